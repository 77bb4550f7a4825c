"""An emulated arm for a mission: where it stands in the pipe, and what goes wrong with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipenav.backends.real_robot import ArmStart
from pipenav.errors import FileProblem, PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec
from pipenav.storage.text_files import MAX_SETTINGS, read_json
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig

THESIS_FAULTS: list[dict[str, Any]] = [
    {"device": "scanner", "fault": "minimum", "probability": 0.3},
    {"device": "scanner", "fault": "noise", "value": 0.01},
]
"""The scanner of the thesis (5.4.1): readings of its smallest range where the pipe is open, and noise."""


class Emulation(NamedTuple):
    """An emulated arm as it will be started.

    Attributes:
        pipe: the pipe around it.
        start: where it stands.
        seed: seed of noise and of random faults.
        faults: what goes wrong, as yet unchecked.
        patience: factor on every time limit of the driver, for busy machines.
    """

    pipe: PipeCorner
    start: ArmStart
    seed: int
    faults: list[dict[str, Any]]
    patience: float


def plan_emulation(robot: RobotSpec, pipe: PipeCorner, seed: int, faults: str | None, patience: float) -> Emulation:
    """Draw where the arm stands, and find out what is to go wrong.

    Args:
        robot: the robot.
        pipe: the pipe around it.
        seed: seed of the start, of noise and of random faults.
        faults: `thesis` for the scanner of the thesis, or a JSON file; None for no faults.
        patience: factor on every time limit of the driver.

    Raises:
        PipenavError: there is no such file, or it is not a list in JSON.
    """
    return Emulation(pipe, draw_start(robot, pipe, seed), seed, _named_faults(faults), patience)


def draw_start(robot: RobotSpec, pipe: PipeCorner, seed: int) -> ArmStart:
    """Pose in which the arm starts in a pipe: the start of an episode of the reach task."""
    episodes = episode.sample(robot, ReachConfig(), [pipe], np.random.default_rng(seed))
    return ArmStart(episodes.q[0], float(episodes.base[0]))


def _named_faults(name: str | None) -> list[dict[str, Any]]:
    if name is None:
        return []
    if name == "thesis":
        return THESIS_FAULTS
    try:
        loaded = read_json(Path(name), MAX_SETTINGS)
    except FileProblem as problem:
        raise PipenavError(f"{str(problem).rstrip('.')}: for --faults choose thesis or a JSON file.") from problem
    if not isinstance(loaded, list):
        raise PipenavError(f'{name} holds no list of faults: write [{{"fault": "drop"}}], for example.')
    return loaded
