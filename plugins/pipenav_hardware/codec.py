"""Translation of servo and sensor bytes into a `Reading`, and of a `Command` into servo set-points.

Nothing here has input or output: the same bytes give the same readings and packets, in a mission and in its replay.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends import CONTROL_PERIOD, Bounds, Command, Reading, Repeats, Stopped, safety
from pipenav.robots import RobotSpec
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.beam_filter import BeamFilter
from pipenav_hardware.ranging import RangeScan
from pipenav_hardware.table import COUNT, COUNTS, SPEED_UNIT, ServoGoal, State, decode_state

STEP_SLACK = 2
"""Number of counts by which a goal may be farther than one step from the servo's position: its resolution and play."""

JUMP_MARGIN = 8
"""Number of counts beyond a period's fastest motion by which a position may differ from the last and be believed."""

LIMIT_MARGIN = 8
"""Number of counts that a joint may be beyond its limits; farther stops the arm. A servo overshoots by a few."""


class Raw(NamedTuple):
    """The bytes and the scan of one tick.

    Attributes:
        states: 8 bytes from address 36 of every servo; None where it did not answer.
        scan: the newest scan if there is a new one, else None.
        front: distance ahead [m]; None without a reading.
        time: time since the start [s].
    """

    states: tuple[bytes | None, ...]
    scan: RangeScan | None
    front: float | None
    time: float


class Encoded(NamedTuple):
    """A command as it may be sent.

    Attributes:
        goals: id of a servo -> its goal; empty if nothing may be sent.
        clamped: joints whose set-point was changed, (joints,).
        positions: the set-points in joint coordinates, (joints,) [rad or m].
    """

    goals: dict[int, ServoGoal]
    clamped: tuple[bool, ...]
    positions: Floats


class Codec:
    """Decodes and encodes with what a tick needs of the ticks before: positions, set-points, the history of the beams.

    Attributes:
        speeds: Moving Speed of every servo, at the joint's speed limit, never 0 [counts].
        bounds: limits of the goals [counts].
        states: last state of every servo that was believed; None before the first.
        last: last goals, (joints,) [counts]; None before the first.
        problem: why the last reading was not whole; empty where it was.
    """

    def __init__(self, robot: RobotSpec, arm: ArmConfig, beams: BeamFilter) -> None:
        self._arm, self._beams = arm, beams
        units = np.array([servo.unit for servo in arm.servos])
        fastest = robot.speed_limits / units  # at the servos, (joints,) [rad/s]
        self.speeds = [max(1, math.floor(speed / SPEED_UNIT)) for speed in fastest]
        step = np.maximum(np.floor(fastest * CONTROL_PERIOD / COUNT), 1.0)
        limits = arm.count_limits
        self.bounds = Bounds(limits[:, 0], limits[:, 1], step, np.full(len(step), float(STEP_SLACK)))
        self.states: list[State | None] = [None] * len(arm.servos)
        self.last: Floats | None = None
        self._ranges: Floats | None = None
        self._implausible = [Repeats(1) for _ in arm.servos]
        self._age = np.zeros(len(arm.servos))  # ticks since each servo's position was last taken over
        self._stuck = Repeats(1)
        self.problem = ""

    @property
    def present(self) -> Floats:
        """Last positions, (joints,) [counts]."""
        return np.array([state.position for state in self.states if state is not None], float)

    def decode(self, raw: Raw) -> Reading | None:
        """The reading of one robot; None if a servo's state is missing or not to be believed, see `problem`.

        Raises:
            Stopped: a position that cannot be, twice in a row, or a joint beyond its limits.
        """
        self.problem = ""
        self._age += 1
        for i, (servo, data) in enumerate(zip(self._arm.servos, raw.states, strict=True)):
            if data is None:
                self.problem = f"servo {servo.id} ({servo.joint}) does not answer"
                continue
            state = decode_state(data)
            if self._implausible[i].broken(wrong := self._is_jump(i, state)):
                raise Stopped(
                    "jump",
                    f"servo {servo.id} ({servo.joint}) jumped from {self._known(i)} to {state.position} counts",
                    "its potentiometer or its cable is bad: look at both",
                )
            if wrong:
                self.problem = f"servo {servo.id} ({servo.joint}) reads an impossible position"
                continue
            self.states[i], self._age[i] = state, 0
            low, high = servo.count_limits
            if not low - LIMIT_MARGIN <= state.position <= high + LIMIT_MARGIN:
                raise Stopped(
                    "limit",
                    f"joint {servo.joint} is beyond its limits ({state.position} counts, allowed {low} to {high})",
                    "move it back by hand with the power off",
                )
        if raw.scan is not None:
            self._ranges = self._beams.beams(raw.scan, raw.front)
        if self.problem or self._ranges is None or None in self.states:
            return None
        known = [state for state in self.states if state is not None]
        q = [servo.to_position(state.position) for servo, state in zip(self._arm.servos, known, strict=True)]
        qd = [s.sign * state.speed * SPEED_UNIT * s.unit for s, state in zip(self._arm.servos, known, strict=True)]
        return Reading(np.array([q]), np.array([qd]), self._ranges[None].copy(), np.array([raw.time]))

    def encode(self, command: Command) -> Encoded:
        """Set-points of a command, limited. They count as sent.

        Raises:
            Stopped: values that are not finite, or no set-point that would do, twice in a row.
        """
        if command.control != "position":
            raise Stopped("control", "the servos take positions, not torques", "use a policy with position control")
        values = safety.require_finite(np.ravel(np.asarray(command.values, object)), "an action")
        if values.shape != (len(self._arm.servos),):
            raise Stopped("shape", f"{values.size} values came for {len(self._arm.servos)} joints", "check the policy")
        with np.errstate(over="ignore"):
            counts = [servo.to_counts(value) for servo, value in zip(self._arm.servos, values, strict=True)]
        wanted = np.round(np.clip(counts, -10 * COUNTS, 10 * COUNTS))  # finite but huge: limited below in any case
        present = self.present
        last = present if self.last is None else self.last
        result = safety.limited(wanted, present, last, self.bounds)
        if self._stuck.broken(bool(result.empty.any())):
            joint = self._arm.servos[int(np.argmax(result.empty))].joint
            raise Stopped(
                "lost-step",
                f"joint {joint} is farther from its last goal than it can move in a tick",
                "something pushes it, or the bus loses goals: look at the arm and run pipenav hw-check",
            )
        if result.empty.any():
            return Encoded({}, tuple(map(bool, result.clamped)), self._positions(last))
        self.last = result.set_points
        pairs = zip(self._arm.ids, result.set_points, self.speeds, strict=True)
        goals = {servo: ServoGoal(int(counts), speed) for servo, counts, speed in pairs}
        return Encoded(goals, tuple(map(bool, result.clamped)), self._positions(result.set_points))

    def _positions(self, counts: Floats) -> Floats:
        return np.array([servo.to_position(count) for servo, count in zip(self._arm.servos, counts, strict=True)])

    def _known(self, i: int) -> int | None:
        state = self.states[i]
        return None if state is None else state.position

    def _is_jump(self, i: int, state: State) -> bool:
        before = self._known(i)
        return before is not None and abs(state.position - before) > self._age[i] * self.bounds.step[i] + JUMP_MARGIN
