"""The report of a training as one HTML file, which loads nothing from anywhere: curves, checks, settings, times."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from pipenav.arrays import Floats
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.map_panels import map_panels
from pipenav.evaluation.summary import percent
from pipenav.learning.checks import Check, Checks, read_checks
from pipenav.learning.config import TrainConfig
from pipenav.learning.progress import progress_columns, read_progress
from pipenav.learning.stages import training_stages
from pipenav.learning.training_folder import TrainingFolder
from pipenav.pages.page import filled_page
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.text_files import read_text

TEMPLATE = Path(__file__).with_name("report.html")

MOST_POINTS = 600
"""Most points of a curve; of more updates, each point is the mean of as many that follow each other as needed."""

CURVES = ("success", "min_range_m", "reward", "policy_loss", "value_loss", "episode_steps", "std", "steps_per_s")
"""Columns of progress.csv that are drawn."""

LINKED = {
    "best.zip": "the policy of the best check, to evaluate and to deploy",
    "last.zip": "the newest policy",
    "config.json": "the settings",
    "progress.csv": "all numbers of the curves",
    "checks.json": "all numbers of the checks",
    "training.png": "the curves as a picture",
}
"""Files of the folder that the page links to, each with what it is."""


def write_training_page(path: Path) -> None:
    """Write report.html of a training that has been saved.

    Args:
        path: the training folder.

    Raises:
        PipenavError: the folder holds no training, or files of it are damaged.
    """
    folder, config = TrainingFolder.open(path)
    atomic_write(folder.page, training_page(folder, config))


def training_page(folder: TrainingFolder, config: TrainConfig) -> str:
    """The page of a training, from its folder's progress.csv and checks.json."""
    columns = progress_columns(read_progress(folder.progress))
    checks = read_checks(folder.checks)
    steps = columns.get("steps", [])
    done, seconds = (int(steps[-1]) if steps else 0), _last(columns.get("seconds", []))
    best = max(checks.checks, key=lambda check: (check.success, check.steps), default=None)
    return filled_page(
        TEMPLATE,
        {
            "title": folder.path.resolve().name,
            "subject": _subject(config),
            "command": _command(folder),
            "success": best and percent(best.success),
            "best": best and _best_words(best),
            "steps": done,
            "of": config.steps,
            "time": _duration(seconds),
            "speed": f"{done / seconds:,.0f}" if seconds else "",
            "resume": f"pipenav train --resume {folder.path}" if done < config.steps else "",
            "curves": _curves(columns),
            "averaged": _group(len(steps)),
            "stages": _stages(config, columns),
            "checks": [_check(check) for check in checks.checks],
            "sets": [_pipes(checks, number) for number in range(len(checks.pipe_sets))],
            "settings": _flat(config.model_dump(mode="json")),
            "files": [[name, said] for name, said in LINKED.items() if (folder.path / name).exists()],
        },
    )


def _subject(config: TrainConfig) -> str:
    return (
        f"{config.description.rstrip('.')}; robot {config.robot}, {config.task.kind}, "
        f"pipes {', '.join(config.pipes)}, backend {config.backend}, "
        f"{config.learner.robots} robots at once, seed {config.seed}"
    )


def _command(folder: TrainingFolder) -> str:
    return read_text(folder.command).strip() if folder.command.is_file() else ""


def _best_words(check: Check) -> str:
    """Interval of a check, and when it was made."""
    episodes = check.episodes * len(check.successes)
    low, high = wilson(sum(check.successes), episodes)
    return (
        f"best check, after {check.steps:,} steps: 95 % interval {percent(low)}–{percent(high)} % "
        f"of {episodes:,} episodes"
    )


def _last(values: Sequence[float]) -> float:
    """The last number that is known; 0 without any."""
    return next((value for value in reversed(values) if not math.isnan(value)), 0.0)


def _duration(seconds: float) -> str:
    """A time in words: `5 s`, `3 min 20 s`, `2 h 5 min`."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def _group(rows: int) -> int:
    """Updates that a point of a curve stands for."""
    return max(1, -(-rows // MOST_POINTS))


def _curves(columns: Mapping[str, Sequence[float]]) -> dict[str, list[float | None]]:
    """Means of the columns over groups of rows, None where a group has no number; and the steps at their ends."""
    steps = list(columns.get("steps", []))
    each = _group(len(steps))
    ends = [*range(each, len(steps), each), len(steps)] if steps else []
    curves: dict[str, list[float | None]] = {"steps": [steps[end - 1] for end in ends]}
    for name in CURVES:
        values = np.array(columns.get(name, [math.nan] * len(steps)))
        curves[name] = [_mean(values[begin:end]) for begin, end in pairwise([0, *ends])] if ends else []
    return curves


def _mean(values: Floats) -> float | None:
    known = values[np.isfinite(values)]
    return float(f"{known.mean():.5g}") if len(known) else None


def _stages(config: TrainConfig, columns: Mapping[str, Sequence[float]]) -> list[dict[str, Any]]:
    """The stages that have begun: their names, steps and seconds; none of a training without stages."""
    if not config.stages:
        return []
    number, steps, seconds = (columns.get(name, []) for name in ("stage", "steps", "seconds"))
    found, earlier = [], 0.0
    for stage in training_stages(config):
        rows = [row for row, n in enumerate(number) if n == stage.number]
        if rows:
            took = _last([seconds[row] for row in rows])
            took, earlier = took - earlier, took
            found.append({"name": stage.label, "from": stage.begin, "to": steps[rows[-1]], "time": _duration(took)})
    return found


def _check(check: Check) -> dict[str, Any]:
    low, high = wilson(sum(check.successes), check.episodes * len(check.successes))
    return {
        "steps": check.steps,
        "time": _duration(check.seconds),
        "stage": check.stage,
        "set": check.pipes,
        "each": check.episodes,
        "success": check.success,
        "percent": percent(check.success),
        "low": low,
        "high": high,
        "interval": f"{percent(low)}–{percent(high)}",
        "successes": list(check.successes),
        "failures": {place: counts for place, counts in enumerate(check.failures) if counts},
    }


def _pipes(checks: Checks, number: int) -> dict[str, Any]:
    return {
        "labels": [one.label for one in checks.pipe_sets[number]],
        "panels": map_panels(checks.records(number)),
    }


def _flat(table: Mapping[str, Any], before: str = "") -> list[tuple[str, str]]:
    """Dotted keys of nested tables with their values in words."""
    rows: list[tuple[str, str]] = []
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            rows += _flat(value, f"{before}{key}.")
        elif isinstance(value, list) and value and all(isinstance(one, Mapping) for one in value):
            for one in value:
                rows += _flat(one, f"{before}{key}.{one.get('name', '')}.")
        else:
            rows.append((before + key, _word(value)))
    return rows


def _word(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(_word, value))
    return "" if value is None or value == {} else str(value)
