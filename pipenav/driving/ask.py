"""Wishes of a person for a control step, and what an operator sees when asked.

A keyboard, a gamepad, faders and a script all answer `Operator.ask`. None of them sees where the robot is.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner

PERSON, POLICY = "person", "policy"
"""Names of those who drive a step, as records hold them."""


class Ask(NamedTuple):
    """Wishes of a person for one control step.

    Attributes:
        active: whether the person drives; where not, the policy does, and without one the robot stays where it is.
        joints: speed of each joint as a share of its fastest, in [-1, 1], by the joint's name.
        positions: position that a fader asks of a joint, by the joint's name [rad or m].
        wheels: speed of all wheels forwards as a share of their fastest, in [-1, 1].
        tip: speed of an arm's tip along its heading and to its left as a share of the fastest, in [-1, 1]; None where
            the tip is not driven.
        step: name of a step or primitive that is to begin; empty where the one before goes on.
        quiet: whether a step that is under way is to end here.
        stop: whether the robot is to be stopped at once: an emergency stop.
        end: whether the person ends the session.
    """

    active: bool = False
    joints: dict[str, float] = {}  # noqa: RUF012  # a NamedTuple's default, which nobody changes
    positions: dict[str, float] = {}  # noqa: RUF012
    wheels: float = 0.0
    tip: tuple[float, float] | None = None
    step: str = ""
    quiet: bool = False
    stop: bool = False
    end: bool = False


NOTHING = Ask()
"""A person who asks for nothing."""


class Seen(NamedTuple):
    """The view of an operator: the robot's own sensors and what the screen says.

    Attributes:
        tick: control step, from 0.
        reading: readings of one robot's sensors, rows of one.
        step: name of the step that is under way; empty where none is.
        done: whether that step is done.
        target: target of the tip in the robot's own frame, (2,) [m]; None where there is none.
        pipe: the corner as it is drawn; None where the pipe is none, or not known.
        tip_gap: distance of the tip before the inner wall's bend at the start, about [m].
        who: who drove the control step before.
        in_plane: whether the robot lies in the plane of the corner that comes next; always, where the pipe lies in one.
    """

    tick: int
    reading: Reading
    step: str = ""
    done: bool = False
    target: Floats | None = None
    pipe: PipeCorner | None = None
    tip_gap: float = 0.0
    who: str = PERSON
    in_plane: bool = True


class Operator(Protocol):
    """Someone who drives one robot."""

    def ask(self, seen: Seen) -> Ask:
        """The wish for the control step that begins now.

        Raises:
            OperatorLost: the device is gone.
        """
        ...


class OperatorLost(PipenavError):
    """A person's device is gone while a robot is driven."""

    def __init__(self, device: str) -> None:
        super().__init__(f"{device} is gone: connect it again, then start again.")
