"""The screen of `pipenav drive`: the robot from above in braille letters, and what the keys do."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Self

import numpy as np
from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.driving.braille import View, draw
from pipenav.driving.mapping import legend
from pipenav.driving.steps import STEPS
from pipenav.units import rad_to_deg

if TYPE_CHECKING:
    from pipenav.arrays import Floats
    from pipenav.driving.shown import Shown

STYLES = ("", "bold cyan", "bold yellow")
"""Colours of walls, robot and target."""

ROWS, COLUMNS = 16, 76
"""Largest picture [letters]."""

EVERY = 2
"""Number of control steps from one picture to the next."""

LEGEND_ROWS = 4
"""Most rows of the mapping on the screen."""


class DriveView:
    """Shows every control step of a session in the terminal, in step with the clock; a context manager.

    Args:
        console: the terminal.
        mapping: action of each control, for the legend.
        clock: gives the time [s].
        sleep: waits for a time [s].
    """

    def __init__(
        self,
        console: Console,
        mapping: Mapping[str, str],
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._console, self._clock, self._sleep = console, clock, sleep
        self._legend = "  ".join(legend(mapping))
        self._live = Live(console=console, auto_refresh=False, transient=True) if console.is_terminal else None
        self._due = clock()

    def __enter__(self) -> Self:
        if self._live is not None:
            self._live.start()
        self._due = self._clock()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def __call__(self, shown: Shown) -> None:
        """Show a control step, and wait until the next one is due."""
        if self._live is not None and round(shown.seconds / CONTROL_PERIOD) % EVERY == 0:
            self._live.update(self.picture(shown), refresh=True)
        self._due = max(self._due + CONTROL_PERIOD, self._clock() - CONTROL_PERIOD)
        self._sleep(max(0.0, self._due - self._clock()))

    def picture(self, shown: Shown) -> Group:
        """The screen of a control step."""
        columns = max(min(self._console.width - 1, COLUMNS), 20)
        rows = max(min(self._console.height - 10, ROWS), 5)
        label, segments, points, aim = shown.picture
        centre = (points.max(axis=0) + points.min(axis=0)) / 2
        extent = np.ptp(points, axis=0)
        width = max(1.3 * extent[0], 1.3 * extent[1] * columns / (2 * rows), 0.5)
        walls = [_near(part, centre, 2 * width) for part in segments]
        target = [] if aim is None else [_cross(aim, width / 60)]
        cells = draw(View(centre, float(width), columns, rows), [walls, [points], target])
        lines = []
        for row in cells:
            line = Text(no_wrap=True)
            for cell in row:
                line.append(cell.letter, STYLES[cell.layer] if cell.layer >= 0 else "")
            lines.append(line)
        return Group(*lines, *self._words(shown, label))

    def _words(self, shown: Shown, label: str) -> list[Text]:
        door, reading = shown.door, shown.reading
        where = f"{label}, " if label else ""
        step = f", step ({door.step}) {STEPS[door.step]}" if door.step in STEPS else door.step and f", {door.step}"
        step += ": done" if door.step_done else ""
        joints = "  ".join(
            f"{1e3 * value:.0f} mm" if slide else f"{rad_to_deg(value):.0f}°"
            for value, slide in zip(reading.q[0], ~door.robot.hinges, strict=True)
        )
        return [
            Text(f"{where}{shown.seconds:.1f} s: {door.who} drives{step}", "bold"),
            *([Text(door.scenery, "magenta")] if door.scenery else []),
            Text(f"joints {joints}   force {shown.force:.0f} N   taken over {door.takeovers} times"),
            Text(door.said, "yellow"),
            Text(self._legend, "dim"),
        ]


def with_window(opened: contextlib.ExitStack, view: Callable[[Shown], None]) -> Callable[[Shown], None]:
    """The view with the simulator's own window beside it, open until `opened` is closed."""
    from pipenav.backends.viewer import Sight
    from pipenav.recording.live import Window

    window = Window(sleep=lambda _: None)  # the view waits for the clock
    opened.callback(window.close)

    def show(shown: Shown) -> None:
        if shown.world is not None:
            aim = shown.picture.target
            target = None if aim is None else (float(aim[0]), float(aim[1]))
            window(shown.world, Sight(f"{shown.seconds:.1f} s: {shown.door.who} drives", target))
        view(shown)

    return show


def _near(segment: Floats, centre: Floats, reach: float) -> Floats:
    """A wall's part that is near enough to be seen, (2, 2) [m]: walls are metres long."""
    a, d = segment[0], segment[1] - segment[0]
    length = float(np.hypot(*d))
    if length == 0.0:
        return segment
    middle = float((centre - a) @ d) / length
    ends = np.clip([middle - reach, middle + reach], 0.0, length)
    return np.asarray(a + ends[:, None] * d / length)


def _cross(point: Floats, size: float) -> Floats:
    """A small cross as one line, (5, 2) [m]."""
    return np.asarray(point + size * np.array([[-1, -1], [1, 1], [0, 0], [-1, 1], [1, -1]]))
