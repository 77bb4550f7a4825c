"""The supervisor: a process of its own beside the driver, which switches torque off when the driver no longer can.

Started by path, with nothing but the standard library, so that it is there within milliseconds and shares no fate with
the driver: it inherits the servo bus's port and the reading end of a pipe. Orders are single bytes: `A` torque is on,
`.` the driver is alive, `D` torque is off. The pipe's end while torque is on means that the driver is dead, silence
means that it hangs; both end in torque off. Then every servo is asked, and the joints that do not confirm are named.

    python supervisor.py PORT_DESCRIPTOR PIPE_DESCRIPTOR PACKET_HEX PATIENCE_SECONDS [QUESTION_HEX:ANSWER_HEX:JOINT ...]

A scanner has one too, which switches its laser off:

    python supervisor.py farewell PORT_DESCRIPTOR PIPE_DESCRIPTOR ORDER_HEX
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

BURSTS = (0.0, 0.02, 0.04, 0.1)
"""Times at which to send [s]: a packet that the driver left unfinished may swallow the first burst."""

PACKETS_PER_BURST = 3
CONFIRMATION, TRIES = 0.06, 2
"""Longest wait for a servo's answer [s], and how often it is asked."""

GRACE = 0.5
"""Longest silence of a driver that hangs before the servos are asked in its place [s].

Two who ask at once take each other's answers.
"""

FAREWELL = "farewell"
OUTPUT = 2
"""Descriptor of the standard error output."""

CONTROL_GROUPS = Path("/sys/fs/cgroup")
OWN_GROUP = Path("/proc/self/cgroup")
GROUP_PREFIX = "pipenav-supervisor-"


class Question(NamedTuple):
    """Question to a servo after torque was switched off, and the answer that is wanted.

    Attributes:
        request: the packet that asks whether its torque is on.
        off: its answer where torque is off; the error byte, the fifth, is not compared, nor the checksum after it.
        joint: name of its joint.
    """

    request: bytes
    off: bytes
    joint: str


def cut(port: int, packet: bytes) -> None:
    """Send the packet that switches torque off, several times, whatever the port says."""
    start = time.monotonic()
    for moment in BURSTS:
        time.sleep(max(0.0, start + moment - time.monotonic()))
        for _ in range(PACKETS_PER_BURST):
            with contextlib.suppress(OSError):  # gone: nothing can reach the servos any more
                os.write(port, packet)


def unconfirmed(port: int, questions: Sequence[Question]) -> list[str]:
    """Joints whose servo does not say that its torque is off."""
    return [question.joint for question in questions if not any(_is_off(port, question) for _ in range(TRIES))]


def _is_off(port: int, question: Question) -> bool:
    """Whether a servo answers that its torque is off."""
    with contextlib.suppress(OSError):
        while select.select([port], [], [], 0)[0]:
            if not os.read(port, 4096):
                return False
        os.write(port, question.request)
        heard, deadline = b"", time.monotonic() + CONFIRMATION
        while (left := deadline - time.monotonic()) > 0 and select.select([port], [], [], left)[0]:
            arrived = os.read(port, 4096)
            if not arrived:
                return False
            heard += arrived
            at = heard.find(question.off[:4])
            answer = heard[at : at + len(question.off)] if at >= 0 else b""
            if len(answer) == len(question.off):
                return answer[5:-1] == question.off[5:-1] and ~sum(answer[2:-1]) & 0xFF == answer[-1]
    return False


def say(text: str) -> None:
    """Print a line, unless that would have to wait: the output may be full, and closed."""
    with contextlib.suppress(OSError, ValueError):
        if select.select([], [OUTPUT], [], 0.1)[1]:
            os.write(OUTPUT, f"{text}\n".encode(errors="replace"))


def name_unconfirmed(port: int, questions: Sequence[Question], why: str) -> bool:
    """Ask every servo, and name the joints that do not confirm that torque is off; whether there are such joints."""
    joints = unconfirmed(port, questions)
    if joints:
        say(
            f"pipenav: {why}. Torque may still be on at {', '.join(joints)}: "
            "switch the supply off before touching the arm."
        )
    return bool(joints)


def watch(port: int, pipe: int, packet: bytes, patience: float, questions: Sequence[Question]) -> None:
    """Switch torque off whenever the driver is dead or silent, until the pipe ends.

    Args:
        port: descriptor of the servo bus's port.
        pipe: descriptor of the pipe's reading end.
        packet: the packet that switches torque off.
        patience: longest silence while torque is on [s].
        questions: what every servo is asked afterwards.
    """
    armed = doubtful = False  # doubtful: torque was switched off here, and nobody has confirmed it
    while True:
        heard = select.select([pipe], [], [], patience if armed else None)[0]
        orders = os.read(pipe, 4096) if heard else b""
        if heard and not orders:
            if armed or doubtful:
                cut(port, packet)
                name_unconfirmed(port, questions, "the program ended with torque on")
            return
        switched = [order for order in orders if order in b"AD"]
        if switched:
            armed, doubtful = switched[-1] == ord("A"), False
        elif not heard:
            cut(port, packet)
            armed, doubtful = False, True  # the driver must say so when it switches torque on again
            if not select.select([pipe], [], [], GRACE)[0]:  # one that speaks again asks by itself
                doubtful = name_unconfirmed(port, questions, "the program hangs with torque on")


def leave_control_group(groups: Path = CONTROL_GROUPS, own: Path = OWN_GROUP) -> bool:
    """Move this process out of the driver's control group, as far as that is allowed.

    What stops a service or a container kills its whole control group; a group beside it is spared.

    Args:
        groups: where the control groups (version 2) are mounted.
        own: file that names this process's own group.

    Returns:
        Whether it has a group of its own now.
    """
    with contextlib.suppress(OSError):
        lines = own.read_text(encoding="utf-8").splitlines()
        path = next((line[3:] for line in lines if line.startswith("0::")), "/").strip("/")
        if not path or ".." in path.split("/"):
            return False
        beside = (groups / path).parent
        for left in beside.glob(f"{GROUP_PREFIX}*"):  # of supervisors that have ended
            with contextlib.suppress(OSError):
                left.rmdir()
        made = beside / f"{GROUP_PREFIX}{os.getpid()}"
        made.mkdir()
        try:
            (made / "cgroup.procs").write_text(str(os.getpid()), encoding="ascii")
        except OSError:
            made.rmdir()
            return False
        return True
    return False


def say_farewell(port: int, pipe: int, order: bytes) -> None:
    """Send a device its last order at the pipe's end, unless `D` came before: the driver has sent it itself."""
    last = b""
    while heard := os.read(pipe, 4096):
        last = heard
    if not last.endswith(b"D"):
        with contextlib.suppress(OSError):
            os.write(port, order)


def ignore_signals() -> None:
    """Survive every signal that is meant for the driver."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)


def main() -> None:
    ignore_signals()
    leave_control_group()
    if sys.argv[1] == FAREWELL:
        say_farewell(int(sys.argv[2]), int(sys.argv[3]), bytes.fromhex(sys.argv[4]))
        return
    port, pipe, packet, patience, *asked = sys.argv[1:]
    parts = [text.split(":", 2) for text in asked]
    questions = [Question(bytes.fromhex(request), bytes.fromhex(off), joint) for request, off, joint in parts]
    watch(int(port), int(pipe), bytes.fromhex(packet), float(patience), questions)


if __name__ == "__main__":
    main()
