"""A tick and an arm as the telemetry holds them, and the arithmetic of a recorded arm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipenav.backends import Recoder, Sent, ServoHealth
from pipenav.robots import RobotSpec
from pipenav_hardware import packets
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.beam_filter import BeamFilter
from pipenav_hardware.codec import Codec, Encoded, Raw
from pipenav_hardware.ranging import RangeScan, RangeSensor
from pipenav_hardware.table import SHARE_UNIT, Alarm, decode_state


def sent_command(arm: ArmConfig, encoded: Encoded) -> Sent:
    """A command as it was sent, or as it would have been."""
    packet = packets.goal_packet(encoded.goals).hex() if encoded.goals else ""
    clamped = [servo.joint for servo, was in zip(arm.servos, encoded.clamped, strict=True) if was]
    return Sent([float(value) for value in encoded.positions], clamped, packet)


def tick_record(raw: Raw, alarms: Sequence[Alarm]) -> dict[str, Any]:
    """The bytes, the alarms and the scan of a tick, for the telemetry."""
    scan = raw.scan
    return {
        "states": [None if data is None else data.hex() for data in raw.states],
        "alarms": [int(alarm) for alarm in alarms],
        "scan_mm": None if scan is None else list(scan.distances),
        "scan_sequence": None if scan is None else scan.sequence,
        "front_m": raw.front,
        "time": raw.time,
    }


def recorded_raw(record: Mapping[str, Any]) -> Raw:
    """The bytes and the scan in a `tick_record`."""
    states = tuple(None if text is None else bytes.fromhex(text) for text in record["states"])
    scan = None if record["scan_mm"] is None else RangeScan(tuple(record["scan_mm"]), 0.0, record["scan_sequence"])
    return Raw(states, scan, record["front_m"], record["time"])


def arm_description(
    arm: ArmConfig, scanner: RangeSensor, start_goals: list[int] | None, latency: float
) -> dict[str, Any]:
    """The facts about an arm that a replay needs.

    Args:
        arm: the arm's description.
        scanner: its scanner.
        start_goals: goals with which torque came on, in joint order [counts]; None where it never did.
        latency: median answer time of the servo bus [s].
    """
    return {
        "arm": arm.model_dump(mode="json"),
        "scanner": {
            "angles": scanner.angles.tolist(),
            "range_min": scanner.range_min,
            "range_max": scanner.range_max,
        },
        "start_goals": start_goals,
        "latency": latency,
    }


def recorded_arithmetic(robot: RobotSpec, description: Mapping[str, Any]) -> Recoder:
    """The arithmetic of the arm in an `arm_description`."""
    arm, scanner = ArmConfig.model_validate(description["arm"]), description["scanner"]
    beams = BeamFilter(robot.laser, np.array(scanner["angles"]), scanner["range_min"], scanner["range_max"])
    codec = Codec(robot, arm, beams)
    if description["start_goals"] is not None:
        codec.last = np.array(description["start_goals"], float)
    return Recoder(
        lambda record: codec.decode(recorded_raw(record)),
        lambda command: sent_command(arm, codec.encode(command)),
        lambda record: [None if data is None else servo_health(data) for data in recorded_raw(record).states],
    )


def servo_health(data: bytes) -> ServoHealth:
    """Load, supply and temperature in the bytes of a servo's state."""
    state = decode_state(data)
    return ServoHealth(state.load * SHARE_UNIT, state.decivolts / 10, float(state.temperature))
