# SPDX-License-Identifier: GPL-2.0-only
"""Mutations of the forward channel of scanheads: the codec in xy3, and xy3-spi.

'rate set before the command' is in scanhead.py, with the backchannel.
"""

from . import LEAK, SIM, Driver, Mutation

MUTATIONS = (
    Mutation('parity mask', 'xy3-frame.h',
             '(hweight32(data) & XY3_FRAME32_PARITY)',
             '(hweight32(data) & XY3_FRAME24_PARITY)'),
    Mutation('26-bit code cut to 20', 'xy3-frame.h',
             'data &= XY3_CODE32_MAX;',
             'data &= XY3_CODE24_MAX;'),
    Mutation('swapped lines', 'xy3-lines.c',
             'map->axis_line[map->axes++] = line;',
             'map->axis_line[map->axes++] = line ^ (lines > 1);'),
    Mutation('highest line not most significant', 'xy3-lines.c',
             'map->axis_line[map->axes++] = line;',
             'map->axis_line[map->axes++] = lines - 1 - line;'),
    Mutation('SYNC gap one clock short', 'xy3-lines.c',
             '#define XY3_GAP4\t0x11',
             '#define XY3_GAP4\t0x01'),
    Mutation('SYNC gap one clock short on 8 lines', 'xy3-lines.c',
             '\t} else {\n\t\t*out++ = XY3_GAP8 * high;\n',
             '\t} else {\n\t\t*out++ = 0;\n'),
    Mutation('no gap in front of the first scan', 'xy3-lines.c',
             'xy3_put_gap(map->lines, BIT(map->sync_line), out);',
             'xy3_put_gap(map->lines, 0, out);'),
    Mutation('command on all lines', 'xy3-lines.c',
             '\tframe = xy3_command_word(map, 0) << unused;\n',
             ''),
    Mutation('no frame beside a command', 'xy3-lines.c',
             '\tfor (unsigned int i = 1; i < map->axes; i++)\n'
             '\t\txy3_add_frame(',
             '\tfor (unsigned int i = 1; i < 1; i++)\n'
             '\t\txy3_add_frame('),
    Mutation('bits over a code reach the frame', 'xy3-frame.h',
             'data &= XY3_CODE24_MAX;',
             ''),
    Mutation('a signal on two lines', 'xy3-lines.c',
             '\t\tif (found >= 0)\n\t\t\treturn -EINVAL;\n',
             ''),
    Mutation('SYNC over two lines', 'xy3-lines.c',
             '\t\tif (!xy3_default_signals(lines, true))\n\t\t\treturn -EINVAL;\n',
             ''),
    Mutation('wrong byte order on the wire', 'xy3-lines.c',
             'put_unaligned_be32(bits, out);',
             'put_unaligned_le32(bits, out);'),
    # xy3-spi
    Mutation('lost last scan', 'spi/xy3-stream.c',
             '\txy3_queue(stream)->running = false;\n',
             '\tstruct xy3_queue *queue = xy3_queue(stream);\n'
             '\tif (queue->filling && queue->filling->scans > 1)\n'
             '\t\tqueue->filling->scans--;\n'
             '\tqueue->running = false;\n', SIM),
    Mutation('repeated block', 'spi/xy3-queue.c',
             '\txy3_block_recycle(block, err);\n\txy3_pump(stream, true);',
             '\tif (block->scans == block->scans_max &&\n'
             '\t    xy3_queue(stream)->stat[XY3_SCANS] % 7 == 0) {\n'
             '\t\tlist_add(&block->node, &xy3_queue(stream)->full);\n'
             '\t\txy3_queue(stream)->fulls++;\n'
             '\t} else {\n'
             '\t\txy3_block_recycle(block, err);\n'
             '\t}\n'
             '\txy3_pump(stream, true);', SIM),
    Mutation('command inside a block', 'spi/xy3-queue.c',
             '\tcommands->sending = command;\n',
             '\tif (!list_empty(&xy3_queue(stream)->full) && !stream->map.words) {\n'
             '\t\tblock = list_first_entry(&xy3_queue(stream)->full, struct xy3_block, node);\n'
             '\t\txy3_encode_command_scan(&stream->map, command->code,\n'
             '\t\t\t\t\tblock->data + stream->map.scan_size);\n'
             '\t\txy3_command_end(stream, command, 0);\n'
             '\t\treturn NULL;\n'
             '\t}\n'
             '\tcommands->sending = command;\n', SIM),
    Mutation('underrun not counted', 'spi/xy3-counter.c',
             'queue->stat[XY3_UNDERRUNS]++;',
             ';', SIM),
    Mutation('unbind leak', 'spi/xy3-stream.c',
             '\txy3_blocks_free(&queue->spare);\n',
             '', LEAK),
    # not in the original list
    Mutation('what is repeated is not the last scan', 'spi/xy3-queue.c',
             'memcpy(queue->last, xy3_last_scan(block), stream->map.scan_size);',
             'memcpy(queue->last, block->data, stream->map.scan_size);', SIM),
    Mutation('codes out of the field not counted', 'spi/xy3-buffer.c',
             'clamped += code > max;',
             'clamped = 0;', SIM),
)

DRIVER = Driver(
    sources='drivers/xy3',
    host={'xy3_frame_codec_test': 'xy3_frame', 'xy3_lines_codec_test': 'xy3_lines'},
    kernel=('xy3_frame', 'xy3_lines'),
    sim='forward',
    mutations=MUTATIONS,
)
