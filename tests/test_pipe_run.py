"""The laws of runs of pipe, in the plane and in space."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.backends.wall_boxes import wall_boxes
from pipenav.errors import OutOfRange, PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import CrossesItself
from pipenav.pipes.route_corner import Corner

diameters = st.floats(40, 300)
angles = st.one_of(st.floats(30, 180), st.sampled_from([30.0, 55.0, 90.0, 180.0]))
turns = st.sampled_from(["left", "right"])
rolls = st.one_of(st.sampled_from([0.0, 90.0, 180.0, 270.0]), st.floats(-360, 360))
flat_rolls = st.sampled_from([0.0, 0.0, 180.0, -180.0, 360.0])


extras = st.one_of(st.integers(0, 100), st.integers(300, 2500))


@st.composite
def routes(
    draw: st.DrawFn,
    rolls: st.SearchStrategy[float] = rolls,
    extras: st.SearchStrategy[int] = extras,
    most: int = 5,
) -> PipeRoute:
    """Runs whose straights are as long as their mitres need, and some more [mm]."""
    diameter = draw(st.floats(40, 150))
    corners = draw(st.lists(st.tuples(angles, turns, rolls), min_size=1, max_size=most))
    reach = [0.0, *((diameter / 2 + 3) / math.tan(math.radians(angle) / 2) for angle, _, _ in corners), 0.0]
    needed = [math.ceil(a + b + 0.1 * diameter) for a, b in pairwise(reach)]
    straights = [least + draw(extras) for least in needed]
    try:
        return PipeRoute.of(diameter, corners, straights)
    except CrossesItself:
        assume(False)
        raise


planar_runs = routes(flat_rolls)
OVER_ITSELF = [(90, "left", 90), (90, "right", 0), (90, "left", -90), (90, "left", 0), (90, "left", 0)]
MIRROR = np.diag([1.0, -1.0, 1.0])


def inside(route: PipeRoute, seed: int = 0, count: int = 40) -> Floats:
    """Points in the bore of every leg, between its mitres, (legs, count, 3)."""
    rng = np.random.default_rng(seed)
    around, (off, share) = rng.uniform(0, 2 * math.pi, count), rng.uniform(0.001, 0.999, (2, count))
    lines = route.legs.lines(off * route.radius, around)
    return np.moveaxis(lines[:, :-1] + share[:, None, None] * np.diff(lines, axis=1), 1, 0)


@given(diameters, angles, turns)
def test_a_run_of_one_is_that_pipe(diameter: float, angle: float, turn: str) -> None:
    pipe = PipeCorner.of(diameter, angle, turn)
    route = PipeRoute.from_corner(pipe)
    left, right = pipe.walls if turn == "left" else pipe.walls[::-1]
    np.testing.assert_allclose(route.walls.left, left, atol=1e-12)
    np.testing.assert_allclose(route.walls.right, right, atol=1e-12)
    np.testing.assert_allclose(route.centre_line[:, :2], pipe.line(0.0), atol=1e-12)
    points = np.random.default_rng(1).uniform(-1.2, 1.2, (200, 2)) * pipe.leg
    points = points[pipe.contains(points)]
    np.testing.assert_allclose(route.along(points), pipe.distance_along(points), atol=1e-12)
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
def test_frames_of_a_chained_run_are_those_of_its_parts_composed(first: PipeRoute, second: PipeRoute) -> None:
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
def test_turning_every_corner_the_other_way_mirrors_the_run(route: PipeRoute, seed: int) -> None:
    other = {"left": "right", "right": "left"}
    corners = tuple(Corner(angle=c.angle, turn=other[c.turn], roll=-c.roll) for c in route.corners)
    mirrored = route.model_copy(update={"corners": corners})
    np.testing.assert_allclose(mirrored.centre_line, route.centre_line @ MIRROR, atol=1e-9)
    points = inside(route, seed)
    np.testing.assert_allclose(mirrored.along(points @ MIRROR), route.along(points), atol=1e-9)


@given(routes(), st.integers(0, 4))
def test_a_roll_by_180_deg_makes_the_other_turn(route: PipeRoute, which: int) -> None:
    i = which % len(route.corners)
    corners = [corner.model_dump() for corner in route.corners]
    corners[i]["turn"] = {"left": "right", "right": "left"}[corners[i]["turn"]]
    corners[i]["roll"] += math.pi
    if i + 1 < len(corners):  # whose plane is told from the one that was rolled
        corners[i + 1]["roll"] -= math.pi
    same = route.model_copy(update={"corners": tuple(Corner(**corner) for corner in corners)})
    np.testing.assert_allclose(same.centre_line, route.centre_line, atol=1e-9)
    assert same.planar == route.planar


@given(routes(), st.integers(0, 9))
def test_along_rises_along_lines_that_keep_the_inside_and_is_the_distance_on_the_centre_line(
    route: PipeRoute, seed: int
) -> None:
    distances = np.sort(np.random.default_rng(seed).uniform(route.distances[0], route.distances[-1], 300))
    on_line = np.stack([np.interp(distances, route.distances, line) for line in route.centre_line.T], axis=1)
    np.testing.assert_allclose(route.along(on_line), distances, atol=1e-9)
    line = route.legs.lines(0.9 * route.radius, np.array([seed]))[0]
    share = np.linspace(0, len(line) - 1, 400)
    walked = np.stack([np.interp(share, np.arange(len(line)), x) for x in line.T], axis=1)
    assert (np.diff(route.along(walked)) >= -1e-9).all()


@given(routes())
def test_along_goes_on_past_the_open_ends(route: PipeRoute) -> None:
    before = route.centre_line[0] - 0.1 * route.frames.rotation[0][:, 0]
    after = route.centre_line[-1] + 0.1 * route.frames.rotation[-1][:, 0]
    assume(route.leg_of(np.stack([before, after])).tolist() == [0, len(route.corners)])  # no other leg is nearer
    assert not route.contains(np.stack([before, after])).any()
    assert route.along(np.stack([before, after])) == pytest.approx(
        [route.distances[0] - 0.1, route.distances[-1] + 0.1]
    )


def test_a_point_in_a_mitre_counts_to_the_leg_before() -> None:
    route = PipeRoute.of(100, [(90, "left", 0)])
    mitre = np.array([[0.02, -0.02], [0.0, 0.0], [-0.02, 0.02]])
    assert route.leg_of(mitre).tolist() == [0, 0, 0]
    assert route.along(mitre) == pytest.approx([0.0, 0.0, -0.02])
    assert route.along(mitre + np.array([0.0, 1e-9])) == pytest.approx([0.0, 0.0, 0.02], abs=1e-8)


@given(routes(), st.integers(0, 9))
def test_points_of_a_leg_are_inside_and_belong_to_it(route: PipeRoute, seed: int) -> None:
    points = inside(route, seed)
    assert route.contains(points).all()
    leg = np.broadcast_to(np.arange(len(points))[:, None], points.shape[:2])
    np.testing.assert_array_equal(route.leg_of(points), leg)
    local = route.to_leg(points, leg)
    origin, rotation = route.frames
    np.testing.assert_allclose((rotation[leg] @ local[..., None])[..., 0] + origin[leg], points, atol=1e-9)


def test_points_in_a_bore_belong_to_it_even_where_another_legs_open_end_points_at_them() -> None:
    route = PipeRoute.of(108, [(110, "left", 0), (110, "left", 0), (30, "left", 0)], [137, 92, 317, 224])
    points = np.array([[-0.0874, 0.0539], [-0.06, 0.05]])
    assert route.leg_of(points).tolist() == [0, 0] and route.contains(points).all()


@given(routes(), st.integers(0, 9))
def test_points_of_the_wall_are_outside(route: PipeRoute, seed: int) -> None:
    rng = np.random.default_rng(seed)
    lines = route.legs.lines(route.radius + 0.5 * route.wall, rng.uniform(0, 2 * math.pi, 20))
    assert not route.contains(lines[:, :-1] + rng.uniform(size=(20, 1, 1)) * np.diff(lines, axis=1)).any()


@given(planar_runs)
def test_a_planar_runs_segments_have_free_space_on_their_left_only(route: PipeRoute) -> None:
    step = route.segments[:, 1] - route.segments[:, 0]
    left = np.stack([-step[:, 1], step[:, 0]], axis=1) / np.linalg.norm(step, axis=1, keepdims=True)
    middle = route.segments.mean(axis=1)
    assert route.contains(middle + 1e-6 * left).all()
    assert not route.contains(middle - 1e-6 * left).any()


@given(planar_runs)
def test_edges_are_where_the_wall_bends_away_from_the_free_space(route: PipeRoute) -> None:
    for wall, edges in zip(np.split(route.segments, 2), np.split(route.edges, 2), strict=True):
        step = wall[:, 1] - wall[:, 0]
        step /= np.linalg.norm(step, axis=1, keepdims=True)
        bend = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]  # positive: to the left, towards the free space
        for at_end, at_start, turning in zip(edges[:-1, 1], edges[1:, 0], bend, strict=True):
            assert at_end == at_start
            assert at_end == (turning < 0) or abs(turning) < 1e-6


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
def test_only_planar_runs_have_walls_in_the_plane(route: PipeRoute) -> None:
    rolled = any(abs(math.sin(corner.roll)) > 1e-9 for corner in route.corners)
    assert route.planar == (not rolled)
    if rolled:
        with pytest.raises(PipenavError, match="leaves the plane"):
            _ = route.walls
    else:
        assert np.abs(route.centre_line[:, 2]).max() < 1e-9


@given(routes(), st.floats(0.0, 1.0), st.floats(0, 6.28))
@settings(max_examples=50)
def test_legs_that_are_no_neighbours_never_share_a_point(route: PipeRoute, share: float, around: float) -> None:
    line = route.legs.lines(share * route.radius, np.array([around]))[0]
    samples = line[:-1, None] + np.linspace(0, 1, 50)[1:-1, None] * np.diff(line, axis=0)[:, None]
    np.testing.assert_array_equal(
        route.leg_of(samples), np.broadcast_to(np.arange(len(samples))[:, None], (len(samples), 48))
    )


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
def test_runs_that_cross_themselves_are_refused(
    corners: list[tuple[float, str, float]], straights: list[float], crossing: str | None
) -> None:
    if crossing is None:
        PipeRoute.of(100, corners, straights)
        return
    with pytest.raises(PipenavError, match=f"crosses itself: straights {crossing} would meet"):
        PipeRoute.of(100, corners, straights)


def test_runs_of_the_same_numbers_are_equal_and_arrays_are_read_only() -> None:
    corners = [(90, "left", 0), (75, "right", 0)]
    route = PipeRoute.of(100, corners)
    assert route == PipeRoute.of(100, corners) and hash(route) == hash(PipeRoute.of(100, corners))
    assert route != PipeRoute.of(100, [(90, "left", 0), (75, "left", 180)])
    for array in (*route.walls, route.segments, *route.frames, *route.legs):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_names_and_labels_tell_runs_apart() -> None:
    route = PipeRoute.of(100, [(90, "left", 0), (62.5, "right", 90)])
    assert route.name == "run-d100-L90-R62.5roll90"
    assert route.label == "100 mm, 90 deg left, 62.5 deg right rolled 90 deg"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((39, [(90, "left", 0)]), "diameter 39 mm is out of range: choose 40 to 300 mm."),
        (
            (100, [(90, "left", 0), (20, "left", 0)]),
            "interior angle of corner 2 20 deg is out of range: choose 30 to 180",
        ),
        ((100, [(90, "left", 400)]), "roll of corner 1 400 deg is out of range: choose -360 to 360 deg."),
        ((100, [(90, "left", math.nan)]), "roll of corner 1 nan deg is out of range"),
        ((100, [(90, "up", 0)]), "turn 'up' is unknown: choose 'left' or 'right'."),
        ((100, []), "a route of 0 corners is not possible: give it 1 to 50."),
        ((100, [(90, "left", 0)] * 51), "a route of 51 corners is not possible: give it 1 to 50."),
        ((100, [(90, "left", 0)], [500]), "1 straights do not fit 1 corners: give one before each"),
        (
            (100, [(90, "left", 0)] * 2, [600, 115, 600]),
            "length of straight 2 115 mm is out of range: choose 116 to 20000",
        ),
        ((100, [(90, "left", 0), (90, "right", 0)], [600, 9, 600]), "choose 10 to 20000 mm."),
        ((100, [(90, "left", 0)], [600, math.inf]), "length of straight 2 inf mm is out of range"),
        ((100, [(90, "left", 0)], [600, 600], 0), "wall thickness 0 mm is out of range: choose 0.5 to 50 mm."),
    ],
)
def test_messages_name_what_is_allowed(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(PipenavError) as caught:
        PipeRoute.of(*arguments)
    assert message in str(caught.value)


def test_bends_are_no_corners_of_a_run() -> None:
    with pytest.raises(PipenavError, match="has a bend radius: the corners of a route are mitres"):
        PipeRoute.from_corner(PipeCorner.of(100, 90, "left", 150))


def test_the_model_itself_refuses_what_is_out_of_range() -> None:
    with pytest.raises(OutOfRange, match="length of straight 1 10 mm"):
        PipeRoute(diameter=0.1, corners=(Corner(angle=1.2),), straights=(0.01, 1.0))
