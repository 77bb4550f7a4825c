"""An evaluation in parts: the same result wherever the parts run, whoever dies on the way, and however they are cut."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.processes import started
from helpers.waiting import wait_until
from hypothesis import given
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.evaluation import part_jobs, part_plan
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.part_plan import Shard
from pipenav.evaluation.parts import PartResult, StageRows, run_part
from pipenav.evaluation.pipe_counts import pipe_records
from pipenav.jobs import JobStore, MemoryStore
from pipenav.jobs.here import HerePlace
from pipenav.jobs.processes import ProcessesPlace
from pipenav.pipes.corner_sets import parse_corners
from pipenav.tasks.outcome import Outcome, PassageStage

NAMES = ("d=100,angle=90", "d=70,angle=55", "d=70,angle=55,turn=right")
CONFIGS: dict[str, dict[str, Any]] = {
    "policy": {"policy": "arm", "episodes": 3},
    "passage": {"policy": "arm", "stage": "passage", "episodes": 3, "disturb": "noise"},
    "random": {"policy": "baseline:random", "episodes": 3},
    "pybullet": {"policy": "baseline:centreline", "backend": "pybullet", "episodes": 2},
}


def config(name: str) -> EvaluationConfig:
    return EvaluationConfig(pipes=NAMES, seed=3, **CONFIGS[name])


@pytest.fixture(autouse=True)
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part_plan, "PART_EPISODES", (2, 4))


class SomeoneDies:
    """A store in which, when the first part is kept, a worker of ours is killed."""

    def __init__(self, store: MemoryStore) -> None:
        self._store, self.killed = store, 0
        self.has, self.read = store.has, store.read

    def write(self, key: str, content: bytes) -> None:
        self._store.write(key, content)
        workers = [pid for pid, line in children().items() if "pipenav.jobs.worker" in line]
        if workers and not self.killed:
            self.killed = workers[-1]
            os.kill(self.killed, signal.SIGKILL)


def children() -> dict[int, str]:
    """Processes that this one has started, with their command lines."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if int((folder / "stat").read_text().rpartition(")")[2].split()[1]) == os.getpid():
                found[int(folder.name)] = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode()
        except OSError:
            continue
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", CONFIGS)
def test_processes_give_the_same_bytes_though_one_is_killed(name: str) -> None:
    if name == "pybullet":
        pytest.importorskip("pybullet")
    here = CheckedEvaluation(config(name)).run().to_json()
    checked, store = CheckedEvaluation(config(name)), SomeoneDies(MemoryStore())
    assert checked.parts.count >= 3
    assert checked.run(place=ProcessesPlace("2"), store=store).to_json() == here
    assert store.killed


@pytest.mark.parametrize("sizes", [(1, 1), (4, 4), (7, 7), (1000, 1000)])
@pytest.mark.parametrize("name", ["policy", "passage"])
def test_mujocos_results_do_not_depend_on_the_parts(
    name: str, sizes: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = CheckedEvaluation(config(name)).run().to_json()
    monkeypatch.setattr(part_plan, "PART_EPISODES", sizes)
    monkeypatch.setattr(part_plan, "MOST_TOGETHER", 500)
    assert CheckedEvaluation(config(name)).run().to_json() == expected


@given(st.integers(1, 3_000_000))
def test_parts_have_every_episode_once(total: int) -> None:
    bounds = part_plan.bounds_of(total)
    sizes = np.diff(bounds)
    fewest, most = part_plan.PART_EPISODES
    assert bounds[0] == 0 and bounds[-1] == total
    assert (sizes > 0).all() and (sizes <= max(most, fewest)).all()
    assert len(set(sizes[:-1])) <= 1


@given(st.lists(st.booleans(), min_size=1, max_size=12), st.booleans())
def test_parts_that_are_missing_run_once_each(kept: list[bool], together: bool) -> None:
    plan = CheckedEvaluation(config("policy")).parts
    monkey = [*range(0, 2 * len(kept), 2), 2 * len(kept)]
    plan.__dict__["bounds"] = monkey
    groups = list(plan.missing(kept, together))
    assert [i for group in groups for i in group] == [i for i, there in enumerate(kept) if not there]
    if not together:
        assert all(len(group) == 1 for group in groups)


@pytest.mark.parametrize(("policy", "most"), [("arm", 4096), ("pirate", 1365)])
def test_a_stop_loses_few_episodes_of_long_ones(policy: str, most: int) -> None:
    plan = CheckedEvaluation(EvaluationConfig(policy=policy, episodes=50)).parts
    groups = list(plan.missing([False] * plan.count, together=True))
    assert len(groups) > 1
    assert all(plan.bounds[one.stop] - plan.bounds[one.start] <= most for one in groups)


@given(st.data())
def test_records_do_not_depend_on_where_parts_end(data: st.DataObject) -> None:
    pipes, episodes = parse_corners(list(NAMES)), data.draw(st.integers(1, 5))
    total = len(pipes) * episodes
    rng = np.random.default_rng(data.draw(st.integers(0, 100)))
    reach = rows_of(np.arange(total), rng)
    rows = {PassageStage.REACH: reach, PassageStage.REAR: rows_of(reach.jobs[reach.passed], rng)}
    cuts = sorted(data.draw(st.sets(st.integers(1, total))) | {total})
    whole = list(pipe_records([(total, rows)], pipes, episodes))
    parts = [
        (end, {stage: part.between(begin, end) for stage, part in rows.items()})
        for begin, end in zip([0, *cuts], cuts, strict=False)
    ]
    assert list(pipe_records(parts, pipes, episodes)) == whole
    assert sum(record.reach_successes or 0 for record in whole) == reach.passed.sum()


def rows_of(jobs: np.ndarray, rng: np.random.Generator) -> StageRows:
    k = len(jobs)
    outcome = rng.choice([Outcome.REACHED, Outcome.LIMIT, Outcome.TIMEOUT], k).astype(np.int8)
    return StageRows(jobs, outcome, rng.integers(1, 50, k), *rng.random((4, k)))


@given(st.integers(0, 2**32 - 1))
def test_results_come_back_from_their_bytes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    result = PartResult({PassageStage.LOCATE: rows_of(np.arange(3), rng)}, "some cpu")
    again = PartResult.from_bytes(result.to_bytes())
    assert again.cpu == "some cpu"
    for one, other in zip(again.rows[PassageStage.LOCATE], result.rows[PassageStage.LOCATE], strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)


def test_bytes_of_something_else_are_refused() -> None:
    for content in (b"", b"PK", np.arange(3).tobytes()):
        with pytest.raises(PipenavError, match="damaged"):
            PartResult.from_bytes(content)


def test_shares_are_the_whole_and_no_part_twice(tmp_path: Path) -> None:
    expected = CheckedEvaluation(config("random")).run().to_json()
    store, written = JobStore(tmp_path / "store", {}), []
    keep = store.write
    store.write = lambda key, content: (written.append(key), keep(key, content))[1]  # type: ignore[method-assign]
    for number in (2, 1):
        CheckedEvaluation(config("random")).run_parts(store, shard=Shard(number, 2))
    checked = CheckedEvaluation(config("random"))
    assert checked.missing(store) == 0
    assert len(written) == len(set(written)) == checked.parts.count
    assert checked.merged(store).to_json() == expected


def test_an_evaluation_with_a_missing_part_is_not_counted(tmp_path: Path) -> None:
    store = JobStore(tmp_path / "store", {})
    checked = CheckedEvaluation(config("random"))
    checked.run_parts(store, shard=Shard(1, 2))
    with pytest.raises(PipenavError, match="part 2 of the evaluation is missing"):
        checked.merged(store)


def test_progress_counts_every_episode_once() -> None:
    last: dict[str, tuple[int, int, int]] = {}

    def report(stage: str, *counts: int) -> None:
        assert 0 <= counts[2] <= counts[1] <= counts[0]
        last[stage] = counts  # type: ignore[assignment]

    found = CheckedEvaluation(config("passage")).run(report)
    located = sum(record.located or 0 for record in found.pipes)
    reached = sum(record.reach_successes or 0 for record in found.pipes)
    rear = sum(record.rear_successes or 0 for record in found.pipes)
    assert last == {"locate": (9, 9, located), "reach": (located, located, reached), "rear": (reached, reached, rear)}


def test_other_versions_are_refused() -> None:
    part = CheckedEvaluation(config("policy")).parts.part(0, 1)
    other = part.__class__(*(getattr(part, name) for name in list(part.__dataclass_fields__)[:-1]), {"mujoco": "0.1"})
    with pytest.raises(PipenavError, match=r"has mujoco \S+, and the machine that drives the jobs 0\.1: install"):
        run_part(other, HerePlace().open(lambda *_: None, lambda: False))  # type: ignore[arg-type]


def test_a_mix_of_processors_is_noted() -> None:
    checked, store = CheckedEvaluation(config("policy")), MemoryStore()
    checked.run_parts(store)
    key = checked.parts.key(1)
    store.write(key, PartResult(PartResult.from_bytes(store.read(key) or b"").rows, "another").to_bytes())
    checked.merged(store)
    assert len(checked.cpus) == 2


@pytest.mark.slow
@pytest.mark.parametrize("killed", ["driver", "interrupted"])
def test_a_command_that_is_killed_goes_on_and_runs_no_finished_part_twice(killed: str, tmp_path: Path) -> None:
    command = ("eval", "--policy", "arm", "--pipes", "thesis", "--episodes", "30", "--jobs", "2", "--out", "out")
    store = tmp_path / "out" / "unfinished"
    with started(*command, folder=tmp_path) as family:
        wait_until(lambda: len(list(store.glob("part-*"))) >= 2, "two parts are kept")
        os.kill(family.command.pid, signal.SIGKILL if killed == "driver" else signal.SIGINT)
        said = family.command.communicate()[0]
    wait_until(lambda: not family.alive(), "nothing is left")
    if killed == "interrupted":
        assert "parts are kept in out/unfinished; the same command goes on from there" in said
    kept = {path.name: path.stat().st_mtime_ns for path in store.glob("part-*")}
    assert not (tmp_path / "out" / "eval.json").exists()
    with started(*command, folder=tmp_path) as family:
        seen: dict[str, int] = {}
        while family.command.poll() is None:
            seen |= times_of(store)
            time.sleep(0.05)
        said = family.command.communicate()[0]
    assert f"{len(kept)} of 16 parts are there already" in said
    assert kept.items() <= seen.items()
    assert not store.exists()
    (tmp_path / "fresh").mkdir()
    with started(*command[:-4], folder=tmp_path / "fresh") as family:
        family.command.communicate()
    (fresh,) = (tmp_path / "fresh").rglob("eval.json")
    assert fresh.read_bytes() == (tmp_path / "out" / "eval.json").read_bytes()


def times_of(store: Path) -> dict[str, int]:
    found = {}
    for path in store.glob("part-*"):
        try:
            found[path.name] = path.stat().st_mtime_ns
        except FileNotFoundError:
            continue
    return found


@pytest.mark.parametrize("breaks", [lambda: PipenavError("the user's"), lambda: ZeroDivisionError("ours")])
def test_an_error_in_a_part_is_raised(breaks: Callable[[], Exception], monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_part: object, _control: object) -> bytes:
        raise breaks()

    monkeypatch.setattr(part_jobs, "run_part", broken)
    with pytest.raises(type(breaks()), match=str(breaks())):
        CheckedEvaluation(config("policy")).run()
