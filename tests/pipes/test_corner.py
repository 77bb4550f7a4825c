"""The laws of pipe geometry, over the whole range of pipes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.errors import OutOfRange, PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_lines import ARC_TOLERANCE

diameters = st.floats(40, 300)
angles = st.one_of(st.floats(30, 180), st.sampled_from([30.0, 55.0, 90.0, 179.999, 180.0]))
bends = st.one_of(st.floats(0, 500), st.sampled_from([0.0, 1e-4, 20.0, 50.0, 150.0]))
turns = st.sampled_from(["left", "right"])
pipes = st.builds(PipeCorner.of, diameters, angles, turns, bends)


@given(pipes)
def test_walls_are_a_diameter_apart_in_both_legs(pipe: PipeCorner) -> None:
    inner, outer = pipe.walls
    assert np.linalg.norm(inner[0] - outer[0]) == pytest.approx(pipe.diameter)
    assert np.linalg.norm(inner[-1] - outer[-1]) == pytest.approx(pipe.diameter)
    for wall, offset in ((inner, pipe.turn_sign * pipe.radius), (outer, -pipe.turn_sign * pipe.radius)):
        assert wall[:2, 1] == pytest.approx(offset)
        assert pipe.along_second_leg(wall[-2:])[:, 1] == pytest.approx(offset, abs=1e-9)


@given(pipes)
def test_legs_have_their_length_and_the_second_one_its_heading(pipe: PipeCorner) -> None:
    line = pipe.line(0.0)
    assert line[0] == pytest.approx([-pipe.leg, 0.0])
    assert line[-1] == pytest.approx(pipe.leg * pipe.second_leg)
    assert math.acos(np.clip(pipe.second_leg @ [-1.0, 0.0], -1, 1)) == pytest.approx(pipe.angle, abs=1e-7)
    assert pipe.second_leg[1] * pipe.turn_sign >= -1e-12


@given(diameters, angles, bends)
def test_a_right_turn_mirrors_a_left_one(diameter: float, angle: float, bend: float) -> None:
    left, right = (PipeCorner.of(diameter, angle, turn, bend) for turn in ("left", "right"))
    for ours, theirs in zip(left.walls, right.walls, strict=True):
        np.testing.assert_array_equal(ours * [1, -1], theirs)
    assert left.gap == right.gap and left.inner_edge == right.inner_edge
    assert left.heading_change == -right.heading_change


@given(pipes)
def test_segments_have_free_space_on_their_left_only(pipe: PipeCorner) -> None:
    step = pipe.segments[:, 1] - pipe.segments[:, 0]
    assert (np.linalg.norm(step, axis=1) > 0).all()
    left = np.stack([-step[:, 1], step[:, 0]], axis=1) / np.linalg.norm(step, axis=1, keepdims=True)
    middle = pipe.segments.mean(axis=1)
    near = 1e-6
    assert pipe.contains(middle + near * left).all()
    assert not pipe.contains(middle - near * left).any()


@given(pipes, st.floats(-0.9999, 0.9999), st.integers(0, 10**6))
def test_lines_between_the_walls_are_inside(pipe: PipeCorner, share: float, seed: int) -> None:
    line = pipe.line(share * (pipe.radius - 2 * ARC_TOLERANCE))
    where = np.random.default_rng(seed).uniform(0.001, 0.999, (20, 1))
    i = np.random.default_rng(seed).integers(0, len(line) - 1, 20)
    assert pipe.contains(line[i] + where * (line[i + 1] - line[i])).all()


@given(pipes)
def test_beyond_the_walls_and_the_open_ends_is_outside(pipe: PipeCorner) -> None:
    beyond = pipe.radius + pipe.wall / 2
    # A chord of the outer line may cut its own wall's corner of metal, so look at its points alone.
    for offset in (beyond, -beyond):
        assert not pipe.contains(pipe.line(offset)).any()
    assert not pipe.contains(np.array([[-pipe.leg - 1e-6, 0.0]])).any()
    assert not pipe.contains(((pipe.leg + 1e-6) * pipe.second_leg)[None]).any()


@given(pipes)
def test_arcs_are_within_tolerance_of_their_chords(pipe: PipeCorner) -> None:
    for offset in (pipe.radius, 0.0, -pipe.radius):
        crude, fine = pipe.line(offset), pipe.line(offset, arc_segments=301)
        far = max(np.min(_distance_to_segments(point, crude)) for point in fine[::10])
        assert far < 1.01 * ARC_TOLERANCE


def _distance_to_segments(point: np.ndarray, line: np.ndarray) -> np.ndarray:
    start, step = line[:-1], np.diff(line, axis=0)
    share = np.clip(np.sum((point - start) * step, axis=1) / np.sum(step**2, axis=1), 0, 1)
    return np.linalg.norm(start + share[:, None] * step - point, axis=1)


@given(pipes)
def test_gap_lies_between_the_walls_on_the_bisector(pipe: PipeCorner) -> None:
    bisector = np.array([-math.cos(pipe.angle / 2), pipe.turn_sign * math.sin(pipe.angle / 2)])
    inner, outer = pipe.apex(pipe.radius), pipe.apex(-pipe.radius)
    clear = 2 * ARC_TOLERANCE  # an outer arc's chords lie a little inside it
    assert pipe.contains(np.array([(inner - 1e-6) * bisector, (outer + clear) * bisector])).all()
    assert not pipe.contains(np.array([(inner + clear) * bisector, (outer - 1e-6) * bisector])).any()
    assert pipe.gap >= pipe.diameter - 1e-12


@given(diameters, st.floats(30, 180))
def test_gap_and_inner_edge_of_a_mitre(diameter: float, angle: float) -> None:
    pipe = PipeCorner.of(diameter, angle)
    assert pipe.gap == pytest.approx(pipe.diameter / math.sin(pipe.angle / 2))
    assert pipe.inner_edge == pytest.approx(pipe.radius / math.tan(pipe.angle / 2))
    assert pipe.walls.inner[1] == pytest.approx([-pipe.inner_edge, pipe.radius])


@given(pipes)
def test_centre_line_distance_is_signed_distance_from_the_corner(pipe: PipeCorner) -> None:
    points = np.array([[-0.9 * pipe.leg, 0.0], [0.0, 0.0], 0.9 * pipe.leg * pipe.second_leg])
    assert pipe.distance_along(points) == pytest.approx([-0.9 * pipe.leg, 0.0, 0.9 * pipe.leg], abs=1e-9)


def test_contains_keeps_the_shape_of_its_points() -> None:
    pipe = PipeCorner.of(100, 75)
    assert pipe.contains(np.zeros((3, 4, 2))).shape == (3, 4)
    assert pipe.contains(np.zeros(2)).shape == ()


def test_pipes_are_equal_and_copies_have_their_own_walls() -> None:
    pipe = PipeCorner.of(100, 75)
    assert len(pipe.segments) == 4
    assert pipe == PipeCorner.of(100, 75) and hash(pipe) == hash(PipeCorner.of(100, 75))
    right = pipe.model_copy(update={"turn": "right"})
    assert right != pipe and right.walls.inner[0, 1] == -0.05


def test_walls_cannot_be_changed_in_place() -> None:
    pipe = PipeCorner.of(100, 75)
    for array in (*pipe.walls, pipe.segments):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_names_tell_pipes_apart() -> None:
    assert PipeCorner.of(100, 75).name == "corner-d100-a75-left"
    assert PipeCorner.of(62.5, 90, "right", 150).name == "corner-d62.5-a90-r150-right"
    assert PipeCorner.of(100, 75).label == "100 mm, 75 deg, left"


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"diameter_mm": 39}, "diameter 39 mm is out of range: choose 40 to 300 mm."),
        ({"diameter_mm": math.nan}, "diameter nan mm is out of range: choose 40 to 300 mm."),
        ({"angle_deg": 181}, "interior angle 181 deg is out of range: choose 30 to 180 deg."),
        ({"angle_deg": 0}, "interior angle 0 deg is out of range: choose 30 to 180 deg."),
        ({"bend_radius_mm": -1}, "bend radius -1 mm is out of range: choose 0 to 3000 mm."),
        ({"wall_mm": 0}, "wall thickness 0 mm is out of range: choose 0.5 to 50 mm."),
        ({"leg_mm": 79}, "leg length 79 mm is out of range: choose 80 to 20000 mm."),
        ({"leg_mm": math.inf}, "leg length inf mm is out of range: choose 80 to 20000 mm."),
        ({"turn": "up"}, "turn 'up' is unknown: choose 'left' or 'right'."),
    ],
)
def test_messages_name_what_is_allowed(numbers: dict[str, object], message: str) -> None:
    with pytest.raises(PipenavError) as caught:
        PipeCorner.of(**{"diameter_mm": 100, "angle_deg": 75, **numbers})
    assert str(caught.value) == message


def test_the_model_itself_refuses_what_is_out_of_range() -> None:
    with pytest.raises(OutOfRange, match="leg length 10 mm"):
        PipeCorner(diameter=0.1, angle=1.2, leg=0.01)


@given(diameters, angles, bends)
def test_a_default_leg_is_whole_centimetres_and_may_be_typed(diameter: float, angle: float, bend: float) -> None:
    pipe = PipeCorner.of(diameter, angle, "left", bend)
    assert pipe.leg >= 0.6 and pipe.leg * 100 == pytest.approx(round(pipe.leg * 100))
    assert PipeCorner.of(diameter, angle, "left", bend, leg_mm=round(pipe.leg * 1000)).leg == pipe.leg
