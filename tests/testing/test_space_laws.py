"""The laws of robots in space, over every installed simulator that has them, and over fakes that break them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from pipenav.arrays import Floats, Ints
from pipenav.backends.plugins import find_backends
from pipenav.backends.spatial import SpaceBackend, SpaceReading, SpaceTruth
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import RobotSpec
from pipenav.testing import SPACE_LAWS, KinematicSpace, SpaceBench, SpaceLaw
from pipenav.testing.space_laws import mirror_image


@pytest.mark.parametrize("check", SPACE_LAWS, ids=lambda check: check.__name__[len("check_") :])
@pytest.mark.parametrize("backend", [KinematicSpace, "mujoco"], ids=["kinematic", "mujoco"])
def test_laws_in_space(backend: str | Callable[[RobotSpec, int], SpaceBackend], check: SpaceLaw) -> None:
    check(SpaceBench(backend))


@pytest.mark.parametrize("check", SPACE_LAWS, ids=lambda check: check.__name__[len("check_") :])
def test_laws_in_space_hold_for_one_robot(check: SpaceLaw) -> None:
    check(SpaceBench(KinematicSpace, n=1))


def test_our_simulator_in_space_is_installed() -> None:
    assert "mujoco" in find_backends()


def test_a_mirror_image_has_right_and_left_exchanged() -> None:
    route = PipeRoute.of(90, [(90, "left", 30), (75, "right", 90, 150), (100, "left", 0)], [900, 900, 900, 800])
    image = mirror_image(route)
    across = [1.0, -1.0, 1.0]
    np.testing.assert_allclose(image.legs.line(0.0, 0.0), route.legs.line(0.0, 0.0) * across, atol=1e-12)
    assert mirror_image(image) == route


class Shaky(KinematicSpace):
    def step(self, set_points: Floats, roll: Floats) -> None:
        super().step(set_points, roll)
        self._base[:, 0] += 1e-12 * np.random.default_rng().normal()


class ResetsAll(KinematicSpace):
    def reset(self, indices: Ints, routes: Sequence[PipeRoute], q: Floats, base: Floats, plane: Floats) -> SpaceReading:
        self._time[:] = 0.0
        return super().reset(indices, routes, q, base, plane)


class StartsMoving(KinematicSpace):
    def reset(self, indices: Ints, routes: Sequence[PipeRoute], q: Floats, base: Floats, plane: Floats) -> SpaceReading:
        super().reset(indices, routes, q, base, plane)
        self._qd[indices] = 0.1
        return self._reading(indices)


class DriftsRight(KinematicSpace):
    def step(self, set_points: Floats, roll: Floats) -> None:
        super().step(set_points, roll)
        self._base[:, 1] -= 0.01


class Rises(KinematicSpace):
    def step(self, set_points: Floats, roll: Floats) -> None:
        super().step(set_points, roll)
        self._base[:, :3] -= 0.001 * self._gravity


class Falls(KinematicSpace):
    def step(self, set_points: Floats, roll: Floats) -> None:
        super().step(set_points, roll)
        self._base[:, :3] += 0.001 * self._gravity


class KnowsOneDown(KinematicSpace):
    def incline(self, indices: Ints, gravity: Floats) -> None:
        super().incline(indices, np.linalg.norm(gravity, axis=1, keepdims=True) * [0.0, 0.0, -1.0])


class Unrolled(KinematicSpace):
    def truth(self) -> SpaceTruth:
        truth = super().truth()
        return truth._replace(normals=truth.normals[:, [0, 0]])


@pytest.mark.parametrize(
    ("backend", "law", "message"),
    [
        (Shaky, "same_seed_same_motion", "two backends under the same commands"),
        (ResetsAll, "reset_touches_only_named_robots", "robots that were not reset"),
        (StartsMoving, "reset_puts_robots_where_it_says", "speeds after a reset"),
        (DriftsRight, "gravity_mirrors", "points in the mirror image"),
        (KnowsOneDown, "down_and_roll_fit_the_truth", "down across the planes"),
        (Rises, "let_go_it_never_rises", "robots that are let go rise by"),
        (Falls, "a_clamped_robot_stays", "clamped robots creep by"),
        (Unrolled, "down_and_roll_fit_the_truth", "."),
    ],
)
def test_a_broken_law_in_space_is_noticed(backend: type[KinematicSpace], law: str, message: str) -> None:
    (check,) = (check for check in SPACE_LAWS if check.__name__ == f"check_{law}")
    with pytest.raises(AssertionError, match=message):
        check(SpaceBench(backend))
