"""Files that are refused: one sentence that names the line or the feature."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.network_files import Drawn, as_geojson, as_inp, as_pandapipes, as_pcf
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.networks import ENDINGS, DiameterField, ReadOptions, read_network_map
from pipenav.networks.text import MAX_NETWORK

DRAWN = Drawn({"N0": (0, 0, 0), "N1": (200, 0, 0), "N2": (400, 50, 1)}, [("N0", "N1", 100), ("N1", "N2", 80)])
BORE = ReadOptions(diameter=DiameterField("bore", "mm"), coordinates="m")
INP, JSON, PCF = as_inp(DRAWN, "LPS", False), as_pandapipes(DRAWN, True), as_pcf(DRAWN, False)
GEO = as_geojson(DRAWN)

CASES = {
    "a node named twice": ("net.inp", INP.replace(" N1\t", " N0\t", 1), r"line 6: node 'N0' is named twice"),
    "a pipe to nowhere": ("net.inp", INP.replace(" P1 N1 N2", " P1 N1 N9"), r"line \d+: node 'N9' is not described"),
    "a diameter of 0": ("net.inp", INP.replace(" 80.0 100", " 0 100"), r"line 10: line 'P1' has a diameter of 0 mm"),
    "NaN coordinates": ("net.inp", INP.replace(" N2 400", " N2 nan"), r"line \d+: x 'nan' is not a finite number"),
    "one place": ("net.inp", INP.replace(" N2 400 50", " N2 200 0").replace("\t1.0\t", "\t0.0\t"), "lie in one place"),
    "an unknown flow unit": ("net.inp", INP.replace("LPS", "XYZ"), r"line \d+: flow unit 'XYZ' is unknown"),
    "no section": ("net.inp", "hello\n", r"line 1: 'hello' stands before any \[SECTION\]"),
    "JSON as .inp": ("net.inp", JSON, r"line 1: .* stands before any"),
    "inp as .json": ("net.json", INP, "is not valid JSON"),
    "another JSON": ("net.json", "[1, 2]", "is no FeatureCollection"),
    "a table that is cut": ("net.json", JSON.replace("inner_diameter_mm", "x", 1).replace(", 100]", "]"), "longer or"),
    "no features": ("net.geojson", '{"features": []}', "has no lines in it"),
    "mixed units": (
        "net.geojson",
        GEO.replace('"bore": 80', '"bore": "4 in"'),
        r"feature 2: diameter '4 in' is not in",
    ),
    "a bore of 0": ("net.geojson", GEO.replace('"bore": 80', '"bore": 0'), r"feature 2: line '2' has a diameter of 0"),
    "NaN in JSON": ("net.geojson", GEO.replace("400", "NaN"), r"feature 2: x nan is not a finite number"),
    "one point": ("net.geojson", GEO.replace("[200, 0, 0], [400, 50, 1]", "[1, 2]"), "feature 2: a line needs two"),
    "no such field": ("net.geojson", GEO.replace("bore", "width"), "feature 1: there is no field 'bore'.*width"),
    "no columns": ("net.csv", "a,b\n1,2\n", "has no column wkt"),
    "a short row": ("net.csv", "x1,y1,x2,y2,bore\n0,0,1\n", "line 2: it has 3 columns"),
    "degrees": ("net.csv", "x1,y1,x2,y2,bore\n7.1,48.1,7.2,48.2,100\n", "look like degrees"),
    "no WKT": ("net.csv", "wkt,bore\nPOINT (1 2),3\n", "line 2: 'POINT .* is no LINESTRING"),
    "no units": ("net.pcf", PCF.replace("UNITS-CO-ORDS", "X"), "names no UNITS-CO-ORDS"),
    "another unit": ("net.pcf", PCF.replace("UNITS-BORE MM", "UNITS-BORE KM"), "UNITS-BORE 'KM' is unknown"),
    "a point of two": ("net.pcf", PCF.replace(" 0.0 100.0", "", 1), r"line 6: .* needs x, y and z"),
    "no table beside it": ("net.shp", "hello", r"has no net\.dbf beside it"),
    "an index twice": (
        "net.json",
        JSON.replace("[0, 1, 2]", "[0, 1, 1]", 1),
        "table junction, row 3: index '1' stands in row 2",
    ),
    "nothing": ("net.csv", " \n", "is empty"),
    "nothing, as JSON": ("net.geojson", "", "is empty"),
    "unknown": ("net.dxf", "0\nSECTION\n", r"of an unknown format: give a file that ends in \.inp"),
}


@pytest.mark.parametrize("case", CASES)
def test_one_sentence_with_the_place(case: str, tmp_path: Path) -> None:
    name, text, says = CASES[case]
    (tmp_path / name).write_text(text)
    options = BORE._replace(coordinates="auto") if case == "degrees" else BORE
    with pytest.raises(PipenavError, match=says) as error:
        read_network_map(tmp_path / name, options)
    assert "\n" not in str(error.value) and str(error.value).endswith(".")


@pytest.mark.parametrize("ending", [ending for ending in ENDINGS if ending != ".shp"])
def test_a_file_of_200_mb_is_refused_unread(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"net{ending}"
    with path.open("wb") as file:
        file.truncate(200 << 20)
    with pytest.raises(PipenavError, match=f"larger than {MAX_NETWORK >> 20} MiB"):
        read_network_map(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
@given(
    st.sampled_from([("net.inp", INP), ("net.json", JSON), ("net.geojson", GEO), ("net.pcf", PCF)]),
    st.floats(0, 1),
    st.text(max_size=4),
    st.integers(0, 30),
)
def test_damage_is_read_or_refused_in_words(
    tmp_path: Path, whole: tuple[str, str], share: float, put: str, cut: int
) -> None:
    """A file in which something was replaced gives a map or a sentence, never another error."""
    name, text = whole
    at = int(share * len(text))
    (tmp_path / name).write_text(text[:at] + put + text[at + cut :], encoding="utf-8", errors="replace")
    try:
        read = read_network_map(tmp_path / name, BORE)
    except PipenavError as error:
        assert str(error)
    else:
        assert len(read.ends) == len(read.diameter) == len(read.line_names) > 0


def test_numbers_that_json_spells_as_words(tmp_path: Path) -> None:
    """A diameter as a text with its unit is the same number."""
    written = json.loads(GEO)
    written["features"][0]["properties"]["bore"] = "100 mm"
    written["features"][1]["properties"]["bore"] = None
    (tmp_path / "net.geojson").write_text(json.dumps(written))
    read = read_network_map(tmp_path / "net.geojson", BORE)
    assert read.diameter[0] == pytest.approx(0.1) and read.diameter[1] != read.diameter[1]
