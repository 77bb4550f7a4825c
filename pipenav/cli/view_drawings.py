"""Drawings of `pipenav view`: motions in a plane, from above, or one motion in space."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path

from pipenav.errors import PipenavError
from pipenav.motions.trajectory import Trajectory
from pipenav.motions.trajectory_file import write_trajectory
from pipenav.recording.film import Progress, write_film
from pipenav.recording.posed_motion import PosedMotion, posed_in_space, posed_trajectory
from pipenav.recording.record_rolling import SpaceRecording
from pipenav.recording.rolling_film import draw_in_space

TABLE = ".csv"


class Drawing(ABC):
    """Recorded motions that can be told in sentences and written as files."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the first motion's pipe, for a file whose name nobody gave."""

    @property
    @abstractmethod
    def sentences(self) -> list[str]:
        """Pipe, stage and end of each motion, a line each."""

    @abstractmethod
    def posed(self) -> list[PosedMotion]:
        """The motions as poses in space."""

    @abstractmethod
    def write(self, path: Path, progress: Progress) -> None:
        """Write a file of the kind that the suffix names."""


class PlaneDrawing(Drawing):
    """Motions in a plane, one after another."""

    def __init__(self, motions: Sequence[Trajectory]) -> None:
        self._motions = motions

    @property
    def name(self) -> str:
        return self._motions[0].header.pipe.name

    @property
    def sentences(self) -> list[str]:
        return [_sentence(motion) for motion in self._motions]

    def posed(self) -> list[PosedMotion]:
        return [posed_trajectory(motion) for motion in self._motions]

    def write(self, path: Path, progress: Progress) -> None:
        if path.suffix.lower() != TABLE:
            write_film(path, self._motions, progress)
        elif len(self._motions) > 1:
            raise PipenavError(f"{path}: a trajectory file holds one motion: name one pipe.")
        else:
            write_trajectory(path, self._motions[0])


class SpaceDrawing(Drawing):
    """A motion in a route that leaves the plane."""

    def __init__(self, recording: SpaceRecording) -> None:
        self._recording = recording

    @property
    def name(self) -> str:
        return self._recording.route.name

    @property
    def sentences(self) -> list[str]:
        recording = self._recording
        ended = f"{recording.outcome} after {recording.time[-1]:.1f} s"
        force = f"largest contact force {recording.contact_force.max():.1f} N"
        return [f"{recording.route.label}, traverse: {ended}, {force}"]

    def posed(self) -> list[PosedMotion]:
        return [posed_in_space(self._recording)]

    def write(self, path: Path, progress: Progress) -> None:
        draw_in_space(path, self._recording, progress)


def _sentence(motion: Trajectory) -> str:
    header, seconds = motion.header, motion.time[-1]
    force = motion.contact_force
    touched = "" if force is None else f", largest contact force {force.max():.1f} N"
    return f"{header.pipe.label}, {header.stage}: {header.outcome or 'not run'} after {seconds:.1f} s{touched}"
