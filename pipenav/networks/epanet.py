"""EPANET's .inp: sections in brackets, a line for each node or pipe.

Source of the format and of the units by flow unit: L. A. Rossman et al., EPANET 2.2 User Manual, EPA/600/R-20/133,
appendices A (units) and C (input file).
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipenav.errors import ConfigError, shown
from pipenav.networks.draft import LineFacts, MapDraft, Point
from pipenav.networks.model import SCALE_SPREAD, NetworkMap
from pipenav.networks.text import network_text
from pipenav.networks.units import FOOT, INCH, number
from pipenav.storage.text_files import shown_path

US_FLOWS = ("CFS", "GPM", "MGD", "IMGD", "AFD")
"""Flow units with which diameters are inches and lengths feet."""

SI_FLOWS = ("LPS", "LPM", "MLD", "CMH", "CMD", "CMS")
"""Flow units with which diameters are millimetres and lengths metres."""

KNOWN = ("TITLE", "JUNCTIONS", "RESERVOIRS", "TANKS", "PIPES", "PUMPS", "VALVES", "COORDINATES", "VERTICES", "OPTIONS")
"""Sections by which the format is known; all others are passed over."""


class _Row(NamedTuple):
    """Words of a line, and its place in words."""

    words: list[str]
    place: str


class _Units(NamedTuple):
    """Units of diameters and of lengths and heights [m]."""

    diameter: float
    length: float


def read_epanet(path: Path) -> NetworkMap:
    """The map of an EPANET file.

    Heads of tanks and reservoirs are no heights of pipes, so these nodes have none. Coordinates without a unit of their
    own are scaled so that lines are as long as they are stated; in a sketch, where no scale does that, they stay.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no such file, with the line that does not fit.
    """
    where = shown_path(path)
    sections = _sections(network_text(path), where)
    units = _units(sections.get("OPTIONS", []), where)
    draft = MapDraft(where, "EPANET .inp")
    places = _coordinates(sections.get("COORDINATES", []), where)
    vertices: dict[str, list[tuple[float, float]]] = {}
    for row in sections.get("VERTICES", []):
        _need(row, 3, "a link, x and y", where)
        vertices.setdefault(row.words[0], []).append((_number(row, 1, "x", where), _number(row, 2, "y", where)))
    pipes = sections.get("PIPES", [])
    scale = _scale(pipes, places, vertices, units)
    if scale != 1.0:
        draft.note("scaled", "info", f"coordinates have no unit: scaled by {scale:.4g} to stated lengths", where)
    _add_nodes(draft, sections, places, scale, units)
    for row in pipes:
        _add_pipe(draft, row, vertices, scale, units)
    for kind in ("VALVES", "PUMPS"):
        for row in sections.get(kind, []):
            noun = kind[:-1].lower()
            text = f"{noun}s are taken for ends: what they let through is not in the file"
            draft.note(kind.lower(), "assumed", text, row.words[0])
    return draft.finish()


def _sections(text: str, where: str) -> dict[str, list[_Row]]:
    """Rows of each section by its name."""
    found: dict[str, list[_Row]] = {}
    rows: list[_Row] | None = None
    for i, line in enumerate(text.split("\n"), 1):
        bare = line.partition(";")[0].strip()
        if not bare:
            continue
        if bare.startswith("["):
            name = bare.strip("[]").strip().upper()
            if name == "END":
                break
            rows = found.setdefault(_full_name(name), [])
        elif rows is None:
            raise ConfigError(f"{where}, line {i}: {shown(bare)} stands before any [SECTION]: this is no EPANET file.")
        else:
            rows.append(_Row(bare.split(), f"line {i}"))
    if not found.get("PIPES"):
        raise ConfigError(f"{where} has no [PIPES], which an EPANET file has: give another file.")
    return found


def _full_name(name: str) -> str:
    """Name of a section, which may be written by its first four letters."""
    return next((known for known in KNOWN if len(name) >= 4 and known.startswith(name)), name)


def _units(options: list[_Row], where: str) -> _Units:
    flow = "GPM"
    for row in options:
        if row.words[0].upper() == "UNITS" and len(row.words) > 1:
            flow = row.words[1].upper()
            if flow not in US_FLOWS + SI_FLOWS:
                known = ", ".join(US_FLOWS + SI_FLOWS)
                raise ConfigError(f"{where}, {row.place}: flow unit {shown(flow)} is unknown: choose {known}.")
    return _Units(INCH, FOOT) if flow in US_FLOWS else _Units(1e-3, 1.0)


def _coordinates(rows: list[_Row], where: str) -> dict[str, tuple[float, float]]:
    found: dict[str, tuple[float, float]] = {}
    for row in rows:
        _need(row, 3, "a node, x and y", where)
        if row.words[0] in found:
            raise ConfigError(f"{where}, {row.place}: node {shown(row.words[0])} has coordinates twice: remove one.")
        found[row.words[0]] = (_number(row, 1, "x", where), _number(row, 2, "y", where))
    return found


def _add_nodes(
    draft: MapDraft,
    sections: dict[str, list[_Row]],
    places: dict[str, tuple[float, float]],
    scale: float,
    units: _Units,
) -> None:
    for kind in ("JUNCTIONS", "RESERVOIRS", "TANKS"):
        for row in sections.get(kind, []):
            name = row.words[0]
            height = None
            if kind != "JUNCTIONS":
                draft.note("heads", "info", "tanks and reservoirs state a head, which is no height of a pipe", name)
            elif len(row.words) > 1:
                height = _number(row, 1, "height", draft.file) * units.length
            if name not in places:
                raise draft.refuse(row.place, f"node {shown(name)} has no [COORDINATES]: a map needs them, add them.")
            x, y = places[name]
            draft.node(name, (x * scale, y * scale, height), row.place)


def _add_pipe(
    draft: MapDraft, row: _Row, vertices: dict[str, list[tuple[float, float]]], scale: float, units: _Units
) -> None:
    _need(row, 5, "a name, two nodes, length and diameter", draft.file)
    name, start, end = row.words[:3]
    facts = LineFacts(
        diameter=_number(row, 4, "diameter", draft.file) * units.diameter,
        length=_number(row, 3, "length", draft.file) * units.length,
    )
    ends = (draft.number_of(start, row.place), draft.number_of(end, row.place))
    between: list[Point] = [(x * scale, y * scale, None) for x, y in vertices.get(name, [])]
    draft.line(name, ends, facts, between, row.place)


def _scale(
    pipes: list[_Row],
    places: dict[str, tuple[float, float]],
    vertices: dict[str, list[tuple[float, float]]],
    units: _Units,
) -> float:
    """Metres in a unit of the coordinates, as the stated lengths say; 1 where they agree within 1 % or not at all."""
    ratios = []
    for row in pipes:
        if len(row.words) > 3 and row.words[1] in places and row.words[2] in places:
            way = np.array([places[row.words[1]], *vertices.get(row.words[0], []), places[row.words[2]]])
            drawn = float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
            if drawn > 0 and re.fullmatch(r"[\d.eE+-]+", row.words[3]):
                ratios.append(_length(row.words[3]) * units.length / drawn)
    usable = [ratio for ratio in ratios if math.isfinite(ratio) and ratio > 0]
    if not usable:
        return 1.0
    low, middle, high = np.percentile(usable, [10, 50, 90])
    return 1.0 if high > SCALE_SPREAD * low or abs(middle - 1) < 0.01 else float(middle)


def _length(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return math.nan


def _need(row: _Row, words: int, what: str, where: str) -> None:
    if len(row.words) < words:
        raise ConfigError(f"{where}, {row.place}: {shown(' '.join(row.words))} is too short: it needs {what}.")


def _number(row: _Row, column: int, what: str, where: str) -> float:
    return number(row.words[column], what, f"{where}, {row.place}")
