"""Driving in a route in space: steps and rolls through the same door, and set-points that never jump."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from helpers.driving import RandomHands, changes
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.backends.spatial import SpaceReading
from pipenav.deployment.telemetry import read_telemetry
from pipenav.driving import space_door
from pipenav.driving.ask import NOTHING, Ask, Seen
from pipenav.driving.door import STEPS_ONLY, Door, Scene
from pipenav.driving.plans import make_plan
from pipenav.driving.primitives import NO_ROLL
from pipenav.driving.rear_flip import RearFlip
from pipenav.driving.route_steps import corner_row
from pipenav.driving.scripted import StepScript, script_for
from pipenav.driving.sessions import Session
from pipenav.driving.space_door import SpaceDoor, roll_limits
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import BASE, load_robot
from pipenav.tasks.rolling.clamp import ZIGZAG, steepness
from pipenav.tasks.rolling.manoeuvre import RollCommand
from pipenav.testing.kinematic_space import KinematicSpace

ROBOT = load_robot("pirate-strong")
ROUTE = PipeRoute.of(90, [(90, "left", 0), (75, "left", 90)], straights_mm=[1000, 1200, 1000])
ROUNDING = 1e-9

ROUTE_FILE = """schema = 1
diameter_mm = 90
first_straight_mm = 1000
[[corners]]
angle_deg = 90
turn = "left"
straight_mm = 1000
[[corners]]
angle_deg = 100
turn = "right"
roll_deg = 90
straight_mm = 1000
"""


class Wishes:
    """Asks for what it is given."""

    def __init__(self) -> None:
        self.wish = NOTHING

    def ask(self, seen: Seen) -> Ask:  # noqa: ARG002  # the signature of an operator
        return self.wish


class Bench:
    """A robot that clamps in the first straight, and its door; `plane` is its angle to the first corner's plane."""

    def __init__(self, plane: float, has_policy: bool = False) -> None:
        self.hands = Wishes()
        self.door = SpaceDoor(ROBOT, self.hands, has_policy)
        self.space = KinematicSpace(ROBOT, 1)
        q = np.zeros((1, len(BASE) + len(ROBOT.joints)))
        q[0, len(BASE) :] = steepness(ROBOT, ROUTE.radius) * ZIGZAG
        self.reading: SpaceReading = self.space.reset(np.arange(1), [ROUTE], q, np.zeros(1), np.array([plane]))
        self.door.start_in_space(self.reading, Scene(None, 0.08, None, corner_row(ROUTE)), ROUTE)
        self.door._plane.plane = plane

    def step(self, wish: Ask, policy: RollCommand | None = None) -> RollCommand:
        self.hands.wish = wish
        told = self.door.next_in_space(self.reading, None if policy is None else lambda: policy)
        self.space.step(told.values, told.roll)
        turned = np.zeros((1, 2, 3))
        before, self.reading = self.reading, self.space.read()
        turned[0, :, 0] = (self.reading.roll - before.roll) / 2
        self.reading = self.reading._replace(turned=turned)
        return told


@settings(max_examples=8, deadline=None)
@given(plane=st.floats(-1.5, 1.5).filter(lambda plane: abs(plane) > 0.2), halts=st.integers(1, 60))
def test_a_roll_never_jumps_and_goes_on_after_a_halt(plane: float, halts: int) -> None:
    bench, step = Bench(plane), np.append(Door(ROBOT, None, False).limits, roll_limits(ROBOT).step)
    told = [bench.door.told]
    bench.step(Ask(active=True, step="roll"))
    assert bench.door.step == "roll"
    for tick in range(400):
        halt = tick == halts
        again = tick == halts + 5 and not bench.door._plane.done
        bench.step(Ask(active=True, quiet=halt, step="roll" if again else ""))
        told.append(bench.door.told)
        assert bench.door.in_space["roll_command"] == bench.door.told[-1]
        if bench.door.step_done:
            break
    assert bench.door.step_done
    turned = np.array(told)[:, -1]
    assert max(turned, key=abs) == pytest.approx(-plane, abs=0.02)  # half after half
    assert turned[-1] == pytest.approx(0.0, abs=0.02)
    assert (np.abs(np.diff(told, axis=0)) <= step + ROUNDING).all()
    change = np.abs(np.diff(turned, n=2))
    assert change.max() <= roll_limits(ROBOT).change[0] + ROUNDING


def test_a_key_turns_the_roll_joint_alone_and_its_stop_is_kept() -> None:
    bench = Bench(0.0)
    for _ in range(300):
        bench.step(Ask(active=True, joints={"roll": 1.0}))
    assert ROBOT.roll is not None
    assert bench.door.told[-1] == pytest.approx(ROBOT.roll.joint.upper)
    bench.step(Ask(active=True, step="a"))
    assert bench.door.said == space_door.TWISTED
    assert bench.door.step == ""


def test_a_roll_that_is_not_possible_says_why() -> None:
    bench = Bench(0.0)
    bench.step(Ask(active=True, step="roll"))
    assert bench.door.said == space_door.SAME_PLANE
    bench = Bench(1.0)
    bench.step(Ask(active=True, step="a"))
    bench.step(Ask(active=True, step="roll"))
    assert bench.door.said == space_door.NO_STRAIGHT
    assert bench.door.step == "a"


def test_a_policys_roll_is_what_it_wants_and_a_take_over_holds_it() -> None:
    bench = Bench(0.0, has_policy=True)
    values = bench.door.command[None]
    wants = np.array([0.8])
    told = [bench.step(NOTHING, RollCommand(values, wants)).roll[0] for _ in range(40)]
    assert told[-1] == pytest.approx(0.8)
    held = [bench.step(Ask(active=True), RollCommand(values, -wants)).roll[0] for _ in range(20)]
    assert held == pytest.approx([0.8] * 20)
    assert bench.door.takeovers == 1
    back = [bench.step(NOTHING, RollCommand(values, -wants)).roll[0] for _ in range(60)]
    assert back[-1] == pytest.approx(-0.8)
    path = np.array(told + held + back)
    assert np.abs(np.diff(path)).max() <= roll_limits(ROBOT).step[0] + ROUNDING


@given(turn=st.sampled_from(["left", "right"]), rear=st.sampled_from([-1, 1]), front=st.sampled_from([-1, 1]))
def test_before_step_a_the_rear_half_clamps_as_the_corner_turns_and_the_front_half_stays(
    turn: str, rear: int, front: int
) -> None:
    pipe = PipeCorner.of(90, 80, turn)
    steep = float(steepness(ROBOT, pipe.radius))
    clamped = steep * np.array([1.0, -2.0, 1.0])
    bends = np.concatenate([rear * clamped, front * clamped[::-1]])
    flip = RearFlip.needed(ROBOT, pipe, bends)
    assert (flip is None) == (rear == pipe.turn_sign)
    if flip is not None:
        goal = flip.goal(bends)
        assert not flip.done
        assert (goal[6:] == 0).all()
        assert goal[[0, 5]] == pytest.approx(steep * np.array([pipe.turn_sign, front]))
        assert goal[1] * pipe.turn_sign < -steep
        assert goal[4] * front < -steep
        flip.goal(goal[:6])
        assert flip.done


def test_the_front_half_holds_until_the_rear_half_has_turned_over() -> None:
    bench = Bench(0.0)
    before = bench.door.command[:6]
    assert before[1] > 0  # as in a turn to the right, and the first corner turns to the left
    bench.step(Ask(active=True, step="a"))
    for _ in range(60):
        told = bench.step(Ask(active=True)).values[0]
        if abs(told[4]) < 0.5 * abs(before[4]):
            break
    assert bench.reading.body.q[0, 1] < 0
    assert abs(told[4]) < 0.5 * abs(before[4])


@pytest.mark.parametrize("row", [True, False])
def test_in_a_plane_there_is_no_roll(row: bool) -> None:
    hands = Wishes()
    door, pipe = Door(ROBOT, hands, False), PipeCorner.of(90, 90)
    reading = KinematicSpace(ROBOT, 1).read().body
    door.start(reading, Scene(pipe, 0.08, None, corner_row(pipe) if row else None))
    for wish in (Ask(active=True, step="roll"), Ask(active=True, joints={"roll": 1.0})):
        hands.wish, door.said = wish, ""
        door.next(reading, None)
        assert door.said == (NO_ROLL if row or wish.joints else STEPS_ONLY)
        assert door.step == ""


def test_a_script_rolls_before_it_goes_on_in_another_plane() -> None:
    script = StepScript(ROBOT, 0)
    reading = KinematicSpace(ROBOT, 1).read().body
    for step, in_plane, then in (("e", True, "a"), ("e", False, "roll"), ("roll", True, "e"), ("roll", False, "e")):
        assert script._next(Seen(9, reading, step, True, in_plane=in_plane)) == then


@pytest.mark.slow
@pytest.mark.parametrize("weight", [0.0, 3.0])
def test_a_script_passes_a_rolled_route_by_steps_and_rolls(weight: float, tmp_path: Path) -> None:
    file, folder = tmp_path / "route.toml", tmp_path / "driven"
    file.write_text(ROUTE_FILE)
    folder.mkdir()
    plan = make_plan(None, "pirate-strong", [str(file)], 1, 0)
    plan = plan.on("mujoco", {"gravity": weight} if weight else {}, None, folder)
    session = Session(plan, lambda _: script_for(plan.robot, 0, False))
    session.run()
    assert [record.outcome for record in session.records] == ["reached"]
    ticks = read_telemetry(folder / "episode-0000.jsonl").ticks
    steps = [tick["step"] for tick in ticks if tick["step"]]
    changed = [one for one, before in zip(steps, ["", *steps], strict=False) if one != before]
    assert re.fullmatch("abcde(roll e)+abcde", " ".join(changed).replace(" ", "").replace("rolle", "roll e"))
    assert abs(math.cos(ticks[-1]["plane"])) < math.sin(math.radians(15.0))  # a quarter of a turn, to either side
    assert session.records[0].largest_jump <= 1 + 1e-6
    assert "observation" not in ticks[0]
    clamped = next(tick for tick in ticks if tick["step"] == "e" and abs(tick["plane"]) > 1.0)
    begun = next(tick for tick in ticks if tick["step"] == "a" and tick["tick"] > clamped["tick"])
    for joint in (1, 4):  # what presses goes on pressing until step (a) turns the rear half over
        held = [tick["q"][joint] for tick in ticks[clamped["tick"] : begun["tick"]]]
        assert min(held) * max(held) > 0


@pytest.mark.slow
def test_neither_a_take_over_nor_a_hand_back_jumps_in_space(tmp_path: Path) -> None:
    """Whoever drives, and whatever is moved, the roll joint among it."""
    plan = make_plan("pirate-strong", None, ["runs-rolled:1"], 2, 0)
    plan = plan.on("mujoco", {}, None, tmp_path)
    session = Session(plan, lambda i: RandomHands(plan.robot, i, roll=True))
    session.run()
    found = [changes(path, plan.robot) for path in sorted(tmp_path.glob("*.jsonl"))]
    assert sum(one.count[0] for one in found) == sum(record.takeovers for record in session.records) > 10
    assert max(one.jump for one in found) <= 1 + 1e-6
    assert max(one.break_ for one in found) <= 1 + 1e-6
