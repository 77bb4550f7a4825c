"""Disturbances: faults of a real arm as ranges, for randomised training and for `pipenav eval --disturb`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import BaseModel, Field, ValidationError, WrapValidator

from pipenav.arrays import Table, ordered
from pipenav.errors import ConfigError, PipenavError, UnknownName
from pipenav.storage import shipped
from pipenav.storage.text_files import read_toml

Task = TypeVar("Task", bound=BaseModel)

MAX_LATENCY = 5
"""Largest latency that can be set [control steps]: half a second is more than any bus needs."""


_Factor = Annotated[float, Field(gt=0, le=10)]
_Share = Annotated[float, Field(ge=0, le=1)]
_Steps = Annotated[int, Field(ge=0, le=MAX_LATENCY)]
Factors = Annotated[tuple[_Factor, _Factor], WrapValidator(ordered), Field(strict=False)]
Shares = Annotated[tuple[_Share, _Share], WrapValidator(ordered), Field(strict=False)]
Steps = Annotated[tuple[_Steps, _Steps], WrapValidator(ordered), Field(strict=False)]


class Disturbance(Table):
    """Ranges `[smallest, largest]` from which every robot draws evenly at the start of every episode.

    The defaults disturb nothing. Joint positions stay true: an encoder does not fail as a scanner does.
    """

    friction: Factors = Field((1.0, 1.0), description="factor on the friction coefficient")
    mass: Factors = Field((1.0, 1.0), description="factor on mass and inertia, drawn for each link")
    strength: Factors = Field((1.0, 1.0), description="factor on an actuator's effort and speed, drawn for each joint")
    gain: Factors = Field((1.0, 1.0), description="factor on a position controller's gain, drawn for each joint")
    latency: Steps = Field((0, 0), description="control steps by which every command arrives late")
    noise: Shares = Field((0.0, 0.0), description="standard deviation of a laser reading that meets a wall [m]")
    dropouts: Shares = Field((0.0, 0.0), description="share of all readings that are the laser's minimum instead")
    missing: Shares = Field((0.0, 0.0), description="share of the beams that read the laser's maximum all episode long")
    start_bend: _Share | None = Field(None, description="largest start angle of a hinge [rad], instead of the task's")
    start_gap: Shares | None = Field(
        None, description="how far before the inner wall's bend the tip starts [m], instead of the task's"
    )

    @property
    def varies_robots(self) -> bool:
        """Whether robots differ from their description, which only some simulators can do (`Simulator.can_vary`)."""
        return any(span != (1.0, 1.0) for span in (self.friction, self.mass, self.strength, self.gain))

    @property
    def acts(self) -> bool:
        """Whether anything is disturbed once an episode has begun."""
        return self.model_copy(update={"start_bend": None, "start_gap": None}) != Disturbance()

    def starts(self, task: Task) -> Task:
        """Copy of the task with the start poses that are set here.

        Raises:
            PipenavError: the task has no such start pose.
        """
        given = {"start_bend": self.start_bend, "start_gap": self.start_gap}
        wanted = {key: value for key, value in given.items() if value is not None}
        for key in wanted.keys() - type(task).model_fields.keys():
            raise PipenavError(f"the disturbance sets {key}, which this policy's task does not have: leave it out.")
        return task.model_copy(update=wanted)


UNDISTURBED = Disturbance()


def disturbance_names() -> list[str]:
    """Names of the shipped disturbances."""
    return sorted(path.stem for path in shipped.disturbances_dir().glob("*.toml"))


def load_disturbance(text: str) -> Disturbance:
    """Load a shipped disturbance by its name, or a disturbance from a TOML file.

    Raises:
        UnknownName: the text is neither a shipped name nor a TOML file.
        ConfigError: the file describes no disturbance, or one that disturbs nothing.
        FileProblem: the file cannot be read.
    """
    path = Path(text)
    if text in disturbance_names():
        path = shipped.disturbances_dir() / f"{text}.toml"
    elif path.suffix != ".toml":
        raise UnknownName("disturbance", text, [*disturbance_names(), "FILE.toml"])
    try:
        disturbance = Disturbance.model_validate(read_toml(path))
    except ValidationError as error:
        raise ConfigError.from_validation(text, error, Disturbance.model_fields) from error
    if disturbance == UNDISTURBED:
        raise ConfigError(f"{text} disturbs nothing: set one of {', '.join(Disturbance.model_fields)} in it.")
    return disturbance
