"""Laws of simulators in space: sameness, mirrors, weight, clamps, and readings that fit the truth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.spatial import SpaceBackend
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import BASE
from pipenav.testing.laws import require, require_same
from pipenav.testing.space_bench import PRESS, SpaceBench, SpaceStart, clamped, space_starts

SpaceLaw = Callable[[SpaceBench], None]
"""A check of one law on a bench; it raises AssertionError, in words, where the law is broken."""

RISE = 2e-3
"""Height by which a robot that is let go may rise above its start [m]: its joints give way."""

CREEP = 2e-3
"""Distance by which a clamped robot may creep in 2 s [m]: contacts of simulators are soft."""


def space_state(subject: SpaceBackend) -> dict[str, Floats]:
    """All that a backend reports now, by the names of its fields: readings and the truth."""
    reading, truth = subject.read(), subject.truth()._asdict()
    turning = {"roll": reading.roll, "down": reading.down, "turned": reading.turned}
    return {**reading.body.measured(), **turning, **truth}


def check_same_seed_same_motion(bench: SpaceBench) -> None:
    """Two backends, treated alike, give the same numbers to the last bit."""
    with bench.open() as one, bench.open() as other:
        for subject in (one, other):
            space_starts(bench).begin(subject)
        for set_points, roll in bench.commands(10):
            one.step(set_points, roll)
            other.step(set_points, roll)
            require_same(space_state(one), space_state(other), "two backends under the same commands")


def check_reset_touches_only_named_robots(bench: SpaceBench) -> None:
    """Robots that a reset does not name go on exactly as if nothing had happened."""
    chosen, others = np.arange(1, bench.n, 2), np.arange(0, bench.n, 2)
    with bench.open() as subject, bench.open() as undisturbed:
        for simulator in (subject, undisturbed):
            space_starts(bench).begin(simulator)
        for i, (set_points, roll) in enumerate(bench.commands(8)):
            if i == 4:
                space_starts(bench, seed=1).part(chosen).begin(subject)
            subject.step(set_points, roll)
            undisturbed.step(set_points, roll)
            mine, theirs = (
                {name: values[others] for name, values in space_state(simulator).items()}
                for simulator in (subject, undisturbed)
            )
            require_same(mine, theirs, "robots that were not reset and the same robots undisturbed")


def check_reset_puts_robots_where_it_says(bench: SpaceBench) -> None:
    """A reset returns what is read after it: joints as asked, at rest, at time zero; time counts from then on."""
    with bench.open() as subject:
        space_starts(bench).begin(subject)
        for set_points, roll in bench.commands(3):
            subject.step(set_points, roll)
        np.testing.assert_allclose(
            subject.read().body.time, 3 * CONTROL_PERIOD, rtol=1e-6, err_msg="time after 3 steps"
        )
        again = space_starts(bench, seed=1).part(np.arange(0, bench.n, 2))
        subject.incline(again.indices, again.gravity)
        given, read = subject.reset(*again[:5]), subject.read()
        for name, values in given.body.measured().items():
            same = read.body.measured()[name][again.indices]
            np.testing.assert_array_equal(values, same, err_msg=f"{name} of a reset and read after it")
        np.testing.assert_allclose(given.body.q, again.q[:, len(BASE) :], atol=1e-6, err_msg="joints after a reset")
        for name, rest in (("speeds", given.body.qd), ("time", given.body.time), ("roll", given.roll)):
            np.testing.assert_allclose(rest, 0.0, atol=1e-6, err_msg=f"{name} after a reset")


def check_gravity_mirrors(bench: SpaceBench) -> None:
    """Under any gravity, a robot in the mirror image of a route moves as the mirror image of the robot in the route."""
    robot, start = bench.robot, space_starts(bench)
    across = np.array([1.0, -1.0, 1.0])
    mirrored = SpaceStart(
        start.indices,
        [mirror_image(route) for route in start.routes],
        start.q * robot.mirror_coordinates,
        start.base,
        -start.plane,
        start.gravity * across,
    )
    with bench.open() as one, bench.open() as other:
        start.begin(one)
        mirrored.begin(other)
        for set_points, roll in bench.commands(3):
            one.step(set_points, roll)
            other.step(set_points * robot.mirror_actuators, -roll)
        mine, theirs = one.truth().points, other.truth().points
        np.testing.assert_allclose(theirs, mine * across, atol=1e-3, err_msg="points in the mirror image")
        down = one.read().down * across
        np.testing.assert_allclose(other.read().down, down, atol=1e-2, err_msg="down in the mirror image")


def check_let_go_it_never_rises(bench: SpaceBench) -> None:
    """A robot that is let go at rest falls, and never gets higher than it was: its energy does not grow."""
    robot, start = bench.robot, space_starts(bench)
    masses = np.array([link.mass + (link.wheel.mass if link.wheel else 0.0) for link in robot.links])
    still = np.concatenate([start.q[:, len(BASE) :], np.zeros((bench.n, len(robot.wheels)))], axis=1)
    with bench.open() as subject:
        start.begin(subject)
        heights = []
        for _ in range(20):
            points = subject.truth().points
            middle = masses @ ((points[:, :-1] + points[:, 1:]) / 2) / masses.sum()  # (n, 3)
            heights.append(-np.sum(middle * start.gravity, axis=1) / np.linalg.norm(start.gravity, axis=1))
            subject.step(still, np.zeros(bench.n))
    risen = np.max(heights, axis=0) - heights[0]
    require(bool((risen < RISE).all()), f"robots that are let go rise by {risen} m")


def check_a_clamped_robot_stays(bench: SpaceBench) -> None:
    """A robot that presses against both sides of its pipe, at rest, stays where it is under its weight."""
    start = clamped(bench)
    q = start.q[:, len(BASE) :]
    held = np.concatenate([q + PRESS * np.sign(q), np.zeros((bench.n, len(bench.robot.wheels)))], axis=1)
    with bench.open() as subject:
        start.begin(subject)
        for _ in range(10):
            subject.step(held, np.zeros(bench.n))
        before = subject.truth().points
        for _ in range(20):
            subject.step(held, np.zeros(bench.n))
        crept = np.linalg.norm(subject.truth().points - before, axis=2).max(axis=1)
    require(bool((crept < CREEP).all()), f"clamped robots creep by {crept} m")


def check_down_and_roll_fit_the_truth(bench: SpaceBench) -> None:
    """Down is the direction of gravity in the halves' frames, and 0 where nothing weighs; roll is the angle between."""
    start = space_starts(bench)
    with bench.open() as subject:
        start._replace(gravity=0 * start.gravity).begin(subject)
        require(not subject.read().down.any(), "something is down where nothing weighs")
        start.begin(subject)
        direction = start.gravity / np.linalg.norm(start.gravity, axis=1, keepdims=True)
        for set_points, roll in [(None, None), *bench.commands(4)]:
            if set_points is not None and roll is not None:
                subject.step(set_points, roll)
            reading, normals = subject.read(), subject.truth().normals
            np.testing.assert_allclose(np.linalg.norm(reading.down, axis=2), 1.0, atol=1e-6, err_msg="length of down")
            across = np.einsum("nhi,ni->nh", normals, direction)
            np.testing.assert_allclose(reading.down[..., 2], across, atol=1e-4, err_msg="down across the planes")
            between = np.sum(normals[:, 0] * normals[:, 1], axis=1)
            np.testing.assert_allclose(between, np.cos(reading.roll), atol=1e-4, err_msg="angle between the halves")


SPACE_LAWS: list[SpaceLaw] = [
    check_same_seed_same_motion,
    check_reset_touches_only_named_robots,
    check_reset_puts_robots_where_it_says,
    check_gravity_mirrors,
    check_let_go_it_never_rises,
    check_a_clamped_robot_stays,
    check_down_and_roll_fit_the_truth,
]
"""Laws of every simulator's robots in space."""


def mirror_image(route: PipeRoute) -> PipeRoute:
    """The route with right and left exchanged."""
    other = {"left": "right", "right": "left"}
    changes = [{"turn": other[corner.turn], "roll": -corner.roll} for corner in route.corners]
    corners = [corner.model_copy(update=change) for corner, change in zip(route.corners, changes, strict=True)]
    return route.model_copy(update={"corners": tuple(corners)})
