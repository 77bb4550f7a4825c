"""The bus driver against the emulator's process: every fault measured on the SDK and its promised reaction."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from helpers.emulated import PATIENCE, strike
from pipenav_hardware import packets, table
from pipenav_hardware.dynamixel import REPLY_ALLOWANCE, Bus, BusLost
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings
from pipenav_hardware.serial_port import Mode, Port
from pipenav_hardware.servos import Servos
from pipenav_hardware.table import Alarm

from pipenav.errors import PipenavError
from pipenav.robots.robot import load_robot

pytestmark = pytest.mark.realtime

UNHURRIED = 20.0
"""Factor on the driver's time limits where a test depends on what comes in time and what does not."""

STATE = (table.STATE_ADDRESS, table.STATE_SIZE)


@pytest.fixture(scope="module")
def shared() -> Iterator[Emulator]:
    with Emulator(load_robot("basic"), EmulatorSettings(front_sensor=False)) as emulator:
        yield emulator


@pytest.fixture
def emulator(shared: Emulator) -> Emulator:
    shared.order(clear=True)
    return shared


@pytest.fixture
def bus(emulator: Emulator) -> Iterator[Bus]:
    opened = Bus(emulator.arm.port, 1_000_000, PATIENCE)
    yield opened
    opened.close()


def test_a_healthy_servo_answers(bus: Bus) -> None:
    assert all(bus.ping(servo).data == b"" for servo in (1, 2, 3, 4))
    assert bus.ping(9).problem == "no answer"
    data = bus.read(2, *STATE).data
    assert data is not None
    assert 500 < table.decode_state(data).position < 520
    assert bus.read_register(2, table.MODEL) == table.MODEL_NUMBER


def test_a_silent_servo_is_silent_and_the_others_are_not(emulator: Emulator, bus: Bus) -> None:
    emulator.order(fault="dead", servo=3)
    answers = [bus.read(servo, *STATE) for servo in (1, 2, 3, 4)]
    assert [answer.data is None for answer in answers] == [False, False, True, False]
    assert answers[2].problem == "no answer"


@pytest.mark.parametrize("fault", ["corrupt", "truncate", "wrong_id", "drop"])
def test_a_damaged_answer_is_asked_for_again(emulator: Emulator, bus: Bus, fault: str) -> None:
    right = bus.read(1, *STATE).data
    emulator.order(fault=fault, count=1, servo=1)
    assert bus.read(1, *STATE).data == right
    emulator.order(fault=fault, servo=1)
    assert bus.read(1, *STATE).data is None


def test_garbage_before_an_answer_is_passed_over(emulator: Emulator, bus: Bus) -> None:
    right = bus.read(1, *STATE).data
    emulator.order(fault="garbage")
    assert bus.read(1, *STATE).data == right


def test_an_error_without_data_is_no_reading_but_its_alarm_counts(emulator: Emulator, bus: Bus) -> None:
    emulator.order(fault="bare_error", value=0x25, servo=1)
    for size in (1, 2, 8):
        answer = bus.read(1, 36, size)
        assert answer.data is None
        assert answer.alarms == Alarm.VOLTAGE | Alarm.OVERHEAT | Alarm.OVERLOAD


def test_a_late_answer_never_answers_the_next_question(emulator: Emulator) -> None:
    """Answers carry no address: without care the goal would be read where the position was asked for."""
    with closing(Bus(emulator.arm.port, 1_000_000, UNHURRIED)) as bus:
        bus.mode = Mode.DRIVE
        bus.expect(0.0)
        assert bus.write_register(1, table.GOAL_POSITION, 400)
        present = bus.read_register(1, table.PRESENT_POSITION)
        assert present != 400
        for share in (1.3, 1.5, 1.7):  # of the time for which the driver waits, and then waits once more
            emulator.order(fault="delay", servo=1, value=share * REPLY_ALLOWANCE * UNHURRIED, count=1)
            assert bus.read(1, table.GOAL_POSITION.address, 2, retries=0).data is None
            assert bus.read_register(1, table.PRESENT_POSITION) == present
            assert bus.read_register(1, table.GOAL_POSITION) == 400


def test_an_answer_within_its_time_is_taken_and_not_asked_for_again(emulator: Emulator) -> None:
    emulator.order(fault="delay", servo=1, value=REPLY_ALLOWANCE * UNHURRIED / 3)
    with closing(Bus(emulator.arm.port, 1_000_000, UNHURRIED)) as bus:
        bus.expect(0.0)
        before = len(byte_log.instructions(emulator.log_path))
        assert bus.read(1, *STATE).data is not None
        assert len(byte_log.instructions(emulator.log_path)) == before + 1


def test_a_port_that_was_never_opened_closes(tmp_path: Path) -> None:
    port = Port(str(tmp_path / "none"), 1_000_000, 1.0)
    with pytest.raises(PipenavError, match="there is no port"):
        port.openPort()
    port.closePort()


def test_an_adapter_that_echoes_is_refused(emulator: Emulator, bus: Bus) -> None:
    assert not bus.echoes()
    emulator.order(fault="echo")
    assert bus.echoes()
    with pytest.raises(PipenavError, match="echoes what is sent"):
        Servos(emulator.arm, bus)


def test_after_an_exception_inside_a_read_the_bus_still_works(bus: Bus, monkeypatch: pytest.MonkeyPatch) -> None:
    """The SDK would stay busy for ever, and say so without an exception."""

    def interrupted(_length: int) -> bytes:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(bus._port, "readPort", interrupted)
        with pytest.raises(KeyboardInterrupt):
            bus.read(1, *STATE)
    assert bus._port.is_using
    bus._port.mode = Mode.DRIVE
    assert bus.off((1, 2, 3, 4)) == []


def test_time_outs_do_not_depend_on_the_wall_clock(bus: Bus, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "time", lambda: 0.0)  # a clock that stands still would never time out
    assert bus.ping(9).data is None


@pytest.mark.parametrize("baud", sorted(table.BAUD_VALUES))
def test_a_wrong_speed_finds_nobody_and_the_right_one_everybody(bus: Bus, baud: int) -> None:
    bus.open(baud)
    assert (bus.ping(1).data is not None) == (baud == 1_000_000)


@pytest.mark.parametrize("code", [packets.REG_WRITE, packets.ACTION, packets.RESET, packets.BULK_READ, 0x82, 0x84])
def test_the_driver_does_not_send_what_resets_a_servo_or_what_it_does_not_know(bus: Bus, code: int) -> None:
    for mode in Mode:
        bus.mode = mode
        with pytest.raises(PipenavError, match=f"does not send instruction {code:#04x}"):
            bus._port.writePort(packets.Packet(1, code, bytes(2)).encode())


def test_the_driver_sends_nothing_that_it_should_not(bus: Bus) -> None:
    bus.mode = Mode.LISTEN
    with pytest.raises(PipenavError, match="only listens"):
        bus.send_goals({1: (500, 10)})
    with pytest.raises(PipenavError, match="only listens"):
        bus.write_register(1, table.TORQUE_ENABLE, 0)
    bus.mode = Mode.STOPPED
    with pytest.raises(PipenavError, match="only listens"):
        bus.write_register(1, table.TORQUE_ENABLE, 1)
    assert bus.write_register(1, table.TORQUE_ENABLE, 0)


def test_torque_goes_off_everywhere_although_one_servo_is_dead(emulator: Emulator, bus: Bus) -> None:
    bus.mode = Mode.DRIVE
    for servo in (1, 2, 3, 4):
        assert bus.write_register(servo, table.TORQUE_ENABLE, 1)
    emulator.order(fault="dead", servo=1)
    before = len(byte_log.instructions(emulator.log_path))
    assert bus.off((1, 2, 3, 4)) == [1]
    told = [heard.packet.encode() for heard in byte_log.instructions(emulator.log_path)[before:]]
    assert told[:3] == [packets.TORQUE_OFF_ALL] * 3, "no servo is asked before all are switched off"
    assert not any(on for on, _ in byte_log.torque(emulator.log_path, (2, 3, 4)).values())
    emulator.order(clear=True)
    assert bus.off((1, 2, 3, 4)) == []


def test_torque_goes_off_although_servos_are_overloaded(emulator: Emulator, bus: Bus) -> None:
    """An alarm bit in the answer is no failure of the write."""
    bus.mode = Mode.DRIVE
    assert bus.write_register(2, table.TORQUE_ENABLE, 1)
    emulator.order(fault="overload")
    assert bus.off((1, 2, 3, 4)) == []


def test_the_sent_packet_is_the_one_that_is_returned(emulator: Emulator, bus: Bus) -> None:
    sent: list[bytes] = []
    bus.on_send(sent.append)
    bus.mode = Mode.DRIVE
    packet = bus.send_goals({1: (500, 10), 2: (510, 20), 3: (520, 30), 4: (530, 40)})
    assert sent == [packet]
    assert len(packet) == 28
    bus.off((1, 2, 3, 4))
    assert packet in [heard.packet.encode() for heard in byte_log.instructions(emulator.log_path)]


def test_a_pulled_adapter_is_one_error_and_works_when_plugged_in_again() -> None:
    with Emulator(load_robot("basic"), EmulatorSettings(front_sensor=False)) as emulator:
        bus = Bus(emulator.arm.port, 1_000_000, PATIENCE)
        assert bus.ping(1).data is not None
        strike(emulator, fault="unplug")
        with pytest.raises(BusLost, match="check the USB cable") as lost:
            for _ in range(3):
                bus.read(1, *STATE)
        assert lost.value.cause == "bus-lost"
        assert bus.off((1, 2, 3, 4)) == [1, 2, 3, 4], "nobody confirms, and nothing is raised"
        bus.close()
        bus.close()
        with pytest.raises(PipenavError, match="there is no port"):
            Bus(emulator.arm.port, 1_000_000)
        emulator.order(plug="bus")
        again = Bus(emulator.arm.port, 1_000_000)
        assert again.ping(1).data is not None
        again.close()


def test_an_adapter_that_takes_no_bytes_is_lost_and_does_not_block() -> None:
    with Emulator(load_robot("basic"), EmulatorSettings(front_sensor=False)) as emulator:
        bus = Bus(emulator.arm.port, 1_000_000, PATIENCE)
        bus.mode = Mode.DRIVE
        emulator.order(fault="deaf")
        with pytest.raises(BusLost):
            for _ in range(5000):
                bus.send_goals(dict.fromkeys((1, 2, 3, 4), (500, 10)))
        emulator.order(clear=True)
        assert any(bus.ping(1).data is not None for _ in range(200)), "it first carries out all that it was sent"
        assert bus.off((1, 2, 3, 4)) == []
        bus.close()


def test_a_second_master_is_refused_with_the_first_ones_pid(bus: Bus) -> None:
    with pytest.raises(PipenavError, match=rf"in use by process {os.getpid()} \("):
        Bus(bus.name, 1_000_000)
