"""`pipenav presets`."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from pipenav.learning.config import load_config, preset_names


def presets() -> None:
    """List the training presets, one line each.

    Example:

        pipenav train --preset thesis-torque
    """
    table = Table("preset", "robot", "control", "steps", "what it trains", box=None)
    for name in preset_names():
        config = load_config(name)
        table.add_row(name, config.robot, config.task.control, f"{config.steps:,}", config.description)
    Console().print(table)
