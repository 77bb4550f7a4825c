"""Options that choose where the work of a command runs."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

from pipenav.cli.option_groups import OptionGroup
from pipenav.errors import PipenavError, shown

if TYPE_CHECKING:
    from pipenav.jobs import Place

WHERE = "Where it runs"
"""Panel in a command's help."""

MOST_SHARDS = 10_000

JobsOption = Annotated[int | None, typer.Option(min=1, max=1024, help="Processes on this machine.", show_default=False)]
ClusterOption = Annotated[
    str | None,
    typer.Option(metavar="auto|HOST:PORT", help="Ray cluster instead; auto: the one of this machine, or a new one."),
]
ShardOption = Annotated[
    str | None,
    typer.Option(metavar="K/N", help="Only the K-th of N shares, into the same --out; without it the rest, and all."),
]


@dataclass(frozen=True)
class PlaceOptions(OptionGroup):
    """The choice of a place."""

    panel: ClassVar[str] = WHERE
    jobs: JobsOption = None
    cluster: ClusterOption = None

    def place(self, default_jobs: int | None = None) -> Place:
        """The place that was chosen; by default so many processes, or this one.

        Raises:
            PipenavError: two were chosen, or one that is not to be had.
        """
        from pipenav.jobs import chosen_place

        jobs = default_jobs if self.jobs is None and self.cluster is None else self.jobs
        return chosen_place(jobs, self.cluster)


@dataclass(frozen=True)
class ShardedPlaceOptions(PlaceOptions):
    """The choice of a place, and of a share of the work."""

    shard: ShardOption = None

    def shard_numbers(self) -> tuple[int, int] | None:
        """K and N of `--shard K/N`; None for the whole.

        Raises:
            PipenavError: it is something else.
        """
        if self.shard is None:
            return None
        match = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", self.shard)
        if match and 1 <= int(match[1]) <= int(match[2]) <= MOST_SHARDS:
            return int(match[1]), int(match[2])
        raise PipenavError(
            f"--shard {shown(self.shard)} is no share: write it as K/N with K from 1 to N, for example 1/8, and N at "
            f"most {MOST_SHARDS:,}."
        )
