"""Ray as a place: every core of a cluster is a slot."""

from __future__ import annotations

import contextlib
import pickle
import time
from typing import Any, NamedTuple

import ray
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

from pipenav.jobs import (
    Done,
    Ending,
    Failed,
    HearProgress,
    Job,
    JobFunction,
    Lost,
    Place,
    ShouldStop,
    Slots,
    Stopped,
    ending_of,
    portable,
)
from pipenav_ray.cluster import Address, connected
from pipenav_ray.relay import ASK_S, RayControl, Relay

COUNT_S = 1.0
"""Time between two counts of the cluster's cores [s]: nodes come and go."""


class RayPlace(Place):
    """A Ray cluster.

    Args:
        given: `auto` or HOST:PORT.

    Raises:
        PipenavError: that is no address.
    """

    shares_disk = False

    def __init__(self, given: str) -> None:
        self._address = Address.parsed(given)
        self.name = f"the Ray cluster {given}"

    def open(self, hear: HearProgress, should_stop: ShouldStop) -> Slots:  # noqa: ARG002  # the driver asks it
        stack = contextlib.ExitStack()
        stack.enter_context(connected(self._address))
        return _RaySlots(hear, stack)


class _RaySlots(Slots):
    """Tasks of Ray, none of which Ray itself tries again: the driver does, as at every place."""

    def __init__(self, hear: HearProgress, stack: contextlib.ExitStack) -> None:
        self._hear, self._stack = hear, stack
        self._busy: dict[Any, Job] = {}
        self._cores, self._counted = 0, -COUNT_S
        here = NodeAffinitySchedulingStrategy(ray.get_runtime_context().get_node_id(), soft=False)
        self._relay = ray.remote(Relay).options(num_cpus=0, scheduling_strategy=here).remote()
        self._news: Any = None
        self._asked = 0.0
        self._do = ray.remote(_do)

    @property
    def free(self) -> int:
        if time.monotonic() - self._counted >= COUNT_S:
            self._counted = time.monotonic()
            self._cores = int(ray.cluster_resources().get("CPU", 0))
        return max(0, self._cores - sum(job.cores for job in self._busy.values()))

    @property
    def busy(self) -> tuple[Job, ...]:
        return tuple(self._busy.values())

    def give(self, job: Job) -> None:
        order = pickle.dumps((job.function, job.data))
        task = self._do.options(num_cpus=job.cores, max_retries=0, name=job.key)
        self._busy[task.remote(order, job.key, job.cores, self._relay)] = job

    def wait(self, patience: float) -> list[Ending]:
        self._hear_news()
        if not self._busy:
            time.sleep(patience)
            return []
        first, _ = ray.wait(list(self._busy), timeout=patience)
        if not first:
            return []
        ended, _ = ray.wait(list(self._busy), num_returns=len(self._busy), timeout=0)
        return [_ending(self._busy.pop(reference), reference) for reference in ended]

    def _hear_news(self) -> None:
        """Hear what jobs have reported, without waiting for it."""
        if self._news is not None and ray.wait([self._news], timeout=0)[0]:
            news, self._news = ray.get(self._news), None
            for job in self.busy:
                if job.key in news:
                    self._hear(job, news[job.key])
        if self._news is None and time.monotonic() - self._asked >= ASK_S:
            self._asked = time.monotonic()
            self._news = self._relay.take.remote()

    def stop(self, job: Job) -> None:
        self._relay.stop.remote(job.key)

    def close(self) -> None:
        for reference in self._busy:
            with contextlib.suppress(ray.exceptions.RayError):
                ray.cancel(reference, force=True)
        self._busy.clear()
        with contextlib.suppress(ray.exceptions.RayError):
            ray.kill(self._relay)
        self._stack.close()


class _Saved(NamedTuple):
    """The answer of a job that was stopped, with what it sends."""

    content: bytes


def _do(order: bytes, key: str, cores: int, relay: Any) -> bytes | Exception | _Saved:
    """Do a job in a worker of Ray: what its function returned, or what it raised, or how it was stopped."""
    try:
        function: JobFunction
        function, data = pickle.loads(order)
    except Exception as error:  # its function or its data is not to be found here
        return portable(error)
    ending = ending_of(Job(key, key, function, data), RayControl(key, cores, relay))
    if isinstance(ending, Failed):
        return portable(ending.error)
    assert not isinstance(ending, Lost)  # a job that is done here cannot be
    return ending.content if isinstance(ending, Done) else _Saved(ending.content)


def _ending(job: Job, reference: Any) -> Ending:
    """The end of a job, from the reference to what its task returned."""
    try:
        answer = ray.get(reference)
    except ray.exceptions.RayError as error:
        how = " ".join(str(error).split()).partition(". ")[0]
        return Lost(job, f"{type(error).__name__}: {how[:200]}")
    if isinstance(answer, Exception):
        return Failed(job, answer)
    return Stopped(job, answer.content) if isinstance(answer, _Saved) else Done(job, answer)
