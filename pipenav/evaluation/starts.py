"""Sets of starts: pipes, and poses in which robots are stuck in them, as JSON files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, ValidationError

from pipenav.arrays import Table
from pipenav.errors import ConfigError, PipenavError, UnknownName
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.storage import shipped
from pipenav.storage.text_files import checked_json, read_text
from pipenav.tasks.traverse.episode import TraverseEpisodes

MAX_FILE = 16 << 20
"""Largest file that is read [bytes]: that of 50,000 starts."""

_Number = Annotated[float, Field(ge=-1000, le=1000)]
_Numbers = Annotated[tuple[_Number, ...], Field(strict=False, min_length=1, max_length=100)]


class Start(Table):
    """A pose in which an episode begins.

    Attributes:
        stuck: how the robot got stuck in it, the name of an outcome.
        q: base in the pipe's frame, then the joints, (coordinates,) [m, rad].
        press: distances of the joints' set-points from the joints, (joints,) [rad].
    """

    stuck: Literal["jam", "slip", "limit", "fold"]
    q: _Numbers
    press: _Numbers

    def put(self, episode: TraverseEpisodes) -> TraverseEpisodes:
        """The episode, k = 1, with this start."""
        return episode._replace(q=np.array([self.q]), base=np.zeros(1), press=np.array([self.press]))


class PipeStarts(Table):
    """Starts in one pipe.

    Attributes:
        pipe: the pipe, as a person names it.
        starts: its starts.
    """

    pipe: str
    starts: tuple[Start, ...] = Field(strict=False, min_length=1)


class StartSet(Table):
    """Starts in several pipes, as many in each.

    Attributes:
        schema_version: version of the format.
        robot: shipped robot that the poses are of.
        drawn: how they were drawn.
        pipes: the pipes with their starts.
    """

    schema_version: Literal[1] = Field(alias="schema")
    robot: str
    drawn: str
    pipes: tuple[PipeStarts, ...] = Field(strict=False, min_length=1)

    @property
    def each(self) -> int:
        """Number of starts in each pipe."""
        return len(self.pipes[0].starts)

    def to_json(self) -> str:
        """The set as JSON, a line for each pipe and each start."""
        text = self.model_dump_json(by_alias=True)
        return text.replace('{"pipe"', '\n{"pipe"').replace('{"stuck"', '\n {"stuck"') + "\n"

    def check_robot(self, robot: RobotSpec) -> None:
        """Refuse a robot that the poses do not fit.

        Raises:
            PipenavError: its links differ from those of the robot that they are of.
        """
        own = load_robot(self.robot)
        if own.coordinates != robot.coordinates or not np.array_equal(own.lengths, robot.lengths):
            raise PipenavError(
                f"the starts are poses of the robot {self.robot}, given {robot.name}, whose links differ: choose a "
                f"policy of {self.robot}."
            )


def start_set_names() -> list[str]:
    """Names of the shipped sets of starts."""
    return sorted(path.stem for path in shipped.starts_dir().glob("*.json"))


def load_starts(text: str) -> StartSet:
    """Load a shipped set of starts by its name, or one from a JSON file.

    Raises:
        UnknownName: the text is neither a shipped name nor a JSON file.
        ConfigError: the file is something else, or has not as many starts in each pipe or not all coordinates.
        FileProblem: the file cannot be read.
    """
    path = Path(text)
    if text in start_set_names():
        path = shipped.starts_dir() / f"{text}.json"
    elif path.suffix != ".json":
        raise UnknownName("set of starts", text, [*start_set_names(), "FILE.json"])
    try:
        found = StartSet.model_validate_json(checked_json(read_text(path, MAX_FILE), str(path)))
    except ValidationError as error:
        raise ConfigError.from_validation(text, error, StartSet.model_fields) from error
    if any(len(pipe.starts) != found.each for pipe in found.pipes):
        raise ConfigError(f"{text} has more starts in some pipes than in others: give as many in each.")
    robot = load_robot(found.robot)
    sizes = {(len(start.q), len(start.press)) for pipe in found.pipes for start in pipe.starts}
    if sizes != {(robot.coordinates, len(robot.joints))}:
        raise ConfigError(
            f"{text} has starts with other numbers than the {robot.coordinates} coordinates and {len(robot.joints)} "
            f"presses of the robot {found.robot}: give so many."
        )
    return found
