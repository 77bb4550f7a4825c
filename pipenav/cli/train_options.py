"""Options of `pipenav train`: its folders, and several trainings at once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from pipenav.cli.option_groups import OptionGroup
from pipenav.cli.place_options import PlaceOptions
from pipenav.errors import PipenavError, shown

MOST_SEEDS = 1000


@dataclass(frozen=True)
class FolderOptions(OptionGroup):
    """The folders of a training."""

    panel: ClassVar[str] = "Folders"
    out: Annotated[Path | None, typer.Option(help="Training folder; default runs/PRESET.")] = None
    start: Annotated[
        Path | None, typer.Option("--from", help="Training folder whose weights the new training starts from.")
    ] = None
    from_recordings: Annotated[
        str | None,
        typer.Option(
            metavar="DIR[,DIR...]",
            help="Drive folders: before PPO, learn what their successful episodes show.",
        ),
    ] = None
    resume: Annotated[Path | None, typer.Option(help="Training folder to continue.")] = None

    @property
    def recordings(self) -> list[str] | None:
        """Drive folders to learn from; None where none are given."""
        if self.from_recordings is None:
            return None
        return [name.strip() for name in self.from_recordings.split(",")]

    def refuse_two_starts(self) -> None:
        """Refuse recordings beside another training's weights, and names of folders that are empty.

        Raises:
            PipenavError: both are given, or a name is missing.
        """
        if self.recordings is not None and self.start is not None:
            raise PipenavError("--from and --from-recordings are two beginnings of one training: give one of them.")
        if self.recordings is not None and not all(self.recordings):
            raise PipenavError(
                f"--from-recordings names folders with commas between them, given {shown(self.from_recordings)}: "
                "for example runs/drive-1,runs/drive-2."
            )


@dataclass(frozen=True)
class SeedsOptions(PlaceOptions):
    """Several trainings that differ in their seed, and where they run."""

    panel: ClassVar[str] = "Several seeds"
    seeds: Annotated[
        int | None,
        typer.Option(
            min=1, max=MOST_SEEDS, help="Train so many seeds, from --seed on, into OUT/seed-K.", show_default=False
        ),
    ] = None

    def refuse_place_alone(self) -> None:
        """Refuse a place for a single training.

        Raises:
            PipenavError: --jobs or --cluster is given without --seeds.
        """
        if self.seeds is None and (self.jobs is not None or self.cluster is not None):
            raise PipenavError("--jobs and --cluster run trainings side by side: give the number of them by --seeds.")
