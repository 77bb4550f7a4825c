"""A job, the function that does it, and what becomes of it."""

from __future__ import annotations

import pickle
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from pipenav.errors import PipenavError


class JobControl(Protocol):
    """The side of a place that a running job sees.

    Attributes:
        cores: number of cores that are the job's; its result must not depend on them.
    """

    @property
    def cores(self) -> int: ...

    def report(self, progress: Any) -> None:
        """Tell the driver how far the job is, in plain data; as often as one likes, for most of it is left out."""
        ...

    def should_stop(self) -> bool:
        """Whether the job shall save what it has and raise `JobStopped`; a job that never asks is ended as it is."""
        ...


class JobStopped(Exception):
    """A job has saved what it had, as it was asked to.

    Attributes:
        content: what goes to the driver, where the job has saved nothing that the driver can see.
    """

    def __init__(self, content: bytes = b"") -> None:
        super().__init__(content)
        self.content = content


JobFunction = Callable[[Any, JobControl], bytes]
"""Function of a module, found there by its name in every process. It takes plain data and returns what a store keeps
of the job, which is empty where the job leaves its results in files."""


@dataclass(frozen=True)
class Job:
    """A piece of work that any process on any machine can do: a function and plain data.

    Attributes:
        key: letters, digits, `-`, `.` and `_` that tell the job from every other of its driver; a store has a file of
            this name.
        name: words for a person.
        function: what does it.
        data: what the function works on; it must pickle, and must name no file that only one machine has.
        cores: number of cores that the job can use.
    """

    key: str
    name: str
    function: JobFunction
    data: Any
    cores: int = 1


class Done(NamedTuple):
    """The end of a job that was done, with what its function returned."""

    job: Job
    content: bytes


class Failed(NamedTuple):
    """The end of a job whose function raised: a user's error as it was, or a fault of ours with its traceback."""

    job: Job
    error: Exception


class Lost(NamedTuple):
    """The end of a job whose process or machine ended under it, with words for how."""

    job: Job
    how: str


class Stopped(NamedTuple):
    """The end of a job that was asked to stop, and has saved, with what it sent."""

    job: Job
    content: bytes = b""


class Progressed(NamedTuple):
    """News of a running job: the latest that its function reported."""

    job: Job
    progress: Any


class Kept(NamedTuple):
    """A job that is not done again, for a store has its result."""

    job: Job


Ending = Done | Failed | Lost | Stopped
"""The end of a job at a place."""

Event = Ending | Progressed | Kept
"""Everything that a driver can hear of a job."""


def ending_of(job: Job, control: JobControl) -> Ending:
    """Do a job in this process; an interrupt goes through."""
    try:
        return Done(job, job.function(job.data, control))
    except JobStopped as stopped:
        return Stopped(job, stopped.content)
    except Exception as error:  # the driver raises it: here nobody would see it
        return Failed(job, error)


def portable(error: Exception) -> Exception:
    """An error that can be sent to another process: a user's error as it is, another one as its traceback."""
    if not isinstance(error, PipenavError):
        return RuntimeError("".join(traceback.format_exception(error)))
    try:
        again = pickle.loads(pickle.dumps(error))
    except Exception:  # a plugin's error with parts that cannot travel: its sentence can
        return PipenavError(str(error))
    return error if str(again) == str(error) else PipenavError(str(error))
