"""The servo bus: dynamixel-sdk's port and packets, with the sharp edges that were measured on them taken off.

The SDK spins while it waits, measures time by the wall clock, waits 34 ms for a silent servo, may block for ever in a
write, leaves its port marked busy when an exception passes through, and takes whatever comes for an answer. Here the
port waits in short blocking reads on a monotonic clock, every write has a time-out, every answer is checked for
length, and switching torque off needs none of the SDK's state.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import termios
import time
from collections.abc import Callable, Iterable, Sequence
from enum import Enum
from typing import Any, NamedTuple

import serial
from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS, GroupSyncWrite, PortHandler, Protocol1PacketHandler

from pipenav.backends import Stopped
from pipenav.errors import PipenavError
from pipenav_hardware import packets, table
from pipenav_hardware.ports import holder_of, port_problem

FIRST_ALLOWANCE = 0.034
"""How long a servo may stay silent until the adapter's latency is known [s]: as long as the SDK waits."""

REPLY_ALLOWANCE = 0.012
"""How long a servo may stay silent before it counts as silent [s]: the bytes' own time is added.

The SDK waits 34 ms; four silent servos would then use up more than a control period. With 12 ms a healthy bus behind
an adapter of 1 ms had no false time-out in 10,000 ticks.
"""

READ_SLICE = 0.002
"""Longest single wait for bytes [s]: the SDK asks again until its time-out."""

WRITE_TIMEOUT = 0.02
"""Longest wait for the adapter to take a packet [s]; a healthy one takes it at once."""

LOST = (OSError, termios.error, serial.SerialException)
"""What a vanished adapter raises; termios.error is no OSError."""


class BusLost(Stopped):
    """The adapter is gone or takes no bytes."""

    def __init__(self, port: str, why: object) -> None:
        super().__init__(
            "bus-lost", f"the servo bus on {port} is lost ({why})", "check the USB cable, then start again"
        )


class Mode(Enum):
    """What may be sent."""

    LISTEN = "only PING and READ: for checks and dry runs"
    DRIVE = "everything that the driver knows"
    STOPPED = "torque may be switched off, and questions asked"


class Answer(NamedTuple):
    """What became of a request: the data of the length asked for, the alarms with it; or None and why."""

    data: bytes | None
    alarms: table.Alarm = table.Alarm(0)
    problem: str = ""


class Port(PortHandler):  # type: ignore[misc]  # the SDK has no types
    """The SDK's port on a monotonic clock, exclusive, never blocking for long, and refusing what its mode forbids."""

    def __init__(self, name: str, baud: int, patience: float) -> None:
        super().__init__(name)
        self._patience = patience
        self.baudrate, self.is_open = baud, False
        self.mode = Mode.LISTEN
        self.allowance = FIRST_ALLOWANCE
        self.sent: Callable[[bytes], None] | None = None
        self._heard = b""

    def setupPort(self, cflag_baud: int) -> bool:  # noqa: ARG002  # the SDK's name and argument
        if self.is_open:
            self.closePort()
        try:
            self.ser = serial.Serial(self.port_name, self.baudrate)
        except LOST as error:
            raise port_problem(self.port_name, error) from error
        try:
            fcntl.flock(self.ser.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.ser.close()
            raise PipenavError(
                f"{self.port_name} is in use by {holder_of(self.port_name)}: one master at a time; end that process."
            ) from None
        self.is_open = True
        self.flush()
        self.tx_time_per_byte = 10_000.0 / self.baudrate  # [ms]
        return True

    def setPacketTimeout(self, packet_length: int) -> None:
        self.packet_start_time = self.getCurrentTime()
        self.packet_timeout = self.tx_time_per_byte * packet_length + 1e3 * self.silence

    @property
    def silence(self) -> float:
        """How long an answer may take to begin [s]."""
        return self.allowance * self._patience

    def getCurrentTime(self) -> float:
        return time.monotonic() * 1e3

    def writePort(self, packet: Sequence[int]) -> int:
        data = bytes(packet)
        refused = _refusal(data, self.mode)
        if refused:
            raise PipenavError(refused)
        descriptor, left = self.ser.fileno(), data
        while left:
            with contextlib.suppress(BlockingIOError):
                left = left[os.write(descriptor, left) :]
            # pyserial's own write time-out also strikes when nothing but this program was slow
            if left and not select.select([], [descriptor], [], WRITE_TIMEOUT * self._patience)[1]:
                raise serial.SerialTimeoutException("it takes no bytes")
        if self.sent is not None:
            self.sent(data)
        return len(data)

    def readPort(self, length: int) -> bytes:
        """At most so many bytes; waits only where none has arrived."""
        if not self._heard and select.select([self.ser.fileno()], [], [], READ_SLICE)[0]:
            self._heard = os.read(self.ser.fileno(), 4096)  # the SDK asks for a packet in two parts
            if not self._heard:
                raise serial.SerialException("it is unplugged")
        data, self._heard = self._heard[:length], self._heard[length:]
        return data

    def clearPort(self) -> None:
        """Drop what has arrived; not what the kernel is about to deliver, as `flush` does.

        That waits for the kernel's worker thread, as `select` does where nothing has arrived. The worker runs at normal
        priority, behind whatever other program wants the processor, and often has not ended yet when the answer before
        this one wakes us: up to 3 ms were seen. Between an answer and the next question nothing must wait for it.
        """
        self._heard = b""
        if waiting := self.ser.in_waiting:
            os.read(self.ser.fileno(), waiting)

    def flush(self) -> None:
        """Drop whatever was sent to us until now."""
        self._heard = b""
        self.ser.reset_input_buffer()

    def closePort(self) -> None:
        if self.ser is not None:
            self.ser.close()
        self.is_open = False


def _refusal(packet: bytes, mode: Mode) -> str:
    """Why a packet may not be sent now; empty if it may."""
    instruction = packet[4]
    if instruction in (packets.PING, packets.READ):
        return ""
    if instruction not in (packets.WRITE, packets.SYNC_WRITE):
        return f"the driver does not send instruction {instruction:#04x}."
    off = instruction == packets.WRITE and packet[5:-1] == bytes([table.TORQUE_ENABLE.address, 0])
    if mode is Mode.DRIVE or (mode is Mode.STOPPED and off):
        return ""
    return "the bus only listens now: nothing that moves or sets a servo is sent."


class Bus:
    """All that is said to the servos goes through here, from one thread.

    Raises:
        BusLost: from every method but `off`, when the adapter is gone.
    """

    def __init__(self, name: str, baud: int, patience: float = 1.0) -> None:
        """
        Args:
            name: of the port.
            baud: its speed.
            patience: factor on every time limit.
        """
        self.name = name
        self._port = Port(name, baud, patience)
        self._handler: Any = Protocol1PacketHandler()
        self._doubtful: dict[int, tuple[int, int]] = {}
        self._goals: Any = GroupSyncWrite(self._port, self._handler, table.GOAL_ADDRESS, table.GOAL_SIZE)
        self.open(baud)

    def open(self, baud: int) -> None:
        """Open the port, or open it again at another speed."""
        if not self._port.setBaudRate(baud):
            raise PipenavError(f"baud {baud} cannot be set by the SDK: choose {sorted(table.BAUD_VALUES)}.")

    @property
    def mode(self) -> Mode:
        return self._port.mode

    @mode.setter
    def mode(self, mode: Mode) -> None:
        self._port.mode = mode

    def expect(self, latency: float) -> None:
        """Wait for answers as long as an adapter of this latency [s] needs, no longer."""
        self._port.allowance = REPLY_ALLOWANCE + latency

    @property
    def descriptor(self) -> int:
        return int(self._port.ser.fileno())

    def on_send(self, listener: Callable[[bytes], None]) -> None:
        """Have every packet that was sent told to `listener`."""
        self._port.sent = listener

    def echoes(self) -> bool:
        """Whether the adapter sends our own bytes back, which would be taken for answers."""
        request = packets.ping(0xFD)  # an id that nobody has
        with self._edge():
            self._port.clearPort()
            self._port.writePort(request)
            deadline, heard = time.monotonic() + self._port.silence, b""
            while time.monotonic() < deadline and len(heard) < len(request):
                heard += self._port.readPort(len(request))
        return heard[: len(request)] == request

    def ping(self, servo: int) -> Answer:
        """Whether a servo is there: data is empty if so."""
        return self._ask(servo, (0, 0), lambda: self._handler.txRxPacket(self._port, [0, 0, servo, 2, packets.PING, 0]))

    def read(self, servo: int, address: int, size: int, retries: int = 1) -> Answer:
        """Bytes of the control table."""
        for _ in range(retries + 1):
            answer = self._read_once(servo, address, size)
            if answer.data is not None:
                break
        return answer

    def read_register(self, servo: int, register: table.Register) -> int | None:
        """One register's value; None if the servo does not answer."""
        data = self.read(servo, register.address, register.size).data
        return None if data is None else int.from_bytes(data, "little")

    def write_register(self, servo: int, register: table.Register, value: int, retries: int = 2) -> bool:
        """Write one register and read it back; whether it holds the value now."""
        data = list(value.to_bytes(register.size, "little"))
        for _ in range(retries + 1):
            with self._edge():
                result, _ = self._handler.writeTxRx(self._port, servo, register.address, register.size, data)
            if result != COMM_SUCCESS:
                self._doubtful[servo] = (-1, -1)  # its acknowledgement may still be on the way
            if self.read_register(servo, register) == value:
                return True
        return False

    def send_goals(self, goals: dict[int, tuple[int, int]]) -> bytes:
        """Goal position and moving speed of every servo in one packet, which no servo answers; the packet."""
        self._goals.clearParam()
        for servo, (goal, speed) in goals.items():
            self._goals.addParam(servo, list(packets.words(goal, speed)))
        with self._edge():
            result = self._goals.txPacket()
        if result != COMM_SUCCESS:
            raise BusLost(self.name, self._handler.getTxRxResult(result))
        return packets.sync_write(table.GOAL_ADDRESS, {s: packets.words(*values) for s, values in goals.items()})

    def off(self, servos: Iterable[int]) -> list[int]:
        """Switch torque off everywhere, whatever state this object is in; never raises.

        Three broadcasts that no servo answers come first, so that neither a dead servo nor the SDK can delay them;
        then every servo is asked.

        Returns:
            The servos that did not confirm.
        """
        self.cut()
        return [servo for servo in servos if not self._is_off(servo)]

    def cut(self) -> None:
        """The broadcasts alone: safe inside a signal handler, at whatever point of the SDK the signal came."""
        port = self._port
        port.mode = Mode.STOPPED
        port.is_using = False
        for _ in range(3):
            with contextlib.suppress(*LOST, AttributeError):
                port.writePort(packets.TORQUE_OFF_ALL)

    def _is_off(self, servo: int) -> bool:
        with contextlib.suppress(BusLost, *LOST, AttributeError, TypeError, IndexError):
            return self.write_register(servo, table.TORQUE_ENABLE, 0, retries=1)
        return False

    def close(self) -> None:
        with contextlib.suppress(*LOST):
            self._port.closePort()

    def _read_once(self, servo: int, address: int, size: int) -> Answer:
        request = [0, 0, servo, 4, packets.READ, address, size, 0]
        answer = self._ask(servo, (address, size), lambda: self._handler.txRxPacket(self._port, request))
        if answer.data is not None and len(answer.data) != size:
            self._doubtful[servo] = (-1, -1)
            return Answer(None, answer.alarms, f"an answer of {len(answer.data)} bytes instead of {size}")
        return answer

    def _ask(self, servo: int, question: tuple[int, int], send: Callable[[], Any]) -> Answer:
        """Send a request and take its answer; after a failure, first wait until a late answer must have come.

        Answers carry no address: a late one would be taken for that of the next question, unless that is the same.
        """
        with self._edge():
            if self._doubtful.get(servo, question) != question:
                self._drain()
            self._doubtful.pop(servo, None)
            reply, result, error = send()
        if result == COMM_SUCCESS:
            return Answer(bytes(reply[5:-1]), table.Alarm(error))
        self._doubtful[servo] = question
        return Answer(None, problem="no answer" if result == COMM_RX_TIMEOUT else "a damaged answer")

    def _drain(self) -> None:
        deadline = time.monotonic() + self._port.silence
        while time.monotonic() < deadline:
            self._port.readPort(256)
        self._port.flush()

    @contextlib.contextmanager
    def _edge(self) -> Any:
        """Everything that a lost adapter raises becomes one error, and the SDK's busy flag never stays behind."""
        try:
            self._port.is_using = False
            yield
        except LOST as error:
            raise BusLost(self.name, str(error) or type(error).__name__) from error
