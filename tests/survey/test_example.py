"""The example, Schutterwald, as others measured it: lengths, branches, taps; its licence lies beside it."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from helpers.doc_pages import ROOT

from pipenav.networks import NetworkMap, is_sketch, map_notes, read_network_map
from pipenav.survey.features import Fittings, Geometry, fittings_of
from pipenav.survey.graph import mains_graph

EXAMPLE = ROOT / "examples/schutterwald"


@pytest.fixture(scope="module")
def network() -> NetworkMap:
    return read_network_map(EXAMPLE / "network.json")


@pytest.fixture(scope="module")
def fittings(network: NetworkMap) -> Fittings:
    return fittings_of(mains_graph(network), Geometry())


def test_lengths(network: NetworkMap) -> None:
    """Pandapipes' own tables add up to these: 1,053 mains and 1,506 house connections."""
    mains = ~network.service
    in_range = mains & (network.diameter >= 0.07) & (network.diameter <= 0.12)
    assert (mains.sum(), network.service.sum()) == (1053, 1506)
    assert network.length[mains].sum() == pytest.approx(10_440.6, abs=0.1)
    assert network.length[in_range].sum() == pytest.approx(9421.06, abs=0.01)
    assert not is_sketch(network)


def test_branches_and_corners(fittings: Fittings) -> None:
    """Thirty tees with one branch and six crosses with two: 42 branches; some 95 corners of 3.5 deg or more."""
    degrees = Counter(fittings.graph.incidence.degree.tolist())
    assert degrees[3] + 2 * degrees[4] == 42
    turns = np.array([180 - f.angle_deg for f in fittings.features if f.kind == "bend"])
    assert (turns >= 3.5).sum() == pytest.approx(95, abs=2)


def test_nearly_half_of_straight_nodes_would_look_like_bends(fittings: Fittings) -> None:
    """By the error that 0.25 m puts on their angles, the chance of 5 deg or more, on average 45 %."""
    from math import erfc, sqrt

    errors = [feature.error_deg for feature in fittings.features if feature.kind == "joint"]
    assert np.mean([erfc(5 / error / sqrt(2)) for error in errors]) == pytest.approx(0.45, abs=0.05)


def test_taps_are_counted(network: NetworkMap) -> None:
    (note,) = [note for note in map_notes(network) if note.kind == "services"]
    assert note.number == 1506 and note.examples[0].startswith("53 at ")


def test_the_licence_is_there() -> None:
    assert "Fraunhofer" in (EXAMPLE / "LICENSE").read_text(encoding="utf-8")
