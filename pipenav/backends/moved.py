"""Old names of pipenav that plugins may have been written for, and the names that took their place."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.util import find_spec

import pipenav

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
    names = set(names)
    old = sorted(name for name in names if name in MOVED)
    exact = [name for name in old if not any(other.startswith(f"{name}.") for other in old)]
    if exact:
        return "it imports " + ", ".join(f"{name} ({MOVED[name]} now)" for name in exact)
    gone = sorted({top for name in names if (top := _module_of_pipenav(name)) and not _exists(top)})
    return no_longer_here(", ".join(gone)) if gone else ""


def no_longer_here(module: str) -> str:
    """Sentence about a module of an older pipenav that no single name of today stands for."""
    return f"it imports {module}, which this pipenav no longer has"


def _module_of_pipenav(name: str) -> str:
    """Module or package right below `pipenav` that a dotted name begins with; empty for other people's names."""
    top, *below = name.split(".")
    return f"{top}.{below[0]}" if top == pipenav.__name__ and below else ""


def _exists(module: str) -> bool:
    """Whether a name right below `pipenav` is there, as a module or as an attribute such as its version."""
    return hasattr(pipenav, module.rpartition(".")[2]) or find_spec(module) is not None
