"""Exported robots are, in every engine that loads them, the robots that they came from."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from helpers.robot_engines import ENGINES, LoadedRobot
from hypothesis import given, settings
from hypothesis import strategies as st
from pipenav_mujoco.model import Contact, build_spec

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.export.robot_model import write_robot
from pipenav.robots import RobotSpec, kinematics, load_robot, robot_names, space_kinematics
from pipenav.robots.bodies import FRONT, Piece, divided, inertia, link_pieces, robot_bodies
from pipenav.robots.parts import BoxPart, DiscPart, Wheel

ROBOTS = robot_names()
POSES = 20


@pytest.fixture(scope="module", params=[(robot, engine) for robot in ROBOTS for engine in ENGINES], ids=" in ".join)
def loaded(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[RobotSpec, LoadedRobot]:
    name, engine = request.param
    suffix, load = ENGINES[engine]
    file = tmp_path_factory.mktemp("robots") / f"{name}{suffix}"
    write_robot(load_robot(name), file)
    return load_robot(name), load(file)


def random_positions(robot: RobotSpec, seed: int) -> dict[str, float]:
    """Random positions of all joints within their limits, the roll joint's too."""
    rng = np.random.default_rng(seed)
    joints = [*robot.joints, *([robot.roll.joint] if robot.roll else [])]
    return {joint.name: float(rng.uniform(joint.lower, joint.upper)) for joint in joints}


def origins(robot: RobotSpec, positions: dict[str, float]) -> Floats:
    """Origins of the links by our own kinematics, (links, 3) [m]: where each joint is, a slide's position included."""
    q = np.array([[positions[joint.name] for joint in robot.joints]])
    if robot.roll is not None:
        at_origin = np.array([[0.0, 0, 0, 1, 0, 0, 0]])
        return space_kinematics.forward(robot, at_origin, q, np.array([positions[robot.roll.joint.name]])).points[
            0, :-1
        ]
    configuration = np.concatenate([np.zeros((1, 3)), q], axis=1) if robot.free else q
    points = kinematics.forward(robot, configuration).joints[0]
    return np.pad(points, ((0, 0), (0, 1)))


def test_links_are_where_our_kinematics_say(loaded: tuple[RobotSpec, LoadedRobot]) -> None:
    robot, engine = loaded
    for seed in range(POSES):
        positions = random_positions(robot, seed)
        found, ours = engine.origins(positions), origins(robot, positions)
        for link, point in zip(robot.links, ours, strict=True):
            if link.name in found:  # of the fixed base that Bullet keeps at the origin it tells nothing
                np.testing.assert_allclose(found[link.name], point, atol=2e-6, err_msg=link.name)


def test_masses_are_those_of_the_description(loaded: tuple[RobotSpec, LoadedRobot]) -> None:
    robot, engine = loaded
    ours = {link.name: link.mass for link in robot.links} | {wheel.name: wheel.mass for wheel in robot.wheels}
    found = {name: mass for name, mass in engine.masses.items() if name != "world"}
    if robot.roll is not None:
        found[robot.roll.link] += found.pop(robot.roll.link + FRONT)
    assert found == pytest.approx(ours, rel=1e-6)


def test_limits_are_those_of_the_description(loaded: tuple[RobotSpec, LoadedRobot]) -> None:
    robot, engine = loaded
    joints = [*robot.joints, *([robot.roll.joint] if robot.roll else [])]
    assert engine.limits.keys() == {joint.name for joint in joints}
    for joint in joints:
        assert engine.limits[joint.name] == pytest.approx((joint.lower, joint.upper), rel=1e-6)


def test_inertias_are_ours(loaded: tuple[RobotSpec, LoadedRobot]) -> None:
    robot, engine = loaded
    for body in robot_bodies(robot):
        if body.name in engine.inertias:
            own = inertia(body.pieces)
            matrix = np.array([[own.xx, own.xy, 0], [own.xy, own.yy, 0], [0, 0, own.zz]])
            np.testing.assert_allclose(engine.inertias[body.name], matrix, rtol=1e-5, atol=1e-12, err_msg=body.name)


def test_no_part_of_the_robot_meets_another(loaded: tuple[RobotSpec, LoadedRobot]) -> None:
    """Wheels overlap the links that they sit between, which must not push them apart."""
    robot, engine = loaded
    if engine.contacts is not None:
        assert sum(engine.contacts(random_positions(robot, seed)) for seed in range(POSES)) == 0


@pytest.mark.parametrize("name", [name for name in ROBOTS if load_robot(name).roll is None])
def test_the_model_moves_as_the_simulators(name: str, tmp_path: Path) -> None:
    """The same mass matrix, damping, motors and limits of force as in the model that trainings run on."""
    robot = load_robot(name)
    write_robot(robot, tmp_path / "robot.xml")
    ours = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    theirs = build_spec(robot, 0, 0.002, Contact(0.004, (0.9, 0.95, 0.001))).compile()
    assert [ours.joint(i).name for i in range(ours.njnt)] == [theirs.joint(i).name for i in range(theirs.njnt)]
    np.testing.assert_allclose(ours.dof_damping, theirs.dof_damping)
    np.testing.assert_allclose(ours.actuator_forcerange, theirs.actuator_forcerange)
    for seed in range(POSES):
        matrices = []
        for model in (ours, theirs):
            data = mujoco.MjData(model)
            for joint, value in random_positions(robot, seed).items():
                data.joint(joint).qpos[:] = value
            mujoco.mj_forward(model, data)
            matrix = np.zeros((model.nv, model.nv))
            mujoco.mj_fullM(model, data, matrix)
            matrices.append(matrix)
        np.testing.assert_allclose(*matrices, rtol=1e-6, atol=1e-12)


def test_controllers_hold_what_they_are_told(tmp_path: Path) -> None:
    write_robot(load_robot("basic"), tmp_path / "robot.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    data = mujoco.MjData(model)
    asked = np.array([0.05, 0.4, -0.3, 0.2])
    data.ctrl[:] = asked
    while data.time < 5.0:
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.qpos, asked, atol=1e-3)


parts = st.one_of(
    st.builds(
        BoxPart,
        x=st.floats(-0.1, 0.3),
        y=st.floats(-0.02, 0.02),
        length=st.floats(0.001, 0.2),
        width=st.floats(0.001, 0.1),
        height=st.floats(0.001, 0.1),
    ),
    st.builds(
        DiscPart,
        shape=st.just("disc"),
        x=st.floats(-0.1, 0.3),
        diameter=st.floats(0.001, 0.1),
        height=st.floats(0.001, 0.1),
    ),
)
pieces = st.lists(st.builds(Piece, parts, st.floats(0.001, 10)), min_size=1, max_size=5)


@given(pieces=pieces)
@settings(deadline=None)
def test_bodies_are_possible(pieces: list[Piece]) -> None:
    """No moment is larger than the sum of the other two, and a flat body would have the sum of both in its plane."""
    own = inertia(pieces)
    moments = np.linalg.eigvalsh([[own.xx, own.xy, 0], [own.xy, own.yy, 0], [0, 0, own.zz]])
    assert moments[0] > 0
    assert moments[2] <= (moments[0] + moments[1]) * (1 + 1e-9)


@given(pieces=pieces, at=st.floats(-0.2, 0.4))
@settings(deadline=None)
def test_a_cut_loses_nothing(pieces: list[Piece], at: float) -> None:
    """Mass, centre of mass and, of boxes, the moments stay."""
    rear, front = divided(pieces, at)
    joined = [*rear, *(Piece(p.part.model_copy(update={"x": p.part.x + at}), p.mass) for p in front)]
    whole, cut = inertia(pieces), inertia(joined)
    assert cut[:3] == pytest.approx(whole[:3], rel=1e-9, abs=1e-12)
    if all(isinstance(piece.part, BoxPart) for piece in pieces):
        assert cut == pytest.approx(whole, rel=1e-6, abs=1e-12)


def test_all_of_a_robot_is_in_its_bodies() -> None:
    for name in ROBOTS:
        robot = load_robot(name)
        bodies = robot_bodies(robot)
        weight = sum(piece.mass for body in bodies for piece in body.pieces)
        expected = sum(link.mass for link in robot.links) + sum(wheel.mass for wheel in robot.wheels)
        assert weight == pytest.approx(expected)
        assert {body.name for body in bodies if isinstance(body.joint, Wheel)} == {w.name for w in robot.wheels}
        seen: set[str | None] = {None}
        for body in bodies:
            assert body.parent in seen
            seen.add(body.name)
        assert [piece.mass for piece in link_pieces(robot.links[0])] == pytest.approx([robot.links[0].mass])


def test_another_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match=r"must end in \.urdf"):
        write_robot(load_robot("basic"), tmp_path / "robot.sdf")
    assert not list(tmp_path.iterdir())
