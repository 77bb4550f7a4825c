"""A recorded motion of one robot in one pipe, and all that is known of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, JsonValue

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.json_keys import PipeInFile
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome, PassageStage


class Motion(NamedTuple):
    """A motion of one robot in one pipe.

    Attributes:
        pipe: the pipe.
        base: x of the robot's frame in the pipe's frame [m].
        q: joint positions in the robot's own frame, one row per control step, the start pose first, (rows, joints).
    """

    pipe: PipeCorner
    base: float
    q: Floats


def _known_outcome(outcome: str | None) -> str | None:
    known = [outcome.label for outcome in Outcome]
    if outcome is not None and outcome not in known:
        raise ValueError(f"is none of {', '.join(known)}, null")
    return outcome


def _current_stage(given: Any) -> Any:
    """Stage of a passage from its name; schema 1 called `front` what is `reach` today."""
    try:
        return PassageStage("reach" if given == "front" else given)
    except ValueError:
        raise ValueError(f"is none of {', '.join(PassageStage)}") from None


class TrajectoryHeader(BaseModel):
    """First line of a trajectory file.

    Attributes:
        schema_version: version of the format; the key is `schema`.
        robot: name of the robot.
        pipe: the pipe, under the keys of pipe.json or of run.json.
        base_m: x of the robot's frame in the pipe's frame [m].
        goal_m: target in the pipe's frame [m]; None where there is none.
        stage: part of a passage that the motion is.
        outcome: label of an `Outcome`; None for a motion that was planned and not carried out.
        backend: name of the backend that carried it out; None for a plan.
        controller: policy, baseline or behaviour that acted.
        options: settings of the backend.
        seed: seed of the episode; None where there was none.
        gravity_mps2: gravity's part in the pipe's plane, axes of the pipe's frame [m/s^2], zeros where nothing weighs;
            None where it is not known.
    """

    model_config = ConfigDict(frozen=True, extra="ignore", strict=True, allow_inf_nan=False, populate_by_name=True)

    schema_version: Literal[1, 2] = Field(2, alias="schema")
    robot: str
    pipe: PipeInFile
    base_m: float
    goal_m: Annotated[tuple[float, float] | None, Field(strict=False)] = None
    stage: Annotated[PassageStage, BeforeValidator(_current_stage)]
    outcome: Annotated[str | None, AfterValidator(_known_outcome)] = None
    backend: str | None = None
    controller: str | None = None
    options: dict[str, JsonValue] = Field(default_factory=dict)
    seed: int | None = None
    gravity_mps2: Annotated[tuple[float, float] | None, Field(strict=False)] = None


@dataclass(frozen=True)
class Trajectory:
    """A recorded motion and all that is known of it. Its arrays must not be written to.

    Attributes:
        header: first line of the file.
        robot: robot that moved.
        q: configurations in the robot's own frame, (rows, coordinates) [rad or m]; the first row is the start pose.
        contact_force: largest net force of the pipe on any one link, peak of each control step, (rows,) [N]; None
            where nothing measured it.
        link_forces: net force of the pipe on every link at that peak, in the pipe's axes, (rows, links, 2) [N];
            None where it is not known.
    """

    header: TrajectoryHeader
    robot: RobotSpec
    q: Floats
    contact_force: Floats | None = None
    link_forces: Floats | None = None

    @property
    def motion(self) -> Motion:
        """The motion alone.

        Raises:
            PipenavError: the pipe is a route.
        """
        return Motion(self.header.pipe.require_corner(), self.header.base_m, self.q)

    @property
    def time(self) -> Floats:
        """Time of each row [s], (rows,)."""
        return np.round(np.arange(len(self.q)) * CONTROL_PERIOD, 6)

    @property
    def succeeded(self) -> bool:
        """Whether the motion achieved what its stage is for."""
        return self.header.outcome == Outcome.REACHED.label
