"""The report of a training in a real browser: values under the cursor, checks to click, settings, and no network."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.browser import EVIL, opened
from hypothesis import given
from hypothesis import strategies as st

from pipenav.errors import ConfigError
from pipenav.learning.checks import MOST_CHECKS, Checks, read_checks, write_checks
from pipenav.learning.config import TrainConfig, load_config
from pipenav.learning.html_report import MOST_POINTS, training_page
from pipenav.learning.progress import PROGRESS_COLUMNS
from pipenav.learning.training_folder import TrainingFolder
from pipenav.pipes import parse_pipes
from pipenav.tasks.outcome import Outcome

PIPES = parse_pipes(["d=90,angle=60", "d=90,angle=90", "d=110,angle=60,turn=right"])
EACH = 4


def outcomes(*successes: int) -> Any:
    """Outcomes of a check in which so many episodes of each pipe succeeded."""
    rows = [[Outcome.REACHED] * n + [Outcome.TIMEOUT] * (EACH - n) for n in successes]
    return np.array(rows, np.int8).ravel()


def some_checks() -> Checks:
    checks = Checks(schema=1)
    for steps, found in ((1000, (0, 1, 2)), (2000, (4, 2, 3)), (3000, (4, 4, 1))):
        checks = checks.with_check(PIPES, outcomes(*found), steps=steps, seconds=steps / 100, stage=1)
    return checks


def made(path: Path, rows: int, checks: Checks, name: str = "mine") -> tuple[TrainingFolder, TrainConfig]:
    """A training folder as if it had been trained, with so many updates of 10 steps."""
    path = path / name
    path.mkdir()
    folder, config = TrainingFolder(path), load_config(options={"steps": rows * 10, "description": EVIL})
    with folder.progress.open("w", newline="") as file:
        writer = csv.DictWriter(file, PROGRESS_COLUMNS)
        writer.writeheader()
        for row in range(rows):
            cells = dict.fromkeys(PROGRESS_COLUMNS, "")
            values = {"steps": 10 * row + 10, "seconds": row, "reward": row / rows, "success": 0.25, "value_loss": 3.5}
            writer.writerow(cells | values)
    folder.command.write_text("pipenav train\n")
    folder.best.write_bytes(b"")
    if checks.checks:
        write_checks(folder.checks, checks)
    return folder, config


@pytest.fixture
def folder(tmp_path: Path) -> TrainingFolder:
    folder, config = made(tmp_path, 300, some_checks())
    folder.page.write_text(training_page(folder, config), encoding="utf-8")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings",
    [{}, {"color_scheme": "dark"}, {"viewport": {"width": 360, "height": 740}, "has_touch": True}],
    ids=["desk", "dark", "phone"],
)
def test_the_page_reads_and_clicks(settings: dict[str, Any], browser: Any, folder: TrainingFolder) -> None:
    page, trouble = opened(browser, folder.page, **settings)
    assert page.locator("#totals b").all_inner_texts() == ["75.0 %", "3,000", "4 min 59 s"]
    page.locator("#slide").fill("1")
    assert "after 2,000 steps" in page.locator("#which").inner_text()
    for place, successes in enumerate((4, 2, 3)):
        cell = page.locator(f'.map button[data-pipes="{place}"]')
        cell.click()
        said = page.locator("#details").inner_text()
        assert PIPES[place].label in said and f"{successes} of {EACH}" in said
        assert (f"{EACH - successes} timeout" in said) == (successes < EACH)
        assert page.locator("#details .chart").count() == 1
    width = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert width <= 0, "nothing is wider than the screen"
    assert not trouble
    page.close()


@pytest.mark.slow
def test_the_cursor_of_all_curves_shows_the_values_at_its_step(browser: Any, folder: TrainingFolder) -> None:
    page, trouble = opened(browser, folder.page)
    charts = page.locator("#curves .chart")
    titles = charts.locator("figcaption").all_inner_texts()
    assert [title.strip() for title in titles] == ["Success", "Mean reward of a step", "Loss of the value function"]
    page.locator("#curves svg").first.focus()
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
    assert page.locator("#curves .when").all_inner_texts() == ["at 2,970 steps"] * 3
    assert page.locator("#curves .value").all_inner_texts() == ["25.0", "75.0 (46.8–91.1)", "0.9867", "3.5"]
    page.locator("#curves svg").nth(1).hover(position={"x": 300, "y": 60})
    step = page.evaluate("training.data.curves.steps")
    said = page.locator("#curves .when").first.inner_text()
    at = int(said.removeprefix("at ").removesuffix(" steps").replace(",", ""))
    shown = float(page.locator("#curves .value").nth(2).inner_text())
    assert at in step and shown == pytest.approx((at - 10) / 3000, abs=1e-4)
    assert not trouble
    page.close()


@pytest.mark.slow
def test_names_run_no_code_and_it_prints(browser: Any, folder: TrainingFolder, tmp_path: Path) -> None:
    page, trouble = opened(browser, folder.page)
    assert EVIL in page.locator("#subject").inner_text()
    assert page.locator("#files a").all_inner_texts() == ["best.zip", "progress.csv", "checks.json"]
    assert page.locator("#files a").first.get_attribute("href") == "best.zip"
    page.pdf(path=str(tmp_path / "report.pdf"))
    assert page.locator("img").count() == 0 and not trouble
    page.close()


@pytest.mark.slow
def test_a_training_without_a_check_has_a_page(browser: Any, tmp_path: Path) -> None:
    folder, config = made(tmp_path, 1, Checks(schema=1))
    folder.page.write_text(training_page(folder, config.model_copy(update={"steps": 4000})), encoding="utf-8")
    page, trouble = opened(browser, folder.page)
    assert page.locator("#checked").count() == 0
    assert "no check has been made" in page.locator("#totals").inner_text()
    assert "pipenav train --resume" in page.locator("#unfinished").inner_text()
    assert not trouble
    page.close()


@pytest.mark.parametrize("rows", [0, 1, MOST_POINTS, MOST_POINTS + 1, 20 * MOST_POINTS + 7])
def test_long_trainings_have_small_pages(rows: int, tmp_path: Path) -> None:
    folder, config = made(tmp_path, max(rows, 1), some_checks())
    if not rows:
        folder.progress.write_text(",".join(PROGRESS_COLUMNS) + "\n")
    assert len(training_page(folder, config)) < 200_000


@given(st.lists(st.tuples(st.integers(1, 50), st.integers(0, EACH)), max_size=30))
def test_checks_come_back_and_stay_in_order(given: list[tuple[int, int]]) -> None:
    """A training that lost its last steps repeats a check: the newer one counts, and those after it are gone."""
    checks = Checks(schema=1)
    for steps, successes in given:
        checks = checks.with_check(PIPES[:1], outcomes(successes), steps=steps, seconds=1.0, stage=1)
        assert (checks.checks[-1].steps, checks.checks[-1].success) == (steps, successes / EACH)
    steps = [check.steps for check in checks.checks]
    assert steps == sorted(set(steps)) and len(checks.pipe_sets) <= 1
    assert Checks.model_validate_json(checks.model_dump_json(by_alias=True)) == checks


def test_only_the_newest_checks_are_kept(tmp_path: Path) -> None:
    checks = Checks(schema=1)
    for steps in range(MOST_CHECKS + 3):
        checks = checks.with_check(PIPES[:1], outcomes(1), steps=steps, seconds=1.0, stage=1)
    assert len(checks.checks) == MOST_CHECKS and checks.checks[0].steps == 3
    write_checks(tmp_path / "checks.json", checks)
    assert read_checks(tmp_path / "checks.json") == checks
    assert read_checks(tmp_path / "none.json") == Checks(schema=1)


@pytest.mark.parametrize("broken", ["", "[]", '{"schema": 2}', '{"schema": 1, "checks": [{"steps": -1}]}'])
def test_damaged_checks_are_refused_in_a_sentence(broken: str, tmp_path: Path) -> None:
    (tmp_path / "checks.json").write_text(broken)
    with pytest.raises(ConfigError, match=r"checks\.json"):
        read_checks(tmp_path / "checks.json")


def test_a_check_of_other_pipes_is_refused(tmp_path: Path) -> None:
    text = some_checks().model_dump_json(by_alias=True)
    (tmp_path / "checks.json").write_text(text.replace('"pipes":0', '"pipes":1', 1))
    with pytest.raises(ConfigError, match="pipes"):
        read_checks(tmp_path / "checks.json")
