"""A map in the making: what readers find goes in here line by line, and is checked in one place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.errors import ConfigError, shown
from pipenav.networks.model import NetworkMap, Note, Origin, Severity, drawn_lengths

MOST_EXAMPLES = 5
"""Places that a note names."""

MOST_LINES = 1_000_000
"""Most lines of a map: ten times the largest city's."""

LARGEST_DIAMETER = 10.0
"""Largest inner diameter that a pipe can have [m]; more is a slip of units."""

Point = tuple[float, float, float | None]
"""x, y and, where it is known, z [m]."""


class LineFacts(NamedTuple):
    """Numbers of a line as far as a file states them.

    Attributes:
        diameter: inner diameter [m].
        length: length [m].
        service: whether it is a service.
        diameter_origin: where the diameter came from.
    """

    diameter: float | None = None
    length: float | None = None
    service: bool = False
    diameter_origin: Origin = Origin.STATED


@dataclass
class _Found:
    severity: Severity
    text: str
    count: int = 0
    examples: list[str] = field(default_factory=list)


class MapDraft:
    """A map in the making.

    Args:
        file: name of the file, for messages.
        source: name of its format.
        fabricated: see `NetworkMap`.
    """

    def __init__(self, file: str, source: str, fabricated: bool = False) -> None:
        self.file, self.source, self.fabricated = file, source, fabricated
        self.nodes: dict[str, int] = {}
        self._points: list[Point] = []
        self._places: list[str] = []
        self._radius: list[tuple[float, Origin]] = []
        self._lines: dict[str, int] = {}
        self._ends: list[tuple[int, int]] = []
        self._between: list[Sequence[Point]] = []
        self._facts: list[LineFacts] = []
        self._notes: dict[str, _Found] = {}

    def refuse(self, place: str, problem: str) -> ConfigError:
        """An error at a place of the file, to be raised."""
        return ConfigError(f"{self.file}, {place}: {problem}")

    def note(self, kind: str, severity: Severity, text: str, example: str) -> None:
        """Count a finding; the first text of a kind stands for all of it."""
        found = self._notes.setdefault(kind, _Found(severity, text))
        found.count += 1
        if len(found.examples) < MOST_EXAMPLES:
            found.examples.append(example)

    def node(self, name: str, point: Point, place: str) -> int:
        """Add a node and give its number.

        Raises:
            ConfigError: a name that comes twice, or a coordinate that is not finite.
        """
        if name in self.nodes:
            earlier = self._places[self.nodes[name]]
            raise self.refuse(place, f"node {shown(name)} is named twice, first in {earlier}: give each its own name.")
        self.check_point(point, place)
        self.nodes[name] = len(self._points)
        self._points.append(point)
        self._places.append(place)
        self._radius.append((math.nan, Origin.ASSUMED))
        return self.nodes[name]

    def number_of(self, name: str, place: str) -> int:
        """Number of a node.

        Raises:
            ConfigError: there is no such node.
        """
        if name not in self.nodes:
            raise self.refuse(place, f"node {shown(name)} is not described in the file: add it, or correct the name.")
        return self.nodes[name]

    def bend(self, node: int, radius: float, origin: Origin) -> None:
        """Note the radius of the bend at a node [m]."""
        self._radius[node] = (radius, origin)

    def line(
        self, name: str, ends: tuple[int, int], facts: LineFacts, between: Sequence[Point] = (), place: str = ""
    ) -> None:
        """Add a line between two nodes.

        Raises:
            ConfigError: a name that comes twice, two ends in one node, or a number that no pipe has.
        """
        if name in self._lines:
            raise self.refuse(place, f"line {shown(name)} is named twice: give each its own name.")
        if len(self._ends) >= MOST_LINES:
            raise self.refuse(place, f"the file has more than {MOST_LINES} lines: cut out a part of it.")
        if ends[0] == ends[1] and not between:
            raise self.refuse(place, f"line {shown(name)} begins and ends in one node: give it two.")
        for point in between:
            self.check_point(point, place)
        self._check_facts(name, facts, place)
        self._lines[name] = len(self._ends)
        self._ends.append(ends)
        self._between.append(between)
        self._facts.append(facts)

    def finish(self) -> NetworkMap:
        """The finished map.

        Raises:
            ConfigError: there is no line, or two nodes that one line joins lie in one place.
        """
        if not self._ends:
            raise ConfigError(f"{self.file} has no pipe in it: give a file of a network ({self.source} was expected).")
        position = _points_array(self._points)
        counts = [len(between) for between in self._between]
        vertices = _points_array([point for between in self._between for point in between])
        offsets, ends = np.concatenate([[0], np.cumsum(counts)]).astype(np.intp), np.array(self._ends, np.intp)
        height_origin = np.full(len(position), Origin.STATED, np.int8)
        height_origin[np.isnan(position[:, 2])] = Origin.ASSUMED
        position[:, 2], vertices[:, 2] = _filled(position, vertices, offsets, ends)
        drawn = drawn_lengths(position, ends, vertices, offsets)
        self._check_drawn(drawn)
        stated = np.array([math.nan if facts.length is None else facts.length for facts in self._facts])
        diameters = [math.nan if facts.diameter is None else facts.diameter for facts in self._facts]
        if missing := int((height_origin == Origin.ASSUMED).sum()):
            self._notes["level-assumed"] = _Found(
                "assumed", "no height is stated: taken as level with the nearest end that has one", missing
            )
        return NetworkMap(
            source=self.source,
            fabricated=self.fabricated,
            node_names=tuple(self.nodes),
            position=position,
            height_origin=height_origin,
            bend_radius=np.array([radius for radius, _ in self._radius]),
            radius_origin=np.array([origin for _, origin in self._radius], np.int8),
            line_names=tuple(self._lines),
            ends=ends,
            vertices=vertices,
            offsets=offsets,
            diameter=np.array(diameters),
            diameter_origin=np.array([facts.diameter_origin for facts in self._facts], np.int8),
            length=np.where(np.isnan(stated), drawn, stated),
            length_origin=np.where(np.isnan(stated), Origin.DERIVED, Origin.STATED).astype(np.int8),
            service=np.array([facts.service for facts in self._facts]),
            notes=tuple(
                Note(kind, found.severity, found.text, found.count, tuple(found.examples))
                for kind, found in self._notes.items()
            ),
        )

    def check_point(self, point: Point, place: str) -> None:
        """Refuse a point that is no place on earth.

        Raises:
            ConfigError: with the coordinate.
        """
        for axis, value in zip("xyz", point, strict=True):
            if value is not None and not (math.isfinite(value) and abs(value) < 1e9):
                raise self.refuse(place, f"coordinate {axis} {value:g} is no place on earth: correct it there.")

    def _check_facts(self, name: str, facts: LineFacts, place: str) -> None:
        if facts.diameter is not None and not 0 < facts.diameter <= LARGEST_DIAMETER:
            raise self.refuse(
                place,
                f"line {shown(name)} has a diameter of {facts.diameter * 1e3:g} mm: give one of more than 0 and at "
                f"most {LARGEST_DIAMETER * 1e3:g} mm, or leave it empty where it is not known.",
            )
        if facts.length is not None and not 0 <= facts.length < 1e7:
            raise self.refuse(place, f"line {shown(name)} has a length of {facts.length:g} m: give a possible one.")

    def _check_drawn(self, drawn: Floats) -> None:
        """Refuse lines between two nodes in one place; a network without any coordinates is another matter."""
        for line in np.flatnonzero(drawn <= 0)[:1].tolist():
            one, other = (list(self.nodes)[node] for node in self._ends[line])
            raise ConfigError(
                f"{self.file}: line {shown(list(self._lines)[line])} joins nodes {shown(one)} and {shown(other)}, "
                "which lie in one place: give each its own coordinates, or make them one node."
            )


def _points_array(points: Sequence[Point]) -> Floats:
    """Points as an array with NaN for heights that are not known, (n, 3) [m]."""
    array = [(x, y, math.nan if z is None else z) for x, y, z in points]
    return np.array(array, float).reshape(-1, 3)


def _filled(position: Floats, vertices: Floats, offsets: Ints, ends: Ints) -> tuple[Floats, Floats]:
    """Heights of nodes and vertices, none of which is missing: first from the neighbours, then the median of all."""
    heights, between = position[:, 2].copy(), vertices[:, 2].copy()
    level = float(np.nanmedian(heights)) if not np.isnan(heights).all() else 0.0
    for _ in range(3):  # a node whose neighbours have heights is level with them
        for one, other in ((0, 1), (1, 0)):
            missing = np.isnan(heights[ends[:, one]]) & ~np.isnan(heights[ends[:, other]])
            heights[ends[missing, one]] = heights[ends[missing, other]]
    heights[np.isnan(heights)] = level
    owner = np.repeat(np.arange(len(ends)), np.diff(offsets))
    missing = np.isnan(between)
    if missing.any():  # in a straight line from end to end, by the number of the vertex
        share = (np.arange(len(between)) - offsets[owner] + 1.0) / (np.diff(offsets)[owner] + 1)
        start, end = heights[ends[owner, 0]], heights[ends[owner, 1]]
        between[missing] = (start + share * (end - start))[missing]
    return heights, between
