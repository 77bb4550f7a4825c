"""The folder of a training: every file appears whole or not at all."""

from __future__ import annotations

import csv
import io
import json
import shlex
from pathlib import Path
from typing import Any, NamedTuple

from pipenav.errors import PipenavError
from pipenav.learning.config import TrainConfig, validate_config
from pipenav.learning.progress import PROGRESS_COLUMNS, progress_rows, read_progress
from pipenav.storage.atomic_files import atomic_write, prepare_folder
from pipenav.storage.text_files import MAX_SETTINGS, read_json


class TrainingFolder:
    """Names and writing of a training's files."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.best, self.last = path / "best.zip", path / "last.zip"
        self.config, self.command = path / "config.json", path / "command.txt"
        self.progress, self.plot = path / "progress.csv", path / "training.png"
        self.checks, self.page = path / "checks.json", path / "report.html"
        self.checkpoint, self.diverged = path / "resume.safetensors", path / "diverged.json"
        self._rows: list[dict[str, Any]] = []

    @classmethod
    def create(cls, path: Path, config: TrainConfig, command: str) -> TrainingFolder:
        """The folder of a new training.

        A folder that already holds one is refused, but not what a training left that never came to save.
        """
        folder = cls(path)
        folder.refuse_other_training()
        prepare_folder(path)
        folder.write_config(config)
        atomic_write(folder.command, command + "\n")
        return folder

    def remove_unsaved(self) -> None:
        """Empty the folder of a training that never came to save."""
        if not self.checkpoint.exists():
            self.config.unlink(missing_ok=True)
            self.command.unlink(missing_ok=True)

    @classmethod
    def open(cls, path: Path) -> OpenedTraining:
        """A training that has been saved, with its configuration.

        Raises:
            PipenavError: the folder holds no training, or files of it are damaged.
        """
        folder = cls(path)
        if not folder.config.is_file() or not folder.checkpoint.is_file():
            raise PipenavError(f"{path} holds no training: it needs config.json and resume.safetensors.")
        table = read_json(folder.config, MAX_SETTINGS)
        if folder.progress.is_file():
            folder._rows = list(progress_rows(read_progress(folder.progress)))
        return OpenedTraining(folder, validate_config(table, str(folder.config)))

    def refuse_other_training(self) -> None:
        """Refuse a new training where the folder already holds one.

        Raises:
            PipenavError: it does.
        """
        if self.checkpoint.exists():
            raise PipenavError(
                f"{self.path} already holds a training: continue it with --resume {shlex.quote(str(self.path))}, "
                "or choose another --out."
            )
        if any(file.exists() for file in (self.best, self.last, self.diverged)):
            raise PipenavError(f"{self.path} already holds a training: choose another --out.")

    def write_config(self, config: TrainConfig) -> None:
        atomic_write(self.config, json.dumps(config.model_dump(mode="json"), indent=2) + "\n")

    def add_progress(self, row: dict[str, Any]) -> None:
        """Remember a row of progress.csv; `write_progress` writes them all."""
        self._rows.append(row)

    def write_progress(self) -> None:
        text = io.StringIO()
        writer = csv.DictWriter(text, PROGRESS_COLUMNS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(self._rows)
        atomic_write(self.progress, text.getvalue())


class OpenedTraining(NamedTuple):
    """A training that has been saved: its folder and its configuration."""

    folder: TrainingFolder
    config: TrainConfig


def default_training_path(preset: str, root: Path = Path("runs")) -> Path:
    """`runs/<preset>`, or the same with a number behind it where that is taken."""
    path, number = root / preset, 1
    while path.exists():
        number += 1
        path = root / f"{preset}-{number}"
    return path
