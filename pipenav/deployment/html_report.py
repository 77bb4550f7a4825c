"""The report of a mission as one HTML file, which loads nothing from anywhere: its outcome, its timeline, its stops."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.deployment.picture import drawable
from pipenav.deployment.telemetry import Recording
from pipenav.deployment.ticks import servo_health, tick_seconds
from pipenav.deployment.trajectories import ArmPlacement
from pipenav.pages.page import filled_page
from pipenav.robots import frames, kinematics
from pipenav.robots.parts import Joint
from pipenav.robots.robot import RobotSpec
from pipenav.units import m_to_mm, rad_to_deg

TEMPLATE = Path(__file__).with_name("report.html")

MOST_TICKS = 3000
"""Most ticks in a page; of a longer mission some in even steps, and every tick in which something happened."""

FILES = ("telemetry.jsonl", "run.png", "policy.zip", "locate.csv", "front.csv", "back.csv", "bus.jsonl")
"""Files of a mission folder that a page links to where they are there."""

Ticks = Sequence[Mapping[str, Any]]


def mission_page(recording: Recording, robot: RobotSpec, folder: Path, placement: ArmPlacement | None = None) -> str:
    """The page of a mission.

    Args:
        recording: its telemetry.
        robot: its robot.
        folder: its folder, whose files the page links to.
        placement: the pipe around the arm, and where it stands in it; None where that is not known.
    """
    header, all_ticks = recording.header, recording.ticks
    ticks = _chosen(all_ticks)
    end = recording.end or {"end": "cut short", "cause": None, "message": "the process was killed"}
    times = [tick_seconds(tick) for tick in ticks]
    return filled_page(
        TEMPLATE,
        {
            "outcome": str(end.get("end")),
            "cause": str(end.get("cause") or ""),
            "message": str(end.get("message") or ""),
            "name": folder.resolve().name,
            "subject": _subject(header, placement),
            "period": CONTROL_PERIOD,
            "ticks": len(all_ticks),
            "seconds": round(times[-1] - times[0], 2) if times else 0.0,
            "shown": len(ticks),
            "time": [round(time, 3) for time in times],
            "stages": _stages(ticks, times),
            "events": _events(all_ticks),
            "joints": [_joint(joint, i, ticks) for i, joint in enumerate(robot.joints)],
            "servos": _servos(header, robot, ticks),
            "ranges": [_least(tick.get("ranges")) for tick in ticks],
            "front": [_mm(tick["raw"].get("front_m")) for tick in ticks],
            "taken": [_number(tick["raw"].get("seconds", {}).get("taken"), 1000.0, 1) for tick in ticks],
            "late": max((tick["raw"].get("late") or 0 for tick in all_ticks), default=0),
            "limited": sum(bool(tick.get("clamped")) for tick in all_ticks),
            "picture": _picture(ticks, robot, placement),
            "files": [name for name in FILES if (folder / name).exists()],
            "facts": _facts(header),
        },
    )


def _chosen(ticks: Ticks) -> Ticks:
    """The ticks of a page."""
    if len(ticks) <= MOST_TICKS:
        return ticks
    kept = set(np.linspace(0, len(ticks) - 1, MOST_TICKS).round().astype(int).tolist())
    kept |= {i for i, tick in enumerate(ticks) if "stopped" in tick}
    return [ticks[i] for i in sorted(kept)]


def _subject(header: Mapping[str, Any], placement: ArmPlacement | None) -> str:
    pipe = "in a pipe that is not known" if placement is None else f"in a pipe of {placement.pipe.label}"
    return f"{header.get('robot', 'The arm')} {pipe}, started {header.get('started', 'at an unknown time')}"


def _stages(ticks: Ticks, times: Sequence[float]) -> list[dict[str, Any]]:
    """Stages one after the other, with the time in which each began and ended; holding belongs to the one before."""
    found: list[dict[str, Any]] = []
    for tick, time in zip(ticks, times, strict=True):
        stage = tick.get("stage", "hold")
        if (stage == "hold" and found) or (found and found[-1]["name"] == stage):
            found[-1]["to"] = time
            continue
        if found:
            found[-1]["to"] = time
        found.append({"name": str(stage), "from": time, "to": time})
    return found


def _events(ticks: Ticks) -> list[dict[str, Any]]:
    """Everything that happened besides driving: stops, incomplete readings, warnings, limited set-points."""
    found: list[dict[str, Any]] = []
    warned: set[str] = set()
    limited: Sequence[str] = ()
    for tick in ticks:
        raw, said = tick["raw"], []
        if "stopped" in tick:
            said.append(("stop", str(tick["stopped"])))
        if raw.get("problem"):
            said.append(("held", str(raw["problem"])))
        said += [("warning", str(text)) for text in tick.get("warnings") or [] if text not in warned]
        warned |= {text for _, text in said}
        now = tick.get("clamped") or ()
        if new := [name for name in now if name not in limited]:
            said.append(("limited", ", ".join(map(str, new))))
        limited = now
        found += [{"time": round(tick_seconds(tick), 2), "tick": tick["tick"], "kind": k, "text": t} for k, t in said]
    return found


def _joint(joint: Joint, i: int, ticks: Ticks) -> dict[str, Any]:
    """Positions and set-points of a joint [mm or deg]; None where there were none."""
    slide = joint.type == "slide"
    factor, decimals = (m_to_mm(1.0), 1) if slide else (rad_to_deg(1.0), 2)

    def column(key: str) -> list[float | None]:
        values = [tick.get(key) for tick in ticks]
        return [None if row is None else _number(row[i], factor, decimals) for row in values]

    return {"name": joint.name, "unit": "mm" if slide else "deg", "is": column("q"), "sent": column("sent")}


def _servos(header: Mapping[str, Any], robot: RobotSpec, ticks: Ticks) -> list[dict[str, Any]]:
    """Load [percent], supply [V] and temperature [deg C] of each servo."""
    servos = servo_health(header, robot)
    rows = [servos(tick["raw"]) for tick in ticks]
    return [
        {
            "name": joint.name,
            "load": [None if one is None else round(100 * one.load, 1) for one in column],
            "volts": [None if one is None else one.volts for one in column],
            "celsius": [None if one is None else one.celsius for one in column],
        }
        for i, joint in enumerate(robot.joints)
        for column in [[row[i] for row in rows]]
    ]


def _picture(ticks: Ticks, robot: RobotSpec, placement: ArmPlacement | None) -> dict[str, Any]:
    """The robot from above in every tick [mm], None where its pose is not known; walls, and where the target was."""
    places = [i for i, tick in enumerate(ticks) if drawable(tick, robot)]
    base = 0.0 if placement is None else placement.base
    poses: list[list[float] | None] = [None] * len(ticks)
    hits: list[list[float] | None] = [None] * len(ticks)
    if places:
        q = np.array([ticks[i]["q"] for i in places])
        points = m_to_mm(1.0) * frames.robot_to_pipe(kinematics.waypoints(robot, q), base)
        pose = kinematics.forward(robot, q)
        ranges = np.array([ticks[i]["ranges"] for i in places])
        beams = pose.headings[:, -1:] + robot.laser.angles
        ends = pose.tip[:, None] + ranges[..., None] * np.stack([np.cos(beams), np.sin(beams)], axis=-1)
        ends = m_to_mm(1.0) * frames.robot_to_pipe(ends, base)
        met = (ranges > robot.laser.range_min) & (ranges < robot.laser.range_max)
        for row, i in enumerate(places):
            poses[i] = np.round(points[row].ravel(), 1).tolist()
            hits[i] = np.round(ends[row][met[row]].ravel(), 1).tolist()
    target = next((tick["target"] for tick in reversed(ticks) if tick.get("target")), None)
    return {
        "poses": poses,
        "hits": hits,
        "walls": []
        if placement is None
        else np.round(m_to_mm(1.0) * placement.pipe.segments.reshape(-1, 4), 1).tolist(),
        "target": target and np.round(m_to_mm(1.0) * frames.robot_to_pipe(np.array(target), base), 1).tolist(),
        "widths": [_mm(link.width) for link in robot.links],
        "wheels": [
            [i, _mm(link.wheel.x), _mm(link.wheel.diameter)] for i, link in enumerate(robot.links) if link.wheel
        ],
        "margin": _mm(robot.width),
    }


def _facts(header: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The header's short facts."""
    facts = [(key, str(header[key])) for key in ("robot", "policy", "policy_sha256", "started") if key in header]
    versions = header.get("versions")
    if isinstance(versions, Mapping):
        facts.append(("versions", ", ".join(f"{name} {version}" for name, version in versions.items())))
    return facts


def _least(ranges: Sequence[float] | None) -> float | None:
    return _mm(min(ranges)) if ranges else None


def _mm(metres: float | None) -> float | None:
    return _number(metres, m_to_mm(1.0), 1)


def _number(value: float | None, factor: float, decimals: int) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value * factor, decimals)
