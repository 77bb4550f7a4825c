"""The processes that simulate a backend's robots: Bullet keeps Python's lock, so that threads would gain nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from itertools import pairwise
from multiprocessing import Pipe as pipe_ends
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from pipenav.errors import PipenavError
from pipenav.robots import RobotSpec
from pipenav_pybullet.world import WORLD_SIZE, Setting


class Crew:
    """Processes that share n robots, each the next few of them. See `worker` for what they do."""

    def __init__(self, robot: RobotSpec, n: int, setting: Setting, processes: int) -> None:
        worlds = -(-n // WORLD_SIZE)
        workers = min(processes or len(os.sched_getaffinity(0)), worlds)
        shared = np.linspace(0, worlds, workers + 1).round().astype(int)  # whole worlds: results, to the last bit,
        self.bounds: list[int] = np.minimum(shared * WORLD_SIZE, n).tolist()  # depend on who shares one
        self._processes: list[subprocess.Popen[bytes]] = []
        self._ends: list[Connection[Any, Any]] = []
        for _ in range(workers):
            self._start()
        self.ask("open", [(robot, last - first, setting) for first, last in pairwise(self.bounds)])

    def _start(self) -> None:
        ours, theirs = pipe_ends()
        command = [sys.executable, "-m", "pipenav_pybullet.worker", str(theirs.fileno())]
        quiet = subprocess.DEVNULL  # Bullet writes to the terminal on its own account
        process = subprocess.Popen(command, pass_fds=[theirs.fileno()], stdin=quiet, stdout=quiet, stderr=quiet)
        theirs.close()
        self._ends.append(ours)
        self._processes.append(process)

    def ask(self, what: str, orders: Sequence[tuple[Any, ...] | None]) -> list[Any]:
        """Have every process do the same with arguments of its own, all at the same time; None leaves one out.

        Raises:
            PipenavError: a process is gone.
        """
        asked = [(end, order) for end, order in zip(self._ends, orders, strict=True) if order is not None]
        try:
            for end, order in asked:
                end.send((what, order))
            answers = [end.recv() for end, _ in asked]
        except (EOFError, ConnectionError) as error:
            raise PipenavError(
                "a process of the PyBullet backend has ended: check the memory that is left, or lower the setting "
                "processes."
            ) from error
        for answer in answers:
            if isinstance(answer, Exception):
                raise answer
        return answers

    def close(self) -> None:
        """A process leaves when its pipe closes."""
        for end in self._ends:
            end.close()
        for process in self._processes:
            process.wait()
        self._processes, self._ends = [], []
