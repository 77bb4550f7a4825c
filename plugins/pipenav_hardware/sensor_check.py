"""The checks of the arm's sensors, for `pipenav hw-check`."""

from __future__ import annotations

from collections.abc import Iterator

from pipenav.backends import Finding
from pipenav.errors import PipenavError
from pipenav_hardware.arm_config import ArmConfig, FrontSensorConfig, ScannerConfig
from pipenav_hardware.front_sensor import FrontSensor
from pipenav_hardware.scip2 import open_scanner

FAN = 0.5
"""Width of the scan that a check takes [rad]."""


def sensor_findings(arm: ArmConfig) -> Iterator[Finding]:
    """Everything about the scanner and the front sensor."""
    try:
        yield _scanner(arm.scanner)
    except PipenavError as error:
        yield Finding("problem", str(error))
    if arm.front_sensor is None:
        return
    try:
        yield _front(arm.front_sensor)
    except PipenavError as error:
        yield Finding("problem", str(error))


def _scanner(config: ScannerConfig) -> Finding:
    scanner = open_scanner(config, FAN)
    try:
        scan = scanner.latest()
        seen = sum(value >= scanner.range_min * 1e3 for value in scan.distances) if scan else 0
        reach = f"{scanner.range_min * 1e3:.0f} to {scanner.range_max * 1e3:.0f} mm"
        what = f"scanner {config.driver}: {reach}, {seen} of {len(scanner.angles)} middle points valid"
        says = f", says: {scanner.words}" if scanner.words else ""
        if not seen:
            return Finding("warning", f"{what}{says}", "clean its window, or hold something before it")
        return Finding("ok", f"{what}{says}")
    finally:
        scanner.close()


def _front(config: FrontSensorConfig) -> Finding:
    front = FrontSensor(config)
    try:
        distance = "nothing within reach" if front.distance is None else f"{front.distance * 1e3:.0f} mm"
        return Finding("ok", f"front sensor: {distance}")
    finally:
        front.close()
