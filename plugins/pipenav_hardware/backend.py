"""The real arm behind the backend seam: read and commanded at a fixed rate, stopped when a rule is broken."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from pipenav.arrays import Floats, Ints
from pipenav.backends import (
    CONTROL_PERIOD,
    ArmStart,
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
    TorqueUnconfirmed,
)
from pipenav.errors import PipenavError
from pipenav.pipes import Pipe, PipeCorner
from pipenav.robots import RobotSpec
from pipenav_hardware import table
from pipenav_hardware.arm_config import load_arm
from pipenav_hardware.beam_filter import BeamFilter
from pipenav_hardware.calibrate import Calibration
from pipenav_hardware.check import findings
from pipenav_hardware.codec import Codec, Raw
from pipenav_hardware.dynamixel import Bus
from pipenav_hardware.ranging import late_for_scan
from pipenav_hardware.recording import arm_description, recorded_arithmetic, sent_command, tick_record
from pipenav_hardware.sensors import Sensors
from pipenav_hardware.servo_flaws import require, speed_flaw
from pipenav_hardware.servo_memory import store_described
from pipenav_hardware.servos import ServoAnswers, Servos
from pipenav_hardware.trips import SensorRules, ServoRules
from pipenav_hardware.watchdog import Watchdog

START_TOLERANCE = 0.02
"""Farthest that a joint may be from the start that `reset` is given [rad or m]: nothing moves on a reset."""


class HardwareOptions(BackendOptions):
    """Settings of the hardware backend."""

    arm: str = Field("arm.toml", description="the arm's description, as pipenav calibrate writes it")
    listen_only: bool = Field(False, description="send nothing but questions: the arm does not move")
    allow_slow_bus: bool = Field(False, description="accept an adapter that answers after more than 12 ms")
    patience: float = Field(
        1.0, ge=1, le=100, description="factor on every time limit; above 1 only to test on a busy machine"
    )


class HardwareBackend(RealRobot):
    """The real arm, see `RealRobot`. Connecting only asks; `reset` switches torque on where the arm is.

    Attributes:
        arm: the arm's description.
    """

    Options = HardwareOptions

    def __init__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int = 4) -> None:  # noqa: ARG002
        assert isinstance(options, HardwareOptions)
        if n != 1:
            raise PipenavError(f"the hardware backend drives one arm, {n} were asked for.")
        self._options, self._robot = options, robot
        self.arm = load_arm(Path(options.arm))
        self.arm.require(robot)
        require(speed_flaw(self.arm))
        self.complete, self.warnings = False, list[str]()
        self._enabled, self._due = False, math.nan
        self._unconfirmed: list[str] = []
        self._reading: Reading | None = None
        self._alarms: tuple[table.Alarm, ...] = ()
        self._seconds: dict[str, float] = {}
        self._start_goals: list[int] | None = None
        with contextlib.ExitStack() as opened:
            self._bus = Bus(self.arm.port, self.arm.baud, options.patience)
            opened.callback(self._bus.close)
            self._servos = Servos(self.arm, self._bus, options.allow_slow_bus, Path(options.arm))
            self._sensors = Sensors(self.arm, robot)
            opened.callback(self._sensors.close)
            self._watchdog = (
                None if options.listen_only else Watchdog(self._bus.descriptor, options.patience, self.arm.joints)
            )
            self._opened = opened.pop_all()
        self._begin()
        self.warnings = list(self._servos.warnings)

    @property
    def joint_limits(self) -> Floats:
        return np.array([servo.limits for servo in self.arm.servos])

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
            joint = self._robot.joints[int(away.argmax())]
            where = f"{away.max():.3f} {'m' if joint.type == 'slide' else 'rad'} from its start position"
            raise PipenavError(f"joint {joint.name} is {where}: move the arm there by hand.")
        if self._watchdog is not None:
            self._watchdog.armed()
            self._enabled = True
            self._start_goals = self._servos.enable(self._codec.speeds, self._watchdog.beat)
            self._forget()
            self._codec.last = np.array(self._start_goals, float)
        return reading

    def read(self) -> Reading:
        if math.isnan(self._due):
            self._sensors.await_scan(1.5 * CONTROL_PERIOD)
            self._due = self._start = time.monotonic()
        self._beat()
        begun, self._seconds = time.monotonic(), {}
        answers = self._servos.read()
        self._seconds["bus"] = time.monotonic() - begun
        self._sensors.listen(time.monotonic())
        reading = self._reading_of(answers)
        self.complete = reading is not None
        if reading is not None:
            self._reading = reading
        if self._enabled:
            self._servos.verify(answers.settings)
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
            Stopped: the tick is so late that they must not be sent, or they are no usable set-points.
        """
        begun = time.monotonic()
        self._deadlines.check(begun - self._due)
        encoded = self._codec.encode(command)
        if encoded.goals and not self._options.listen_only:
            self._servos.send_goals(encoded.goals)
        self._beat()
        self._seconds["send"] = time.monotonic() - begun
        self._note_taken()
        return sent_command(self.arm, encoded)

    def hold(self) -> None:
        self._beat()
        self._note_taken()

    def wait(self) -> None:
        """Wait until the next tick is due, listening to the sensors.

        Raises:
            Stopped: the tick, with its recording, was much too late, or late for the second time in a row.
        """
        self._deadlines.check(time.monotonic() - self._due)
        self._deadlines.begin()
        self._due += CONTROL_PERIOD - late_for_scan(self._due, self._sensors.scanner.latest())
        if time.monotonic() - self._due > CONTROL_PERIOD / 2:
            self._due = time.monotonic()  # a late tick moves the schedule; it does not shorten the ticks after it
        self._sensors.listen_until(self._due)

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
        self._unconfirmed = [servo.joint for servo in self.arm.servos if servo.id in silent]
        return self._unconfirmed

    def raw(self) -> dict[str, Any]:
        return {
            **tick_record(self._raw, self._alarms),
            "problem": self._codec.problem,
            "late": self._deadlines.missed,
            "seconds": self._seconds,
        }

    def description(self) -> dict[str, Any]:
        return arm_description(self.arm, self._sensors.scanner, self._start_goals, self.latency)

    @classmethod
    def recoder(cls, robot: RobotSpec, description: Mapping[str, Any]) -> Recoder:
        return recorded_arithmetic(robot, description)

    @classmethod
    def check(cls, options: BackendOptions, robot: RobotSpec | None = None) -> Iterator[Finding]:
        assert isinstance(options, HardwareOptions)
        arm = load_arm(Path(options.arm))
        if robot is not None:
            arm.require(robot)
        return findings(arm, Path(options.arm), options.allow_slow_bus)

    @classmethod
    def calibrator(cls, robot: RobotSpec, ports: Mapping[str, str], may_write: bool = False) -> Calibrator:
        return Calibration(robot, ports, may_write)

    @classmethod
    def store(cls, options: BackendOptions) -> list[str]:
        assert isinstance(options, HardwareOptions)
        return store_described(Path(options.arm))

    @classmethod
    @contextlib.contextmanager
    def emulate(
        cls,
        robot: RobotSpec,
        pipe: PipeCorner,
        start: ArmStart,
        folder: Path,
        seed: int,
        faults: Sequence[Mapping[str, Any]],
    ) -> Iterator[Emulated]:
        from pipenav_hardware.emulator.client import Emulator
        from pipenav_hardware.emulator.config import EmulatorSettings
        from pipenav_hardware.emulator.faults import fault_script

        settings = EmulatorSettings(seed=seed, faults=fault_script(faults))
        with Emulator(robot, settings, pipe, start, folder) as emulator:
            yield Emulated(HardwareOptions(arm=str(emulator.arm_path)), emulator.log_path)

    def close(self) -> None:
        named, unconfirmed = self._unconfirmed, self.off()
        self._opened.close()
        if self._watchdog is not None:
            self._watchdog.close()
        if unconfirmed and not named:
            raise TorqueUnconfirmed(unconfirmed)

    def _begin(self) -> None:
        """Start anew, as after a pause."""
        self._forget()
        self._rules, self._sensor_rules = ServoRules(self.arm), SensorRules(self._options.patience)
        self._deadlines = Deadlines(CONTROL_PERIOD, self._options.patience)
        self._reading = None
        self._raw, self._alarms, self._seconds = Raw((), None, None, 0.0), (), {}
        self._due, self._start = math.nan, time.monotonic()
        self._sensors.refresh()

    def _forget(self) -> None:
        """Drop what was known of earlier ticks: a mission decides by its own ticks alone, which a replay has too."""
        scanner = self._sensors.scanner
        self._beams = BeamFilter(self._robot.laser, scanner.angles, scanner.range_min, scanner.range_max)
        self._codec = Codec(self._robot, self.arm, self._beams)
        self._sequence = -1

    def _first_reading(self) -> Reading:
        """A whole reading without a tick; a lost answer is asked for once more."""
        for _ in range(3):
            reading = self._reading_of(self._servos.read())
            if reading is not None:
                return reading
        raise PipenavError(f"no first reading: {self._codec.problem}; run pipenav hw-check.")

    def _reading_of(self, answers: ServoAnswers) -> Reading | None:
        """The reading of this tick, judged by all rules; None where it is not whole.

        Raises:
            Stopped: a rule about servos, sensors or positions is broken.
        """
        now = time.monotonic()
        front_sensor, newest = self._sensors.front, self._sensors.scanner.latest()
        scan = newest if newest is not None and newest.sequence != self._sequence else None
        front = None if front_sensor is None else front_sensor.distance
        self._raw, self._alarms = Raw(answers.states, scan, front, now - self._start), answers.alarms
        reading = self._codec.decode(self._raw)
        self._rules.alarmed(answers.alarms)
        self._rules.answered([data is not None for data in answers.states])
        self._rules.check(self._codec.states, self._codec.last if self._enabled else None)
        self.warnings = [*self._servos.warnings, *self._rules.warnings]
        if scan is not None:
            self._sequence = scan.sequence
            self._sensor_rules.scanned(scan, self._beams.all_invalid)
        self._sensor_rules.aged("scanner", now - newest.stamp if newest else math.inf)
        if front_sensor is not None:
            self._sensor_rules.aged("front sensor", now - front_sensor.stamp)
        return reading

    def _note_taken(self) -> None:
        """Note how long the tick has taken until now, when all that it sends is sent."""
        self._seconds["taken"] = time.monotonic() - self._due
        self._deadlines.note(self._seconds["taken"])

    def _beat(self) -> None:
        """Let the supervisor hear that the driver lives."""
        if self._watchdog is not None:
            self._watchdog.beat()
