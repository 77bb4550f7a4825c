"""A disturbed simulator: late commands, bad readings and uneven robots, the same whenever an episode is repeated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Backend, BackendOptions, Variation
from pipenav.backends.messages import Command, Control, Reading
from pipenav.backends.viewer import Viewer
from pipenav.disturbances.disturbance import UNDISTURBED, Disturbance
from pipenav.disturbances.disturbed_backend import DisturbedSimulator, disturbed
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.testing import CONTRACT, Bench, KinematicBackend, KinematicOptions, starts

ROBOT = load_robot("basic")
LASER = ROBOT.laser
WORST = Disturbance(latency=(0, 2), noise=(0.0, 0.02), dropouts=(0.0, 0.4), missing=(0.0, 0.3))

TRUE_READINGS = {
    "check_nothing_constant",
    "check_tip_and_ranges_fit_the_pose",
    "check_commands_move_the_right_way",
    "check_left_and_right_mirror",
}
"""Laws that bad readings and late commands break by their nature."""


def plain(n: int) -> KinematicBackend:
    return KinematicBackend(ROBOT, n, KinematicOptions())


class Bothered(DisturbedSimulator):
    Options = KinematicOptions

    def __init__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int = 4) -> None:
        super().__init__(KinematicBackend(robot, n, options, wall_segments), robot, n, WORST, 0)


@pytest.mark.parametrize("check", [check for check in CONTRACT if check.__name__ not in TRUE_READINGS])
def test_it_keeps_the_contract(check: Callable[[Bench], None]) -> None:
    check(Bench(Bothered))


def test_nothing_stands_between_where_nothing_is_disturbed() -> None:
    backend = plain(2)
    assert disturbed(backend, ROBOT, 2, UNDISTURBED, 0) is backend
    assert disturbed(backend, ROBOT, 2, Disturbance(start_bend=0.2), 0) is backend
    assert disturbed(backend, ROBOT, 2, WORST, 0) is not backend


def run(backend: Backend, n: int, commands: list[Command], rows: Ints | None = None) -> list[Reading]:
    """Readings of n robots from the contract's starts on, or from some rows of more starts."""
    start = starts(Bench(KinematicBackend, n=6))
    rows = np.arange(n) if rows is None else rows
    readings = [backend.reset(np.arange(n), [start.pipes[i] for i in rows], start.q[rows], start.base[rows])]
    for command in commands:
        backend.step(command)
        readings.append(backend.read())
    return readings


@settings(deadline=None, max_examples=15)
@given(latency=st.integers(0, 5), control=st.sampled_from(["torque", "position"]))
def test_commands_arrive_so_many_steps_late(latency: int, control: Control) -> None:
    n = 2
    commands = Bench(KinematicBackend, n=n).commands(12, control)
    on_time = run(plain(n), n, commands)
    late = run(DisturbedSimulator(plain(n), ROBOT, n, Disturbance(latency=(latency, latency)), 0), n, commands)
    for step, reading in enumerate(late):
        np.testing.assert_array_equal(reading.q, on_time[max(step - latency, 0)].q)


def stand(disturbance: Disturbance, n: int = 40, steps: int = 50) -> tuple[Floats, Floats]:
    """Readings of robots that stand still in a wide pipe, (steps, n, beams), and the true ones, (beams,)."""
    backend = DisturbedSimulator(plain(n), ROBOT, n, disturbance, 0)
    pipe = PipeCorner.of(300, 60)
    base = np.linspace(-0.7, -0.69, n)
    backend.reset(np.arange(n), [pipe] * n, np.zeros((n, 4)), base)
    seen = []
    for _ in range(steps):
        backend.step(Command("position", np.zeros((n, 4))))
        seen.append(backend.read().ranges)
    quiet = plain(n)
    return np.array(seen), quiet.reset(np.arange(n), [pipe] * n, np.zeros((n, 4)), base).ranges


def test_readings_scatter_by_the_noise_and_stay_what_the_laser_can_tell() -> None:
    seen, true = stand(Disturbance(noise=(0.02, 0.02)))
    error = (seen - true)[:, true < LASER.range_max - 0.1]
    assert abs(error.mean()) < 1e-3
    assert error.std() == pytest.approx(0.02, rel=0.05)
    assert np.all(seen[:, true == LASER.range_max] == LASER.range_max)
    assert np.all((seen >= LASER.range_min) & (seen <= LASER.range_max))
    np.testing.assert_allclose(seen / LASER.resolution, np.round(seen / LASER.resolution), atol=1e-9)


def test_so_many_readings_drop_to_the_minimum_each_on_its_own() -> None:
    seen, true = stand(Disturbance(dropouts=(0.3, 0.3)))
    dropped = seen == LASER.range_min
    assert not np.any(true == LASER.range_min)
    assert dropped.mean() == pytest.approx(0.3, abs=0.02)
    assert np.all(seen[~dropped] == np.broadcast_to(true, seen.shape)[~dropped])
    together = (dropped[:, :, 0] & dropped[:, :, 1]).mean()
    in_a_row = (dropped[1:] & dropped[:-1]).mean()
    assert together == pytest.approx(0.09, abs=0.02)
    assert in_a_row == pytest.approx(0.09, abs=0.02)


def test_missing_beams_are_missing_all_episode_long() -> None:
    seen, true = stand(Disturbance(missing=(0.25, 0.25)), n=200, steps=5)
    lost = seen == LASER.range_max
    assert np.all(lost == lost[0])
    near = true < LASER.range_max
    assert lost[0][near].mean() == pytest.approx(0.25, abs=0.03)


@settings(deadline=None, max_examples=10)
@given(rows=st.permutations(range(6)).map(lambda order: np.array(order[:3])), seed=st.integers(0, 2**31))
def test_an_episode_does_not_depend_on_its_neighbours(rows: Ints, seed: int) -> None:
    commands = Bench(KinematicBackend, n=6).commands(6)
    all_of_them = run(DisturbedSimulator(plain(6), ROBOT, 6, WORST, seed), 6, commands, np.arange(6))
    some = [Command(control, values[rows]) for control, values in commands]
    few = run(DisturbedSimulator(plain(3), ROBOT, 3, WORST, seed), 3, some, rows)
    for one, other in zip(all_of_them, few, strict=True):
        for name, b in other.measured().items():
            np.testing.assert_array_equal(one.measured()[name][rows], b)


def test_another_seed_or_another_start_is_disturbed_otherwise() -> None:
    def seen(seed: int, q: float) -> Floats:
        backend = DisturbedSimulator(plain(1), ROBOT, 1, Disturbance(noise=(0.02, 0.02)), seed)
        return backend.reset(np.arange(1), [PipeCorner.of(300, 60)], np.full((1, 4), q), np.array([-0.7])).ranges

    assert np.array_equal(seen(0, 0.0), seen(0, 0.0))
    assert not np.array_equal(seen(0, 0.0), seen(1, 0.0))
    assert not np.array_equal(seen(0, 0.0), seen(0, 1e-12))


class Varied(KinematicBackend):
    """A simulator that remembers how it was varied, and does nothing with it."""

    can_vary = True

    def vary(self, indices: Ints, variation: Variation) -> None:
        self.indices, self.variation = indices, variation


def test_a_simulator_gets_what_was_drawn_for_the_robots_that_begin() -> None:
    n = 30
    inner = Varied(ROBOT, n, KinematicOptions())
    wanted = Disturbance(friction=(0.5, 1.5), mass=(0.8, 1.3), strength=(0.7, 0.9), gain=(1.1, 1.4))
    backend = DisturbedSimulator(inner, ROBOT, n, wanted, 0)
    start = starts(Bench(KinematicBackend, n=n))
    backend.reset(*start)
    shapes = {"friction": (n,), "mass": (n, 4), "strength": (n, 4), "gain": (n, 4)}
    for name, values in inner.variation._asdict().items():
        low, high = getattr(wanted, name)
        assert values.shape == shapes[name]
        assert low <= values.min() < low + 0.2 * (high - low)
        assert high >= values.max() > high - 0.2 * (high - low)
        assert len(np.unique(values)) == values.size
    chosen = np.array([3, 7])
    before = inner.variation.part(chosen)
    backend.reset(chosen, [start.pipes[i] for i in chosen], start.q[chosen], start.base[chosen])
    assert np.array_equal(inner.indices, chosen)
    for again, first in zip(inner.variation, before, strict=True):
        np.testing.assert_array_equal(again, first)  # the same episode


def test_a_backend_that_cannot_vary_its_robots_says_so() -> None:
    with pytest.raises(PipenavError, match="KinematicBackend cannot change friction, mass, strength or gain"):
        disturbed(plain(1), ROBOT, 1, Disturbance(mass=(1.0, 1.2)), 0)


class Watched(KinematicBackend):
    """Has a window on its first robot."""

    has_viewer = True

    def open_viewer(self) -> Viewer:
        raise PipenavError("its own window")


def test_the_window_is_the_simulators_own() -> None:
    backend = DisturbedSimulator(Watched(ROBOT, 1, KinematicOptions()), ROBOT, 1, WORST, 0)
    assert backend.has_viewer
    with pytest.raises(PipenavError, match="its own window"):
        backend.open_viewer()
    assert not DisturbedSimulator(plain(1), ROBOT, 1, WORST, 0).has_viewer
