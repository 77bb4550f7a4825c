"""Rolling between corners in several planes: the manoeuvre, what the robot senses, and the commands that run it."""

from __future__ import annotations

import math
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from command import route as command
from hypothesis import given
from hypothesis import strategies as st

from pipenav.backends.messages import Reading
from pipenav.backends.simulators import open_space
from pipenav.backends.spatial import SpaceReading
from pipenav.errors import PipenavError
from pipenav.evaluation.results import read_evaluation
from pipenav.evaluation.rolling_stage import gravity_of
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_legs import about_x
from pipenav.recording.rolling_film import SIDES, faces
from pipenav.robots import laser
from pipenav.robots.robot import load_robot
from pipenav.tasks.rolling import senses
from pipenav.tasks.rolling.clamp import ZIGZAG, check_robot, nearest, room, steepness
from pipenav.tasks.rolling.manoeuvre import Roll, RollPhase
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import GRAVITY

ROBOT = load_robot("pirate")
SEVERAL_PLANES = """schema = 1
diameter_mm = 90
first_straight_mm = 900

[[corners]]
angle_deg = 120
turn = "left"
straight_mm = 900

[[corners]]
angle_deg = 120
turn = "left"
roll_deg = 90
straight_mm = 900
"""


def clamped(radius: float, third: float) -> np.ndarray:
    return third * steepness(ROBOT, radius) * ZIGZAG


def reading(bends: np.ndarray, ranges: np.ndarray | None = None, down: np.ndarray | None = None) -> SpaceReading:
    """Of one robot that stands still."""
    seen = np.full(ROBOT.laser.beams, 0.5) if ranges is None else ranges
    body = Reading(bends, np.zeros(6), seen, np.zeros(()), np.zeros(6), np.zeros(12))
    return SpaceReading(body, np.zeros(()), np.zeros((2, 3)) if down is None else down, np.zeros((2, 3)))


@pytest.mark.parametrize("third", [1.0, -1.0])
@pytest.mark.parametrize("diameter", [0.07, 0.12])
def test_in_a_zigzag_the_rear_half_heads_along_the_pipe(diameter: float, third: float) -> None:
    bends = clamped(diameter / 2, third)
    first = senses.ways(ROBOT, bends)[0]  # the first link lies along the axis
    rear = senses.ways(ROBOT, bends)[1:3].sum(axis=0)
    assert senses.angle_between(first, rear) == pytest.approx(0.0, abs=1e-9)
    assert nearest(bends) == third


@given(st.floats(-1.0, 1.0), st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6))
def test_the_divided_links_heading_counts_from_the_rear_half(turn: float, bends: list[float]) -> None:
    """However the robot is bent: a bend of the third joint turns the divided link and leaves the rear half."""
    before = np.array(bends)
    after = before + np.array([0, 0, turn, 0, 0, 0])
    change = senses.from_rear_half(ROBOT, after) - senses.from_rear_half(ROBOT, before)
    assert change == pytest.approx(turn, abs=1e-9)


@given(st.floats(-math.pi, math.pi), st.floats(-1.2, 1.2), st.floats(-0.6, 0.6))
def test_a_plane_is_known_from_the_weight_unless_the_straight_is_too_steep(
    plane: float, slope: float, swing: float
) -> None:
    """By any pose of the joints: the accelerometers' link may head another way than the straight."""
    c, s = math.cos(slope), math.sin(slope)
    axes = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])  # climbs by the slope
    bends = clamped(0.045, 1.0) + np.array([0, 0, swing, -swing, 0, 0])
    way = senses.ways(ROBOT, bends)
    heading = senses.angle_between(way[1:-1].sum(axis=0), way[3])
    turn = np.array([[math.cos(heading), -math.sin(heading), 0], [math.sin(heading), math.cos(heading), 0], [0, 0, 1]])
    link = axes @ about_x(plane) @ turn
    seen = senses.plane_of(ROBOT, reading(bends, down=np.array([[0, 0, -1.0] @ link] * 2)), axes)
    if math.cos(slope) < senses.STEEPEST:
        assert seen is None
    elif seen is not None:
        assert math.remainder(seen - plane, 2 * math.pi) == pytest.approx(0.0, abs=1e-6)
    assert senses.plane_of(ROBOT, reading(bends), axes) is None


@pytest.mark.parametrize("turn", ["left", "right"])
@pytest.mark.parametrize("third", [1.0, -1.0])
@pytest.mark.parametrize(("diameter", "angle"), [(70, 55), (70, 125), (90, 90), (120, 55), (120, 125)])
def test_a_clamped_robot_sees_a_straight_end_in_time_and_not_before(
    diameter: int, angle: int, third: float, turn: str
) -> None:
    pipe = PipeCorner.of(diameter, angle, turn)
    bends = clamped(pipe.radius, third)

    def sees(gap: float) -> bool:
        tip = np.array([[-pipe.inner_edge - gap, -third * room(ROBOT, pipe.radius)]])
        distances = laser.cast(tip, ROBOT.laser.angles[None], pipe.segments[None])
        return senses.sees_end(ROBOT, reading(bends, laser.measure(ROBOT.laser, distances)[0]), pipe.radius, third)

    seen = [gap for gap in np.arange(0.0, 0.4, 0.005) if sees(gap)]
    assert 0.05 <= max(seen) <= 0.215
    assert any(sees(gap) for gap in np.arange(0.04, 0.1, 0.005))


@pytest.mark.parametrize(
    ("diameter", "gravity", "plane", "third"),
    [(70, GRAVITY, 90, 1.0), (90, GRAVITY, 0, -1.0), (120, GRAVITY, 90, -1.0), (120, 0.0, 0, 1.0)],
)
def test_a_roll_turns_the_plane_by_what_was_asked_and_the_robot_stays_where_it_is(
    diameter: int, gravity: float, plane: float, third: float
) -> None:
    route, turn, start = PipeRoute.of(diameter, [(90, "left", 0)], [1500, 600]), math.radians(90), math.radians(plane)
    q = np.concatenate([[0.0, third * room(ROBOT, route.radius - 1e-4), 0.0], clamped(route.radius - 1e-4, third)])
    with closing(open_space("mujoco", ROBOT, 1, {}, gravity)) as backend:
        backend.reset(np.arange(1), [route], q[None], np.array([-1.0]), np.array([start]))
        first, place = backend.read().row(0), backend.truth().points[0, :, 0].mean()
        roll, deepest = Roll(ROBOT, route.radius, turn, first.body.q, first.down), 0.0
        while roll.phase is not RollPhase.DONE:
            now = backend.read().row(0)
            assert now.body.wheel_speeds is not None
            set_points, joint = roll.act(now.body.q, float(now.roll), now.body.wheel_speeds, now.down)
            backend.step(set_points[None], np.array([joint]))
            deepest = max(deepest, float(backend.truth().penetration[0]))
        truth, after = backend.truth(), backend.read().row(0)
    turned = np.arctan2(-truth.normals[0, :, 1], truth.normals[0, :, 2]) - start
    assert np.abs(np.remainder(turned - turn + math.pi, 2 * math.pi) - math.pi).max() < math.radians(12)
    assert abs(after.roll) < 0.05 and nearest(after.body.q) in (1.0, -1.0)
    np.testing.assert_allclose(np.abs(after.body.q), np.abs(clamped(route.radius, 1.0)), atol=0.4)
    assert deepest < 1e-3
    assert abs(truth.points[0, :, 0].mean() - place) < 0.12


def test_gravity_comes_with_the_task() -> None:
    assert gravity_of(TraverseConfig(kind="traverse")) == 0.0
    assert gravity_of(TraverseConfig(kind="traverse", inclination_deg=(0.0, 360.0))) == GRAVITY


def test_only_a_robot_of_two_halves_rolls() -> None:
    with pytest.raises(PipenavError, match=r"robot 'basic' cannot roll: .*: choose --robot pirate"):
        check_robot(load_robot("basic"))


def several_planes(folder: Path) -> str:
    (folder / "several.toml").write_text(SEVERAL_PLANES, encoding="utf-8")
    return str(folder / "several.toml")


def test_runs_in_several_planes_are_counted_beside_those_in_one(tmp_path: Path) -> None:
    """By random actions, which pass nowhere."""
    args = ("--pipes", several_planes(tmp_path), "--pipes", "d=90,angle=90", "--episodes", "1", "--robot", "pirate")
    assert command("eval", "--policy", "baseline:random", *args, "--out", str(tmp_path / "found")) == 0
    rolled, corner = read_evaluation(tmp_path / "found").pipes
    assert (rolled.route, corner.route) == ("run-d90-L120-L120roll90", None)
    for record in (rolled, corner):
        assert record.traverse_attempts == sum(record.failures.values()) == 1


def test_a_picture_of_a_run_in_several_planes(tmp_path: Path) -> None:
    picture = tmp_path / "strip.png"
    args = ("view", "--policy", "baseline:random", "--robot", "pirate", "--pipes", several_planes(tmp_path))
    assert command(*args, "--out", str(picture)) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (
            ("eval", "--backend", "pybullet"),
            "backend 'pybullet' moves robots in a plane alone: choose --backend mujoco",
        ),
        (("eval", "--disturb", "real-world"), "--disturb disturbs robots in a plane"),
        (("view", "--out", "way.csv"), "its suffix must be one of: .png, .gif, .mp4"),
        (("view", "--pipes", "d=90,angle=90"), "a picture in space shows one route"),
    ],
)
def test_what_cannot_be_done_in_several_planes_is_said(
    args: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name, *rest = args
    common = ("--policy", "baseline:random", "--robot", "pirate", "--pipes", several_planes(tmp_path))
    assert command(name, *common, *rest) == 1
    assert said in " ".join(capsys.readouterr().err.split())


def test_the_sequence_turns_corners_in_one_plane_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    args = ("--pipes", several_planes(tmp_path), "--episodes", "1", "--out", str(tmp_path / "found"))
    assert command("eval", "--policy", "baseline:sequence", *args) == 1
    assert "turns corners in one plane" in " ".join(capsys.readouterr().err.split())


def test_a_robot_is_drawn_in_its_halves_planes() -> None:
    """Every face of a straight robot lies around it at the links' width and height, turned with the half's plane."""
    points = np.zeros((len(ROBOT.links) + 1, 3))
    points[1:, 0] = np.cumsum(ROBOT.lengths)
    links, wheels, half = faces(ROBOT, points, np.array([[0.0, 0, 1], [0, -1, 0]]))
    pieces = len(ROBOT.links) + 1  # the roll joint divides one
    assert links.shape == (6 * pieces, 4, 3) and len(wheels) == len(ROBOT.wheels)
    assert list(half) == [0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1]
    width, height = ROBOT.links[0].width, ROBOT.links[0].height
    sizes = np.ptp(links.reshape(pieces, -1, 3), axis=1)[:, 1:]
    np.testing.assert_allclose(sizes, [[width, height]] * 4 + [[height, width]] * 4)
    for disc, of in zip(wheels, half[pieces:], strict=True):
        assert disc.shape == (SIDES, 3)
        np.testing.assert_allclose(disc[:, 2 if of == 0 else 1], 0.0, atol=1e-12)
