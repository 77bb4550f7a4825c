"""Geometry's word on classes: proofs hold in every bore of a class, motions in all that is wider, and both are kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.surveys import found
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.certify.model import Model
from pipenav.certify.verdict import Kind, certify
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.survey import possible
from pipenav.survey.classes import BORE_STEP_MM, FittingClass
from pipenav.survey.possible import Possibilities, Possibility, fits_straight, part_too_large, possibility
from pipenav.survey.trials import STRAIGHT, Trial
from pipenav.units import deg_to_rad

PIRATE = load_robot("pirate")
WORDS = {word: i for i, word in enumerate(("impossible", "undecided", "passable"))}
FEW = settings(max_examples=12, deadline=None)

ways = st.sampled_from(["into", "out"])
angles = st.sampled_from([60.0, 75.0, 90.0, 105.0, 120.0])


@pytest.mark.parametrize("angle", [75.0, 90.0, 135.0])
def test_a_wider_bore_is_never_worse(angle: float) -> None:
    found = [WORDS[possibility(PIRATE, FittingClass("bend", bore, angle)).kind] for bore in range(45, 90, 5)]
    assert found == sorted(found)
    assert {found[0], found[-1]} == {WORDS["impossible"], WORDS["passable"]}


@FEW
@given(st.sampled_from([45.0, 50.0, 55.0, 60.0]), angles, st.floats(-1, 1))
def test_a_proof_holds_in_every_bore_of_its_class(bore: float, angle: float, share: float) -> None:
    if possibility(PIRATE, FittingClass("bend", bore, angle)).kind == "impossible":
        pipe = PipeCorner.of(bore + share * BORE_STEP_MM / 2, angle)
        assert certify(Model(PIRATE, pipe, "round"), None, deg_to_rad(0.5)).kind != "passable"


@FEW
@given(st.sampled_from([50.0, 65.0, 70.0, 100.0]), st.sampled_from([0.0, 30.0]), angles, ways)
def test_a_branch_is_passable_where_the_corner_of_its_bore_is(
    branch: float, more: float, angle: float, way: str
) -> None:
    """The corner lies within the tee and the cross, whatever the run's bore; a tee is never proven by its corner."""
    corner = possibility(PIRATE, FittingClass("bend", branch, angle)).kind
    for kind in ("tee", "cross"):
        word = possibility(PIRATE, FittingClass(kind, branch + more, angle, to_mm=branch, way=way))
        assert word.kind == "undecided" if corner == "impossible" else WORDS[word.kind] >= WORDS[corner]


@pytest.mark.parametrize("robot", ["pirate", "high-fidelity"])
def test_a_robot_fits_straight_or_has_a_part_that_does_not(robot: str) -> None:
    """Both tests agree from some bore on; a part that is too large for one bore is too large for each smaller one."""
    spec = load_robot(robot)
    bores = [0.01 * k for k in range(1, 12)]
    too_large = [bool(part_too_large(spec, bore)) for bore in bores]
    assert too_large == sorted(too_large, reverse=True) and too_large[0] and not too_large[-1]
    assert not any(large and fits_straight(spec, bore) for bore, large in zip(bores, too_large, strict=True))
    assert fits_straight(spec, bores[-1])


def test_what_no_part_fits_into_is_impossible_whatever_it_is() -> None:
    kinds = [FittingClass("reducer", 100.0, to_mm=30.0), FittingClass("bend", 30.0, 90.0), FittingClass("bend", 30.0)]
    kinds += [FittingClass("tee", 100.0, 90.0, to_mm=30.0, way=way) for way in ("straight", "into", "out")]
    for kind in kinds:
        word = possibility(PIRATE, kind)
        assert word.kind == "impossible" and "width: a part of" in word.reason


def test_words_are_kept_for_all_slopes_and_for_a_shape(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    real = possible.possibility

    def counted(robot: Any, kind: FittingClass) -> Possibility:
        asked.append(kind)
        return real(robot, kind)

    monkeypatch.setattr(possible, "possibility", counted)
    level = FittingClass("bend", 100, 90)
    steep = level._replace(incline_deg=30.0)
    first = Possibilities(PIRATE, tmp_path).results([level, steep])
    assert first[level] == first[steep] and asked == [level]
    assert Possibilities(PIRATE, tmp_path).results([steep])[steep] == first[level] and len(asked) == 1
    heavier = PIRATE.model_copy(update={"name": "another"})
    Possibilities(heavier, tmp_path).results([level])
    assert len(asked) == 1, "a name is no shape"


TRIALS = {
    "untried": Trial(episodes=0, successes=0, reason="nobody knows"),
    "passes": Trial(episodes=20, successes=20),
    "fails": Trial(episodes=20, successes=2),
    "open": Trial(episodes=20, successes=18),
    "straight": STRAIGHT,
}


@pytest.mark.parametrize("trial", TRIALS)
@pytest.mark.parametrize("geometry", ["passable", "impossible", "undecided"])
def test_verdicts_need_both(trial: str, geometry: Kind) -> None:
    """Navigable is only what passes trials and has a motion; a proof outdoes them; what nobody tried is never that."""
    finding = found(TRIALS[trial], geometry)
    verdict, cause, reason = finding.verdict(0.95), finding.cause(0.95), finding.reason(0.95)
    assert (verdict == "navigable") == (trial in ("passes", "straight") and geometry == "passable")
    assert (verdict == "not navigable") == (geometry == "impossible" or trial == "fails")
    assert (cause == "impossible") == (geometry == "impossible")
    assert (cause == "policy") == (geometry == "passable" and trial == "fails")
    assert (cause == "untried") == (trial == "untried" and geometry != "impossible")
    assert bool(reason) == bool(cause) == (verdict != "navigable")
    if geometry != "passable" and verdict != "navigable" and trial != "open":
        assert "a reason" in reason
