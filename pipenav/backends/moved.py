"""Old names of pipenav that plugins may have been written for, and the names that took their place."""

from __future__ import annotations

from collections.abc import Iterable

UPDATE = "update it, as pipenav's guide 'Write a backend' shows"
"""Remedy for a plugin that was written for an older pipenav."""

MOVED = {
    "pipenav.any_pipe": "pipenav.pipes",
    "pipenav.any_pipe.AnyPipe": "pipenav.pipes.Pipe",
    "pipenav.backend": "pipenav.backends",
    "pipenav.backend.Inclinable": "pipenav.backends.Simulator",
    "pipenav.backend.Variable": "pipenav.backends.Simulator",
    "pipenav.backend.Viewable": "pipenav.backends.Simulator",
    "pipenav.contact_force": "pipenav.backends",
    "pipenav.kinematics": "pipenav.robots.kinematics",
    "pipenav.laser": "pipenav.robots.laser",
    "pipenav.machine": "pipenav.backends",
    "pipenav.machine.Machine": "pipenav.backends.RealRobot",
    "pipenav.machine.load_machine": "pipenav.backends.load_real_robot",
    "pipenav.pipe": "pipenav.pipes",
    "pipenav.pipe.Pipe": "pipenav.pipes.PipeCorner",
    "pipenav.pipe_run": "pipenav.pipes",
    "pipenav.pipe_run.PipeRun": "pipenav.pipes.PipeRoute",
    "pipenav.pipe_run_legs": "pipenav.pipes",
    "pipenav.pipe_run_shapes": "pipenav.pipes",
    "pipenav.pipe_shapes": "pipenav.pipes",
    "pipenav.pipe_shapes.wall_boxes": "pipenav.pipes.corner_boxes",
    "pipenav.registry": "pipenav.backends",
    "pipenav.robot": "pipenav.robots",
    "pipenav.robot_parts": "pipenav.robots",
    "pipenav.robot_parts.Table": "pipenav.arrays.Table",
    "pipenav.safety": "pipenav.backends.safety",
    "pipenav.space": "pipenav.backends",
    "pipenav.space.Spatial": "pipenav.backends.Simulator",
    "pipenav.state": "pipenav.backends",
    "pipenav.wall_boxes": "pipenav.backends",
}
"""Old name of a module, or of a class or function in it: the name to import today."""


def outdated(names: Iterable[str]) -> str:
    """Sentence about the old names among those that a plugin imports, with the new ones; empty where there are none."""
    old = sorted({name for name in names if name in MOVED})
    exact = [name for name in old if not any(other.startswith(f"{name}.") for other in old)]
    return "it imports " + ", ".join(f"{name} ({MOVED[name]} now)" for name in exact) if exact else ""
