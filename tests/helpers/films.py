"""Motions made up, to be filmed."""

from __future__ import annotations

import numpy as np

from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot

ROBOT = load_robot("basic")


def motion(rows: int, pipe: PipeCorner, outcome: str | None = "reached") -> Trajectory:
    """A motion of some rows that bends the arm to the pipe's side, and touches the wall in the end."""
    target = 0.15 * pipe.second_leg
    header = TrajectoryHeader(
        robot="basic",
        pipe=pipe,
        base_m=-0.6,
        goal_m=(float(target[0]), float(target[1])),
        stage="reach",
        outcome=outcome,
        backend="mujoco",
        controller="arm",
    )
    q = np.linspace([0, 0, 0, 0], [0.2, 0.1, 0.2, 0.3], rows) * [1, pipe.turn_sign, pipe.turn_sign, pipe.turn_sign]
    forces = np.zeros((rows, 4, 2))
    forces[-1, 3] = [0.0, -8.0]
    return Trajectory(header, ROBOT, q, np.linalg.norm(forces, axis=2).max(axis=1), forces)


TWO = [motion(4, PipeCorner.of(100, 90)), motion(3, PipeCorner.of(120, 60, "right"), "timeout")]
