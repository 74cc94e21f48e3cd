# SPDX-License-Identifier: GPL-2.0-only
"""Signs of trouble in a kernel log. The only list, for the test kernel and for Debian's kernels.

Each entry has a line that it must match, and that no other entry may hide;
unit/test_kernel_trouble checks this.
"""

import re

# (regular expression, a line of a kernel log that it matches)
TROUBLE = (
    (r'\bBUG\b', 'BUG: kernel NULL pointer dereference, address: 0000000000000008'),
    (r'\bWARNING: ', 'WARNING: CPU: 0 PID: 1 at drivers/tty/tty_io.c:1 tty_open+0x1/0x2'),
    (r'\bINFO: (?!.*\bselftest\b)', 'INFO: task kworker/0:1:9 blocked for more than 120 seconds.'),
    (r'\b(KASAN|KFENCE|KCSAN|UBSAN): ', 'UBSAN: shift-out-of-bounds in xy3-frame.c:1:2'),
    (r'ODEBUG: ', 'ODEBUG: free active (active state 0) object: timer_list'),
    (r'cut here', '------------[ cut here ]------------'),
    (r'Call Trace:', 'Call Trace:'),
    (r'\*\*\* DEADLOCK \*\*\*', ' *** DEADLOCK ***'),
    (r'turning off the locking correctness validator',
     'turning off the locking correctness validator.'),
    (r'DEBUG_LOCKS_WARN_ON', 'DEBUG_LOCKS_WARN_ON(lock->magic != lock)'),
    (r'bad unlock balance', '[ bad unlock balance detected! ]'),
    (r'lock held when returning', 'lock held when returning to user space!'),
    (r'refcount_t: ', 'refcount_t: underflow; use-after-free.'),
    (r'list_(add|del) corruption', 'list_del corruption. prev->next should be x, but was y'),
    (r'cannot create duplicate filename',
     "sysfs: cannot create duplicate filename '/class/xy3/xy3-0'"),
    (r'general protection', 'general protection fault, probably for non-canonical address'),
    (r'segfault at', 'xy3ctl[7]: segfault at 8 ip 0000 sp 0000 error 4 in libc.so.6'),
    (r'\bOops\b', 'Oops: 0000 [#1] PREEMPT SMP NOPTI'),
    (r'Kernel panic', 'Kernel panic - not syncing: Attempted to kill init!'),
    (r'stack-protector', 'stack-protector: Kernel stack is corrupted in: xy3_open'),
    # ... but the HID core logs it for a truncated report descriptor, which a test uses
    (r'[Uu]nbalanced (?!(collection|delimiter) at end of report)',
     'Unbalanced enable for IRQ 4'),
    (r'self-detected stall', 'rcu: rcu_preempt self-detected stall on CPU'),
    (r'soft lockup', 'watchdog: soft lockup - CPU#0 stuck for 22s!'),
    (r'hung_task', 'hung_task: blocked tasks'),
    (r'kobject.*(failed|tried to init)', 'kobject_add_internal failed for xy3-0 (error: -2)'),
    (r'Redzone|Poison overwritten', 'Right Redzone overwritten'),
    (r'double free|use-after-free', 'slab: double free detected in kmalloc-64'),
    (r'unregister_netdevice: waiting',
     'unregister_netdevice: waiting for lo to become free. Usage count = 1'),
    (r'enqueued on deprecated workqueue',
     'workqueue: work func xy3_tty_rate_work [xy3] enqueued on deprecated workqueue. '
     'Use system_{percpu|dfl}_wq instead.'),
)
_ANY = re.compile('|'.join(pattern for pattern, _ in TROUBLE))

# Only lines with the time stamp of the kernel count, not the output of programs.
_KERNEL_LINE = re.compile(r'^\[ *\d+\.\d+\] (.*)')


def trouble(log, allowed=lambda text: False):
    """-> the lines of a kernel log, without time stamps, that are signs of trouble; each once"""
    found = {}
    for line in log.splitlines():
        match = _KERNEL_LINE.match(line.rstrip('\r'))
        text = match.group(1) if match else ''
        if _ANY.search(text) and not allowed(text):
            found[text] = True
    return list(found)
