"""A window on a running simulation, and what is shown in it beside the robot."""

from __future__ import annotations

from typing import NamedTuple, Protocol


class Sight(NamedTuple):
    """Things to show beside the robot, its beams and its contact forces, which a simulator knows itself.

    Attributes:
        text: a line of text.
        target: target in the pipe's frame, (x, y) [m]; None for a task without one, or before it is found.
        down: unit vector downwards in the pipe's frame, (x, y, z); None where nothing weighs, or it is not known.
    """

    text: str = ""
    target: tuple[float, float] | None = None
    down: tuple[float, float, float] | None = None


class Viewer(Protocol):
    """A window of a simulator's own on its first robot."""

    def show(self, sight: Sight) -> bool:
        """Show the state as it is now; False when the person has closed the window."""
        ...

    def close(self) -> None:
        """Close the window; closing twice is harmless."""
        ...


class HasWindow(Protocol):
    """A simulator, in the plane or in space, that may have a window of its own."""

    def open_viewer(self) -> Viewer:
        """Open a window on the first robot.

        Raises:
            PipenavError: there is none, or no display for it.
        """
        ...
