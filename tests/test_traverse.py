"""The traverse task: what is seen, what counts as progress, how episodes start and end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.backends.backend import Backend
from pipenav.backends.messages import Command, Reading, Truth
from pipenav.backends.simulators import open_simulator
from pipenav.disturbances.disturbance import Disturbance
from pipenav.disturbances.disturbed_backend import DisturbedSimulator
from pipenav.errors import PipenavError
from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.wall_distance import clearance
from pipenav.robots.kinematics import waypoints
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.registry import task_of
from pipenav.tasks.sampling import random_episodes
from pipenav.tasks.traverse import observation
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.config import TraverseConfig, TraverseReward
from pipenav.tasks.traverse.episode import GRAVITY, TraverseEpisodes, sample
from pipenav.tasks.traverse.outcome import Facts, OutcomeTracker, reward
from pipenav.testing import KinematicBackend
from pipenav.testing.kinematic import KinematicOptions

ROBOT = load_robot("pirate")
CONFIG = TraverseConfig(kind="traverse")
PIPES = [
    PipeCorner.of(70, 55),
    PipeCorner.of(120, 125, "right"),
    PipeCorner.of(90, 90),
    PipeCorner.of(100, 70, "right"),
]
seeds = st.integers(0, 2**32 - 1)


def episodes(config: TraverseConfig = CONFIG, seed: int = 0, pipes: list[PipeCorner] = PIPES) -> TraverseEpisodes:
    return sample(ROBOT, config, pipes, np.random.default_rng(seed))


@contextmanager
def batch(start: TraverseEpisodes, config: TraverseConfig = CONFIG) -> Iterator[TraverseBatch]:
    n = len(start.pipes)
    simulator = open_simulator("mujoco", ROBOT, n, {"threads": 1})
    with closing(TraverseBatch(ROBOT, config, simulator, n, lambda _: start)) as made:
        made.reset()
        yield made


@settings(max_examples=30, deadline=None)
@given(seeds)
def test_starts_touch_nothing_and_leave_the_gap(seed: int) -> None:
    start = episodes(seed=seed)
    for i, pipe in enumerate(start.pipes):
        room = clearance(ROBOT, pipe, start.q[i : i + 1], float(start.base[i]))[0]
        assert room >= -1e-9
        points = waypoints(ROBOT, start.q[i : i + 1])[0] + [start.base[i], 0.0]
        low, high = CONFIG.start_gap
        assert low - 1e-9 <= -pipe.inner_edge - points[-1, 0] <= high + 1e-9
        assert -pipe.leg < points[0, 0] - ROBOT.length  # room to slide back by its own length


@settings(max_examples=10, deadline=None)
@given(seeds)
def test_at_a_full_spread_every_wheel_touches_a_wall_by_turns(seed: int) -> None:
    start = episodes(CONFIG.model_copy(update={"start_spread": (1.0, 1.0)}), seed, PIPES[:1])
    wheels = waypoints(ROBOT, start.q)[0, 1:-1]
    room = PIPES[0].radius - ROBOT.width / 2
    assert np.abs(wheels[:, 1]) == pytest.approx(room)
    assert np.all(np.diff(np.sign(wheels[:, 1])) != 0)


def test_gravity_is_drawn_over_the_whole_circle_or_is_none() -> None:
    assert not episodes().gravity.any()
    inclined = CONFIG.model_copy(update={"inclination_deg": (0.0, 360.0)})
    drawn = episodes(inclined, pipes=PIPES * 100).gravity
    assert np.linalg.norm(drawn, axis=1) == pytest.approx(GRAVITY)
    quarters = np.histogram(np.arctan2(*drawn.T), bins=4, range=(-np.pi, np.pi))[0]
    assert quarters.min() > 0.8 * quarters.mean()


def test_where_down_is_is_felt_in_the_divided_link_and_mirrored_as_all_else() -> None:
    config = CONFIG.model_copy(update={"inclination_deg": (0.0, 360.0), "start_spread": (1.0, 1.0)})
    left = episodes(config, 3, [PipeCorner.of(90, 75), PipeCorner.of(110, 110)])
    mirrored = tuple(pipe.model_copy(update={"turn": "right"}) for pipe in left.pipes)
    mirror = np.array([1.0, -1.0])
    right = left._replace(pipes=mirrored, q=left.q * ROBOT.mirror_coordinates, gravity=left.gravity * mirror)
    with batch(left, config) as one, batch(right, config) as other:
        for _ in range(3):
            still = np.zeros((2, one.action_size))
            down, seen = one.step(still).observation[:, -2:], other.step(still).observation[:, -2:]
            assert down == pytest.approx(seen, abs=0.02)
            rear, front = one.points[:, 3:5].swapaxes(0, 1)  # of the link between wheel 3 and wheel 4
            ahead = (front - rear) / np.linalg.norm(front - rear, axis=1)[:, None]
            across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
            felt = np.stack([(left.gravity * axis).sum(axis=1) for axis in (ahead, across)], axis=1) / GRAVITY
            assert down == pytest.approx(felt)
    assert [part.name for part in observation.layout(ROBOT, config)][-1] == "down"


@given(seeds)
def test_the_way_is_the_pipes_centre_line(seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, (len(PIPES), 6, 2))
    along = CentreLines.of(PIPES).along(points)
    for one, pipe, own in zip(along, PIPES, points, strict=True):
        assert one == pytest.approx(pipe.distance_along(own))


def test_left_and_right_are_seen_and_driven_alike() -> None:
    left = episodes(pipes=[PipeCorner.of(90, 75), PipeCorner.of(110, 110)], seed=3)
    mirrored = tuple(pipe.model_copy(update={"turn": "right"}) for pipe in left.pipes)
    right = left._replace(pipes=mirrored, q=left.q * ROBOT.mirror_coordinates)
    rng = np.random.default_rng(0)
    with batch(left) as one, batch(right) as other:
        for _ in range(6):
            action = rng.uniform(-1.0, 1.0, (2, one.action_size))
            a, b = one.step(action), other.step(action)
            assert a.observation == pytest.approx(b.observation, abs=0.02)
            assert a.reward == pytest.approx(b.reward, abs=1e-3)


def test_the_observation_has_the_size_and_the_order_that_its_layout_says() -> None:
    parts = observation.layout(ROBOT, CONFIG)
    names = ["q", "qd", "wheel_speeds", "loads", "ranges", "action_before", "turns_beside"]
    assert [part.name for part in parts] == names
    n = 2
    reading = Reading(
        np.full((n, 6), 1.0),
        np.full((n, 6), 2.0),
        np.full((n, 10), 4.0),
        np.zeros(n),
        np.full((n, 6), 3.0),
        np.ones((n, 12)),
    )
    seen = observation.observe(ROBOT, reading, np.full((n, 12), 5.0), np.ones(n), np.array([[0.0, -1.0]] * n))
    assert seen.shape == (n, len(task_of(CONFIG).observation_scale(ROBOT)))
    assert list(seen[0]) == [1.0] * 6 + [2.0] * 6 + [3.0] * 6 + [1.0] * 12 + [4.0] * 10 + [5.0] * 12 + [0.0, -1.0]


@given(seeds, st.sampled_from(["measured", "held"]))
def test_a_command_keeps_to_the_limits_and_near_the_joints_and_is_mirrored(seed: int, set_points: str) -> None:
    config = CONFIG.model_copy(update={"set_points": set_points})
    rng = np.random.default_rng(seed)
    action, (q, before) = rng.uniform(-1.5, 1.5, (2, 12)), rng.uniform(ROBOT.lower, ROBOT.upper, (2, 2, 6))
    left = observation.to_command(ROBOT, config, action, q, before, np.ones(2)).values
    signs = ROBOT.mirror_signs
    right = observation.to_command(ROBOT, config, action, q * signs, before * signs, -np.ones(2)).values
    assert right == pytest.approx(left * ROBOT.mirror_drives)
    assert np.all((left[:, :6] >= ROBOT.lower) & (left[:, :6] <= ROBOT.upper))
    assert np.abs(left[:, :6] - q).max() <= config.alpha + 1e-12
    assert np.abs(left[:, 6:]).max() <= observation.wheel_limits(ROBOT).max()


def test_held_set_points_stay_and_measured_ones_follow_the_joints() -> None:
    q, before, still = np.full((1, 6), 0.3), np.full((1, 6), 0.4), np.zeros((1, 12))
    for name, expected in (("held", before), ("measured", q)):
        config = CONFIG.model_copy(update={"set_points": name})
        assert observation.to_command(ROBOT, config, still, q, before, np.ones(1)).values[:, :6] == pytest.approx(
            expected
        )


def test_wheels_roll_forwards_on_the_wall_that_their_bend_presses_them_on() -> None:
    q = np.array([[-0.5, 0.5, -0.05, 0.0, 0.5, -0.5]])  # a bend to the right presses its wheel to the left
    ahead = np.concatenate([np.zeros((1, 6)), np.ones((1, 6))], axis=1)
    limit = observation.wheel_limits(ROBOT)[0]
    speeds = observation.to_command(ROBOT, CONFIG, ahead, q, q, np.ones(1)).values[0, 6:]
    assert speeds == pytest.approx(limit * np.array([1.0, -1.0, 0.5, 0.0, -1.0, 1.0]))


class Course:
    """One robot that is led along a straight way by hand, to be judged."""

    def __init__(self, **config: object) -> None:
        self.config = CONFIG.model_copy(update={"patience": 3, **config})
        self._judge, self._steps = OutcomeTracker(ROBOT, self.config, 1), np.zeros(1, int)
        self._start = np.linspace(-1.0, -0.4, 8)[None]
        self._judge.start(np.arange(1), self._start)

    def step(self, moved: float, depth: float = 0.0, spin: float = 0.0, q: float = 0.0, fold: bool = False) -> Outcome:
        along = self._start + moved
        if fold:
            along[:, -1] = along[:, 0]
        reading = Reading(np.full((1, 6), q), np.zeros((1, 6)), np.ones((1, 10)), np.zeros(1), np.full((1, 6), spin))
        zero = np.zeros(1)
        truth = Truth(np.zeros((1, 3)), zero, np.array([depth]), zero, np.zeros((1, 7, 2)))
        self._steps += 1
        self.facts, outcome = self._judge.step(
            self._steps, np.array([self.config.max_steps]), along, np.array([0.1]), reading, truth
        )
        return Outcome(outcome[0])


def test_the_tail_beyond_the_corner_ends_an_episode_well() -> None:
    course = Course()
    assert course.step(1.1) is Outcome.RUNNING
    assert course.step(1.1 + course.config.through + 1e-6) is Outcome.REACHED
    assert course.facts.passed.all()
    assert course.facts.progress == pytest.approx(course.config.through + 1e-6)


def test_an_overlap_fails_even_the_last_step() -> None:
    assert Course().step(1.2, depth=0.0021) is Outcome.PENETRATION


def test_sliding_back_by_its_length_fails() -> None:
    course = Course()
    course.step(0.3)
    assert course.step(0.3 - 0.99 * ROBOT.length) is Outcome.RUNNING
    assert course.step(0.3 - 1.01 * ROBOT.length) is Outcome.SLID_BACK
    assert course.facts.failed.all()


@pytest.mark.parametrize(
    ("moves", "reason"),
    [({}, Outcome.JAM), ({"spin": 40.0}, Outcome.SLIP), ({"q": 2.19}, Outcome.LIMIT), ({"fold": True}, Outcome.FOLD)],
)
def test_being_stuck_has_a_reason_and_is_a_failure(moves: dict[str, float], reason: Outcome) -> None:
    course = Course()
    for i in range(4):
        outcome = course.step(0.001 * i, **moves)  # type: ignore[arg-type]
        assert outcome is (Outcome.RUNNING if i < 2 else reason)
        assert course.facts.failed.all() == (i >= 2)


def test_time_runs_out_on_one_that_still_comes_on() -> None:
    course = Course(max_steps=5)
    assert [course.step(0.01 * i) for i in range(1, 6)] == [Outcome.RUNNING] * 4 + [Outcome.TIMEOUT]
    assert not course.facts.failed.any()  # it might have gone on


def test_the_reward_is_the_sum_of_its_terms_and_a_failure_is_one_number() -> None:
    config = TraverseReward(progress=2.0, passed=3.0, step=-0.5, force=-0.1, penetration=-1.0, failed=-7.0)
    facts = Facts(
        np.array([0.1, 0.1]),
        np.array([5.0, 5.0]),
        np.array([1e-3, 0.0]),
        np.array([True, False]),
        np.array([False, True]),
    )
    assert reward(config, facts) == pytest.approx([0.2 + 3.0 - 0.5 - 0.5 - 1.0, -7.0])


def test_an_arm_on_a_mount_is_refused() -> None:
    arm = load_robot("basic")
    with (
        closing(open_simulator("mujoco", arm, 1, {})) as simulator,
        pytest.raises(PipenavError, match="hangs on a mount"),
    ):
        TraverseBatch(arm, CONFIG, simulator, 1, lambda _: episodes())


def test_a_backend_without_gravity_is_refused_where_pipes_are_inclined() -> None:
    inclined = CONFIG.model_copy(update={"inclination_deg": (0.0, 360.0)})
    simulator = KinematicBackend(ROBOT, 1, KinematicOptions())
    with pytest.raises(PipenavError, match="knows no gravity"):
        TraverseBatch(ROBOT, inclined, simulator, 1, lambda _: episodes())


@pytest.mark.parametrize("steps", [3, 5])
def test_unclamped_in_an_upright_pipe_it_falls_freely(steps: int) -> None:
    pipe, n = PipeCorner.of(120, 90, leg_mm=3000), 1
    with closing(open_simulator("mujoco", ROBOT, n, {"threads": 1})) as simulator:
        simulator.incline(np.arange(n), np.array([[-GRAVITY, 0.0]]))  # type: ignore[attr-defined]
        simulator.reset(np.arange(n), [pipe], np.zeros((n, 9)), np.array([-1.0]))
        height = _tip_x(simulator)
        for _ in range(steps):
            simulator.step(Command("position", np.zeros((n, 12))))
        assert height - _tip_x(simulator) == pytest.approx(GRAVITY / 2 * (0.1 * steps) ** 2, rel=0.03)


def test_held_clamped_in_an_upright_pipe_it_stays_and_its_wheels_carry_it_up() -> None:
    upright = {"set_points": "held", "start_spread": (1.0, 1.0), "start_press": 0.16, "inclination_deg": (180.0, 180.0)}
    config, pipes = CONFIG.model_copy(update=upright), [PipeCorner.of(70, 90), PipeCorner.of(100, 90, "right")]
    with batch(episodes(config, pipes=pipes), config) as indices:
        heights = [indices.q[:, 0]]
        for forwards in (0.0, 0.5):
            action = np.concatenate([np.zeros((2, 6)), np.full((2, 6), forwards)], axis=1)
            for _ in range(10):
                indices.step(action)
            heights.append(indices.q[:, 0])
    assert heights[1] - heights[0] == pytest.approx(0.0, abs=0.02)
    assert np.all(heights[2] - heights[1] > 0.03)


def _tip_x(simulator: Backend) -> float:
    truth = simulator.truth()
    assert truth is not None
    return float(truth.tip[0, 0])


def test_a_disturbed_robot_falls_too() -> None:
    n = 1
    simulator = open_simulator("mujoco", ROBOT, n, {"threads": 1})
    config = CONFIG.model_copy(update={"inclination_deg": (180.0, 180.0)})
    with closing(DisturbedSimulator(simulator, ROBOT, n, Disturbance(mass=(1.5, 1.5)), 0)) as disturbed:
        one = TraverseBatch(ROBOT, config, disturbed, n, lambda _: episodes(config, pipes=[PipeCorner.of(120, 90)]))
        one.reset()
        before = one.q[0, 0]
        for _ in range(3):
            one.step(np.zeros((n, 12)))
        assert one.q[0, 0] < before - 0.1


def test_both_tasks_are_described_alike() -> None:
    arm = load_robot("basic")
    for robot, task in ((arm, ReachConfig()), (ROBOT, CONFIG)):
        kind, pipes = task_of(task), [PipeCorner.of(90, 90)]
        assert len(kind.action_scale(robot, task)) == len(robot.driven_actuators)
        source = random_episodes(robot, task, [pipes], np.random.default_rng(0), sample=kind.sample)
        with closing(kind.batch(robot, task, open_simulator("mujoco", robot, 2, {}), 2, source)) as made:
            assert made.reset().shape == (2, made.observation_size) == (2, len(task_of(task).observation_scale(robot)))
            result = made.step(np.zeros((2, made.action_size)))
            assert result.reward.shape == result.cut_off.shape == (2,)
            assert made.q.shape == (2, robot.coordinates)
