"""The progress bars of commands that take a while."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn


def percentage_bar(console: Console, **settings: Any) -> Progress:
    """A bar with the share that is done, the time that it took and the time that is left."""
    return _bar(console, TextColumn("{task.percentage:>3.0f}%"), **settings)


def episode_bar(console: Console) -> Progress:
    """A bar that counts episodes."""
    return _bar(console, TextColumn("{task.completed} of {task.total} episodes"))


def _bar(console: Console, amount: TextColumn, **settings: Any) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), amount, TimeElapsedColumn())
    return Progress(*columns, TextColumn("left"), TimeRemainingColumn(), console=console, **settings)
