"""Evidence from the byte log: the servos' commands, read from the bytes that reached them and from nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pipenav_hardware import packets, table
from pipenav_hardware.packets import Packet, Stream


class Heard(NamedTuple):
    """An instruction that reached the servos, at a time on the system's monotonic clock [s]."""

    time: float
    packet: Packet


class Goal(NamedTuple):
    """A goal that reached a servo.

    Attributes:
        time: when it came, on the system's monotonic clock [s].
        servo: id of the servo.
        goal, speed: the registers written [counts]; the speed is None where only the goal was written.
        present: position that the servo had last sent to the host [counts]; None before it sent any.
        last: goal before this one [counts]; None for the first.
    """

    time: float
    servo: int
    goal: int
    speed: int | None
    present: int | None
    last: int | None


def records(log: Path) -> Iterator[dict[str, Any]]:
    """The lines of a log; a last line that is cut short is left out."""
    with log.open(encoding="ascii") as file:
        for line in file:
            if line.endswith("\n"):
                yield json.loads(line)


def instructions(log: Path) -> list[Heard]:
    """Every whole instruction with a right checksum."""
    stream, heard = Stream(), []
    for record in records(log):
        if record.get("port") == "bus" and record["dir"] == "in":
            found = stream.feed(bytes.fromhex(record["hex"]))
            heard += [Heard(record["t"], packet) for packet in found if packet.valid]
    return heard


def goals(log: Path) -> Iterator[Goal]:
    """Every goal, with what the host could know when it sent the goal."""
    asked, answers = Stream(), Stream()
    reading = table.TABLE_END
    present: dict[int, int] = {}
    last: dict[int, int] = {}
    for record in records(log):
        if record.get("port") != "bus":
            continue
        data = bytes.fromhex(record["hex"])
        if record["dir"] == "out":
            for answer in answers.feed(data):
                offset = table.PRESENT_POSITION.address - reading
                if answer.valid and 0 <= offset <= len(answer.parameters) - table.PRESENT_POSITION.size:
                    present[answer.id] = table.word(answer.parameters, offset)
            continue
        for packet in asked.feed(data):
            if packet.code == packets.READ:
                reading = packet.parameters[0]
            for servo, written in _goal_writes(packet):
                speed = table.word(written, 2) if len(written) >= 4 else None
                goal = table.word(written, 0)
                yield Goal(record["t"], servo, goal, speed, present.get(servo), last.get(servo))
                last[servo] = goal


class _GoalWrite(NamedTuple):
    """Id of a servo, and the bytes that its registers get from the goal register on."""

    servo: int
    data: bytes


def _goal_writes(packet: Packet) -> list[_GoalWrite]:
    """Goals in a WRITE or SYNC_WRITE; none in other packets."""
    parameters = packet.parameters
    if packet.code == packets.SYNC_WRITE and parameters[0] == table.GOAL_ADDRESS:
        size = parameters[1] + 1
        chunks = [parameters[i : i + size] for i in range(2, len(parameters), size)]
        return [_GoalWrite(chunk[0], chunk[1:]) for chunk in chunks]
    if packet.code == packets.WRITE and parameters[0] == table.GOAL_ADDRESS:
        return [_GoalWrite(packet.id, parameters[1:])]
    return []


class Torque(NamedTuple):
    """Whether a servo's torque is on, and since when [s]; since 0 where it was never switched."""

    on: bool
    since: float


def torque(log: Path, servos: Sequence[int]) -> dict[int, Torque]:
    """Torque of each servo, by id, at the log's end."""
    state = dict.fromkeys(servos, Torque(False, 0.0))
    for time, packet in instructions(log):
        address = table.TORQUE_ENABLE.address
        if packet.code == packets.WRITE and packet.parameters[0] == address:
            on = bool(packet.parameters[1])
            for servo in servos if packet.id == packets.BROADCAST else [packet.id]:
                if servo in state and state[servo].on != on:
                    state[servo] = Torque(on, time)
    return state


def laser(log: Path) -> bool:
    """Whether the scanner's laser is on at the log's end."""
    states = [bool(record["on"]) for record in records(log) if record.get("event") == "laser"]
    return bool(states) and states[-1]


def only_asked(log: Path) -> bool:
    """Whether nothing but PING and READ reached the servos."""
    return all(heard.packet.code in (packets.PING, packets.READ) for heard in instructions(log))
