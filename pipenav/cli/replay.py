"""`pipenav replay`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pipenav.cli.terminal import say
from pipenav.errors import PipenavError, shown


def replay(
    log: Annotated[Path, typer.Argument(help="telemetry.jsonl of a mission.", show_default=False)],
    draw: Annotated[Path | None, typer.Option(help="Write the mission's picture here, as PNG.")] = None,
) -> None:
    """Repeat a recorded mission's arithmetic and compare every reading, action and packet bit for bit.

    Examples:

        pipenav replay runs/real-1/telemetry.jsonl

        pipenav replay runs/real-1/telemetry.jsonl --draw mission.png
    """
    from pipenav.deployment.picture import mission_picture
    from pipenav.deployment.plan import POLICY_COPY
    from pipenav.deployment.replay import replay as replayed
    from pipenav.policies.policy import load_policy
    from pipenav.storage.atomic_files import atomic_write, check_outputs

    if draw is not None:
        check_outputs([draw], inputs=[log, log.with_name(POLICY_COPY)])
        if draw.suffix.lower() != ".png":
            raise PipenavError(f"{draw}: the picture is a PNG, give --draw a name ending in .png.")
    result = replayed(log)
    recording = result.recording
    if draw is not None:
        robot = load_policy(log.with_name(POLICY_COPY)).header.robot
        end = recording.end or {"end": "cut short"}
        ended = shown(end.get("cause") or end["end"], quoted=False)
        atomic_write(
            draw,
            mission_picture(robot, recording.ticks[: result.ticks], f"{robot.name}: {ended}, {result.ticks} ticks"),
        )
    if result.difference:
        changed = "the log, the policy or pipenav has changed since: replay with the version that recorded it"
        raise PipenavError(f"the replay differs: {result.difference}; {changed}.")
    say(f"{result.ticks} ticks, {result.packets} packets: all identical")
