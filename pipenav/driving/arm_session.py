"""Driving the real arm by hand: the same limits, trips and torque-off as in every mission."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Command, Reading
from pipenav.backends.real_robot import RealRobot
from pipenav.backends.safety import Stopped
from pipenav.deployment.guard import guarded
from pipenav.deployment.loop import control_loop
from pipenav.deployment.mission import mission_of
from pipenav.deployment.plan import POLICY_COPY, TELEMETRY
from pipenav.deployment.session import Ending, policy_record, rehearse
from pipenav.deployment.stages import Decision
from pipenav.deployment.telemetry import Telemetry
from pipenav.driving.ask import PERSON, POLICY, OperatorLost
from pipenav.driving.door import Door, Scene
from pipenav.errors import FileProblem
from pipenav.policies.header import installed_versions
from pipenav.policies.policy import Policy
from pipenav.robots import kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.storage.atomic_files import atomic_write

LOST_TICKS = 2
"""Ticks for which the arm holds when a person's device is gone, before it is stopped: as when a servo is silent."""


class ArmScene(NamedTuple):
    """Surroundings of the arm, as far as they are known, and when the session ends by itself.

    Attributes:
        scene: the pipe, if it is known, and the target.
        reached: distance of the tip from the target at which the session ends [m]; 0 for never.
        folder: folder of the telemetry.
        stop_file: a file whose appearance is an emergency stop.
        most_ticks: number of ticks after which the session ends; None for no such end.
    """

    scene: Scene
    reached: float
    folder: Path
    stop_file: Path
    most_ticks: int | None


class Beside(NamedTuple):
    """A policy that drives while the person does not, and its mission's settings, see `mission_settings`."""

    policy: Policy
    settings: dict[str, Any]


class HandMission:
    """A mission that a person carries out, with a policy's mission beside where there is one.

    Args:
        robot: the robot.
        door: the door.
        given: surroundings and ends.
        beside: the policy whose mission goes on while the person does not drive; None without one.

    Attributes:
        beside: the same.
        outcome: empty while it goes on.
    """

    def __init__(self, robot: RobotSpec, door: Door, given: ArmScene, beside: Beside | None) -> None:
        self._robot, self._door, self._given, self.beside = robot, door, given, beside
        self._policy = None if beside is None else mission_of(beside.policy, beside.settings)
        self._made = Decision("", None)
        self._begun = False
        self._lost = 0
        self._over: Decision | None = None
        self.outcome = ""

    @property
    def target(self) -> Floats | None:
        """Target in the robot's own frame, (2,) [m]: the policy's where one drives; None before one is known."""
        return self._given.scene.target if self._policy is None else self._policy.target

    @property
    def door(self) -> Door:
        """The door."""
        return self._door

    def back_out(self, why: str) -> bool:  # noqa: ARG002  # the signature of a mission
        """Never: a person decides what comes after a stop."""
        return False

    def decide(self, reading: Reading) -> Decision:
        """The person's command, or the policy's.

        Raises:
            Stopped: the person pressed the emergency stop, or the person's device has been gone for too long.
        """
        if not self._begun:
            self._begun = True
            self._door.start(reading, self._given.scene)
        if self._lost or not self._ask(reading):
            return self._hold()
        asked = self._door.asked
        if asked.stop:
            raise Stopped("e-stop", "the stop key was pressed", "start again when the arm is free")
        if self._over is not None and self._door.who == POLICY:
            self.outcome = self._over.stage
        elif asked.end:
            self.outcome = "ended"
        elif self._arrived(reading):
            self.outcome = "reached"
        wished = {key: value for key, value in asked._asdict().items() if value}
        if self.outcome:
            return Decision(self.outcome, None, asked=wished)
        command = Command("position", self._door.command[None])
        if self._door.who == POLICY:
            made = self._made
            return Decision(POLICY, command, made.observation, made.action, wished, made.stage)
        if self._policy is not None:
            self._policy.watch(reading, self._door.command)
        return Decision(PERSON, command, asked=wished)

    def _ask(self, reading: Reading) -> bool:
        """Ask the person; False where the device is gone."""
        try:
            self._door.next(reading, self._by_policy(reading))
        except OperatorLost as lost:
            self._lost, self._why = 0, lost
            return False
        return True

    def _by_policy(self, reading: Reading) -> Callable[[], Floats] | None:
        policy = self._policy
        if policy is None:
            return None

        def command() -> Floats:
            self._made = decision = policy.decide(reading)
            if decision.command is None:
                self._over = decision
                return self._door.command
            return np.asarray(decision.command.values[0])

        return command

    def _hold(self) -> Decision:
        """Stay, and stop when the device stays away.

        Raises:
            Stopped: it has been gone for `LOST_TICKS`.
        """
        self._lost += 1
        if self._lost > LOST_TICKS:
            what, _, remedy = str(self._why).rstrip(".").partition(": ")
            raise Stopped("operator", what, remedy)
        return Decision("hold", Command("position", self._door.command[None]), asked={})

    def _arrived(self, reading: Reading) -> bool:
        if self.target is None or not self._given.reached:
            return False
        tip = kinematics.forward(self._robot, reading.q).tip[0]
        return bool(np.hypot(*(tip - self.target)) <= self._given.reached)


def drive_by_hand(
    arm: RealRobot,
    mission: HandMission,
    given: ArmScene,
    show: Callable[[dict[str, Any]], None],
    header: dict[str, Any],
) -> Ending:
    """Switch the arm on, let a person drive it, switch it off; the telemetry is on disk then.

    Args:
        arm: the real robot, connected.
        mission: the person's mission.
        given: surroundings and ends.
        show: called with the record of every tick.
        header: what the telemetry's first line says besides the machine.
    """
    with Telemetry(given.folder / TELEMETRY) as telemetry:
        try:
            about_policy = _kept(mission.beside, given.folder)
            with guarded(arm):
                first = arm.read()
                if mission.beside is not None:
                    rehearse(*mission.beside, first)
                arm.reset(np.array([0]), [], first.q, np.zeros(1))
                try:
                    started = datetime.now(UTC).isoformat(timespec="seconds")
                    machine = {"machine": arm.description(), "versions": installed_versions()}
                    telemetry.begin({"started": started, "backend": "hardware", **header, **about_policy, **machine})
                    outcome = control_loop(arm, mission, telemetry, show, given.stop_file, given.most_ticks)
                except FileProblem as problem:
                    raise Stopped("telemetry", str(problem).rstrip("."), "make room, then start again") from problem
        except Stopped as stopped:
            with contextlib.suppress(FileProblem):  # not before torque is off: a disk may take its time
                telemetry.end("stopped", stopped.cause, stopped.what)
            return Ending(stopped.cause, stopped, list(telemetry.last))
        telemetry.end(outcome, None, "")
        return Ending(outcome, None, list(telemetry.last))


def _kept(beside: Beside | None, folder: Path) -> dict[str, Any]:
    """Keep a copy of the policy in the session's folder, and say in the telemetry's header which one it is.

    Raises:
        FileProblem: it cannot be written.
    """
    if beside is None:
        return {}
    content = beside.policy.path.read_bytes()
    atomic_write(folder / POLICY_COPY, content)
    return policy_record(beside.policy, content, beside.settings)
