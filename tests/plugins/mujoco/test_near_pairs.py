"""Pairs that are listed for a control period: they miss no contact, and alter no number."""

from __future__ import annotations

from contextlib import closing

import mujoco
import numpy as np
import pytest
from pipenav_mujoco import ways
from pipenav_mujoco.model import Contact
from pipenav_mujoco.near_pairs import NearPairs, Parts, Walls
from pipenav_mujoco.space_batch import SpaceBatch
from pipenav_mujoco.space_model import FRONT, space_spec
from pipenav_mujoco.space_walls import Layout
from pipenav_mujoco.ways import Way

from pipenav.arrays import Floats, Ints
from pipenav.backends.simulators import open_space
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_routes
from pipenav.robots import space_kinematics
from pipenav.robots.robot import load_robot

ROBOT = load_robot("pirate-strong")
ROUTES = [
    PipeRoute.of(90, [(90, "left", 0), (75, "right", 90), (120, "left", 90, 150)], [2500, 700, 700, 800]),
    PipeRoute.of(110, [(60, "right", 30)], [2500, 900]),
]
CONTACT = Contact(0.005, (0.95, 0.99, 0.001))
ROOM = 1500


def motion(gravity: float, steps: int) -> Floats:
    """Points of two robots that fall along x and roll forwards, at every step."""
    q = np.zeros((2, ROBOT.coordinates))
    q[:, 3:] = [[0.3, -0.6, 0.6, -0.6, 0.6, -0.3]] * 2
    speeds = np.concatenate([q[:, 3:], -5.0 * np.sign(q[:, 3:])], axis=1)
    with closing(open_space("mujoco", ROBOT, 2, {})) as backend:
        backend.incline(np.arange(2), np.array([[gravity, 0.0, -1.0], [gravity, 1.0, 0.0]]))
        backend.reset(np.arange(2), ROUTES, q, np.array([-2.0, -1.6]), np.array([0.0, 1.0]))
        points = []
        for _ in range(steps):
            backend.step(speeds, np.array([0.1, -0.1]))
            truth = backend.truth()
            points.append(np.concatenate([truth.points, truth.link_forces], axis=1))
    return np.array(points)


@pytest.mark.parametrize(("gravity", "hurries"), [(0.1, False), (9.81, True)])
def test_lists_of_near_pairs_alter_no_number(gravity: float, hurries: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    repeated, repeat = [], SpaceBatch._repeat

    def noted(self: SpaceBatch, indices: Ints, states: Floats, first: int, count: int) -> None:
        repeated.append(count)
        repeat(self, indices, states, first, count)

    monkeypatch.setattr(SpaceBatch, "_repeat", noted)
    some = motion(gravity, 15)
    assert (min(repeated, default=40) < 40) == hurries  # even halves of a period were too long
    for slack in ("SLACK", "MOST", "LEAST"):
        monkeypatch.setattr(ways, slack, 0.4)
    np.testing.assert_array_equal(some, motion(gravity, 15))


@pytest.mark.parametrize("route", parse_routes(["runs-rolled"])[::9], ids=lambda route: route.name)
def test_every_contact_is_in_the_list_in_its_order(route: PipeRoute) -> None:
    listed = space_spec(ROBOT, route, Layout.of(route)._replace(pairs=ROOM), 0.0025, CONTACT).compile()
    found_by_all = space_spec(ROBOT, route, Layout.of(route), 0.0025, CONTACT).compile()
    walls = Walls.of(listed)
    listed.body_contype[:] = listed.body_conaffinity[:] = 0
    pairs = NearPairs(Parts.of(ROBOT, listed, "middle" + FRONT), 1, len(walls.geom))
    pairs.take([listed], np.arange(1), [walls])
    rng, met = np.random.default_rng(0), 0
    line = route.legs.line(0.0, 0.0)
    for _ in range(60):
        i, share = rng.integers(len(line) - 1), rng.uniform()
        qpos = rng.uniform(-1.0, 1.0, listed.nq)
        qpos[:3] = (1 - share) * line[i] + share * line[i + 1]
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        joints = [listed.joint(joint.name).qposadr[0] for joint in ROBOT.joints]
        roll = qpos[None, listed.joint("roll").qposadr[0]]
        points = space_kinematics.forward(ROBOT, qpos[None, :7], qpos[None, joints], roll).points
        assert pairs.find(np.arange(1), Way.resting(points)) <= ROOM
        both = []
        for model in (listed, found_by_all):
            data = mujoco.MjData(model)
            data.qpos[:] = qpos
            mujoco.mj_forward(model, data)
            contact = data.contact
            numbers = contact.dist, contact.pos, contact.frame, contact.friction, contact.solref, contact.solimp
            both.append(np.column_stack([contact.geom, *numbers]))
            np.testing.assert_allclose(data.body("middle").xpos, points[0, 3], atol=1e-12)
        np.testing.assert_array_equal(*both)
        met += len(both[0])
    assert met > 300
