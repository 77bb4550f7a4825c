"""Networks written by the rules of a format are what is read: pipes, bores, lengths, places, and which pipes meet."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.network_files import (
    Drawn,
    as_csv,
    as_geojson,
    as_inp,
    as_pandapipes,
    as_pcf,
    drawn_networks,
    write_shapefile,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipenav.networks import DiameterField, NetworkMap, Origin, ReadOptions, read_network_map

IN_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
BORE = ReadOptions(diameter=DiameterField("bore", "mm"))


def same(read: NetworkMap, drawn: Drawn, heights: bool = True) -> None:
    """Check that a map has exactly the pipes that were drawn, whatever its nodes are called."""
    axes = 3 if heights else 2

    def key(places: list[tuple[float, ...]], mm: float) -> tuple[object, ...]:
        return (*sorted(tuple(round(value, 3) + 0.0 for value in place[:axes]) for place in places), round(mm, 4))

    expected = [key([drawn.nodes[start], drawn.nodes[end]], mm) for start, end, mm in drawn.pipes]
    found = [
        key([tuple(read.position[node].tolist()) for node in ends], diameter * 1e3)
        for ends, diameter in zip(read.ends.tolist(), read.diameter.tolist(), strict=True)
    ]
    assert sorted(found) == sorted(expected)
    assert len(read.position) == len(drawn.nodes)
    assert (read.diameter_origin == Origin.STATED).all()
    assert read.length.sum() == pytest.approx(sum(drawn.length(i) for i in range(len(drawn.pipes))), rel=1e-9)


@IN_FOLDER
@given(drawn_networks(), st.sampled_from([("LPS", False), ("CMH", False), ("GPM", True), ("AFD", True)]))
def test_epanet(tmp_path: Path, drawn: Drawn, units: tuple[str, bool]) -> None:
    (tmp_path / "net.inp").write_text(as_inp(drawn, *units))
    read = read_network_map(tmp_path / "net.inp")
    spread = max(
        drawn.length(i) / math.dist(drawn.nodes[a][:2], drawn.nodes[b][:2]) for i, (a, b, _) in enumerate(drawn.pipes)
    )
    assert spread < 1.01, "stated lengths are nearly those in plan, so that nothing is scaled"
    same(read, drawn)
    assert (read.length_origin == Origin.STATED).all()


@IN_FOLDER
@given(drawn_networks(), st.booleans())
def test_pandapipes(tmp_path: Path, drawn: Drawn, newer: bool) -> None:
    (tmp_path / "net.json").write_text(as_pandapipes(drawn, newer))
    same(read_network_map(tmp_path / "net.json"), drawn)


@IN_FOLDER
@given(drawn_networks())
def test_geojson(tmp_path: Path, drawn: Drawn) -> None:
    (tmp_path / "net.geojson").write_text(as_geojson(drawn))
    read = read_network_map(tmp_path / "net.geojson", BORE._replace(coordinates="m"))
    same(read, drawn)
    assert (read.length_origin == Origin.DERIVED).all()


@IN_FOLDER
@given(drawn_networks(), st.booleans())
def test_csv(tmp_path: Path, drawn: Drawn, wkt: bool) -> None:
    (tmp_path / "net.csv").write_text(as_csv(drawn, wkt))
    same(read_network_map(tmp_path / "net.csv", BORE._replace(coordinates="m")), drawn)


@IN_FOLDER
@given(drawn_networks())
def test_shapefile(tmp_path: Path, drawn: Drawn) -> None:
    pytest.importorskip("shapefile")
    write_shapefile(drawn, tmp_path / "net.shp")
    options = ReadOptions(diameter=DiameterField("BORE", "mm"), coordinates="m")
    same(read_network_map(tmp_path / "net.shp", options), drawn)


@IN_FOLDER
@given(drawn_networks(), st.booleans())
def test_pcf(tmp_path: Path, drawn: Drawn, inches: bool) -> None:
    (tmp_path / "net.pcf").write_text(as_pcf(drawn, inches))
    read = read_network_map(tmp_path / "net.pcf")
    same(read, drawn)
    assert read.fabricated


@given(st.floats(20, 160), st.floats(0.8, 5.0), st.floats(0.0, 2 * math.pi))
def test_elbows_of_pcf_have_the_radius_of_their_points(turn: float, bores: float, around: float) -> None:
    """An arc of radius r that turns by t has tangents of r tan(t / 2), whatever ANGLE says."""
    radius, mm = bores * 100, math.tan(math.radians(turn) / 2)
    leg = radius * mm
    after = math.radians(turn)
    way = (math.cos(after), math.sin(after) * math.cos(around), math.sin(after) * math.sin(around))
    text = "\n".join(
        [
            "UNITS-BORE MM",
            "UNITS-CO-ORDS MM",
            "ELBOW",
            f"    END-POINT {-leg!r} 0 0 100",
            f"    END-POINT {leg * way[0]!r} {leg * way[1]!r} {leg * way[2]!r} 100",
            "    CENTRE-POINT 0 0 0",
            f"    ANGLE {round(100 * turn)}",
            f"    BEND-RADIUS {radius * 1.5!r}",
        ]
    )
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "net.pcf")
        path.write_text(text)
        read = read_network_map(path)
    assert np.nanmax(read.bend_radius) == pytest.approx(radius / 1e3, rel=1e-6)
    assert [note.kind for note in read.notes] == ["radius-differs"], "the angle fits, the radius does not"


@IN_FOLDER
@given(st.floats(-60, 60), st.floats(-170, 170), st.floats(10, 5000))
def test_degrees_become_metres(tmp_path: Path, latitude: float, longitude: float, metres: float) -> None:
    """A line to the north is as long as the meridian says, one to the east as the parallel (WGS 84, to 0.1 %)."""
    degree = 111_132.95 - 559.85 * math.cos(2 * math.radians(latitude)) + 1.17 * math.cos(4 * math.radians(latitude))
    end = [longitude, latitude + metres / degree]
    path = tmp_path / "net.geojson"
    line = {"type": "LineString", "coordinates": [[longitude, latitude], end]}
    path.write_text(
        '{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"bore": 100}, "geometry": '
        + str(line).replace("'", '"')
        + "}]}"
    )
    read = read_network_map(path, BORE)
    assert read.length[0] == pytest.approx(metres, rel=1e-3)


@IN_FOLDER
@given(st.integers(1, 20), st.floats(0.02, 0.98), st.floats(-0.09, 0.09))
def test_an_end_on_the_inside_of_a_line_is_a_tee(tmp_path: Path, length: int, share: float, off: float) -> None:
    """The line is cut there, and none of its length is lost."""
    run, at = 100 * length, 100 * length * share
    rows = [f"0,0,{run},0,100", f"{at!r},{off!r},{at!r},300,100"]
    (tmp_path / "net.csv").write_text("\n".join(["x1,y1,x2,y2,bore", *rows]))
    read = read_network_map(tmp_path / "net.csv", BORE._replace(coordinates="m"))
    assert len(read.line_names) == 3 and len(read.position) == 4
    assert np.bincount(read.ends.ravel()).max() == 3
    assert read.length.sum() == pytest.approx(run + 300, abs=0.2)
    assert "tee-without-node" in [note.kind for note in read.notes]
