"""The report of an evaluation in a real browser: one click on a cell shows numbers, failures and a picture."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.browser import EVIL, opened

from pipenav.evaluation import Evaluation, EvaluationConfig, PipeRecord
from pipenav.evaluation.failures import Failure, with_poses
from pipenav.evaluation.html_report import Pictured, evaluation_page
from pipenav.evaluation.passability_record import PipePassability
from pipenav.evaluation.replay import Replayed
from pipenav.pipes import Pipe, PipeCorner, parse_pipes
from pipenav.robots import load_robot
from pipenav.tasks.outcome import Outcome, PassageStage

EACH = 20
ROBOT = load_robot("basic")
EVIL_FILE = f"{EVIL}.zip"


def failed_in(number: int) -> int:
    """Failed episodes of a pipe, by its number: in every third one some."""
    return 0 if number % 3 else 1 + number % EACH


def made(pipes: Sequence[Pipe], policy: str = "arm") -> tuple[Evaluation, Pictured]:
    """An evaluation in pipes as if it had been run, with a motion of every failed episode and of every pipe."""
    rng, records, failures, replayed = np.random.default_rng(0), [], [], {}
    for number, pipe in enumerate(pipes):
        failed, corner = failed_in(number), pipe.require_corner()
        numbers = range(number * EACH, number * EACH + max(failed, 1))
        for episode in numbers:
            outcome = Outcome.TIMEOUT if failed else Outcome.REACHED
            q = np.cumsum(rng.normal(0, 0.01, (60, ROBOT.coordinates)), axis=0)
            stage = PassageStage.REACH
            replayed[episode] = Replayed(episode, pipe, stage, outcome, 59, stage, -0.4, q, (0.02, 0.1))
            if failed:
                failures.append(Failure(number=episode, pipe=number, stage="reach", outcome=outcome.label, steps=59))
        records.append(
            PipeRecord(
                diameter_mm=round(1000 * pipe.diameter, 6),
                angle_deg=round(float(np.degrees(corner.angle)), 6),
                turn=corner.turn,
                episodes=EACH,
                reach_attempts=EACH,
                reach_successes=EACH - failed,
                failures={"timeout": failed} if failed else {},
                min_range_m=0.007,
                max_penetration_m=0.0001,
                peak_force_n=12.25,
                contact_time_share=0.5,
                mean_steps=31.0,
            )
        )
    config = EvaluationConfig(policy=policy, pipes=("thesis",), episodes=EACH, stage="reach")
    evaluation = Evaluation.of(records, config=config, robot="basic")
    return evaluation, Pictured(ROBOT, pipes, with_poses(failures, replayed.values(), ROBOT), replayed, "view")


@pytest.fixture(scope="module")
def large() -> tuple[Evaluation, Pictured]:
    return made(parse_pipes(["working-range"]))


@pytest.fixture
def file(large: tuple[Evaluation, Pictured], tmp_path: Path) -> Path:
    (tmp_path / "report.html").write_text(evaluation_page(*large), encoding="utf-8")
    return tmp_path / "report.html"


def test_the_page_of_180_pipes_is_small(file: Path) -> None:
    assert file.stat().st_size <= 3_000_000


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings",
    [{}, {"color_scheme": "dark"}, {"viewport": {"width": 360, "height": 740}, "has_touch": True}],
    ids=["desk", "dark", "phone"],
)
def test_a_click_shows_numbers_failures_and_a_picture(
    settings: dict[str, Any], browser: Any, file: Path, large: tuple[Evaluation, Pictured]
) -> None:
    evaluation, pictured = large
    page, trouble = opened(browser, file, **settings)
    for number in (0, 1, 90, len(pictured.pipes) - 1):
        page.locator(f'.map button[data-pipes="{number}"]').click()
        text = page.locator("#details").inner_text()
        assert pictured.pipes[number].label in text
        failed = failed_in(number)
        assert f"{EACH - failed} of {EACH}" in text and "12.3 N" in text and "7.0 mm" in text
        assert (f"{failed} timeout" in text) == bool(failed)
        assert page.locator("#details svg .last .link").count() == len(ROBOT.links)
        assert page.locator("#details .some button").count() == min(failed, 24)
    assert page.locator(".map button").count() == len(evaluation.pipes)
    width = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert width <= 0, "nothing is wider than the screen"
    assert not trouble
    page.close()


@pytest.mark.slow
def test_every_failed_episode_has_its_place_and_picture(
    browser: Any, file: Path, large: tuple[Evaluation, Pictured]
) -> None:
    page, trouble = opened(browser, file)
    failures = large[1].failures
    assert page.locator("#failures tbody tr").count() == len(failures)
    for i in (0, len(failures) // 2, len(failures) - 1):
        page.locator("#failures tbody tr a").nth(i).click()
        pose = failures[i].pose
        assert pose is not None
        text = page.locator("#details").inner_text()
        assert f"episode\n{failures[i].number}" in text.replace("\t", "\n")
        assert f"{pose.side} corner {pose.corner}" in text
        assert f"episode {failures[i].number}: timeout after 5.9 s" in text
    counted = page.locator("#kinds tbody tr td:nth-child(2)").all_inner_texts()
    assert sum(map(int, counted)) == len(failures)
    assert not trouble
    page.close()


@pytest.mark.slow
def test_tables_sort_by_number_both_ways(browser: Any, file: Path) -> None:
    page, trouble = opened(browser, file)
    head, cells = page.locator("#pipes th button").nth(3), page.locator("#pipes tbody td:nth-child(4)")
    before = [int(text) for text in cells.all_inner_texts()]
    head.click()
    assert [int(text) for text in cells.all_inner_texts()] == sorted(before, reverse=True)
    head.click()
    assert [int(text) for text in cells.all_inner_texts()] == sorted(before)
    assert page.locator("#pipes th[aria-sort]").count() == 1
    assert not trouble
    page.close()


@pytest.mark.slow
def test_names_run_no_code(browser: Any, tmp_path: Path) -> None:
    evaluation, pictured = made(parse_pipes(["d=90,angle=60", "d=90,angle=90"]), EVIL_FILE)
    labelled = [Labelled(pipe, EVIL_FILE) for pipe in pictured.pipes]
    page_file = tmp_path / "report.html"
    page_file.write_text(
        evaluation_page(evaluation, pictured._replace(pipes=labelled, replayed={}, again=EVIL_FILE)), encoding="utf-8"
    )
    page, trouble = opened(browser, page_file)
    page.locator(".map button").first.click()
    assert EVIL_FILE in page.locator("#title").inner_text() and EVIL_FILE in page.locator("#details").inner_text()
    assert page.locator("img").count() == 0
    assert not trouble
    page.close()


@pytest.mark.slow
def test_it_prints(browser: Any, file: Path, tmp_path: Path) -> None:
    page, trouble = opened(browser, file)
    page.pdf(path=str(tmp_path / "report.pdf"))
    assert (tmp_path / "report.pdf").stat().st_size > 10_000
    assert not trouble
    page.close()


@pytest.mark.slow
def test_cells_show_what_geometry_says(browser: Any, tmp_path: Path) -> None:
    """A pipe each: all possible, some impossible, some undecided, none possible."""
    evaluation, pictured = made(parse_pipes([f"d=90,angle={angle}" for angle in (60, 70, 80, 90)]))
    chances = [(EACH, 0, 0), (EACH - 3, 3, 0), (EACH - 4, 0, 4), (0, EACH, 0)]
    records = []
    for record, (possible, impossible, undecided) in zip(evaluation.pipes, chances, strict=True):
        verdict = "impossible" if not possible else "passable"
        left = record.model_copy(update={"reach_successes": min(possible, record.successes)})
        records.append(left.model_copy(update={"passability": passability(left, impossible, undecided, verdict)}))
    certified = Evaluation.of(records, config=evaluation.config, robot="basic")
    page_file = tmp_path / "report.html"
    page_file.write_text(evaluation_page(certified, pictured), encoding="utf-8")
    page, trouble = opened(browser, page_file)
    classes = [page.locator(f'.map button[data-pipes="{n}"]').get_attribute("class") for n in range(4)]
    assert classes == ["", "impossible", "undecided", "hopeless impossible"]
    page.locator('.map button[data-pipes="3"]').click()
    text = page.locator("#details").inner_text()
    assert "impossible; with the allowed overlap impossible" in text and f"proven impossible\n{EACH}" in text
    assert page.locator("#pipes tbody td:nth-child(11)").all_inner_texts() == ["passable"] * 3 + ["impossible"]
    assert "Slanted lines" in page.locator("#note").inner_text()
    assert not trouble
    page.close()


def passability(record: PipeRecord, impossible: int, undecided: int, verdict: Any) -> PipePassability:
    """Geometry's word on a pipe."""
    possible = record.episodes - impossible - undecided
    return PipePassability(
        possible=possible,
        possible_with_overlap=0,
        undecided=undecided,
        impossible=impossible,
        gaps=possible - record.successes,
        contradictions=0,
        verdict=verdict,
        verdict_with_overlap=verdict,
        reason="",
    )


class Labelled:
    """A pipe with another label."""

    def __init__(self, pipe: Pipe, label: str) -> None:
        self._pipe, self.label = pipe, label

    def __getattr__(self, name: str) -> Any:
        return getattr(self._pipe, name)


def test_pages_name_no_address(file: Path) -> None:
    addresses = set(re.findall(r"https?://[\w./]+", file.read_text(encoding="utf-8")))
    assert addresses == {"http://www.w3.org/2000/svg"}, "only the name of SVG's namespace, which is not loaded"


def test_a_pipe_without_failures_has_no_list_of_them() -> None:
    evaluation, pictured = made([PipeCorner.of(90, 60), PipeCorner.of(90, 90)])
    assert [failure.pipe for failure in pictured.failures] == [0] * failed_in(0)
    assert '"failed":1,' in evaluation_page(evaluation, pictured)
