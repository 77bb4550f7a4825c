"""Functions of jobs that only tests have, and a place whose workers find them."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pipenav.errors import OutOfRange
from pipenav.jobs import Event, Job, JobControl, JobStopped


def doubled(data: int, control: JobControl) -> bytes:
    """Twice a number, as text."""
    control.report(data)
    return str(2 * data).encode()


def refused(data: Any, _control: JobControl) -> bytes:
    """A user's error."""
    raise OutOfRange("angle", float(data), 10, 20, "deg")


def faulty(_data: Any, _control: JobControl) -> bytes:
    """A fault of ours."""
    raise ZeroDivisionError("by nothing")


def killed(data: Any, _control: JobControl) -> bytes:
    """The end of the process itself, by a signal."""
    os.kill(os.getpid(), int(data))
    raise AssertionError("unreachable")


def killed_at_first(data: str, _control: JobControl) -> bytes:
    """The end of the process, the first two times; a folder counts them."""
    tries = Path(data)
    number = len(list(tries.iterdir()))
    (tries / str(number)).touch()
    if number < 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return b"at last"


def patient(data: str, control: JobControl) -> bytes:
    """Wait for the order to stop; a file says that it was heard, and another one that the job runs."""
    Path(data).with_suffix(".runs").touch()
    while not control.should_stop():
        control.report("waiting")
        time.sleep(0.01)
    Path(data).touch()
    raise JobStopped


def deaf(data: str, _control: JobControl) -> bytes:
    """Never ask whether to stop."""
    Path(data).with_suffix(".runs").touch()
    time.sleep(60.0)
    return b""


def cores(_data: Any, control: JobControl) -> bytes:
    """The number of cores that the job was given."""
    return str(control.cores).encode()


class Heard:
    """Everything that a driver heard of its jobs."""

    def __init__(self) -> None:
        self.events: list[Event] = []

    def __call__(self, event: Event) -> None:
        self.events.append(event)

    def of(self, kind: type) -> list[Any]:
        """The events of one kind."""
        return [event for event in self.events if isinstance(event, kind)]


def numbers(count: int) -> Iterator[Job]:
    """Jobs that double the numbers from 0."""
    return (Job(f"number-{i}", f"number {i}", doubled, i) for i in range(count))


def one(function: Any, data: Any = None, key: str = "one") -> Sequence[Job]:
    """A single job."""
    return [Job(key, f"the job {key}", function, data)]
