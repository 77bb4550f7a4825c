"""Settings of the reach task: every field is read by the task and states its unit and its reason."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, WrapValidator

from pipenav.arrays import Table, ordered
from pipenav.backends.messages import Control

TargetReward = Literal["linear", "huber", "log"]

LARGEST_WEIGHT = 1e6
"""Largest weight of a reward's term: far beyond any use, and small enough for the learner's 32-bit floats."""

LONGEST = 10.0
"""Longest distance in an episode [m]: half of the longest leg."""

MOST_STEPS = 100_000
"""Most control steps of an episode: almost three hours."""

Weight = Annotated[float, Field(ge=0, le=LARGEST_WEIGHT)]
Penalty = Annotated[float, Field(ge=-LARGEST_WEIGHT, le=0)]
Distance = Annotated[float, Field(ge=0, le=LONGEST)]
Span = Annotated[tuple[Distance, Distance], WrapValidator(ordered), Field(strict=False)]


class RewardConfig(Table):
    """Weights of the reward's terms: first the thesis's (eq 3.12, 3.15), then ours, which are off by default."""

    target: TargetReward = Field("log", description="target term: eq 3.6 linear, 3.7 huber or 3.8 log")
    c1: Weight = Field(1.5, description="weight of the target term (5.1)")
    c2: Weight = Field(0.4, description="weight of the laser term, eq 3.10")
    c3: Weight = Field(0.0, description="weight of the joint-change term, eq 3.14")
    beta: float = Field(5.0, ge=1e-6, le=1000, description="slope of the laser term [1/m] (eq 3.11)")
    d0: float = Field(0.005, ge=1e-6, le=1000, description="offset of the laser term (eq 3.11)")
    limit: Penalty = Field(-1000.0, description="reward of a step that fails the episode (eq 3.13)")

    progress: Weight = Field(0.0, description="reward per metre by which a step shortens the path to the target [1/m]")
    reach: Weight = Field(0.0, description="reward of reaching the target")
    step: Penalty = Field(0.0, description="reward of every step, to be quick")
    force: Penalty = Field(0.0, description="reward per newton of the step's peak contact force [1/N]")
    penetration: Penalty = Field(0.0, description="reward per millimetre of the step's deepest overlap [1/mm]")

    scale: float = Field(
        1.0, ge=1e-9, le=LARGEST_WEIGHT, description="factor on the sum, to suit the learning algorithm"
    )


class ReachConfig(Table):
    """Settings of the reach task."""

    kind: Literal["reach"] = "reach"
    observation: Literal["basic", "history", "relative", "relative-history"] = Field(
        "basic",
        description="eq 3.1; eq 3.2; eq 3.1 with the target seen from the tip; or the latter with the last action and "
        "the scan before, which make up for late commands and lost beams",
    )
    control: Control = Field(
        "torque", description="actions are duties, shares of effort (eq 3.3), or position steps (eq 3.4)"
    )
    alpha: float = Field(0.2, ge=1e-4, le=1, description="position step of a full action, in units (eq 3.5; 5.2)")
    slide_unit: float = Field(
        0.1, ge=1e-4, le=LONGEST, description="unit step of a slide [m]: 0.2 x 0.1 m is the thesis's v0 (5.3.1)"
    )
    max_steps: int = Field(100, ge=1, le=MOST_STEPS, description="control steps until an episode times out (4.4.2)")
    reach_tolerance: float = Field(
        0.020,
        ge=1e-4,
        le=1,
        description="distance of tip and target that counts as reached [m]; the thesis gives none. The width of the "
        "tip: the task is to pass the corner, not to park",
    )
    max_penetration: float = Field(0.002, ge=1e-6, le=1, description="overlap with the wall that fails an episode [m]")
    limit_margin: float = Field(
        0.005, ge=0, lt=0.1, description="a joint is at its limit within this share of its travel"
    )
    target_depth: Span = Field(
        (0.08, 0.12),
        description="target area along the second leg, from the end of the inner wall's bend [m]",
    )
    target_lateral: float = Field(0.15, ge=0, lt=0.4, description="half width of the target area, in diameters")
    start_gap: Span = Field((0.06, 0.10), description="how far before the inner wall's bend the tip starts [m]")
    start_bend: float = Field(0.05, ge=0, le=math.pi, description="largest start angle of a hinge [rad]")
    reward: RewardConfig = RewardConfig()
