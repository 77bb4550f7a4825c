"""Motions of a whole robot around a corner: its links turn one after another, pushed into the outer corner, or in a
bend all its joints follow one line."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from pipenav.arrays import Floats
from pipenav.certify.corner_walls import width_seen
from pipenav.certify.model import Model
from pipenav.certify.motion_check import check_by_distance, check_by_shapely, clearances
from pipenav.certify.push import pushed
from pipenav.pipes.corner_lines import ARC_TOLERANCE
from pipenav.robots import kinematics
from pipenav.tasks.traverse.config import TraverseConfig

STEP, COARSE = math.radians(0.5), math.radians(2.0)
"""Largest change of a heading between two waypoints near a wall, and where there is room [rad]."""

STOPS = (0.7, 0.78, 0.74, 0.65, 0.6)
"""Headings at which a link waits for the one behind it to begin, as shares of the turn."""

OVERLAP = 0.3
"""Share of a link's turn in which the one before it, which waits, goes on to its end."""

MARGINS = (8e-3, 4e-3, 2e-3, 1e-3, 5e-4)
"""Distances to the walls that are kept where there is room, before the least one [m]: tests take few samples then."""

STEADY = 1e-3
"""Margin above which waypoints may be far from each other [m]."""

LINES = (0.4, 0.0, 0.2, 0.6, 0.8, 0.9)
"""Lines that joints follow in a bend: distance from the axis to the outside, as a share of the wheels' room."""

BESIDE = (1.2e-3, 8e-4, 5e-4, 3.5e-4, 2.5e-4, 0.0)
"""Further lines: distance to where wheels keep no more than the margin from the outside [m]."""

GLANCE = 0.02
"""Step along a line at which it is looked at first, to see which one leaves most room [m]."""

ALONG, COARSE_ALONG = 0.002, 0.006
"""Step along the line between two waypoints near a wall, and where there is room [m]."""

HALVINGS = 28
"""Halvings by which the next joint on a line is found: to a nanometre."""

PAST = 0.005
"""Distance by which the tail goes on after it counts as through [m]."""

SPARE = math.radians(0.5)
"""Angle by which motions stay off the joints' limits [rad]."""


def whole_motion(model: Model, margin: float, config: TraverseConfig) -> Floats | None:
    """A motion that takes the whole robot around the corner; None where none of those tried is free.

    Args:
        model: what is certified; its robot stands free.
        margin: distance to the walls that is kept [m].
        config: the task, which says where it starts and when the tail is through.

    Returns:
        Configurations in the pipe's frame: base x of the robot's frame is 0, (rows, coordinates).
    """
    makes = _followed if model.pipe.bend_radius else _waves
    for headings, origin in makes(model, margin):
        q = _with_ends(model, headings, origin, config)
        bends = q[:, 3:]
        if (bends < model.robot.lower + SPARE).any() or (bends > model.robot.upper - SPARE).any():
            continue
        if check_by_distance(model, q, 0.0).free and check_by_shapely(model, q, 0.0).free:
            return q
    return None


def _waves(model: Model, margin: float) -> Iterator[tuple[Floats, Floats]]:
    """Headings, (rows, links), and places of the rear end, (rows, 2), of links that turn one after another.

    A link turns on its own through the middle of its turn, where it needs most room. Its first and its last part take
    place while its neighbours do theirs, so that no joint ever bends by more than the share at which links wait.
    Those that keep the largest margin come first.
    """
    for distance in (*MARGINS, margin):
        shapes, step = model.shapes(proof=False, margin=distance), COARSE if distance > STEADY else STEP
        for stop in STOPS:
            rows, links = math.ceil((len(shapes.lengths) + 1) * model.turn / step), len(shapes.lengths)
            phase = np.linspace(0.0, links + 1.0, rows)[:, None] - np.arange(links)[::-1]
            knots = (0.0, 1.0 - stop, stop, 1.0)
            headings = model.turn * np.interp(phase, (0.0, OVERLAP, 1.0, 1.0 + OVERLAP), knots)
            at = pushed(model, shapes, headings)
            if at.gap.min() >= 0:
                yield headings, at.origin


def _followed(model: Model, margin: float) -> Iterator[tuple[Floats, Floats]]:
    """Headings and places of the rear end of a robot whose joints all lie on one line along the bend.

    The first line that leaves enough room comes first, then the others, the one that leaves most before the rest.
    """
    discs = model.shapes(proof=False, margin=margin).discs
    seen = width_seen(model.pipe.diameter, discs.height, model.bore) / 2
    room = float((seen - discs.radius).min(initial=model.pipe.radius)) - ARC_TOLERANCE
    found = []
    for offset in (*(share * room for share in LINES), *(room - beside for beside in BESIDE)):
        q = _configuration(model, *_on_line(model, -offset, GLANCE))
        least = float(clearances(model, q, 0.0).min())
        if least > STEADY:
            yield _on_line(model, -offset, COARSE_ALONG)
        if least > 0:
            found.append((least, offset))
    for _, offset in sorted(found, reverse=True):
        yield _on_line(model, -offset, ALONG)


def _on_line(model: Model, offset: float, step: float) -> tuple[Floats, Floats]:
    """Headings, (rows, links), and places of the rear end, (rows, 2), of a robot with its joints on a line."""
    line = _fine(model, offset)
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.arange(0.0, lengths[-1] - 1.05 * model.robot.length, step)
    points = [_on(line, lengths, at)]
    for length in model.robot.lengths.tolist():
        at = _next(line, lengths, at, length)
        points.append(_on(line, lengths, at))
    steps = np.diff(np.array(points), axis=0)  # (links, rows, 2)
    return np.arctan2(steps[..., 1], steps[..., 0]).T, points[0]


def _fine(model: Model, offset: float) -> Floats:
    """A line along the corner with a robot's length and a half of straight before and after the bend, (k, 2) [m]."""
    pipe = model.pipe
    straight = pipe.tangent_length(offset) + 1.5 * model.robot.length
    return pipe.model_copy(update={"leg": straight, "turn": "left"}).line(offset, 400)


def _on(line: Floats, lengths: Floats, at: Floats) -> Floats:
    """Points of a line at some lengths along it, (n, 2) [m]."""
    return np.stack([np.interp(at, lengths, column) for column in line.T], axis=1)


def _next(line: Floats, lengths: Floats, at: Floats, distance: float) -> Floats:
    """Lengths along the line at which its points are a distance ahead of others, (n,) [m]."""
    here, low, high = _on(line, lengths, at), at + distance * 0.999999, at + 1.6 * distance
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        near = np.hypot(*(_on(line, lengths, middle) - here).T) < distance
        low, high = np.where(near, middle, low), np.where(near, high, middle)
    return np.asarray(high)


def _with_ends(model: Model, headings: Floats, origin: Floats, config: TraverseConfig) -> Floats:
    """Configurations from the straight start on the first leg's axis until the tail is through, (rows, coordinates)."""
    robot, turn = model.robot, model.turn
    inner = model.pipe.inner_edge
    gap = sum(config.start_gap) / 2
    axis = np.array([math.cos(turn), math.sin(turn)])
    start = np.array([min(-inner - gap - robot.length, float(origin[0, 0])), 0.0])
    through = inner + config.through + PAST
    further = max(0.0, through - float(origin[-1] @ axis))
    places = np.concatenate([start[None], origin, (origin[-1] + further * axis)[None]])
    every = np.concatenate([headings[:1], headings, headings[-1:]])
    return _configuration(model, every, places)


def _configuration(model: Model, headings: Floats, rear: Floats) -> Floats:
    """Configurations in the pipe's frame from canonical headings and places of the rear end, (rows, coordinates)."""
    q = np.concatenate([rear, headings[:, :1], np.diff(headings, axis=1)], axis=1)
    return np.asarray(q if model.pipe.turn_sign > 0 else q * model.robot.mirror_coordinates)


def tail_is_through(model: Model, q: Floats, config: TraverseConfig) -> bool:
    """Whether the rear end is past the corner at the end of a motion in the pipe's frame, (rows, coordinates)."""
    rear = kinematics.waypoints(model.robot, q[-1:])[0, 0]
    return bool(model.pipe.distance_along(rear) >= model.pipe.inner_edge + config.through)
