"""Threads of torch beside an environment.

Torch divides each small operation of a policy among one thread per core, and these wait for each other in busy loops.
Where other processes have the cores, a training of one environment takes ten times as long as with one thread, whatever
the environment is: `Pendulum-v1` as much as ours. An environment itself steps one robot with one thread.
"""

from __future__ import annotations

import os
import sys

CHOSEN_BY = ("OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables by which a person chooses the number of threads."""

_done = False


def bound_torch_threads() -> None:
    """Give torch one thread, once in a process and only if it is imported, unless a variable of `CHOSEN_BY` is set.

    Whoever wants more threads sets such a variable, or calls `torch.set_num_threads` after the first reset.
    """
    global _done
    torch = sys.modules.get("torch")
    if _done or torch is None:
        return
    _done = True
    if not any(os.environ.get(name) for name in CHOSEN_BY):
        torch.set_num_threads(1)
