"""A mission of the arm, as the thesis draws it in figure 5.22: locate a target, reach it by the policy, back out."""

from __future__ import annotations

from typing import Any

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading
from pipenav.deployment.stages import Back, Decision, Locate, Reach
from pipenav.locating.locator import Exit, LocateConfig
from pipenav.pipes.pipe import Turn
from pipenav.policies.policy import Policy


class Mission:
    """A mission: its stages one after another.

    Attributes:
        exit_: the exit that the arm takes.
        target: target in the robot's own frame, (2,) [m]; None before one is known.
        outcome: empty while the mission goes on; `passed` where the arm reached the target and came back.
    """

    def __init__(
        self,
        policy: Policy,
        exit_: Exit,
        period: float,
        target: Floats | None,
        locate: LocateConfig,
        retreat: bool,
    ) -> None:
        """
        Args:
            policy: the policy that reaches the target.
            exit_: the exit that the arm takes.
            period: length of a tick [s].
            target: target in the robot's own frame, (2,) [m]; None to look for one.
            locate: how to look for it.
            retreat: whether to back out as well when the target was not found or not reached.
        """
        self.exit_ = exit_
        self._policy, self._turn_sign, self._period = policy, exit_.turn_sign, period
        self._robot, self._retreat = policy.header.robot, retreat
        self._path: list[Floats] = []
        self._detour: list[Floats] = []  # way that someone else has taken the arm while it looked or went back
        self._undo: Back | None = None
        self.target, self.outcome, self._failure = target, "", ""
        self._stage: Locate | Reach | Back | None = Locate(self._robot, locate, exit_)
        if target is not None:
            self._stage = Reach(policy, self._turn_sign, target)

    def decide(self, reading: Reading) -> Decision:
        """Decide what to do after a reading."""
        if self._detour:
            self._undo, self._detour = Back(self._robot, self._detour, self._period), []
        if self._undo is not None:
            undone = self._undo.decide(reading)
            if isinstance(undone, Decision):
                return undone
            self._undo = None
            if undone != "home":
                self._stage, self.outcome = None, undone
        if not isinstance(self._stage, Back):
            self._path.append(reading.q[0].copy())
        while self._stage is not None:
            made = self._stage.decide(reading)
            if isinstance(made, Decision):
                return made
            self._finish(made)
        return Decision(self.outcome, None)

    def watch(self, reading: Reading, told: Floats) -> None:
        """Take in a tick in which someone else drove.

        While the arm reaches, the way that it was taken belongs to the path along which it backs out later. While it
        looks for a target or goes back, it returns along that way first, and then goes on where it was.

        Args:
            reading: readings of the sensors, rows of one.
            told: set-points that were sent, (joints,) [rad or m].
        """
        q = reading.q[0].copy()
        if isinstance(self._stage, Reach):
            self._path.append(q)
            self._stage.watch(reading, told)
            return
        if self._undo is not None:
            self._detour, self._undo = self._undo.left, None
        self._detour.append(q)

    def back_out(self, why: str) -> bool:
        """Leave the present stage and back out; False where that is not wanted or already under way."""
        if not self._retreat or isinstance(self._stage, Back) or not self._path:
            return False
        self._failure = why
        self._stage = Back(self._robot, self._path, self._period)
        return True

    def _finish(self, ended: str) -> None:
        """Go on to the next stage, or end."""
        if isinstance(self._stage, Back):
            self._stage = None
            self.outcome = ended if ended != "home" else self._failure or "passed"
        elif isinstance(self._stage, Locate) and self._stage.target is not None:
            self.target = self._stage.target
            self._path = self._path[-1:]  # it is back where it started: what it did to look need not be undone
            self._stage = Reach(self._policy, self._turn_sign, self.target)
        elif ended == "reached":
            self._stage = Back(self._robot, self._path, self._period)
        elif not self.back_out(ended):
            self._stage, self.outcome = None, ended


def mission_settings(exit_: Exit, target: Floats | None, retreat: bool) -> dict[str, Any]:
    """The settings of a mission, as a telemetry's header holds them and `mission_of` takes them.

    Args:
        exit_: the exit that the arm takes.
        target: target in the robot's own frame, (2,) [m]; None to look for one.
        retreat: whether to back out when it is not found or not reached.
    """
    return {
        "side": exit_.turn_sign,
        "tee": exit_.tee,
        "straight_on": exit_.straight,
        "bend": exit_.bend,
        "period_s": CONTROL_PERIOD,
        "goal_m": None if target is None else [float(x) for x in target],
        "locate": LocateConfig().model_dump(),
        "retreat": retreat,
    }


def mission_of(policy: Policy, settings: dict[str, Any]) -> Mission:
    """The mission that `mission_settings` describes."""
    target = None if settings["goal_m"] is None else np.array(settings["goal_m"], float)
    locate = LocateConfig.model_validate(settings["locate"])
    turn: Turn = "left" if settings["side"] > 0 else "right"
    # Missions of before know no tees and no bends.
    exit_ = Exit(turn, *(bool(settings.get(key)) for key in ("tee", "straight_on", "bend")))
    return Mission(policy, exit_, settings["period_s"], target, locate, settings["retreat"])
