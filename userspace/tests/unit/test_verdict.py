# SPDX-License-Identifier: GPL-2.0-only
"""The verdict on artificial results, which a kernel does not produce on purpose."""
import contextlib
import io
import tempfile
from case import Case, row
from pathlib import Path

import verdict

GOOD = '''KTAP version 1
1..1
    KTAP version 1
    # Subtest: some
    # module: some_test
    1..2
    ok 1 first
        KTAP version 1
        # Subtest: second
        ok 1 row one
        ok 2 row two
    # second: pass:2 fail:0 skip:0 total:2
    ok 2 second
# some: pass:2 fail:0 skip:0 total:2
ok 1 some
'''

GOOD_CONSOLE = '''Checking that ptrace can change system call numbers...OK
[    0.000000] Linux version 6.12.0
[    1.000000] KernelAddressSanitizer initialized
init: 6.12.0 is up after 1.0 s
a test says BUG: this is not the kernel's word
'''


class TestVerdict(Case):
    def set_up(self):
        folder = tempfile.TemporaryDirectory()
        self.add_cleanup(folder.cleanup)
        self.out = Path(folder.name)
        self.leave('end', 'ok\n')
        self.leave('status', '0\n')
        self.leave('console.log', GOOD_CONSOLE)
        self.leave('tainted', str(1 << 12 | 1 << 18) + '\n')
        self.leave('lockdep', ' debug_locks:                             1\n')
        self.leave('kmemleak', '')
        self.leave('ktap/some.ktap', GOOD)

    def leave(self, name, text):
        path = self.out / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)

    def judge(self, least=2, wanted=None, plain=False):
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            counts = verdict.judge(self.out, 'run', wanted or {'some': least}, True, plain=plain)
        return counts, said.getvalue()

    def assert_refused(self, why, **arguments):
        (_, failed), said = self.judge(**arguments)
        assert failed > 0, said
        assert why in said

    def test_good_run_is_accepted(self):
        counts, said = self.judge()
        assert counts == (3, 0), said

    def test_plain_kernel(self):
        """It has neither lockdep nor kmemleak; all other checks apply."""
        for name in ('lockdep', 'kmemleak'):
            (self.out / name).unlink()
        counts, said = self.judge(plain=True)
        assert counts == (3, 0), said
        self.leave('tainted', str(1 << 9) + '\n')
        self.assert_refused('taint', plain=True)
        self.leave('tainted', '0\n')
        self.leave('console.log', GOOD_CONSOLE + '[    9.000000] Oops: 0002\n')
        self.assert_refused('console', plain=True)

    def test_too_few_cases(self):
        self.assert_refused('2 cases, at least 3 wanted', least=3)

    def test_missing_suite(self):
        self.assert_refused('suite other did not run', wanted={'some': 1, 'other': 1})

    def test_suite_nobody_asked_for(self):
        self.leave('ktap/other.ktap', GOOD.replace('some', 'other'))
        self.assert_refused('suite other was not asked for')

    def test_no_plan_line(self):
        self.leave('ktap/some.ktap', GOOD.replace('    1..2\n', ''))
        self.assert_refused('no plan line')

    def test_plan_not_kept(self):
        self.leave('ktap/some.ktap', GOOD.replace('    1..2\n', '    1..3\n'))
        self.assert_refused('3 planned, 2 there')

    def test_cut_off(self):
        for lines in range(len(GOOD.splitlines())):
            with row(lines=lines):
                self.leave('ktap/some.ktap', '\n'.join(GOOD.splitlines()[:lines]))
                (_, failed), said = self.judge()
                assert failed > 0, said

    def test_case_twice(self):
        self.leave('ktap/some.ktap', GOOD.replace('    ok 1 first\n', '    ok 1 first\n' * 2))
        self.assert_refused('2 planned, 3 there')

    def test_failed_row_under_a_good_case(self):
        self.leave('ktap/some.ktap', GOOD.replace('        ok 2', '        not ok 2'))
        self.assert_refused('not ok some.second: ok, but not its rows row two')

    def test_skipped_row(self):
        self.leave('ktap/some.ktap', GOOD.replace('row two', 'row two # SKIP no reason'))
        self.assert_refused('not ok some.second')

    def test_case_without_rows(self):
        self.leave('ktap/some.ktap', ''.join(
            line for line in GOOD.splitlines(True) if 'row' not in line))
        self.assert_refused('some.second: empty')

    def test_suite_failed_but_no_case(self):
        self.leave('ktap/some.ktap', GOOD.replace('\nok 1 some', '\nnot ok 1 some'))
        self.assert_refused('suite some failed, but none of its cases')

    def test_empty_results(self):
        self.leave('ktap/some.ktap', '')
        self.assert_refused('suite some: the text is cut off')

    def test_kernel_did_not_end(self):
        self.leave('end', 'timeout\n')
        self.assert_refused('did not come to its end: timeout')

    def test_status(self):
        self.leave('status', '1\n')
        self.assert_refused("the command's status is 1")

    def test_what_a_run_did_not_record(self):
        for name in ('end', 'status', 'console.log', 'tainted', 'lockdep', 'kmemleak'):
            with row(name=name):
                self.set_up()
                (self.out / name).unlink()
                (_, failed), said = self.judge()
                assert failed > 0, said

    def test_console_reports(self):
        for text in ('BUG: KASAN: slab-use-after-free in f+0x1/0x2',
                     'WARNING: possible circular locking dependency detected',
                     'BUG: sleeping function called from invalid context at f.c:1',
                     'UBSAN: array-index-out-of-bounds in f.c:1:2',
                     'WARNING: CPU: 0 PID: 1 at f.c:1 f+0x1/0x2',
                     'INFO: task xhc:12 blocked for more than 120 seconds.',
                     'INFO: trying to register non-static key.',
                     'ODEBUG: free active (active state 0) object: 0 object type: timer_list',
                     'refcount_t: underflow; use-after-free.',
                     'rcu: INFO: rcu_sched self-detected stall on CPU',
                     'sysfs: cannot create duplicate filename \'/class/x\'',
                     'Kernel panic - not syncing: Segfault'):
            with row(text=text):
                self.leave('console.log', GOOD_CONSOLE + f'[   12.345678] {text}\r\n')
                self.assert_refused(f'console: {text}')

    def test_taint(self):
        self.leave('tainted', str(1 << 12 | 1 << 18 | 1 << 9) + '\n')
        self.assert_refused('unexpected bits 0x200')

    def test_lockdep_off(self):
        self.leave('lockdep', ' debug_locks:                             0\n')
        self.assert_refused('lockdep has switched itself off')

    def test_leak(self):
        self.leave('kmemleak', 'unreferenced object 0x61d0ab40 (size 256):\n  comm "x"\n')
        self.assert_refused('kmemleak: 1 unreferenced object')
