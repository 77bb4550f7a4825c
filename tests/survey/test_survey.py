"""Whole surveys: lengths add up, sensitivities are what a survey with that number gives, records are whole."""

from __future__ import annotations

import csv
import io
import json
import re
from pathlib import Path

import pytest
from helpers.documented import pipenav
from helpers.surveys import AnsweredFindings, map_of, random_tree
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.networks.model import NetworkMap
from pipenav.pipes.route_file import read_route
from pipenav.survey.entries import Goal
from pipenav.survey.features import Geometry
from pipenav.survey.folder import FILES, write_survey
from pipenav.survey.html_report import html_report
from pipenav.survey.passage import Tether
from pipenav.survey.record import Subject, survey_record
from pipenav.survey.routes import far_routes
from pipenav.survey.sensitivity import sensitivities
from pipenav.survey.survey import Survey, SurveyConfig, survey
from pipenav.survey.tables import features_csv, map_geojson

SOME = settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
FROM_FIRST = SurveyConfig(entries=("N0",), tether=Tether(cable=200.0))


def rule(name: str) -> int:
    """A robot that is stopped by sharp bends, passes into branches, and seldom past them."""
    return 2 if "straight" in name or name.startswith("bend-d100-a9") else 20


def surveyed(network: NetworkMap, config: SurveyConfig, folder: Path) -> tuple[Survey, AnsweredFindings]:
    findings = AnsweredFindings(folder, rule)
    return survey(network, findings, config), findings


@SOME
@given(st.integers(0, 10_000), st.integers(3, 25))
def test_lengths_add_up(tmp_path: Path, seed: int, nodes: int) -> None:
    network = random_tree(seed, nodes)
    result, _ = surveyed(network, FROM_FIRST, tmp_path)
    totals = result.totals
    assert totals.mains == pytest.approx(float(network.length.sum()))
    assert totals.seen + totals.unknown + totals.blocked == pytest.approx(totals.mains)
    assert min(totals) >= -1e-6
    assert all(more >= totals.seen - 1e-6 for more in result.without.values()), "without a limit one sees no less"
    assert all(blocker.behind <= totals.mains - totals.seen + 1e-6 for blocker in result.blockers)


@SOME
@given(st.integers(0, 10_000))
def test_a_changed_number_moves_the_result_as_the_table_says(tmp_path: Path, seed: int) -> None:
    """Each row is what a whole survey with that number gives."""
    network = random_tree(seed, 20)
    result, findings = surveyed(network, FROM_FIRST, tmp_path)
    for row in sensitivities(result, network, findings):
        assert row.seen == pytest.approx(result.totals.seen)
        for value, seen in ((row.low, row.seen_low), (row.high, row.seen_high)):
            config = FROM_FIRST
            if row.what == "accuracy":
                config = config._replace(geometry=Geometry(accuracy=value))
            elif row.what in Tether._fields:
                config = config._replace(tether=config.tether._replace(**{row.what: value}))
            else:
                continue
            assert surveyed(network, config, tmp_path)[0].totals.seen == pytest.approx(seen)


@SOME
@given(st.integers(0, 10_000), st.integers(3, 25))
def test_records_are_whole(tmp_path: Path, seed: int, nodes: int) -> None:
    network = random_tree(seed, nodes)
    result, findings = surveyed(network, SurveyConfig(goal=Goal(share=0.8)), tmp_path)
    record = survey_record(result, Subject("net.csv", findings.trials, sensitivities(result, network, findings)))
    assert json.loads(json.dumps(record, allow_nan=False)) == json.loads(json.dumps(record))
    assert sum(segment["seen_m"] for segment in record["segments"]) == pytest.approx(result.totals.seen, abs=0.1)
    rows = list(csv.DictReader(io.StringIO(features_csv(record))))
    assert len(rows) == len(record["features"])
    reached = [row for row in rows if row["distance_m"]]
    for entry in {row["entry"] for row in reached}:
        distances = [float(row["distance_m"]) for row in reached if row["entry"] == entry]
        assert distances == sorted(distances)
        assert max(distances) <= result.config.tether.cable + 1e-6
    drawn = json.loads("".join(map_geojson(record)))["features"]
    assert sum(feature["geometry"]["type"] == "LineString" for feature in drawn) == len(record["segments"])


def test_routes_to_far_ends_can_be_read(tmp_path: Path) -> None:
    """A zigzag: its only far end is reached by a route with all its corners, straights shortened."""
    points = [(60.0 * i, 40.0 * (i % 2), 0.0) for i in range(6)]
    network = map_of(points, list(zip(range(5), range(1, 6), strict=True)))
    result = survey(
        network, AnsweredFindings(tmp_path), SurveyConfig(entries=("N0",), tether=Tether(cable=1e4, pull=1e4))
    )
    (made,) = far_routes(result)
    assert made.name == "N0-to-N5.toml" and not made.problem
    (tmp_path / made.name).write_text(made.text)
    route = read_route(tmp_path / made.name)
    assert len(route.corners) == 4
    assert [corner.turn for corner in route.corners] in (["right", "left"] * 2, ["left", "right"] * 2)
    assert max(route.straights) < 13
    written = [float(line.split(" = ")[1]) for line in made.text.splitlines() if re.search("_(deg|mm) = ", line)]
    assert written and all(value == round(value, 1) for value in written)


@pytest.mark.slow
def test_routes_are_taken_by_gen_pipe_eval_and_view(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two corners of a map: the file is made into a pipe, evaluated in, and drawn."""
    monkeypatch.chdir(tmp_path)
    network = map_of([(0.0, 0.0, 0.0), (9.0, 0.0, 0.0), (16.0, 3.0, 0.1), (25.0, 3.0, 0.2)], [(0, 1), (1, 2), (2, 3)])
    result = survey(network, AnsweredFindings(tmp_path), SurveyConfig(entries=("N0",), tether=Tether().lifted))
    (made,) = far_routes(result)
    Path(made.name).write_text(made.text)
    for command in (
        f"gen-pipe --route {made.name}",
        f"eval --policy pirate --pipes {made.name} --episodes 1 --out evaluation",
        f"view --policy pirate --pipes {made.name} --out view.png",
    ):
        assert pipenav(*command.split()) == 0
    assert json.loads(Path("evaluation/eval.json").read_text())["success"] == 1.0
    assert Path(made.name).with_suffix("").joinpath("pipe.urdf").is_file() and Path("view.png").is_file()


def test_names_of_a_strangers_file_cannot_leave_the_page(tmp_path: Path) -> None:
    network = random_tree(1, 4)
    result, findings = surveyed(network, FROM_FIRST, tmp_path)
    record = survey_record(result, Subject("</script><script>alert(1)</script>", findings.trials, []))
    page = "".join(html_report(record))
    assert "alert(1)</script>" not in page
    harmless = "".join(html_report(survey_record(result, Subject("a file", findings.trials, []))))
    assert page.count("</script>") == harmless.count("</script>")
    assert not [
        word for word in ("http://", "https://", "//cdn") if word in page.replace("http://www.w3.org/2000/svg", "")
    ]


def test_all_files_are_written(tmp_path: Path) -> None:
    result, findings = surveyed(random_tree(2, 8), FROM_FIRST, tmp_path / "cache")
    out = tmp_path / "out"
    out.mkdir()
    write_survey(out, survey_record(result, Subject("net", findings.trials, [])))
    assert {path.name for path in out.iterdir()} == set(FILES)


def test_an_unknown_entry_is_named(tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match="unknown node 'N99'"):
        surveyed(random_tree(1, 4), SurveyConfig(entries=("N99",)), tmp_path)
