"""The emulated line: who answers, and what spoils the answers."""

from __future__ import annotations

import pytest
from pipenav_hardware import packets
from pipenav_hardware.emulator.bus import ServoBus
from pipenav_hardware.emulator.faults import Fault, FaultScript
from pipenav_hardware.emulator.free_plant import FreePlant
from pipenav_hardware.emulator.servo import EmulatedServo
from pipenav_hardware.packets import Packet, Stream


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
