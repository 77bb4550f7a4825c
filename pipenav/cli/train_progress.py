"""The progress of `pipenav train` on the terminal: a bar of PPO's steps, and one before it of a supervised start."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

from pipenav.cli.terminal import say

if TYPE_CHECKING:
    from rich.progress import Progress

    from pipenav.learning.progress import TrainingProgress

SECONDS_BETWEEN_LINES = 10
"""Time between two lines of progress where the output is no terminal [s]."""


class TrainingRows:
    """Rows of a bar that follow a training, and lines where the console is no terminal.

    Args:
        bar: the bar.
        steps: control steps of the whole training.
    """

    def __init__(self, bar: Progress, steps: int) -> None:
        self._bar, self._console, self._steps = bar, bar.console, steps
        self._row = bar.add_task("loading the learner", total=steps)
        self._lessons = bar.add_task("supervised start", total=1.0, visible=False)
        self._last_line = 0.0

    def loaded(self) -> None:
        """Say that the learner is loaded."""
        self._bar.update(self._row, description="starting")

    def report(self, progress: TrainingProgress) -> None:
        """Show what a training reports."""
        if not math.isnan(progress.imitated):
            self._bar.update(self._lessons, completed=progress.imitated, visible=True)
            if progress.imitated == 1.0:
                say("supervised start done", console=self._console)
            return
        text = progress_text(progress)
        self._bar.update(self._row, completed=progress.steps, description=text)
        if not self._console.is_terminal and time.monotonic() - self._last_line > SECONDS_BETWEEN_LINES:
            self._last_line = time.monotonic()
            say(f"{progress.steps:>9,} of {self._steps:,} steps: {text}", console=self._console)


def progress_text(progress: TrainingProgress) -> str:
    """The progress of a training in words."""
    success = "no episode has ended yet" if math.isnan(progress.success) else f"success {progress.success:.1%}"
    stage = f"{progress.stage}: " if progress.stage else ""
    least = f"least laser reading {progress.min_range * 1e3:.0f} mm"
    return f"{stage}{progress.steps_per_s:,.0f} steps/s, {success}, {least}"
