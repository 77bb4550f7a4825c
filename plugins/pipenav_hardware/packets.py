"""Protocol 1.0 packets as bytes: built, checked and found in a stream.

Instruction: FF FF ID LENGTH INSTRUCTION parameters CHECKSUM; status: the same with the error byte as instruction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from pipenav_hardware.table import GOAL_ADDRESS, ServoGoal

PING, READ, WRITE, REG_WRITE, ACTION, RESET, SYNC_WRITE, BULK_READ = 1, 2, 3, 4, 5, 6, 0x83, 0x92
BROADCAST = 0xFE
MAX_LENGTH = 250


class Packet(NamedTuple):
    """An instruction or a status.

    Attributes:
        id: the servo's id.
        code: the instruction; in a status packet the error byte.
        parameters: bytes after the code.
        valid: whether the checksum was right.
    """

    id: int
    code: int
    parameters: bytes
    valid: bool = True

    def encode(self) -> bytes:
        body = bytes([self.id, len(self.parameters) + 2, self.code, *self.parameters])
        return b"\xff\xff" + body + bytes([checksum(body)])


def checksum(body: bytes) -> int:
    """Checksum of ID to last parameter: the inverted low byte of their sum."""
    return ~sum(body) & 0xFF


def ping(servo: int) -> bytes:
    return Packet(servo, PING, b"").encode()


def write(servo: int, address: int, data: bytes) -> bytes:
    return Packet(servo, WRITE, bytes([address]) + data).encode()


def sync_write(address: int, data: dict[int, bytes]) -> bytes:
    """Packet that writes to several servos: the same address, each its own bytes (all of the same length)."""
    size = len(next(iter(data.values())))
    parameters = bytes([address, size]) + b"".join(bytes([servo]) + chunk for servo, chunk in data.items())
    return Packet(BROADCAST, SYNC_WRITE, parameters).encode()


def words(*values: int) -> bytes:
    """Bytes of 16-bit values, little endian."""
    return b"".join(value.to_bytes(2, "little") for value in values)


def goal_packet(goals: Mapping[int, ServoGoal]) -> bytes:
    """Packet that gives every servo its goal position and moving speed, by id."""
    return sync_write(GOAL_ADDRESS, {servo: words(*goal) for servo, goal in goals.items()})


TORQUE_OFF_ALL = write(BROADCAST, 24, b"\x00")
"""Broadcast: register 24 (Torque Enable) of every servo becomes 0; no servo answers."""


class Stream:
    """Finds packets in a byte stream, whatever lies between them."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> Iterator[Packet]:
        """Packets that are complete now, in order; `valid` is False where the checksum is wrong."""
        self._buffer += data
        while (packet := self._next()) is not None:
            yield packet

    def forget(self) -> None:
        """Drop an unfinished packet, as a servo does when its rest does not come."""
        self._buffer.clear()

    @property
    def waiting(self) -> bool:
        """Whether a packet has begun and not ended."""
        return bool(self._buffer)

    def _next(self) -> Packet | None:
        buffer = self._buffer
        while True:
            start = buffer.find(b"\xff\xff")
            if start < 0:
                del buffer[: len(buffer) - (1 if buffer[-1:] == b"\xff" else 0)]
                return None
            del buffer[:start]
            while buffer[2:3] == b"\xff":  # three or more FF: the header is the last two of them
                del buffer[0]
            if len(buffer) < 4:
                return None
            length = buffer[3]
            if not 2 <= length <= MAX_LENGTH:
                del buffer[:2]
                continue
            if len(buffer) < length + 4:
                return None
            body, given = bytes(buffer[2 : length + 3]), buffer[length + 3]
            del buffer[: length + 4]
            return Packet(body[0], body[2], body[3:], checksum(body) == given)
