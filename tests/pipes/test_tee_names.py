"""Names of tees in the results of evaluations."""

from __future__ import annotations

import math

import pytest

from pipenav.pipes.branch import Branch
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.tee import TeePassage, fitting_of, tee


@pytest.mark.parametrize("way", ["straight", "into", "out"])
@pytest.mark.parametrize("turn", ["left", "right"])
@pytest.mark.parametrize("angle", [30, 45, 62.5, 90, 135, 150])
def test_a_tee_is_called_as_it_was_asked_for(angle: float, way: str, turn: str) -> None:
    assert fitting_of(tee(100, angle, TeePassage(way, turn))) == f"tee {angle:g} {way}"


def test_crosses_and_corners() -> None:
    sides = tuple(Branch(angle=math.pi / 3, turn=turn, diameter=0.1, length=0.4) for turn in ("left", "right"))
    assert fitting_of(PipeCorner(diameter=0.1, angle=math.pi, leg=0.6, branches=sides[:1])) == "tee 60 straight"
    opposite = sides[1].model_copy(update={"angle": 2 * math.pi / 3})
    crossing = PipeCorner(diameter=0.1, angle=math.pi, leg=0.6, branches=(sides[0], opposite))
    assert fitting_of(crossing) == "cross 60 straight"
    assert fitting_of(PipeCorner.of(100, 60)) is None
