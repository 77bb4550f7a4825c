"""The log of a mission: one line of JSON per tick, written as the tick ends, so that a killed process loses none.

`docs/formats/telemetry.md` describes the format. Floats are written so that reading them gives the same bits.
"""

from __future__ import annotations

import contextlib
import io
import json
from codecs import BOM_UTF8
from collections import deque
from collections.abc import Mapping
from io import FileIO
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

from pipenav.errors import ConfigError, FileProblem, PipenavError
from pipenav.storage.text_files import as_text, parse_json, read_bytes

SCHEMA = 2
"""Version of the format; in version 2 the sessions of `pipenav drive` hold observations, actions and rewards."""

READABLE = (1, 2)
"""Versions that are read."""

REMEMBERED = 50
"""Number of ticks kept at hand for a message about a stop."""

MAX_BYTES = 48 << 20
"""Largest log that is read [bytes]: half an hour of ticks, of 2.7 kB each."""

MAX_LINE = 256 << 10
"""Longest line that is read [bytes]: a hundred times a tick."""


class TelemetryFileError(PipenavError):
    """A telemetry file that cannot be used."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"telemetry {path} {problem}: give a telemetry.jsonl that pipenav run-real or drive wrote.")


class Telemetry:
    """Writes the log; a context manager that closes it.

    Attributes:
        path: the log's file, which `begin` makes.
        last: the newest ticks.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.last: deque[dict[str, Any]] = deque(maxlen=REMEMBERED)
        self._file: FileIO | None = None
        self._problem: FileProblem | None = None
        self._ended = False

    def begin(self, header: Mapping[str, Any]) -> None:
        """Make the file and write its header.

        Raises:
            FileProblem: the file exists already, or cannot be written.
        """
        try:
            self._file = FileIO(self.path, "x")  # without a buffer, which would be full and raise once more at the end
        except OSError as error:
            raise FileProblem(self.path, "write", error) from error
        self._write({"pipenav_telemetry": SCHEMA, **header})

    def tick(self, record: dict[str, Any]) -> None:
        """Write the record of a tick.

        Raises:
            FileProblem: it cannot be written; then nothing is written any more.
        """
        self.last.append(record)
        self._write(record)

    def end(self, outcome: str, cause: str | None, message: str) -> None:
        """Write how the mission ended, as far as the log was begun and can be written; the first end counts.

        Raises:
            FileProblem: the end, and nothing before it, cannot be written.
        """
        if self._file is None or self._problem is not None or self._ended:
            return
        self._ended = True
        self._write({"end": outcome, "cause": cause, "message": message})

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._file is not None:
            with contextlib.suppress(OSError):
                self._file.close()

    def _write(self, record: Mapping[str, Any]) -> None:
        assert self._file is not None, "a log begins with its header"
        if self._problem is not None:
            raise self._problem
        left = json.dumps(record).encode("ascii") + b"\n"
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            self._problem = FileProblem(self.path, "write", error)
            raise self._problem from error


class Recording(NamedTuple):
    """A log as it was read: header, ticks, and the end, which is missing where the process was killed."""

    header: dict[str, Any]
    ticks: list[dict[str, Any]]
    end: dict[str, Any] | None


def read_telemetry(path: Path) -> Recording:
    """Read a log; a last line that was cut short is left out.

    Raises:
        FileProblem: the file cannot be read.
        TelemetryFileError: the file is no telemetry, or a line of it is damaged.
    """
    try:
        content = read_bytes(path, MAX_BYTES).removeprefix(BOM_UTF8)
    except ConfigError as error:
        problem = str(error).removeprefix(str(path)).partition(": ")[0].strip(" .")
        raise TelemetryFileError(path, problem) from error
    header: dict[str, Any] | None = None
    end: dict[str, Any] | None = None
    ticks: list[dict[str, Any]] = []
    for number, line in enumerate(io.BytesIO(content[: content.rfind(b"\n") + 1]), start=1):
        if not line.strip():
            continue
        if end is not None:
            raise TelemetryFileError(path, f"goes on after its end, in line {number}")
        record = _record(path, number, line)
        if header is None:
            header = _header(path, record)
        elif "end" in record:
            end = record
        elif record.get("tick") != len(ticks) or not isinstance(record.get("raw"), dict):
            raise TelemetryFileError(path, f"misses tick {len(ticks)}")
        else:
            ticks.append(record)
    return Recording(_header(path, header or {}), ticks, end)


def _record(path: Path, number: int, line: bytes) -> dict[str, Any]:
    """A line of the log, a table."""
    try:
        record = parse_json(as_text(line, "the line") if len(line) <= MAX_LINE else "", "the line")
    except ConfigError:
        record = None
    if not isinstance(record, dict):
        raise TelemetryFileError(path, f"is damaged in line {number}")
    return record


def _header(path: Path, record: dict[str, Any]) -> dict[str, Any]:
    """The first line of a log of the version that can be read."""
    if record.get("pipenav_telemetry") not in READABLE:
        raise TelemetryFileError(path, f"does not begin with a header of version {' or '.join(map(str, READABLE))}")
    return record
