"""Folders that appear complete or not at all, and their JSON record, in SI units and in units for people."""

from __future__ import annotations

import json
import math
import shutil
import uuid
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any

from pipenav.errors import ConfigError, FileProblem, PipenavError, shown
from pipenav.storage.text_files import read_json


def write_folder(folder: Path, kind: str, record: str, files: Collection[str], write: Callable[[Path], None]) -> None:
    """Write a folder, complete or not at all, in place of an older one of its kind.

    Files that others put into the older folder are kept.

    Args:
        folder: path of the folder; folders above it are made.
        kind: word for the folder in messages: `pipe folder`.
        record: name of the file that every folder of this kind has.
        files: names of all files that folders of this kind may have; the older folder's files of these names go.
        write: function that writes the files into the empty folder that it is given.

    Raises:
        FileProblem: the folder cannot be written.
        PipenavError: something else has that name.
    """
    mark = uuid.uuid4().hex[:8]
    draft, old = (folder.with_name(f".{folder.name}-{mark}-{part}") for part in ("new", "old"))
    try:
        if folder.is_symlink() or (folder.exists() and not (folder / record).is_file()):
            raise PipenavError(f"{folder} exists and is not a {kind}: move it away or choose another place.")
        draft.mkdir(parents=True)
        write(draft)
        _swap(draft, folder, old, files)
    except OSError as error:
        raise FileProblem(folder, "write", error) from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _swap(draft: Path, folder: Path, old: Path, files: Collection[str]) -> None:
    """Put the finished draft in the folder's place; the older folder passes through `old`."""
    if not folder.exists():
        draft.rename(folder)
        return
    folder.rename(old)
    try:
        draft.rename(folder)
    except OSError:
        old.rename(folder)
        raise
    for path in old.iterdir():
        if path.name not in files:
            path.rename(folder / path.name)
    shutil.rmtree(old)


def write_record(file: Path, record: dict[str, Any]) -> None:
    """Write the JSON record of a folder."""
    file.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")


def read_record(file: Path, kind: str, schema: int, keys: Sequence[str]) -> dict[str, Any]:
    """The JSON record of a folder, with a version and some keys that it must have.

    Args:
        file: path of the record.
        kind: word for the file in messages: `pipe file`.
        schema: version that can be read.
        keys: keys that the record must have.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no such file of this version.
    """
    record = read_json(file)
    if not isinstance(record, dict) or "schema" not in record:
        raise ConfigError(f"{file} is not a {kind}: it has no 'schema'.")
    if record["schema"] != schema:
        raise ConfigError(
            f"{file} has schema {shown(record['schema'])}: this version of pipenav reads schema {schema}."
        )
    missing = [key for key in keys if key not in record]
    if missing:
        raise ConfigError(f"{file} lacks {', '.join(missing)}: make the folder again with gen-pipe.")
    return record


def refuse_contradictions(file: Path, record: Any, expected: Any) -> None:
    """Refuse a record that was edited by hand in the units for people alone, as in `diameter_mm` beside `diameter_m`.

    Args:
        file: path of the record, for the message.
        record: record as it was read.
        expected: record as it is written for the pipe that was read from it.

    Raises:
        ConfigError: numbers in mm or deg that are not those in SI units.
    """
    if isinstance(expected, list):
        for ours, theirs in zip(record if isinstance(record, list) else [], expected, strict=False):
            refuse_contradictions(file, ours, theirs)
    if not isinstance(expected, dict) or not isinstance(record, dict):
        return
    for key, value in expected.items():
        given = record.get(key, value)
        if not key.endswith(("_mm", "_deg")):
            refuse_contradictions(file, given, value)
        elif not _close(given, value):
            expected_text = f"{value:g}" if isinstance(value, float) else value
            raise ConfigError(
                f"{file}: {key} {shown(given)} contradicts the same length or angle in SI units, {expected_text}."
            )


def _close(given: Any, value: float | list[float]) -> bool:
    if isinstance(value, list):
        return isinstance(given, list) and len(given) == len(value) and all(map(_close, given, value))
    return isinstance(given, int | float) and math.isclose(given, value, abs_tol=1e-9)
