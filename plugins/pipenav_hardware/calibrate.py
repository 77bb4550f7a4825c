"""Finding out how an arm's servos are mounted: each moves a few degrees, and a person says what it did."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Mapping

from pydantic import ValidationError

from pipenav.backends import Calibrator, Stopped, TorqueUnconfirmed
from pipenav.errors import ConfigError, PipenavError
from pipenav.robots import RobotSpec
from pipenav.units import m_to_mm, mm_to_m, rad_to_deg
from pipenav_hardware import table
from pipenav_hardware.arm_config import (
    ArmConfig,
    FrontSensorConfig,
    ScannerConfig,
    arm_toml,
    default_arm,
)
from pipenav_hardware.dynamixel import Bus
from pipenav_hardware.serial_port import Mode
from pipenav_hardware.servo_config import Servo, reachable
from pipenav_hardware.servo_flaws import half_silent, named, require
from pipenav_hardware.servo_memory import make_ready, store_settings
from pipenav_hardware.watchdog import Watchdog

NUDGE = 40
"""Size of a nudge [counts]: 12 deg can be seen, and are less than a servo moves in a control period."""

NUDGE_SPEED = 30
"""Moving Speed of a nudge [counts]: 20 deg/s."""

NUDGE_TORQUE = 256
"""Torque Limit of a nudge [counts], a quarter: enough to move the arm, not enough to break it."""

NUDGE_TIME = 2.0
"""Longest time for a nudge [s]."""


class Calibration(Calibrator):
    """Calibration of an AX-12A arm, see `pipenav.backends.Calibrator`. Servos have the ids 1, 2, ... in joint order."""

    def __init__(self, robot: RobotSpec, ports: Mapping[str, str], may_write: bool) -> None:
        self._robot = robot
        try:
            scanner = ScannerConfig(driver="scip2", port=ports["scanner"])
            front = FrontSensorConfig(port=ports["front"]) if "front" in ports else None
            self._arm = default_arm(robot, ports["servos"], scanner, front)
        except ValidationError as error:  # a name that no device can have
            raise ConfigError.from_validation("an arm at these ports", error) from error
        self.joints = [servo.joint for servo in self._arm.servos]
        self._bus = Bus(self._arm.port, self._arm.baud)
        self._torque, self._turned = False, NUDGE * table.COUNT
        self._unconfirmed: list[str] = []
        try:
            for servo in self._arm.servos:
                self._refuse_unfit(servo, may_write)
            self._watchdog = Watchdog(self._bus.descriptor, servos=self._arm.joints)
        except BaseException:
            self._bus.close()
            raise

    def set_zero(self) -> None:
        for index in range(len(self.joints)):
            self._change(index, zero_count=float(self._position(index)))

    def nudge(self, joint: str) -> float:
        index = self.joints.index(joint)
        servo, start = self._arm.servos[index].id, self._position(index)
        goal_counts = min(start + NUDGE, table.COUNTS)
        self._watchdog.armed()
        self._torque, self._bus.mode = True, Mode.DRIVE
        try:
            values = {
                table.TORQUE_LIMIT: NUDGE_TORQUE,
                table.MOVING_SPEED: NUDGE_SPEED,
                table.GOAL_POSITION: start,
                table.TORQUE_ENABLE: 1,
            }
            for register, value in values.items():
                if not self._bus.write_register(servo, register, value):
                    raise Stopped("comms", f"servo {servo} ({joint}) does not take a value", "check its cable")
            self._bus.write_register(servo, table.GOAL_POSITION, goal_counts)
            deadline = time.monotonic() + NUDGE_TIME
            while abs(goal_counts - self._position(index)) > 2 and time.monotonic() < deadline:
                self._watchdog.beat()
                time.sleep(0.05)
        finally:
            unconfirmed = self.off()
        if unconfirmed:
            raise TorqueUnconfirmed(unconfirmed)
        self._turned = (self._position(index) - start) * table.COUNT
        return self._turned

    def set_direction(self, joint: str, positive: bool, moved_mm: float | None) -> None:
        index = self.joints.index(joint)
        changes: dict[str, float | int] = {"sign": 1 if positive else -1}
        if moved_mm is not None:
            changes["pinion_radius_mm"] = round(abs(moved_mm / self._turned), 2)
        self._change(index, **changes)

    def text(self) -> str:
        return arm_toml(self._arm)

    def write_servos(self) -> list[str]:
        return store_settings(self._arm, self._bus)

    def cut(self) -> None:
        if self._torque:
            self._bus.cut()

    def off(self) -> list[str]:
        if not self._torque:
            return []
        silent = self._bus.off(self._arm.ids)
        self._torque = bool(silent)
        if not silent:
            self._watchdog.disarmed()
        self._unconfirmed = [servo.joint for servo in self._arm.servos if servo.id in silent]
        return self._unconfirmed

    def close(self) -> None:
        named, unconfirmed = self._unconfirmed, self.off()
        with contextlib.suppress(OSError):
            self._bus.close()
        self._watchdog.close()
        if unconfirmed and not named:
            raise TorqueUnconfirmed(unconfirmed)

    def _refuse_unfit(self, servo: Servo, may_write: bool) -> None:
        """Refuse a servo that does not answer, or that could not be stopped by its angle limits.

        Args:
            servo: the servo.
            may_write: whether it may be given settings that make it fit.
        """
        if may_write and self._bus.ping(servo.id).data is not None:
            make_ready(servo, self._bus)
        model = self._bus.read_register(servo.id, table.MODEL)
        if model is None:
            require(half_silent(servo, self._bus, "add --write-servos, which has it answer"))
            raise PipenavError(
                f"{named(servo)} does not answer: check its cable, and give the servos ids from 1 on, in joint order."
            )
        if model != table.MODEL_NUMBER:
            raise PipenavError(f"{named(servo)} says it is model {model}, an AX-12A is model 12: replace it.")
        endless = self._bus.read_register(servo.id, table.CW_LIMIT) == 0
        endless &= self._bus.read_register(servo.id, table.CCW_LIMIT) == 0
        if endless and not (may_write and self._give_a_turn(servo)):
            raise PipenavError(
                f"{named(servo)} is in wheel mode and would turn forever: add --write-servos, which limits it."
            )

    def _give_a_turn(self, servo: Servo) -> bool:
        """Take a servo out of wheel mode; whether it is."""
        self._bus.mode = Mode.DRIVE
        try:
            return self._bus.write_register(servo.id, table.CCW_LIMIT, table.COUNTS)
        finally:
            self._bus.mode = Mode.STOPPED

    def _position(self, index: int) -> int:
        """Position of a joint's servo [counts]."""
        position = self._bus.read_register(self._arm.servos[index].id, table.PRESENT_POSITION)
        if position is None:
            raise PipenavError(f"servo {self._arm.servos[index].id} ({self.joints[index]}) does not answer any more.")
        return position

    def _change(self, index: int, **changes: float | int) -> None:
        """Change how one servo is mounted; its limits become what it then reaches of the robot's own."""
        servo, joint = self._arm.servos[index], self._robot.joints[index]
        values = servo.model_dump() | changes
        unit = mm_to_m(values["pinion_radius_mm"]) if servo.drive == "pinion" else 1.0
        convert, name = (m_to_mm, "mm") if servo.drive == "pinion" else (rad_to_deg, "deg")
        ends = reachable(joint.lower, joint.upper, values["sign"], values["zero_count"], unit)
        lower, upper = math.ceil(100 * convert(ends.lower)) / 100, math.floor(100 * convert(ends.upper)) / 100
        if not lower < 0 < upper:
            raise PipenavError(
                f"servo {servo.id} ({servo.joint}) is at {values['zero_count']:.0f} counts, at the end of its turn: "
                "mount its horn so that the straight arm lies within its 300 deg."
            )
        values |= {f"lower_{name}": lower, f"upper_{name}": upper}
        servos = [mounted.model_dump() for mounted in self._arm.servos]
        servos[index] = values
        self._arm = ArmConfig.model_validate(self._arm.model_dump() | {"servos": servos})
