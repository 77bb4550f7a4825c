"""The laws of routes, in the plane and in space, and of their walls in the plane."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.random_routes import angles, diameters, flat_rolls, inside, routes, turns
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.backends.wall_boxes import wall_boxes
from pipenav.errors import OutOfRange, PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner

OVER_ITSELF = [(90, "left", 90), (90, "right", 0), (90, "left", -90), (90, "left", 0), (90, "left", 0)]
MIRROR = np.diag([1.0, -1.0, 1.0])


@given(routes())
def test_frames_follow_the_centre_line_and_are_rotations(route: PipeRoute) -> None:
    origin, rotation = route.frames
    np.testing.assert_allclose(
        rotation @ rotation.transpose(0, 2, 1), np.tile(np.eye(3), (len(origin), 1, 1)), atol=1e-12
    )
    assert np.linalg.det(rotation) == pytest.approx(1)
    np.testing.assert_allclose(origin[1], 0, atol=1e-12)
    ends = origin + np.array(route.straights)[:, None] * rotation[:, :, 0]
    np.testing.assert_allclose(ends[:-1], origin[1:], atol=1e-9)
    np.testing.assert_allclose(route.centre_line, [*origin, ends[-1]], atol=1e-9)
    assert route.distances == pytest.approx(np.cumsum([-route.straights[0], *route.straights]))


@given(routes())
def test_every_corner_bends_in_its_own_plane_by_its_angle(route: PipeRoute) -> None:
    rotation = route.frames.rotation
    for before, after, corner in zip(rotation, rotation[1:], route.corners, strict=False):
        c, s = math.cos(corner.roll), math.sin(corner.roll)
        turn_sign = 1 if corner.turn == "left" else -1
        to_inside = turn_sign * (c * before[:, 1] + s * before[:, 2])
        expected = -math.cos(corner.angle) * before[:, 0] + math.sin(corner.angle) * to_inside
        np.testing.assert_allclose(after[:, 0], expected, atol=1e-12)
        np.testing.assert_allclose(after[:, 2], c * before[:, 2] - s * before[:, 1], atol=1e-12)


@given(routes(), routes(most=3))
@settings(max_examples=40)
def test_frames_of_a_chained_route_are_those_of_its_parts_composed(first: PipeRoute, second: PipeRoute) -> None:
    corners, straights = first.corners + second.corners, first.straights[:-1] + second.straights
    try:
        chained = PipeRoute(diameter=0.04, corners=corners, straights=straights)
    except PipenavError:
        assume(False)
    turn = first.frames.rotation[-1]
    n = len(first.corners)
    np.testing.assert_allclose(chained.frames.rotation[: n + 1], first.frames.rotation, atol=1e-12)
    np.testing.assert_allclose(chained.frames.rotation[n:], turn @ second.frames.rotation, atol=1e-9)
    shift = chained.frames.origin[n + 1] - turn @ second.frames.origin[1]
    np.testing.assert_allclose(chained.frames.origin[n:], second.frames.origin @ turn.T + shift, atol=1e-9)


@given(routes(), st.integers(0, 9))
def test_turning_every_corner_to_the_other_side_mirrors_the_route(route: PipeRoute, seed: int) -> None:
    other = {"left": "right", "right": "left"}
    corners = tuple(Corner(angle=c.angle, turn=other[c.turn], roll=-c.roll) for c in route.corners)
    mirrored = route.model_copy(update={"corners": corners})
    np.testing.assert_allclose(mirrored.centre_line, route.centre_line @ MIRROR, atol=1e-9)
    points = inside(route, seed)
    np.testing.assert_allclose(mirrored.distance_along(points @ MIRROR), route.distance_along(points), atol=1e-9)


@pytest.mark.slow
@given(routes(), st.integers(0, 4))
def test_a_roll_by_180_deg_makes_the_other_turn(route: PipeRoute, which: int) -> None:
    i = which % len(route.corners)
    corners = [corner.model_dump() for corner in route.corners]
    corners[i]["turn"] = {"left": "right", "right": "left"}[corners[i]["turn"]]
    corners[i]["roll"] += math.pi
    if i + 1 < len(corners):  # whose plane counts from the one that was rolled
        corners[i + 1]["roll"] -= math.pi
    same = route.model_copy(update={"corners": tuple(Corner(**corner) for corner in corners)})
    np.testing.assert_allclose(same.centre_line, route.centre_line, atol=1e-9)
    assert same.planar == route.planar


@pytest.mark.parametrize(
    ("corners", "straights", "crossing"),
    [
        ([(60, "left", 0), (60, "left", 0)], [1000, 500, 1000], "1 and 3"),
        ([(60, "left", 0), (60, "left", 0)], [1000, 500, 300], None),
        ([(60, "left", 0), (60, "right", 0)], [1000, 500, 1000], None),
        ([(90, "left", 0)] * 3, [1000, 400, 400, 1000], "1 and 4"),
        ([(90, "left", 0)] * 3, [1000, 400, 500, 250], None),
        ([(90, "left", 0), (90, "left", 0), (90, "left", 90)], [1000, 400, 400, 1000], None),
        ([(90, "left", 0)] * 2, [1000, 120, 1000], None),
        (OVER_ITSELF, [1000, 125, 400, 400, 800, 1000], "1 and 6"),
        (OVER_ITSELF, [1000, 130, 400, 400, 800, 1000], None),
    ],
)
def test_routes_that_cross_themselves_are_refused(
    corners: list[tuple[float, str, float]], straights: list[float], crossing: str | None
) -> None:
    if crossing is None:
        PipeRoute.of(100, corners, straights)
        return
    with pytest.raises(PipenavError, match=f"crosses itself: straights {crossing} would touch"):
        PipeRoute.of(100, corners, straights)


def test_routes_of_the_same_numbers_are_equal_and_arrays_are_read_only() -> None:
    corners = [(90, "left", 0), (75, "right", 0)]
    route = PipeRoute.of(100, corners)
    assert route == PipeRoute.of(100, corners) and hash(route) == hash(PipeRoute.of(100, corners))
    assert route != PipeRoute.of(100, [(90, "left", 0), (75, "left", 180)])
    for array in (*(side.face for side in route.wall_sides), route.segments, *route.frames, *route.legs):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_names_and_labels_distinguish_routes() -> None:
    route = PipeRoute.of(100, [(90, "left", 0), (62.5, "right", 90)])
    assert route.name == "run-d100-L90-R62.5roll90"
    assert route.label == "100 mm, 90 deg left, 62.5 deg right rolled 90 deg"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((39, [(90, "left", 0)]), "diameter 39 mm is out of range: choose 40 to 300 mm."),
        (
            (100, [(90, "left", 0), (20, "left", 0)]),
            "interior angle of corner 2, 20 deg, is out of range: choose 30 to 180",
        ),
        ((100, [(90, "left", 400)]), "roll of corner 1, 400 deg, is out of range: choose -360 to 360 deg."),
        ((100, [(90, "left", math.nan)]), "roll of corner 1, nan deg, is out of range"),
        (
            (100, [(90, "left", 0, 74)]),
            "bend radius of corner 1 (0 is a mitre), 74 mm, is out of range: choose 75",
        ),
        ((100, [(90, "left", 0, -1)]), "bend radius of corner 1 (0 is a mitre), -1 mm, is out of range"),
        ((100, [(90, "left", 0, 150)], [600, 159]), "length of straight 2, 159 mm, is out of range: choose 160 to"),
        ((100, [(90, "up", 0)]), "turn 'up' is unknown: choose 'left' or 'right'."),
        ((100, []), "a route of 0 corners is not possible: give it 1 to 50."),
        ((100, [(90, "left", 0)] * 51), "a route of 51 corners is not possible: give it 1 to 50."),
        ((100, [(90, "left", 0)], [500]), "1 straights do not fit 1 corners: give one before each"),
        (
            (100, [(90, "left", 0)] * 2, [600, 115, 600]),
            "length of straight 2, 115 mm, is out of range: choose 116 to 20000",
        ),
        ((100, [(90, "left", 0), (90, "right", 0)], [600, 9, 600]), "choose 10 to 20000 mm."),
        ((100, [(90, "left", 0)], [600, math.inf]), "length of straight 2, inf mm, is out of range"),
        ((100, [(90, "left", 0)], [600, 600], 0), "wall thickness 0 mm is out of range: choose 0.5 to 50 mm."),
    ],
)
def test_messages_name_what_is_allowed(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(PipenavError) as caught:
        PipeRoute.of(*arguments)
    assert message in str(caught.value)


def test_the_model_itself_refuses_what_is_out_of_range() -> None:
    with pytest.raises(OutOfRange, match="length of straight 1, 10 mm"):
        PipeRoute(diameter=0.1, corners=(Corner(angle=1.2),), straights=(0.01, 1.0))


@given(diameters, angles, turns)
def test_a_route_of_one_corner_is_that_corner(diameter: float, angle: float, turn: str) -> None:
    pipe = PipeCorner.of(diameter, angle, turn)
    route = PipeRoute.from_corner(pipe)
    left, right = pipe.walls if turn == "left" else pipe.walls[::-1]
    np.testing.assert_allclose(route.wall_sides[0].face, left, atol=1e-12)
    np.testing.assert_allclose(route.wall_sides[1].face, right, atol=1e-12)
    np.testing.assert_allclose(route.centre_line[:, :2], pipe.line(0.0), atol=1e-12)
    points = np.random.default_rng(1).uniform(-1.2, 1.2, (200, 2)) * pipe.leg
    points = points[pipe.contains(points)]
    np.testing.assert_allclose(route.distance_along(points), pipe.distance_along(points), atol=1e-12)
    # Sorted by their middles, a pipe and a run list the same walls, with the same thick and thin boxes behind them.
    if angle > 179.9:  # where a run knows no inner side
        return
    for boxes in zip(*(_sorted_boxes(it) for it in (pipe, route)), strict=True):
        np.testing.assert_allclose(*boxes, atol=1e-9)


def _sorted_boxes(pipe: PipeCorner | PipeRoute) -> Floats:
    boxes = wall_boxes([pipe], 4, np.zeros(1))
    turned = np.sign(boxes.quaternion[0][:, :1]) * boxes.quaternion[0]
    rows = np.concatenate([boxes.position[0], np.abs(turned), boxes.half_size[0]], axis=1)
    return rows[np.lexsort(np.round(rows[:, :2], 6).T)]


@given(routes(flat_rolls, st.integers(300, 2500), most=3))
@settings(max_examples=50)
def test_no_wall_box_reaches_into_free_space_farther_than_the_thin_ones_do(route: PipeRoute) -> None:
    boxes = wall_boxes([route], len(route.segments), np.zeros(1))
    grid = np.stack(np.meshgrid(*[np.linspace(-1, 1, 9)] * 2), axis=-1).reshape(-1, 2)
    yaw = 2 * np.arctan2(boxes.quaternion[0, :, 3], boxes.quaternion[0, :, 0])
    along = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    local = grid * boxes.half_size[0][:, None, :2]  # (s, 81, 2)
    points = boxes.position[0][:, None, :2] + local[..., :1] * along[:, None] + local[..., 1:] * across[:, None]
    narrow = route.model_copy(update={"diameter": route.diameter - 3e-4})
    assert not narrow.contains(points).any()


@given(routes())
def test_only_planar_routes_have_walls_in_the_plane(route: PipeRoute) -> None:
    rolled = any(abs(math.sin(corner.roll)) > 1e-9 for corner in route.corners)
    assert route.planar == (not rolled)
    if rolled:
        with pytest.raises(PipenavError, match="leaves the plane"):
            _ = route.walls
    else:
        assert np.abs(route.centre_line[:, 2]).max() < 1e-9
