"""The servo bus: dynamixel-sdk's packets on our own port, with the sharp edges that were measured on the SDK taken off.

The SDK leaves its port marked busy when an exception passes through, and takes whatever comes for an answer. Here every
answer is checked for length, a late one is waited for before the next question, and switching torque off needs none of
the SDK's state. See `serial_port` for how the port waits.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS, GroupSyncWrite, Protocol1PacketHandler

from pipenav.backends import Stopped
from pipenav_hardware import packets, table
from pipenav_hardware.serial_port import LOST, Mode, Port
from pipenav_hardware.table import ServoGoal

REPLY_ALLOWANCE = 0.012
"""Longest silence of a servo before it counts as missing [s]; the bytes' own time is added.

The SDK waits 34 ms; four silent servos would then use up more than a control period. With 12 ms a healthy bus behind
an adapter of 1 ms had no false time-out in 10,000 ticks.
"""


class BusLost(Stopped):
    """The adapter is gone or takes no bytes."""

    def __init__(self, port: str, why: object) -> None:
        super().__init__(
            "bus-lost", f"the servo bus on {port} is lost ({why})", "check the USB cable, then start again"
        )


class Answer(NamedTuple):
    """The answer to a request.

    Attributes:
        data: bytes of the length asked for; None without a usable answer.
        alarms: alarms that came with the answer.
        problem: why there is no data; empty where there is.
    """

    data: bytes | None
    alarms: table.Alarm = table.Alarm(0)
    problem: str = ""


class _Question(NamedTuple):
    """Part of the control table that a servo was asked for."""

    address: int
    size: int


PRESENCE = _Question(0, 0)
"""Question of a PING."""

UNRELATED = _Question(-1, -1)
"""Stands for a question that no later one repeats."""


class Bus:
    """The only way to the servos, for one thread.

    Raises:
        BusLost: the adapter is gone; every method but `cut`, `off` and `close` may raise it.
    """

    def __init__(self, name: str, baud: int, patience: float = 1.0) -> None:
        """
        Args:
            name: device of the port.
            baud: speed of the port.
            patience: factor on every time limit.
        """
        self.name = name
        self._port = Port(name, baud, patience)
        self._handler: Any = Protocol1PacketHandler()
        self._doubtful: dict[int, _Question] = {}  # servos whose answer may still come
        self._goals: Any = GroupSyncWrite(self._port, self._handler, table.GOAL_ADDRESS, table.GOAL_SIZE)
        self.open(baud)

    def open(self, baud: int) -> None:
        """Open the port, or open it again at another speed."""
        self._port.setBaudRate(baud)
        self._doubtful.clear()

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
    def baud(self) -> int:
        """Speed of the port."""
        return int(self._port.baudrate)

    @property
    def descriptor(self) -> int:
        return int(self._port.ser.fileno())

    def on_send(self, listener: Callable[[bytes], None]) -> None:
        """Call `listener` with every packet that was sent from now on."""
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
        """Whether a servo is there: the data is empty if so, else None."""
        request = [0, 0, servo, 2, packets.PING, 0]
        return self._ask(servo, PRESENCE, lambda: self._handler.txRxPacket(self._port, request))

    def read(self, servo: int, address: int, size: int, retries: int = 1) -> Answer:
        """Read bytes of the control table."""
        for _ in range(retries + 1):
            answer = self._read_once(servo, address, size)
            if answer.data is not None:
                break
        return answer

    def read_register(self, servo: int, register: table.Register) -> int | None:
        """Value of one register; None if the servo does not answer."""
        data = self.read(servo, register.address, register.size).data
        return None if data is None else int.from_bytes(data, "little")

    def write_register(self, servo: int, register: table.Register, value: int, retries: int = 2) -> bool:
        """Write one register and read it back.

        Returns:
            Whether it holds the value now.
        """
        data = list(value.to_bytes(register.size, "little"))
        for _ in range(retries + 1):
            with self._edge():
                result, _ = self._handler.writeTxRx(self._port, servo, register.address, register.size, data)
            if result != COMM_SUCCESS:
                self._doubtful[servo] = UNRELATED  # its acknowledgement may still be on the way
            if self.read_register(servo, register) == value:
                return True
        return False

    def send_goals(self, goals: Mapping[int, ServoGoal]) -> bytes:
        """Send goal position and moving speed of every servo in one packet, which no servo answers.

        Args:
            goals: id of a servo -> its goal.

        Returns:
            The packet.
        """
        self._goals.clearParam()
        for servo, goal in goals.items():
            self._goals.addParam(servo, list(packets.words(*goal)))
        with self._edge():
            result = self._goals.txPacket()
        if result != COMM_SUCCESS:
            raise BusLost(self.name, self._handler.getTxRxResult(result))
        return packets.goal_packet(goals)

    def off(self, servos: Iterable[int]) -> list[int]:
        """Switch torque off everywhere, whatever state this object is in; never raises.

        Three broadcasts that no servo answers come first, so that neither a dead servo nor the SDK can delay them;
        then every servo is asked.

        Returns:
            Ids of the servos that did not confirm.
        """
        self.cut()
        return [servo for servo in servos if not self._is_off(servo)]

    def cut(self) -> None:
        """Send the broadcasts alone: safe inside a signal handler, at whatever point of the SDK the signal came."""
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
        answer = self._ask(servo, _Question(address, size), lambda: self._handler.txRxPacket(self._port, request))
        if answer.data is not None and len(answer.data) != size:
            self._doubtful[servo] = UNRELATED
            return Answer(None, answer.alarms, f"an answer of {len(answer.data)} bytes instead of {size}")
        return answer

    def _ask(self, servo: int, question: _Question, send: Callable[[], Any]) -> Answer:
        """Send a request and take its answer; after a failure, first wait until a late answer must have come.

        Answers carry no address: a late one would be taken for the answer to the next question, which does no harm only
        where the question is the same.
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
        """Wait until a late answer must have come, and drop it."""
        deadline = time.monotonic() + self._port.silence
        while time.monotonic() < deadline:
            self._port.readPort(256)
        self._port.flush()

    @contextlib.contextmanager
    def _edge(self) -> Iterator[None]:
        """Turn everything that a lost adapter raises into one error, and never leave the SDK's busy flag behind."""
        try:
            self._port.is_using = False
            yield
        except LOST as error:
            raise BusLost(self.name, str(error) or type(error).__name__) from error
