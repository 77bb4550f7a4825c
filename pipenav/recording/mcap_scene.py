"""A motion as messages that Foxglove draws: walls and target once, links, tip's path and beams at every moment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from pipenav.arrays import Floats
from pipenav.recording.posed_motion import PosedMotion

FRAME = "pipe"
"""Name of the frame that everything is drawn in."""

LINE_STRIP, LINE_LIST = 0, 2
"""Numbers of the kinds of lines."""

WALL, LINK, BEAM, TARGET = (0.42, 0.45, 0.5, 1.0), (0.18, 0.5, 0.76, 1.0), (0.7, 0.33, 0.75, 0.6), (0.83, 0.31, 0.05, 1)
"""Colours, red, green, blue and opacity."""


def scene_updates(motion: PosedMotion, started: int) -> Iterator[tuple[float, dict[str, Any]]]:
    """Updates of the scene, each with its time since the start [s].

    Args:
        motion: the motion.
        started: nanoseconds since 1970 at its start.
    """
    for row, seconds in enumerate(motion.time.tolist()):
        stamp = _time(started + round(seconds * 1e9))
        entities = [_entity("robot", stamp, cubes=_cubes(motion, row))]
        if motion.beams is not None:
            entities.append(_entity("laser", stamp, lines=_beams(motion, row)))
        if row == 0:
            walls = [_line(LINE_STRIP, line.tolist(), WALL, 0.004) for line in motion.walls]
            target = [] if motion.target is None else [_sphere(motion.target)]
            entities.append(_entity("pipe", stamp, lines=walls, spheres=target))
        yield seconds, {"deletions": [], "entities": entities}


def _time(nanoseconds: int) -> dict[str, int]:
    return {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}


def _entity(name: str, stamp: dict[str, int], **shapes: list[dict[str, Any]]) -> dict[str, Any]:
    """An entity that stays until another one of its name comes."""
    empty: dict[str, list[Any]] = {
        kind: []
        for kind in ("metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")
    }
    return {
        "timestamp": stamp,
        "frame_id": FRAME,
        "id": name,
        "lifetime": _time(0),
        "frame_locked": False,
        **empty,
        **shapes,
    }


def _cubes(motion: PosedMotion, row: int) -> list[dict[str, Any]]:
    turns = Rotation.from_matrix(motion.axes[row]).as_quat()
    return [
        {
            "pose": _pose(start + axes[:, 0] * link.length / 2, turn),
            "size": _vector([link.length, link.width, link.height]),
            "color": _colour(LINK),
        }
        for link, start, axes, turn in zip(motion.robot.links, motion.start[row], motion.axes[row], turns, strict=True)
    ]


def _beams(motion: PosedMotion, row: int) -> list[dict[str, Any]]:
    assert motion.beams is not None
    ends = motion.beams.ends[row][motion.beams.met[row]]
    points = [point for end in ends.tolist() for point in (motion.tip[row].tolist(), end)]
    return [_line(LINE_LIST, points, BEAM, 0.001)]


def _sphere(place: Floats) -> dict[str, Any]:
    still = np.array([0.0, 0.0, 0.0, 1.0])
    return {"pose": _pose(place, still), "size": _vector([0.016] * 3), "color": _colour(TARGET)}


def _line(kind: int, points: Sequence[Sequence[float]], colour: Sequence[float], width: float) -> dict[str, Any]:
    return {
        "type": kind,
        "pose": _pose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])),
        "thickness": width,
        "scale_invariant": False,
        "points": [_vector(point) for point in points],
        "color": _colour(colour),
        "colors": [],
        "indices": [],
    }


def _pose(place: Floats, turn: Floats) -> dict[str, dict[str, float]]:
    return {"position": _vector(place.tolist()), "orientation": _vector(turn.tolist())}


def _vector(values: Sequence[float]) -> dict[str, float]:
    return dict(zip("xyzw", values, strict=False))


def _colour(values: Sequence[float]) -> dict[str, float]:
    return dict(zip("rgba", values, strict=True))
