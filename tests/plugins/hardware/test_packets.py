"""Protocol 1.0 and SCIP2 against the manuals' own examples, and the servo's units against the robot's."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pipenav_hardware import packets, scip2, table
from pipenav_hardware.front_sensor import framed, unframed
from pipenav_hardware.packets import Packet, Stream
from pipenav_hardware.table import Alarm

GOLDEN = {
    "ping": ("FF FF 01 02 01 FB", packets.ping(1)),
    "ping status": ("FF FF 01 02 00 FC", Packet(1, 0, b"").encode()),
    "read temperature": ("FF FF 01 04 02 2B 01 CC", Packet(1, packets.READ, bytes([43, 1])).encode()),
    "temperature status": ("FF FF 01 03 00 20 DB", Packet(1, 0, b"\x20").encode()),
    "broadcast id": ("FF FF FE 04 03 03 01 F6", packets.write(packets.BROADCAST, 3, b"\x01")),
    "reg write goal": (
        "FF FF 01 05 04 1E F4 01 E2",
        Packet(1, packets.REG_WRITE, b"\x1e" + packets.words(500)).encode(),
    ),
    "action": ("FF FF FE 02 05 FA", Packet(packets.BROADCAST, packets.ACTION, b"").encode()),
    "sync write": (
        "FF FF FE 0E 83 1E 04 00 10 00 50 01 01 20 02 60 03 67",
        packets.sync_write(30, {0: packets.words(0x010, 0x150), 1: packets.words(0x220, 0x360)}),
    ),
    "overload and overheat": ("FF FF 01 02 24 D8", Packet(1, Alarm.OVERLOAD | Alarm.OVERHEAT, b"").encode()),
    "max torque": ("FF FF 00 05 03 0E FF 01 E9", packets.write(0, 14, packets.words(511))),
    "torque off": ("FF FF FE 04 03 18 00 E2", packets.TORQUE_OFF_ALL),
    "bulk read": (
        "FF FF FE 09 92 00 02 01 1E 02 02 24 1D",
        Packet(packets.BROADCAST, packets.BULK_READ, bytes([0, 2, 1, 0x1E, 2, 2, 0x24])).encode(),
    ),
}


@pytest.mark.parametrize("name", GOLDEN)
def test_golden_packets(name: str) -> None:
    text, built = GOLDEN[name]
    assert built == bytes.fromhex(text)
    (packet,) = Stream().feed(built)
    assert packet.valid and packet.encode() == built


@given(st.lists(st.sampled_from([bytes.fromhex(text) for text, _ in GOLDEN.values()]), max_size=5), st.data())
def test_a_stream_finds_every_packet_however_it_is_cut(whole: list[bytes], data: st.DataObject) -> None:
    text = b"".join(whole)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(text)), max_size=6)))
    stream, found = Stream(), []
    for start, end in zip([0, *cuts], [*cuts, len(text)], strict=True):
        found += stream.feed(text[start:end])
    assert [packet.encode() for packet in found] == whole


@given(st.binary(max_size=60))
def test_a_stream_survives_any_bytes(noise: bytes) -> None:
    stream = Stream()
    list(stream.feed(noise))
    list(stream.feed(bytes(300)))  # no packet is longer: whatever had begun has ended
    assert packets.ping(3) in [packet.encode() for packet in stream.feed(packets.ping(3))]


def test_a_wrong_checksum_is_noticed() -> None:
    for bit in range(8):
        damaged = bytearray(packets.TORQUE_OFF_ALL)
        damaged[6] ^= 1 << bit
        (packet,) = Stream().feed(bytes(damaged))
        assert not packet.valid


@given(st.integers(-1023, 1023))
def test_signed_values_keep_their_sign(value: int) -> None:
    assert table.signed(table.raw_signed(value)) == value


def test_one_clockwise_step_is_not_a_stop() -> None:
    assert table.raw_signed(-1) == 1025  # 1024 would mean: clockwise, standing


def test_the_table_is_the_manuals() -> None:
    registers = sorted(table.REGISTERS.values(), key=lambda register: register.address)
    for one, other in itertools.pairwise(registers):
        assert one.end <= other.address
    assert (table.STATE_ADDRESS, table.STATE_SIZE, table.GOAL_ADDRESS, table.GOAL_SIZE) == (36, 8, 30, 4)
    assert math.degrees(table.COUNT) == pytest.approx(0.29326, abs=1e-5)
    assert math.degrees(table.SPEED_UNIT) == pytest.approx(0.666, abs=1e-3)
    assert {register.address for register in registers if register.eeprom} == {
        0,
        2,
        3,
        4,
        5,
        6,
        8,
        11,
        12,
        13,
        14,
        16,
        17,
        18,
    }


def test_scip2_numbers_of_the_specification() -> None:
    assert scip2.decode("CB") == 1234
    assert scip2.decode("1Dh") == 5432
    assert scip2.encode(1234, 2) == "CB"
    assert scip2.encode(5432, 3) == "1Dh"


@given(st.integers(0, 2**18 - 1))
def test_scip2_numbers_round_trip(value: int) -> None:
    assert scip2.decode(scip2.encode(value, 3)) == value


@pytest.mark.parametrize(
    ("line", "given"), [("DMIN:20", "4"), ("DMAX:5600", "_"), ("AMIN:44", "7"), ("AMAX:725", "o"), ("AFRT:384", "6")]
)
def test_scip2_sums_of_the_specification(line: str, given: str) -> None:
    assert scip2.checksum(line) == given
    key, value = line.split(":")
    assert scip2.parameters([f"{line};{given}"]) == {key: value}
    assert scip2.parameters([f"{line};{scip2.checksum(line + ';')}"]) == {key: value}
    assert scip2.parameters([f"{line};{chr(ord(given) ^ 1)}"]) == {}


def scan_lines(distances: list[int], stamp: int = 1234) -> list[str]:
    text = "".join(scip2.encode(value, 3) for value in distances)
    echo = f"MD{44:04d}{44 + len(distances) - 1:04d}01000"
    return [echo, scip2.with_sum("99"), scip2.with_sum(scip2.encode(stamp, 4)), *scip2.data_lines(text)]


@given(st.lists(st.integers(0, 5600), min_size=1, max_size=300))
def test_a_scan_is_read_as_it_was_written(distances: list[int]) -> None:
    assert scip2.parse_scan(scan_lines(distances)) == scip2.Scan(1234, distances)


@given(st.data())
def test_a_scan_with_one_wrong_bit_is_rejected(data: st.DataObject) -> None:
    lines = scan_lines(list(np.arange(100, 345)))
    row = data.draw(st.integers(1, len(lines) - 1))
    column = data.draw(st.integers(0, len(lines[row]) - 1))
    bit = data.draw(st.integers(0, 5))
    flipped = chr(ord(lines[row][column]) ^ 1 << bit)
    lines[row] = lines[row][:column] + flipped + lines[row][column + 1 :]
    assert scip2.parse_scan(lines) is None


def test_a_scan_cut_short_is_rejected() -> None:
    lines = scan_lines(list(range(100, 345)))
    for count in range(len(lines)):
        assert scip2.parse_scan(lines[:count]) is None


@given(st.integers(0, 65535), st.integers(0, 1000))
def test_front_sensor_lines(sequence: int, millimetres: int) -> None:
    body = f"F,{sequence},{millimetres}"
    assert unframed(framed(body)) == body
    assert unframed(framed(body).replace("F", "G", 1)) is None
