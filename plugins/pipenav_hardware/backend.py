"""One real arm behind the backend seam: read, told and waited for at a fixed rate, stopped when a rule is broken."""

from __future__ import annotations

import contextlib
import math
import select
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from pipenav.arrays import Floats, Ints
from pipenav.backends import (
    CONTROL_PERIOD,
    BackendOptions,
    Calibrator,
    Command,
    Deadlines,
    Emulated,
    Finding,
    Reading,
    RealRobot,
    Recoder,
    Sent,
    Stopped,
    Truth,
)
from pipenav.errors import PipenavError
from pipenav.pipes import Pipe, PipeCorner
from pipenav.robots import RobotSpec
from pipenav_hardware import packets, table
from pipenav_hardware.arm_config import ArmConfig, load_arm
from pipenav_hardware.calibrate import Calibration
from pipenav_hardware.check import findings
from pipenav_hardware.codec import Codec, Encoded, Raw
from pipenav_hardware.dynamixel import Bus
from pipenav_hardware.front_sensor import FrontSensor
from pipenav_hardware.ranging import BeamFilter, RangeScan, RangeSensor, SensorLost, await_scan, late_for_scan
from pipenav_hardware.scip2 import open_scanner
from pipenav_hardware.servos import Servos, Told
from pipenav_hardware.trips import SensorRules, ServoRules
from pipenav_hardware.watchdog import Watchdog

START_TOLERANCE = 0.02
"""Farthest that a joint may be from where `reset` is told that it is [rad or m]: nothing moves on a reset."""

FRESH_TIMEOUT = 1.0
"""Longest wait for two scans that were taken after a pause [s]."""


class HardwareOptions(BackendOptions):
    """Settings of the hardware backend."""

    arm: str = Field("arm.toml", description="the arm's description, as pipenav calibrate writes it")
    listen_only: bool = Field(False, description="send nothing but questions: the arm does not move")
    allow_slow_bus: bool = Field(False, description="accept an adapter that answers after more than 12 ms")
    patience: float = Field(
        1.0, ge=1, le=100, description="factor on every time limit; above 1 only to test on a busy machine"
    )


class HardwareBackend(RealRobot):
    """See `pipenav.backends.real_robot.Machine`. Connecting only asks; `reset` switches torque on where the arm is."""

    Options = HardwareOptions

    def __init__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int = 4) -> None:  # noqa: ARG002
        assert isinstance(options, HardwareOptions)
        if n != 1:
            raise PipenavError(f"the hardware backend drives one arm, {n} were asked for.")
        self._options, self._robot = options, robot
        self.arm = load_arm(Path(options.arm))
        self.arm.require(robot)
        self.complete, self.warnings = False, list[str]()
        self._enabled, self._due = False, math.nan
        self._reading: Reading | None = None
        self._alarms: tuple[table.Alarm, ...] = ()
        self._seconds: dict[str, float] = {}
        self._start_goals: list[int] | None = None
        with contextlib.ExitStack() as opened:
            self._bus = Bus(self.arm.port, self.arm.baud, options.patience)
            opened.callback(self._bus.close)
            self._servos = Servos(self.arm, self._bus, options.allow_slow_bus)
            self._scanner: RangeSensor = open_scanner(self.arm.scanner, math.radians(robot.laser.fan_deg))
            opened.callback(self._scanner.close)
            self._front = FrontSensor(self.arm.front_sensor) if self.arm.front_sensor else None
            if self._front is not None:
                opened.callback(self._front.close)
            self._watchdog = None if options.listen_only else Watchdog(self._bus.descriptor, options.patience)
            self._opened = opened.pop_all()
        self._begin()

    @property
    def latency(self) -> float:
        """Median answer time of the servo bus [s]."""
        return self._servos.latency

    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:  # noqa: ARG002
        """Switch torque on where the arm is.

        Raises:
            PipenavError: the arm is not at `q`, or a joint is outside its limits.
        """
        self._begin()
        reading = self._reading = self._first_reading()
        away = np.abs(reading.q[0] - q[0])
        if away.max() > START_TOLERANCE:
            joint = self._robot.joints[int(away.argmax())].name
            raise PipenavError(
                f"joint {joint} is {away.max():.3f} from its start position: move the arm there by hand."
            )
        if self._watchdog is not None:
            self._watchdog.armed()
            self._enabled = True
            self._start_goals = self._servos.enable(self._codec.speeds, self._watchdog.beat)
            self._forget()
            self._codec.last = np.array(self._start_goals, float)
        return reading

    def read(self) -> Reading:
        if math.isnan(self._due):
            await_scan(self._scanner, self._listen, 1.5 * CONTROL_PERIOD)
            self._due = self._start = time.monotonic()
        self._beat()
        begun, self._seconds = time.monotonic(), {}
        told = self._servos.read()
        self._seconds["bus"] = time.monotonic() - begun
        self._listen(time.monotonic())
        reading = self._judge(told)
        self.complete = reading is not None
        if reading is not None:
            self._reading = reading
        if self._enabled:
            self._servos.verify(told.settings)
        self._seconds["read"] = time.monotonic() - begun
        if self._reading is None:
            self._reading, self.complete = self._first_reading(), True
        return self._reading

    def step(self, command: Command) -> None:
        self.send(command)
        self.wait()

    def send(self, command: Command) -> Sent:
        """Send set-points, limited.

        Raises:
            Stopped: the tick is so late that they must not be sent, or they are none.
        """
        begun = time.monotonic()
        self._deadlines.check(begun - self._due)
        encoded = self._codec.encode(command)
        if encoded.goals and not self._options.listen_only:
            self._servos.tell(encoded.goals)
        self._beat()
        self._seconds["send"] = time.monotonic() - begun
        self._taken()
        return _sent(self.arm, encoded)

    def hold(self) -> None:
        self._beat()
        self._taken()

    def wait(self) -> None:
        """See `RealRobot.wait`; raises `Stopped` where the tick, with its recording, was late twice in a row or much."""
        self._deadlines.check(time.monotonic() - self._due)
        self._deadlines.begin()
        self._due += CONTROL_PERIOD - late_for_scan(self._due, self._scanner.latest())
        if time.monotonic() - self._due > CONTROL_PERIOD / 2:
            self._due = time.monotonic()  # a late tick moves the schedule; it does not shorten the ticks after it
        sensors = [sensor for sensor in (self._scanner, self._front) if sensor is not None]
        descriptors = [sensor.fileno() for sensor in sensors if sensor.fileno() >= 0]
        while (left := self._due - time.monotonic()) > 0:
            select.select(descriptors, [], [], left)
            self._listen(time.monotonic())
            if len(descriptors) < len(sensors):
                time.sleep(min(0.005, max(0.0, self._due - time.monotonic())))

    def truth(self) -> Truth | None:
        return None

    def cut(self) -> None:
        if not self._options.listen_only:
            self._bus.cut()

    def off(self) -> list[str]:
        if not self._enabled:
            return []
        silent = self._bus.off(self.arm.ids)
        self._enabled = bool(silent)
        if self._watchdog is not None and not silent:
            self._watchdog.disarmed()
        return [servo.joint for servo in self.arm.servos if servo.id in silent]

    def raw(self) -> dict[str, Any]:
        scan = self._raw.scan
        return {
            "states": [None if data is None else data.hex() for data in self._raw.states],
            "alarms": [int(alarm) for alarm in self._alarms],
            "scan_mm": None if scan is None else list(scan.distances),
            "scan_sequence": None if scan is None else scan.sequence,
            "front_m": self._raw.front,
            "time": self._raw.time,
            "problem": self._codec.problem,
            "late": self._deadlines.missed,
            "seconds": self._seconds,
        }

    def description(self) -> dict[str, Any]:
        return {
            "arm": self.arm.model_dump(mode="json"),
            "scanner": {
                "angles": self._scanner.angles.tolist(),
                "range_min": self._scanner.range_min,
                "range_max": self._scanner.range_max,
            },
            "start_goals": self._start_goals,
            "latency": self.latency,
        }

    @classmethod
    def recoder(cls, robot: RobotSpec, description: Mapping[str, Any]) -> Recoder:
        arm = ArmConfig.model_validate(description["arm"])
        scanner = description["scanner"]
        beams = _beam_filter(robot, np.array(scanner["angles"]), scanner["range_min"], scanner["range_max"])
        codec = Codec(robot, arm, beams)
        if description["start_goals"] is not None:
            codec.last = np.array(description["start_goals"], float)
        return Recoder(lambda raw: codec.decode(_recorded(raw)), lambda command: _sent(arm, codec.encode(command)))

    @classmethod
    def check(cls, options: BackendOptions) -> Iterator[Finding]:
        assert isinstance(options, HardwareOptions)
        return findings(load_arm(Path(options.arm)))

    @classmethod
    def calibrator(cls, robot: RobotSpec, ports: Mapping[str, str]) -> Calibrator:
        return Calibration(robot, ports)

    @classmethod
    @contextlib.contextmanager
    def emulate(
        cls, robot: RobotSpec, pipe: PipeCorner, folder: Path, seed: int, faults: Sequence[Mapping[str, Any]]
    ) -> Iterator[Emulated]:
        from pipenav.tasks.reach import episode
        from pipenav.tasks.reach.config import ReachConfig
        from pipenav_hardware.emulator.client import Emulator
        from pipenav_hardware.emulator.faults import require_faults

        require_faults(faults)
        start = episode.sample(robot, ReachConfig(), [pipe], np.random.default_rng(seed))
        base = float(start.base[0])
        settings: dict[str, Any] = {"seed": seed, "faults": [dict(fault) for fault in faults]}
        with Emulator(robot, pipe, folder=folder, q=start.q[0], base=base, **settings) as emulator:
            yield Emulated(HardwareOptions(arm=str(emulator.arm_path)), base, emulator.log_path)

    def close(self) -> None:
        self.off()
        self._opened.close()
        if self._watchdog is not None:
            self._watchdog.close()

    def _begin(self) -> None:
        """Start anew, as after a pause."""
        self._forget()
        self._rules, self._sensor_rules = ServoRules(self.arm), SensorRules(self._options.patience)
        self._deadlines = Deadlines(CONTROL_PERIOD, self._options.patience)
        self._reading = None
        self._raw, self._alarms, self._seconds = Raw((), None, None, 0.0), (), {}
        self._due, self._start = math.nan, time.monotonic()
        self._fresh()

    def _forget(self) -> None:
        """Drop what was known of earlier ticks: what a run decides comes from its own ticks, which a replay has."""
        scanner = self._scanner
        self._beams = _beam_filter(self._robot, scanner.angles, scanner.range_min, scanner.range_max)
        self._codec = Codec(self._robot, self.arm, self._beams)
        self._sequence = -1

    def _first_reading(self) -> Reading:
        """A whole reading without a tick; a lost answer is asked for once more."""
        for _ in range(3):
            reading = self._judge(self._servos.read())
            if reading is not None:
                return reading
        raise PipenavError(f"no first reading: {self._codec.problem}; run pipenav hw-check.")

    def _fresh(self) -> None:
        """Drop what sensors sent during a pause and wait for news."""
        self._listen(time.monotonic())
        for _ in range(2):  # the first of them may have begun before
            await_scan(self._scanner, self._listen, FRESH_TIMEOUT / 2)

    def _listen(self, now: float) -> None:
        try:
            self._scanner.pump(now)
            if self._front is not None:
                self._front.pump(now)
        except SensorLost as lost:
            raise Stopped("sensor-lost", str(lost).rstrip("."), "then start again") from lost

    def _judge(self, told: Told) -> Reading | None:
        """The reading in this tick's answers.

        Raises:
            Stopped: a rule of servos, sensors or positions is broken.
        """
        now = time.monotonic()
        newest = self._scanner.latest()
        scan = newest if newest is not None and newest.sequence != self._sequence else None
        front = None if self._front is None else self._front.distance
        self._raw, self._alarms = Raw(told.states, scan, front, now - self._start), told.alarms
        reading = self._codec.decode(self._raw)
        self._rules.alarmed(told.alarms)
        self._rules.answered([data is not None for data in told.states])
        self._rules.check(self._codec.states, self._codec.last if self._enabled else None)
        self.warnings = [*self._servos.warnings, *self._rules.warnings]
        if scan is not None:
            self._sequence = scan.sequence
            self._sensor_rules.scanned(scan, self._beams.all_invalid)
        self._sensor_rules.aged("scanner", now - newest.stamp if newest else math.inf)
        if self._front is not None:
            self._sensor_rules.aged("front sensor", now - self._front.stamp)
        return reading

    def _taken(self) -> None:
        """What the servos shall be told in this tick, they have been told."""
        self._seconds["taken"] = time.monotonic() - self._due
        self._deadlines.note(self._seconds["taken"])

    def _beat(self) -> None:
        if self._watchdog is not None:
            self._watchdog.beat()


def _beam_filter(robot: RobotSpec, angles: Floats, range_min: float, range_max: float) -> BeamFilter:
    return BeamFilter(robot.laser, angles, range_min, range_max)


def _sent(arm: ArmConfig, encoded: Encoded) -> Sent:
    registers = {servo: packets.words(*values) for servo, values in encoded.goals.items()}
    packet = packets.sync_write(table.GOAL_ADDRESS, registers).hex() if registers else ""
    clamped = [servo.joint for servo, was in zip(arm.servos, encoded.clamped, strict=True) if was]
    return Sent([float(value) for value in encoded.positions], clamped, packet)


def _recorded(raw: Mapping[str, Any]) -> Raw:
    """A tick as the telemetry holds it."""
    states = tuple(None if text is None else bytes.fromhex(text) for text in raw["states"])
    scan = None if raw["scan_mm"] is None else RangeScan(tuple(raw["scan_mm"]), 0.0, raw["scan_sequence"])
    return Raw(states, scan, raw["front_m"], raw["time"])
