"""The laws of `pipenav.testing.contract`, over every installed simulator that can run here."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Backend
from pipenav.backends.messages import Command, Reading, Truth
from pipenav.backends.plugins import find_backends
from pipenav.backends.requirements import availability
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.testing import ALL_LAWS, CONTRACT, Bench, KinematicBackend

NEEDS_A_MACHINE = {"hardware"}
"""Backends that cannot be opened without their arm: their own tests run them over a fake wire."""


def _subjects() -> list[object]:
    subjects: list[object] = [pytest.param(KinematicBackend, id="kinematic")]
    for name, plugin in find_backends().items():
        if name not in NEEDS_A_MACHINE:
            can_load, missing, remedy = availability(plugin)
            marks = [] if name == "mujoco" else [pytest.mark.slow]
            marks += [] if can_load else [pytest.mark.skip(reason=f"{name}: {missing}; {remedy}")]
            subjects.append(pytest.param(name, id=name, marks=marks))
    return subjects


def test_our_backends_are_installed() -> None:
    """Without them the contract would be checked on next to nothing."""
    assert "mujoco" in find_backends(), (
        "pipenav's own backends are not installed, so the contract was not run over them: this is a bare checkout. "
        "Backends are found through the installed distribution: pip install -c constraints.txt -e '.[dev]'"
    )


@pytest.mark.parametrize("check", ALL_LAWS, ids=lambda check: check.__name__[len("check_") :])
@pytest.mark.parametrize("backend", _subjects())
def test_contract(backend: str | type[Backend], check: Callable[[Bench], None]) -> None:
    check(Bench(backend))


@pytest.mark.parametrize("check", ALL_LAWS, ids=lambda check: check.__name__[len("check_") :])
@pytest.mark.parametrize("backend", _subjects()[1:])
def test_contract_holds_for_a_robot_on_wheels(backend: str, check: Callable[[Bench], None]) -> None:
    check(Bench(backend, load_robot("pirate-strong")))


@pytest.mark.parametrize("check", CONTRACT, ids=lambda check: check.__name__.removeprefix("check_"))
def test_contract_holds_for_one_robot(check: Callable[[Bench], None]) -> None:
    check(Bench(KinematicBackend, n=1))


class SharesMemory(KinematicBackend):
    def read(self) -> Reading:
        return super().read()._replace(q=self._q)


class Backwards(KinematicBackend):
    def step(self, command: Command) -> None:
        super().step(command._replace(values=-command.values))


class ResetsAll(KinematicBackend):
    def reset(self, indices: Ints, pipes: Sequence[PipeCorner], q: Floats, base: Floats) -> Reading:
        reading = super().reset(indices, pipes, q, base)
        self._q[:] = q[0] if len(q) else 0.0
        return reading


class DeadBeam(KinematicBackend):
    def read(self) -> Reading:
        reading = super().read()
        reading.ranges[:, 0] = 0.3
        return reading


class RemembersItsPast(KinematicBackend):
    steps = 0

    def step(self, command: Command) -> None:
        super().step(command)
        self.steps += 1
        self._q[:, -1] += 1e-12 * self.steps


class Shaky(KinematicBackend):
    def step(self, command: Command) -> None:
        super().step(command)
        self._q[:, -1] += 1e-12 * np.random.default_rng().normal()


class ReadsOthers(KinematicBackend):
    def reset(self, indices: Ints, pipes: Sequence[PipeCorner], q: Floats, base: Floats) -> Reading:
        super().reset(indices, pipes, q, base)
        return self.read().part(np.arange(len(indices)))


class Unfelt(KinematicBackend):
    def truth(self) -> Truth:
        return super().truth()._replace(contact_force=np.ones(len(self._q)))


class Stopped(KinematicBackend):
    def read(self) -> Reading:
        return super().read()._replace(time=np.ones(len(self._q)))


@pytest.mark.parametrize(
    ("backend", "law", "message"),
    [
        (SharesMemory, "no_shared_memory", "a backend whose arrays the caller wrote into"),
        (Backwards, "commands_move_the_right_way", "a positive duty moves joint 0 by"),
        (ResetsAll, "reset_touches_only_named_robots", "differs between robots that were not reset"),
        (ResetsAll, "resets_differ", "joint positions after a reset"),
        (DeadBeam, "nothing_constant", r"ranges never changes in columns \[0\]"),
        (DeadBeam, "tip_and_ranges_fit_the_pose", "beams miss the walls"),
        (RemembersItsPast, "reset_forgets_the_past", "a used and a new backend under the same commands"),
        (Shaky, "same_seed_same_trajectory", "two backends under the same commands"),
        (ReadsOthers, "reset_reads_what_read_reads", "what a reset returns and what is read after"),
        (Unfelt, "contact_force_is_the_largest_of_the_links", "contact force"),
        (Stopped, "time_counts", "Not equal"),
    ],
)
def test_a_broken_law_is_noticed(backend: type[Backend], law: str, message: str) -> None:
    (check,) = (check for check in CONTRACT if check.__name__ == f"check_{law}")
    with pytest.raises(AssertionError, match=message):
        check(Bench(backend))
