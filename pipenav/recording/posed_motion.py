"""A recorded motion as poses in space: what a three-dimensional viewer shows, whatever recorded it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.motions.trajectory import Trajectory
from pipenav.pipes.route import PipeRoute
from pipenav.recording.record_rolling import SpaceRecording
from pipenav.robots import frames, kinematics, laser
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome

RING_POINTS = 32
"""Points of a ring that shows a pipe's bore in space."""

RINGS_APART = 0.1
"""Largest distance of two rings on a straight [m]."""


class Beams(NamedTuple):
    """Laser beams.

    Attributes:
        ends: ends of the beams, (rows, beams, 3) [m].
        met: whether each met a wall within its range, (rows, beams).
    """

    ends: Floats
    met: Flags


@dataclass(frozen=True)
class PosedMotion:
    """A motion as poses in the pipe's frame; a motion in the plane lies at z = 0. Its arrays must not be written to.

    Attributes:
        name: name of the motion, for people.
        robot: the robot.
        walls: lines of the pipe's walls, (points, 3) each [m].
        time: time of each row, (rows,) [s].
        start: rear end of each link, (rows, links, 3) [m].
        axes: axes of each link as columns, x along it, (rows, links, 3, 3).
        tip: the tip, (rows, 3) [m].
        beams: the laser's beams; None where they are not known.
        target: the target, (3,) [m]; None where there is none.
        series: numbers over time by name, (rows,) each.
        events: row and text of everything that happened, in order.
    """

    name: str
    robot: RobotSpec
    walls: Sequence[Floats]
    time: Floats
    start: Floats
    axes: Floats
    tip: Floats
    beams: Beams | None = None
    target: Floats | None = None
    series: Mapping[str, Floats] = field(default_factory=dict)
    events: Sequence[tuple[int, str]] = ()


def posed_trajectory(motion: Trajectory) -> PosedMotion:
    """A motion in the plane; its beams are those of a laser without noise, since a trajectory does not hold them."""
    header, robot = motion.header, motion.robot
    segments = header.pipe.segments
    pose = kinematics.forward(robot, motion.q)
    tips, headings = frames.robot_to_pipe(pose.tip, header.base_m), pose.headings[:, -1:] + robot.laser.angles
    ranges = laser.measure(robot.laser, laser.cast(tips, headings, np.repeat(segments[None], len(tips), axis=0)))
    series = {f"joint/{joint.name}": motion.q[:, i - len(robot.joints)] for i, joint in enumerate(robot.joints)}
    if motion.contact_force is not None:
        series["contact_force"] = motion.contact_force
    series["least_range"] = ranges.min(axis=1)
    if header.outcome is not None:
        series["succeeded"] = _at_the_end(len(motion.q), header.outcome == Outcome.REACHED.label)
    return plane_motion(
        robot,
        motion.q,
        header.base_m,
        name=f"{header.controller or header.stage}: {header.pipe.label}",
        walls=[_raised(line) for line in segments],
        time=motion.time,
        ranges=ranges,
        target=None if header.goal_m is None else _raised(np.array([header.goal_m]))[0],
        series=series,
        events=[(len(motion.q) - 1, f"{header.stage}: {header.outcome or 'not run'}")],
    )


def plane_motion(robot: RobotSpec, q: Floats, base: float, ranges: Floats | None, **more: object) -> PosedMotion:
    """A motion in the plane from its configurations.

    Args:
        robot: the robot.
        q: configurations in the robot's own frame, (rows, coordinates) [rad or m].
        base: x of the robot's frame in the pipe's frame [m].
        ranges: laser readings, (rows, beams) [m]; None where they are not known.
        more: the other attributes of a `PosedMotion`.
    """
    pose = kinematics.forward(robot, q)
    points = _raised(frames.robot_to_pipe(kinematics.waypoints(robot, q), base))
    along = np.diff(points, axis=1) / np.array([link.length for link in robot.links])[:, None]
    up = np.broadcast_to([0.0, 0.0, 1.0], along.shape)
    beams = None
    if ranges is not None:
        headings = pose.headings[:, -1:] + robot.laser.angles
        rays = np.stack([np.cos(headings), np.sin(headings), np.zeros(headings.shape)], axis=-1)
        met = (ranges > robot.laser.range_min) & (ranges < robot.laser.range_max)
        beams = Beams(points[:, -1:] + ranges[..., None] * rays, met)
    axes = np.stack([along, np.cross(up, along), up], axis=-1)
    return PosedMotion(robot=robot, start=points[:, :-1], axes=axes, tip=points[:, -1], beams=beams, **more)  # type: ignore[arg-type]


def posed_in_space(recording: SpaceRecording) -> PosedMotion:
    """A motion in a route that leaves the plane."""
    robot, points = recording.robot, recording.points
    assert robot.roll is not None
    divided = [link.name for link in robot.links].index(robot.roll.link)
    along = np.diff(points, axis=1) / np.array([link.length for link in robot.links])[:, None]
    # The divided link is drawn as its rear half lies.
    up = recording.normals[:, [0 if i <= divided else 1 for i in range(len(robot.links))]]
    changes = [(0, recording.doing[0])]
    changes += [(row, now) for row, (before, now) in enumerate(pairwise(recording.doing), 1) if now != before]
    return PosedMotion(
        name=f"{recording.controller}: {recording.route.label}",
        robot=robot,
        walls=route_lines(recording.route),
        time=recording.time,
        start=points[:, :-1],
        axes=np.stack([along, np.cross(up, along), up], axis=-1),
        tip=points[:, -1],
        series={
            "contact_force": recording.contact_force,
            "succeeded": _at_the_end(len(points), recording.succeeded),
        },
        events=[*changes, (len(points) - 1, recording.outcome)],
    )


def route_lines(route: PipeRoute) -> list[Floats]:
    """Lines that show a route in space: its centre line, and rings of its bore on every leg."""
    line, radius = route.centre_line, route.diameter / 2
    angle = np.linspace(0.0, 2 * np.pi, RING_POINTS + 1)
    lines = [line]
    for (begin, end), axes in zip(pairwise(line), route.frames.rotation, strict=True):
        ring = radius * (np.cos(angle)[:, None] * axes[:, 1] + np.sin(angle)[:, None] * axes[:, 2])
        count = max(2, int(np.ceil(np.linalg.norm(end - begin) / RINGS_APART)))
        lines += [begin + share * (end - begin) + ring for share in np.linspace(0.0, 1.0, count)]
    return lines


def _at_the_end(rows: int, succeeded: bool) -> Floats:
    """1 or 0 in the last row, and nothing before it, (rows,)."""
    return np.array([*[np.nan] * (rows - 1), float(succeeded)])


def _raised(points: Floats) -> Floats:
    """Points of the plane in space, (..., 3) [m]."""
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)
