"""Networks of chance, written as files by the rules of each format."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import NamedTuple

from hypothesis import strategies as st

INCH, FOOT = 0.0254, 0.3048


class Drawn(NamedTuple):
    """A tree of pipes on a grid.

    Attributes:
        nodes: positions in whole metres, by name.
        pipes: start and end of each pipe, with its inner diameter in whole millimetres.
    """

    nodes: dict[str, tuple[int, int, int]]
    pipes: list[tuple[str, str, int]]

    def length(self, pipe: int) -> float:
        """Length of a pipe [m]."""
        start, end, _ = self.pipes[pipe]
        steps = zip(self.nodes[start], self.nodes[end], strict=True)
        return float(sum((a - b) ** 2 for a, b in steps) ** 0.5)


@st.composite
def drawn_networks(draw: st.DrawFn) -> Drawn:
    """Trees in which no pipe comes near to another one's node: the nodes lie on a parabola, but for some metres."""
    count = draw(st.integers(2, 12))
    nodes = {
        f"N{i}": (1000 * i + draw(st.integers(-9, 9)), 100 * i * i + draw(st.integers(-9, 9)), draw(st.integers(-5, 5)))
        for i in range(count)
    }
    pipes = [(f"N{draw(st.integers(0, i - 1))}", f"N{i}", draw(st.integers(40, 400))) for i in range(1, count)]
    return Drawn(nodes, pipes)


def as_inp(network: Drawn, flow: str, inches: bool) -> str:
    """The network as EPANET writes it."""
    bore, length = (INCH, FOOT) if inches else (1e-3, 1.0)
    lines = ["[TITLE]", "a test ; with a comment", "[JUNCTIONS]", ";ID Elev"]
    lines += [f" {name}\t{z / length!r}\t0 ;" for name, (_, _, z) in network.nodes.items()]
    lines.append("[PIPES]")
    for i, (start, end, mm) in enumerate(network.pipes):
        lines.append(f" P{i} {start} {end} {network.length(i) / length!r} {mm / 1000 / bore!r} 100 0 Open ;")
    lines += ["[OPTIONS]", f" Units {flow}", "[COORDINATES]"]
    lines += [f" {name} {x} {y}" for name, (x, y, _) in network.nodes.items()]
    return "\n".join([*lines, "[END]", "what follows is not read"]) + "\n"


def as_pandapipes(network: Drawn, newer: bool) -> str:
    """The network as pandapipes writes it, with the older or the newer name of the diameter."""
    names = list(network.nodes)

    def table(columns: list[str], rows: list[list[object]]) -> dict[str, object]:
        text = json.dumps({"columns": columns, "index": list(range(len(rows))), "data": rows})
        return {"_module": "pandas.core.frame", "_class": "DataFrame", "_object": text, "orient": "split"}

    diameter = "inner_diameter_mm" if newer else "diameter_m"
    pipes: list[list[object]] = [
        [names.index(start), names.index(end), network.length(i) / 1e3, mm if newer else mm / 1e3]
        for i, (start, end, mm) in enumerate(network.pipes)
    ]
    tables = {
        "junction": table(["name", "height_m"], [[name, z] for name, (_, _, z) in network.nodes.items()]),
        "junction_geodata": table(["x", "y"], [[x, y] for x, y, _ in network.nodes.values()]),
        "pipe": table(["from_junction", "to_junction", "length_km", diameter], pipes),
    }
    return json.dumps({"_module": "pandapipes.pandapipes_net", "_class": "pandapipesNet", "_object": tables})


def as_geojson(network: Drawn) -> str:
    """The network as lines of GeoJSON in metres."""
    features = [
        {
            "type": "Feature",
            "properties": {"bore": mm},
            "geometry": {"type": "LineString", "coordinates": [network.nodes[start], network.nodes[end]]},
        }
        for start, end, mm in network.pipes
    ]
    return json.dumps({"type": "FeatureCollection", "features": features})


def as_csv(network: Drawn, wkt: bool) -> str:
    """The network as CSV, with columns of ends or with well-known text."""
    file = io.StringIO()
    writer = csv.writer(file, delimiter=";" if wkt else ",")
    writer.writerow(["id", "bore", "wkt"] if wkt else ["id", "bore", "x1", "y1", "z1", "x2", "y2", "z2"])
    for i, (start, end, mm) in enumerate(network.pipes):
        a, b = network.nodes[start], network.nodes[end]
        course = [f"LINESTRING Z ({', '.join(' '.join(map(str, p)) for p in (a, b))})"] if wkt else [*a, *b]
        writer.writerow([f"P{i}", f"{mm} mm", *course])
    return file.getvalue()


def write_shapefile(network: Drawn, path: Path) -> None:
    """Write the network as a shapefile of polylines with heights."""
    import shapefile

    with shapefile.Writer(str(path), shapeType=shapefile.POLYLINEZ) as writer:
        writer.field("BORE", "N", size=10, decimal=1)
        for start, end, mm in network.pipes:
            writer.linez([[list(network.nodes[start]), list(network.nodes[end])]])
            writer.record(mm)


def as_pcf(network: Drawn, inches: bool) -> str:
    """The network as pipes of a PCF file, coordinates in millimetres or in inches."""
    unit, name = (INCH * 1e3, "INCH") if inches else (1.0, "MM")
    lines = ["ISOGEN-FILES ISOGEN.FLS", f"UNITS-BORE {name}", f"UNITS-CO-ORDS {name}", "PIPELINE-REFERENCE P-1"]
    for start, end, mm in network.pipes:
        lines.append("PIPE")
        for node in (start, end):
            x, y, z = (1e3 * value / unit for value in network.nodes[node])
            lines.append(f"    END-POINT {x!r} {y!r} {z!r} {mm / unit!r}")
    return "\n".join(lines) + "\n"
