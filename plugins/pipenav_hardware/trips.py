"""Rules about servos and sensors whose breach stops the arm; `docs/guides/the-arm.md` says what to do after each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from pipenav.arrays import Floats
from pipenav.backends import CONTROL_PERIOD, Repeats, Stopped
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.ranging import RangeScan
from pipenav_hardware.table import COUNT, Alarm, State

HOT = 60
"""Temperature that stops the arm [deg C]; the servo itself gives up at 70."""

LEAST_VOLTS, MOST_VOLTS, WARN_VOLTS = 9.0, 12.6, 9.5
"""Supply below and above which the arm stops when it lasts, and below which is warned [V]: an AX-12A is rated for 9 to
12 V and by itself reports nothing above 6."""

LASTING = round(0.5 / CONTROL_PERIOD)
"""Number of ticks for which a voltage or a stall must last."""

STALL_SHARE = 0.8
"""Load of a stall, as a share of the torque limit: beyond that limit no load can be read."""

STALL_ERROR = 0.0873
"""Position error of a stall [rad], 5 deg."""

STALL_MOTION = 4
"""Motion within a tick that still counts as none [counts]: a servo at full torque that moves is not stalled."""

SILENT_TICKS = 1
"""Number of ticks without an answer that are forgiven; in the next one the arm stops."""

STALE = 0.25
"""Age beyond which a scan or a front reading stops the arm [s]."""

BAD_SCANS = 2
"""Number of scans without a valid point, or all the same, that are forgiven; the next one stops the arm."""

HW_CHECK = "run pipenav hw-check"


class AlarmReason(NamedTuple):
    """Why an alarm stops the arm: cause and sentence of the message, and what to do."""

    cause: str
    what: str
    remedy: str


STATE_ALARMS = {
    Alarm.VOLTAGE: AlarmReason("voltage", "reports its supply voltage out of range", "check the supply and its cable"),
    Alarm.OVERHEAT: AlarmReason(
        "overheat", "reports overheating", "let it cool for 20 minutes, and look for what held it"
    ),
    Alarm.OVERLOAD: AlarmReason(
        "overload", "reports overload", "look for what held it, then switch the supply off and on"
    ),
    Alarm.ANGLE: AlarmReason("angle-limit", "refused a goal beyond its angle limits", HW_CHECK),
    Alarm.RANGE: AlarmReason("range", "refused a value", HW_CHECK),
    Alarm.INSTRUCTION: AlarmReason("instruction", "did not understand an instruction", HW_CHECK),
}
"""Alarm bits that stop the arm, in the order in which they explain each other; a checksum error is the line's, and is
counted as a bad answer."""


class ServoRules:
    """Watches every servo over time.

    Attributes:
        warnings: what is not yet a reason to stop, in the last tick.
    """

    def __init__(self, arm: ArmConfig) -> None:
        self._arm = arm
        count = len(arm.servos)
        self._silent = [Repeats(SILENT_TICKS) for _ in range(count)]
        self._volts = [Repeats(LASTING - 1) for _ in range(count)]
        self._stalls = [Repeats(LASTING - 1) for _ in range(count)]
        self._before: list[int | None] = [None] * count
        self.warnings: list[str] = []

    def answered(self, answers: Sequence[bool]) -> None:
        """Judge which servos answered in this tick.

        Raises:
            Stopped: a servo is silent for the second tick in a row.
        """
        broken = [rule.broken(not answer) for rule, answer in zip(self._silent, answers, strict=True)]
        silent = [f"{s.id} ({s.joint})" for s, lost in zip(self._arm.servos, broken, strict=True) if lost]
        if silent:
            raise Stopped(
                "comms",
                f"servo {', '.join(silent)} did not answer for {SILENT_TICKS + 1} ticks",
                "check its cable, then run pipenav hw-check",
            )

    def alarmed(self, alarms: Sequence[Alarm]) -> None:
        """Judge the error bytes of this tick's answers.

        Raises:
            Stopped: any alarm but a checksum error; all of a servo's alarms are named.
        """
        for servo, alarm in zip(self._arm.servos, alarms, strict=True):
            reasons = [reason for bit, reason in STATE_ALARMS.items() if alarm & bit]
            if reasons:
                what = " and ".join(reason.what for reason in reasons)
                raise Stopped(reasons[-1].cause, f"servo {servo.id} ({servo.joint}) {what}", reasons[-1].remedy)

    def check(self, states: Sequence[State | None], goals: Floats | None) -> None:
        """Judge what the servos say about themselves.

        Args:
            states: state of every servo; None where unknown.
            goals: their last goals [counts]; None while torque is off.

        Raises:
            Stopped: a servo is too hot; or a wrong voltage or a stall has lasted.
        """
        self.warnings = []
        for i, (servo, state) in enumerate(zip(self._arm.servos, states, strict=True)):
            if state is None:
                continue
            name = f"servo {servo.id} ({servo.joint})"
            if state.temperature >= HOT:
                raise Stopped(
                    "overheat",
                    f"{name} is at {state.temperature} deg C, {HOT} is too hot",
                    "let it cool for 20 minutes",
                )
            volts = state.decivolts / 10
            if self._volts[i].broken(not LEAST_VOLTS <= volts <= MOST_VOLTS):
                limits = f"{LEAST_VOLTS:g} to {MOST_VOLTS:g} V are allowed"
                raise Stopped("voltage", f"{name} gets {volts:.1f} V, {limits}", "check the supply and its cable")
            if volts < WARN_VOLTS:
                self.warnings.append(f"{name}: {volts:.1f} V")
            moved = self._before[i] is None or abs(state.position - self._before[i]) > STALL_MOTION  # type: ignore[operator]
            self._before[i] = state.position
            pushing = abs(state.load) >= STALL_SHARE * servo.torque_counts
            far = goals is not None and abs(goals[i] - state.position) * COUNT > STALL_ERROR
            if self._stalls[i].broken(pushing and far and not moved):
                raise Stopped(
                    "stall",
                    f"{name} pushes with full torque and does not move",
                    "look for what holds it; --retreat backs out along the recorded path",
                )


class SensorRules:
    """Watches the scanner and the front sensor over time."""

    def __init__(self, patience: float = 1.0) -> None:
        self._stale = STALE * patience
        self._blind, self._frozen = Repeats(BAD_SCANS), Repeats(BAD_SCANS - 1)  # the first of them repeats nothing
        self._before: RangeScan | None = None

    def scanned(self, scan: RangeScan, blind: bool) -> None:
        """Judge a new scan.

        Raises:
            Stopped: it is the third in a row that saw nothing, or that is the same as the scan before.
        """
        same = self._before is not None and scan.distances == self._before.distances
        frozen = same and min(scan.distances) < max(scan.distances)  # all alike: too near to measure, which may last
        self._before = scan
        if self._blind.broken(blind):
            raise Stopped(
                "blind", "three scans in a row had no valid point", "clean the scanner's window, check its cable"
            )
        if self._frozen.broken(frozen):
            raise Stopped("frozen", "the scanner sends the same scan again and again", "switch the scanner off and on")

    def aged(self, name: str, age: float) -> None:
        """Judge how old the newest scan or reading is.

        Raises:
            Stopped: it is too old.
        """
        if age > self._stale:
            raise Stopped(
                "stale",
                f"the {name}'s newest reading is {age * 1e3:.0f} ms old, {self._stale * 1e3:.0f} ms are allowed",
                f"check the {name}'s cable and port",
            )
