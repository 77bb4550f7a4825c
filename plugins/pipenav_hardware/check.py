"""The checks of `pipenav hw-check`: every bus speed, every servo, every sensor. They ask and change nothing."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator

from pipenav.backends import Finding
from pipenav.errors import PipenavError
from pipenav.units import m_to_mm, rad_to_deg
from pipenav_hardware import table
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.dynamixel import Bus
from pipenav_hardware.front_sensor import FrontSensor
from pipenav_hardware.scip2 import open_scanner
from pipenav_hardware.servo_config import Servo
from pipenav_hardware.servos import LATENCY_REMEDY, PINGS, SLOW
from pipenav_hardware.trips import HOT, LEAST_VOLTS, MOST_VOLTS, WARN_VOLTS

OTHER_IDS = (0, 1, 2, 3, 4, 5, 6, 7, 8)
"""Ids that are looked for besides the arm's own: people give these to an arm's servos."""


def findings(arm: ArmConfig) -> Iterator[Finding]:
    """Everything about an arm, in the order in which a person would look at it."""
    try:
        bus = Bus(arm.port, arm.baud)
    except PipenavError as error:
        yield Finding("problem", str(error))
    else:
        try:
            yield Finding("ok", f"port {arm.port} opened at {arm.baud} baud")
            yield from _servo_findings(arm, bus)
        except PipenavError as error:
            yield Finding("problem", str(error))
        finally:
            bus.close()
    yield from _sensor_findings(arm)


def _servo_findings(arm: ArmConfig, bus: Bus) -> Iterator[Finding]:
    """Everything about the servos: each of them, where missing ones may be, how fast they answer."""
    if bus.echoes():
        yield Finding("problem", "the adapter sends back what is sent", "use a USB2Dynamixel or a U2D2")
        return
    missing = []
    for servo in arm.servos:
        found = list(_one_servo(servo, bus))
        if not found:
            missing.append(servo)
        yield from found
    elsewhere = _elsewhere(arm, bus) if missing else {}
    for servo in missing:
        yield _missing(arm, servo, elsewhere)
    if not missing:
        yield from _latency(arm, bus)


def _one_servo(servo: Servo, bus: Bus) -> Iterator[Finding]:
    """Everything that a servo says about itself; nothing if it does not answer."""
    name = f"servo {servo.id} ({servo.joint})"
    memory = bus.read(servo.id, *table.EEPROM)
    answer = bus.read(servo.id, table.STATE_ADDRESS, table.STATE_SIZE)
    if memory.data is None or answer.data is None:
        if "damaged" in memory.problem:
            yield Finding("problem", f"{name}: damaged answers", "two servos may have this id: connect them one by one")
        return
    eeprom, state = table.decode_eeprom(memory.data), table.decode_state(answer.data)
    position = servo.to_position(state.position)
    shown = f"{m_to_mm(position):.1f} mm" if servo.drive == "pinion" else f"{rad_to_deg(position):.1f} deg"
    yield Finding(
        "ok",
        f"{name}: model {eeprom.model}, firmware {eeprom.firmware}, {state.decivolts / 10:.1f} V, "
        f"{state.temperature} deg C, position {state.position} ({shown}), limits {eeprom.limits[0]}-{eeprom.limits[1]}",
    )
    yield from _memory_flaws(servo, name, eeprom)
    yield from _state_flaws(servo, name, state, answer.alarms)


def _memory_flaws(servo: Servo, name: str, eeprom: table.Eeprom) -> Iterator[Finding]:
    """Settings in a servo's EEPROM that are not the arm's."""
    store = "store the arm's settings in the servos: pipenav calibrate --write-servos"
    if eeprom.model != table.MODEL_NUMBER:
        yield Finding("problem", f"{name} is no AX-12A (model {eeprom.model})", "replace it")
    if eeprom.limits == table.WHEEL_MODE:
        yield Finding("problem", f"{name} is in wheel mode", store)
    elif eeprom.limits != servo.count_limits:
        yield Finding("problem", f"{name}: angle limits are {eeprom.limits}, arm.toml says {servo.count_limits}", store)
    if eeprom.max_torque > servo.torque_counts:
        yield Finding("problem", f"{name}: max torque is above what arm.toml allows ({servo.torque_counts})", store)
    if eeprom.return_level != 2:
        yield Finding("problem", f"{name}: status return level {eeprom.return_level}, 2 is needed", store)
    if eeprom.return_delay:
        yield Finding("warning", f"{name} waits {2 * eeprom.return_delay} us before answering", store)


def _state_flaws(servo: Servo, name: str, state: table.State, alarms: table.Alarm) -> Iterator[Finding]:
    """Reasons why a servo should not be switched on now."""
    volts = state.decivolts / 10
    if not servo.count_limits[0] <= state.position <= servo.count_limits[1]:
        yield Finding("problem", f"{name} stands outside its limits", "move it back by hand")
    if not LEAST_VOLTS <= volts <= MOST_VOLTS:
        yield Finding("problem", f"{name} gets {volts:.1f} V", f"supply {LEAST_VOLTS:g} to {MOST_VOLTS:g} V")
    elif volts < WARN_VOLTS:
        yield Finding("warning", f"{name} gets only {volts:.1f} V", "use a stronger supply or thicker cable")
    if state.temperature >= HOT:
        yield Finding("problem", f"{name} is at {state.temperature} deg C", "let it cool for 20 minutes")
    if alarms:
        names = ", ".join(str(bit.name).lower() for bit in table.Alarm if bit & alarms)
        yield Finding("problem", f"{name} reports {names}", "see docs/guides/the-arm.md, Trips")


def _elsewhere(arm: ArmConfig, bus: Bus) -> dict[int, list[int]]:
    """Ids that answer at each bus speed, and that are not where arm.toml has them."""
    found: dict[int, list[int]] = {}
    for baud in sorted(table.BAUD_VALUES, reverse=True):
        bus.open(baud)
        ids = sorted({*arm.ids, *OTHER_IDS})
        answering = [servo for servo in ids if bus.ping(servo).data is not None]
        stray = [servo for servo in answering if baud != arm.baud or servo not in arm.ids]
        if stray:
            found[baud] = stray
    bus.open(arm.baud)
    return found


def _missing(arm: ArmConfig, servo: Servo, elsewhere: dict[int, list[int]]) -> Finding:
    """A servo that does not answer, and where it may be."""
    index = arm.ids.index(servo.id)
    name = f"servo {servo.id} ({servo.joint}) does not answer"
    for baud, ids in elsewhere.items():
        if servo.id in ids:
            return Finding("problem", f"{name} at {arm.baud} baud but at {baud}", f"set its register 4 for {arm.baud}")
    before = arm.servos[index - 1]
    cable = "the power supply and the cable from the adapter to it"
    if index:
        cable = f"the cable from servo {before.id} ({before.joint}) to it"
    others = sorted({other for ids in elsewhere.values() for other in ids} - set(arm.ids))
    strays = f"; or it is the one with id {', '.join(map(str, others))}" if others else ""
    return Finding("problem", name, f"check {cable}{strays}")


def _latency(arm: ArmConfig, bus: Bus) -> Iterator[Finding]:
    """How fast the servos answer."""
    times = []
    for i in range(PINGS):
        start = time.monotonic()
        bus.ping(arm.ids[i % len(arm.ids)])
        times.append(time.monotonic() - start)
    latency = statistics.median(times)
    text = f"servos answer after {latency * 1e3:.1f} ms (median of {PINGS})"
    yield Finding("warning", text, LATENCY_REMEDY) if latency > SLOW else Finding("ok", text)


def _sensor_findings(arm: ArmConfig) -> Iterator[Finding]:
    """Everything about the scanner and the front sensor."""
    try:
        scanner = open_scanner(arm.scanner, 0.5)
        scan = scanner.latest()
        seen = sum(value >= scanner.range_min * 1e3 for value in scan.distances) if scan else 0
        reach = f"{scanner.range_min * 1e3:.0f} to {scanner.range_max * 1e3:.0f} mm"
        yield Finding(
            "ok", f"scanner {arm.scanner.driver}: {reach}, {seen} of {len(scanner.angles)} middle points valid"
        )
        scanner.close()
    except PipenavError as error:
        yield Finding("problem", str(error))
    if arm.front_sensor is None:
        return
    try:
        front = FrontSensor(arm.front_sensor)
        distance = "nothing within reach" if front.distance is None else f"{front.distance * 1e3:.0f} mm"
        yield Finding("ok", f"front sensor: {distance}")
        front.close()
    except PipenavError as error:
        yield Finding("problem", str(error))
