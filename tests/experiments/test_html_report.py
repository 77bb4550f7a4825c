"""The report of experiments in a real browser: tables with intervals beside the thesis's figures, curves over seeds."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest
from helpers.browser import opened
from helpers.thesis_results import write_thesis_results

from pipenav.evaluation.interval import wilson
from pipenav.experiments.definition import agents_of
from pipenav.experiments.figures import ITERATION
from pipenav.experiments.plan import TRAINED_FILE, ExperimentPlan
from pipenav.experiments.report import write_report, write_unfinished_report
from pipenav.experiments.tables import pooled_counts, results
from pipenav.learning.progress import PROGRESS_COLUMNS
from pipenav.learning.training_folder import TrainingFolder

pytestmark = pytest.mark.slow

SHOWN = ("c", "e", "f")
ITERATIONS = 20


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> ExperimentPlan:
    """Results that hold the thesis's own figures, with trainings whose success is the seed's share of 80 percent."""
    plan = write_thesis_results(tmp_path_factory.mktemp("experiments"))._replace(experiments=SHOWN)
    for agent in agents_of(list(plan.experiments)):
        for seed in plan.seeds:
            folder = TrainingFolder(plan.training_folder(agent, seed))
            folder.path.mkdir(parents=True, exist_ok=True)
            (folder.path / TRAINED_FILE).write_text(json.dumps({"seconds": 1, "steps": ITERATION * ITERATIONS}))
            with folder.progress.open("w", newline="") as file:
                writer = csv.DictWriter(file, PROGRESS_COLUMNS, restval="")
                writer.writeheader()
                for i in range(ITERATIONS):
                    steps = ITERATION * (i + 1)
                    row = {"steps": steps, "seconds": i, "success": 0.8 * (seed + 1) / 2, "min_range_m": 0.05}
                    writer.writerow(row)
    write_report(plan)
    return plan


@pytest.mark.parametrize(
    "settings",
    [{}, {"color_scheme": "dark"}, {"viewport": {"width": 360, "height": 740}, "has_touch": True}],
    ids=["desk", "dark", "phone"],
)
def test_every_cell_has_our_figure_its_interval_and_the_thesiss(
    settings: dict[str, Any], browser: Any, plan: ExperimentPlan
) -> None:
    page, trouble = opened(browser, plan.out / "report.html", **settings)
    for name in SHOWN:
        rows = page.locator(f"#table-{name} tbody tr")
        lines = [(result, line) for result in results(plan, name) for line in result.lines]
        assert rows.count() == len(lines)
        for i, (result, line) in enumerate(lines):
            for cell, (diameter, spread) in zip(rows.nth(i).locator(".cell").all(), line.ours.items(), strict=True):
                text = cell.inner_text()
                low, high = wilson(*pooled_counts(result.evaluations, line.stage, diameter))
                assert text.startswith(spread.text) and 100 * low <= spread.mean + 1e-9 <= 100 * high + 1e-9
                if diameter in line.thesis:
                    assert f"thesis {line.thesis[diameter]:g}" in text
    width = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert width <= 0, "nothing is wider than the screen"
    assert not trouble
    page.close()


def test_curves_show_mean_and_range_over_the_seeds(browser: Any, plan: ExperimentPlan) -> None:
    page, trouble = opened(browser, plan.out / "report.html")
    part = page.locator("#part-c")
    part.locator(".chart svg").first.focus()
    page.keyboard.press("ArrowLeft")
    assert part.locator(".when").first.inner_text() == f"at iteration {ITERATIONS - 1}"
    assert part.locator(".chart").first.locator(".value").first.inner_text() == "60 (40–80)"
    heads = page.locator("#part-e h3").all_inner_texts()
    assert heads == ["Over the corner angle: target located, %"], "it trains nothing"
    assert not trouble
    page.close()


def test_tables_sort_and_pictures_are_inside(browser: Any, plan: ExperimentPlan) -> None:
    page, trouble = opened(browser, plan.out / "report.html")
    page.locator("#table-c th button").nth(2).click()
    shown = [float(text.split()[0]) for text in page.locator("#table-c td:nth-child(3) .cell").all_inner_texts()]
    assert shown == sorted(shown, reverse=True)
    page.locator("#part-c summary").first.click()
    assert page.locator("#part-c img").count() == 2
    images = "[...document.querySelectorAll('#part-c img')]"
    page.evaluate(f"Promise.all({images}.map(i => i.decode()))")
    assert page.evaluate(f"{images}.every(i => i.naturalWidth > 300)")
    assert not trouble
    page.close()


def test_it_is_small_and_prints(browser: Any, plan: ExperimentPlan, tmp_path: Path) -> None:
    assert (plan.out / "report.html").stat().st_size <= 3_000_000
    page, trouble = opened(browser, plan.out / "report.html")
    page.pdf(path=str(tmp_path / "report.pdf"))
    assert not trouble
    page.close()


def test_a_stop_leaves_the_page_of_what_is_complete(browser: Any, plan: ExperimentPlan, tmp_path: Path) -> None:
    begun = plan._replace(out=tmp_path)
    assert write_unfinished_report(begun) == [] and not (tmp_path / "report.html").exists()
    for stage in plan.out.glob("stages/*-locate-*"):
        (tmp_path / "stages").mkdir(exist_ok=True)
        (tmp_path / "stages" / stage.name).symlink_to(stage)
    assert write_unfinished_report(begun) == ["e"]
    page, trouble = opened(browser, tmp_path / "report.html")
    assert page.locator("section").count() == 1 and page.locator("#table-e tbody tr").count() == 2
    assert not trouble
    page.close()
