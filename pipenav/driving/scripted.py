"""Scripted operators: fixed, noisy scripts that drive through the same door as people do.

They see what a person sees on the screen: the robot's own sensors, the pipe's drawing, a target where there is one.
None of them knows where the robot is. They react late, hesitate and press keys too early, all by a seed.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np

from pipenav.arrays import Floats
from pipenav.driving.ask import NOTHING, Ask, Seen
from pipenav.driving.primitives import ROLL
from pipenav.driving.route_steps import order_after
from pipenav.driving.scan_match import ScanMatch
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.centreline_plan import follow_line
from pipenav.policies.baselines.guide_line import guide_line
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec

REACTION = (2, 8)
"""Least and most control steps from when a person sees something to when a key is down: 0.2 to 0.8 s."""

TOO_EARLY = 0.2
"""Share of the episodes in which the front is told to clamp before it is through."""

HESITATION = 0.3
"""Share of the episodes in which a step is broken off in its middle, and begun again a second later."""

TREMOR = 0.15
"""Standard deviation of a hand on a stick, as a share of its travel."""

AHEAD = 0.02
"""Distance along the line by which a person looks ahead of the tip [m]."""

WIDTHS = ((0.5, 0.65, 0.78), (0.3, 0.4, 0.5, 0.65), (0.5, 0.65, 0.8))
"""Ways around a corner to choose from: distances from the inner wall before, at and after it, in diameters."""


STUCK, CAUGHT = 20, 80
"""Control steps in which a robot does not get on, after which a person helps a policy, or takes it back in a step."""

STILL = 0.015
"""Largest distance of a joint's mean position from that of some time before that counts as not getting on [rad or m]:
whoever looks at a robot sees through its wagging and the noise of its sensors."""

HELP = (8, 25)
"""Least and most control steps for which a person helps."""


class Past:
    """Positions of a robot's joints in its last control steps.

    Args:
        steps: number of control steps, even.
    """

    def __init__(self, steps: int) -> None:
        self._steps = steps
        self._positions: list[Floats] = []

    @property
    def full(self) -> bool:
        """Whether there were that many control steps."""
        return len(self._positions) == self._steps

    def still(self, q: Floats) -> bool:
        """Take in the positions now, (joints,); whether the joints were where they are for all the time."""
        self._positions = [*self._positions[1 - self._steps :], q.copy()]
        if not self.full:
            return False
        before, after = np.array(self._positions).reshape(2, self._steps // 2, -1).mean(axis=1)
        return bool(np.abs(after - before).max() < STILL)


class Scripted(ABC):
    """A script for one robot.

    Args:
        robot: the robot.
        seed: seed of all noise; that of an episode depends on it, on the pipe and on the robot's first scan alone.
        rng: source of the noise where the script is part of another one.
    """

    def __init__(self, robot: RobotSpec, seed: int, rng: np.random.Generator | None = None) -> None:
        self._robot, self._seed = robot, seed
        self._rng = rng or np.random.default_rng(seed)

    def ask(self, seen: Seen) -> Ask:
        """The script's wish for the control step that begins now."""
        if seen.tick == 0:
            first = np.concatenate([seen.reading.q[0], seen.reading.ranges[0]])
            self._rng = np.random.default_rng([self._seed, *first.view(np.uint32).tolist()])
            self.begin(seen)
        return self.answer(seen)

    @abstractmethod
    def begin(self, seen: Seen) -> None:
        """Begin an episode."""

    @abstractmethod
    def answer(self, seen: Seen) -> Ask:
        """The script's wish for this control step, after `begin`."""


class StepScript(Scripted):
    """Presses the keys of the steps (a) to (e), each some time after the one before is done.

    Where the robot is caught in a step, it takes the robot back a little, and goes on with the step.
    """

    def begin(self, seen: Seen) -> None:  # noqa: ARG002  # the signature of a script
        self._wait = int(self._rng.integers(*REACTION))
        self._early = self._rng.random() < TOO_EARLY
        self._pause = int(self._rng.integers(15, 60)) if self._rng.random() < HESITATION else -1
        self._paused, self._resumed = 0, ""
        self._in_b, self._past, self._back = 0, Past(CAUGHT), 0.0

    def answer(self, seen: Seen) -> Ask:
        if self._paused:
            self._paused -= 1
            return Ask(active=True, wheels=self._back) if self._paused else Ask(active=True, step=self._resumed)
        if self._wait > 0:
            self._wait -= 1
            return Ask(active=True)
        if not seen.step:
            return self._press("a")
        self._in_b = 0 if seen.step == "a" else self._in_b + (seen.step == "b")
        if seen.step == "b" and self._in_b == self._pause:
            self._paused, self._resumed, self._back = 10, seen.step, 0.0
            return Ask(active=True, quiet=True)
        if self._past.still(seen.reading.q[0]) and seen.step in ("b", "d") and not seen.done:
            self._past = Past(CAUGHT)
            self._paused, self._resumed, self._back = int(self._rng.integers(*HELP)), seen.step, -1.0
            return Ask(active=True, quiet=True)
        if seen.step == "b" and self._early and self._in_b > 20:
            return self._press("c")
        if seen.done:
            return self._press(self._next(seen))
        return Ask(active=True)

    def _next(self, seen: Seen) -> str:
        """The key after a step that is done: a roll where the next corner lies in another plane, and then on."""
        if seen.step == ROLL:
            return "e"
        return ROLL if seen.step == "e" and not seen.in_plane else order_after(seen.step)

    def _press(self, step: str) -> Ask:
        self._wait = int(self._rng.integers(*REACTION))
        return Ask(active=True, step=step)


class TipScript(Scripted):
    """Steers an arm's tip along a line that a person would draw around the corner, to the target."""

    def begin(self, seen: Seen) -> None:
        self._line: Floats | None = None
        self._wait = int(self._rng.integers(*REACTION))
        self._sign, self._base = 1.0, 0.0
        if seen.pipe is None or seen.target is None:
            return
        self._sign = seen.pipe.turn_sign
        left = seen.pipe.model_copy(update={"turn": "left"})
        self._match = ScanMatch(self._robot, left)
        tip = float(kinematics.forward(self._robot, seen.reading.q).tip[0, 0])
        self._base = -left.inner_edge - seen.tip_gap - tip
        self._target = frames.robot_to_canonical(seen.target, self._sign)
        self._left = left
        self._steer = np.zeros(2)

    def answer(self, seen: Seen) -> Ask:
        if seen.pipe is None or seen.target is None:
            return NOTHING
        q = seen.reading.q * np.where(self._sign > 0, 1.0, self._robot.mirror_signs)
        pose = kinematics.forward(self._robot, q)
        heading, tip = float(pose.headings[0, -1]), pose.tip[0]
        ranges = seen.reading.ranges[0] if self._sign > 0 else seen.reading.ranges[0, ::-1]
        self._base += self._match.error(frames.robot_to_pipe(tip, self._base), heading, ranges)
        if self._wait > 0:
            self._wait -= 1
            return Ask(active=True)
        if self._line is None:
            self._line = self._draw()
        self._steer = 0.5 * self._steer + 0.5 * self._towards(frames.robot_to_pipe(tip, self._base), heading)
        along, left = np.clip(self._steer + self._rng.normal(0.0, TREMOR, 2), -1.0, 1.0)
        return Ask(active=True, tip=(max(float(along), 0.05), float(left) * self._sign))

    def _draw(self) -> Floats:
        """The line to the target, in the pipe's frame, (p, 2) [m]."""
        target = frames.robot_to_pipe(self._target, self._base)
        return _dense_line(self._robot, self._left, self._base, target)

    def _towards(self, tip: Floats, heading: float) -> Floats:
        """Stick towards the point of the line a little ahead of the tip: along its heading and to its left, (2,)."""
        assert self._line is not None
        nearest = int(np.hypot(*(self._line - tip).T).argmin())
        rest = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self._line[nearest:], axis=0).T))])
        point = self._line[nearest + min(int(np.searchsorted(rest, AHEAD)), len(rest) - 1)]
        away = point - tip
        away = away / max(float(np.hypot(*away)), 1e-6)
        cos, sin = math.cos(heading), math.sin(heading)
        return np.array([cos * away[0] + sin * away[1], cos * away[1] - sin * away[0]])


def _dense_line(robot: RobotSpec, pipe: PipeCorner, base: float, target: Floats) -> Floats:
    """The line around a left turn on which an arm has most room, its points close together, (p, 2) [m]."""
    best = tuple(choices[len(choices) // 2] for choices in WIDTHS)
    for i in range(len(WIDTHS)):
        lines = [(*best[:i], width, *best[i + 1 :]) for width in WIDTHS[i]]
        best = max(lines, key=lambda line: follow_line(robot, pipe, base, target, line).score)
    points = guide_line(pipe, target, best).points
    distance = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    along = np.arange(0.0, distance[-1], 0.002)
    return np.stack([np.interp(along, distance, column) for column in points.T], axis=1)


class HelpScript(Scripted):
    """Watches a policy, and helps where the robot does not get on: it takes the robot back a little and hands it back.

    Where that was not enough it steers an arm's tip on, every other time, if it knows the way.
    """

    def begin(self, seen: Seen) -> None:
        self._past = Past(STUCK)
        self._left = self._helps = 0
        self._way = None if self._robot.free else TipScript(self._robot, self._seed, self._rng)
        if self._way is not None:
            self._way.begin(seen)

    def answer(self, seen: Seen) -> Ask:
        if self._left > 0:
            self._left -= 1
            self._past = Past(STUCK)
            if self._helps % 2 == 0 and self._way is not None and seen.target is not None:
                return self._way.answer(seen)
            strength = -float(np.clip(1.0 + self._rng.normal(0.0, TREMOR), 0.3, 1.0))
            return Ask(active=True, wheels=strength) if self._robot.free else Ask(active=True, tip=(strength, 0.0))
        still = self._past.still(seen.reading.q[0])
        if self._past.full and self._rng.random() < 0.3 and still:
            self._left, self._helps = int(self._rng.integers(*HELP)), self._helps + 1
        return NOTHING


def script_for(robot: RobotSpec, seed: int, shared: bool) -> Scripted:
    """The script that drives a robot: alone, or beside a policy."""
    if shared:
        return HelpScript(robot, seed)
    return StepScript(robot, seed) if robot.free else TipScript(robot, seed)
