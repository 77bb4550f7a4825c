"""The controllers that an evaluation runs."""

from __future__ import annotations

import numpy as np
import pytest

from pipenav.errors import PipenavError, UnknownName
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.centreline import CentrelineController
from pipenav.policies.baselines.wall_distance import clearance
from pipenav.policies.controller import Controller
from pipenav.policies.named import RandomController, open_controller
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.sampling import random_episodes

ROBOT = load_robot("basic")


def _batch(controller: Controller, pipes: list[PipeCorner], n: int, seed: int = 0) -> ReachBatch:
    from pipenav_mujoco.backend import MujocoBackend, MujocoOptions

    segments = max(len(pipe.segments) for pipe in pipes)
    backend = MujocoBackend(controller.robot, n, MujocoOptions(threads=1), segments)
    source = random_episodes(controller.robot, controller.task, [pipes], np.random.default_rng(seed))
    return ReachBatch(controller.robot, controller.task, backend, n, source)


def _outcomes(controller: Controller, pipes: list[PipeCorner], n: int) -> list[str]:
    """How the first episode of each of n robots ends."""
    batch = _batch(controller, pipes, n)
    observation = batch.reset()
    first = np.zeros(n, int)
    while not first.all():
        action = controller.act(observation, batch)
        assert action.shape == (n, len(controller.robot.joints))
        assert np.abs(action).max() <= 1.0
        result = batch.step(action)
        observation = result.observation
        first = np.where(first == Outcome.RUNNING, result.outcome, first)
        if (ended := np.flatnonzero(result.outcome)).size:
            observation = batch.reset(ended)
    batch.close()
    return [Outcome(outcome).label for outcome in first]


@pytest.mark.parametrize("turn", ["left", "right"])
@pytest.mark.parametrize(("diameter", "angle", "bend"), [(100, 90, 0), (80, 70, 0), (120, 125, 0), (100, 90, 75)])
def test_centreline_passes(diameter: float, angle: float, bend: float, turn: str) -> None:
    pipe = PipeCorner.of(diameter, angle, turn, bend)
    assert _outcomes(open_controller("baseline:centreline"), [pipe], 4) == ["reached"] * 4


def test_centreline_does_not_depend_on_the_other_robots() -> None:
    pipes = [PipeCorner.of(90, angle, turn) for angle in (60, 100) for turn in ("left", "right")]
    controller = CentrelineController(ROBOT)
    batch = _batch(controller, pipes, 6)
    actions = [controller.act(batch.reset(), batch) for _ in range(2)][1]
    again = CentrelineController(ROBOT)  # it has not seen the episodes before these
    np.testing.assert_array_equal(again.act(np.zeros((6, 1)), batch), actions)
    batch.close()


def test_centreline_needs_a_slide_and_hinges() -> None:
    hinges = ROBOT.model_copy(update={"links": ROBOT.links[1:]})
    with pytest.raises(PipenavError, match="robot 'basic' has hinge, hinge, hinge"):
        CentrelineController(hinges)


def test_random_is_reproducible_by_its_seed() -> None:
    observation = np.zeros((5, 3))
    batch = None
    one, same, other = (RandomController(ROBOT, seed) for seed in (3, 3, 4))
    first = one.act(observation, batch)  # type: ignore[arg-type]  # it does not look
    np.testing.assert_array_equal(same.act(observation, batch), first)  # type: ignore[arg-type]
    assert not np.array_equal(other.act(observation, batch), first)  # type: ignore[arg-type]
    assert not np.array_equal(one.act(observation, batch), first)  # type: ignore[arg-type]
    assert first.shape == (5, 4)
    assert np.abs(first).max() <= 1.0


def test_random_seldom_passes() -> None:
    outcomes = _outcomes(open_controller("baseline:random", seed=1), [PipeCorner.of(80, 60)], 8)
    assert outcomes.count("reached") <= 1


def test_unknown_names_list_the_known_ones() -> None:
    with pytest.raises(UnknownName, match="did you mean 'baseline:random'"):
        open_controller("baseline:randm")
    with pytest.raises(UnknownName, match="unknown robot"):
        open_controller("baseline:random", "no-such-robot")
    with pytest.raises(UnknownName, match="unknown policy"):
        open_controller("no-such-policy")


def test_every_baseline_says_its_task() -> None:
    assert open_controller("baseline:centreline").task.control == "position"
    assert open_controller("baseline:random").task == ReachConfig()


def test_clearance_of_a_straight_arm_is_what_the_walls_leave() -> None:
    pipe = PipeCorner.of(100, 90)
    base = -pipe.inner_edge - ROBOT.length - 0.1
    poses = np.zeros((3, 4))
    poses[1, 0] = 0.1 + pipe.inner_edge + 0.03  # the tip's end face 20 mm off the outer wall
    poses[2, 1] = 0.5  # into the wall
    found = clearance(ROBOT, pipe, poses, base)
    np.testing.assert_allclose(found[:2], [0.04, 0.02], atol=1e-9)
    assert found[2] < 0


def test_clearance_agrees_with_a_dense_outline() -> None:
    """Wherever all points of the links' outlines lie inside the pipe, there is clearance, and the other way round."""
    rng = np.random.default_rng(0)
    pipe = PipeCorner.of(80, 70)
    base = -pipe.inner_edge - ROBOT.length
    q = rng.uniform([0.0, -0.3, -0.3, -0.3], [0.2, 0.3, 1.2, 1.5], (400, 4))
    found = clearance(ROBOT, pipe, q, base)
    inside = np.array([_outline_inside(pipe, pose, base) for pose in q])
    sure = np.abs(found) > 0.002
    np.testing.assert_array_equal(found[sure] > 0, inside[sure])
    assert 10 < inside[sure].sum() < sure.sum() - 10


def _outline_inside(pipe: PipeCorner, q: np.ndarray, base: float) -> bool:
    from pipenav.robots import kinematics

    chain = kinematics.forward(ROBOT, q[None])
    t = np.linspace(0.0, 1.0, 200)
    for start, heading, link in zip(chain.joints[0], chain.headings[0], ROBOT.links, strict=True):
        along, across = (np.array([np.cos(a), np.sin(a)]) for a in (heading, heading + np.pi / 2))
        sides = [start + link.length * t[:, None] * along + w * link.width / 2 * across for w in (-1, 1)]
        ends = [start + x * along + link.width * (t[:, None] - 0.5) * across for x in (0.0, link.length)]
        if not pipe.contains(np.concatenate(sides + ends) + np.array([base, 0.0])).all():
            return False
    return True
