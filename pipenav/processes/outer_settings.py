"""Environment variables that notebooks and servers set for programs of their own, left out of pipenav's processes."""

from __future__ import annotations

import os

SCREEN_SETTINGS = ("MPLBACKEND", "MUJOCO_GL", "PYOPENGL_PLATFORM")
"""Variables that choose what Matplotlib and MuJoCo draw on a screen with.

An import fails where they name what is not installed. pipenav needs none: its pictures go straight into files, and
MuJoCo's viewer always opens its window by GLFW.
"""


def leave_screen_settings() -> None:
    """Take the settings out of the environment of this process, and so of whatever it starts; twice is harmless."""
    for name in SCREEN_SETTINGS:
        os.environ.pop(name, None)
