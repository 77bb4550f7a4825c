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
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig

pytestmark = pytest.mark.slow

ROBOT = load_robot("basic")


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
    (process,) = [worker.process for worker in backend._crew._workers]
    process.kill()
    process.wait()
    with pytest.raises(PipenavError, match="a process of the PyBullet backend has ended"):
        backend.step(Command("torque", np.zeros((2, 4))))
    backend.close()


def test_closing_ends_the_processes() -> None:
    backend, _, _ = crowd(18, processes=2)
    processes = [worker.process for worker in backend._crew._workers]
    assert len(processes) == 2
    backend.close()
    assert all(process.poll() == 0 for process in processes)


def test_a_timestep_that_does_not_divide_the_control_period_is_refused() -> None:
    with pytest.raises(PipenavError, match=r"timestep of 0\.0015 s does not divide the control period of 0\.1 s"):
        PybulletBackend(ROBOT, 1, PybulletOptions(timestep=0.0015))


def test_importing_it_writes_nothing() -> None:
    done = subprocess.run([sys.executable, "-c", "import pipenav_pybullet"], capture_output=True, text=True, check=True)
    assert done.stdout == done.stderr == ""
