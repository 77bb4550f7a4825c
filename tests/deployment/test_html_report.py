"""The report of a mission in a real browser: outcome, timeline, stops, and the arm's picture at every moment."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from helpers.browser import EVIL, opened

from pipenav.deployment.html_report import MOST_TICKS, mission_page
from pipenav.deployment.telemetry import Recording, read_telemetry
from pipenav.deployment.trajectories import ArmPlacement
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot

ROBOT = load_robot("real-setup")
EARLIER = Path(__file__).parents[1] / "data" / "0.1" / "mission" / "telemetry.jsonl"
PLACEMENT = ArmPlacement(PipeCorner.of(130, 90), -0.4)


def state(load: int, decivolts: int, celsius: int) -> str:
    """The bytes of a servo in the middle of its travel."""
    return bytes([0, 2, 0, 0, load & 255, load >> 8, decivolts, celsius]).hex()


def made(ticks: int, stopped: str | None = None) -> Recording:
    """A mission as if it had been driven: all joints at 1, 2, ... hundredths times the tick."""
    earlier = read_telemetry(EARLIER)
    rows: list[dict[str, Any]] = []
    for n in range(ticks):
        q = [0.001 * n, *(0.01 * n / ticks for _ in ROBOT.joints[1:])]
        raw = {"states": [state(100 + n % 100, 118, 40 + i) for i in range(4)], "alarms": [0] * 4, "scan_mm": None}
        raw |= {"scan_sequence": None, "front_m": 0.2, "time": 0.1 * n, "problem": "", "late": 0, "seconds": {}}
        tick = {"tick": n, "stage": "locate" if n < ticks / 2 else "reach", "q": q, "qd": [0.0] * 4, "time": 0.1 * n}
        tick |= {"ranges": [0.15 + 0.01 * n / ticks] * ROBOT.laser.beams, "sent": [2 * x for x in q], "clamped": []}
        rows.append(tick | {"raw": raw, "warnings": [EVIL] if n == 1 else [], "target": [0.3, 0.1], "packet": ""})
    end: dict[str, Any] = {"end": "passed", "cause": None, "message": ""}
    if stopped is not None:
        rows.append(
            {"tick": ticks, "raw": {**rows[-1]["raw"], "states": [None] * 4, "time": 0.1 * ticks}, "stopped": stopped}
        )
        end = {"end": "stopped", "cause": stopped, "message": f"servo 2 is at 75 deg C {EVIL}"}
    return Recording(json.loads(json.dumps(earlier.header)), rows, end)


def page_file(folder: Path, recording: Recording, placement: ArmPlacement | None = PLACEMENT) -> Path:
    (folder / "telemetry.jsonl").write_text("")
    file = folder / "report.html"
    file.write_text(mission_page(recording, ROBOT, folder, placement), encoding="utf-8")
    return file


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings",
    [{}, {"color_scheme": "dark"}, {"viewport": {"width": 360, "height": 740}, "has_touch": True}],
    ids=["desk", "dark", "phone"],
)
def test_every_moment_shows_its_numbers_and_pose(settings: dict[str, Any], browser: Any, tmp_path: Path) -> None:
    page, trouble = opened(browser, page_file(tmp_path, made(60)), **settings)
    assert page.locator("#totals b").all_inner_texts()[:2] == ["passed", "5.9 s"]
    for n in (0, 17, 59):
        page.locator("#slide").fill(str(n))
        text = page.locator("#details").inner_text()
        stage = "locate" if n < 30 else "reach"
        assert f"{n / 10:.1f} s, {stage}" in text and f"{n:.1f} mm, set-point {2 * n:.1f} mm" in text
        assert f"{100 * (100 + n) / 1023:.0f} %, 40 deg C, 11.8 V" in text
        assert page.locator("#picture .now .link").count() == len(ROBOT.links)
        assert page.locator("#picture .hit").count() == ROBOT.laser.beams
        shown = page.locator("#charts .chart").first.locator(".value").all_inner_texts()
        assert shown == [f"{n:g}", f"{2 * n:g}"]
    assert page.locator("#picture .wall").count() == len(PLACEMENT.pipe.segments)
    assert page.locator("#charts .chart").count() == len(ROBOT.joints) + 4, "walls, load, temperature, supply"
    assert page.locator("#stages tbody tr").count() == 2
    width = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert width <= 0, "nothing is wider than the screen"
    assert not trouble
    page.close()


@pytest.mark.slow
def test_what_stopped_the_arm_stands_on_top_and_in_the_list(browser: Any, tmp_path: Path) -> None:
    page, trouble = opened(browser, page_file(tmp_path, made(20, "heat"), None))
    assert page.locator("#totals b").first.inner_text() == "stopped"
    assert "by heat" in page.locator("#totals").inner_text()
    assert "servo 2 is at 75 deg C" in page.locator("#why").inner_text() and EVIL in page.locator("#why").inner_text()
    rows = page.locator("#events tbody tr")
    assert [row.split("\t")[2:] for row in rows.all_inner_texts()] == [["warning", EVIL], ["stopped", "heat"]]
    assert page.locator("#charts .chart").first.locator(".mark").count() == 1
    rows.nth(1).locator("a").click()
    assert page.locator("#slide").input_value() == "20"
    assert page.locator("img").count() == 0 and not trouble
    page.pdf(path=str(tmp_path / "report.pdf"))
    page.close()


@pytest.mark.slow
def test_a_killed_mission_and_one_without_a_tick_have_pages(browser: Any, tmp_path: Path) -> None:
    recording = made(3)
    for each in (recording._replace(end=None), Recording(recording.header, [], None)):
        page, trouble = opened(browser, page_file(tmp_path, each))
        assert page.locator("#totals b").first.inner_text() == "cut short"
        assert not trouble
        page.close()


def test_the_earlier_mission_has_a_page() -> None:
    assert '"outcome":"passed"' in mission_page(read_telemetry(EARLIER), ROBOT, EARLIER.parent)


def test_long_missions_have_small_pages_with_every_stop(tmp_path: Path) -> None:
    recording = made(3 * MOST_TICKS, "bus")
    text = mission_page(recording, ROBOT, tmp_path, PLACEMENT)
    assert len(text) < 3_000_000
    assert '"kind":"stop","text":"bus"' in text and f'"ticks":{3 * MOST_TICKS + 1}' in text


def test_incomplete_ticks_are_gaps(tmp_path: Path) -> None:
    recording = made(5)
    held = {"tick": 2, "stage": "hold", "raw": {**recording.ticks[2]["raw"], "problem": "no scan"}}
    ticks = [held if n == 2 else tick for n, tick in enumerate(recording.ticks)]
    text = mission_page(recording._replace(ticks=ticks), ROBOT, tmp_path)
    data = json.loads(text.partition('type="application/json">')[2].partition("</script>")[0])
    assert data["joints"][0]["is"] == pytest.approx([0.0, 1.0, None, 3.0, 4.0])
    assert data["picture"]["poses"][2] is None and [one["name"] for one in data["stages"]] == ["locate", "reach"]
    assert [event["text"] for event in data["events"]] == [EVIL, "no scan"]
    assert data["time"] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
