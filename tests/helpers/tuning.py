"""Searches whose trainings take a second."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

from helpers.tiny_training import TINY
from pipenav.tuning.objective import Check, Objective, Outcome
from pipenav.tuning.plan import BaseTraining, TunePlan, checked_plan
from pipenav.tuning.space import SearchSpace, value_text

TINY_SETTINGS = [f"{key}={value_text(value)}" for key, value in TINY.items()] + ["task.max_steps=20", "check.every=256"]
"""Settings for `--set`: few robots, one pipe, short episodes."""

STEPS = 512

RANGES: dict[str, Any] = {
    "learner.learning_rate": {"low": 1e-4, "high": 1e-2, "log": True},
    "learner.epochs": {"low": 1, "high": 3},
    "network.policy": {"choices": [[16], [16, 16], [64, 64]]},
}
"""A range of each kind; the preset's own values lie in them."""

SPACE_TOML = """
description = "a tiny search"

[space]
learner.learning_rate = { low = 1e-4, high = 1e-2, log = true }
learner.epochs = { low = 1, high = 3 }
"""


def space(**ranges: Any) -> SearchSpace:
    """A search space with the ranges given, or with `RANGES`."""
    return SearchSpace.model_validate({"description": "tiny", "space": ranges or RANGES})


def tiny_plan(out: Path, trials: int = 3, again: int = 0, **more: Any) -> TunePlan:
    """A search of trainings that take a second.

    Args:
        out: folder of the search.
        trials, again: see `TunePlan`.
        more: `objective`, `space`, `steps`, or further `settings`.
    """
    settings = [*TINY_SETTINGS, *more.get("settings", [])]
    base = BaseTraining(more.get("space", space()), None, settings, more.get("steps", STEPS), 0)
    return checked_plan(base, more.get("objective", Objective(name="success")), trials, again, out)


def outcome(*success: float, every: int = 100) -> Outcome:
    """An outcome with checks every so many steps, at one step a second."""
    checks = [Check((i + 1) * every, float((i + 1) * every), share) for i, share in enumerate(success)]
    return Outcome(checks=tuple(checks), steps=len(checks) * every, seconds=float(len(checks) * every))


def workers_of(process: subprocess.Popen[Any] | int) -> list[int]:
    """Process numbers of a driver's workers."""
    number = process if isinstance(process, int) else process.pid
    return [int(word) for word in Path(f"/proc/{number}/task/{number}/children").read_text().split()]


def copied(folder: Path, to: Path) -> Path:
    """A copy of a folder, to go on from twice."""
    return Path(shutil.copytree(folder, to))
