"""The log of a run on an arm: one line of JSON per tick, written as the tick ends, so that a killed run loses none.

`docs/telemetry.md` describes the format. Floats are written so that reading them gives the same bits.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

from pipenav.errors import FileProblem, PipenavError

SCHEMA = 1
REMEMBERED = 50
"""Ticks kept at hand for a message about a stop."""

MAX_BYTES = 1 << 30
"""A day of ticks."""


class TelemetryFileError(PipenavError):
    """A telemetry file that cannot be used."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"telemetry {path} {problem}: give a telemetry.jsonl that pipenav run-real wrote.")


class Telemetry:
    """Writes the log; a context manager.

    Attributes:
        last: the newest ticks.
    """

    def __init__(self, path: Path, header: Mapping[str, Any]) -> None:
        self.path = path
        self.last: deque[dict[str, Any]] = deque(maxlen=REMEMBERED)
        try:
            self._file = path.open("x", buffering=1, encoding="utf-8")
        except OSError as error:
            raise FileProblem(path, "write", error) from error
        self._write({"pipenav_telemetry": SCHEMA, **header})

    def tick(self, record: dict[str, Any]) -> None:
        self.last.append(record)
        self._write(record)

    def end(self, outcome: str, cause: str | None, message: str) -> None:
        """How the run ended."""
        self._write({"end": outcome, "cause": cause, "message": message})

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def _write(self, record: Mapping[str, Any]) -> None:
        try:
            self._file.write(json.dumps(record) + "\n")
        except OSError as error:
            raise FileProblem(self.path, "write", error) from error


class Recording(NamedTuple):
    """A log as it was read: header, ticks, and the end, which is missing where the run was killed."""

    header: dict[str, Any]
    ticks: list[dict[str, Any]]
    end: dict[str, Any] | None


def read_telemetry(path: Path) -> Recording:
    """Read a log; a last line that was cut short is left out.

    Raises:
        FileProblem: it cannot be read.
        TelemetryFileError: it is no telemetry, or a line of it is damaged.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise FileProblem(path, "read", error) from error
    if len(content) > MAX_BYTES:
        raise TelemetryFileError(path, "is larger than any run's")
    records = []
    for number, line in enumerate(content[: content.rfind(b"\n") + 1].splitlines(), start=1):
        try:
            record = json.loads(line)
        except ValueError:
            record = None
        if not isinstance(record, dict):
            raise TelemetryFileError(path, f"is damaged in line {number}")
        records.append(record)
    if not records or records[0].get("pipenav_telemetry") != SCHEMA:
        raise TelemetryFileError(path, f"does not begin with a header of version {SCHEMA}")
    end = records[-1] if "end" in records[-1] else None
    ticks = records[1:] if end is None else records[1:-1]
    for number, tick in enumerate(ticks):
        if tick.get("tick") != number or "raw" not in tick:
            raise TelemetryFileError(path, f"misses tick {number}")
    return Recording(records[0], ticks, end)
