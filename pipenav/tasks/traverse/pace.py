"""Time that a robot gets: more for a slow one, by the speed that its wheels have under its load."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.robots import traction
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import GRAVITY, TraverseEpisodes

PACE = 0.13
"""Speed under load for which a task's time limits are stated [m/s]: that of `pirate-strong` that climbs upright, of its
0.16 m/s in a level pipe. A faster robot gets no less time."""

CRAWL = 0.1
"""Least share of the no-load speed that is counted on: a robot whose load is its pull would get time for ever."""


def slowness(robot: RobotSpec, config: TraverseConfig, episodes: TraverseEpisodes) -> Floats:
    """Factors on the time limits of k episodes, at least 1, (k,)."""
    gravity = np.maximum(np.linalg.norm(episodes.gravity, axis=1), np.linalg.norm(episodes.gravity_in_space, axis=1))
    return _slowness(robot, config, gravity, episodes.cable)


def most_slowness(robot: RobotSpec, config: TraverseConfig) -> float:
    """Largest of these factors in any episode."""
    gravity, cable = (
        0.0 if config.inclination_deg is None else GRAVITY,
        0.0 if config.tether is None else config.tether.length[1],
    )
    return float(_slowness(robot, config, np.array(gravity), np.array(cable)))


def _slowness(robot: RobotSpec, config: TraverseConfig, gravity: Floats, cable: Floats) -> Floats:
    """Factors for a gravity [m/s^2] and a length of cable [m] behind the robot, in their shape."""
    dragged = 0.0 if config.tether is None else config.tether.per_metre * cable
    speed = traction.speed_under(robot, traction.mass(robot) * gravity + dragged)
    return np.asarray(np.maximum(1.0, PACE / np.maximum(speed, CRAWL * traction.top_speed(robot))))
