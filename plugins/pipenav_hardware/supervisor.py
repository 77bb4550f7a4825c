"""The supervisor: a process of its own beside the driver, which switches torque off when the driver no longer can.

Started by path, with nothing but the standard library, so that it is there within milliseconds and shares no fate with
the driver: it inherits the servo bus's port and the reading end of a pipe. Orders are single bytes: `A` torque is on,
`.` the driver is alive, `D` torque is off. The pipe's end while torque is on means that the driver is dead, silence
means that it hangs; both end in torque off.

    python supervisor.py PORT_DESCRIPTOR PIPE_DESCRIPTOR PACKET_HEX PATIENCE_SECONDS
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time

BURSTS = (0.0, 0.02, 0.04, 0.1)
"""Times at which to send [s]: a packet that the driver left unfinished may swallow the first burst."""

PACKETS_PER_BURST = 3


def cut(port: int, packet: bytes) -> None:
    """Send the packet that switches torque off, several times, whatever the port says."""
    start = time.monotonic()
    for moment in BURSTS:
        time.sleep(max(0.0, start + moment - time.monotonic()))
        for _ in range(PACKETS_PER_BURST):
            with contextlib.suppress(OSError):  # gone: nothing can reach the servos any more
                os.write(port, packet)


def watch(port: int, pipe: int, packet: bytes, patience: float) -> None:
    """Switch torque off whenever the driver is dead or silent, until the pipe ends.

    Args:
        port: descriptor of the servo bus's port.
        pipe: descriptor of the pipe's reading end.
        packet: the packet that switches torque off.
        patience: longest silence while torque is on [s].
    """
    armed = False
    while True:
        heard = select.select([pipe], [], [], patience if armed else None)[0]
        orders = os.read(pipe, 4096) if heard else b""
        if armed and not (heard and orders):
            cut(port, packet)
        if heard and not orders:
            return
        switched = [order for order in orders if order in b"AD"]
        if switched:
            armed = switched[-1] == ord("A")
        elif not heard:
            armed = False  # torque is off: the driver must say so when it switches it on again


def main() -> None:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    port, pipe, packet, patience = sys.argv[1:]
    watch(int(port), int(pipe), bytes.fromhex(packet), float(patience))


if __name__ == "__main__":
    main()
