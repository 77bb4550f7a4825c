"""A training as a job: in its folder where the place shares the driver's disk, else in one that travels as bytes."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from pipenav.backends.simulators import SimulatorSettings
from pipenav.errors import PipenavError
from pipenav.jobs import JobControl, JobStopped
from pipenav.learning.config import TrainConfig
from pipenav.storage.atomic_files import atomic_write_all, prepare_folder
from pipenav.storage.lock import one_writer
from pipenav.storage.temporary import temporary_folder


@dataclass(frozen=True)
class TrainingOrder:
    """A training to begin, or to go on with.

    Attributes:
        config: its configuration.
        folder: its folder on the driver's machine.
        command: the command that asked for it.
        files: where the place has no disk in common with the driver, the folder's files as a zip; None where it has.
    """

    config: TrainConfig
    folder: Path
    command: str
    files: bytes | None = None


class TrainedSummary(NamedTuple):
    """Steps, and seconds without the pauses between resumptions."""

    steps: int
    seconds: float


def order_for(config: TrainConfig, folder: Path, command: str, shares_disk: bool) -> TrainingOrder:
    """The order for a training, with what its folder holds where the place cannot see it."""
    return TrainingOrder(config, folder, command, None if shares_disk else _packed(folder))


def run_training(order: TrainingOrder, control: JobControl) -> bytes:
    """Train, or go on with a training: the function of such a job; it reports (steps, share of successes).

    Raises:
        JobStopped: it was asked to stop, and is saved.
        PipenavError: anything a user can mend.
    """
    if order.files is None:
        with one_writer(order.folder, f"{order.command}, training in {order.folder}"):
            return _train(order, order.folder, control)
    with temporary_folder("training") as folder:
        _unpack(order.files, folder)
        return _train(order, folder, control)


def _train(order: TrainingOrder, path: Path, control: JobControl) -> bytes:
    from pipenav.learning.train import train
    from pipenav.learning.training_folder import TrainingFolder

    config = order.config
    simulator = SimulatorSettings(config.backend, config.options).on_cores(control.cores)
    config = config.model_copy(update={"options": dict(simulator.options)})
    resumed = TrainingFolder(path).checkpoint.exists()
    folder = TrainingFolder.open(path).folder if resumed else TrainingFolder.create(path, config, order.command)
    summary = train(config, folder, resumed, lambda now: control.report((now.steps, now.success)), control.should_stop)
    files = b"" if order.files is None else _packed(path)
    if summary.stopped:
        raise JobStopped(files)
    return json.dumps({"steps": summary.steps, "seconds": summary.seconds}).encode() + b"\n" + files


def take_training(order: TrainingOrder, content: bytes) -> TrainedSummary:
    """Put what a training returned into its folder, where it is not there yet; its steps and seconds."""
    summary, _, files = content.partition(b"\n")
    take_files(order, files)
    return TrainedSummary(**json.loads(summary))


def take_files(order: TrainingOrder, files: bytes) -> None:
    """Put the files of a training that was elsewhere into its folder."""
    if files:
        _unpack(files, order.folder)


def _packed(folder: Path) -> bytes:
    """The files of a folder as a zip, without hidden ones; an empty zip where there is no folder."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for file in sorted(folder.iterdir()) if folder.is_dir() else []:
            if file.is_file() and not file.name.startswith("."):
                archive.write(file, file.name)
    return packed.getvalue()


def _unpack(files: bytes, folder: Path) -> None:
    """Write the files of a zip, each of which must lie in the folder itself."""
    prepare_folder(folder)
    with zipfile.ZipFile(io.BytesIO(files)) as archive:
        names = archive.namelist()
        if any(Path(name).name != name for name in names):
            raise PipenavError(f"what came back of the training for {folder} has files that lie elsewhere.")
        if names:
            atomic_write_all({folder / name: archive.read(name) for name in names})
