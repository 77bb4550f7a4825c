"""Routes and sets of routes from TOML, shipped ones and a user's own."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import pytest

from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import corner_set_names, parse_corners
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_route, parse_routes, read_route, route_set_names
from pipenav.units import m_to_mm, rad_to_deg

ONE = """
schema = 1
diameter_mm = 100
[[corners]]
angle_deg = 90
turn = "left"
straight_mm = 500
[[corners]]
angle_deg = 75
turn = "right"
roll_deg = 90
"""
SET = """
schema = 1
description = "mine"
runs = 4
seed = 3
corners = 2
diameters_mm = [80, 90]
angles_deg = { start = 90, stop = 120, step = 10 }
straights_mm = [500]
ends_mm = 700
"""


def written(folder: Path, text: str) -> str:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("name", ["runs-level", "runs-rolled"])
def test_a_shipped_set_covers_the_working_range_in_routes_of_five_corners(name: str) -> None:
    routes = parse_routes([name])
    corners = [corner for route in routes for corner in route.corners]
    assert len(set(routes)) == 24 and {len(route.corners) for route in routes} == {5}
    assert Counter(round(m_to_mm(route.diameter)) for route in routes) == dict.fromkeys(range(70, 121, 10), 4)
    assert {round(rad_to_deg(corner.angle)) for corner in corners} == set(range(55, 126, 5))
    assert 0.4 < sum(corner.turn == "left" for corner in corners) / len(corners) < 0.6


@pytest.mark.slow
def test_the_routes_for_training_are_shorter_than_those_of_the_evaluations() -> None:
    sizes = {"runs-narrow-train": 200, "runs-train": 400, "runs-wide-train": 200, "runs-rolled-train": 400}
    runs = [name for name in route_set_names() if name.startswith("runs-")]
    assert runs == sorted(["runs-level", "runs-rolled", *sizes])
    for name, size in sizes.items():
        routes = parse_routes([name])
        assert len(set(routes)) == size and {len(route.corners) for route in routes} == {3}
        assert all(route.planar for route in routes) == ("rolled" not in name)
        assert not set(routes) & set(parse_routes(["runs-level", "runs-rolled"]))


@pytest.mark.slow
def test_the_rolled_routes_leave_room_for_the_whole_robot_between_two_corners() -> None:
    straights = {
        name: {x for route in parse_routes([name]) for x in route.straights[1:-1]} for name in route_set_names()
    }
    assert min(straights["runs-level"]) == 0.4 and max(straights["runs-level"]) == 0.8
    assert min(straights["runs-rolled"]) == 0.9 and max(straights["runs-rolled"]) == 1.3


def test_the_level_routes_stay_in_the_plane_and_the_rolled_ones_leave_it_by_quarter_turns() -> None:
    assert all(route.planar for route in parse_routes(["runs-level"]))
    assert all({corner.turn for corner in route.corners} >= {"left"} for route in parse_routes(["runs-level"])[:3])
    rolled = parse_routes(["runs-rolled"])
    assert not any(route.planar for route in rolled)
    assert {route.corners[0].roll for route in rolled} == {0.0}
    rolls = Counter(round(rad_to_deg(corner.roll)) for route in rolled for corner in route.corners[1:])
    assert set(rolls) == {0, 90, 180, 270} and min(rolls.values()) > 15


def test_sets_are_drawn_alike_every_time_and_otherwise_with_another_seed(tmp_path: Path) -> None:
    first = parse_routes([written(tmp_path, SET)])
    assert first == parse_routes([written(tmp_path, SET)])
    assert first != parse_routes([written(tmp_path, SET.replace("seed = 3", "seed = 4"))])
    assert [round(m_to_mm(route.diameter)) for route in first] == [80, 90, 80, 90]
    assert {route.straights for route in first} == {(0.7, 0.5, 0.7)}


def test_the_first_route_of_a_shipped_set_never_changes() -> None:
    """Measurements in a shipped set must stay comparable."""
    assert parse_routes(["runs-level:1"])[0].name == "run-d70-R65-L70-R100-R55-L110"
    assert parse_routes(["runs-rolled:24"])[0].name == "run-d120-L95-R110roll270-L95roll270-R110roll90-L75roll270"


def test_a_route_by_its_number() -> None:
    routes = parse_routes(["runs-level"])
    assert parse_routes(["runs-level:1", "runs-level:24"]) == [routes[0], routes[-1]]


def test_a_file_of_one_route(tmp_path: Path) -> None:
    route = PipeRoute.of(100, [(90, "left", 0), (75, "right", 90)], [None, 500, None])
    assert parse_routes([written(tmp_path, ONE)]) == [route] == [read_route(tmp_path / "mine.toml")]
    assert route.straights == (0.6, 0.5, 0.6)


def test_every_number_of_a_file_reaches_the_route(tmp_path: Path) -> None:
    text = ONE.replace("diameter_mm", "wall_mm = 5\nfirst_straight_mm = 900\ndescription = 'x'\ndiameter_mm")
    expected = PipeRoute.of(100, [(90, "left", 0), (75, "right", 90)], [900, 500, 750], 5)
    assert parse_routes([written(tmp_path, text + "straight_mm = 750")]) == [expected]


@pytest.mark.parametrize("text", ["d=90,angle=60,turn=right", "thesis-train"])
def test_corners_are_routes_of_one_corner(text: str) -> None:
    assert parse_routes([text]) == [PipeRoute.from_corner(pipe) for pipe in parse_corners([text])]


def test_a_file_of_pipes_is_a_set_of_routes_of_one_corner(tmp_path: Path) -> None:
    text = written(tmp_path, 'description = "x"\ndiameters_mm = [80]\nangles_deg = [60]')
    assert parse_routes([text]) == [PipeRoute.from_corner(PipeCorner.of(80, 60))]


def test_routes_keep_their_order_and_come_once() -> None:
    routes = parse_routes(["runs-rolled:2", "d=90,angle=60", "runs-rolled"])
    assert (
        len(routes) == 25
        and routes[1] == PipeRoute.from_corner(PipeCorner.of(90, 60))
        and routes[2] == parse_routes(["runs-rolled"])[0]
    )


def test_names_of_sets_are_distinct() -> None:
    assert not set(route_set_names()) & set(corner_set_names())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("runs-levle", "unknown set of pipes or routes 'runs-levle': did you mean 'runs-level'"),
        ("thesi", "unknown set of pipes or routes 'thesi': did you mean 'thesis'"),
        ("runs-level:0", "'runs-level:0' names no route of the set: write a number from 1 to 24 after the colon."),
        ("runs-level:x", "write a number from 1 to 24"),
        ("no-such.toml", "cannot read no-such.toml: No such file or directory; check its name."),
        ("d=90,angle=60,bend_radius=60", "bend radius of corner 1 (0 is a mitre), 60 mm, is out of range: choose 67.5"),
    ],
)
def test_what_is_no_route_is_named(text: str, message: str) -> None:
    with pytest.raises(PipenavError) as caught:
        parse_routes([text])
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ONE.replace("schema = 1", "schema = 4"), "schema: input should be 1, 2 or 3, given 4"),
        (ONE.replace("schema = 1", ""), "schema: this key is missing, add it"),
        (ONE.replace("diameter_mm", "diametre_mm"), "unknown key 'diametre_mm': did you mean 'diameter_mm'?"),
        (ONE + "rol_deg = 90", "unknown key 'corners.1.rol_deg': did you mean 'corners.1.roll_deg'"),
        (ONE + 'straight_mm = "long"', "corners.1.straight_mm: input should be a valid number"),
        (ONE.replace('turn = "right"', 'turn = "up"'), "mine.toml: turn 'up' is unknown: choose 'left' or 'right'."),
        (
            ONE.replace("angle_deg = 75", "angle_deg = 7"),
            "interior angle of corner 2, 7 deg, is out of range",
        ),
        (
            ONE.replace("straight_mm = 500", "straight_mm = 5"),
            "mine.toml: length of straight 2, 5 mm, is out of range: choose",
        ),
        ("schema = 1\ndiameter_mm = 100\ncorners = []", "corners: list should have at least 1 item"),
        (ONE + "to_diameter_mm = 80", "a reducer goes straight on: leave out angle_deg"),
        (ONE + "length_mm = 50", "a length_mm needs to_diameter_mm, which makes a reducer"),
        (ONE.replace("= 90", "= ninety"), "is not valid TOML"),
        (SET.replace("seed", "sed"), "unknown key 'sed': did you mean 'seed'?"),
        (SET.replace("seed = 3\n", ""), "seed: this key is missing, add it"),
        (SET.replace("runs = 4", "runs = 0"), "runs: input should be greater than or equal to 1"),
        (SET + "roll_deg = [0]", "unknown key 'roll_deg': did you mean 'rolls_deg'"),
        (SET.replace("[500]", "[50]"), "mine.toml: length of straight 2, 50 mm, is out of range"),
        (
            SET.replace("corners = 2", "corners = 5\nturns = ['left']").replace("120", "90"),
            "cross themselves: choose wider angles",
        ),
    ],
)
def test_a_wrong_file_is_explained(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(PipenavError) as caught:
        parse_routes([written(tmp_path, text)])
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_set_is_no_route(tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match="is not one route: give a file with a"):
        read_route(Path(written(tmp_path, SET)))


def test_quarter_rolls_of_a_file_are_exact(tmp_path: Path) -> None:
    assert read_route(Path(written(tmp_path, ONE))).corners[1].roll == math.pi / 2


def test_one_route_has_a_name(tmp_path: Path) -> None:
    assert parse_route(written(tmp_path, ONE)) == ("mine", read_route(tmp_path / "mine.toml"))
    assert parse_route("runs-level:3") == ("runs-level-3", parse_routes(["runs-level"])[2])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("runs-level", "runs-level is a set of routes: choose one of them by its number, as in runs-level:1."),
        ("runs-leve:3", "unknown route 'runs-leve:3': did you mean 'runs-level:1'"),
        ("d=90,angle=60", "unknown route 'd=90,angle=60': choose 'FILE.toml'"),
        ("runs-level:25", "write a number from 1 to 24"),
    ],
)
def test_what_is_not_one_route_is_named(text: str, message: str) -> None:
    with pytest.raises(PipenavError) as caught:
        parse_route(text)
    assert message in str(caught.value)


EVALUATED = {
    "tees-train": ["tees"],
    "town-train": ["town", "space-town"],
    "space-train": ["space-elbows", "space-tees", "space-reducers", "space-s-bends", "space-town"],
}
"""Sets to train in, and the sets beside them, in which policies are evaluated."""


@pytest.mark.parametrize("trained", EVALUATED)
def test_sets_to_train_in_share_no_fitting_with_the_evaluated_ones(trained: str) -> None:
    """A fitting is the same where its diameter, its angle and the number of its branches are."""

    def fittings(names: list[str]) -> set[tuple[float, float, int]]:
        return {
            (round(2 * radius, 9), round(corner.angle, 9), len(corner.branches))
            for route in parse_routes(names)
            for corner, radius in zip(route.corners, route.legs.radius.tolist(), strict=False)
            if not corner.reducer
        }

    assert not fittings([trained]) & fittings(EVALUATED[trained])


def test_no_set_to_train_in_has_a_pipe_of_another_set() -> None:
    frontier = [name for name in corner_set_names() if name.startswith("frontier-")]
    names = [*route_set_names(), "elbows", "elbows-train", "tees", "tees-train", *frontier]
    trained, evaluated = ([name for name in names if name.endswith("-train") == is_one] for is_one in (True, False))
    assert not set(parse_routes(trained)) & set(parse_routes(evaluated))


def test_no_pipe_near_a_frontier_is_in_another_set_of_corners() -> None:
    frontier = [name for name in corner_set_names() if name.startswith("frontier-")]
    near = {train: {name for name in frontier if name.endswith("-train") == train} for train in (True, False)}
    others = set(parse_routes([*({*corner_set_names()} - {*frontier})]))
    for names in near.values():
        assert names and not set(parse_routes(sorted(names))) & others


def test_a_town_has_the_proportions_of_a_real_one() -> None:
    """There 33 of 121 fittings are tees and 12 are corners sharper than 112 deg, 64 corners gentler than 157 deg."""
    corners = [corner for route in parse_routes(["town"]) for corner in route.corners]
    tees = [bool(corner.branches) for corner in corners]
    bends = [math.degrees(corner.angle) for corner in corners if not corner.branches]
    for count, real in ((sum(tees), 33), (sum(a < 112 for a in bends), 12), (sum(a > 157 for a in bends), 64)):
        assert count / len(corners) == pytest.approx(real / 121, abs=0.05)
    assert min(bends) >= 55


def test_routes_climb_by_the_slopes_of_their_set() -> None:
    slopes = {round(math.degrees(route.slope), 6) for route in parse_routes(["space-elbows"])}
    assert slopes <= {-90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0} and len(slopes) > 4
    steep = next(route for route in parse_routes(["space-elbows"]) if route.slope > 1.5)
    assert steep.down == pytest.approx([-1, 0, 0], abs=1e-12)
