"""Settings of the traverse task: every field is read by the task and states its unit and its reason."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, WrapValidator

from pipenav.arrays import Table, ordered
from pipenav.robots.inertial import SensorsName
from pipenav.tasks.reach.config import LONGEST, MOST_STEPS, Penalty, Span, Weight
from pipenav.tasks.traverse.tether import TetherConfig

Share = Annotated[float, Field(ge=0, le=1)]
Shares = Annotated[tuple[Share, Share], WrapValidator(ordered), Field(strict=False)]
Angle = Annotated[float, Field(ge=-720, le=720)]


class TraverseReward(Table):
    """Weights of the reward's terms."""

    progress: Weight = Field(4.0, description="reward per metre that the body's middle gains along the pipe [1/m]")
    passed: Weight = Field(1.0, description="reward of the tail being through: a quarter of what progress earns")
    step: Penalty = Field(
        -0.01, description="reward of every step, to be quick: a fifth of what progress usually earns"
    )
    force: Penalty = Field(0.0, description="reward per newton of the step's peak contact force [1/N]")
    penetration: Penalty = Field(-0.04, description="reward per millimetre of the step's deepest overlap [1/mm]")
    failed: Penalty = Field(-1.0, description="reward of a step that fails the episode: it undoes a success")


class TraverseConfig(Table):
    """Settings of the traverse task."""

    kind: Literal["traverse"]
    observation: Literal["body"] = Field("body", description="readings of the robot's own sensors, and the last action")
    control: Literal["position"] = Field("position", description="set-points for the on-board controllers")
    set_points: Literal["measured", "held"] = Field(
        "measured",
        description="an action changes a bending joint's measured position (eq 3.5), or its set-point of the step "
        "before, so that an action of 0 goes on pressing",
    )
    alpha: float = Field(
        0.25,
        ge=1e-4,
        le=1,
        description="set-point change of a bending joint at a full action, and largest distance of a set-point from "
        "its joint [rad]; more than full_drive_error, so that a policy can ask for all of a joint's effort",
    )
    max_steps: int = Field(
        300,
        ge=1,
        le=MOST_STEPS,
        description="control steps for each corner until an episode times out, for a robot that rolls at 0.13 m/s "
        "under its load; slower ones get more in proportion; a passage at 0.16 m/s takes 70 to 100",
    )
    patience: int = Field(
        100,
        ge=1,
        le=MOST_STEPS,
        description="control steps without an advance after which a robot counts as stuck, for the same speed",
    )
    advance: float = Field(
        0.005, ge=1e-6, le=LONGEST, description="distance gained along the pipe that counts as an advance [m]"
    )
    spin: float = Field(
        0.1,
        ge=1e-6,
        le=1000,
        description="rolled distance, mean over the wheels, from which being stuck is a slip and no jam [m]",
    )
    slide_back: float = Field(
        1.0, ge=1e-3, le=1000, description="largest fall of the body behind its furthest distance, in its own lengths"
    )
    max_penetration: float = Field(0.002, ge=1e-6, le=1, description="overlap with the wall that fails an episode [m]")
    through: float = Field(
        0.010, ge=0, le=LONGEST, description="distance of the tail past the inner wall's bend when it is through [m]"
    )
    start_gap: Span = Field(
        (0.06, 0.10), description="distance of the tip before the inner wall's bend at the start [m]"
    )
    start_spread: Shares = Field(
        (0.0, 1.0),
        description="distance of the wheels from the axis at the start, on alternating sides, as a share of the "
        "room that they have",
    )
    start_press: float = Field(
        0.0,
        ge=0,
        le=math.pi,
        description="distance of set-points beyond the bends of their joints at the start, where set-points are held "
        "[rad]: the robot clamps from the first moment",
    )
    inclination_deg: Annotated[tuple[Angle, Angle], WrapValidator(ordered)] | None = Field(
        None,
        strict=False,
        description="range of gravity's direction in the pipe's plane, from the first leg's direction towards the "
        "left [deg]; none: the plane is level and carries the robot",
    )
    exit_told: bool = Field(
        False,
        description="each robot is told where its route goes straight on, past a branch or into another bore; which "
        "way it turns elsewhere every robot is told",
    )
    sensors: SensorsName = Field(
        "ideal",
        description="grade of gyroscopes, accelerometers and wheel encoders: without errors, or of a consumer part",
    )
    recovery: bool = Field(
        False,
        description="whether a robot in the plane rolls back by itself and tries again where its own sensors say that "
        "it is stuck; in space robots do so anyway",
    )
    tether: TetherConfig | None = Field(None, description="cable that the robot drags; none: it has none")
    reward: TraverseReward = TraverseReward()
