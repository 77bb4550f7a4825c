"""A person's hands on controls: which actions are held and tapped, and what is asked for by them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pipenav.driving.ask import Ask
from pipenav.driving.mapping import TAPS

STEP = "step-"
"""Begin of the names of actions that begin a step."""

TIP = {"tip-forward": (1.0, 0.0), "tip-back": (-1.0, 0.0), "tip-left": (0.0, 1.0), "tip-right": (0.0, -1.0)}
"""Directions of held keys that steer a tip: along its heading and to its left."""

STILL = 0.05
"""Share of a stick's travel within which it counts as let go."""


class Hands:
    """Makes an `Ask` of actions.

    A step or a primitive goes on without a key, and with it the person drives; `hand-back` gives the robot back.
    """

    def __init__(self) -> None:
        self._engaged = False

    def ask(self, held: Mapping[str, float], tapped: Iterable[str], positions: Mapping[str, float]) -> Ask:
        """The wish that the hands express.

        Args:
            held: share of the fastest, in [-1, 1], of each action that goes on: a held key has 1.
            tapped: actions that were tapped since the last time.
            positions: position that a fader asks of a joint, by its name [rad or m].
        """
        known = [action for action in tapped if action in TAPS]
        begun = [action.removeprefix(STEP) for action in known if action not in ("halt", "hand-back", "stop", "end")]
        if begun:
            self._engaged = True
        if "hand-back" in known:
            self._engaged, begun = False, []
        joints: dict[str, float] = {}
        along = left = wheels = 0.0
        steering = False
        for action, share in held.items():
            if action in TIP and abs(share) > STILL:
                along, left = along + TIP[action][0] * share, left + TIP[action][1] * share
                steering = True
            elif action == "tip-along" and abs(share) > STILL:
                along, steering = along + share, True
            elif action in ("wheels", "wheels+", "wheels-"):
                wheels += -share if action.endswith("-") else share
            elif abs(share) > STILL:
                name = action.rstrip("+-")
                joints[name] = joints.get(name, 0.0) + (-share if action.endswith("-") else share)
        wheels = wheels if abs(wheels) > STILL else 0.0
        moving = bool(joints or positions or wheels or steering)
        return Ask(
            active=moving or self._engaged,
            joints={name: share for name, share in joints.items() if share},
            positions=dict(positions),
            wheels=wheels,
            tip=(along, left) if steering else None,
            step=begun[-1] if begun else "",
            quiet="halt" in known,
            stop="stop" in known,
            end="end" in known,
        )
