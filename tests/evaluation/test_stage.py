"""Stages of an evaluation do what the batch would do by itself."""

from __future__ import annotations

from contextlib import closing

import numpy as np

from pipenav.backends.simulators import open_simulator
from pipenav.evaluation.episode_runner import EpisodeQueue, joined, random_start
from pipenav.evaluation.passage import run_task
from pipenav.evaluation.stage import TaskStage
from pipenav.pipes.corner_sets import parse_corners
from pipenav.policies.controller import actions_of
from pipenav.policies.named import open_controller
from pipenav.robots import kinematics
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.batch import ReachBatch

PIPES = parse_corners(["d=100,angle=90", "d=90,angle=60,turn=right"])


def test_the_front_stage_is_the_corner_task_under_its_controller() -> None:
    controller = open_controller("baseline:centreline")
    start = random_start(controller.robot, controller.task, PIPES, 1, seed=2)

    def batch() -> ReachBatch:
        queue = EpisodeQueue(start, len(PIPES), len(PIPES))
        simulator = open_simulator("mujoco", controller.robot, len(PIPES), {}, 4)
        return ReachBatch(
            controller.robot, controller.task, simulator, len(PIPES), lambda indices: joined(queue.take(indices))
        )

    with closing(batch()) as plain, closing(TaskStage(batch(), controller)) as stage:
        observation = plain.reset()
        stage.start(np.arange(stage.n))
        for _ in range(12):
            expected, step = plain.step(actions_of(controller, observation, plain)), stage.step()
            observation = expected.observation
            np.testing.assert_array_equal(step.outcome, expected.outcome)
            np.testing.assert_array_equal(step.truth.tip, expected.truth.tip)
            np.testing.assert_array_equal(step.q, plain.q)
            np.testing.assert_array_equal(stage.steps, plain.steps)


def test_an_episode_is_the_same_whenever_it_is_asked_for() -> None:
    controller = open_controller("baseline:centreline")
    start = random_start(controller.robot, controller.task, PIPES, 3, seed=2)
    for job in range(6):
        one, again = start(job), start(job)
        assert one.pipes == again.pipes == (PIPES[job // 3],)
        np.testing.assert_array_equal(one.q, again.q)
        np.testing.assert_array_equal(one.target, again.target)


def test_results_say_where_each_episode_ended() -> None:
    """The next stage starts there: the tip is at the target of those that reached it."""
    controller = open_controller("baseline:centreline")
    found = run_task(controller, PIPES, 2, seed=2)
    assert (found.outcome == Outcome.REACHED).all()
    start = random_start(controller.robot, controller.task, PIPES, 2, seed=2)
    for job, q in enumerate(found.q):
        episode = start(job)
        tip = kinematics.forward(controller.robot, q[None]).tip * [1.0, episode.turn_sign[0]]
        assert np.linalg.norm(tip - episode.target) <= controller.task.reach_tolerance
