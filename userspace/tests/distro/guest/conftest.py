# SPDX-License-Identifier: GPL-2.0-only
"""What pytest has to know before it imports the guests' tests."""

import pytest

pytest.register_assert_rewrite('access', 'harness', 'heads', 'typed', 'virtual')
