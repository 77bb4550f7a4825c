"""A map of a pipe network: thousands of nodes and lines as arrays, each number with a record of where it came from.

A `pipenav.pipes.network.PipeNetwork` is a network that can be built and simulated, down to its walls; a map is what an
operator has in a file, with what is missing or doubtful in it. Routes of a map become routes that can be simulated.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints

Origins = NDArray[np.int8]
"""Values of `Origin`, one for each number of an array."""

SCALE_SPREAD = 1.3
"""Largest ratio of the 90th to the 10th percentile of stated over drawn length: above it, a map is a sketch."""

Severity = Literal["info", "assumed", "refused"]


class Origin(IntEnum):
    """Source of a number: the file, other numbers of it, or a guess."""

    STATED = 0
    DERIVED = 1
    ASSUMED = 2

    @property
    def label(self) -> str:
        """`stated`, `derived` or `assumed`."""
        return self.name.lower()


class Note(NamedTuple):
    """Something that a reader or a check found out about a map.

    Attributes:
        kind: short name, `level-assumed`.
        severity: `info`; `assumed` where a number was guessed; `refused` where angles or all of the map are of no use.
        text: sentence for people.
        number: number of places.
        examples: names of the first places.
    """

    kind: str
    severity: Severity
    text: str
    number: int = 1
    examples: tuple[str, ...] = ()


@dataclass(frozen=True)
class NetworkMap:
    """Nodes and the lines between them, n nodes and m lines; lengths in metres, z upwards.

    Attributes:
        source: format of the file that it was read from.
        fabricated: whether it was drawn to be built from, to the millimetre, and not surveyed.
        node_names: names of the nodes, n of them.
        position: positions of the nodes, (n, 3) [m].
        height_origin: where the heights of the nodes came from, (n,).
        bend_radius: radius of the bend at a node [m], 0 for a mitre, NaN where nothing is known, (n,).
        radius_origin: where the radii came from, (n,); it says nothing where the radius is NaN.
        line_names: names of the lines, m of them.
        ends: nodes in which each line begins and ends, (m, 2).
        vertices: points of all lines between their ends, line after line, (v, 3) [m].
        offsets: number of the first vertex of each line, and v, (m + 1,).
        diameter: inner diameters [m], NaN where none is known, (m,).
        diameter_origin: where the diameters came from, (m,).
        length: lengths as stated, or along the points, (m,) [m].
        length_origin: where the lengths came from, (m,).
        service: whether a line is a service, which leads from a main to a single building, (m,).
        notes: findings of the reader.
    """

    source: str
    fabricated: bool
    node_names: tuple[str, ...]
    position: Floats
    height_origin: Origins
    bend_radius: Floats
    radius_origin: Origins
    line_names: tuple[str, ...]
    ends: Ints
    vertices: Floats
    offsets: Ints
    diameter: Floats
    diameter_origin: Origins
    length: Floats
    length_origin: Origins
    service: Flags
    notes: tuple[Note, ...] = ()

    def points_of(self, line: int) -> Floats:
        """Points of a line from end to end, (points, 3) [m]."""
        start, end = self.position[self.ends[line]]
        between = self.vertices[self.offsets[line] : self.offsets[line + 1]]
        return np.concatenate([start[None], between, end[None]])

    @property
    def drawn_length(self) -> Floats:
        """Lengths along the points, in plan and height, (m,) [m]."""
        return drawn_lengths(self.position, self.ends, self.vertices, self.offsets)


def drawn_lengths(position: Floats, ends: Ints, vertices: Floats, offsets: Ints) -> Floats:
    """Lengths of lines along their points, (m,) [m]; arguments as the attributes of `NetworkMap`."""
    if not len(ends):
        return np.zeros(0)
    counts = np.diff(offsets) + 2
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    points = np.empty((int(counts.sum()), 3))
    inner = np.ones(len(points), bool)
    last = first + counts - 1
    inner[first] = inner[last] = False
    points[first], points[last], points[inner] = position[ends[:, 0]], position[ends[:, 1]], vertices
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    steps[last[:-1]] = 0.0  # between two lines
    return np.asarray(np.add.reduceat(np.append(steps, 0.0), first))
