"""Laws of motion that every simulator with physics obeys: no joint is stronger or faster than its motor."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from contextlib import ExitStack, closing
from typing import Protocol

import numpy as np
import pytest

from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command
from pipenav.backends.simulators import SimulatorSettings
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec, load_robot

ROBOT = load_robot("basic")


class Alone(Protocol):
    """Opens a simulator with one robot at rest in a pipe, its frame at `base` [m]."""

    def __call__(self, robot: RobotSpec, pipe: PipeCorner, base: float) -> Simulator: ...


@pytest.fixture(
    params=[
        "mujoco",
        pytest.param(
            "pybullet",
            marks=[
                pytest.mark.slow,
                pytest.mark.skipif(importlib.util.find_spec("pybullet") is None, reason="pybullet is not installed"),
            ],
        ),
    ]
)
def alone(request: pytest.FixtureRequest) -> Iterator[Alone]:
    with ExitStack() as stack:

        def opened(robot: RobotSpec, pipe: PipeCorner, base: float) -> Simulator:
            backend = stack.enter_context(closing(SimulatorSettings(request.param).open(robot, 1)))
            backend.reset(np.arange(1), [pipe], np.zeros((1, len(robot.joints))), np.array([base]))
            return backend

        yield opened


def links(*indices: int, friction: float = 0.0) -> RobotSpec:
    """Some links of the robot alone."""
    return ROBOT.model_copy(update={"links": tuple(ROBOT.links[i] for i in indices), "friction": friction})


def drive(backend: Simulator, duty: list[float], steps: int) -> None:
    for _ in range(steps):
        backend.step(Command("torque", np.array([duty])))


@pytest.mark.parametrize("link", [0, 1])
def test_a_joint_nears_its_no_load_speed_and_never_exceeds_it(alone: Alone, link: int) -> None:
    # J dv/dt = limit * duty - damping * v: v = v_max (1 - exp(-t damping / J)).
    robot = links(link)
    actuator, body = robot.joint_actuators[0], robot.links[0]
    inertia = body.mass
    if link:
        inertia = body.mass * (body.length**2 / 3 + body.width**2 / 12)  # of a box about its end
    rate = actuator.damping / (inertia + actuator.armature)
    backend = alone(robot, PipeCorner.of(300, 180), -0.3)
    for k in range(1, 5):
        drive(backend, [1.0], 1)
        speed = backend.read().qd[0, 0]
        assert speed <= actuator.speed_limit * (1 + 1e-12)
        assert speed == pytest.approx(actuator.speed_limit * (1 - np.exp(-0.1 * k * rate)), rel=1e-2)


def test_a_slide_presses_with_its_stall_effort(alone: Alone) -> None:
    # Pushing head-on into the far wall of a 90 deg corner.
    robot = links(0)
    backend = alone(robot, PipeCorner.of(100, 90), -0.2)
    drive(backend, [1.0], 20)
    effort = robot.effort_limits[0]
    assert backend.read().q[0, 0] == pytest.approx(0.2 + 0.05 - 0.04, abs=1e-4)
    assert backend.truth().contact_force[0] == pytest.approx(effort, rel=1e-3)
    assert backend.truth().link_forces[0] == pytest.approx(np.array([[-effort, 0.0]]), rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("duty", [-1.0, -0.5, 0.3, 1.0])
def test_a_hinge_presses_by_the_law_of_the_lever(alone: Alone, duty: float) -> None:
    # The link turns until its front corner meets the straight wall; without friction the wall pushes across the
    # pipe only, so force * (the corner's distance along the pipe) = duty * stall torque.
    robot, pipe = links(1), PipeCorner.of(100, 180)
    backend = alone(robot, pipe, -0.3)
    drive(backend, [duty], 25)
    q, body = abs(backend.read().q[0, 0]), robot.links[0]
    lever = body.length * np.cos(q) - body.width / 2 * np.sin(q)
    height = body.length * np.sin(q) + body.width / 2 * np.cos(q)
    assert height == pytest.approx(pipe.radius, abs=1e-4)
    force = duty * robot.effort_limits[0] / lever
    assert backend.truth().contact_force[0] == pytest.approx(abs(force), rel=1e-3)
    assert backend.truth().link_forces[0, 0] == pytest.approx([0.0, -force], rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("angle", [55, 65, 90, 125])
def test_a_link_that_slides_slowly_along_the_inner_wall_is_not_stopped_at_its_edge(
    alone: Alone, angle: float, request: pytest.FixtureRequest
) -> None:
    if angle == 55 and "mujoco" in request.node.name:
        known = "the second leg's box sticks out by 0.06 mm, and a slow link stops there until it is pushed harder"
        request.applymarker(pytest.mark.xfail(strict=True, reason=known))
    robot, pipe = links(0, 1, friction=ROBOT.friction), PipeCorner.of(70, angle)
    backend = alone(robot, pipe, -pipe.inner_edge - 0.05 - robot.length)
    drive(backend, [0.0, 0.3], 5)
    assert backend.truth().contact_share[0] == 1.0
    drive(backend, [0.2, 0.3], 20)
    assert backend.truth().tip[0, 0] > -pipe.inner_edge + robot.width / 2


def test_friction_takes_its_share_of_the_push(alone: Alone) -> None:
    # The two-link arm presses sideways on the wall with its hinge while its slide pulls along the pipe: at rest, the
    # wall's force on the tip, friction included, has the pull as its component along the pipe.
    robot = links(0, 1, friction=0.8)
    backend = alone(robot, PipeCorner.of(100, 180), -0.3)
    drive(backend, [0.0, 0.6], 25)
    drive(backend, [-0.05, 0.6], 5)
    reading, pull = backend.read(), 0.05 * robot.effort_limits[0]
    assert reading.qd == pytest.approx(np.zeros((1, 2)), abs=1e-4)
    q, body, torque = reading.q[0, 1], robot.links[1], 0.6 * robot.effort_limits[1]
    x = body.length * np.cos(q) - body.width / 2 * np.sin(q)
    y = body.length * np.sin(q) + body.width / 2 * np.cos(q)
    across = (torque - pull * y) / x  # moments about the hinge; the wall pushes down, and forwards against the pull
    force = backend.truth().link_forces[0]
    assert force == pytest.approx(np.array([[0.0, 0.0], [pull, -across]]), rel=5e-3, abs=1e-6)


def test_the_position_controller_goes_to_its_set_points_and_stays(alone: Alone) -> None:
    backend = alone(ROBOT, PipeCorner.of(300, 180), -0.3)
    drive(backend, [1.0] * 4, 1)
    set_points = np.array([[0.1, 0.1, -0.2, 0.15]])
    for _ in range(30):
        backend.step(Command("position", set_points))
    assert backend.read().q == pytest.approx(set_points, abs=1e-6)
    assert backend.read().qd == pytest.approx(0.0, abs=1e-5)
