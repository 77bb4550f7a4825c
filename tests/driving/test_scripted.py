"""Scripted operators drive through the same door as people, and nobody on it sees where the robot is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.backends.messages import Reading
from pipenav.driving.ask import Ask, Seen
from pipenav.driving.plans import make_plan
from pipenav.driving.scripted import StepScript, TipScript, script_for
from pipenav.driving.sessions import Session
from pipenav.driving.steps import STEPS, StepDriver
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.sequence_phases import TurnPhase
from pipenav.robots.robot import load_robot

WHOLE, ARM = load_robot("pirate"), load_robot("basic")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "pipes"),
    [
        ("pirate", ["d=70,angle=55", "d=90,angle=90,turn=right", "d=120,angle=125"]),
        ("basic", ["d=70,angle=55", "d=90,angle=90,turn=right", "d=120,angle=125"]),
    ],
)
def test_a_script_passes_corners_of_the_working_range(robot: str, pipes: list[str]) -> None:
    plan = make_plan(None, robot, pipes, 2, 1)
    session = Session(plan, lambda _: script_for(plan.robot, 3, False))
    session.run()
    assert [record.outcome for record in session.records] == ["reached"] * plan.total
    assert all(record.person_share == 1.0 for record in session.records)


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["pirate", "basic"])
def test_a_script_does_the_same_alone_and_among_others(robot: str) -> None:
    """The same seed gives the same episode, however many robots are driven at once."""
    records = []
    for alone in (True, False):
        plan = make_plan(None, robot, ["d=100,angle=100"], 2, 4)
        session = Session(plan, lambda _, plan=plan: script_for(plan.robot, 3, False), alone=alone)  # type: ignore[misc]
        session.run()
        records.append(sorted(session.records, key=lambda record: record.number))
    assert records[0] == records[1]


class Straight:
    """Readings of a whole robot that rolls as it is told, for a driver that knows no simulator."""

    def __init__(self, bends: np.ndarray) -> None:
        self.bends, self.wheels = bends, np.zeros(6)

    def reading(self) -> Reading:
        q = self.bends[None]
        return Reading(q, 0 * q, np.full((1, 10), 0.5), np.zeros(1), self.wheels[None], np.zeros((1, 12)))


@settings(max_examples=15, deadline=None)
@given(diameter=st.floats(70, 120), angle=st.floats(55, 125), early=st.integers(0, 200))
def test_the_front_never_clamps_before_it_has_moved_on(diameter: float, angle: float, early: int) -> None:
    pipe = PipeCorner.of(diameter, angle)
    robot = Straight(np.zeros(6))
    driver = StepDriver(WHOLE, pipe, 0.08, robot.reading())
    for tick in range(600):
        driver.see(robot.reading())
        if tick == 0:
            driver.begin("a")
        if tick == 20:
            driver.begin("b")
        if tick == 21 + early:
            driver.begin("c")
        goal = driver.goal()
        robot.bends, robot.wheels = goal.set_points, goal.wheels
        state, course = driver._state, driver._course
        assert state is not None
        if course.phase >= TurnPhase.CLAMP_FRONT:
            half_way = driver._turn._plan.line.distance[-1]
            assert state.rear_clamp >= half_way - 0.02 or state.front_clamp >= -half_way - 0.02
            break


@pytest.mark.parametrize("asked", list("bcde"))
def test_steps_come_in_their_order(asked: str) -> None:
    robot = Straight(np.zeros(6))
    driver = StepDriver(WHOLE, PipeCorner.of(90, 90), 0.08, robot.reading())
    driver.see(robot.reading())
    driver.begin(asked)
    assert driver.step == ""
    assert driver.refusal == f"({asked}) comes after (a)"


def test_the_rear_stays_clamped_until_the_front_has_clamped() -> None:
    robot = Straight(np.zeros(6))
    driver = StepDriver(WHOLE, PipeCorner.of(90, 90), 0.08, robot.reading())
    driver.see(robot.reading())
    for step in "abcd":
        driver.begin(step)
    assert driver.step == "c"
    assert "(d) comes when (c) is done" in driver.refusal


def seen(robot: object, tick: int, **more: object) -> Seen:
    joints = len(robot.joints)  # type: ignore[attr-defined]
    reading = Reading(np.zeros((1, joints)), np.zeros((1, joints)), np.full((1, 10), 0.1), np.zeros(1))
    return Seen(tick, reading, **more)  # type: ignore[arg-type]


@given(seed=st.integers(0, 2**31))
@settings(max_examples=30, deadline=None)
def test_a_script_presses_no_key_faster_than_a_person(seed: int) -> None:
    script = StepScript(WHOLE, seed)
    pressed, step = [], ""
    for tick in range(120):
        asked = script.ask(seen(WHOLE, tick, step=step, done=step != "e"))
        if asked.step:
            pressed.append(tick)
            step = asked.step
    assert step == "e"
    assert all(b - a >= 2 for a, b in zip([0, *pressed], pressed, strict=False))
    assert len(pressed) >= len(STEPS)


def test_a_script_without_a_pipe_asks_for_nothing() -> None:
    assert TipScript(ARM, 0).ask(seen(ARM, 0)) == Ask()
