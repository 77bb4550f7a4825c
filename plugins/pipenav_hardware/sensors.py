"""The arm's sensors together: its scanner, and the front sensor where there is one."""

from __future__ import annotations

import contextlib
import math
import select
import time

from pipenav.backends import Stopped
from pipenav.robots import RobotSpec
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.front_sensor import FrontSensor
from pipenav_hardware.ranging import RangeSensor, SensorLost, await_scan
from pipenav_hardware.scip2 import open_scanner

FRESH_TIMEOUT = 1.0
"""Longest wait for two scans that were taken after a pause [s]."""

POLL_PERIOD = 0.005
"""Longest wait between two looks at a sensor that has no descriptor to wait for [s]."""


class Sensors:
    """Sensors that are listened to together, until they are closed.

    Attributes:
        scanner: the range scanner at the tip.
        front: the front distance sensor; None where the arm has none.
    """

    def __init__(self, arm: ArmConfig, robot: RobotSpec) -> None:
        with contextlib.ExitStack() as opened:
            self.scanner: RangeSensor = open_scanner(arm.scanner, math.radians(robot.laser.fan_deg))
            opened.callback(self.scanner.close)
            self.front = FrontSensor(arm.front_sensor) if arm.front_sensor else None
            if self.front is not None:
                opened.callback(self.front.close)
            self._opened = opened.pop_all()

    def listen(self, now: float) -> None:
        """Take in what has arrived.

        Raises:
            Stopped: a sensor is gone.
        """
        try:
            self.scanner.pump(now)
            if self.front is not None:
                self.front.pump(now)
        except SensorLost as lost:
            raise Stopped("sensor-lost", str(lost).rstrip("."), "then start again") from lost

    def refresh(self) -> None:
        """Drop what was sent during a pause, and wait for scans that were taken after it."""
        self.listen(time.monotonic())
        for _ in range(2):  # the first of them may have begun before
            self.await_scan(FRESH_TIMEOUT / 2)

    def await_scan(self, timeout: float) -> None:
        """Wait until the next scan has just come, or for `timeout` [s]."""
        await_scan(self.scanner, self.listen, timeout)

    def listen_until(self, due: float) -> None:
        """Take in what arrives until a moment of the monotonic clock [s]."""
        sensors = [sensor for sensor in (self.scanner, self.front) if sensor is not None]
        descriptors = [sensor.fileno() for sensor in sensors if sensor.fileno() >= 0]
        while (left := due - time.monotonic()) > 0:
            select.select(descriptors, [], [], left)
            self.listen(time.monotonic())
            if len(descriptors) < len(sensors):
                time.sleep(min(POLL_PERIOD, max(0.0, due - time.monotonic())))

    def close(self) -> None:
        """Close all of them."""
        self._opened.close()
