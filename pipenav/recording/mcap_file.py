"""Telemetry as an MCAP file for Foxglove: a topic with its schema for each part of a tick, and the robot as a scene."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from pipenav.deployment.telemetry import Recording
from pipenav.deployment.ticks import servo_health, tick_seconds
from pipenav.errors import PipenavError
from pipenav.recording.mcap_scene import scene_updates
from pipenav.recording.mcap_schemas import END, JOINTS, OTHER, SCENE, SERVOS, TICK_TOPICS, Schema, Topic
from pipenav.recording.posed_motion import PosedMotion
from pipenav.robots.robot import RobotSpec
from pipenav.storage.atomic_files import atomic_write

INSTALL = "pip install 'pipenav[mcap]'"
"""Advice where the library is missing."""

SUFFIX = ".mcap"

HEADER = "telemetry"
"""Name of the metadata record that holds the telemetry's first line, as JSON under the key `header`."""


class Message(NamedTuple):
    """A message of an MCAP file.

    Attributes:
        topic: its topic.
        schema_name: name of its schema.
        schema: its schema.
        seconds: its time since the start [s].
        content: the message itself, as JSON can hold it.
    """

    topic: str
    schema_name: str
    schema: Schema
    seconds: float
    content: dict[str, Any]


def write_mcap(path: Path, recording: Recording, robot: RobotSpec | None, motion: PosedMotion | None) -> None:
    """Write a telemetry as an MCAP file.

    Args:
        path: the file, .mcap.
        recording: the telemetry.
        robot: its robot; None where it is not known: joints have no names then.
        motion: its motion, for the scene; None where it is not known.

    Raises:
        PipenavError: mcap is not installed, or the suffix is another one.
        FileProblem: the file cannot be written.
    """
    check_mcap(path)
    atomic_write(path, lambda draft: _write(draft, recording, robot, motion))


def check_mcap(path: Path) -> None:
    """Refuse a file of another suffix, and any where mcap is missing.

    Raises:
        PipenavError: one of the two.
    """
    if path.suffix.lower() != SUFFIX:
        raise PipenavError(f"{path}: a recording for Foxglove needs a name ending in {SUFFIX}.")
    _writer_class()


def _writer_class() -> Any:
    """The class of the extra `mcap` that writes files."""
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise PipenavError(f"a recording for Foxglove needs the extra 'mcap': {INSTALL}.") from error
    return Writer


def _write(draft: Path, recording: Recording, robot: RobotSpec | None, motion: PosedMotion | None) -> None:
    start = _started(recording.header)
    with draft.open("wb") as file:
        writer = _writer_class()(file)
        writer.start(library="pipenav")
        writer.add_metadata(HEADER, {"header": json.dumps(recording.header)})
        channels: dict[str, int] = {}
        for number, message in enumerate(_messages(recording, robot, motion)):
            if message.topic not in channels:
                schema = writer.register_schema(
                    message.schema_name, "jsonschema", json.dumps(message.schema).encode("utf-8")
                )
                channels[message.topic] = writer.register_channel(message.topic, "json", schema)
            time = start + round(message.seconds * 1e9)
            content = json.dumps(message.content).encode("utf-8")
            writer.add_message(channels[message.topic], time, content, time, number)
        writer.finish()


def _started(header: Mapping[str, Any]) -> int:
    """Nanoseconds since 1970 at which the telemetry began; 0 where it does not say."""
    try:
        started = datetime.fromisoformat(header["started"])
    except (KeyError, TypeError, ValueError):
        return 0
    return max(round(started.replace(tzinfo=started.tzinfo or UTC).timestamp()), 0) * 10**9


def _messages(recording: Recording, robot: RobotSpec | None, motion: PosedMotion | None) -> Iterator[Message]:
    """All messages in order of their time."""
    servos = None if robot is None else servo_health(recording.header, robot)
    scenes = iter(()) if motion is None else scene_updates(motion, _started(recording.header))
    pending, seconds = next(scenes, None), 0.0
    for tick in recording.ticks:
        seconds = max(tick_seconds(tick), seconds)
        while pending is not None and pending[0] <= seconds:
            yield Message("/scene", "foxglove.SceneUpdate", SCENE, *pending)
            pending = next(scenes, None)
        yield from _parts(tick, seconds)
        if robot is not None and servos is not None:
            yield from _named(tick, robot, servos(tick["raw"]), seconds)
    if recording.end is not None:
        yield Message("/end", "pipenav.End", END, seconds, recording.end)


def _parts(tick: Mapping[str, Any], seconds: float) -> Iterator[Message]:
    """A tick's keys, each in the topic that it belongs to; every message has the tick's number."""
    known = {"tick"}
    for topic in TICK_TOPICS:
        known |= set(topic.keys)
        yield from _part(topic, {key: tick[key] for key in topic.keys if key in tick}, tick["tick"], seconds)
    yield from _part(OTHER, {key: value for key, value in tick.items() if key not in known}, tick["tick"], seconds)


def _part(topic: Topic, content: dict[str, Any], tick: int, seconds: float) -> Iterator[Message]:
    if content:
        fields = {"tick": {"type": "integer"}, **topic.schema["properties"]}
        schema = {**topic.schema, "properties": fields}
        yield Message(topic.name, topic.schema_name, schema, seconds, {"tick": tick, **content})


def _named(tick: Mapping[str, Any], robot: RobotSpec, servos: Any, seconds: float) -> Iterator[Message]:
    """Joints and servos by name, which curves are easily drawn of."""
    names, free = [joint.name for joint in robot.joints], robot.coordinates - len(robot.joints)
    columns = {"position": tick.get("q"), "speed": tick.get("qd"), "set_point": tick.get("sent") or tick.get("command")}
    joints: dict[str, dict[str, float]] = {name: {} for name in names}
    for key, values in columns.items():
        own = values[free:] if values and len(values) == robot.coordinates else values or []
        for name, value in zip(names, own, strict=False):
            joints[name][key] = value
    if any(joints.values()):
        yield Message("/joints", "pipenav.Joints", JOINTS, seconds, joints)
    if any(servo is not None for servo in servos):
        known = {name: servo._asdict() for name, servo in zip(names, servos, strict=True) if servo is not None}
        yield Message("/servos", "pipenav.Servos", SERVOS, seconds, known)
