"""The relay of a driver's jobs on Ray: news of running jobs on their way to it, orders to stop on their way back.

It is an actor on the driver's own node, so that it lives as long as the driver has anything to hear.
"""

from __future__ import annotations

import contextlib
import time
from typing import Any

import ray

ASK_S = 0.5
"""Time between two messages of a job to the relay [s]."""


class Relay:
    """The latest news of each job by its key, and the jobs that shall stop."""

    def __init__(self) -> None:
        self._news: dict[str, Any] = {}
        self._stopping: set[str] = set()

    def tell(self, key: str, progress: Any) -> bool:
        """Take news of a job, where there are any; returns whether it shall stop."""
        if progress is not None:
            self._news[key] = progress
        return key in self._stopping

    def take(self) -> dict[str, Any]:
        """The news since the last time."""
        news, self._news = self._news, {}
        return news

    def stop(self, key: str) -> None:
        """Note that a job shall stop."""
        self._stopping.add(key)


class RayControl:
    """The side of Ray that a running job sees, see `pipenav.jobs.JobControl`; it never waits for an answer.

    Args:
        key: key of the job.
        cores: number of cores that are the job's.
        relay: handle of the driver's `Relay`.
    """

    def __init__(self, key: str, cores: int, relay: Any) -> None:
        self.cores = cores
        self._key, self._relay = key, relay
        self._latest: Any = None
        self._asked: Any = None
        self._last = 0.0
        self._stop = False

    def report(self, progress: Any) -> None:
        """Send how far the job is, now and then."""
        self._latest = progress
        self._ask_if_due()

    def should_stop(self) -> bool:
        """Whether the driver has asked to stop, as far as is known here."""
        self._ask_if_due()
        if self._asked is not None and ray.wait([self._asked], timeout=0)[0]:
            with contextlib.suppress(ray.exceptions.RayError):  # the driver is gone, and Ray ends this process soon
                self._stop = self._stop or ray.get(self._asked)
            self._asked = None
        return self._stop

    def _ask_if_due(self) -> None:
        """Send the latest news, and ask with them whether to stop, unless that was done just now."""
        if time.monotonic() - self._last >= ASK_S:
            self._last = time.monotonic()
            self._asked = self._relay.tell.remote(self._key, self._latest)
            self._latest = None
