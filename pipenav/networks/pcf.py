"""Isogen's piping component files (.pcf): a keyword at the line's start for each component, its attributes indented.

Angles and radii are computed from the points, since the ANGLE that files state is sometimes the turn and sometimes the
interior angle, and BEND-RADIUS is often missing or wrong. Source of the keywords: Alias Ltd, "Piping Component File
(PCF) Reference Guide".
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import ConfigError, shown
from pipenav.networks.draft import LineFacts, MapDraft
from pipenav.networks.model import NetworkMap, Origin
from pipenav.networks.text import network_text
from pipenav.networks.units import INCH, number
from pipenav.storage.text_files import shown_path

BENDS = ("ELBOW", "BEND")
FITTINGS = ("TEE", "CROSS", "OLET", "TEE-STUB", "TEE-SET-ON")
SPOTS = ("WELD", "SUPPORT", "BOLT", "GASKET", "INSTRUMENT-DIAL", "FLOW-ARROW", "MESSAGE", "MATERIALS")
"""Components without a length that matters here."""

POINTS = ("END-POINT", "CENTRE-POINT", "BRANCH1-POINT", "BRANCH2-POINT", "CO-ORDS")

SNAP = 1e-3
"""Distance within which points of components are one node [m]: files are written to the millimetre."""

ANGLE_TOLERANCE, RADIUS_TOLERANCE = 0.5, 0.02
"""Differences that are rounding: of an angle [deg], and of a radius as a share of it."""


class _Component(NamedTuple):
    """A component: its keyword, its points with bores in the file's units, its other attributes, and its place."""

    kind: str
    points: list[tuple[str, tuple[float, float, float], float | None]]
    attributes: dict[str, str]
    place: str

    def at(self, *kinds: str) -> list[tuple[tuple[float, float, float], float | None]]:
        return [(point, bore) for kind, point, bore in self.points if kind in kinds]


def read_pcf(path: Path) -> NetworkMap:
    """The map of a PCF file.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no such file, with the line that does not fit.
    """
    where = shown_path(path)
    header, components = _parsed(network_text(path), where)
    lengths, bores = (_unit(header, key, where) for key in ("UNITS-CO-ORDS", "UNITS-BORE"))
    maker = _Maker(MapDraft(where, "PCF", fabricated=True), lengths, bores)
    for component in components:
        maker.add(component)
    return maker.draft.finish()


def _parsed(text: str, where: str) -> tuple[dict[str, str], list[_Component]]:
    """The units at the head of a file, and its components."""
    header: dict[str, str] = {}
    components: list[_Component] = []
    for i, line in enumerate(text.split("\n"), 1):
        words = line.split()
        if not words:
            continue
        if not line[0].isspace():
            if words[0].startswith("UNITS-") and len(words) > 1:
                header[words[0]] = words[1].upper()
            components.append(_Component(words[0].upper(), [], {}, f"line {i}"))
        elif not components:
            raise ConfigError(f"{where}, line {i}: an attribute stands before any component: this is no PCF file.")
        elif words[0] in POINTS:
            at = f"{where}, line {i}"
            if len(words) < 4:
                raise ConfigError(f"{at}: {shown(line.strip())} needs x, y and z: add what is missing.")
            x, y, z = (number(word, axis, at) for word, axis in zip(words[1:4], "xyz", strict=True))
            bore = number(words[4], "bore", at) if len(words) > 4 and _numeric(words[4]) else None
            components[-1].points.append((words[0], (x, y, z), bore))
        else:
            components[-1].attributes[words[0].upper()] = " ".join(words[1:])
    if "UNITS-CO-ORDS" not in header:
        raise ConfigError(f"{where} names no UNITS-CO-ORDS, which every PCF file has: add it, or give another file.")
    return header, components


def _numeric(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _unit(header: dict[str, str], key: str, where: str) -> float:
    given = header.get(key, "MM")
    units = {"MM": 1e-3, "INCH": INCH}
    if given not in units:
        raise ConfigError(f"{where}: {key} {shown(given)} is unknown: choose MM or INCH.")
    return units[given]


class _Maker:
    """Turns components into nodes and lines.

    Args:
        draft: the map in the making.
        length: unit of coordinates and radii [m].
        bore: unit of bores [m].
    """

    def __init__(self, draft: MapDraft, length: float, bore: float) -> None:
        self.draft, self._length, self._bore = draft, length, bore
        self._nodes: dict[tuple[int, int, int], int] = {}
        self._lines = 0

    def add(self, component: _Component) -> None:
        """Add the lines of a component."""
        kind = component.kind
        ends, centres = component.at("END-POINT"), component.at("CENTRE-POINT")
        if kind in SPOTS or len(ends) < 2:
            if kind == "OLET" and centres:
                self.draft.note("olet", "info", "olets are taps on a pipe and were left out", component.place)
            return
        if kind in BENDS:
            self._add_bend(component)
        elif kind in FITTINGS and centres:
            branches = component.at("BRANCH1-POINT", "BRANCH2-POINT")
            for point, bore in [*ends, *branches]:
                self._line(component, (point, centres[0][0]), bore)
        else:
            first, last = ends[0], ends[-1]
            middle = tuple((a + b) / 2 for a, b in zip(first[0], last[0], strict=True))
            if first[1] and last[1] and first[1] != last[1]:  # a reducer: the bore changes in its middle
                self._line(component, (first[0], (middle[0], middle[1], middle[2])), first[1])
                self._line(component, ((middle[0], middle[1], middle[2]), last[0]), last[1])
            else:
                self._line(component, (first[0], last[0]), first[1] or last[1])
            if kind.startswith(("VALVE", "INSTRUMENT", "PUMP")):
                text = "valves and instruments were taken for open pipe"
                self.draft.note("valves", "assumed", text, f"{kind}, {component.place}")

    def _add_bend(self, component: _Component) -> None:
        ends, centres = component.at("END-POINT"), component.at("CENTRE-POINT")
        if not centres:
            raise self.draft.refuse(component.place, f"a {component.kind} needs a CENTRE-POINT: add it.")
        centre = centres[0][0]
        legs = [np.subtract(end[0], centre) * self._length for end in ends[:2]]
        sizes = [float(np.linalg.norm(leg)) for leg in legs]
        if min(sizes) <= SNAP:
            raise self.draft.refuse(component.place, "its centre lies in one of its ends: give three points.")
        interior = angle_between(legs[0], legs[1])
        radius = min(sizes) * math.tan(interior / 2)
        self._compare(component, math.degrees(interior), radius)
        bore = ends[0][1] or ends[1][1]
        for end, _ in ends[:2]:
            self._line(component, (end, centre), bore)
        self.draft.bend(self._node(centre), radius, Origin.DERIVED)

    def _compare(self, component: _Component, interior: float, radius: float) -> None:
        """Note where a stated angle or radius is not that of the points."""
        stated = component.attributes.get("ANGLE")
        if stated is not None and _numeric(stated):
            angle = float(stated) / 100
            if min(abs(angle - interior), abs(angle - (180 - interior))) > ANGLE_TOLERANCE:
                text = "a stated ANGLE is neither the turn nor the interior angle of its points, which are used"
                example = f"{component.place}: {angle:g} deg stated, a turn of {180 - interior:.2f} deg"
                self.draft.note("angle-differs", "info", text, example)
        stated = component.attributes.get("BEND-RADIUS")
        if stated is not None and _numeric(stated):
            given = float(stated) * self._length
            if abs(given - radius) > RADIUS_TOLERANCE * radius:
                text = "a stated BEND-RADIUS is not that of the points, which are used"
                example = f"{component.place}: {given * 1e3:g} mm stated, {radius * 1e3:.4g} mm"
                self.draft.note("radius-differs", "info", text, example)

    def _line(
        self,
        component: _Component,
        ends: tuple[tuple[float, float, float], tuple[float, float, float]],
        bore: float | None,
    ) -> None:
        nodes = self._node(ends[0]), self._node(ends[1])
        if nodes[0] == nodes[1]:
            self.draft.note("short", "info", "pieces shorter than a millimetre were left out", component.place)
            return
        self._lines += 1
        diameter = None if bore is None else bore * self._bore
        name = f"{component.kind.lower()} {self._lines}"
        self.draft.line(name, nodes, LineFacts(diameter), place=component.place)

    def _node(self, point: tuple[float, float, float]) -> int:
        """Number of the node at a point in the file's units."""
        x, y, z = (value * self._length for value in point)
        key = (round(x / SNAP), round(y / SNAP), round(z / SNAP))
        for i in (0, -1, 1):
            for j in (0, -1, 1):
                for k in (0, -1, 1):
                    if (near := (key[0] + i, key[1] + j, key[2] + k)) in self._nodes:
                        return self._nodes[near]
        self._nodes[key] = self.draft.node(f"node {len(self._nodes) + 1}", (x, y, z), "a component")
        return self._nodes[key]


def angle_between(one: Floats, other: Floats) -> float:
    """Angle between two directions [rad]."""
    return math.atan2(float(np.linalg.norm(np.cross(one, other))), float(one @ other))
