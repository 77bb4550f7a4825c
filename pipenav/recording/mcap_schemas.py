"""Schemas of the messages in an MCAP file, as JSON Schema: the parts of a tick, and a scene that Foxglove draws.

`foxglove.SceneUpdate` has the fields that https://docs.foxglove.dev/docs/visualization/message-schemas/scene-update
names, as far as they are used.
"""

from __future__ import annotations

from typing import Any, NamedTuple

Schema = dict[str, Any]

TEXT: Schema = {"type": "string"}
NUMBER: Schema = {"type": "number"}


def described(schema: Schema, meaning: str) -> Schema:
    """A schema with its meaning."""
    return {**schema, "description": meaning}


def listed(items: Schema, meaning: str = "") -> Schema:
    """A list."""
    return described({"type": "array", "items": items}, meaning) if meaning else {"type": "array", "items": items}


def optional(schema: Schema) -> Schema:
    """The same, or null."""
    return {"anyOf": [schema, {"type": "null"}]}


def record(title: str, **fields: Schema) -> Schema:
    """An object with these fields, any of which may be missing."""
    return {"title": title, "type": "object", "properties": fields}


def by_joint(title: str, **fields: Schema) -> Schema:
    """An object with a record of these fields for each joint, by its name."""
    return {"title": title, "type": "object", "additionalProperties": record("a joint", **fields)}


class Topic(NamedTuple):
    """A topic that holds a part of every tick.

    Attributes:
        name: its name.
        schema_name: name of its schema.
        schema: its schema, whose fields are keys of a tick.
    """

    name: str
    schema_name: str
    schema: Schema

    @property
    def keys(self) -> list[str]:
        """Keys of a tick that it holds."""
        return list(self.schema["properties"])


TICK_TOPICS = (
    Topic(
        "/reading",
        "pipenav.Reading",
        record(
            "What the robot measured",
            q=listed(NUMBER, "joint positions [rad, m]"),
            qd=listed(NUMBER, "joint speeds [rad/s, m/s]"),
            ranges=listed(NUMBER, "laser readings from right to left [m]"),
            time=described(NUMBER, "time since the start [s]"),
            force=described(NUMBER, "largest contact force, from a simulator [N]"),
            roll=described(NUMBER, "position of the roll joint, in space [rad]"),
            down=listed(listed(NUMBER), "direction downwards in the frame of each half, in space"),
            plane=described(NUMBER, "angle of the robot's plane about its straight, in space [rad]"),
        ),
    ),
    Topic(
        "/decision",
        "pipenav.Decision",
        record(
            "What was decided, and by whom",
            stage=described(TEXT, "locate, reach, back, person, policy, hold, or the outcome"),
            step=described(TEXT, "step or primitive under way, by hand"),
            asked=described({"type": "object"}, "what a person asked for"),
            observation=optional(listed(NUMBER, "what the policy saw")),
            action=optional(listed(NUMBER, "what the policy did, in [-1, 1]")),
            reward=described(NUMBER, "reward of the step"),
            target=optional(listed(NUMBER, "target in the robot's own frame [m]")),
        ),
    ),
    Topic(
        "/command",
        "pipenav.Command",
        record(
            "What was asked of the motors and what was sent",
            command=optional(listed(NUMBER, "set-points that were asked for [rad, m]; then wheels")),
            roll_command=described(NUMBER, "set-point of the roll joint that was asked for, in space [rad]"),
            wheel_speeds=listed(NUMBER, "speeds of the wheels [rad/s]"),
            sent=listed(NUMBER, "set-points that were sent, within all limits [rad, m]"),
            clamped=listed(TEXT, "joints whose set-point was limited"),
            packet=described(TEXT, "bytes that went to the servos, hexadecimal"),
        ),
    ),
    Topic("/timing", "pipenav.Timing", record("Time that parts of the tick took [s]", seconds={"type": "object"})),
    Topic(
        "/events",
        "pipenav.Events",
        record(
            "Warnings and stops",
            warnings=listed(TEXT, "sentences"),
            stopped=described(TEXT, "cause of a stop, in the last tick"),
        ),
    ),
    Topic("/raw", "pipenav.Raw", record("What the devices sent", raw={"type": "object"})),
)
"""Topics that hold a tick's known keys."""

OTHER = Topic("/other", "pipenav.Other", record("Keys that this version does not know"))
"""Topic that holds all other keys of a tick."""

SERVOS = by_joint(
    "How hard the servos work",
    load=described(NUMBER, "signed share of its torque"),
    volts=described(NUMBER, "supply [V]"),
    celsius=described(NUMBER, "temperature [deg C]"),
)

JOINTS = by_joint(
    "Joints by name",
    position=described(NUMBER, "[rad, m]"),
    speed=described(NUMBER, "[rad/s, m/s]"),
    set_point=described(NUMBER, "as it was sent [rad, m]"),
)

END = record("How it ended", end=TEXT, cause=optional(TEXT), message=TEXT)

_VECTOR = record("vector", x=NUMBER, y=NUMBER, z=NUMBER)
_POSE = record("pose", position=_VECTOR, orientation=record("quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER))
_COLOUR = record("colour", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
_TIME = record("time", sec={"type": "integer"}, nsec={"type": "integer"})
_CUBE = record("CubePrimitive", pose=_POSE, size=_VECTOR, color=_COLOUR)
_SPHERE = record("SpherePrimitive", pose=_POSE, size=_VECTOR, color=_COLOUR)
_LINE = record(
    "LinePrimitive",
    type={"type": "integer"},
    pose=_POSE,
    thickness=NUMBER,
    scale_invariant={"type": "boolean"},
    points=listed(_VECTOR),
    color=_COLOUR,
    colors=listed(_COLOUR),
    indices=listed({"type": "integer"}),
)
_ENTITY = record(
    "SceneEntity",
    timestamp=_TIME,
    frame_id=TEXT,
    id=TEXT,
    lifetime=_TIME,
    frame_locked={"type": "boolean"},
    metadata=listed(record("KeyValuePair", key=TEXT, value=TEXT)),
    arrows=listed({"type": "object"}),
    cubes=listed(_CUBE),
    spheres=listed(_SPHERE),
    cylinders=listed({"type": "object"}),
    lines=listed(_LINE),
    triangles=listed({"type": "object"}),
    texts=listed({"type": "object"}),
    models=listed({"type": "object"}),
)
SCENE = record("foxglove.SceneUpdate", deletions=listed({"type": "object"}), entities=listed(_ENTITY))
