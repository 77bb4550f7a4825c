"""The stages of a mission on a simulated arm that nothing disturbs, and without any arm."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pipenav.backends.messages import Command, Reading
from pipenav.backends.simulators import open_simulator
from pipenav.deployment.mission import Mission, mission_of, mission_settings
from pipenav.deployment.stages import LOCATE_TICKS, PUSH, Back, Decision, Locate
from pipenav.locating.locator import Exit, LocateConfig
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.policy import Policy, load_policy, resolve_policy
from pipenav.robots import kinematics
from pipenav.tasks.reach import episode

POLICY = load_policy(resolve_policy("arm"))
ROBOT = POLICY.header.robot
PERIOD = 0.1


def reading(q: Any, ranges: float = 0.2) -> Reading:
    q = np.array([q], float)
    return Reading(q, np.zeros_like(q), np.full((1, ROBOT.laser.beams), ranges), np.zeros(1))


def simulate(
    pipe: PipeCorner, seed: int, policy: Policy = POLICY, lag: float = 0.0, **settings: Any
) -> tuple[Mission, list[Decision]]:
    """A mission on a simulated arm whose set-points are limited as a real arm's.

    Its joints are read up to `lag` periods before their motion ends.
    """
    robot, rng = policy.header.robot, np.random.default_rng(seed)
    start = episode.sample(robot, policy.header.task, [pipe], rng)
    backend = open_simulator("mujoco", robot, 1, {"threads": 1}, len(pipe.segments))
    now = before = backend.reset(np.array([0]), [pipe], start.q, start.base)
    given = {"target": None, "retreat": False} | settings
    mission = Mission(
        policy,
        Exit(pipe.turn, bend=pipe.bend_radius > 0),
        PERIOD,
        given["target"],
        LocateConfig(),
        given["retreat"],
    )
    made, step = [], robot.speed_limits * PERIOD
    for _ in range(500):
        seen = now._replace(q=now.q - rng.uniform(0, lag) * (now.q - before.q))
        made.append(mission.decide(seen))
        command = made[-1].command
        if command is None:
            break
        target = np.clip(np.clip(command.values, seen.q - step, seen.q + step), robot.lower, robot.upper)
        backend.step(Command("position", target))
        before, now = now, backend.read()
    backend.close()
    return mission, made


@pytest.mark.parametrize("turn", ["left", "right"])
@pytest.mark.parametrize(("angle", "bend_mm"), [(60, 0), (90, 0), (120, 0), (90, 130), (120, 390)])
def test_an_arm_locates_reaches_and_comes_back(angle: int, bend_mm: int, turn: str) -> None:
    pipe = PipeCorner.of(130, angle, turn, bend_mm)
    mission, made = simulate(pipe, angle)
    stages = [decision.stage for decision in made]
    assert mission.outcome == "passed"
    assert stages == sorted(stages, key=["locate", "reach", "back", "passed"].index)
    assert {"locate", "reach", "back", "passed"} == set(stages)
    assert mission.target is not None and np.sign(mission.target[1]) == pipe.turn_sign
    for decision in made:
        assert (decision.observation is not None) == (decision.stage == "reach")


def test_a_given_target_is_not_looked_for() -> None:
    pipe = PipeCorner.of(120, 90, "right")
    start = episode.sample(ROBOT, POLICY.header.task, [pipe], np.random.default_rng(3))
    target = start.target[0] * [1, -1]
    mission, made = simulate(pipe, 3, target=target)
    assert mission.outcome == "passed"
    assert made[0].stage == "reach"
    assert mission.target is target


def test_a_target_out_of_reach_is_given_up_and_left_if_wished() -> None:
    far = np.array([5.0, 0.0])
    for retreat, last in ((False, "reach"), (True, "back")):
        mission, made = simulate(PipeCorner.of(130, 90), 0, target=far, retreat=retreat)
        assert mission.outcome in ("timeout", "limit")
        assert made[-2].stage == last


@pytest.mark.parametrize("exit_", [Exit("left"), Exit("left", bend=True)])
def test_where_no_corner_is_none_is_found(exit_: Exit) -> None:
    locate = Locate(ROBOT, LocateConfig(), exit_)
    straight = reading(np.zeros(4), ROBOT.laser.range_max)
    for _ in range(LOCATE_TICKS):
        assert isinstance(locate.decide(straight), Decision)
    assert locate.decide(straight) == "not-located"
    assert locate.target is None


def test_decisions_on_a_right_turn_mirror_those_on_a_left_one() -> None:
    rng = np.random.default_rng(0)
    left = Mission(POLICY, Exit("left"), PERIOD, np.array([0.7, 0.2]), LocateConfig(), False)
    right = Mission(POLICY, Exit("right"), PERIOD, np.array([0.7, -0.2]), LocateConfig(), False)
    for _ in range(10):
        q = rng.uniform(-0.5, 0.5, 4) * [0.2, 1, 1, 1]
        ranges = rng.uniform(0.01, 0.5, (1, ROBOT.laser.beams))
        one = left.decide(reading(q)._replace(ranges=ranges)).command
        other = right.decide(reading(q * ROBOT.mirror_signs)._replace(ranges=ranges[:, ::-1])).command
        assert one is not None and other is not None
        assert other.values * ROBOT.mirror_signs == pytest.approx(one.values)


def path(rows: int = 6) -> list[np.ndarray]:
    return [np.array([0.02, 0.1, -0.1, 0.2]) * i for i in range(rows)]


def test_backing_out_visits_the_recorded_poses_in_reverse() -> None:
    poses = path()
    back, q, sent = Back(ROBOT, poses, PERIOD), poses[-1], []
    while isinstance(made := back.decide(reading(q)), Decision):
        assert made.command is not None
        q = made.command.values[0]
        sent.append(q)
    assert made == "home"
    assert np.array(sent[:5]) == pytest.approx(np.array(poses[-2::-1]))


def test_an_arm_that_catches_is_freed_forwards_and_one_that_stays_caught_is_given_up() -> None:
    poses = path()
    back, goals = Back(ROBOT, poses, PERIOD), []
    while isinstance(made := back.decide(reading(poses[-1])), Decision):
        assert made.command is not None
        goals.append(float(made.command.values[0, 0]))
    assert made == "back-timeout"
    assert max(goals) == pytest.approx(float(poses[-1][0]) + PUSH), "it never goes far beyond what it has passed"
    assert np.diff(goals).max() > 0, "it goes forwards again"


def test_a_mission_backs_out_only_once_and_only_if_it_may() -> None:
    mission = Mission(POLICY, Exit("left"), PERIOD, None, LocateConfig(), False)
    mission.decide(reading(np.zeros(4)))
    assert not mission.back_out("stall")
    mission = Mission(POLICY, Exit("left"), PERIOD, None, LocateConfig(), True)
    assert not mission.back_out("stall"), "nothing has been recorded yet"
    mission.decide(reading(np.zeros(4)))
    assert mission.back_out("stall")
    assert not mission.back_out("stall")
    mission.decide(reading(np.zeros(4)))
    assert mission.outcome == "stall"


def test_the_tip_ends_within_the_tolerance() -> None:
    mission, made = simulate(PipeCorner.of(130, 120), 1)
    assert mission.target is not None
    reach = [decision.command for decision in made if decision.stage == "back"]
    assert reach[0] is not None
    tip = kinematics.forward(ROBOT, reach[0].values).tip[0]
    assert np.linalg.norm(tip - mission.target) < 4 * POLICY.header.task.reach_tolerance


def test_an_arm_that_hooks_on_the_corners_edge_is_free_after_a_few_ticks() -> None:
    """A start from which a link's shoulder catches when the arm comes back, which forwards it slid over."""
    mission, made = simulate(PipeCorner.of(130, 60), 108, load_policy(resolve_policy("real-setup")), lag=0.7)
    stages = [decision.stage for decision in made]
    assert mission.outcome == "passed"
    assert stages.count("back") < stages.count("reach") + 12


EXITS = [Exit("left"), Exit("right", tee=True), Exit("left", tee=True, straight=True), Exit("right", bend=True)]


@pytest.mark.parametrize("exit_", EXITS)
def test_a_mission_is_told_the_exit_that_its_settings_hold(exit_: Exit) -> None:
    assert mission_of(POLICY, mission_settings(exit_, None, retreat=False)).exit_ == exit_


def test_settings_of_before_there_were_tees_and_bends_are_those_of_a_corner() -> None:
    settings = mission_settings(Exit("right"), None, retreat=False)
    older = {key: value for key, value in settings.items() if key not in ("tee", "straight_on", "bend")}
    assert mission_of(POLICY, older).exit_ == Exit("right")
