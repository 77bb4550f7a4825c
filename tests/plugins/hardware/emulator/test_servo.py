"""The emulated servo, byte for byte as the manual has it."""

from __future__ import annotations

import pytest
from pipenav_hardware import packets, table
from pipenav_hardware.emulator.free_plant import FreePlant
from pipenav_hardware.emulator.servo import EmulatedServo
from pipenav_hardware.packets import Packet, Stream
from pipenav_hardware.table import Alarm, Register

MAX_TORQUE = 358


@pytest.fixture
def servo() -> EmulatedServo:
    return EmulatedServo(1, (43, 980), MAX_TORQUE)


def ask(servo: EmulatedServo, data: bytes) -> Packet | None:
    (instruction,) = Stream().feed(data)
    answer = servo.answer(instruction)
    if answer is None:
        return None
    (status,) = Stream().feed(answer)
    assert status.valid and status.id == servo.id
    return status


def write(servo: EmulatedServo, register: Register, value: int) -> Alarm:
    status = ask(servo, packets.write(1, register.address, value.to_bytes(register.size, "little")))
    assert status is not None
    return Alarm(status.code)


def test_golden_conversations(servo: EmulatedServo) -> None:
    assert servo.answer(next(iter(Stream().feed(packets.ping(1))))) == bytes.fromhex("FFFF010200FC")
    servo.set(table.PRESENT_TEMPERATURE, 32)
    read = bytes.fromhex("FFFF0104022B01CC")
    assert servo.answer(next(iter(Stream().feed(read)))) == bytes.fromhex("FFFF01030020DB")


@pytest.mark.parametrize(
    "data",
    [
        packets.ping(2),
        packets.TORQUE_OFF_ALL,
        packets.ping(packets.BROADCAST),
        bytes.fromhex("FFFFFE0992000201 1E0202241D"),
    ],
)
def test_what_stays_unanswered(servo: EmulatedServo, data: bytes) -> None:
    """Other ids, broadcasts, and bulk reads, which the AX-12A does not know."""
    assert ask(servo, data) is None


def test_return_levels(servo: EmulatedServo) -> None:
    reading = Packet(1, packets.READ, bytes([36, 2])).encode()
    for level, answers in ((0, (True, False, False)), (1, (True, True, False)), (2, (True, True, True))):
        servo.set(table.RETURN_LEVEL, level)
        asked = (packets.ping(1), reading, packets.write(1, 25, b"\x01"))
        assert tuple(ask(servo, data) is not None for data in asked) == answers


def test_a_wrong_checksum_is_answered_so(servo: EmulatedServo) -> None:
    damaged = bytearray(packets.write(1, 25, b"\x01"))
    damaged[-1] ^= 1
    status = ask(servo, bytes(damaged))
    assert status is not None and Alarm(status.code) == Alarm.CHECKSUM
    assert servo.get(table.LED) == 0


def test_access_rules(servo: EmulatedServo) -> None:
    assert write(servo, table.PRESENT_POSITION, 3) == Alarm.RANGE
    assert write(servo, table.TORQUE_LIMIT, 1024) == Alarm.RANGE
    assert write(servo, table.GOAL_POSITION, 981) == Alarm.ANGLE
    assert write(servo, table.GOAL_POSITION, 980) == Alarm(0)
    assert write(servo, table.MAX_TORQUE, 300) == Alarm(0)
    assert write(servo, table.TORQUE_ENABLE, 1) == Alarm(0)
    assert write(servo, table.MAX_TORQUE, 400) == Alarm.RANGE, "EEPROM while torque is on"
    assert servo.get(table.MAX_TORQUE) == 300
    status = ask(servo, Packet(1, packets.READ, bytes([48, 4])).encode())
    assert status is not None and (Alarm(status.code), status.parameters) == (Alarm.RANGE, b"")
    assert ask(servo, Packet(1, 0x55, b"").encode()) == Packet(1, Alarm.INSTRUCTION, b"")


def test_registered_writes_wait_for_action(servo: EmulatedServo) -> None:
    status = ask(servo, bytes.fromhex("FFFF01 05 04 1E F4 01 E2"))
    assert status is not None and status.code == 0
    assert (servo.get(table.REGISTERED), servo.get(table.GOAL_POSITION)) == (1, 512)
    assert ask(servo, bytes.fromhex("FFFFFE 02 05 FA")) is None
    assert (servo.get(table.REGISTERED), servo.get(table.GOAL_POSITION)) == (0, 500)
    assert ask(servo, Packet(1, packets.ACTION, b"").encode()) == Packet(1, Alarm.INSTRUCTION, b"")


def test_a_sync_write_takes_each_servo_its_own() -> None:
    servos = [EmulatedServo(i, (0, 1023), 500) for i in (1, 2)]
    data = packets.sync_write(30, {2: packets.words(300, 50), 1: packets.words(200, 40)})
    assert all(ask(servo, data) is None for servo in servos)
    assert [s.get(table.GOAL_POSITION) for s in servos] == [200, 300]
    assert [s.get(table.MOVING_SPEED) for s in servos] == [40, 50]


@pytest.mark.parametrize(("alarm", "share"), [(Alarm.OVERHEAT, 0), (Alarm.OVERLOAD, 0), (Alarm.VOLTAGE, MAX_TORQUE)])
def test_shutdown_sets_the_torque_limit_to_nothing_until_it_is_written(
    servo: EmulatedServo, alarm: Alarm, share: int
) -> None:
    """Voltage is not in the maker's default shutdown mask."""
    shaft = FreePlant(1).shafts(1.0)[0]
    servo.forced = alarm
    servo.feel(shaft, 0.1)
    assert servo.get(table.TORQUE_LIMIT) == share
    status = ask(servo, packets.write(1, 24, b"\x00"))
    assert status is not None and Alarm(status.code) == alarm, "alarms are state, not a verdict on the request"
    servo.forced = Alarm(0)
    servo.feel(shaft, 0.1)
    assert servo.get(table.TORQUE_LIMIT) == share
    assert write(servo, table.TORQUE_LIMIT, 200) == Alarm(0)


def test_power_on_resets_ram_and_keeps_eeprom(servo: EmulatedServo) -> None:
    write(servo, table.TORQUE_ENABLE, 1)
    write(servo, table.MOVING_SPEED, 100)
    servo.power_on(700)
    assert (servo.get(table.TORQUE_ENABLE), servo.get(table.MOVING_SPEED)) == (0, 0)
    assert (servo.get(table.TORQUE_LIMIT), servo.get(table.CW_LIMIT)) == (MAX_TORQUE, 43)


@pytest.mark.parametrize("auto", [False, True])
def test_a_goal_may_switch_torque_on(servo: EmulatedServo, auto: bool) -> None:
    servo.auto_torque_on_goal = auto
    write(servo, table.GOAL_POSITION, 500)
    assert servo.get(table.TORQUE_ENABLE) == auto
