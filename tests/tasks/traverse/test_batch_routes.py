"""The traverse task in routes: the side that changes from corner to corner, starts and time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager

import numpy as np
import pytest
from helpers.traversing import started
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import BackendOptions, Simulator
from pipenav.backends.messages import Command, Reading, Truth
from pipenav.backends.simulators import open_simulator
from pipenav.disturbances.disturbance import load_disturbance
from pipenav.disturbances.disturbed_backend import disturbed
from pipenav.evaluation.episode_runner import random_start
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import CrossesItself
from pipenav.pipes.route_sets import parse_pipes
from pipenav.robots import kinematics
from pipenav.robots.kinematics import waypoints
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.registry import task_of
from pipenav.tasks.traverse import observation
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import sample, with_room

ROBOT = load_robot("pirate-strong")
CONFIG = TraverseConfig(kind="traverse", set_points="held", start_press=0.1)
LEVEL = parse_pipes(["runs-level"])
CORNERS = [PipeCorner.of(90, 75, "right", leg_mm=1600), PipeCorner.of(110, 110, leg_mm=1600)]
seeds = st.integers(0, 2**32 - 1)


def mirrored(route: PipeRoute) -> PipeRoute:
    other = {"left": "right", "right": "left"}
    corners = tuple(corner.model_copy(update={"turn": other[corner.turn]}) for corner in route.corners)
    return route.model_copy(update={"corners": corners})


@contextmanager
def on_mujoco(pipes: Sequence[Pipe], seed: int = 0, config: TraverseConfig = CONFIG) -> Iterator[TraverseBatch]:
    start = sample(ROBOT, config, pipes, np.random.default_rng(seed))
    with started(start, config) as made:
        yield made


def test_a_route_of_one_corner_gives_the_episode_of_the_corner() -> None:
    routes = [PipeRoute.from_corner(pipe) for pipe in CORNERS]
    for number in range(3):
        one, other = (random_start(ROBOT, CONFIG, pipes, 3, 5)(number) for pipes in (CORNERS, routes))
        for a, b in zip(one[1:], other[1:], strict=True):
            assert a == pytest.approx(b)
    rng = np.random.default_rng(1)
    with on_mujoco(CORNERS) as corner, on_mujoco(routes) as route:
        for _ in range(12):
            action = rng.uniform(-1.0, 1.0, (2, 12))
            a, b = corner.step(action), route.step(action)
            assert a.observation == pytest.approx(b.observation, abs=1e-9)
            assert a.reward == pytest.approx(b.reward, abs=1e-9)
            assert list(a.outcome) == list(b.outcome)


@settings(max_examples=30)
@given(seeds)
def test_an_action_seen_from_the_other_side_asks_for_the_same_and_twice_is_itself(seed: int) -> None:
    rng = np.random.default_rng(seed)
    action, (q, before) = rng.uniform(-1.0, 1.0, (2, 12)), rng.uniform(ROBOT.lower, ROBOT.upper, (2, 2, 6))
    change = np.array([-1.0, 1.0])
    seen = observation.mirror_action(ROBOT, action, change)
    assert seen[1] == pytest.approx(action[1])
    assert observation.mirror_action(ROBOT, seen, change) == pytest.approx(action)
    for config in (CONFIG, CONFIG.model_copy(update={"set_points": "measured"})):
        one = observation.to_command(ROBOT, config, action, q, before, np.ones(2)).values
        assert observation.to_command(ROBOT, config, seen, q, before, change).values == pytest.approx(one)


class Ghost(Simulator):
    """Robots that are carried through their pipes by hand, bent as they are asked to, touching nothing."""

    Options = BackendOptions

    def __init__(self, pipes: Sequence[Pipe], q: Floats, ranges: Floats) -> None:
        self.pipes, self.tail, self.q, self.ranges = pipes, np.full(len(pipes), -1.0), q, ranges
        self.asked: list[Command] = []

    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:  # noqa: ARG002
        return self.read()

    def step(self, command: Command) -> None:
        self.asked.append(command)

    def read(self) -> Reading:
        n = len(self.q)
        speeds = np.outer([1.0, -1.0], np.arange(6))[:n]  # of the second robot mirrored
        return Reading(self.q, 0.1 * self.q, self.ranges, np.zeros(n), speeds, np.zeros((n, 12)))

    def truth(self) -> Truth:
        poses = [_on_the_centre_line(pipe, at) for pipe, at in zip(self.pipes, self.tail, strict=True)]
        pose = kinematics.forward(ROBOT, np.concatenate([np.array(poses), self.q], axis=1))
        tip = np.concatenate([pose.tip, pose.headings[:, -1:]], axis=1)
        zero = np.zeros(len(self.q))
        return Truth(tip, zero, zero, zero, np.zeros((len(self.q), 7, 2)))

    def close(self) -> None:
        pass


def _on_the_centre_line(pipe: Pipe, at: float) -> tuple[float, float, float]:
    """Position and direction of the centre line at a distance `at`."""
    assert isinstance(pipe, PipeRoute)
    leg = int(np.clip(np.searchsorted(pipe.distances, at, side="right") - 1, 0, len(pipe.straights) - 1))
    x, y = pipe.legs.axes[leg][:2, 0]
    position = pipe.centre_line[leg, :2] + (at - pipe.distances[leg]) * np.array([x, y])
    return (*position, float(np.arctan2(y, x)))


def carried(pipes: Sequence[Pipe], config: TraverseConfig = CONFIG, seed: int = 0) -> tuple[Ghost, TraverseBatch]:
    """Robots bent at random; the second of two is the first one's mirror image."""
    rng = np.random.default_rng(seed)
    q, ranges = rng.uniform(-0.5, 0.5, (1, 6)), rng.uniform(0.01, 0.4, (1, 10))
    both = np.concatenate([q, q * ROBOT.mirror_signs])[: len(pipes)]
    ghost = Ghost(pipes, both, np.concatenate([ranges, ranges[:, ::-1]])[: len(pipes)])
    pose = np.tile([-1.0, 0.0, 0.0], (len(pipes), 1))
    start = sample(ROBOT, config, pipes, rng)
    q, press = np.concatenate([pose, ghost.q], axis=1), CONFIG.start_press * np.sign(ghost.q)
    start = start._replace(base=np.zeros(len(pipes)), q=q, press=press)
    made = TraverseBatch(ROBOT, config, ghost, len(pipes), lambda _: start)
    made.reset()
    return ghost, made


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.sampled_from(LEVEL), seeds)
def test_a_route_and_its_mirror_image_are_seen_and_driven_alike_through_all_corners(route: Pipe, seed: int) -> None:
    assert isinstance(route, PipeRoute)
    ghost, batch = carried([route, mirrored(route)], seed=seed)
    rng = np.random.default_rng(seed)
    for at in np.linspace(-1.0, route.distances[-1], 40):
        ghost.tail[:] = at
        action = np.tile(rng.uniform(-1.0, 1.0, 12), (2, 1))
        seen = batch.step(action).observation
        assert seen[0] == pytest.approx(seen[1])
        left, right = ghost.asked[-1].values
        assert right == pytest.approx(left * ROBOT.mirror_actuators)


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.sampled_from(LEVEL))
def test_the_side_is_that_of_the_first_corner_that_the_middle_has_not_passed(route: Pipe) -> None:
    assert isinstance(route, PipeRoute)
    ghost, batch = carried([route])
    turn_signs, scale = route.turn_signs, task_of(CONFIG).observation_scale(ROBOT)
    ends = route.distances[1:-1] + route.inner_edges
    around, before, corner = np.array([0.0, *turn_signs, 0.0]), turn_signs[0], 0
    for at in np.linspace(-1.0, route.distances[-1], 60):
        ghost.tail[:] = at
        action = np.random.default_rng(0).uniform(-1.0, 1.0, (1, 12))
        seen = batch.step(action).observation * scale
        corner = max(corner, min(int((batch.distances.mean() >= ends).sum()), len(turn_signs) - 1))
        turn_sign = turn_signs[corner]
        assert seen[0, :6] == pytest.approx(ghost.q[0] * (ROBOT.mirror_signs if turn_sign < 0 else 1.0))
        # What was done last keeps its meaning: the same bends of the same joints.
        assert seen[0, -14:-8] * turn_sign == pytest.approx(action[0, :6] * before)
        assert seen[0, -8:-2] == pytest.approx(action[0, 6:])
        assert seen[0, -2:] * turn_sign == pytest.approx([around[corner], around[corner + 2]])
        before = turn_sign


def test_a_corner_that_was_passed_stays_passed_where_the_robot_slides_back() -> None:
    route = PipeRoute.of(100, [(90, "left", 0), (90, "right", 0)], [1000, 800, 1000])
    ghost, batch = carried([route])
    still = np.zeros((1, 12))
    first = batch.step(still).observation[0, :6]
    ghost.tail[:] = 0.1
    second = batch.step(still).observation[0, :6]
    ghost.tail[:] = -0.1
    assert second == pytest.approx(-first)
    assert batch.step(still).observation[0, :6] == pytest.approx(second)


def test_a_route_is_passed_with_the_tail_past_the_last_corner_and_has_time_for_every_corner() -> None:
    route = PipeRoute.of(100, [(90, "left", 0), (90, "right", 0), (70, "left", 0)], [1000, 800, 800, 1000])
    end = route.distances[-2] + route.inner_edges[-1] + CONFIG.through
    config = CONFIG.model_copy(update={"max_steps": 20})
    for last, outcome, steps in ((end + 1e-6, Outcome.REACHED, 50), (end - 1e-6, Outcome.TIMEOUT, 60)):
        ghost, batch = carried([route], config)
        found = []
        for at in [*np.linspace(-1.0, end - 0.02, 49), *[last] * 11]:
            ghost.tail[:] = at
            found.append(Outcome(batch.step(np.zeros((1, 12))).outcome[0]))
        assert found[: steps - 1] == [Outcome.RUNNING] * (steps - 1)
        assert found[steps - 1] is outcome


def test_robots_in_routes_and_in_corners_are_stepped_together() -> None:
    with on_mujoco([LEVEL[0], CORNERS[0]]) as batch:
        both = [batch.step(np.full((2, 12), 0.3)) for _ in range(3)]
    for i, pipe in enumerate((LEVEL[0], CORNERS[0])):
        start = sample(ROBOT, CONFIG, [LEVEL[0], CORNERS[0]], np.random.default_rng(0)).part(slice(i, i + 1))
        assert start.pipes[0].name == pipe.name
        with started(start, CONFIG) as alone:
            for result in both:
                one = alone.step(np.full((1, 12), 0.3))
                assert one.observation[0] == pytest.approx(result.observation[i], abs=1e-6)
                assert one.reward[0] == pytest.approx(result.reward[i], abs=1e-6)


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(st.sampled_from(LEVEL), seeds)
def test_starts_in_routes_lie_free_in_the_first_straight(route: Pipe, seed: int) -> None:
    start = sample(ROBOT, CONFIG, [route], np.random.default_rng(seed))
    points = waypoints(ROBOT, start.q)[0] + [start.base[0], 0.0]
    assert np.abs(points[:, 1]).max() <= route.radius - ROBOT.width / 2 + 1e-9
    assert -points[-1, 0] - route.inner_edges[0] == pytest.approx(0.08, abs=0.02 + 1e-9)
    assert start.pipes[0] == route  # whose ends are long enough
    assert isinstance(route, PipeRoute)
    assert points[0, 0] >= -route.straights[0]


def test_ends_that_are_too_short_are_made_longer_or_refused_where_the_route_would_cross_itself() -> None:
    corners = [(90, "left", 0), (90, "right", 0)]
    longer = with_room(ROBOT, CONFIG, PipeRoute.of(100, corners, [400, 500, 300]))
    assert isinstance(longer, PipeRoute)
    assert longer.straights == pytest.approx((0.05 + 0.62 + 0.10, 0.5, 0.05 + 0.62 + 0.10))
    spiral = PipeRoute.of(100, [(90, "left", 0)] * 3, [300, 500, 500, 250])
    with pytest.raises(CrossesItself, match="crosses itself"):
        with_room(ROBOT, CONFIG, spiral)


def test_a_corner_that_is_rolled_over_turns_to_the_other_side() -> None:
    assert PipeRoute.of(100, [(90, "left", 180)]).turn_signs == [-1.0]


def test_what_goes_wrong_in_a_route_is_drawn_by_its_corners() -> None:
    readings = []
    for route in (LEVEL[0], LEVEL[0], LEVEL[1].model_copy(update={"diameter": LEVEL[0].diameter})):
        simulator = open_simulator("mujoco", ROBOT, 1, {"threads": 1}, 12)
        q, base = np.zeros((1, ROBOT.coordinates)), np.array([-0.9])
        with closing(disturbed(simulator, ROBOT, 1, load_disturbance("noise"), 0)) as noisy:
            readings.append(noisy.reset(np.arange(1), [route], q, base).ranges[0, 5])
    assert readings[0] == readings[1]
    assert readings[0] != readings[2]
