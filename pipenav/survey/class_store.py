"""Results about classes on disk, each a JSON file together with everything that decides it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import ValidationError

from pipenav.arrays import Table
from pipenav.errors import PipenavError
from pipenav.storage.atomic_files import atomic_write, prepare_folder
from pipenav.storage.text_files import read_text
from pipenav.survey.classes import FittingClass

Result = TypeVar("Result", bound=Table)

MAX_RESULT = 64 << 10
"""Largest file of a result [bytes]."""


def default_cache() -> Path:
    """Folder of results where no other is named: `pipenav/trials` in the user's folder for caches."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "pipenav" / "trials"


class ClassStore(Generic[Result]):
    """Results about classes, in a folder that any number of surveys share.

    Args:
        folder: the folder, which is made when there is something to keep.
        name: name of the result within a file, such as `trial`.
        table: table of a result.
    """

    def __init__(self, folder: Path, name: str, table: type[Result]) -> None:
        self._folder, self._name, self._table = folder, name, table

    def read(self, kind: FittingClass, key: Mapping[str, Any]) -> Result | None:
        """The result about a class that a key decides; None where there is none that can be read."""
        file = self._file(kind, key)
        if not file.is_file():
            return None
        try:
            record = json.loads(read_text(file, MAX_RESULT))
            return self._table.model_validate(record[self._name]) if record["key"] == key else None
        except (PipenavError, ValueError, KeyError, TypeError, ValidationError):
            return None  # it is found anew

    def keep(self, kind: FittingClass, key: Mapping[str, Any], result: Result) -> None:
        """Keep the result about a class.

        Raises:
            FileProblem: it cannot be written.
        """
        record = {"key": key, self._name: result.model_dump()}
        path = prepare_folder(self._folder) / self._file(kind, key).name
        atomic_write(path, json.dumps(record, indent=1) + "\n")

    def _file(self, kind: FittingClass, key: Mapping[str, Any]) -> Path:
        text = json.dumps(key, sort_keys=True)
        return self._folder / f"{kind.name}-{hashlib.sha256(text.encode()).hexdigest()[:16]}.json"
