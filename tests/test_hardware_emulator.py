"""The emulated servo, byte for byte as the manual has it; the mechanics behind it; fault scripts."""

from __future__ import annotations

import numpy as np
import pytest
from pipenav_hardware import packets, table
from pipenav_hardware.arm_config import ScannerConfig, default_arm
from pipenav_hardware.emulator.bus import ServoBus
from pipenav_hardware.emulator.faults import BUS_FAULTS, Fault, FaultScript
from pipenav_hardware.emulator.free_plant import TURN, FreePlant
from pipenav_hardware.emulator.pipe_plant import PipePlant
from pipenav_hardware.emulator.plant import ServoCommand
from pipenav_hardware.emulator.servo import EmulatedServo
from pipenav_hardware.packets import Packet, Stream
from pipenav_hardware.table import COUNT, SPEED_UNIT, Alarm, Register

from pipenav.backends.real_robot import ArmStart
from pipenav.backends.simulators import open_simulator
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot

pytestmark = pytest.mark.flaky(reruns=2)  # real time over a serial line: a busy machine may miss a deadline

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


def test_a_shaft_follows_its_goal_at_its_speed() -> None:
    plant = FreePlant(1)
    plant.command(1.0, [ServoCommand(612, 100, 1.0)])
    shaft = plant.shafts(1.1)[0]
    assert shaft.position == pytest.approx(511.5 + 100 * SPEED_UNIT * 0.1 / COUNT)
    assert shaft.speed == pytest.approx(100 * SPEED_UNIT)
    assert shaft.load > 0.9
    assert plant.shafts(9.0)[0].position == 612


def test_speed_0_is_full_speed() -> None:
    plant = FreePlant(1)
    plant.command(1.0, [ServoCommand(1000, 0, 1.0)])
    assert plant.shafts(1.1)[0].position - 511.5 > 100


def test_a_shaft_without_torque_or_held_stays() -> None:
    plant = FreePlant(2)
    plant.stuck = {1}
    plant.command(1.0, [ServoCommand(900, 100, 0.0), ServoCommand(900, 100, 0.5)])
    free, held = plant.shafts(2.0)
    assert (free.position, free.load) == (511.5, 0.0)
    assert (held.position, held.load) == (511.5, 0.5)


def test_a_wheel_keeps_turning_and_reads_nonsense_in_its_dead_band() -> None:
    plant = FreePlant(1)
    plant.command(1.0, [ServoCommand(0, 300, 1.0, wheel=True)])
    readings = [plant.shafts(1.0 + 0.01 * i)[0].position for i in range(1000)]
    assert all(0 <= reading <= 1023 for reading in readings)
    steps = np.abs(np.diff(readings))
    assert (steps > 100).sum() > 2 * 10 * 300 / 1023 * 6.18 / COUNT / TURN, "more than the jumps of a wrapping counter"


def test_the_arm_in_a_pipe_moves_as_the_backend_says() -> None:
    robot = load_robot("basic")
    arm = default_arm(robot, "bus", ScannerConfig(driver="scip2", port="scanner"), None)
    pipe, q = PipeCorner.of(120, 90), np.zeros(4)
    plant = PipePlant(robot, arm, open_simulator("mujoco", robot, 1, {"threads": 1}), pipe, ArmStart(q, -0.6))
    goals = np.array([0.02, 0.1, -0.1, 0.1])
    actuators = [ServoCommand(round(s.to_counts(g)), 250, 0.3) for s, g in zip(arm.servos, goals, strict=True)]
    plant.command(1.0, actuators)
    start = [shaft.position for shaft in plant.shafts(1.0)]
    assert start == pytest.approx([servo.to_counts(0.0) for servo in arm.servos])
    for k in range(1, 12):
        plant.command(1.0 + 0.1 * k, actuators)
    shafts = plant.shafts(2.15)
    assert [s.to_position(shaft.position) for s, shaft in zip(arm.servos, shafts, strict=True)] == pytest.approx(
        goals, abs=0.01
    )
    assert np.isfinite(plant.distances(2.15, np.zeros(1))).all()


def test_a_joint_in_the_pipe_without_torque_stays() -> None:
    robot = load_robot("basic")
    arm = default_arm(robot, "bus", ScannerConfig(driver="scip2", port="scanner"), None)
    plant = PipePlant(
        robot, arm, open_simulator("mujoco", robot, 1, {}), PipeCorner.of(120, 90), ArmStart(np.zeros(4), -0.6)
    )
    plant.command(1.0, [ServoCommand(700, 250, 0.0)] * 4)
    for k in range(5):
        positions = [shaft.position for shaft in plant.shafts(1.0 + 0.1 * k)]
    assert positions == pytest.approx([servo.to_counts(0.0) for servo in arm.servos], abs=1)


def bus_with(*faults: Fault) -> tuple[ServoBus, list[bytes]]:
    sent: list[bytes] = []
    servos = [EmulatedServo(i, (0, 1023), 500) for i in (1, 2)]
    return ServoBus(servos, FreePlant(2), FaultScript(list(faults), 0), lambda _, data: sent.append(data), 0.0), sent


@pytest.mark.parametrize("kind", ["drop", "corrupt", "truncate", "garbage", "wrong_id", "bare_error"])
def test_an_answer_is_spoilt_as_ordered(kind: str) -> None:
    healthy, right = bus_with()
    bus, sent = bus_with(Fault(fault=kind, servo=1, value=32))
    for servo in (1, 2):
        request = Packet(servo, packets.READ, bytes([36, 8])).encode()
        for one in (healthy, bus):
            one.receive(1.0, request, 1_000_000)
    assert right[1] in sent
    assert right[0] not in sent


def test_faults_have_their_time_their_number_and_their_chance() -> None:
    script = FaultScript([Fault(fault="drop", at=1.0, span=1.0), Fault(fault="echo", count=2)], 0)
    struck = []
    for now in (0.5, 1.0, 1.9, 2.0):
        script.now = now
        struck.append(script.active("drop") is not None)
    assert struck == [False, True, True, False]
    assert [script.active("echo") is not None for _ in range(3)] == [True, True, False]
    chance = FaultScript([Fault(fault="drop", probability=0.25)], 1)
    assert 150 < sum(chance.active("drop") is not None for _ in range(1000)) < 350
    again = FaultScript([Fault(fault="drop", probability=0.25)], 1)
    first = [FaultScript([Fault(fault="drop", probability=0.25)], 1).active("drop") for _ in range(1)]
    assert [again.active("drop") is not None] == [first[0] is not None]


def test_an_unknown_fault_is_refused_by_name() -> None:
    with pytest.raises(PipenavError, match="bus has no fault 'explode': choose drop, "):
        FaultScript([Fault(fault="explode")], 0)
    assert "drop" in BUS_FAULTS


def test_a_half_packet_is_forgotten() -> None:
    bus, sent = bus_with()
    bus.receive(1.0, packets.ping(1)[:4], 1_000_000)
    bus.receive(2.0, packets.ping(2), 1_000_000)
    assert sent == [bytes.fromhex("FFFF020200FB")]


def test_a_host_at_another_speed_is_not_understood() -> None:
    bus, sent = bus_with()
    bus.receive(1.0, packets.ping(1), 57_600)
    assert not sent


def test_two_servos_with_one_id_spoil_each_others_answers() -> None:
    bus, sent = bus_with()
    bus.begin(Fault(fault="duplicate", servo=2, value=1))
    bus.receive(1.0, packets.ping(1), 1_000_000)
    assert len(sent) == 1
    assert not any(packet.valid for packet in Stream().feed(sent[0]))
