"""The MuJoCo backend's walls, beams and contacts against static walls, MuJoCo's own rays and plane geometry."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest
from pipenav_mujoco.backend import MujocoBackend, MujocoOptions
from pipenav_mujoco.model import Contact, static_spec

from pipenav.arrays import Floats
from pipenav.backends.messages import Command
from pipenav.backends.wall_boxes import INNER_THICKNESS
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import kinematics, laser
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig

ROBOT = load_robot("basic")
OPTIONS = MujocoOptions(threads=1)
SUBSTEPS = round(0.1 / OPTIONS.timestep)


class Scene(NamedTuple):
    """Robots at random starts, in pipes of their own."""

    backend: MujocoBackend
    pipes: list[PipeCorner]
    q: Floats
    base: Floats


def random_pipes(rng: np.random.Generator, n: int, bends: Sequence[float] = (0.0,)) -> list[PipeCorner]:
    return [
        PipeCorner.of(
            rng.uniform(70, 120), rng.uniform(55, 125), str(rng.choice(["left", "right"])), float(rng.choice(bends))
        )
        for _ in range(n)
    ]


def scene(rng: np.random.Generator, n: int, bends: Sequence[float] = (0.0,)) -> Scene:
    pipes = random_pipes(rng, n, bends)
    start = episode.sample(ROBOT, ReachConfig(), pipes, rng)
    backend = MujocoBackend(ROBOT, n, OPTIONS, max(len(pipe.segments) for pipe in pipes))
    backend.reset(np.arange(n), pipes, start.q, start.base)
    return Scene(backend, pipes, start.q, start.base)


def duties(rng: np.random.Generator, n: int) -> Floats:
    """Random drives that push the arm into the corner, so that it meets the walls often."""
    values = rng.uniform(-1, 1, (n, 4))
    values[:, 0] = 0.3 + 0.7 * np.abs(values[:, 0])
    return values


def static_model(pipe: PipeCorner, base: float) -> Any:
    """The reference: this pipe's walls compiled in, torque control."""
    contact = Contact(OPTIONS.contact_time_constant, OPTIONS.contact_impedance)
    model = static_spec(ROBOT, pipe, OPTIONS.timestep, contact, base).compile()
    model.actuator_gainprm[:, 0], model.actuator_biasprm[:, 1] = ROBOT.effort_limits, 0.0
    return model


@pytest.mark.slow
@pytest.mark.parametrize("bends", [(0.0,), (30.0, 100.0)])
def test_mocap_walls_give_the_trajectories_of_static_ones(bends: tuple[float, ...]) -> None:
    # Not bit for bit: a world geom's contacts come in another order, and sums of floats depend on it. What rounding
    # leaves, 1e-16, contacts amplify to some 1e-12 within these 2.5 s.
    rng = np.random.default_rng(1)
    n = 40 if bends == (0.0,) else 10
    now = scene(rng, n, bends)
    models = [static_model(pipe, base) for pipe, base in zip(now.pipes, now.base, strict=True)]
    states = [mujoco.MjData(model) for model in models]
    for state, q in zip(states, now.q, strict=True):
        state.qpos[:] = q
    touched = 0
    for _ in range(25):
        values = duties(rng, n)
        now.backend.step(Command("torque", values))
        for model, state, duty in zip(models, states, values, strict=True):
            state.ctrl[:] = duty
            mujoco.mj_step(model, state, SUBSTEPS)
        touched += int((now.backend.truth().contact_share > 0).sum())
    reading, truth = now.backend.read(), now.backend.truth()
    assert touched > 10 * n
    assert reading.q == pytest.approx(np.array([state.qpos for state in states]), abs=1e-9)
    for i, (model, state) in enumerate(zip(models, states, strict=True)):
        mujoco.mj_kinematics(model, state)
        assert truth.tip[i, :2] - [now.base[i], 0.0] == pytest.approx(state.site("tip").xpos[:2], abs=1e-9)


def mujoco_rays(pipe: PipeCorner, base: float, q: Floats) -> Floats:
    """Distances that MuJoCo's own rays find from the tip along the beams; inf where they meet nothing."""
    model = static_model(pipe, base)
    model.geom_group[:] = model.geom_bodyid == 0  # the walls
    state = mujoco.MjData(model)
    state.qpos[:] = q
    mujoco.mj_forward(model, state)
    group, hit = np.array([0, 1, 0, 0, 0, 0], np.uint8), np.zeros(1, np.int32)
    headings = q[1:].sum() + ROBOT.laser.angles
    rays = [np.array([np.cos(heading), np.sin(heading), 0.0]) for heading in headings]
    tip = state.site("tip").xpos
    found = np.array([mujoco.mj_ray(model, state, tip, ray, group, 1, -1, hit) for ray in rays])
    return np.where(found < 0, np.inf, found)


def test_beams_are_mujocos_rangefinders() -> None:
    pipe, base = PipeCorner.of(100, 75), -0.52
    q = np.array([[0.05, 0.1, -0.2, 0.6], [0.15, -0.05, 0.3, 0.8]])
    spec = static_spec(ROBOT, pipe, 0.0025, Contact(0.005, (0.95, 0.99, 0.001)), base)
    for geom in spec.geoms:
        if not geom.name.startswith("wall"):
            geom.rgba[3] = 0.0  # a rangefinder looks through what is invisible: here through the arm itself
    last = spec.body(ROBOT.links[-1].name)
    for i, angle in enumerate(ROBOT.laser.angles):
        along_beam = np.sqrt(0.5) * np.array([1.0, -np.sin(angle), np.cos(angle), 0.0])  # turns z onto the beam
        last.add_site(name=f"beam{i}", pos=[ROBOT.links[-1].length, 0, 0], quat=along_beam)
        kind = mujoco.mjtSensor.mjSENS_RANGEFINDER
        spec.add_sensor(
            name=f"beam{i}", type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=f"beam{i}", intprm=[1, 0, 0]
        )
    model = spec.compile()
    state = mujoco.MjData(model)
    backend = MujocoBackend(ROBOT, 2, MujocoOptions())
    backend.reset(np.arange(2), [pipe, pipe], q, np.full(2, base))
    for pose, ranges in zip(q, backend.read().ranges, strict=True):
        state.qpos[:] = pose
        mujoco.mj_forward(model, state)
        found = np.array([state.sensor(f"beam{i}").data[0] for i in range(ROBOT.laser.beams)])
        assert ranges == pytest.approx(laser.measure(ROBOT.laser, np.where(found < 0, np.inf, found)), abs=1e-12)
    backend.close()


def beyond_the_ends(pipe: PipeCorner, points: Floats) -> bool:
    """Whether all points lie past an open end of the pipe, where the boxes of the outer wall run on a little."""
    past_second = pipe.along_second_leg(points)[:, 0] > pipe.leg
    return bool(np.all(past_second | (points[:, 0] < -pipe.leg)))


@pytest.mark.slow
@pytest.mark.parametrize("bends", [(0.0,), (30.0, 100.0)])
def test_beams_are_mujocos_own_rays(bends: tuple[float, ...]) -> None:
    # The square end of an inner box may stand out by its thickness at a sharp edge: there, and only there, beams may
    # differ by more than rounding. Beyond a leg's open end the boxes run on by their thickness, where the pipe ends.
    rng = np.random.default_rng(2)
    now = scene(rng, 30, bends)
    compared = 0
    for _ in range(3):
        for _ in range(7):
            now.backend.step(Command("torque", duties(rng, 30)))
        reading = now.backend.read()
        pose = kinematics.forward(ROBOT, reading.q)
        for i, (pipe, base) in enumerate(zip(now.pipes, now.base, strict=True)):
            origin = pose.tip[i] + [base, 0.0]
            headings = pose.headings[i, -1] + ROBOT.laser.angles
            ours = laser.cast(origin[None], headings[None], pipe.segments[None])[0]
            assert np.array_equal(reading.ranges[i], laser.measure(ROBOT.laser, ours))
            theirs = mujoco_rays(pipe, base, reading.q[i])
            met = np.isfinite(ours)
            directions = np.stack([np.cos(headings), np.sin(headings)], axis=1)
            ends = origin + np.where(met, ours, 0.0)[:, None] * directions
            to_edge = np.linalg.norm(ends[:, None] - pipe.walls.inner[1:-1], axis=2).min(axis=1)
            sure = met & (to_edge > 2 * INNER_THICKNESS)
            assert ours[sure] == pytest.approx(theirs[sure], abs=1e-6)
            out = np.isfinite(theirs) & ~met
            assert beyond_the_ends(pipe, origin + theirs[out, None] * directions[out])
            compared += int(sure.sum())
    assert compared > 850


def overlap(q: Floats, pipe: PipeCorner, base: float) -> float:
    """Deepest overlap of the links' rectangles with the walls of a mitred pipe, by separating axes."""
    pose = kinematics.forward(ROBOT, q[None])
    start, end = pipe.segments[:, 0], pipe.segments[:, 1]
    along = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
    free = np.stack([-along[:, 1], along[:, 0]], axis=1)
    before, edge, after = pipe.walls.inner
    deepest = 0.0
    for link, joint, heading in zip(ROBOT.links, pose.joints[0], pose.headings[0], strict=True):
        x, y = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
        centre, half = joint + [base, 0.0] + x * link.length / 2, np.array([link.length, link.width]) / 2
        corners = np.array([centre + i * half[0] * x + j * half[1] * y for i in (-1, 1) for j in (-1, 1)])
        behind = ((start - corners[:, None]) * free).sum(axis=2).max(axis=0)  # (segments,)
        wedge = list(behind[2:])  # how far the link would have to move along each direction out of the inner wall
        for axis, reach in ((x, half[0]), (y, half[1])):
            for direction in (axis, -axis):
                if (before - edge) @ direction >= 0 and (after - edge) @ direction >= 0:
                    wedge.append(reach - (edge - centre) @ direction)
        deepest = max(deepest, behind[:2].max(), min(wedge))
    return float(deepest)


def test_penetration_is_the_overlap_of_the_shapes() -> None:
    # Poses that physics produced, shaken a little into the walls; a contact pushes out, so that the first physics
    # step's overlap is the peak, but for pushing one contact out deepening another.
    rng = np.random.default_rng(3)
    now = scene(rng, 30)
    cases = []
    for _ in range(25):
        now.backend.step(Command("torque", duties(rng, 30)))
        q = now.backend.read().q + rng.normal(0, 0.01, (30, 4))
        depths = [overlap(*case) for case in zip(q, now.pipes, now.base, strict=True)]
        cases += [(i, q[i], depth) for i, depth in enumerate(depths) if 1e-5 < depth < 2e-3]
    which, q, depth = (list(column) for column in zip(*cases, strict=True))
    assert len(cases) > 80
    backend = MujocoBackend(ROBOT, len(cases), OPTIONS)
    backend.reset(np.arange(len(cases)), [now.pipes[i] for i in which], np.array(q), now.base[which])
    backend.step(Command("torque", np.zeros((len(cases), 4))))
    difference = np.abs(backend.truth().penetration - depth)
    assert np.median(difference) < 1e-12
    assert np.max(difference) < 1e-4


def test_without_contact_there_is_no_force() -> None:
    rng = np.random.default_rng(4)
    now = scene(rng, 20)
    apart = 0
    for _ in range(20):
        now.backend.step(Command("torque", duties(rng, 20)))
        truth = now.backend.truth()
        none = truth.contact_share == 0
        assert np.all(truth.contact_force[none] == 0)
        assert np.all(truth.penetration[none] == 0)
        apart += int(none.sum())
    assert 0 < apart < 400


def test_walls_hold_the_arm() -> None:
    rng = np.random.default_rng(5)
    now = scene(rng, 40)
    depths = []
    for _ in range(30):
        now.backend.step(Command("torque", duties(rng, 40)))
        depths.append(now.backend.truth().penetration)
    assert np.percentile(depths, 99) < 1.5e-3
    assert np.max(depths) < 3e-3


def test_a_timestep_that_does_not_divide_the_control_period_is_refused() -> None:
    with pytest.raises(PipenavError, match=r"timestep of 0\.003 s does not divide the control period of 0\.1 s"):
        MujocoBackend(ROBOT, 1, MujocoOptions(timestep=0.003))


def test_a_pipe_of_more_walls_than_it_was_opened_for_is_refused() -> None:
    pipe = PipeCorner.of(100, 90, bend_radius_mm=100)
    with pytest.raises(PipenavError, match=rf"has {len(pipe.segments)} wall segments, this backend was opened for 4"):
        MujocoBackend(ROBOT, 1, OPTIONS).reset(np.arange(1), [pipe], np.zeros((1, 4)), np.array([-0.6]))


def test_a_wall_pushes_back_on_the_link_that_leans_on_it() -> None:
    link = ROBOT.links[3]
    lever = ROBOT.model_copy(update={"links": (link,), "friction": 0.0})
    backend = MujocoBackend(lever, 2, OPTIONS)
    backend.reset(np.arange(2), [PipeCorner.of(100, 120)] * 2, np.zeros((2, 1)), np.full(2, -0.4))
    sides, duty = np.array([1.0, -1.0]), 0.4  # the first robot leans on the wall to its left, the second to its right
    for _ in range(10):
        backend.step(Command("torque", duty * sides[:, None]))
    forces, angle = backend.truth().link_forces[:, 0], np.abs(backend.read().q[:, 0])
    # At rest the motor's moment is that of the push on the tip's corner, which points away from the wall.
    arm = link.length * np.cos(angle) - link.width / 2 * np.sin(angle)
    assert forces[:, 1] == pytest.approx(-sides * duty * lever.effort_limits[0] / arm, rel=1e-3)
    assert forces[:, 0] == pytest.approx(0.0, abs=1e-6)
