"""The traverse task in runs of corners: the way, the side that changes from corner to corner, starts and time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pipenav import any_pipe
from pipenav.any_pipe import AnyPipe
from pipenav.clearance import clearance
from pipenav.disturbance import load_disturbance
from pipenav.disturbed import disturbed
from pipenav.episode_runner import random_start
from pipenav.errors import PipenavError
from pipenav.pipe import Pipe
from pipenav.pipe_run import CrossesItself, PipeRun
from pipenav.pipe_run_set import parse_any
from pipenav.registry import open_backend
from pipenav.robot import load_robot
from pipenav.state import Truth
from pipenav.task.episode import Verdict
from pipenav.tasks import kind_of
from pipenav.testing import KinematicBackend
from pipenav.traverse import observation
from pipenav.traverse.batch import TraverseBatch
from pipenav.traverse.config import TraverseConfig
from pipenav.traverse.start import TraverseEpisodes, parse_planar, sample, with_room
from pipenav.traverse.way import Ways, waypoints

Array = NDArray[np.float64]

ROBOT = load_robot("pirate")
CONFIG = TraverseConfig(kind="traverse", set_points="held", start_press=0.1)
LEVEL = parse_any(["runs-level"])
CORNERS = [Pipe.of(90, 75, "right", leg_mm=1600), Pipe.of(110, 110, leg_mm=1600)]
seeds = st.integers(0, 2**32 - 1)


def mirrored(run: PipeRun) -> PipeRun:
    other = {"left": "right", "right": "left"}
    corners = tuple(corner.model_copy(update={"turn": other[corner.turn]}) for corner in run.corners)
    return run.model_copy(update={"corners": corners})


@contextmanager
def batch(pipes: Sequence[AnyPipe], seed: int = 0, config: TraverseConfig = CONFIG) -> Iterator[TraverseBatch]:
    start = sample(ROBOT, config, pipes, np.random.default_rng(seed))
    with batch_from(start, config) as made:
        yield made


@contextmanager
def batch_from(start: TraverseEpisodes, config: TraverseConfig = CONFIG) -> Iterator[TraverseBatch]:
    n, slots = len(start.pipes), max(len(pipe.segments) for pipe in start.pipes)
    simulator = open_backend("mujoco", ROBOT, n, {"threads": 1}, slots)
    with closing(TraverseBatch(ROBOT, config, simulator, n, lambda _: start)) as made:
        made.reset()
        yield made


@given(seeds)
def test_the_way_is_the_centre_line_of_runs_and_corners_alike(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pipes = [LEVEL[0], CORNERS[0], LEVEL[7], PipeRun.of(100, [(180, "left", 0), (90, "left", 180)])]
    line = [np.array([[-1.0, 0], [0, 0], [1, 1]]) if isinstance(p, Pipe) else p.centre_line[:, :2] for p in pipes]
    points = np.stack([points[rng.integers(len(points), size=8)] for points in line])
    points += rng.normal(0.0, 0.3, points.shape)
    along = Ways.of(pipes).along(points)
    for one, pipe, own in zip(along, pipes, points, strict=True):
        expected = pipe.centre_line_distance(own) if isinstance(pipe, Pipe) else pipe.along(own)
        assert one == pytest.approx(expected)


def test_ways_make_room_for_more_corners() -> None:
    ways = Ways.of([CORNERS[0], CORNERS[1]]).put(np.array([1]), Ways.of([LEVEL[0]]))
    points = np.random.default_rng(0).normal(size=(2, 50, 2))
    assert ways.along(points)[0] == pytest.approx(CORNERS[0].centre_line_distance(points[0]))
    assert ways.along(points)[1] == pytest.approx(LEVEL[0].along(points[1]))
    assert list(ways.corners) == [1, 5]


@given(st.sampled_from(LEVEL))
def test_corners_end_one_after_the_other_and_turn_to_the_side_that_the_run_turns_to(run: PipeRun) -> None:
    ways = Ways.of([run])
    assert np.all(np.diff(ways.end[0, :-1]) > 0)
    direction = np.diff(run.centre_line[:, :2], axis=0)
    cross = direction[:-1, 0] * direction[1:, 1] - direction[:-1, 1] * direction[1:, 0]
    assert any_pipe.turn_sides(run) == pytest.approx(np.sign(cross))
    assert ways.side[0, :-1] == pytest.approx(np.sign(cross))


def test_a_run_of_one_gives_the_episode_of_the_corner() -> None:
    runs = [PipeRun.from_pipe(pipe) for pipe in CORNERS]
    for number in range(3):
        one, other = (random_start(ROBOT, CONFIG, pipes, 3, 5)(number) for pipes in (CORNERS, runs))
        for a, b in zip(one[1:], other[1:], strict=True):
            assert a == pytest.approx(b)
    rng = np.random.default_rng(1)
    with batch(CORNERS) as corner, batch(runs) as run:
        for _ in range(12):
            action = rng.uniform(-1.0, 1.0, (2, 12))
            a, b = corner.step(action), run.step(action)
            assert a.observation == pytest.approx(b.observation, abs=1e-9)
            assert a.reward == pytest.approx(b.reward, abs=1e-9)
            assert list(a.verdict) == list(b.verdict)


@settings(max_examples=30)
@given(seeds)
def test_an_action_seen_from_the_other_side_asks_for_the_same_and_twice_is_itself(seed: int) -> None:
    rng = np.random.default_rng(seed)
    action, (q, before) = rng.uniform(-1.0, 1.0, (2, 12)), rng.uniform(ROBOT.lower, ROBOT.upper, (2, 2, 6))
    change = np.array([-1.0, 1.0])
    seen = observation.seen_from(ROBOT, action, change)
    assert seen[1] == pytest.approx(action[1])
    assert observation.seen_from(ROBOT, seen, change) == pytest.approx(action)
    for config in (CONFIG, CONFIG.model_copy(update={"set_points": "measured"})):
        one = observation.to_command(ROBOT, config, action, q, before, np.ones(2)).values
        assert observation.to_command(ROBOT, config, seen, q, before, change).values == pytest.approx(one)


class Carried:
    """A batch whose robots are carried along the centre lines of their runs by hand."""

    def __init__(self, runs: Sequence[PipeRun], config: TraverseConfig) -> None:
        self.runs, self.n = runs, len(runs)
        start = sample(ROBOT, config, runs, np.random.default_rng(0))
        slots = max(len(run.segments) for run in runs)
        self._inner = open_backend("mujoco", ROBOT, self.n, {"threads": 1}, slots)
        self.batch = TraverseBatch(ROBOT, config, self._inner, self.n, lambda _: start)
        self.batch.reset()
