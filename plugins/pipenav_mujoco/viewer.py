"""MuJoCo's interactive viewer on one robot, with its beams, contact forces and target, and a line of text."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import mujoco
import numpy as np

from pipenav.arrays import Floats
from pipenav.backends import Sight
from pipenav.errors import PipenavError
from pipenav.robots import frames

NO_DISPLAY = "leave out --live to get a picture, which needs no display"

ROBOT, BEAM = [0.0, 0.45, 0.70, 1.0], [0.90, 0.62, 0.0, 0.6]
FORCE, TARGET = [0.84, 0.37, 0.0, 1.0], [0.0, 0.62, 0.45, 1.0]
"""Colours of the parts, those of the pictures: red, green, blue, opacity."""

DOWN = [0.56, 0.12, 0.42, 1.0]
"""Colour of the arrow downwards, as in the pictures."""

DOWN_BESIDE, DOWN_LENGTH = np.array([-0.25, 0.22, 0.0]), 0.15
"""Place of that arrow beside the tip, (3,) [m], and its length [m]."""

FORCE_SCALE = 0.006
"""Length of a contact arrow [m/N]."""

LEAST_FORCE = 0.3
"""Least force that is drawn [N]."""

BEAM_WIDTH, ARROW_WIDTH, TARGET_RADIUS = 2.0, 0.003, 0.008
"""Width of a beam in pixels, of an arrow [m], and radius of the target's ball [m]."""


class Marks(NamedTuple):
    """Beams and forces of a robot now, in the model's frame.

    Attributes:
        tip: position of the tip, (3,) [m].
        beams: ends of the laser beams, (beams, 3) [m].
        links: middles of the links, (links, 3) [m].
        forces: forces of the pipe on the links, (links, 3) [N].
        base: x of the model's origin in the pipe's frame [m].
    """

    tip: Floats
    beams: Floats
    links: Floats
    forces: Floats
    base: float


class Angle(NamedTuple):
    """Place of the camera around the tip: distance [m], azimuth and elevation [deg]."""

    distance: float
    azimuth: float
    elevation: float


FROM_ABOVE, ASLANT = Angle(0.9, 90.0, -89.0), Angle(1.1, 110.0, -35.0)
"""Cameras on a robot in the plane, with the first leg to the left, and on one in space."""


class MujocoViewer:
    """Viewer of one robot. It has a state of its own, so that the backend may be closed before the window.

    Args:
        model: model with the robot's own walls; the viewer owns it from then on.
        states: live views of the state of the robot, by the names that `MjData` gives them.
        marks: function that gives what is drawn beside the robot.
        camera: place of the camera around the tip, which it follows.
    """

    def __init__(self, model: Any, states: dict[str, Floats], marks: Callable[[], Marks], camera: Angle) -> None:
        _require_display()
        import mujoco.viewer

        self._model, self._data, self._states, self._marks = model, mujoco.MjData(model), states, marks
        self._copy()
        # The camera shows nothing nearer than a share of the model's extent, which parked walls make a hundred metres.
        model.stat.extent = 1.0
        robot = model.body_weldid[model.geom_bodyid] != 0  # walls are welded to the world, mocap bodies too
        model.geom_rgba[robot] = ROBOT
        self._window = mujoco.viewer.launch_passive(model, self._data, show_left_ui=False, show_right_ui=False)
        with self._window.lock():
            seen = self._window.cam
            seen.lookat[:] = self._data.site("tip").xpos
            seen.distance, seen.azimuth, seen.elevation = camera

    def show(self, sight: Sight) -> bool:
        if not self._window.is_running():
            return False
        with self._window.lock():
            self._copy()
            self._window.cam.lookat[:] = self._data.site("tip").xpos
            draw_marks(self._window.user_scn, self._marks(), sight.target, sight.down)
        # The viewer's font has no letters beyond ASCII.
        text = sight.text.encode("ascii", "replace").decode()
        self._window.set_texts((mujoco.mjtFontScale.mjFONTSCALE_150, mujoco.mjtGridPos.mjGRID_TOPLEFT, text, ""))
        self._window.sync()
        return bool(self._window.is_running())

    def close(self) -> None:
        self._window.close()

    def _copy(self) -> None:
        for name, values in self._states.items():
            getattr(self._data, name)[:] = values
        mujoco.mj_forward(self._model, self._data)


def draw_marks(
    scene: Any,
    marks: Marks,
    target: tuple[float, float] | None,
    down: tuple[float, float, float] | None = None,
) -> None:
    """Draw marks in place of what a scene showed before: beams, forces, a ball for the target, an arrow downwards.

    Args:
        scene: the scene.
        marks: beams and forces.
        target: target in the pipe's frame, (x, y) [m].
        down: unit vector downwards in the pipe's frame, (x, y, z).
    """
    scene.ngeom = 0
    for end in marks.beams:
        _connect(scene, mujoco.mjtGeom.mjGEOM_LINE, BEAM_WIDTH, marks.tip, end, BEAM)
    for middle, force in zip(marks.links, marks.forces, strict=True):
        if np.linalg.norm(force) >= LEAST_FORCE:
            _connect(scene, mujoco.mjtGeom.mjGEOM_ARROW, ARROW_WIDTH, middle, middle + FORCE_SCALE * force, FORCE)
    if target is not None:
        place = np.append(frames.pipe_to_robot(target, marks.base), 0.0)
        _add(scene, mujoco.mjtGeom.mjGEOM_SPHERE, TARGET_RADIUS, place, TARGET)
    if down is not None:
        start = marks.tip + DOWN_BESIDE
        _connect(scene, mujoco.mjtGeom.mjGEOM_ARROW, 3 * ARROW_WIDTH, start, start + DOWN_LENGTH * np.array(down), DOWN)


def _connect(scene: Any, kind: Any, width: float, start: Floats, end: Floats, colour: list[float]) -> None:
    geom = _add(scene, kind, width, start, colour)
    if geom is not None:
        mujoco.mjv_connector(geom, kind, width, np.asarray(start, float), np.asarray(end, float))


def _add(scene: Any, kind: Any, size: float, place: Floats, colour: list[float]) -> Any:
    """Add a geom to a scene; None where the scene is full."""
    if scene.ngeom >= scene.maxgeom:
        return None
    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, np.full(3, size), place, np.eye(3).ravel(), np.array(colour, np.float32))
    geom.emission = 0.5  # marks must be seen in the shade of walls too
    scene.ngeom += 1
    return geom


def _require_display() -> None:
    """Raise an error where no window can open; the viewer's own thread would leave its caller waiting for ever."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        unset = "neither DISPLAY nor WAYLAND_DISPLAY is set"
        raise PipenavError(f"MuJoCo's viewer needs a display, and {unset}: {NO_DISPLAY}.")
    import glfw

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # glfw warns of the same
        opened = glfw.init()
    if not opened:
        raise PipenavError(f"MuJoCo's viewer cannot open a window on this display: {NO_DISPLAY}.")
