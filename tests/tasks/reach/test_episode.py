"""Starts, targets and the distance to them, over all pipes of the working range."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import parse_corners
from pipenav.robots import kinematics
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import distance_to_target

ROBOT, TASK = load_robot("basic"), ReachConfig()
PIPES = parse_corners(["working-range"])
seeds = st.integers(0, 2**32 - 1)
any_pipe = st.sampled_from(PIPES)


def drawn(seed: int, pipes: Sequence[PipeCorner] = PIPES) -> episode.ReachEpisodes:
    return episode.sample(ROBOT, TASK, pipes, np.random.default_rng(seed))


def in_pipe(points: Floats, base: float, turn_sign: float) -> Floats:
    """Points (..., 2) of the canonical frame in the pipe's frame."""
    return (points + np.array([base, 0.0])) * [1.0, turn_sign]


@settings(max_examples=25)
@given(seeds)
def test_every_target_lies_in_the_second_leg(seed: int) -> None:
    episodes = drawn(seed)
    for i, pipe in enumerate(PIPES):
        target = in_pipe(episodes.target[i], episodes.base[i], episodes.turn_sign[i])
        along, left = pipe.along_second_leg(target)
        assert pipe.contains(target)
        assert pipe.inner_edge + TASK.target_depth[0] - 1e-9 <= along <= pipe.inner_edge + TASK.target_depth[1] + 1e-9
        assert abs(left) <= TASK.target_lateral * pipe.diameter + 1e-9


@settings(max_examples=40)
@given(seeds)
def test_start_poses_keep_off_the_wall(seed: int) -> None:
    episodes = drawn(seed)
    pose = kinematics.forward(ROBOT, episodes.q)
    half = np.array([link.width / 2 for link in ROBOT.links])
    normal = np.stack([-np.sin(pose.headings), np.cos(pose.headings)], axis=-1) * half[:, None]
    ends = np.concatenate([pose.joints[:, 1:], pose.tip[:, None]], axis=1)
    corners = np.stack([pose.joints + normal, pose.joints - normal, ends + normal, ends - normal])
    radius = np.array([pipe.radius for pipe in PIPES])[:, None]
    assert np.all(np.abs(corners[..., 1]) <= radius - episode.START_WALL_DISTANCE + 1e-9)
    edge = np.array([pipe.inner_edge for pipe in PIPES])
    front = corners[..., 0].max(axis=(0, 2)) + episodes.base
    assert np.all(front <= -edge - TASK.start_gap[0] + half.max() * 0.2)  # a bent tip's corner stands out a little


@settings(max_examples=40)
@given(seeds)
def test_starts_are_at_no_limit_and_targets_are_not_reached_yet(seed: int) -> None:
    episodes = drawn(seed)
    tip = kinematics.forward(ROBOT, episodes.q).tip
    assert not episode.at_limit(ROBOT, TASK, episodes.q).any()
    assert np.all(np.linalg.norm(tip - episodes.target, axis=1) > 5 * TASK.reach_tolerance)


@settings(max_examples=40)
@given(seeds, any_pipe)
def test_turns_mirror_each_other(seed: int, pipe: PipeCorner) -> None:
    other = pipe.model_copy(update={"turn": "right" if pipe.turn == "left" else "left"})
    one, two = drawn(seed, [pipe]), drawn(seed, [other])
    assert one.turn_sign == -two.turn_sign
    for name in ("q", "base", "target", "edge"):
        assert np.array_equal(getattr(one, name), getattr(two, name))


def crossing(p: Floats, q: Floats, a: Floats, b: Floats) -> bool:
    """Whether the segments pq and ab cross: the ends of each lie on either side of the other."""

    def turn_sign(u: Floats, v: Floats, w: Floats) -> float:
        return float((v - u)[0] * (w - u)[1] - (v - u)[1] * (w - u)[0])

    return turn_sign(p, q, a) * turn_sign(p, q, b) < 0 and turn_sign(a, b, p) * turn_sign(a, b, q) < 0


sharp_pipes = st.builds(PipeCorner.of, st.floats(70, 120), st.floats(30, 179), st.just("left"))


@settings(max_examples=40)
@given(seeds, sharp_pipes)
def test_the_distance_to_the_target_is_the_shortest_path_in_the_pipe(seed: int, pipe: PipeCorner) -> None:
    episodes, rng = drawn(seed, [pipe]), np.random.default_rng(seed)
    target, edge = (in_pipe(a[0], episodes.base[0], 1.0) for a in (episodes.target, episodes.edge))
    before, corner, after = pipe.walls.inner
    assert corner == pytest.approx(edge)
    tips = rng.uniform(-0.5, 0.5, (400, 2))
    for tip in tips[pipe.contains(tips)][:60]:
        hidden = crossing(tip, target, before, corner) or crossing(tip, target, corner, after)
        around = np.linalg.norm(tip - edge) + np.linalg.norm(target - edge)
        expected = around if hidden else np.linalg.norm(tip - target)
        assert distance_to_target(tip[None], target[None], edge[None])[0] == pytest.approx(expected)


@settings(max_examples=40)
@given(seeds, any_pipe, st.floats(0, 0.01), st.floats(-np.pi, np.pi))
def test_the_distance_to_the_target_changes_by_no_more_than_the_tip_moves(
    seed: int, pipe: PipeCorner, step: float, heading: float
) -> None:
    episodes, rng = drawn(seed, [pipe]), np.random.default_rng(seed)
    tips = rng.uniform(-0.5, 0.5, (400, 2))
    moved = tips + step * np.array([np.cos(heading), np.sin(heading)])
    turn_sign = episodes.turn_sign[0]
    inside = pipe.contains(tips * [1, turn_sign]) & pipe.contains(moved * [1, turn_sign])
    inside &= pipe.contains((tips + moved) / 2 * [1, turn_sign])
    target, edge = (np.tile(in_pipe(a, episodes.base[0], 1.0), (400, 1)) for a in (episodes.target, episodes.edge))
    change = distance_to_target(moved, target, edge) - distance_to_target(tips, target, edge)
    assert np.all(np.abs(change[inside]) <= step + 1e-9)


@settings(max_examples=40)
@given(seeds, any_pipe)
def test_the_distance_to_the_target_falls_to_zero_along_the_path(seed: int, pipe: PipeCorner) -> None:
    episodes = drawn(seed, [pipe])
    tip = kinematics.forward(ROBOT, episodes.q).tip
    stations = [np.linspace(tip[0], episodes.edge[0], 50), np.linspace(episodes.edge[0], episodes.target[0], 50)]
    path = np.concatenate(stations)
    path[:, 1] -= 1e-9  # on the free side of the edge
    distances = distance_to_target(path, np.tile(episodes.target, (100, 1)), np.tile(episodes.edge, (100, 1)))
    assert np.all(np.diff(distances) <= 1e-8)
    assert distances[-1] == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("joint", range(4))
@pytest.mark.parametrize("end", ["lower", "upper"])
def test_every_joint_has_two_limits(joint: int, end: str) -> None:
    q = np.zeros((1, 4))
    q[0, joint] = 0.95 * getattr(ROBOT, end)[joint]
    assert not episode.at_limit(ROBOT, TASK, q).any()
    q[0, joint] = getattr(ROBOT, end)[joint]
    assert episode.at_limit(ROBOT, TASK, q).all()
