"""Laws of motion of the MuJoCo backend: reproducible, symmetric, and no stronger or faster than its motors."""

from __future__ import annotations

import numpy as np
import pytest
from pipenav_mujoco.backend import MujocoBackend, MujocoOptions

from pipenav.backends.messages import Command, Reading
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig

ROBOT = load_robot("basic")
N = 12


def pipes(turn: str = "left") -> list[PipeCorner]:
    rng = np.random.default_rng(0)
    return [PipeCorner.of(rng.uniform(70, 120), rng.uniform(55, 125), turn) for _ in range(N)]


def opened(turn: str = "left", threads: int = 1) -> MujocoBackend:
    """N robots at random starts."""
    backend = MujocoBackend(ROBOT, N, MujocoOptions(threads=threads))
    start = episode.sample(ROBOT, ReachConfig(), pipes(), np.random.default_rng(1))
    q = start.q if turn == "left" else start.q * ROBOT.mirror_signs
    backend.reset(np.arange(N), pipes(turn), q, start.base)
    return backend


def run(backend: MujocoBackend, steps: int, signs: object = 1.0) -> Reading:
    rng = np.random.default_rng(2)
    for _ in range(steps):
        values = rng.uniform(-1, 1, (N, 4))
        values[:, 0] = np.abs(values[:, 0])
        backend.step(Command("torque", values * signs))
    return backend.read()


def equal(one: Reading, two: Reading, indices: object = slice(None)) -> bool:
    pairs = zip(one.measured().items(), two.measured().items(), strict=True)
    return all(name == other and np.array_equal(a[indices], b[indices]) for (name, a), (other, b) in pairs)


@pytest.mark.parametrize("threads", [2, 5])
def test_any_number_of_threads_gives_the_same_bits(threads: int) -> None:
    one, many = opened(), opened(threads=threads)
    assert equal(run(one, 20), run(many, 20))
    for a, b in zip(one.truth(), many.truth(), strict=True):
        assert np.array_equal(a, b)


def test_the_reset_of_some_leaves_the_others_alone() -> None:
    undisturbed, disturbed = opened(), opened()
    run(undisturbed, 8)
    run(disturbed, 8)
    chosen = np.array([3, 7])
    before = disturbed.truth()
    disturbed.reset(chosen, [PipeCorner.of(75, 60, "right")] * 2, np.full((2, 4), 0.01), np.array([-0.7, -0.8]))
    others = np.setdiff1d(np.arange(N), chosen)
    assert equal(undisturbed.read(), disturbed.read(), others)
    for a, b in zip(before, disturbed.truth(), strict=True):
        assert np.array_equal(a[others], b[others])
    assert np.all(disturbed.truth().contact_force[chosen] == 0)
    assert disturbed.read().time[chosen].tolist() == [0.0, 0.0]
    assert equal(run(undisturbed, 12), run(disturbed, 12), others)


def test_a_reset_forgets_everything() -> None:
    fresh, used = opened(), opened()
    run(used, 10)
    start = episode.sample(ROBOT, ReachConfig(), pipes(), np.random.default_rng(1))
    used.reset(np.arange(N), pipes(), start.q, start.base)
    assert equal(run(fresh, 10), run(used, 10))


def test_left_and_right_mirror_each_other() -> None:
    signs = ROBOT.mirror_signs
    left, right = opened("left"), opened("right")
    one, two = run(left, 25), run(right, 25, signs)
    assert one.q == pytest.approx(two.q * signs, abs=1e-9)
    assert np.array_equal(one.ranges, two.ranges[:, ::-1])
    assert left.truth().contact_force == pytest.approx(right.truth().contact_force, abs=1e-5)
    assert left.truth().link_forces == pytest.approx(right.truth().link_forces * [1, -1], abs=1e-5)


def test_readings_belong_to_the_caller() -> None:
    backend = opened()
    kept = [array for _ in range(2) for array in (*backend.read().measured().values(), *backend.truth())]
    copies = [array.copy() for array in kept]
    run(backend, 3)
    assert all(np.array_equal(a, b) for a, b in zip(kept, copies, strict=True))
    assert not any(np.shares_memory(a, b) for i, a in enumerate(kept) for b in kept[:i])
