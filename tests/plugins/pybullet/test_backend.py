"""The PyBullet backend: motors, contacts and beams by the laws of physics, and processes that behave."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from pipenav.arrays import Floats

pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")

from pipenav_pybullet.backend import PybulletBackend, PybulletOptions

from pipenav.backends.messages import Command, Reading
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.wall_distance import wall_distance
from pipenav.robots import kinematics, laser
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig

pytestmark = pytest.mark.slow

ROBOT = load_robot("basic")


def alone(robot: RobotSpec, pipe: PipeCorner, base: float) -> PybulletBackend:
    backend = PybulletBackend(robot, 1, PybulletOptions())
    backend.reset(np.arange(1), [pipe], np.zeros((1, len(robot.joints))), np.array([base]))
    return backend


def crowd(n: int, processes: int = 1, seed: int = 1) -> tuple[PybulletBackend, list[PipeCorner], Floats]:
    """n robots at random starts in random pipes; also the pipes and the robots' bases."""
    rng = np.random.default_rng(seed)
    turns = [("left", "right")[i % 2] for i in range(n)]
    pipes = [PipeCorner.of(rng.uniform(70, 120), rng.uniform(55, 125), turn) for turn in turns]
    start = episode.sample(ROBOT, ReachConfig(), pipes, rng)
    backend = PybulletBackend(ROBOT, n, PybulletOptions(processes=processes))
    backend.reset(np.arange(n), pipes, start.q, start.base)
    return backend, pipes, start.base


def duties(rng: np.random.Generator, n: int) -> Command:
    """Random drives that push the arms into their corners, so that they meet the walls often."""
    values = rng.uniform(-1, 1, (n, 4))
    values[:, 0] = 0.3 + 0.7 * np.abs(values[:, 0])
    return Command("torque", values)


def single(link: int, friction: float = 0.0) -> RobotSpec:
    """One link of the robot alone."""
    return ROBOT.model_copy(update={"links": (ROBOT.links[link],), "friction": friction})


def test_a_slide_nears_its_no_load_speed_and_never_exceeds_it() -> None:
    # (m + rotor) dv/dt = limit * duty - damping * v: v = v_max (1 - exp(-t damping / (m + rotor))).
    robot = single(0)
    actuator = robot.joint_actuators[0]
    rate = actuator.damping / (robot.links[0].mass + actuator.armature)
    backend = alone(robot, PipeCorner.of(300, 180), -0.3)
    for k in range(1, 5):
        backend.step(Command("torque", np.ones((1, 1))))
        speed = backend.read().qd[0, 0]
        assert speed <= actuator.speed_limit * (1 + 1e-12)
        assert speed == pytest.approx(actuator.speed_limit * (1 - np.exp(-0.1 * k * rate)), rel=1e-2)
    backend.close()


def test_a_slide_presses_with_its_stall_effort() -> None:
    robot = single(0)
    backend = alone(robot, PipeCorner.of(100, 90), -0.2)
    for _ in range(20):
        backend.step(Command("torque", np.ones((1, 1))))
    assert backend.read().q[0, 0] == pytest.approx(0.2 + 0.05 - 0.04, abs=1e-4)
    assert backend.truth().contact_force[0] == pytest.approx(robot.effort_limits[0], rel=1e-3)
    backend.close()


@pytest.mark.parametrize("duty", [-1.0, 0.3])
def test_a_hinge_presses_by_the_law_of_the_lever(duty: float) -> None:
    robot, pipe = single(1), PipeCorner.of(100, 180)
    backend = alone(robot, pipe, -0.3)
    for _ in range(25):
        backend.step(Command("torque", np.full((1, 1), duty)))
    q, body = abs(backend.read().q[0, 0]), robot.links[0]
    lever = body.length * np.cos(q) - body.width / 2 * np.sin(q)
    height = body.length * np.sin(q) + body.width / 2 * np.cos(q)
    assert height == pytest.approx(pipe.radius, abs=1e-4)
    assert backend.truth().contact_force[0] == pytest.approx(abs(duty) * robot.effort_limits[0] / lever, rel=1e-3)
    backend.close()


@pytest.mark.parametrize("angle", [55, 65, 90, 125])
def test_a_link_that_slides_slowly_along_the_inner_wall_is_not_stopped_at_its_edge(angle: float) -> None:
    robot, pipe = ROBOT.model_copy(update={"links": ROBOT.links[:2]}), PipeCorner.of(70, angle)
    backend = alone(robot, pipe, -pipe.inner_edge - 0.05 - robot.length)
    for _ in range(5):
        backend.step(Command("torque", np.array([[0.0, 0.3]])))
    assert backend.truth().contact_share[0] == 1.0
    for _ in range(20):
        backend.step(Command("torque", np.array([[0.2, 0.3]])))
    assert backend.truth().tip[0, 0] > -pipe.inner_edge + robot.width / 2
    backend.close()


def test_friction_takes_its_share_of_the_push() -> None:
    # The two-link arm presses sideways on the wall with its hinge while its slide pulls along the pipe: at rest, the
    # wall's force on the tip, friction included, has the pull as its component along the pipe.
    robot = ROBOT.model_copy(update={"links": ROBOT.links[:2], "friction": 0.8})
    backend = alone(robot, PipeCorner.of(100, 180), -0.3)
    for _ in range(25):
        backend.step(Command("torque", np.array([[0.0, 0.6]])))
    for _ in range(5):
        backend.step(Command("torque", np.array([[-0.05, 0.6]])))
    reading, pull = backend.read(), 0.05 * robot.effort_limits[0]
    assert reading.qd == pytest.approx(np.zeros((1, 2)), abs=1e-4)
    q, body, torque = reading.q[0, 1], robot.links[1], 0.6 * robot.effort_limits[1]
    x = body.length * np.cos(q) - body.width / 2 * np.sin(q)
    y = body.length * np.sin(q) + body.width / 2 * np.cos(q)
    across = (torque - pull * y) / x  # moments about the hinge; the wall pushes down, and forwards against the pull
    assert backend.truth().link_forces[0] == pytest.approx(np.array([[0.0, 0.0], [pull, -across]]), rel=1e-3, abs=1e-6)
    backend.close()


def test_the_position_controller_goes_to_its_set_points_and_stays() -> None:
    backend = alone(ROBOT, PipeCorner.of(300, 180), -0.3)
    backend.step(Command("torque", np.ones((1, 4))))
    set_points = np.array([[0.1, 0.1, -0.2, 0.15]])
    for _ in range(30):
        backend.step(Command("position", set_points))
    assert backend.read().q == pytest.approx(set_points, abs=1e-6)
    assert backend.read().qd == pytest.approx(0.0, abs=1e-5)
    backend.close()


def test_walls_hold_the_arm_and_penetration_is_the_overlap_of_the_shapes() -> None:
    rng = np.random.default_rng(5)
    n = 16
    backend, pipes, base = crowd(n)
    depths, overlap, free = [], np.zeros(n), 0
    for _ in range(25):
        backend.step(duties(rng, n))
        truth, q = backend.truth(), backend.read().q
        depths.append(truth.penetration)
        assert np.all(truth.penetration > overlap - 6e-5)  # as the period before ended; walls end 5e-5 before edges
        overlap = np.array([-wall_distance(ROBOT, *where) for where in zip(pipes, q, base, strict=True)])
        none = truth.contact_share == 0
        assert np.all(truth.contact_force[none] == 0)
        assert np.all(truth.penetration[none] == 0)
        free += int(none.sum())
    assert 0 < free < 25 * n
    assert np.percentile(depths, 99) < 1.5e-3
    assert np.max(depths) < 2e-3
    backend.close()


def test_beams_end_at_the_walls() -> None:
    rng = np.random.default_rng(6)
    n = 16
    backend, pipes, base = crowd(n, seed=2)
    for _ in range(20):
        backend.step(duties(rng, n))
        pose = kinematics.forward(ROBOT, backend.read().q)
        beams = pose.headings[:, -1:] + ROBOT.laser.angles
        segments = np.stack([pipe.segments - [x, 0.0] for pipe, x in zip(pipes, base, strict=True)])
        true = laser.measure(ROBOT.laser, laser.cast(pose.tip, beams, segments))
        assert backend.read().ranges == pytest.approx(true, abs=1e-9)
    backend.close()


def run(backend: PybulletBackend, n: int, steps: int) -> Reading:
    rng = np.random.default_rng(2)
    for _ in range(steps):
        backend.step(duties(rng, n))
    reading = backend.read()
    backend.close()
    return reading


def test_any_number_of_processes_gives_the_same_bits() -> None:
    n = 36  # three worlds
    one, many = run(crowd(n)[0], n, 10), run(crowd(n, processes=3)[0], n, 10)
    for a, b in zip(one, many, strict=True):
        assert np.array_equal(a, b)


def test_a_process_that_has_died_is_an_error_of_one_sentence_and_closing_still_works() -> None:
    backend, _, _ = crowd(2)
    (process,) = backend._crew._processes
    process.kill()
    process.wait()
    with pytest.raises(PipenavError, match="a process of the PyBullet backend has ended"):
        backend.step(Command("torque", np.zeros((2, 4))))
    backend.close()


def test_closing_ends_the_processes() -> None:
    backend, _, _ = crowd(18, processes=2)
    processes = list(backend._crew._processes)
    assert len(processes) == 2
    backend.close()
    assert all(process.poll() == 0 for process in processes)


def test_a_timestep_that_does_not_divide_the_control_period_is_refused() -> None:
    with pytest.raises(PipenavError, match=r"timestep of 0\.0015 s does not divide the control period of 0\.1 s"):
        PybulletBackend(ROBOT, 1, PybulletOptions(timestep=0.0015))


def test_importing_it_writes_nothing() -> None:
    done = subprocess.run([sys.executable, "-c", "import pipenav_pybullet"], capture_output=True, text=True, check=True)
    assert done.stdout == done.stderr == ""
