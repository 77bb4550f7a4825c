"""MuJoCo's interactive viewer on one robot of a batch."""

from __future__ import annotations

import os
import sys
import warnings
from typing import Any

import mujoco

from pipenav.arrays import Floats
from pipenav.errors import PipenavError

NO_DISPLAY = "leave out --live to get a picture, which needs no display"


class MujocoViewer:
    """Viewer of one robot. It has a state of its own, so that the backend may be closed before the window.

    Args:
        model: the batch's model with the robot's own wall sizes; the viewer owns it from then on.
        states: live views of the batch's state of one robot, by the names that `MjData` gives them.
    """

    def __init__(self, model: Any, states: dict[str, Floats]) -> None:
        _require_display()
        import mujoco.viewer

        self._model, self._data, self._states = model, mujoco.MjData(model), states
        self._copy()
        # The camera shows nothing nearer than a share of the model's extent, which parked walls make a hundred metres.
        model.stat.extent = 1.0
        model.geom_rgba[model.body_mocapid[model.geom_bodyid] < 0] = [0.0, 0.45, 0.70, 1.0]  # the robot
        self._window = mujoco.viewer.launch_passive(model, self._data, show_left_ui=False, show_right_ui=False)
        with self._window.lock():
            camera = self._window.cam
            camera.lookat[:] = self._data.site("tip").xpos
            # From above, the first leg to the left.
            camera.distance, camera.azimuth, camera.elevation = 0.9, 90.0, -89.0

    def show(self) -> bool:
        if not self._window.is_running():
            return False
        with self._window.lock():
            self._copy()
        self._window.sync()
        return bool(self._window.is_running())

    def close(self) -> None:
        self._window.close()

    def _copy(self) -> None:
        for name, values in self._states.items():
            getattr(self._data, name)[:] = values
        mujoco.mj_forward(self._model, self._data)


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
