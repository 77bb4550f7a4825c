"""`pipenav presets`."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from pipenav.cli.terminal import show
from pipenav.learning.config import load_config, preset_names


def presets() -> None:
    """List the training presets, one line each.

    Example:

        pipenav train --preset thesis-torque
    """
    show(presets_table())


def presets_table() -> Table:
    """The training presets, a row each."""
    table = Table("preset", "robot", "control", "steps", "what it trains", box=None, pad_edge=False)
    for name in preset_names():
        config = load_config(name)
        steps = f"{config.steps:,}" + (f" in {len(config.stages)} stages" if config.stages else "")
        table.add_row(Text(name, "bold"), config.robot, config.task.control, steps, Text(config.description))
    return table
