"""The range of a policy's training."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pipenav.evaluation.training_range import TrainingRange
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import parse_corners
from pipenav.policies.named import open_controller

diameters, angles = st.integers(60, 120), st.integers(45, 140)
corners = st.builds(PipeCorner.of, diameters, angles, st.sampled_from(["left", "right"]))


@given(st.lists(corners, min_size=1, max_size=6), st.data())
def test_trained_pipes_are_inside_and_those_beyond_all_of_them_outside(
    trained: list[PipeCorner], data: st.DataObject
) -> None:
    found = TrainingRange(trained)
    one = data.draw(st.sampled_from(trained))
    assert found.has(one)
    assert found.has(one.mirrored)
    widest = max(pipe.diameter for pipe in trained) * 1e3
    assert not found.has(PipeCorner.of(widest + 1, 90))
    assert not found.has(PipeCorner.of(100, 30))
    assert not found.has(PipeCorner.of(100, 90, "left", 150))


@given(diameters, angles)
def test_between_the_four_corners_of_a_grid_everything_is_inside(diameter: int, angle: int) -> None:
    grid = TrainingRange([PipeCorner.of(d, a) for d in (60, 120) for a in (45, 140)])
    assert grid.has(PipeCorner.of(diameter, angle))
    missing = TrainingRange([PipeCorner.of(d, a) for d, a in ((60, 140), (120, 45), (120, 140))])
    inside = missing.has(PipeCorner.of(diameter, angle))
    assert inside == (diameter == 120 or angle == 140)


def test_tees_are_a_range_of_their_own() -> None:
    tees = TrainingRange(parse_corners(["d=100,tee=90,way=into", "d=100,tee=60,way=into"]))
    assert tees.has(parse_corners(["d=100,tee=75,way=into"])[0])
    assert not tees.has(parse_corners(["d=100,tee=75,way=out"])[0])
    assert not tees.has(PipeCorner.of(100, 75))


def test_a_shipped_policy_knows_its_range_and_a_baseline_has_none() -> None:
    arm = TrainingRange.of(open_controller("arm"))
    assert arm is not None
    assert arm.has(PipeCorner.of(90, 90))
    assert not arm.has(PipeCorner.of(200, 90))
    assert TrainingRange.of(open_controller("baseline:centreline")) is None
    assert TrainingRange.of(None) is None
