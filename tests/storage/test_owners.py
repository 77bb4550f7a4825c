"""Owners of what was left behind: running, ended, ended without anybody's notice, or another process by now."""

from __future__ import annotations

import os
import subprocess
import sys
import time

from helpers.waiting import wait_until

from pipenav.storage.owners import CLOCKS_APART_S, owner_runs


def test_a_process_runs_until_it_ends_also_where_nobody_asks_for_its_exit_code() -> None:
    waiting = [sys.executable, "-c", "input()"]
    with subprocess.Popen(waiting, stdin=subprocess.PIPE) as process:
        now = time.time()
        assert owner_runs(process.pid, now)
        process.stdin.close()  # type: ignore[union-attr]
        wait_until(lambda: not owner_runs(process.pid, now), "the process has ended")
        os.kill(process.pid, 0)  # its number is still taken: nobody has waited for it
    assert not owner_runs(process.pid, now)


def test_a_process_owns_nothing_older_than_itself() -> None:
    assert owner_runs(os.getpid(), time.time())
    assert not owner_runs(os.getpid(), time.time() - 3600.0 * 24 * 365 - CLOCKS_APART_S)
