"""Processes that simulate a backend's robots: Bullet keeps Python's lock, so that threads would gain nothing."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from pipenav.backends import Worker, WorkerEnded, start_worker
from pipenav.errors import PipenavError
from pipenav.robots import RobotSpec
from pipenav_pybullet.world import WORLD_SIZE, Setting

PATIENCE_S = 1.0
"""Time in which processes end that have nothing more to do [s]; an order that takes longer is cut short."""


class Crew:
    """Processes that share n robots in order; `pipenav_pybullet.worker` is the program of each.

    Args:
        robot: the robot.
        n: number of robots.
        setting: settings of every world.
        processes: largest number of processes; 0 for the number of cores.

    Attributes:
        bounds: number of the first robot of each process, then n.
    """

    def __init__(self, robot: RobotSpec, n: int, setting: Setting, processes: int) -> None:
        worlds = -(-n // WORLD_SIZE)
        workers = min(processes or len(os.sched_getaffinity(0)), worlds)
        # Whole worlds go to each process: the last bits of results depend on which robots share a world.
        shared = np.linspace(0, worlds, workers + 1).round().astype(int)
        self.bounds: list[int] = np.minimum(shared * WORLD_SIZE, n).tolist()
        quiet = subprocess.DEVNULL  # Bullet writes to the terminal by itself
        self._workers: list[Worker] = []
        for _ in range(workers):
            self._workers.append(start_worker("pipenav_pybullet.worker", stdin=quiet, stdout=quiet, stderr=quiet))
        self.ask("open", [(robot, last - first, setting) for first, last in pairwise(self.bounds)])

    def ask(self, what: str, orders: Sequence[tuple[Any, ...] | None]) -> list[Any]:
        """Send every process its order, and collect the answers when all have worked at the same time.

        Args:
            what: method of `pipenav_pybullet.worker.Share` that every process calls.
            orders: arguments for each process; None leaves a process out.

        Raises:
            PipenavError: a process has ended.
        """
        asked = [(worker, order) for worker, order in zip(self._workers, orders, strict=True) if order is not None]
        try:
            for worker, order in asked:
                worker.send((what, order))
            answers = [worker.receive() for worker, _ in asked]
        except WorkerEnded as error:
            raise PipenavError(
                "a process of the PyBullet backend has ended: check the memory that is left, or lower the setting "
                "processes."
            ) from error
        for answer in answers:
            if isinstance(answer, Exception):
                raise answer
        return answers

    def close(self) -> None:
        """Close the pipes, at which the processes end, and wait for them."""
        for worker in self._workers:
            worker.end.close()
        until = time.monotonic() + PATIENCE_S
        for worker in self._workers:
            worker.close(max(0.0, until - time.monotonic()))
        self._workers = []
