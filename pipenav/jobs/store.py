"""The results of finished jobs, each a file of its own, so that a driver that is killed loses none of them."""

from __future__ import annotations

import contextlib
import hashlib
import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from pydantic import JsonValue

from pipenav.errors import ConfigError, FileProblem, PipenavError, shown
from pipenav.storage.atomic_files import atomic_write, prepare_folder
from pipenav.storage.text_files import read_json

REQUEST = "request.json"
"""File of a store that says what its jobs are for."""

HEADER = b"pipenav job 1 "
"""Beginning of a result's file; the SHA-256 of the result and a line's end follow, then the result."""


class Store(Protocol):
    """Results of jobs by key, see `JobStore`."""

    def has(self, key: str) -> bool:
        """Whether there is a result of a job."""
        ...

    def read(self, key: str) -> bytes | None:
        """The result of a job; None where there is none."""
        ...

    def write(self, key: str, content: bytes) -> None:
        """Keep the result of a job."""
        ...


class MemoryStore:
    """Results that are kept as long as this process lives."""

    def __init__(self) -> None:
        self._kept: dict[str, bytes] = {}

    def has(self, key: str) -> bool:
        """Whether there is a result of a job."""
        return key in self._kept

    def read(self, key: str) -> bytes | None:
        """The result of a job; None where there is none."""
        return self._kept.get(key)

    def write(self, key: str, content: bytes) -> None:
        """Keep the result of a job."""
        self._kept[key] = content


class JobStore:
    """A folder with the request that jobs belong to, and the results of those that are done.

    The driver alone writes it, so that workers need no disk in common with it; several drivers may, if they have the
    same request and different jobs.

    Args:
        folder: path of the folder, which is made.
        request: everything that decides the results, as JSON.

    Raises:
        PipenavError: the folder holds results for another request.
        FileProblem: it cannot be written.
    """

    def __init__(self, folder: Path, request: Mapping[str, JsonValue]) -> None:
        self.folder = folder
        prepare_folder(folder)
        file = folder / REQUEST
        if file.exists():
            _refuse_other(folder, dict(request))
        else:
            atomic_write(file, json.dumps(request, indent=1) + "\n")

    def has(self, key: str) -> bool:
        """Whether there is a whole result of a job; a damaged one is none."""
        return self.read(key) is not None

    def read(self, key: str) -> bytes | None:
        """The result of a job; None where there is none, or a damaged one.

        Raises:
            FileProblem: the file cannot be read.
        """
        try:
            head, _, content = (self.folder / key).read_bytes().partition(b"\n")
        except FileNotFoundError:
            return None
        except OSError as error:
            raise FileProblem(self.folder / key, "read", error) from error
        return content if head == _head(content) else None

    def write(self, key: str, content: bytes) -> None:
        """Keep the result of a job.

        Raises:
            FileProblem: the file cannot be written.
        """
        atomic_write(self.folder / key, _head(content) + b"\n" + content)

    def remove(self) -> None:
        """Remove the folder with all that it holds, when its results have gone elsewhere."""
        with contextlib.suppress(OSError):
            (self.folder / REQUEST).unlink(missing_ok=True)  # first: what is left after a kill belongs to no request
            shutil.rmtree(self.folder)


def _head(content: bytes) -> bytes:
    return HEADER + hashlib.sha256(content).hexdigest().encode()


def _refuse_other(folder: Path, request: dict[str, Any]) -> None:
    """Refuse a folder whose request differs, with the first difference."""
    try:
        earlier = read_json(folder / REQUEST)
    except ConfigError:
        earlier = None
    if not isinstance(earlier, dict):
        raise PipenavError(f"{folder / REQUEST} is damaged: remove {folder}, and give the command again.")
    for key in [*request, *(key for key in earlier if key not in request)]:
        there, now = earlier.get(key), request.get(key)
        if there != now:
            raise PipenavError(
                f"{folder} holds finished parts of something else ({key} {shown(there)} there, {shown(now)} now): give "
                "the command that made them, choose another --out, or remove that folder."
            )
