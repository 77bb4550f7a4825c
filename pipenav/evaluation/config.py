"""The configuration of an evaluation, which eval.json keeps."""

from __future__ import annotations

import operator
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, JsonValue

from pipenav.arrays import Table
from pipenav.locating.locator import Variant
from pipenav.robots.inertial import SensorsName

StageName = Literal["locate", "reach", "reach-rear", "passage", "traverse"]
"""Name of what is run: one part of a passage, or several one after the other."""

EARLIER_STAGES = {"front": "reach", "front-rear": "reach-rear"}
"""Names that stages had earlier, and the ones that they have today."""


def todays_stage(given: Any) -> Any:
    """Name that a stage has today; anything else as it is."""
    return EARLIER_STAGES.get(given, given) if isinstance(given, str) else given


MOST_EPISODES = 100_000
"""Most episodes in each pipe: days on any machine."""


def not_given(value: Any) -> bool:
    """Whether a key is left out of files, so that those of evaluations that do not have it stay as they were."""
    return value is None


class EvaluationConfig(Table):
    """Everything that decides what an evaluation computes."""

    policy: str | None = Field(None, description="shipped policy, FILE.zip or baseline; none for the stage locate")
    pipes: tuple[str, ...] = Field(
        ("working-range",), strict=False, min_length=1, description="pipes, as a person names them"
    )
    episodes: int = Field(20, ge=1, le=MOST_EPISODES, description="episodes in each pipe")
    seed: int = Field(0, ge=0, description="seed of starts and targets")
    stage: Annotated[StageName | None, BeforeValidator(todays_stage)] = Field(
        None, description="stage to run; none: the one that the policy was trained for"
    )
    robot: str | None = Field(None, description="robot of the stage locate and of baselines; a policy brings its own")
    variant: Variant = Field("map", description="how a target is located")
    backend: str = Field("mujoco", description="name of a simulator backend")
    options: dict[str, JsonValue] = Field(default_factory=dict, description="the simulator's own settings")
    disturb: str | None = Field(None, description="disturbances, by name or as FILE.toml")
    tether: float | None = Field(
        None, ge=0, le=100_000, exclude_if=not_given, description="length of cable behind a whole robot [m]; none: none"
    )
    cable_friction: float | None = Field(
        None, ge=0, le=3, exclude_if=not_given, description="friction of that cable in the pipe; none: as in PVC"
    )
    max_force: float | None = Field(
        None,
        gt=0,
        le=1e6,
        exclude_if=not_given,
        description="contact force on any one link beyond which an episode fails [N]; none: no limit",
    )
    starts: str | None = Field(
        None, exclude_if=not_given, description="set of starts, by name or as FILE.json; none: drawn from the seed"
    )
    sensors: SensorsName | None = Field(
        None, exclude_if=not_given, description="grade of a whole robot's sensors; none: as its policy was trained"
    )
    recover: bool = Field(
        False, exclude_if=operator.not_, description="whether whole robots back out by themselves where they are stuck"
    )
    audit: float | None = Field(
        None, gt=0, le=1, exclude_if=not_given, description="share of the successful episodes to audit by geometry"
    )
    certify: bool = Field(
        False, exclude_if=operator.not_, description="whether geometry decides which episodes were possible at all"
    )

    @property
    def subject(self) -> str:
        """Name of what is evaluated: of the policy, or of the behaviour that locates a target."""
        return self.policy or f"locate:{self.variant}"
