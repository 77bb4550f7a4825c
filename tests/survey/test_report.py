"""The report in a real browser: a click on a fitting shows its numbers, on a phone and in the dark too."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.browser import opened
from helpers.surveys import AnsweredFindings, random_tree

from pipenav.survey.html_report import html_report
from pipenav.survey.passage import Tether
from pipenav.survey.record import Subject, survey_record
from pipenav.survey.sensitivity import sensitivities
from pipenav.survey.survey import SurveyConfig, survey

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A survey of a small tree."""
    network = random_tree(5, 30)
    findings = AnsweredFindings(tmp_path_factory.mktemp("cache"), lambda name: 2 if "straight" in name else 20)
    result = survey(network, findings, SurveyConfig(tether=Tether(cable=150.0)))
    return survey_record(result, Subject("tree <b>.csv", findings.trials, sensitivities(result, network, findings)))


@pytest.fixture
def page_file(record: dict[str, Any], tmp_path: Path) -> Path:
    path = tmp_path / "report.html"
    path.write_text("".join(html_report(record)), encoding="utf-8")
    return path


def click_on(page: Any, feature: int) -> str:
    """Text of the details after a click on a feature's place on the map."""
    page.evaluate(f"survey.centre({feature})")
    x, y = page.evaluate(f"survey.toScreen({feature})")
    page.locator("#canvas").click(position={"x": x, "y": y})
    return str(page.locator("#details").inner_text())


@pytest.mark.parametrize(
    "settings",
    [{}, {"color_scheme": "dark"}, {"viewport": {"width": 360, "height": 740}, "has_touch": True}],
    ids=["desk", "dark", "phone"],
)
def test_a_click_shows_a_features_numbers(
    settings: dict[str, Any], browser: Any, page_file: Path, record: dict[str, Any]
) -> None:
    page, trouble = opened(browser, page_file, **settings)
    bends = [feature for feature in record["features"] if feature["kind"] == "bend"]
    for bend in bends[:3]:
        text = click_on(page, bend["id"])
        assert f"bend {bend['name']}" in text
        assert f"{bend['angle_deg']:.1f} deg, within {bend['angle_error_deg']:.1f} deg" in text
        assert bend["verdict"] in text and "100 mm" in text and "derived" in text and "mitre (assumed)" in text
    assert f"{record['totals_m']['seen'] / 1000:.2f} km" in page.locator("#totals").inner_text()
    width = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert width <= 0, "nothing is wider than the screen"
    assert not trouble
    page.close()


def test_the_map_can_be_moved_and_zoomed(browser: Any, page_file: Path, record: dict[str, Any]) -> None:
    page, trouble = opened(browser, page_file)
    before = page.evaluate("survey.toScreen(0)")
    box = page.locator("#canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y - 25, steps=4)
    page.mouse.up()
    after = page.evaluate("survey.toScreen(0)")
    assert after == pytest.approx([before[0] + 40, before[1] - 25], abs=1)
    spread = page.evaluate("survey.toScreen(1)[0] - survey.toScreen(0)[0]")
    page.mouse.wheel(0, -400)
    wider = f"Math.abs(survey.toScreen(1)[0] - survey.toScreen(0)[0]) > {abs(spread) * 1.2}"
    for _ in range(250):  # the page's own policy forbids what waits in the browser
        if page.evaluate(wider):
            break
        page.wait_for_timeout(20)
    assert page.evaluate(wider)
    page.locator("#blockers a").first.click()
    blocker = record["blockers"][0]["feature"]
    assert record["features"][blocker]["name"] in page.locator("#details h3").inner_text()
    assert not trouble
    page.close()


def test_it_prints(browser: Any, page_file: Path, tmp_path: Path) -> None:
    page, trouble = opened(browser, page_file)
    page.pdf(path=str(tmp_path / "report.pdf"))
    assert (tmp_path / "report.pdf").stat().st_size > 10_000
    assert not trouble
    page.close()
