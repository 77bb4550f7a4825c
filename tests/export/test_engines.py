"""Exported pipes are hollow in every engine that loads them, and can be included in models of others."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from helpers.engines import CONTACTS, contacts_of_free_body
from helpers.random_routes import along_centre

from pipenav.arrays import Floats
from pipenav.export.corner_folder import write_pipe_folder
from pipenav.export.route_folder import write_route_folder
from pipenav.pipes.branch import Branch
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner, corner_of, reducer_corner
from pipenav.pipes.route_ends import RouteEnds
from pipenav.pipes.route_sets import parse_routes

BALL = 0.010
"""Radius of the ball [m]."""

FORK = Corner(angle=math.pi, branches=(Branch(angle=math.radians(45), diameter=0.08, length=0.5),))
OUT_OF_A_BRANCH = Corner(
    angle=math.radians(60),
    turn="right",
    branches=(Branch(angle=math.radians(120), turn="left", diameter=0.1, length=0.4, closed=True),),
)
CROSSING = Corner(
    angle=math.pi,
    branches=(
        Branch(angle=math.radians(90), roll=math.radians(40), diameter=0.09, length=0.4),
        Branch(angle=math.radians(60), turn="right", diameter=0.05, length=0.4, closed=True),
    ),
)


def _fittings(diameter: float, corners: tuple[Corner, ...], capped: bool = False) -> PipeRoute:
    straights = [None] * (len(corners) + 1)
    return PipeRoute.with_default_straights(diameter, corners, straights, 0.003, RouteEnds(capped=capped))


CORNERS = [
    PipeCorner.of(100, 75),
    PipeCorner.of(40, 30, "right"),
    PipeCorner.of(120, 180),
    PipeCorner.of(100, 90, "left", 150),
    PipeCorner.of(100, 60, "right", 20, wall_mm=5),
]
ROUTES = {
    "level": parse_routes(["runs-level:5"])[0],
    "rolled": parse_routes(["runs-rolled:11"])[0],
    "bent": PipeRoute.of(90, [(90, "left", 0, 67.5), (60, "right", 90, 135), (120, "left", -45)]),
    "odd": PipeRoute.of(150, [(30, "right", 0), (180, "left", 0), (120, "left", 33)], wall_mm=5),
    "tees": _fittings(0.1, (FORK, corner_of(90, "left", 30, 150), OUT_OF_A_BRANCH)),
    "cross": _fittings(0.09, (CROSSING, reducer_corner(70, 60))),
    "capped": _fittings(0.12, (FORK, corner_of(75, "right")), capped=True),
}


@pytest.fixture(scope="module", params=[*CORNERS, *ROUTES], ids=str)
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Pipe, Path]:
    """A pipe and its folder, without the slow part, the drawing."""
    out = tmp_path_factory.mktemp("pipes")
    with pytest.MonkeyPatch.context() as quick:
        quick.setattr("pipenav.drawing.corner.draw_pipe", lambda _, path: path.write_bytes(b""))
        quick.setattr("pipenav.drawing.route.draw_route", lambda _, name, path: path.write_bytes(name.encode()))
        if isinstance(request.param, PipeCorner):
            return request.param, write_pipe_folder(request.param, out)
        return ROUTES[request.param], write_route_folder(ROUTES[request.param], request.param, out)


def centre(pipe: Pipe, count: int = 200) -> Floats:
    """Points along the centre line, (count, 3) [m]."""
    if isinstance(pipe, PipeRoute):
        return along_centre(pipe, count, 1.3 * BALL if pipe.capped else 0.0)
    line = pipe.line(0.0)
    lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    at = np.linspace(0.0, lengths[-1], count)
    return np.stack([*(np.interp(at, lengths, x) for x in line.T), np.zeros(count)], axis=1)


@pytest.mark.parametrize("engine", CONTACTS)
def test_a_ball_goes_along_the_centre_line_without_contact(made: tuple[Pipe, Path], engine: str) -> None:
    pipe, folder = made
    file, contacts = CONTACTS[engine]
    assert sum(contacts(folder / file, centre(pipe), BALL)) == 0


@pytest.mark.parametrize("engine", CONTACTS)
def test_a_ball_goes_into_every_branch_and_meets_the_caps_alone(made: tuple[Pipe, Path], engine: str) -> None:
    pipe, folder = made
    if not isinstance(pipe, PipeRoute) or not len(pipe.branches.corner):
        return
    file, contacts = CONTACTS[engine]
    branches, shares = pipe.branches, np.linspace(0.0, 1.0, 40)[:, None]
    for start, axes, length, closed in zip(
        branches.start, branches.axes, branches.length, branches.closed, strict=True
    ):
        far = length - (1.3 * BALL if closed else 0.0)  # Bullet puts a millimetre around walls
        assert sum(contacts(folder / file, start + far * shares * axes[:, 0], BALL)) == 0
        at_end = start + (length - 0.5 * BALL) * axes[:, 0]
        assert (sum(contacts(folder / file, at_end[None], BALL)) > 0) == closed


@pytest.mark.parametrize("engine", CONTACTS)
def test_the_walls_are_there(made: tuple[Pipe, Path], engine: str) -> None:
    """A ball pressed into the left wall of the first leg touches it: a pipe without walls would pass the law above."""
    pipe, folder = made
    file, contacts = CONTACTS[engine]
    middle = centre(pipe)[0] + np.array([0.02, 0.0, 0.0])
    beside = middle + np.array([0.0, pipe.radius, 0.0])
    assert contacts(folder / file, np.stack([middle, beside]), BALL)[0] == 0
    assert contacts(folder / file, np.stack([middle, beside]), BALL)[1] > 0


@pytest.mark.parametrize("angle", ["degree", "radian"])
def test_a_model_that_includes_the_pipe_keeps_its_own_angles(
    made: tuple[Pipe, Path], tmp_path: Path, angle: str
) -> None:
    pipe, folder = made
    model = f"""<mujoco>
      <compiler angle="{angle}" eulerseq="zyx"/>
      <default><mesh scale="0.001 0.001 0.001"/></default>
      <worldbody><body name="ball"><freejoint/><geom type="sphere" size="{BALL}"/></body>
        <body name="arm"><joint name="hinge" type="hinge" axis="0 0 1" range="-1 1" limited="true"/>
          <geom type="sphere" size="0.01" contype="0" conaffinity="0"/></body></worldbody>
      <include file="{folder / "pipe.xml"}"/>
    </mujoco>"""
    (tmp_path / "model.xml").write_text(model)
    compiled = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    unit = math.pi / 180 if angle == "degree" else 1.0
    np.testing.assert_allclose(compiled.joint("hinge").range, [-unit, unit])
    points = centre(pipe)
    assert sum(contacts_of_free_body(compiled, points)) == 0
    wall = points[:1] + np.array([0.02, pipe.radius, 0.0])
    assert sum(contacts_of_free_body(compiled, wall)) > 0
