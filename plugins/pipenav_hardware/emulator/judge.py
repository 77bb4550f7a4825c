"""Judging by the byte log: what the servos were told, read from the bytes that reached them and from nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pipenav_hardware import packets, table
from pipenav_hardware.packets import Packet, Stream


class Heard(NamedTuple):
    """One instruction that reached the servos, at a time on the system's monotonic clock [s]."""

    time: float
    packet: Packet


class Goal(NamedTuple):
    """One goal that reached one servo.

    Attributes:
        time: when [s].
        servo: its id.
        goal, speed: the registers written.
        present: position that the servo had last told the host, None before it told any.
        last: goal before this one, None at the first.
    """

    time: float
    servo: int
    goal: int
    speed: int | None
    present: int | None
    last: int | None


def records(log: Path) -> Iterator[dict[str, Any]]:
    """The log's lines; a last one that is cut short is left out."""
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
    """Every goal, with what the host could know when it sent it."""
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
                place = table.PRESENT_POSITION.address - reading
                if answer.valid and 0 <= place <= len(answer.parameters) - table.PRESENT_POSITION.size:
                    present[answer.id] = table.word(answer.parameters, place)
            continue
        for packet in asked.feed(data):
            if packet.code == packets.READ:
                reading = packet.parameters[0]
            for servo, chunk in _goal_writes(packet):
                speed = table.word(chunk, 2) if len(chunk) >= 4 else None
                goal = table.word(chunk, 0)
                yield Goal(record["t"], servo, goal, speed, present.get(servo), last.get(servo))
                last[servo] = goal


def _goal_writes(packet: Packet) -> list[tuple[int, bytes]]:
    """Bytes from the goal register on, per servo, in a WRITE or SYNC_WRITE; none for other packets."""
    parameters = packet.parameters
    if packet.code == packets.SYNC_WRITE and parameters[0] == table.GOAL_ADDRESS:
        size = parameters[1] + 1
        chunks = [parameters[i : i + size] for i in range(2, len(parameters), size)]
        return [(chunk[0], chunk[1:]) for chunk in chunks]
    if packet.code == packets.WRITE and parameters[0] == table.GOAL_ADDRESS:
        return [(packet.id, parameters[1:])]
    return []


def torque(log: Path, servos: Sequence[int]) -> dict[int, tuple[bool, float]]:
    """Whether each servo's torque is on at the log's end, and when it was last switched [s]."""
    state = dict.fromkeys(servos, (False, 0.0))
    for time, packet in instructions(log):
        address = table.TORQUE_ENABLE.address
        if packet.code == packets.WRITE and packet.parameters[0] == address:
            on = bool(packet.parameters[1])
            for servo in servos if packet.id == packets.BROADCAST else [packet.id]:
                if servo in state and state[servo][0] != on:
                    state[servo] = (on, time)
    return state


def only_asked(log: Path) -> bool:
    """Whether nothing but PING and READ reached the servos."""
    return all(heard.packet.code in (packets.PING, packets.READ) for heard in instructions(log))
