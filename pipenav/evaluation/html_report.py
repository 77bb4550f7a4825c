"""The report of an evaluation as one HTML file, which loads nothing from anywhere: map, pictures, failures, tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.evaluation.failures import Failure
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.map_panels import map_panels
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.replay import Replayed
from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.summary import circumstances, headline, percent
from pipenav.pages.page import filled_page
from pipenav.pipes.pipe import Pipe
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.units import m_to_mm

TEMPLATE = Path(__file__).with_name("report.html")

FRAMES = 5
"""Poses of a picture: the start, the end, and some between, evenly in time."""

PATH_POINTS = 40
"""Most points of a tip's path in a picture."""

MOST_PIPES = 2000
"""Most pipes in a page: those in which most episodes failed."""

MOST_FAILURES = 2000
"""Most failed episodes in a page."""

MOST_PICTURES = 12
"""Most pictures in the gallery of the worst pipes."""


class Pictured(NamedTuple):
    """Everything in a page besides the evaluation's own record.

    Attributes:
        robot: the robot.
        pipes: pipes of the evaluation, in order.
        failures: all failed episodes, in order of their numbers.
        replayed: episodes that were run again, by number: pictures are drawn of these.
        again: command that runs an episode again, in words.
    """

    robot: RobotSpec
    pipes: Sequence[Pipe]
    failures: Sequence[Failure]
    replayed: Mapping[int, Replayed]
    again: str


def evaluation_page(evaluation: Evaluation, pictured: Pictured) -> str:
    """The page of an evaluation."""
    numbers = _chosen(evaluation)
    place = {number: i for i, number in enumerate(numbers)}
    shots = {number: _shot(one, pictured.robot) for number, one in pictured.replayed.items() if len(one.q)}
    failures = [failure for failure in pictured.failures if failure.pipe in place][:MOST_FAILURES]
    each = evaluation.episodes_per_pipe
    as_run = {number // each: one.pipe for number, one in pictured.replayed.items()}  # its legs as long as needed
    pipes = [_pipe(evaluation.pipes[n], as_run.get(n, pictured.pipes[n])) for n in numbers]
    for number in sorted(shots, reverse=True):  # the first one of a pipe stays
        if number // each in place:
            pipes[place[number // each]]["shot"] = shots[number]
    robot = pictured.robot
    return filled_page(
        TEMPLATE,
        {
            "title": headline(evaluation),
            "subject": circumstances(evaluation).replace("\n", "; "),
            "note": _note(evaluation, numbers, pictured),
            "again": pictured.again,
            "success": percent(evaluation.success),
            "low": percent(evaluation.success_low),
            "high": percent(evaluation.success_high),
            "episodes": evaluation.episodes,
            "failed": evaluation.episodes - sum(record.successes for record in evaluation.pipes),
            "of": len(evaluation.pipes),
            "period": CONTROL_PERIOD,
            "robot": {
                "widths": [_mm(link.width) for link in robot.links],
                "wheels": [
                    [i, _mm(link.wheel.x), _mm(link.wheel.diameter)] for i, link in enumerate(robot.links) if link.wheel
                ],
                "margin": _mm(robot.width + max(pipe.diameter for pipe in pictured.pipes) / 2),
            },
            "panels": map_panels([evaluation.pipes[n] for n in numbers]),
            "pipes": pipes,
            "failures": [_failure(failure, place, shots, robot) for failure in failures],
            "gallery": _gallery(evaluation, failures, shots),
        },
    )


def _chosen(evaluation: Evaluation) -> list[int]:
    """Numbers of the pipes in the page, in order: all, or those in which most episodes failed."""
    every = range(len(evaluation.pipes))
    worst = sorted(every, key=lambda number: evaluation.pipes[number].success)
    return sorted(worst[:MOST_PIPES])


def _note(evaluation: Evaluation, numbers: Sequence[int], pictured: Pictured) -> str:
    """Sentences about what the page leaves out."""
    parts = ["In percent of the episodes. Blue passes, orange does not."]
    if any(record.passability is not None for record in evaluation.pipes):
        parts.append(
            "Slanted lines mark pipes with episodes that geometry proves impossible, dots those with episodes that are "
            "undecided or possible only with overlap; grey ones had no possible episode."
        )
    if len(numbers) < len(evaluation.pipes):
        parts.append(f"The page has the {len(numbers):,} pipes in which most episodes failed; eval.json has all.")
    if len(pictured.failures) > MOST_FAILURES:
        parts.append(f"Of the failed episodes it has {MOST_FAILURES:,}; failures.json has all.")
    unseen = sum(failure.pose is None for failure in pictured.failures)
    if unseen:
        parts.append(f"{unseen:,} failed episodes were not run again for a pose and a picture.")
    return " ".join(parts)


def _pipe(record: PipeRecord, pipe: Pipe) -> dict[str, Any]:
    low, high = wilson(record.successes, record.episodes)
    segments = np.zeros((0, 4)) if pipe.in_space else pipe.segments.reshape(-1, 4)
    return {
        "label": pipe.label,
        "success": record.success,
        "successes": record.successes,
        "low": low,
        "percent": percent(record.success),
        "interval": f"{percent(low)}–{percent(high)}",
        "walls": np.round(m_to_mm(1.0) * segments, 1).tolist(),
        "shot": None,
        "record": record.model_dump(mode="json"),
    }


def _shot(one: Replayed, robot: RobotSpec) -> dict[str, Any]:
    """An episode as a picture: points of the links in some poses, and the tip's path [mm]."""
    rows = np.unique(np.linspace(0, len(one.q) - 1, FRAMES).round().astype(int))
    path = np.unique(np.linspace(0, len(one.q) - 1, PATH_POINTS).round().astype(int))
    points = m_to_mm(1.0) * frames.robot_to_pipe(kinematics.waypoints(robot, one.q), one.base)
    return {
        "number": one.number,
        "end": f"{one.outcome.label} after {CONTROL_PERIOD * one.steps:.1f} s",
        "frames": np.round(points[rows].reshape(len(rows), -1), 1).tolist(),
        "path": np.round(points[path, -1].ravel(), 1).tolist(),
        "target": None if one.target is None else [_mm(x) for x in one.target],
    }


def _failure(
    failure: Failure, place: Mapping[int, int], shots: Mapping[int, dict[str, Any]], robot: RobotSpec
) -> dict[str, Any]:
    pose = failure.pose
    return {
        "number": failure.number,
        "pipe": place[failure.pipe],
        "stage": failure.stage,
        "outcome": failure.outcome,
        "steps": failure.steps,
        "kind": failure.kind,
        "tip": pose and pose.tip_mm,
        "rear": pose and pose.rear_mm,
        "side": pose and pose.side,
        "corner": pose and pose.corner,
        "pose": pose and _pose_text(pose.q, robot),
        "shot": shots.get(failure.number),
    }


def _pose_text(q: Sequence[float], robot: RobotSpec) -> str:
    """Positions of the joints in degrees and millimetres."""
    values = q[len(q) - len(robot.joints) :]
    return ", ".join(
        f"{joint.name} {np.degrees(value):.0f} deg"
        if joint.type == "hinge"
        else f"{joint.name} {m_to_mm(value):.0f} mm"
        for joint, value in zip(robot.joints, values, strict=True)
    )


def _gallery(evaluation: Evaluation, failures: Sequence[Failure], shots: Mapping[int, Any]) -> list[int]:
    """Places in the list of one failure with a picture of each of the worst pipes, the worst first."""
    first: dict[int, int] = {}
    for i, failure in enumerate(failures):
        if failure.number in shots:
            first.setdefault(failure.pipe, i)
    return [first[pipe] for pipe in sorted(first, key=lambda number: evaluation.pipes[number].success)][:MOST_PICTURES]


def _mm(metres: float) -> float:
    return round(m_to_mm(metres), 1)
