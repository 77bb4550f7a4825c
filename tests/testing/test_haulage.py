"""The bollard test of PIRATE: its published travel and pull, and what cable it hauls, in every simulator that pulls."""

from __future__ import annotations

import pytest

from pipenav.backends.refusals import CannotPull
from pipenav.robots.robot import load_robot
from pipenav.robots.traction import speed_under
from pipenav.tasks.traverse.tether import TetherConfig
from pipenav.testing import Haulage

TRAVEL, PULL = 0.080, 14.0
"""Published speed [m/s] and pull [N] of PIRATE, see models/robots/pirate/robot.toml."""

SIMULATORS = ["mujoco", pytest.param("pybullet", marks=pytest.mark.slow)]


def haulage(backend: str, robot: str = "pirate") -> Haulage:
    if backend == "pybullet":
        pytest.importorskip("pybullet")
    return Haulage(load_robot(robot), backend)


@pytest.mark.parametrize("backend", SIMULATORS)
def test_pirate_travels_and_pulls_as_published(backend: str) -> None:
    subject = haulage(backend)
    assert subject.speed() == pytest.approx(TRAVEL, rel=0.05)
    assert subject.bollard_pull() == pytest.approx(PULL, rel=0.05)


@pytest.mark.parametrize("load", [4.0, 7.0, 10.0])
def test_under_a_load_it_is_as_slow_as_the_force_balance_says(load: float) -> None:
    robot = load_robot("pirate")
    assert haulage("mujoco").speed(load) == pytest.approx(float(speed_under(robot, load)), rel=0.05)  # type: ignore[arg-type]


@pytest.mark.parametrize("backend", SIMULATORS)
@pytest.mark.parametrize(("length", "friction"), [(250.0, 0.3), (125.0, 0.6)])
def test_it_just_pulls_the_published_lengths_of_cable(length: float, friction: float, backend: str) -> None:
    subject, cable = haulage(backend), TetherConfig(friction=friction)
    assert 0 < subject.speed(cable.per_metre * length) < 0.1 * TRAVEL
    assert subject.speed(cable.per_metre * length * 260 / 250) < 0


def test_strong_motors_are_limited_by_their_grip() -> None:
    subject = haulage("mujoco", "pirate-strong")
    assert subject.speed() > 1.4 * TRAVEL
    assert 1.5 * PULL < subject.bollard_pull() < 4 * PULL


def test_a_simulator_without_forces_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    from pipenav_mujoco import MujocoBackend

    monkeypatch.setattr(MujocoBackend, "can_pull", False)
    with pytest.raises(CannotPull, match="cannot let a tether pull on robots"):
        haulage("mujoco").speed()
