"""Evaluation: the same episodes whatever runs beside them, and all of them counted."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from pipenav.arrays import Floats
from pipenav.cli import main
from pipenav.evaluation import episode_runner
from pipenav.evaluation.episode_runner import EpisodeResults
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.passage import run_task
from pipenav.pipes.corner_sets import parse_corners
from pipenav.pipes.route_sets import parse_routes
from pipenav.policies.controller import Controller
from pipenav.policies.named import PolicyController, open_controller
from pipenav.policies.policy import load_policy
from pipenav.robots.robot import load_robot
from pipenav.storage import shipped
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.registry import task_of

EPISODES = 4
NAMES = ["d=100,angle=90", "d=70,angle=55", "d=70,angle=55,turn=right"]
PIPES = parse_corners(NAMES)


def centreline() -> Controller:
    return open_controller("baseline:centreline")


class Clumsy:
    """Acts on its observation alone, and badly: it hits walls and limits, where episodes could disturb each other."""

    robot, task = load_robot("basic"), ReachConfig()

    def __init__(self) -> None:
        size = len(task_of(self.task).observation_scale(self.robot))
        self._weights = np.random.default_rng(1).normal(0.0, 1.5, (size, len(self.robot.joints)))

    def act(self, observation: Floats, batch: ReachBatch) -> Floats:  # noqa: ARG002  # the seam's signature
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
def test_results_do_not_depend_on_how_many_robots_run_together(
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
    assert (results.clearance > 0).all()
    assert (results.force > 0).any()
    assert (results.penetration >= 0).all()


def test_progress_is_told_until_the_end() -> None:
    told: list[tuple[str, int, int, int]] = []
    CheckedEvaluation("baseline:centreline", NAMES[:1], EPISODES, 0).run(lambda *all_four: told.append(all_four))
    assert told == sorted(told)
    assert told[-1] == ("front", EPISODES, EPISODES, EPISODES)


def test_the_shipped_policy_passes_the_working_range() -> None:
    policy = shipped.policies_dir() / "arm" / "best.zip"
    assert policy.is_file(), "models/policies/arm/best.zip is missing: train it by pipenav train --preset arm"
    sample = parse_corners(["working-range"])[::16]
    assert len(sample) == 12
    found = run_task(PolicyController(load_policy(policy)), sample, EPISODES, seed=11)
    assert (found.outcome == Outcome.REACHED).mean() >= 0.95


@pytest.mark.parametrize("name", ["pirate", "pirate-gravity"])
def test_the_whole_robots_shipped_policies_pass_corners_and_runs(name: str) -> None:
    sample = [*parse_corners(["working-range"])[::16], *parse_routes(["runs-level:3", "runs-level:14"])]
    found = run_task(open_controller(name), sample, 2, seed=11)
    assert (found.outcome == Outcome.REACHED).mean() >= 0.9


def run(capsys: pytest.CaptureFixture[str], *args: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as left:
        main(["eval", *args])
    shown = capsys.readouterr()
    code = left.value.code
    assert code is None or isinstance(code, int)
    return code or 0, shown.out, shown.err


def test_the_command_writes_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    code, said, _ = run(capsys, "--policy", "baseline:random", "--pipes", NAMES[0], "--episodes", "4")
    folder = Path("runs") / "baseline-random" / "eval-d100-angle90"
    assert code == 0
    assert str(folder) in said.replace("\n", "")
    assert {path.name for path in folder.iterdir()} == {"eval.json", "eval.csv", "success.png", "map.png"}
    table = json.loads((folder / "eval.json").read_text(encoding="utf-8"))
    assert len(table["pipes"]) == 1
    assert table["pipes"][0]["episodes"] == 4
    with (folder / "eval.csv").open(encoding="utf-8", newline="") as file:
        assert len(list(csv.DictReader(file))) == 1
    for name in ("success.png", "map.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--policy", "baseline:centerline"), "unknown baseline 'baseline:centerline': did you mean"),
        (("--policy", "no-such-policy"), "unknown policy 'no-such-policy'"),
        (("--policy", "no-such.zip"), "no-such.zip"),
        (("--pipes", "thesi"), "unknown pipe set 'thesi': did you mean 'thesis'"),
        (("--pipes", "d=90"), "pipe 'd=90' is incomplete"),
        (("--backend", "mujocco"), "unknown backend 'mujocco': did you mean 'mujoco'"),
        (("--robot", "basik"), "unknown robot 'basik': did you mean 'basic'?"),
        (("--option", "timestep"), "option 'timestep' has no value: write it as key=value"),
        (("--option", "timstep=1"), "unknown key 'timstep': did you mean 'timestep'"),
        (("--option", "timestep=often"), "timestep: input should be a valid number, given 'often'."),
    ],
)
def test_what_is_wrong_is_said_in_one_line(
    args: tuple[str, ...], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    code, said, error = run(capsys, *("--policy", "baseline:random", "--out", str(out), *args))
    assert code == 1
    assert error.startswith("pipenav: error: ")
    assert message in error
    assert error.count("\n") == 1
    assert not said
    assert not out.exists()


def test_a_folder_that_cannot_be_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "file"
    file.touch()
    code, _, error = run(capsys, "--policy", "baseline:random", "--out", str(file))
    assert code == 1
    assert error == f"pipenav: error: cannot use the folder {file}: it is a file.\n"
