"""The arm `basic` and what its servos and its scanner may say."""

from __future__ import annotations

import numpy as np
from pipenav_hardware import packets, table
from pipenav_hardware.arm_config import ArmConfig, FrontSensorConfig, ScannerConfig, default_arm
from pipenav_hardware.codec import Raw
from pipenav_hardware.ranging import RangeScan

from pipenav.robots.robot import load_robot

ROBOT = load_robot("basic")


SCANNER = ScannerConfig(driver="scip2", port="scanner")


ARM = default_arm(ROBOT, "bus", SCANNER, FrontSensorConfig(port="front"))


ANGLES = np.deg2rad(np.arange(-95.0, 95.5, 0.5))


def state(position: int, speed: int = 0, load: int = 0) -> bytes:
    """Bytes of one servo's state, without load and speed where none are given."""
    return packets.words(position, table.raw_signed(speed), table.raw_signed(load)) + bytes([120, 30])


def scan(millimetres: int = 200, sequence: int = 1) -> RangeScan:
    """A scan whose points are all equally far away."""
    return RangeScan((millimetres,) * len(ANGLES), 0.0, sequence)


def raw(*positions: int | None, with_scan: bool = True) -> Raw:
    """The raw data of one tick: positions of the servos, None where one did not answer, and a scan."""
    states = tuple(None if position is None else state(position) for position in positions)
    return Raw(states, scan() if with_scan else None, None, 0.1)


def home(arm: ArmConfig = ARM) -> list[int]:
    """Counts at which every joint is at 0."""
    return [round(servo.to_counts(0.0)) for servo in arm.servos]
