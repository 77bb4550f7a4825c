"""The window on a running episode: real time, one window per backend, and life after it is closed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pipenav_mujoco.backend import MujocoBackend, MujocoOptions

from pipenav.backends.messages import Command
from pipenav.errors import PipenavError
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.recording import live
from pipenav.recording.live import Window
from pipenav.recording.record import RecordingSettings
from pipenav.robots.robot import load_robot
from pipenav.testing import KinematicBackend, KinematicOptions

ROBOT = load_robot("basic")
PIPE = PipeCorner.of(100, 75)


class Screen:
    """A window that the person closes after some pictures."""

    def __init__(self, patience: int) -> None:
        self.patience, self.shown, self.closed = patience, 0, False

    def show(self) -> bool:
        self.shown += 1
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
        window(backend)
        time.now += 0.03  # what a control step takes
    assert time.slept[1:] == pytest.approx([0.1, 0.07, 0.07, 0.07])


def test_a_slow_simulator_is_not_slowed_further(backend: Shown) -> None:
    time = RealTime()
    window = Window(lambda: time.now, time.sleep)
    for _ in range(4):
        window(backend)
        time.now += 0.5
    assert time.slept[2:] == [0.0, 0.0, 0.0]


def test_a_closed_window_does_not_stop_the_episode(backend: Shown) -> None:
    time = RealTime()
    window = Window(lambda: time.now, time.sleep)
    for _ in range(9):
        window(backend)
    assert len(time.slept) - 1 == 5
    window.wait()
    assert len(time.slept) - 1 == 5


def test_the_window_waits_to_be_closed_and_is_closed_after_an_error(backend: Shown) -> None:
    with live.live_window() as window:
        window._sleep = lambda _: None
        window(backend)
    assert backend.screens[0].shown == 6
    assert backend.screens[0].closed
    with pytest.raises(KeyboardInterrupt), live.live_window() as window:
        window._sleep = lambda _: None
        window(backend)
        raise KeyboardInterrupt
    assert backend.screens[1].closed
    assert backend.screens[1].shown == 1


def test_each_backend_has_a_window_of_its_own(backend: Shown) -> None:
    other = Shown(ROBOT, 1, KinematicOptions())
    other.screens = []
    window = Window(lambda: 0.0, lambda _: None)
    for one in (backend, backend, other):
        window(one)
    assert (len(backend.screens), len(other.screens)) == (1, 1)
    assert backend.screens[0].closed
    assert not other.screens[0].closed


def test_a_backend_without_a_window_says_so() -> None:
    with pytest.raises(PipenavError, match="KinematicBackend has no window of its own: choose --backend mujoco"):
        Window()(KinematicBackend(ROBOT, 1, KinematicOptions()))


def test_a_recorded_motion_is_shown_pose_by_pose() -> None:
    poses = np.linspace([0, 0, 0, 0], [0.1, 0.1, 0.2, 0.3], 4)
    header = TrajectoryHeader(robot="basic", pipe=PIPE, base_m=-0.6, stage="reach")
    seen: list[Any] = []
    live.play(
        [Trajectory(header, ROBOT, poses)],
        RecordingSettings("mujoco", {"threads": 1}, lambda b: seen.append(b.read().q[0])),
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
        import contextlib

        import mujoco

        self.model, self.data, self.drawn, self.open = model, data, [], True
        self.cam = mujoco.MjvCamera()
        self.lock = contextlib.nullcontext

    def sync(self) -> None:
        self.drawn.append((self.data.qpos.copy(), self.data.site("tip").xpos.copy()))

    def is_running(self) -> bool:
        return self.open

    def close(self) -> None:
        self.open = False


def test_mujocos_viewer_shows_the_first_robot_among_its_walls(monkeypatch: pytest.MonkeyPatch) -> None:
    glfw = pytest.importorskip("glfw")
    viewer = pytest.importorskip("mujoco.viewer")
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(glfw, "init", lambda: True)
    handles: list[Handle] = []

    def launch(*args: Any, **kwargs: Any) -> Handle:
        handles.append(Handle(*args, **kwargs))
        return handles[-1]

    monkeypatch.setattr(viewer, "launch_passive", launch)
    backend = MujocoBackend(ROBOT, 2, MujocoOptions(threads=1))
    base = np.array([-0.6, -0.5])
    backend.reset(np.arange(2), [PIPE, PipeCorner.of(80, 90)], np.zeros((2, 4)), base)
    window = backend.open_viewer()
    for _ in range(3):
        backend.step(Command("position", np.tile([0.1, 0.2, 0.1, 0.1], (2, 1))))
        assert window.show()
        q, tip = handles[0].drawn[-1]
        assert np.array_equal(q, backend.read().q[0])
        assert tip[:2] + np.array([base[0], 0.0]) == pytest.approx(backend.truth().tip[0, :2])
    sizes = handles[0].model.geom_size[[handles[0].model.geom(f"wall{i}").id for i in range(4)]]
    lengths = np.linalg.norm(PIPE.segments[:, 1] - PIPE.segments[:, 0], axis=1)
    assert (2 * sizes[:, 0] >= lengths - 1e-9).all()
    # Parked walls make the model a hundred metres long: what is nearer than `znear` of that is not drawn.
    model = handles[0].model
    assert model.vis.map.znear * model.stat.extent < handles[0].cam.distance / 2
    window.close()
    assert not window.show()
