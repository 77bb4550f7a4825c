"""An AX-12A as its bus sees it: the control table with its rules, and the alarms that follow from its state."""

from __future__ import annotations

from typing import NamedTuple

from pipenav_hardware import packets, table
from pipenav_hardware.emulator.plant import ServoCommand, Shaft
from pipenav_hardware.packets import Packet
from pipenav_hardware.table import REGISTERS, Alarm, Register

NOMINAL_VOLTAGE = 12.0
AMBIENT = 32.0

OVERLOAD_TIME = 2.0
"""Time for which a stalled servo gives more than `OVERLOAD_SHARE` of its torque before it reports overload [s]: the
maker does not publish it; reports say one to three seconds."""
OVERLOAD_SHARE = 0.95

HEATING, COOLING = 6.0, 0.02
"""Rise of temperature at full load [deg C/s], and share of the excess that is lost per second: a stall overheats in
minutes, as reports say."""

CONTROL_LOOP = (table.TORQUE_ENABLE, table.GOAL_POSITION, table.MOVING_SPEED, table.TORQUE_LIMIT)
"""Registers that change what the motor does."""


class _Result(NamedTuple):
    """Result of an instruction: what was wrong with it, and the data that it asked for."""

    problem: Alarm = Alarm(0)
    data: bytes = b""


class EmulatedServo:
    """Control table, access rules and alarms. A plant says where the shaft is.

    Attributes:
        memory: bytes of the control table.
        auto_torque_on_goal: whether it switches torque on when a goal is written.
        volts: supply [V].
        heat: temperature [deg C].
        forced: alarms that it reports whatever its state is.
        model: model number that it gives.
    """

    def __init__(self, servo: int, limits: tuple[int, int], max_torque: int, baud: int = 1_000_000) -> None:
        self.memory = bytearray(table.TABLE_END)
        self.auto_torque_on_goal = False
        self.volts, self.heat = NOMINAL_VOLTAGE, AMBIENT
        self.forced = Alarm(0)
        self.model, self._pending = table.MODEL_NUMBER, b""
        self._stalled = 0.0
        for register in REGISTERS.values():
            self.set(register, register.initial)
        for register, value in (
            (table.ID, servo),
            (table.BAUD, table.BAUD_VALUES[baud]),
            (table.RETURN_DELAY, 0),
            (table.CW_LIMIT, limits[0]),
            (table.CCW_LIMIT, limits[1]),
            (table.MAX_TORQUE, max_torque),
        ):
            self.set(register, value)
        self.power_on(table.CENTRE)

    @property
    def id(self) -> int:
        return self.get(table.ID)

    @property
    def command(self) -> ServoCommand:
        """The command of the motor, from the registers."""
        share = 0.0 if not self.get(table.TORQUE_ENABLE) else self.get(table.TORQUE_LIMIT) * table.SHARE_UNIT
        speed = self.get(table.MOVING_SPEED)
        return ServoCommand(self.get(table.GOAL_POSITION), speed, share, self.is_wheel)

    @property
    def is_wheel(self) -> bool:
        """Whether both angle limits are 0: the servo turns for ever."""
        return self.get(table.CW_LIMIT) == 0 == self.get(table.CCW_LIMIT)

    @property
    def alarms(self) -> Alarm:
        """Alarms that follow from the state."""
        alarms = self.forced
        if not self.get(table.MIN_VOLTAGE) <= round(self.volts * 10) <= self.get(table.MAX_VOLTAGE):
            alarms |= Alarm.VOLTAGE
        if self.heat > self.get(table.TEMPERATURE_LIMIT):
            alarms |= Alarm.OVERHEAT
        if self._stalled > OVERLOAD_TIME:
            alarms |= Alarm.OVERLOAD
        return alarms

    def get(self, register: Register) -> int:
        """Value of a register."""
        return int.from_bytes(self.memory[register.address : register.end], "little")

    def set(self, register: Register, value: int) -> None:
        """Set a register, whatever the access rules say."""
        self.memory[register.address : register.end] = value.to_bytes(register.size, "little")

    def power_on(self, position: float) -> None:
        """Set the RAM as switching power on does: torque off, no speed control, torque limit from the EEPROM."""
        for register in REGISTERS.values():
            if not register.eeprom:
                self.set(register, register.initial)
        self.set(table.GOAL_POSITION, round(min(max(position, 0), table.COUNTS)))
        self.set(table.TORQUE_LIMIT, self.get(table.MAX_TORQUE))
        self._pending, self._stalled = b"", 0.0

    def feel(self, shaft: Shaft, dt: float) -> None:
        """Take over position, speed and load of the shaft, `dt` seconds after the last time."""
        load = abs(shaft.load)
        self.heat += dt * (HEATING * load**2 - COOLING * (self.heat - AMBIENT))
        stalled = load > OVERLOAD_SHARE and abs(shaft.speed) < table.SPEED_UNIT
        self._stalled = self._stalled + dt if stalled or self._stalled > OVERLOAD_TIME else 0.0
        self.set(table.MODEL, self.model)
        self.set(table.PRESENT_POSITION, round(min(max(shaft.position, 0), table.COUNTS)))
        self.set(table.PRESENT_SPEED, table.raw_signed(round(shaft.speed / table.SPEED_UNIT)))
        self.set(table.PRESENT_LOAD, table.raw_signed(round(shaft.load / table.SHARE_UNIT)))
        self.set(table.PRESENT_VOLTAGE, min(round(self.volts * 10), 255))
        self.set(table.PRESENT_TEMPERATURE, min(round(self.heat), 255))
        self.set(table.MOVING, int(abs(shaft.speed) > table.SPEED_UNIT))
        if self.alarms & self.get(table.SHUTDOWN):
            self.set(table.TORQUE_LIMIT, 0)  # output stays 0 % until a torque limit is written again

    def answer(self, packet: Packet) -> bytes | None:
        """Carry out an instruction.

        Returns:
            The status packet; None where a servo stays silent.
        """
        broadcast = packet.id == packets.BROADCAST
        if not broadcast and packet.id != self.id:
            return None
        if not packet.valid:
            return None if broadcast else self._status(Alarm.CHECKSUM)
        result = self._execute(packet)
        level = self.get(table.RETURN_LEVEL)
        speaks = packet.code == packets.PING or level == 2 or (level == 1 and packet.code == packets.READ)
        return None if broadcast or not speaks else self._status(*result)

    def _status(self, problem: Alarm, data: bytes = b"") -> bytes:
        return Packet(self.id, int(self.alarms | problem), data).encode()

    def _execute(self, packet: Packet) -> _Result:
        code, parameters = packet.code, packet.parameters
        if code == packets.PING:
            return _Result()
        if code == packets.READ and len(parameters) == 2:
            address, size = parameters
            inside = size > 0 and address + size <= table.TABLE_END
            return _Result(data=bytes(self.memory[address : address + size])) if inside else _Result(Alarm.RANGE)
        if code == packets.WRITE and len(parameters) > 1:
            return _Result(self._write(parameters[0], parameters[1:]))
        if code == packets.REG_WRITE and len(parameters) > 1:
            self._pending = parameters
            self.set(table.REGISTERED, 1)
            return _Result()
        if code == packets.ACTION:
            return _Result(self._action())
        if code == packets.SYNC_WRITE and packet.id == packets.BROADCAST and len(parameters) > 2:
            return _Result(self._sync_write(parameters))
        if code == packets.RESET:
            for register in REGISTERS.values():
                if register.eeprom:
                    self.set(register, register.initial)
            return _Result()
        return _Result(Alarm.INSTRUCTION)

    def _action(self) -> Alarm:
        if not self._pending:
            return Alarm.INSTRUCTION
        pending, self._pending = self._pending, b""
        self.set(table.REGISTERED, 0)
        return self._write(pending[0], pending[1:])

    def _sync_write(self, parameters: bytes) -> Alarm:
        address, size = parameters[0], parameters[1]
        for start in range(2, len(parameters) - size, size + 1):
            if parameters[start] == self.id:
                return self._write(address, parameters[start + 1 : start + 1 + size])
        return Alarm(0)

    def _write(self, address: int, data: bytes) -> Alarm:
        """Write all registers that the bytes cover, or none; what was wrong."""
        end = address + len(data)
        draft = bytearray(self.memory)
        if end > table.TABLE_END:
            return Alarm.RANGE
        draft[address:end] = data
        touched = [r for r in REGISTERS.values() if r.address < end and address < r.end]
        for register in touched:
            value = int.from_bytes(draft[register.address : register.end], "little")
            if not register.writable or not register.low <= value <= register.high:
                return Alarm.RANGE
            if register.eeprom and (self.get(table.TORQUE_ENABLE) or self.get(table.LOCK)):
                return Alarm.RANGE
        if table.GOAL_POSITION in touched and not self.is_wheel:
            goal = table.word(bytes(draft), table.GOAL_POSITION.address)
            if not self.get(table.CW_LIMIT) <= goal <= self.get(table.CCW_LIMIT):
                return Alarm.ANGLE
            if self.auto_torque_on_goal:
                draft[table.TORQUE_ENABLE.address] = 1
        self.memory[:] = draft
        return Alarm(0)
