"""The window on a running episode: real time, one window per backend, and life after it is closed."""

from __future__ import annotations

import contextlib
from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pipenav_mujoco.backend import MujocoBackend, MujocoOptions
from pipenav_mujoco.viewer import Marks, draw_marks

from pipenav.backends.messages import Command
from pipenav.backends.simulators import open_space
from pipenav.backends.viewer import Sight
from pipenav.errors import PipenavError
from pipenav.evaluation.episode_runner import random_start
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route_sets import parse_routes
from pipenav.policies.named import open_controller
from pipenav.recording import live
from pipenav.recording.live import Window
from pipenav.recording.record import RecordingSettings, Weight, record_task
from pipenav.robots.robot import load_robot
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.testing import KinematicBackend, KinematicOptions

ROBOT = load_robot("basic")
PIPE = PipeCorner.of(100, 75)


class Screen:
    """A window that the person closes after some pictures."""

    def __init__(self, patience: int) -> None:
        self.patience, self.shown, self.closed = patience, 0, False
        self.texts: list[str] = []

    def show(self, sight: Sight) -> bool:
        self.shown += 1
        self.texts.append(sight.text)
        return self.shown <= self.patience

    def close(self) -> None:
        self.closed = True


class Shown(KinematicBackend):
    """A simulator with a window of its own."""

    screens: list[Screen]

    @property
    def has_viewer(self) -> bool:
        return True

    def open_viewer(self) -> Screen:
        self.screens.append(Screen(5))
        return self.screens[-1]


class RealTime:
    """A clock that only sleeping and working move."""

    def __init__(self) -> None:
        self.now, self.slept = 0.0, [0.0]

    def sleep(self, seconds: float) -> None:
        self.now += seconds
        self.slept.append(seconds)


@pytest.fixture
def backend() -> Shown:
    shown = Shown(ROBOT, 1, KinematicOptions())
    shown.screens = []
    return shown


def test_an_episode_is_shown_in_real_time(backend: Shown) -> None:
    time = RealTime()
    window = Window(lambda: time.now, time.sleep)
    for _ in range(4):
        window(backend, Sight())
        time.now += 0.03  # what a control step takes
    assert time.slept[1:] == pytest.approx([0.1, 0.07, 0.07, 0.07])


def test_a_slow_simulator_is_not_slowed_further(backend: Shown) -> None:
    time = RealTime()
    window = Window(lambda: time.now, time.sleep)
    for _ in range(4):
        window(backend, Sight())
        time.now += 0.5
    assert time.slept[2:] == [0.0, 0.0, 0.0]


def test_a_closed_window_does_not_stop_the_episode(backend: Shown) -> None:
    time = RealTime()
    window = Window(lambda: time.now, time.sleep)
    for _ in range(9):
        window(backend, Sight())
    assert len(time.slept) - 1 == 5
    window.wait()
    assert len(time.slept) - 1 == 5


def test_the_window_waits_to_be_closed_and_is_closed_after_an_error(backend: Shown) -> None:
    with live.live_window() as window:
        window._sleep = lambda _: None
        window(backend, Sight())
    assert backend.screens[0].shown == 6
    assert backend.screens[0].closed
    with pytest.raises(KeyboardInterrupt), live.live_window() as window:
        window._sleep = lambda _: None
        window(backend, Sight())
        raise KeyboardInterrupt
    assert backend.screens[1].closed
    assert backend.screens[1].shown == 1


def test_each_backend_has_a_window_of_its_own(backend: Shown) -> None:
    other = Shown(ROBOT, 1, KinematicOptions())
    other.screens = []
    window = Window(lambda: 0.0, lambda _: None)
    for one in (backend, backend, other):
        window(one, Sight())
    assert (len(backend.screens), len(other.screens)) == (1, 1)
    assert backend.screens[0].closed
    assert not other.screens[0].closed


def test_a_backend_without_a_window_says_so() -> None:
    with pytest.raises(PipenavError, match="KinematicBackend has no window of its own: choose --backend mujoco"):
        Window()(KinematicBackend(ROBOT, 1, KinematicOptions()), Sight())


def test_a_recorded_motion_is_shown_pose_by_pose() -> None:
    poses = np.linspace([0, 0, 0, 0], [0.1, 0.1, 0.2, 0.3], 4)
    header = TrajectoryHeader(robot="basic", pipe=PIPE, base_m=-0.6, stage="reach")
    seen: list[Any] = []
    live.play(
        [Trajectory(header, ROBOT, poses)],
        RecordingSettings("mujoco", {"threads": 1}, lambda b, _: seen.append(b.read().q[0])),
    )
    assert np.array_equal(np.array(seen), poses)


def test_without_a_display_mujocos_viewer_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    backend = MujocoBackend(ROBOT, 1, MujocoOptions(threads=1))
    assert backend.has_viewer
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(
        PipenavError, match=r"needs a display, and neither DISPLAY nor WAYLAND_DISPLAY is set: leave out"
    ):
        backend.open_viewer()


class Handle:
    """A stand-in for what MuJoCo's launcher returns, without a screen: it remembers the states that it had to draw."""

    def __init__(self, model: Any, data: Any, **_: Any) -> None:
        self.model, self.data, self.drawn, self.open = model, data, [], True
        self.cam = mujoco.MjvCamera()
        self.lock, self.texts = contextlib.nullcontext, []
        self.user_scn = mujoco.MjvScene(model, 1000)

    def set_texts(self, texts: Any) -> None:
        self.texts.append(texts[2])

    def sync(self) -> None:
        self.drawn.append((self.data.qpos.copy(), self.data.site("tip").xpos.copy()))

    def is_running(self) -> bool:
        return self.open

    def close(self) -> None:
        self.open = False


def drawn(scene: Any) -> dict[int, list[Any]]:
    """Places of what a scene shows beside the model, by its kind."""
    kinds: dict[int, list[Any]] = {}
    for geom in scene.geoms[: scene.ngeom]:
        kinds.setdefault(geom.type, []).append(geom.pos.copy())
    return kinds


def laser_ends(backend: MujocoBackend, base: float) -> Any:
    """Ends of the first robot's beams in the model's frame, (beams, 3)."""
    x, y, heading = backend.truth().tip[0]
    beams = heading + ROBOT.laser.angles
    ends = backend.read().ranges[0][:, None] * np.stack([np.cos(beams), np.sin(beams)], axis=1)
    return np.pad(ends + np.array([x - base, y]), [(0, 0), (0, 1)])


@pytest.fixture
def handles(monkeypatch: pytest.MonkeyPatch) -> list[Handle]:
    """Windows that MuJoCo's launcher opened, on a screen that is not there."""
    glfw, viewer = pytest.importorskip("glfw"), pytest.importorskip("mujoco.viewer")
    opened: list[Handle] = []

    def launch(*args: Any, **kwargs: Any) -> Handle:
        opened.append(Handle(*args, **kwargs))
        return opened[-1]

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(glfw, "init", lambda: True)
    monkeypatch.setattr(viewer, "launch_passive", launch)
    return opened


def test_contact_forces_are_arrows_as_long_as_they_are_large() -> None:
    scene = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), 4)
    zero, middles = np.zeros(3), np.array([[0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])
    forces = np.array([[0.0, 10.0, 0.0], [0.0, 0.1, 0.0]])
    for _ in range(2):  # drawing again replaces what was drawn before
        draw_marks(scene, Marks(zero, np.zeros((0, 3)), middles, forces, 0.0), None)
    assert [geom.type for geom in scene.geoms[: scene.ngeom]] == [mujoco.mjtGeom.mjGEOM_ARROW]
    full = Marks(zero, np.ones((9, 3)), middles, forces, 0.0)
    draw_marks(scene, full, (0.0, 0.0))  # more than the scene can hold
    assert scene.ngeom == 4


def test_an_episode_tells_its_pipe_time_force_outcome_and_target() -> None:
    told: list[Sight] = []
    settings = RecordingSettings("mujoco", {"threads": 1}, lambda _, sight: told.append(sight))
    motion = record_task(open_controller("arm"), "arm", PIPE, 0, 0, settings)
    label = f"{PIPE.label}, level: nothing weighs"
    assert told[0].text == f"{label}, 0.0 s"
    assert told[-1].text.startswith(f"{label}, {motion.time[-1]:.1f} s, contact ")
    assert {sight.down for sight in told} == {None}
    assert told[-1].text.endswith(" N, reached") and len(told) == len(motion.time)
    assert {sight.target for sight in told} == {motion.header.goal_m}


@given(st.floats(-np.pi, np.pi))
def test_an_arrow_in_the_window_points_down(direction: float) -> None:
    gravity = (9.81 * np.cos(direction), 9.81 * np.sin(direction), 0.0)
    weight = Weight.of(gravity)
    assert weight.words == "violet arrow: down"
    assert weight.down == pytest.approx(np.array(gravity) / 9.81)
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    scene, zero = mujoco.MjvScene(model, 10), np.zeros(3)
    draw_marks(scene, Marks(zero, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)), 0.0), None, weight.down)
    (arrow,) = scene.geoms[: scene.ngeom]
    assert arrow.type == mujoco.mjtGeom.mjGEOM_ARROW
    np.testing.assert_allclose(arrow.mat[:, 2], weight.down, atol=1e-5)  # an arrow lies along its z axis


def test_a_route_in_space_is_shown_in_a_window_too(handles: list[Handle]) -> None:
    robot, route = load_robot("pirate-strong"), parse_routes(["runs-rolled:3"])[0]
    task = TraverseConfig(kind="traverse")
    one = random_start(robot, task, [route], 1, 0)(0)
    long = one.pipes[0]
    world = open_space("mujoco", robot, 1, {})
    world.reset(np.arange(1), [long], one.q, one.base, np.array([long.corners[0].roll]))
    with live.live_window() as window:
        window._sleep = lambda _: None
        for _ in range(3):
            world.step(np.zeros((1, len(robot.driven_actuators))), np.zeros(1))
            window(world, Sight("a line"))
        (handle,) = handles
        marks = drawn(handle.user_scn)
        assert len(marks[mujoco.mjtGeom.mjGEOM_LINE]) == robot.laser.beams
        assert handle.cam.lookat == pytest.approx(world.truth().points[0, -1])
        walls = handle.model.geom_group == 2
        assert (handle.model.geom_rgba[walls, 3] < 0.5).all() and (handle.model.geom_rgba[~walls, 3] == 1.0).all()
        handle.open = False
    world.close()


def test_mujocos_viewer_shows_the_first_robot_among_its_walls(handles: list[Handle]) -> None:
    backend = MujocoBackend(ROBOT, 2, MujocoOptions(threads=1))
    base = np.array([-0.6, -0.5])
    backend.reset(np.arange(2), [PIPE, PipeCorner.of(80, 90)], np.zeros((2, 4)), base)
    window = backend.open_viewer()
    for _ in range(3):
        backend.step(Command("position", np.tile([0.1, 0.2, 0.1, 0.1], (2, 1))))
        assert window.show(Sight("100 mm x 75\N{DEGREE SIGN}", (0.1, 0.05)))
        q, tip = handles[0].drawn[-1]
        assert np.array_equal(q, backend.read().q[0])
        assert tip[:2] + np.array([base[0], 0.0]) == pytest.approx(backend.truth().tip[0, :2])
        assert handles[0].cam.lookat == pytest.approx(tip)
    marks, scene = drawn(handles[0].user_scn), handles[0].user_scn
    lines = [geom for geom in scene.geoms[: scene.ngeom] if geom.type == mujoco.mjtGeom.mjGEOM_LINE]
    ends = np.array([line.pos + line.size[2] * line.mat[:, 2] for line in lines])
    assert ends == pytest.approx(laser_ends(backend, base[0]), abs=1e-5)
    assert marks[mujoco.mjtGeom.mjGEOM_SPHERE] == [pytest.approx([0.1 - base[0], 0.05, 0.0])]
    assert handles[0].texts[-1] == "100 mm x 75?"
    sizes = handles[0].model.geom_size[[handles[0].model.geom(f"wall{i}").id for i in range(4)]]
    lengths = np.linalg.norm(PIPE.segments[:, 1] - PIPE.segments[:, 0], axis=1)
    assert (2 * sizes[:, 0] >= lengths - 1e-9).all()
    # Parked walls make the model a hundred metres long: what is nearer than `znear` of that is not drawn.
    model = handles[0].model
    assert model.vis.map.znear * model.stat.extent < handles[0].cam.distance / 2
    window.close()
    assert not window.show(Sight())
