"""`pipenav survey` as people type it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.documented import pipenav
from helpers.network_files import Drawn, as_geojson
from helpers.surveys import answer_evaluations

from pipenav.survey.folder import FILES

DRAWN = Drawn(
    {"N0": (0, 0, 0), "N1": (90, 70, 0), "N2": (150, 70, 0), "N3": (230, 70, 0), "N4": (150, 160, 0)},
    [("N0", "N1", 100), ("N1", "N2", 100), ("N2", "N3", 100), ("N2", "N4", 100)],
)


@pytest.fixture
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a map in it; caches go into it too, and trials are answered."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    answer_evaluations(monkeypatch)
    (tmp_path / "town.geojson").write_text(as_geojson(DRAWN))
    return tmp_path


MAP = ("survey", "town.geojson", "--diameter", "bore:mm", "--coordinates", "m")


def test_a_survey_writes_its_folder(in_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert pipenav(*MAP, "--routes", "routes") == 0
    assert {path.name for path in (in_folder / "runs/survey-town").iterdir()} == set(FILES)
    record = json.loads((in_folder / "runs/survey-town/survey.json").read_text())
    assert record["totals_m"]["seen"] == pytest.approx(record["totals_m"]["mains"])
    said = capsys.readouterr().out
    assert "inspectable" in said and "survey folder" in said
    for route in sorted((in_folder / "routes").glob("*.toml")):
        assert pipenav("gen-pipe", "--route", str(route), "--out", "pipes") == 0


def test_a_check_simulates_and_writes_nothing(in_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert pipenav(*MAP, "--check") == 0
    said = capsys.readouterr().out
    assert "GeoJSON: 4 lines, 5 nodes" in said and "1 bend, 3 ends, 1 tee" in said
    assert not (in_folder / "runs").exists() and not (in_folder / "cache").exists()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--from", "N9"), "unknown node 'N9'"),
        (("--from", ","), "--from names no node"),
        (("--from", "node 1", "--entries", "3"), "leave one of them out"),
        (("--entries", "0"), "--entries 0 is neither"),
        (("--entries", "200%"), "--entries 200% is neither"),
        (("--bends", "1.5"), "--bends 1.5 is no radius"),
        (("--policy", "arm"), "passes no pipe as a whole"),
        (("--check", "--routes", "x"), "--routes would be ignored"),
        (("--routes", "town.geojson"), "cannot use the folder town.geojson: it is a file"),
    ],
)
def test_wrong_options_leave_nothing(
    words: tuple[str, ...], says: str, in_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipenav(*MAP, *words) == 1
    assert says in capsys.readouterr().err
    assert sorted(path.name for path in in_folder.iterdir()) == ["town.geojson"]


def test_a_map_without_diameters_is_refused(in_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for more in ((), ("--check",)):
        assert pipenav("survey", "town.geojson", "--coordinates", "m", *more) == 1
        assert "give --diameter FIELD:mm" in capsys.readouterr().err
    assert not (in_folder / "runs").exists()


def test_a_sketch_is_surveyed_as_unknown(in_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Stated lengths that have nothing to do with the coordinates: no fitting is judged by its angle."""
    lines = ["[JUNCTIONS]", *(f"N{i} 0" for i in range(6)), "[PIPES]"]
    lines += [f"P{i} N{i} N{i + 1} {10 * 4**i} 100" for i in range(5)]
    lines += ["[OPTIONS]", "Units LPS", "[COORDINATES]", *(f"N{i} {50 * i} {30 * (i % 2)}" for i in range(6))]
    (in_folder / "sketch.inp").write_text("\n".join(lines))
    assert pipenav("survey", "sketch.inp", "--check") == 0
    assert "sketch" in capsys.readouterr().out
    assert pipenav("survey", "sketch.inp", "--from", "N0", "--untethered") == 0
    record = json.loads((in_folder / "runs/survey-sketch/survey.json").read_text())
    assert {feature["verdict"] for feature in record["features"] if feature["kind"] == "bend"} == {"unknown"}
    assert record["totals_m"]["blocked"] == pytest.approx(0, abs=1e-6)
