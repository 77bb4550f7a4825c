"""The turning sequence as a baseline: it clamps, it goes through its phases, the halves mirror each other."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.backends.backend import Backend
from pipenav.backends.simulators import open_simulator
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines import sequence_turn
from pipenav.policies.baselines.sequence import SequenceController
from pipenav.policies.baselines.sequence_phases import TurnPhase
from pipenav.policies.baselines.sequence_plan import PRESS, plan
from pipenav.policies.baselines.wall_distance import wall_distance
from pipenav.policies.named import open_controller
from pipenav.policies.policy import load_policy, resolve_policy
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.episode import GRAVITY, TraverseEpisodes, sample

ROBOT = load_robot("pirate-strong")
NAMES = ["baseline:sequence", "baseline:sequence-line"]
diameters, angles = st.floats(70.0, 120.0), st.floats(55.0, 125.0)


def controller(name: str) -> SequenceController:
    made = open_controller(name)
    assert isinstance(made, SequenceController)
    return made


@contextmanager
def batch(start: TraverseEpisodes, one: SequenceController) -> Iterator[tuple[TraverseBatch, Backend]]:
    n = len(start.pipes)
    simulator = open_simulator("mujoco", ROBOT, n, {"threads": 1})
    with closing(TraverseBatch(ROBOT, one.task, simulator, n, lambda _: start)) as made:
        yield made, simulator


def left_and_right(one: SequenceController, diameter: float, angle: float) -> TraverseEpisodes:
    """An episode and its mirror image."""
    left, right = PipeCorner.of(diameter, angle), PipeCorner.of(diameter, angle, "right")
    start = sample(ROBOT, one.task, [left, left], np.random.default_rng(0))
    pipes = (start.pipes[0], start.pipes[0].model_copy(update={"turn": right.turn}))
    q = np.stack([start.q[0], start.q[0] * ROBOT.mirror_coordinates])
    return start._replace(pipes=pipes, q=q, base=start.base[[0, 0]])


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("diameter", "angle"), [(70.0, 55.0), (90.0, 90.0), (120.0, 55.0)])
def test_it_goes_through_its_phases_in_order_to_either_side_alike(name: str, diameter: float, angle: float) -> None:
    one = controller(name)
    with batch(left_and_right(one, diameter, angle), one) as (robots, _):
        observation = robots.reset()
        seen: list[list[TurnPhase]] = [[], []]
        ended = np.zeros(2, int)
        while not ended.all():
            result = robots.step(one.act(observation, robots))
            observation = result.observation
            for i in np.flatnonzero(ended == 0):
                if one.phases[i] not in seen[i]:
                    seen[i].append(one.phases[i])
                if result.outcome[i] != Outcome.RUNNING:
                    assert Outcome(result.outcome[i]) is Outcome.REACHED
                    ended[i] = robots.steps[i]
    expected = [phase for phase in TurnPhase if name == NAMES[0] or phase is not TurnPhase.FRONT_TO_TARGET]
    assert seen == [expected, expected]
    assert abs(ended[0] - ended[1]) <= 0.1 * ended[0]  # contacts are not mirrored to the last digit


@pytest.mark.parametrize("name", NAMES)
def test_the_same_start_gives_the_same_motion(name: str) -> None:
    motions = []
    for _ in range(2):
        one = controller(name)
        start = sample(ROBOT, one.task, [PipeCorner.of(80, 70)], np.random.default_rng(1))
        with batch(start, one) as (robots, _):
            observation = robots.reset()
            for _ in range(45):
                observation = robots.step(one.act(observation, robots)).observation
            motions.append(robots.q)
    assert np.array_equal(*motions)


@pytest.mark.slow
@pytest.mark.parametrize("diameter", [70.0, 90.0, 110.0])
def test_a_clamp_presses_as_its_joint_says_and_carries_the_robot(
    diameter: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The joint in the middle bends two links against the walls: each end is pressed by effort / (length x cosine).

    A standing wheel's controller knows its speed alone, so under a load it turns as slowly as its motor allows.
    """
    monkeypatch.setattr(sequence_turn, "SETTLED", 0.0)
    monkeypatch.setattr(sequence_turn, "DWELL", 10**6)  # goes on clamping
    one, n = controller("baseline:sequence-line"), 2
    pipe = PipeCorner.of(diameter, 90)
    start = sample(ROBOT, one.task, [pipe] * n, np.random.default_rng(2))
    with batch(start, one) as (robots, simulator):
        observation = robots.reset()
        for _ in range(35):
            result = robots.step(one.act(observation, robots))
            observation = result.observation
        bend = ROBOT.joint_actuators[1]
        effort = bend.effort_limit * PRESS / bend.full_drive_error
        expected = 2 * effort / (ROBOT.lengths[1] * np.cos(plan(ROBOT, pipe).steep))
        assert result.truth.contact_force == pytest.approx(expected, rel=0.15)
        wheel, motor = ROBOT.wheels[0], ROBOT.driven_actuators[-1]
        stiff = motor.effort_limit * (1 / motor.full_drive_error + 1 / motor.noload_speed)  # [N m s]
        creep = _mass() * GRAVITY * wheel.radius**2 / (3 * stiff)  # of three wheels under the robot's weight [m/s]
        before = robots.q[:, :2]
        simulator.incline(np.arange(n), GRAVITY * np.array([[-1.0, 0.0], [1.0, 0.0]]))  # type: ignore[attr-defined]
        for _ in range(20):
            observation = robots.step(one.act(observation, robots)).observation
        moved = np.abs(robots.q[:, :2] - before)
        assert moved[:, 0].max() < 1.1 * 2.0 * creep < 0.05
        assert moved[:, 1].max() < 0.0005
        before = robots.q[:, :2]
        for _ in range(5):
            robots.step(np.zeros((n, 12)))  # set-points where the joints are: nothing presses
        assert np.abs(robots.q[:, 0] - before[:, 0]).min() > 10 * 0.5 * creep


def _mass() -> float:
    return sum(link.mass for link in ROBOT.links) + sum(wheel.mass for wheel in ROBOT.wheels)


@settings(max_examples=25, deadline=None)
@given(diameters, angles)
def test_the_line_leads_past_all_walls_to_a_pose_that_mirrors_itself(diameter: float, angle: float) -> None:
    pipe = PipeCorner.of(diameter, angle, leg_mm=2000)
    corner = plan(ROBOT, pipe)
    line, room = corner.line, pipe.radius - ROBOT.wheels[2].radius
    q = np.zeros((len(line.distance), ROBOT.coordinates))
    q[:, 0] = line.distance - ROBOT.lengths[0] - 2 * ROBOT.lengths[1] * np.cos(corner.steep)
    q[:, 1], q[:, 3:5] = -room, [corner.steep, -2 * corner.steep]
    q[:, 5], q[:, 6:] = corner.steep + line.bends[:, 0], line.bends[:, 1:]
    assert wall_distance(ROBOT, pipe, q, 0.0).min() > -1e-6
    half_turn = (np.pi - pipe.angle) / 2
    assert line.bends[-1, :2] == pytest.approx(half_turn, abs=0.1)  # the clamp's and the moving half's bend alike
    assert np.all(np.diff(line.distance) > 0)
    assert np.all(np.diff(corner.tip) > -1e-3)


@given(diameters, angles, st.floats(0.0, 1.0), st.integers(0, 2**32 - 1))
def test_the_path_onto_the_line_begins_where_the_half_is_and_ends_where_the_line_ends(
    diameter: float, angle: float, share: float, seed: int
) -> None:
    corner = plan(ROBOT, PipeCorner.of(diameter, angle))
    bends = np.random.default_rng(seed).uniform(-1.0, 1.0, 4)
    along = float(corner.line.distance[0] * (1 - share) + corner.line.distance[-2] * share)
    path = corner.onto_line(along, bends, float(corner.tip[len(corner.tip) // 2]))
    assert path.at(along) == pytest.approx(bends)
    assert path.at(0.0) == pytest.approx(corner.line.bends[-1])
    assert np.all(np.diff(path.distance) > 0)


def test_what_cannot_be_driven_is_refused() -> None:
    with pytest.raises(PipenavError, match=r"two mirrored halves .* choose --robot pirate"):
        open_controller("baseline:sequence", "basic")
    other = load_policy(resolve_policy("real-setup"))
    with pytest.raises(PipenavError, match="another laser"):
        SequenceController(ROBOT, other)
