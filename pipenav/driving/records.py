"""The records of driven episodes, as written to drive.json; docs/formats/drive-folder.md describes the format."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from pipenav.arrays import Table
from pipenav.errors import ConfigError, PipenavError
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.text_files import checked_json, read_text

RECORDS = "drive.json"
MAX_RECORDS = 64 << 20
"""Largest drive.json that is read [bytes]; that of 100,000 episodes has 40 MB."""


class EpisodeRecord(Table):
    """A driven episode.

    Attributes:
        pipe: the pipe, in words that `--pipes` takes.
        number: number of the episode in this pipe.
        outcome: how it ended, by the names of `pipenav.tasks.outcome`; `ended` where the person ended it.
        passed: whether it succeeded.
        seconds: how long it took [s].
        takeovers: how often the person took over from the policy.
        person_share: share of the control steps that the person drove.
        peak_force_n: largest contact force [N].
        penetration_m: deepest overlap with the wall [m].
        largest_jump: largest change of a command between two control steps, in the limit of one step.
    """

    pipe: str
    number: int = Field(ge=0)
    outcome: str
    passed: bool
    seconds: float = Field(ge=0)
    takeovers: int = Field(ge=0)
    person_share: float = Field(ge=0, le=1)
    peak_force_n: float = Field(ge=0)
    penetration_m: float = Field(ge=0)
    largest_jump: float = Field(ge=0)


class DriveRecords(Table):
    """All episodes of a session.

    Attributes:
        schema_version: version of the format, 1; the key is `schema`.
        robot: name of the robot.
        policy: name of the policy or baseline that drove while the operator did not; None without one.
        operator: `person`, `scripted`, or `none` where the policy drove alone.
        input: device of a person; None for others.
        backend: name of the simulator.
        seed: seed of all starts and targets.
        disturb: name or file of the disturbances; None for none.
        episodes: the episodes, in the order in which they ended.
    """

    schema_version: Literal[1] = Field(1, alias="schema")
    robot: str
    policy: str | None
    operator: Literal["person", "scripted", "none"]
    input: str | None
    backend: str
    seed: int
    disturb: str | None
    episodes: tuple[EpisodeRecord, ...] = Field(strict=False)

    @property
    def driver(self) -> str:
        """Words for who drove."""
        hands = {"person": f"by hand, {self.input}", "scripted": "scripted operator", "none": ""}[self.operator]
        return " + ".join(filter(None, [self.policy, hands]))


def write_records(folder: Path, records: DriveRecords) -> None:
    """Write the records of a session, whole or not at all.

    Raises:
        FileProblem: the file cannot be written.
    """
    atomic_write(folder / RECORDS, (records.model_dump_json(by_alias=True, indent=1) + "\n").encode())


def read_records(folder: Path) -> DriveRecords:
    """The records in a folder, or in a file of the format of drive.json.

    Raises:
        FileProblem: they cannot be read.
        ConfigError: the file holds no such records.
        PipenavError: they hold no episode.
    """
    file = folder / RECORDS if folder.is_dir() else folder
    try:
        text = checked_json(read_text(file, MAX_RECORDS), str(file))
        records = DriveRecords.model_validate_json(text)
    except ValidationError as error:
        raise ConfigError.from_validation(str(file), error, DriveRecords.model_fields) from error
    if not records.episodes:
        raise PipenavError(f"{file} holds no episode: drive one to its end with pipenav drive.")
    return records


def matched(sessions: Sequence[DriveRecords]) -> list[list[EpisodeRecord]]:
    """The episodes that all sessions drove, those of each session in the same order.

    Raises:
        PipenavError: the sessions have other robots, seeds or disturbances, or no episode in common.
    """
    for key in ("robot", "seed"):
        values = {str(getattr(session, key)) for session in sessions}
        if len(values) > 1:
            raise PipenavError(
                f"these sessions differ in their {key} ({', '.join(sorted(values))}): compare those that drove the "
                "same numbered pipes."
            )
    numbered = [{(e.pipe, e.number): e for e in session.episodes} for session in sessions]
    common = sorted(set.intersection(*(set(episodes) for episodes in numbered)))
    if not common:
        raise PipenavError("these sessions have no episode in common: drive the same --pipes with the same --seed.")
    return [[episodes[key] for key in common] for episodes in numbered]
