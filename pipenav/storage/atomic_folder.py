"""Folders that appear complete or not at all, and their JSON record, in SI units and in units for people."""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any

from pipenav.errors import ConfigError, FileProblem, PipenavError, shown
from pipenav.storage.atomic_files import sync_files, sync_folder
from pipenav.storage.drafts import clear_drafts, draft_path, replaced_path
from pipenav.storage.exchange import exchange
from pipenav.storage.text_files import read_json


def write_folder(folder: Path, kind: str, record: str, files: Collection[str], write: Callable[[Path], None]) -> None:
    """Write a folder, complete or not at all, in place of an older one of its kind, or of an empty one.

    Files that others put into the older folder are kept. A process that is killed leaves the older folder or the new
    one, whole.

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
    draft = draft_path(folder.parent)
    try:
        clear_drafts(folder.parent)
        if folder.is_symlink() or (folder.exists() and not _replaceable(folder, record)):
            raise PipenavError(f"{folder} exists and is not a {kind}: move it away or choose another place.")
        draft.mkdir(parents=True)
        write(draft)
        sync_files(draft)
        if folder.exists():
            _keep_others(folder, draft, files)
            _replace(folder, draft)
        else:
            draft.rename(folder)
        sync_folder(folder.parent)
    except OSError as error:
        raise FileProblem(folder, "write", error) from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _replaceable(folder: Path, record: str) -> bool:
    return (folder / record).is_file() or (folder.is_dir() and not any(folder.iterdir()))


def _keep_others(older: Path, draft: Path, files: Collection[str]) -> None:
    """Give the draft all that others put into the older folder, which keeps it too: nothing is lost at any moment."""
    for path in older.iterdir():
        if path.name in files:
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.copytree(path, draft / path.name, symlinks=True, copy_function=_link_or_copy)
        else:
            _link_or_copy(path, draft / path.name)


def _link_or_copy(source: str | Path, target: str | Path) -> None:
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:  # a file system without links
        shutil.copy2(source, target, follow_symlinks=False)


def _replace(older: Path, draft: Path) -> None:
    """Put the finished draft in the older folder's place; the older one is at the draft's place then, or gone."""
    if exchange(draft, older):
        return
    aside = replaced_path(older)  # two steps: after a kill between them, clear_drafts puts the older folder back
    older.rename(aside)
    try:
        draft.rename(older)
    except OSError:
        aside.rename(older)
        raise
    shutil.rmtree(aside, ignore_errors=True)


def write_record(file: Path, record: dict[str, Any]) -> None:
    """Write the JSON record of a folder."""
    file.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")


def read_record(file: Path, kind: str, schemas: Sequence[int], keys: Sequence[str]) -> dict[str, Any]:
    """The JSON record of a folder, with a version and some keys that it must have.

    Args:
        file: path of the record.
        kind: word for the file in messages: `pipe file`.
        schemas: versions that can be read.
        keys: keys that the record must have.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no such file of this version.
    """
    record = read_json(file)
    if not isinstance(record, dict) or "schema" not in record:
        raise ConfigError(f"{file} is not a {kind}: it has no 'schema'.")
    if record["schema"] not in schemas:
        *others, last = map(str, schemas)
        known = f"{', '.join(others)} and {last}" if others else last
        raise ConfigError(f"{file} has schema {shown(record['schema'])}: this version of pipenav reads schema {known}.")
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
