"""The checks of `pipenav hw-check`: every bus speed, every servo, every sensor. They ask and change nothing."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from pathlib import Path

from pipenav.backends import Finding
from pipenav.errors import PipenavError
from pipenav.robots import load_robot
from pipenav.units import m_to_mm, rad_to_deg
from pipenav_hardware import table
from pipenav_hardware.arm_config import DEFAULT_ARM, ArmConfig
from pipenav_hardware.dynamixel import Bus
from pipenav_hardware.sensor_check import sensor_findings
from pipenav_hardware.servo_config import Servo
from pipenav_hardware.servo_flaws import (
    PING_BYTES,
    half_silent,
    memory_flaws,
    named,
    speed_flaw,
    storing,
    wire_time,
)
from pipenav_hardware.servo_search import Stray, search
from pipenav_hardware.servos import PINGS, latency_finding
from pipenav_hardware.trips import HOT, LEAST_VOLTS, MOST_VOLTS, WARN_VOLTS

LIVE = (table.SETTINGS_ADDRESS, table.LOCK.end - table.SETTINGS_ADDRESS)
"""Address and size of a READ that brings settings, state and lock."""


def findings(arm: ArmConfig, path: Path = DEFAULT_ARM, allow_slow: bool = False) -> Iterator[Finding]:
    """Everything about an arm, in the order in which a person would look at it.

    Args:
        arm: the arm's description.
        path: file of the description.
        allow_slow: whether a slow adapter is accepted.
    """
    try:
        arm.require(load_robot(arm.robot))
    except PipenavError as error:
        yield Finding("problem", str(error))
    if flaw := speed_flaw(arm):
        yield flaw
    try:
        bus = Bus(arm.port, arm.baud)
    except PipenavError as error:
        yield Finding("problem", str(error))
    else:
        try:
            yield Finding("ok", f"port {arm.port} opened at {arm.baud} baud")
            yield from _servo_findings(arm, bus, storing(path), allow_slow)
        except PipenavError as error:
            yield Finding("problem", str(error))
        finally:
            bus.close()
    yield from sensor_findings(arm)


def _servo_findings(arm: ArmConfig, bus: Bus, store: str, allow_slow: bool) -> Iterator[Finding]:
    """Everything about the servos: each of them, where missing ones may be, how fast they answer."""
    if bus.echoes():
        yield Finding("problem", "the adapter echoes what is sent", "use a USB2Dynamixel or a U2D2")
        return
    missing = []
    for servo in arm.servos:
        found = list(_one_servo(servo, bus, store))
        if not found:
            missing.append(servo)
        yield from found
    if missing:
        yield Finding("warning", f"{len(missing)} missing, looked for at every speed and id", "it takes a minute")
    elsewhere = search(arm, bus, len(missing)) if missing else []
    for servo in missing:
        yield _missing(arm, servo, elsewhere)
    if not missing:
        yield _latency(arm, bus, allow_slow)


def _one_servo(servo: Servo, bus: Bus, store: str) -> Iterator[Finding]:
    """Everything that a servo says about itself; nothing if it does not answer."""
    name = named(servo)
    memory = bus.read(servo.id, *table.EEPROM)
    answer = bus.read(servo.id, *LIVE)
    if memory.data is None or answer.data is None:
        if "damaged" in memory.problem:
            yield Finding("problem", f"{name}: damaged answers", "two servos may have this id: connect them one by one")
        elif finding := half_silent(servo, bus, store):
            yield finding
        return
    eeprom = table.decode_eeprom(memory.data)
    state = table.decode_state(answer.data[table.SETTINGS_SIZE : table.SETTINGS_SIZE + table.STATE_SIZE])
    position = servo.to_position(state.position)
    shown = f"{m_to_mm(position):.1f} mm" if servo.drive == "pinion" else f"{rad_to_deg(position):.1f} deg"
    yield Finding(
        "ok",
        f"{name}: model {eeprom.model}, firmware {eeprom.firmware}, {state.decivolts / 10:.1f} V, "
        f"{state.temperature} deg C, position {state.position} ({shown}), limits {eeprom.limits[0]}-{eeprom.limits[1]}",
    )
    yield from memory_flaws(servo, eeprom, store)
    yield from _state_flaws(servo, name, state, answer.alarms)
    if answer.data[0]:
        yield Finding("warning", f"{name}: torque is on and no program drives it", "switch the supply off and on")
    if answer.data[-1]:
        yield Finding("warning", f"{name}: its EEPROM is locked", "switch its supply off and on before storing")


def _state_flaws(servo: Servo, name: str, state: table.State, alarms: table.Alarm) -> Iterator[Finding]:
    """Reasons why a servo should not be switched on now."""
    volts = state.decivolts / 10
    if not servo.count_limits.lower <= state.position <= servo.count_limits.upper:
        yield Finding("problem", f"{name} stands outside its limits", "move it back by hand")
    if not LEAST_VOLTS <= volts <= MOST_VOLTS:
        yield Finding("problem", f"{name} gets {volts:.1f} V", f"supply {LEAST_VOLTS:g} to {MOST_VOLTS:g} V")
    elif volts < WARN_VOLTS:
        yield Finding("warning", f"{name} gets only {volts:.1f} V", "use a stronger supply or thicker cable")
    if state.temperature >= HOT:
        yield Finding("problem", f"{name} is at {state.temperature} deg C", "let it cool for 20 minutes")
    if alarms:
        names = ", ".join(str(bit.name).lower() for bit in table.Alarm if bit & alarms)
        yield Finding(
            "problem", f"{name} reports {names}", "look for what holds or heats it, then switch the supply off and on"
        )


def _missing(arm: ArmConfig, servo: Servo, elsewhere: list[Stray]) -> Finding:
    """The finding about a servo that does not answer: where it may be."""
    name = f"{named(servo)} does not answer"
    for stray in elsewhere:
        if stray.id == servo.id:
            value = table.BAUD_VALUES[arm.baud]
            remedy = f"set its register 4 to {value}, for {arm.baud}, with the maker's tool"
            return Finding("problem", f"{name} at {arm.baud} baud but at {stray.baud}", remedy)
    index = arm.ids.index(servo.id)
    before = arm.servos[index - 1]
    cable = "the power supply and the cable from the adapter to it"
    if index:
        cable = f"the cable from {named(before)} to it"
    others = [f"{stray.id}" + f" at {stray.baud} baud" * (stray.baud != arm.baud) for stray in elsewhere]
    strays = f"; or it is the one with id {', '.join(others)}" if others else ""
    return Finding("problem", name, f"check {cable}{strays}")


def _latency(arm: ArmConfig, bus: Bus, allow_slow: bool) -> Finding:
    """Finding about the time that the servos take to answer."""
    times = []
    for i in range(PINGS):
        start = time.monotonic()
        bus.ping(arm.ids[i % len(arm.ids)])
        times.append(time.monotonic() - start)
    waiting = statistics.median(times) - wire_time(PING_BYTES, arm.baud)
    finding = latency_finding(waiting, allow_slow)
    if finding.level == "problem" or allow_slow:
        return finding
    return speed_flaw(arm, waiting) or finding
