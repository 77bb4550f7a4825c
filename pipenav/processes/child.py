"""Program of a child process: `python -P -m pipenav.processes.child PARENT MODULE ARGUMENTS...`.

It calls `main(ARGUMENTS)` of a module, with the signals ignored that are the parent's business. PARENT is the number of
the process with which it ends, 0 for none.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from importlib import import_module

from pipenav.processes.children import PARENTS_SIGNALS
from pipenav.processes.matplotlibrc import ignore_local_matplotlibrc
from pipenav.processes.outer_settings import leave_screen_settings
from pipenav.processes.safe_path import leave_current_folder

PR_SET_PDEATHSIG = 1


def end_with(parent: int) -> None:
    """Have the kernel end this process as soon as its parent ends, where the kernel can: on Linux."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:  # it ended before
        os._exit(1)


def main() -> None:
    for number in PARENTS_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, PARENTS_SIGNALS)
    parent, module, *arguments = sys.argv[1:]
    if int(parent):
        end_with(int(parent))
    leave_current_folder()
    ignore_local_matplotlibrc()
    leave_screen_settings()
    sys.argv = [module, *arguments]
    import_module(module).main(arguments)


if __name__ == "__main__":
    main()
