"""Searches for a target, with and without physics."""

from __future__ import annotations

from contextlib import closing
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.simulators import SimulatorSettings
from pipenav.evaluation.locate_stage import LocateStage
from pipenav.locating.locator import LocateConfig, Variant, robot_for
from pipenav.locating.variants import LOCATORS
from pipenav.pipes.corner import PipeCorner
from pipenav.recording.record import RecordingSettings
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.testing import KinematicBackend, KinematicOptions

ROBOTS = ("basic", "high-fidelity", "real-setup")


SIMULATOR = SimulatorSettings("mujoco", {"timestep": 0.005, "threads": 1})


FAST = RecordingSettings(SIMULATOR.backend, SIMULATOR.options)


ONE = np.arange(1)


class Search(NamedTuple):
    """End of one search: outcome, target in the pipe's frame (2,), all poses (rows, joints)."""

    outcome: Outcome
    target: Floats
    q: Floats


def search(name: str, pipe: PipeCorner, gap: float, bend: Floats, variant: Variant = "map") -> Search:
    """A search on a backend without physics, from a start so far before the bend, so much off straight."""
    robot = robot_for(load_robot(name), variant)
    base = np.array([-pipe.inner_edge - gap - robot.length])
    q = np.concatenate([[0.0], bend])[None]
    start = ReachEpisodes((pipe,), q, base, np.array([pipe.turn_sign]), np.zeros((1, 2)), np.zeros((1, 2)))
    backend = KinematicBackend(robot, 1, KinematicOptions(), wall_segments=len(pipe.segments))
    rows, outcome = [q[0]], Outcome.RUNNING
    locator = LOCATORS[variant](robot, LocateConfig(), 1)
    with closing(LocateStage(robot, locator, ReachConfig(), backend, lambda _: start)) as stage:
        stage.start(ONE)
        while outcome is Outcome.RUNNING:
            step = stage.step()
            outcome = Outcome(step.outcome[0])
            rows.append(step.q[0].copy())
    return Search(outcome, stage.target[0] * [1.0, pipe.turn_sign] + [base[0], 0.0], np.array(rows))
