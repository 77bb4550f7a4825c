"""Evaluations: the same episodes whatever else is evaluated, and all of them counted."""

from __future__ import annotations

import numpy as np
import pytest

from pipenav.arrays import Floats
from pipenav.evaluation import episode_runner
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.episode_runner import EpisodeResults
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.passage import run_task
from pipenav.pipes.corner_sets import parse_corners
from pipenav.pipes.route_sets import parse_pipes, parse_routes
from pipenav.policies.named import PolicyController, open_controller
from pipenav.policies.policy import load_policy
from pipenav.robots.robot import load_robot
from pipenav.storage import shipped
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.registry import task_of

EPISODES = 4
NAMES = ["d=100,angle=90", "d=70,angle=55", "d=70,angle=55,turn=right"]
PIPES = parse_corners(NAMES)


class Clumsy:
    """Acts on its observation alone, and badly: it hits walls and limits, where episodes could disturb each other."""

    robot, task = load_robot("basic"), ReachConfig()

    def __init__(self) -> None:
        size = len(task_of(self.task).observation_scale(self.robot))
        self._weights = np.random.default_rng(1).normal(0.0, 1.5, (size, len(self.robot.joints)))

    def act(self, observation: Floats) -> Floats:
        return np.tanh(np.einsum("ni,ij->nj", observation, self._weights))


@pytest.fixture(scope="module")
def results() -> EpisodeResults:
    return run_task(Clumsy(), PIPES, EPISODES, seed=3)


def require_same(some: EpisodeResults, others: EpisodeResults) -> None:
    for name, one, other in zip(some._fields, some, others, strict=True):
        np.testing.assert_array_equal(one, other, err_msg=name)


def test_the_same_seed_gives_the_same_results(results: EpisodeResults) -> None:
    require_same(run_task(Clumsy(), PIPES, EPISODES, seed=3), results)


def test_another_seed_gives_other_episodes(results: EpisodeResults) -> None:
    other = run_task(Clumsy(), PIPES[:1], EPISODES, seed=4)
    assert (other.steps != results.steps[:EPISODES]).any()


@pytest.mark.parametrize("robots", [1, 5])
def test_results_do_not_depend_on_how_many_robots_are_stepped_together(
    robots: int, results: EpisodeResults, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(episode_runner, "MAX_ROBOTS", robots)
    require_same(run_task(Clumsy(), PIPES, EPISODES, seed=3), results)


def test_results_do_not_depend_on_the_other_pipes(results: EpisodeResults) -> None:
    turned = run_task(Clumsy(), PIPES[::-1], EPISODES, seed=3)
    for i in range(len(PIPES)):
        here, there = slice(i * EPISODES, (i + 1) * EPISODES), len(PIPES) - 1 - i
        part = EpisodeResults(*(column[here] for column in results))
        require_same(EpisodeResults(*(column[there * EPISODES : (there + 1) * EPISODES] for column in turned)), part)


def test_results_do_not_depend_on_the_number_of_episodes(results: EpisodeResults) -> None:
    fewer = run_task(Clumsy(), PIPES[:1], 2, seed=3)
    require_same(fewer, EpisodeResults(*(column[:2] for column in results)))


def test_every_episode_has_ended_in_one_way(results: EpisodeResults) -> None:
    assert len(results.outcome) == len(PIPES) * EPISODES
    assert set(results.outcome) <= set(Outcome) - {Outcome.RUNNING}
    limit = Clumsy.task.max_steps
    assert ((results.steps > 0) & (results.steps <= limit)).all()
    assert ((results.contact_share >= 0) & (results.contact_share <= 1)).all()
    assert (results.min_range > 0).all()
    assert (results.force > 0).any()
    assert (results.penetration >= 0).all()


def test_progress_is_reported_until_the_end() -> None:
    reports: list[tuple[str, int, int, int]] = []
    config = EvaluationConfig(policy="baseline:centreline", pipes=(NAMES[0],), episodes=EPISODES)
    CheckedEvaluation(config).run(lambda *all_four: reports.append(all_four))
    assert reports == sorted(reports)
    assert reports[-1] == ("reach", EPISODES, EPISODES, EPISODES)


def test_the_shipped_policy_passes_the_working_range() -> None:
    policy = shipped.policies_dir() / "arm" / "best.zip"
    assert policy.is_file(), "models/policies/arm/best.zip is missing: train it by pipenav train --preset arm-tees"
    sample = parse_corners(["working-range"])[::16]
    assert len(sample) == 12
    found = run_task(PolicyController(load_policy(policy)), sample, EPISODES, seed=11)
    assert (found.outcome == Outcome.REACHED).mean() >= 0.95


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pirate-strong", "pirate-strong-gravity"])
def test_the_whole_robots_shipped_policies_pass_corners_and_routes(name: str) -> None:
    sample = [*parse_corners(["working-range"])[::16], *parse_routes(["runs-level:3", "runs-level:14"])]
    found = run_task(open_controller(name), sample, 2, seed=11)
    assert (found.outcome == Outcome.REACHED).mean() >= 0.9


@pytest.mark.slow
def test_the_whole_robot_passes_elbows_s_bends_and_reducers() -> None:
    sample = parse_pipes(
        ["d=100,angle=90,bend_radius=1.5D", "d=70,angle=135,bend_radius=1D", "s-bends:40", "reducers:5"]
    )
    found = run_task(open_controller("pirate-strong"), sample, 2, seed=11)
    assert (found.outcome == Outcome.REACHED).all()
