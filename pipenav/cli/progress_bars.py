"""The progress bars of commands that take a while, on stderr."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

FINALISING = "finalising"


class TimeLeftColumn(ProgressColumn):
    """The time that is left; at the end of the steps, what is done then may take a while: `finalising`."""

    max_refresh = 0.5

    def __init__(self) -> None:
        super().__init__()
        self._remaining = TimeRemainingColumn()
        self.over = False

    def render(self, task: Task) -> Text:
        if self.over:
            return Text("")
        if task.finished:
            return Text(FINALISING)
        return Text.assemble("left ", self._remaining.render(task))


class WorkBar(Progress):
    """A progress bar that says `finalising` between the last step and its end."""

    def stop(self) -> None:
        for column in self.columns:
            if isinstance(column, TimeLeftColumn):
                column.over = True
        super().stop()


def percentage_bar(console: Console, **settings: Any) -> Progress:
    """A bar with the share that is done, the time that it took and the time that is left."""
    return _bar(console, TextColumn("{task.percentage:>3.0f}%"), **settings)


def episode_bar(console: Console, counted: str = "episodes") -> Progress:
    """A bar that counts episodes, or something else."""
    return _bar(console, TextColumn(f"{{task.completed}} of {{task.total}} {counted}"))


def _bar(console: Console, amount: TextColumn, **settings: Any) -> Progress:
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), amount, TimeElapsedColumn())
    return WorkBar(*columns, TimeLeftColumn(), console=console, **settings)
