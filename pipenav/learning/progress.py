"""The progress of a training: its report after each update, and the rows and columns of progress.csv."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path
from typing import NamedTuple

from pipenav.errors import ConfigError
from pipenav.storage.text_files import MAX_TABLE, read_text

PROGRESS_COLUMNS = (
    "steps",
    "seconds",
    "steps_per_s",
    "success",
    "min_range_m",
    "reward",
    "episode_steps",
    "std",
    "check_success",
    "stage",
    "policy_loss",
    "value_loss",
)

MAX_ROWS, MAX_COLUMNS = 100_000, 50
"""Most rows and columns of a progress.csv: a row for each update, of three thousand control steps at the least."""

EARLIER_COLUMNS = {"clearance_m": "min_range_m", "eval_success": "check_success"}
"""Names that columns of progress.csv had earlier, and the ones that they have today."""


class TrainingProgress(NamedTuple):
    """Progress of a training, reported after each update.

    Attributes:
        stage: words that name the stage; empty where the training has no stages.
        steps: control steps so far.
        steps_per_s: control steps per second since the last report.
        success: share of the episodes since the last report that reached their target; NaN without any.
        min_range: mean over steps of the smallest laser reading [m].
        check_success: success of the last noise-free check; NaN before the first.
        check_steps, check_seconds: control steps, and seconds of training, at the beginning of that check.
        imitated: share of the supervised start that is done; NaN after it, and where there is none.
    """

    stage: str
    steps: int
    steps_per_s: float
    success: float
    min_range: float
    check_success: float
    check_steps: int = 0
    check_seconds: float = math.nan
    imitated: float = math.nan


def read_progress(path: Path) -> str:
    """Text of a progress.csv, for `progress_rows` and `progress_columns`.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it is not the table of a training: no text, or far too large.
    """
    text = read_text(path, MAX_TABLE)
    rows, columns = text.count("\n"), text.partition("\n")[0].count(",") + 1
    if rows > MAX_ROWS or columns > MAX_COLUMNS:
        raise ConfigError(
            f"{path} has {rows:,} rows of {columns:,} columns: a training's has at most {MAX_ROWS:,} of {MAX_COLUMNS}."
        )
    try:
        list(csv.reader(io.StringIO(text, newline="")))
    except csv.Error as error:
        raise ConfigError(f"{path} is not the table of a training: {error}.") from error
    return text


def progress_rows(text: str) -> list[dict[str, str | None]]:
    """The rows of a progress.csv, cells by the names that columns have today; None where a row breaks off."""
    return [
        {EARLIER_COLUMNS.get(name, name): cell for name, cell in row.items() if name is not None}
        for row in csv.DictReader(io.StringIO(text, newline=""))
    ]


def progress_columns(text: str) -> dict[str, list[float]]:
    """The columns of a progress.csv; NaN where a cell is empty or no number. Broken rows are left out."""
    rows = [
        row for row in progress_rows(text) if None not in row.values() and not math.isnan(_number(row.get("steps")))
    ]
    return {name: [_number(row.get(name)) for row in rows] for name in _names(text)}


def _names(text: str) -> list[str]:
    """The names that the file's columns have today."""
    return [EARLIER_COLUMNS.get(name, name) for name in next(csv.reader(io.StringIO(text, newline="")), [])]


def _number(cell: str | None) -> float:
    try:
        value = float(cell or "nan")
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan
