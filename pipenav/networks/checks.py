"""Doubtful and missing things in a map: found, counted and named, so that nothing is guessed in silence."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.networks.model import BORE_STEP, SCALE_SPREAD, NetworkMap, Note, Origin
from pipenav.networks.polylines import ends_on_lines

NEAR = 0.1
"""Distance at which an end that meets nothing lies on another line, or two nodes lie in one place [m]."""

MANY = 5
"""Services at one node from which they are named: nobody builds a crossing of so many pipes."""


def map_notes(network: NetworkMap) -> list[Note]:
    """Findings about a map, those of its reader first."""
    return [*network.notes, *_lengths(network), *_bores(network), *_connections(network), *_services(network)]


def is_sketch(network: NetworkMap) -> bool:
    """Whether drawn lengths have so little to do with the stated ones that angles mean nothing."""
    return length_spread(network) > SCALE_SPREAD


def length_spread(network: NetworkMap) -> float:
    """Ratio of the 90th to the 10th percentile of stated over drawn length; 1 where no length is stated."""
    stated = network.length_origin == Origin.STATED
    drawn = network.drawn_length[stated]
    ratio = network.length[stated][drawn > 0] / drawn[drawn > 0]
    ratio = ratio[ratio > 0]
    if not len(ratio):
        return 1.0
    low, high = np.percentile(ratio, [10, 90])
    return float(high / low)


def components(ends: Ints, nodes: int) -> Ints:
    """Number of the connected piece that each node belongs to, (nodes,)."""
    label = np.arange(nodes)
    while True:
        least = np.minimum(label[ends[:, 0]], label[ends[:, 1]])
        new = label.copy()
        np.minimum.at(new, ends[:, 0], least)
        np.minimum.at(new, ends[:, 1], least)
        new = np.minimum(new, new[new])
        if (new == label).all():
            return label
        label = new


def _lengths(network: NetworkMap) -> Iterator[Note]:
    spread = length_spread(network)
    if spread > SCALE_SPREAD:
        yield Note(
            "sketch",
            "refused",
            f"coordinates are a sketch: stated over drawn length spreads by {spread:.2f} (90th over 10th percentile, "
            f"at most {SCALE_SPREAD:g} in a map), so angles mean nothing and every fitting stays unknown",
        )


def _bores(network: NetworkMap) -> Iterator[Note]:
    missing = np.flatnonzero(np.isnan(network.diameter) & ~network.service)
    mains = int((~network.service).sum())
    if len(missing):
        all_of_them = len(missing) == mains
        yield Note(
            "no-diameter",
            "refused" if all_of_them else "info",
            "no line has a diameter: give --diameter FIELD:mm" if all_of_them else "mains without a diameter",
            len(missing),
            tuple(network.line_names[i] for i in missing[:5].tolist()),
        )
    least, most = _bore_range(network)
    step = (most - least)[np.isfinite(most - least)]
    if small := int(((step > 1e-6) & (step < BORE_STEP)).sum()):
        yield Note("small-reducer", "assumed", "bores that differ by less than 1 mm were taken for equal", small)


def _bore_range(network: NetworkMap) -> tuple[Floats, Floats]:
    """Least and largest bore of the mains at each node, (n,) [m] each."""
    least, most = np.full(len(network.position), np.inf), np.full(len(network.position), -np.inf)
    known = ~network.service & ~np.isnan(network.diameter)
    for side in (0, 1):
        np.minimum.at(least, network.ends[known, side], network.diameter[known])
        np.maximum.at(most, network.ends[known, side], network.diameter[known])
    return least, most


def _connections(network: NetworkMap) -> Iterator[Note]:
    mains = ~network.service
    used = np.unique(network.ends[mains])
    pieces, counts = np.unique(components(network.ends[mains], len(network.position))[used], return_counts=True)
    if len(pieces) > 1:
        sizes = ", ".join(str(size) for size in sorted(counts.tolist(), reverse=True)[:5])
        text = f"the mains are pieces that do not connect, of {sizes} nodes{' and fewer' * (len(pieces) > 5)}"
        yield Note("pieces", "info", text, len(pieces))
    degree = np.bincount(network.ends.ravel(), minlength=len(network.position))
    lines = [[tuple(p) for p in network.points_of(i).tolist()] for i in np.flatnonzero(mains).tolist()]
    names = [network.line_names[i] for i in np.flatnonzero(mains).tolist()]
    loose = {tuple(network.position[i].tolist()) for i in np.flatnonzero(degree == 1).tolist()}
    found = ends_on_lines(lines, NEAR, loose)
    if found:
        text = f"ends that meet nothing lie within {NEAR:g} m of another line: tees without a node, left as ends"
        yield Note("end-on-line", "info", text, len(found), tuple(names[end.other] for end in found[:5]))
    yield from _same_places(network)


def _same_places(network: NetworkMap) -> Iterator[Note]:
    """Nodes in one place that no line joins: in files of EPANET's, mostly the two sides of a pump or a valve."""
    cells = np.unique(np.round(network.position / NEAR).astype(np.int64), axis=0, return_inverse=True)[1].ravel()
    joined = set(cells[network.ends[cells[network.ends[:, 0]] == cells[network.ends[:, 1]], 0]].tolist())
    counts = np.bincount(cells)
    shared = [cell for cell in np.flatnonzero(counts > 1).tolist() if cell not in joined]
    if shared:
        names = [" and ".join(network.node_names[i] for i in np.flatnonzero(cells == cell)[:4]) for cell in shared[:5]]
        text = (
            f"nodes lie within {NEAR:g} m of another one that no pipe joins to them: taken for sides of a pump or a "
            "valve, which no robot passes; give them one name where they are one"
        )
        yield Note("same-place", "assumed", text, int(counts[shared].sum()), tuple(names))


def _services(network: NetworkMap) -> Iterator[Note]:
    count = int(network.service.sum())
    if not count:
        return
    taps = np.bincount(network.ends[network.service].ravel(), minlength=len(network.position))
    length = float(network.length[network.service].sum())
    busiest = np.argsort(-taps, kind="stable")[:5].tolist()
    yield Note(
        "services",
        "assumed",
        f"services of {length / 1e3:.2f} km are not surveyed, and where they leave a main they are taps, no crossings",
        count,
        tuple(f"{taps[i]} at {network.node_names[i]}" for i in busiest if taps[i] >= MANY),
    )
