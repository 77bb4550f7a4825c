"""Places where jobs run."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from types import TracebackType
from typing import Any, ClassVar, Self

from pipenav.jobs.job import Ending, Job

HearProgress = Callable[[Job, Any], None]
"""Called, while a driver waits, with a job that runs and the latest that it reported."""

ShouldStop = Callable[[], bool]


class Slots(ABC):
    """An open place: a few slots, in each of which one job runs at a time. Leaving its context ends what still runs."""

    @property
    @abstractmethod
    def free(self) -> int:
        """Number of jobs that can be given now."""

    @property
    @abstractmethod
    def busy(self) -> tuple[Job, ...]:
        """Jobs that were given and have not ended."""

    @abstractmethod
    def give(self, job: Job) -> None:
        """Give a job to a free slot."""

    @abstractmethod
    def wait(self, patience: float) -> list[Ending]:
        """The ends of jobs, as soon as there is one, or nothing after a while; hears progress meanwhile.

        Args:
            patience: longest time to wait [s], where jobs run elsewhere.
        """

    @abstractmethod
    def stop(self, job: Job) -> None:
        """Ask a job to save and stop; it ends as `Stopped`, or as `Done` where it was done first."""

    @abstractmethod
    def close(self) -> None:
        """End all that still runs, and everything that belongs to the place."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        self.close()


class Place(ABC):
    """A place where jobs run. Distributions declare their places in the entry-point group `pipenav.places`.

    Its constructor takes the text that a person gave for it, such as the number of processes or an address, and raises
    a `PipenavError` where that makes no sense.

    Attributes:
        name: words for messages, such as `2 processes`.
        shares_disk: whether jobs see the files of the driver's machine by the same paths.
    """

    name: str
    shares_disk: ClassVar[bool] = True

    @abstractmethod
    def __init__(self, given: str) -> None: ...

    @abstractmethod
    def open(self, hear: HearProgress, should_stop: ShouldStop) -> Slots:
        """Open the place.

        Args:
            hear: called with the progress of jobs.
            should_stop: whether all jobs shall save and stop; a place that runs jobs in this process must ask it.

        Raises:
            PipenavError: it cannot be reached.
        """
