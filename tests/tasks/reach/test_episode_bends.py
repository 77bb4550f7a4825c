"""Targets in swept bends: where the arm can come, by a search that knows nothing of how they were drawn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.wall_distance import wall_distance
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig

ARMS = ("basic", "high-fidelity", "real-setup")
TASK = ReachConfig()
POSES, ROUNDS, KEPT = 400, 80, 40
BACK, NEARBY, MOVE = 0.01, 150, 0.12
"""Steps of the slide on the way back [m], poses tried in each, and their largest change of a hinge [rad]."""
elbows = st.builds(
    lambda d, angle, times: PipeCorner.of(d, angle, "left", times * d),
    st.floats(70, 120),
    st.floats(90, 150),
    st.floats(1, 5),
)
seeds = st.integers(0, 2**32 - 1)


def drawn(robot: RobotSpec, pipe: PipeCorner, seed: int, task: ReachConfig = TASK) -> episode.ReachEpisodes:
    return episode.sample(robot, task, [pipe], np.random.default_rng(seed))


def in_pipe(episodes: episode.ReachEpisodes) -> Floats:
    """The first target in the pipe's frame, (2,)."""
    return np.asarray((episodes.target[0] + [episodes.base[0], 0.0]) * [1.0, episodes.turn_sign[0]])


class Search:
    """A search for poses of an arm in one pipe, all of them free and off the joints' limits."""

    def __init__(self, robot: RobotSpec, pipe: PipeCorner, base: float) -> None:
        self.robot, self.pipe, self.base = robot, pipe, base
        self.rng = np.random.default_rng(0)

    def blocked(self, q: Floats) -> Floats:
        """Distance of poses (n, joints) from being allowed, 0 where they are [m, rad]."""
        overlap = np.maximum(-wall_distance(self.robot, self.pipe, q, self.base), 0.0)
        return np.asarray(overlap + 0.1 * episode.at_limit(self.robot, TASK, q))

    def pose_at(self, target: Floats) -> Floats | None:
        """A pose with its tip on the target, by drawing poses around the best ones, again and again."""
        mean, spread = np.array([0.25, 0.0, 0.3, 0.3]), np.array([0.08, 0.4, 0.5, 0.5])
        for _ in range(ROUNDS):
            q = mean + spread * self.rng.standard_normal((POSES, 4))
            q = np.clip(q, self.robot.lower, self.robot.upper)
            tip = frames.robot_to_pipe(kinematics.forward(self.robot, q).tip, self.base)
            missed = np.maximum(np.linalg.norm(tip - target, axis=1) - TASK.reach_tolerance, 0.0)
            cost = missed + 3 * self.blocked(q)
            best = cost.argsort()[:KEPT]
            if cost[best[0]] == 0.0:
                return np.asarray(q[best[0]])
            mean, spread = q[best].mean(axis=0), 0.9 * spread.clip(0.002) + 0.1 * q[best].std(axis=0)
        return None

    def comes_out(self, q: Floats) -> bool:
        """Whether the arm can be drawn back from a pose to a straight one without touching a wall."""
        while q[0] > 0.0:
            tried = q + np.concatenate([np.zeros((1, 4)), self.rng.uniform(-MOVE, MOVE, (NEARBY, 4))])
            tried[:, 0] = q[0] - BACK
            free = tried[self.blocked(tried) == 0.0]
            if not len(free):
                return False
            q = free[np.abs(free[:, 1:]).sum(axis=1).argmin()]
        return bool(np.abs(q[1:]).max() < 0.3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
@settings(max_examples=12, deadline=None)
@given(pipe=elbows, seed=seeds)
def test_the_arm_can_come_to_every_target_without_a_touch(name: str, pipe: PipeCorner, seed: int) -> None:
    robot = load_robot(name)
    episodes = drawn(robot, pipe, seed)
    search = Search(robot, pipe, float(episodes.base[0]))
    pose = search.pose_at(in_pipe(episodes))
    assert pose is not None
    assert search.comes_out(pose)


@settings(max_examples=60, deadline=None)
@given(pipe=elbows, seed=seeds)
def test_targets_lie_in_the_pipe_and_around_the_bend(pipe: PipeCorner, seed: int) -> None:
    robot = load_robot("basic")
    episodes = drawn(robot, pipe, seed)
    assert pipe.contains(in_pipe(episodes))
    tip, edge, target = kinematics.forward(robot, episodes.q).tip[0], episodes.edge[0], episodes.target[0]
    assert target[0] > edge[0] > tip[0]
    assert np.linalg.norm(target - tip) > TASK.start_gap[0] + TASK.reach_tolerance


@settings(max_examples=40, deadline=None)
@given(pipe=elbows, seed=seeds)
def test_an_arm_of_long_reach_gets_the_target_that_was_drawn(pipe: PipeCorner, seed: int) -> None:
    robot = load_robot("basic")
    slide = robot.links[0].model_copy(update={"joint": robot.joints[0].model_copy(update={"upper": 5.0})})
    long = robot.model_copy(update={"links": (slide, *robot.links[1:])})
    mitre = PipeCorner.of(pipe.diameter * 1e3, np.degrees(pipe.angle))
    near, far, sharp = (drawn(*pair, seed) for pair in ((robot, pipe), (long, pipe), (robot, mitre)))
    for name in ("q", "turn_sign"):
        assert np.array_equal(getattr(near, name), getattr(far, name))
    past = pipe.along_second_leg(in_pipe(far)) - [pipe.inner_edge, 0.0]
    assert past == pytest.approx(mitre.along_second_leg(in_pipe(sharp)) - [mitre.inner_edge, 0.0])  # the same draw
    assert near.target[0] @ pipe.second_leg <= far.target[0] @ pipe.second_leg + 1e-9


@settings(max_examples=40, deadline=None)
@given(pipe=elbows, seed=seeds)
def test_turns_mirror_each_other(pipe: PipeCorner, seed: int) -> None:
    one, two = (drawn(load_robot("basic"), each, seed) for each in (pipe, pipe.mirrored))
    assert np.array_equal(one.target, two.target)
    assert np.array_equal(in_pipe(one), in_pipe(two) * [1.0, -1.0])
