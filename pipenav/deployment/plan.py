"""The plan of a mission, and the folder that it is written into."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.locating.locator import Exit
from pipenav.policies.policy import Policy

TELEMETRY, PICTURE, PAGE = "telemetry.jsonl", "run.png", "report.html"
POLICY_COPY = "policy.zip"
"""Copy of the policy, beside the telemetry of the mission that it served."""


class MissionPlan(NamedTuple):
    """The plan of a mission.

    Attributes:
        policy: the policy that reaches the target.
        exit_: the exit that the arm takes.
        target: target in the robot's own frame, (2,) [m]; None to look for one.
        retreat: whether to back out when it is not found or not reached.
        folder: mission folder, where telemetry, policy and picture go.
        stop_file: a file whose appearance is an emergency stop.
        most_ticks: number of ticks after which the mission ends; None for no such end.
    """

    policy: Policy
    exit_: Exit
    target: Floats | None
    retreat: bool
    folder: Path
    stop_file: Path
    most_ticks: int | None = None


def check_stop_file(path: Path) -> None:
    """Refuse a file of the emergency stop that could not appear, or that would stop the arm at once.

    Raises:
        PipenavError: its folder is missing, or the file is there.
    """
    if path.exists():
        raise PipenavError(f"the stop file {path} is there already: remove it, or choose another.")
    if not path.parent.is_dir():
        raise PipenavError(f"there is no folder {path.parent} for the stop file {path.name}: make it first.")


def free_folder(given: Path | None) -> Path:
    """Path of a new mission's folder, which is yet to be made.

    It is the given one, which must hold no mission yet, or the next free one under `runs/`.

    Raises:
        PipenavError: the given folder holds a mission already.
    """
    if given is not None:
        if (given / TELEMETRY).exists():
            raise PipenavError(f"{given} holds a mission already: give another folder with --out.")
        return given
    number = 1
    while (folder := Path("runs") / f"real-{number}").exists():
        number += 1
    return folder
