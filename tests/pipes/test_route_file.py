"""Routes with tees, crosses and caps as TOML: `[[corners.branches]]`, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.random_networks import random_routes
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import ConfigError
from pipenav.pipes.branch import Branch
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner
from pipenav.pipes.route_file import read_route


def as_toml(route: PipeRoute) -> str:
    """A route as the file that people write."""
    lines = ["schema = 3", f"diameter_mm = {1e3 * route.diameter!r}", f"wall_mm = {1e3 * route.wall!r}"]
    lines += [f"first_straight_mm = {1e3 * route.straights[0]!r}", f"capped = {json.dumps(route.capped)}"]
    lines += [f"slope_deg = {float(np.degrees(route.slope))!r}"]
    for corner, straight in zip(route.corners, route.straights[1:], strict=True):
        lines += ["[[corners]]", f"straight_mm = {1e3 * straight!r}", *_lines(_corner(corner))]
        for branch in corner.branches:
            lines += ["[[corners.branches]]", *_lines(_branch(branch))]
    return "\n".join(lines)


def _corner(corner: Corner) -> dict[str, Any]:
    turn = {"angle_deg": float(np.degrees(corner.angle)), "turn": corner.turn, "roll_deg": np.degrees(corner.roll)}
    to = {} if corner.to_diameter is None else {"to_diameter_mm": 1e3 * corner.to_diameter}
    if corner.reducer:
        return to | {"length_mm": 1e3 * corner.length}
    return turn | to | ({"bend_radius_mm": 1e3 * corner.bend_radius} if corner.bend_radius else {})


def _branch(branch: Branch) -> dict[str, Any]:
    return {
        "angle_deg": np.degrees(branch.angle),
        "turn": branch.turn,
        "roll_deg": np.degrees(branch.roll),
        "diameter_mm": 1e3 * branch.diameter,
        "length_mm": 1e3 * branch.length,
        "capped": branch.closed,
    }


def _lines(table: dict[str, Any]) -> list[str]:
    return [f"{key} = {json.dumps(value)}" for key, value in table.items()]


@given(st.integers(0, 2**31 - 1))
@settings(max_examples=25, deadline=None)
def test_routes_are_read_as_they_were(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    file = tmp_path_factory.mktemp("route") / "route.toml"
    for route in random_routes(seed):
        file.write_text(as_toml(route))
        read = read_route(file)
        assert (read.label, read.capped) == (route.label, route.capped)
        np.testing.assert_allclose(read.centre_line, route.centre_line, atol=1e-9)
        np.testing.assert_allclose(read.branches.axes, route.branches.axes, atol=1e-9)
        np.testing.assert_allclose(read.branches.length, route.branches.length)
        assert read.branches.closed.tolist() == route.branches.closed.tolist()


TEE = """schema = 3
diameter_mm = 100
[[corners]]
[[corners.branches]]
angle_deg = 90
"""


def test_a_tee_needs_no_more_than_an_angle(tmp_path: Path) -> None:
    (tmp_path / "tee.toml").write_text(TEE)
    route = read_route(tmp_path / "tee.toml")
    (branch,) = route.corners[0].branches
    assert route.corners[0].straight_on and (branch.turn, branch.diameter, branch.closed) == ("left", 0.1, False)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("schema = 3", "schema = 4", "schema: input should be 1, 2 or 3, given 4"),
        ("angle_deg = 90", "angle_deg = nan", "angle of a branch at corner 1, nan deg, is out of range: choose 30"),
        ("angle_deg = 90", "angle_deg = 20", "angle of a branch at corner 1, 20 deg, is out of range: choose 30"),
        ("angle_deg = 90", "angle_deg = 90\nturn = 'up'", "turn 'up' is unknown: choose 'left' or 'right'"),
        ("angle_deg = 90", "angle_deg = 90\nlength_mm = 0", "length_mm: input should be greater than 0"),
        ("angle_deg = 90", "angle_deg = 90\nlength_mm = 1e300", "length of a branch at corner 1, 1e.300 mm, is out"),
        ("angle_deg = 90", "angle_deg = 90\ndiameter_mm = 120", r"\(at most its run's\), 120 mm, is out of range"),
        ("angle_deg = 90", "angle_deg = 90\nend = 'open'", "unknown key 'corners.0.branches.0.end'"),
        ("angle_deg = 90", "turn = 'left'", "corners.0.branches.0.angle_deg: this key is missing"),
        ("diameter_mm = 100", "diameter_mm = nan", "diameter nan mm is out of range: choose 40 to 300 mm"),
        ("diameter_mm = 100", "diameter_mm = 1e300", r"diameter 1e\+300 mm is out of range"),
        ("[[corners]]", "[[corners]]\nbend_radius_mm = 150", "a tee or cross has neither: leave out bend_radius_mm"),
        ("[[corners]]", "[[corners]]\nangle_deg = 90", "give angle_deg and turn, or neither to go straight on"),
    ],
)
def test_what_is_no_tee_is_refused_in_one_sentence(tmp_path: Path, old: str, new: str, message: str) -> None:
    file = tmp_path / "tee.toml"
    file.write_text(TEE.replace(old, new))
    with pytest.raises(ConfigError, match=message) as caught:
        read_route(file)
    assert str(caught.value).startswith(str(file)) and "\n" not in str(caught.value)
