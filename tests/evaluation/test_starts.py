"""Sets of starts: files read back, episodes that begin in them, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.traversing import ROBOT, started
from hypothesis import given
from hypothesis import strategies as st

from pipenav.errors import ConfigError, FileProblem, PipenavError, UnknownName
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.starts import PipeStarts, Start, StartSet, load_starts, start_set_names
from pipenav.pipes.route_sets import parse_pipes
from pipenav.robots.robot import load_robot
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import sample

HELD = TraverseConfig(kind="traverse", set_points="held")

numbers = st.floats(-1, 1).map(lambda value: round(value, 5))
starts = st.builds(
    Start,
    stuck=st.sampled_from(["jam", "slip", "limit", "fold"]),
    q=st.tuples(*[numbers] * 9),
    press=st.tuples(*[numbers] * 6),
)


def start_set(rows: list[list[Start]], robot: str = "pirate") -> StartSet:
    """The starts, each list in a pipe of its own."""
    pipes = tuple(PipeStarts(pipe=f"d=100,angle={60 + i}", starts=tuple(row)) for i, row in enumerate(rows))
    return StartSet(schema=1, robot=robot, drawn="by hand", pipes=pipes)


@given(
    rows=st.integers(1, 3).flatmap(lambda each: st.lists(st.lists(starts, min_size=each, max_size=each), min_size=1))
)
def test_a_set_is_read_as_it_was_written(rows: list[list[Start]], tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.mktemp("starts") / "set.json"
    file.write_text(start_set(rows).to_json())
    assert load_starts(str(file)) == start_set(rows)


def test_episodes_begin_where_the_set_says() -> None:
    found = load_starts("stuck-starts")
    pipes = parse_pipes([pipe.pipe for pipe in found.pipes[:3]])
    for pipe, rows in zip(pipes, found.pipes, strict=False):
        start = rows.starts[-1]
        episode = start.put(sample(ROBOT, HELD, [pipe], np.random.default_rng(0)))
        with started(episode, HELD) as batch:
            np.testing.assert_allclose(batch.q[0], start.q, atol=1e-9)
            np.testing.assert_allclose(batch.set_points[0] - batch.q[0, 3:], start.press, atol=1e-9)
            np.testing.assert_allclose(batch.points[0, 0], start.q[:2], atol=1e-9)


@pytest.mark.parametrize("name", start_set_names())
def test_shipped_sets_have_hundreds_of_different_starts_inside_their_pipes(name: str) -> None:
    found = load_starts(name)
    poses = {start.q for pipe in found.pipes for start in pipe.starts}
    assert len(poses) == len(found.pipes) * found.each >= 200
    for pipe, rows in zip(parse_pipes([pipe.pipe for pipe in found.pipes]), found.pipes, strict=True):
        end = 3 * load_robot(found.robot).length
        assert all(abs(start.q[0]) < end and abs(start.q[1]) < end for start in rows.starts)
        assert pipe.corner is not None


def test_every_part_of_an_evaluation_begins_with_its_own_starts() -> None:
    checked = CheckedEvaluation(EvaluationConfig(policy="pirate", starts="stuck-starts"))
    found = load_starts("stuck-starts")
    every = [start.q for pipe in found.pipes for start in pipe.starts]
    parts, seen = checked.parts, []
    assert parts.count > 1 and parts.total == len(every)
    for index in range(parts.count):
        plan = parts.part(index, index + 1).plan
        seen += [tuple(plan.numbered()(number).q[0].tolist()) for number in plan.numbers]
    assert seen == every


def test_an_evaluation_is_told_from_one_with_other_starts(tmp_path: Path) -> None:
    def request(move: float) -> object:
        start = Start(stuck="jam", q=(-0.5 + move, *[0.0] * 8), press=(0.0,) * 6)
        (tmp_path / "set.json").write_text(start_set([[start]]).to_json())
        config = EvaluationConfig(policy="pirate", starts=str(tmp_path / "set.json"))
        return CheckedEvaluation(config).parts.request()

    assert request(0.0) == request(0.0) != request(0.01)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([[(9, 6)], [(9, 6), (9, 6)]], "as many in each"),
        ([[(8, 6)]], "9 coordinates and 6 presses"),
        ([[(9, 5)]], "9 coordinates and 6 presses"),
    ],
)
def test_sets_that_fit_no_robot_are_refused(rows: list[list[tuple[int, int]]], message: str, tmp_path: Path) -> None:
    made = [[Start(stuck="jam", q=(0.0,) * q, press=(0.0,) * press) for q, press in row] for row in rows]
    (tmp_path / "set.json").write_text(start_set(made).to_json())
    with pytest.raises(ConfigError, match=message):
        load_starts(str(tmp_path / "set.json"))


def test_what_is_no_set_and_what_is_another_robots_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UnknownName):
        load_starts("stuck")
    with pytest.raises(FileProblem):
        load_starts(str(tmp_path / "missing.json"))
    (tmp_path / "set.json").write_text("[]")
    with pytest.raises(ConfigError):
        load_starts(str(tmp_path / "set.json"))
    with pytest.raises(PipenavError, match="whose links differ: choose a policy of pirate"):
        load_starts("stuck-starts").check_robot(load_robot("basic"))
