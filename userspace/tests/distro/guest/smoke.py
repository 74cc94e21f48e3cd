# SPDX-License-Identifier: GPL-2.0-only
"""The little that shows that the drivers work on a kernel: for those that need no more."""

import display
import events
import forward
import lifecycle
import scanhead
import scanhead_going

NAMES = ('line_discipline_loads_the_module_uart', 'line_discipline_loads_the_module_stick',
         'cat_gives_what_was_sent_stick', 'sensors_prints_temperatures_uart',
         'driver_comes_by_modalias', 'iio_writedev_over_8_lines_line', 'stty_moves_head_and_uart',
         'modules_go_and_leave_nothing')

TESTS = [events.autoload_by_modalias, events.every_key, display.every_attribute_reaches_the_lcd,
         lifecycle.keys_go_up_when_the_module_goes]
TESTS += [test for test in scanhead.TESTS if test.__name__ in NAMES]
TESTS += [scanhead_going.unplugged_while_it_streams, scanhead_going.module_stays_while_it_is_used]
TESTS += [test for test in forward.TESTS if test.__name__ in NAMES]
