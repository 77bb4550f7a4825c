"""Telemetry as MCAP, read back by its own reader: every value of every tick, and schemas that messages keep."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.deployment.telemetry import Recording, read_telemetry
from pipenav.errors import PipenavError
from pipenav.recording.mcap_file import HEADER, write_mcap
from pipenav.recording.mcap_schemas import OTHER, TICK_TOPICS
from pipenav.recording.posed_telemetry import posed_telemetry, robot_of
from pipenav.robots.robot import load_robot

MISSION = Path(__file__).parents[1] / "data" / "0.1" / "mission" / "telemetry.jsonl"
PARTS = {topic.name for topic in (*TICK_TOPICS, OTHER)}

pytest.importorskip("mcap")


class ReadBack:
    """The contents of an MCAP file, by its own reader."""

    def __init__(self, path: Path) -> None:
        from mcap.reader import make_reader

        self.messages: dict[str, list[tuple[int, Any]]] = {}
        self.schemas: dict[str, dict[str, Any]] = {}
        with path.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            (metadata,) = reader.iter_metadata()
            assert metadata.name == HEADER
            self.header = json.loads(metadata.metadata["header"])
            for schema, channel, message in reader.iter_messages():
                assert schema is not None
                assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
                self.schemas[channel.topic] = json.loads(schema.data)
                self.messages.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))

    @property
    def recording(self) -> Recording:
        """The telemetry, put together again from the parts of its ticks."""
        ticks: dict[int, dict[str, Any]] = {}
        for topic in PARTS & self.messages.keys():
            for _, content in self.messages[topic]:
                ticks.setdefault(content["tick"], {}).update(content)
        ends = [content for _, content in self.messages.get("/end", [])]
        return Recording(self.header, [ticks[number] for number in sorted(ticks)], ends[0] if ends else None)


def keeps(content: Any, schema: dict[str, Any]) -> bool:
    """Whether a value keeps a schema, as far as the schemas here go."""
    if "anyOf" in schema:
        return any(keeps(content, one) for one in schema["anyOf"])
    kinds = {"number": (int, float), "integer": int, "string": str, "boolean": bool, "null": type(None)}
    if schema["type"] == "object":
        fields, more = schema.get("properties", {}), schema.get("additionalProperties")
        return isinstance(content, dict) and all(
            keeps(value, fields[key]) if key in fields else more is None or keeps(value, more)
            for key, value in content.items()
        )
    if schema["type"] == "array":
        return isinstance(content, list) and all(keeps(one, schema["items"]) for one in content)
    return isinstance(content, kinds[schema["type"]]) and (schema["type"] == "boolean") == isinstance(content, bool)


@pytest.fixture(scope="module")
def mission() -> Recording:
    return read_telemetry(MISSION)


@pytest.fixture(scope="module")
def back(mission: Recording, tmp_path_factory: pytest.TempPathFactory) -> ReadBack:
    path, robot = tmp_path_factory.mktemp("mcap") / "m.mcap", robot_of(MISSION, mission.header)
    assert robot is not None
    write_mcap(path, mission, robot, posed_telemetry(mission, robot))
    return ReadBack(path)


def test_every_value_of_a_mission_comes_back(mission: Recording, back: ReadBack) -> None:
    assert back.recording == mission


def test_messages_keep_their_schemas(back: ReadBack) -> None:
    assert {"/reading", "/decision", "/command", "/timing", "/raw", "/joints", "/servos", "/scene", "/end"} <= set(
        back.messages
    )
    for topic, messages in back.messages.items():
        assert messages and all(keeps(content, back.schemas[topic]) for _, content in messages), topic


def test_times_are_those_of_the_ticks(mission: Recording, back: ReadBack) -> None:
    times = [time for time, _ in back.messages["/reading"]]
    known = [tick["time"] for tick in mission.ticks if "time" in tick]
    np.testing.assert_allclose(np.diff(times) / 1e9, np.diff(known), atol=2e-9)
    assert times[0] // 10**9 // 86_400 == 1_795_737_600 // 86_400, "the day on which it started"


def test_the_scene_has_every_link_where_it_was(mission: Recording, back: ReadBack) -> None:
    robot = robot_of(MISSION, mission.header)
    assert robot is not None
    motion = posed_telemetry(mission, robot)
    assert motion is not None
    scenes = [content for _, content in back.messages["/scene"]]
    assert len(scenes) == len(motion.time)
    for row, scene in enumerate(scenes):
        cubes = next(entity["cubes"] for entity in scene["entities"] if entity["id"] == "robot")
        for i, (cube, link) in enumerate(zip(cubes, robot.links, strict=True)):
            middle = motion.start[row, i] + motion.axes[row, i, :, 0] * link.length / 2
            np.testing.assert_allclose(list(cube["pose"]["position"].values()), middle, atol=1e-12)
            assert list(cube["size"].values()) == [link.length, link.width, link.height]


def test_named_joints_and_servos_are_those_of_the_arrays(mission: Recording, back: ReadBack) -> None:
    robot = load_robot("real-setup")
    for (_, joints), tick in zip(back.messages["/joints"], mission.ticks, strict=False):
        assert [joints[joint.name]["position"] for joint in robot.joints] == tick["q"]
    assert all(20 <= servo["celsius"] <= 80 for _, one in back.messages["/servos"] for servo in one.values())


finite = st.floats(allow_nan=False, allow_infinity=False)
values = st.recursive(
    st.none() | st.booleans() | finite | st.text(), lambda v: st.lists(v) | st.dictionaries(st.text(), v)
)
ticks = st.fixed_dictionaries(
    {"raw": st.dictionaries(st.text(), values)},
    optional={
        "q": st.lists(finite),
        "time": finite.filter(lambda t: abs(t) < 1e6),
        "stage": st.text(),
        "strange": values,
        "seconds": st.dictionaries(st.text(), finite),
    },
)


@given(rows=st.lists(ticks, max_size=4), header=st.dictionaries(st.text(), values), ended=st.booleans())
@settings(deadline=None)
def test_whatever_a_telemetry_holds_comes_back(
    tmp_path_factory: pytest.TempPathFactory, rows: list[dict[str, Any]], header: dict[str, Any], ended: bool
) -> None:
    numbered = [{"tick": number, **row, "raw": {**row["raw"], "time": None}} for number, row in enumerate(rows)]
    end = {"end": "passed", "cause": None, "message": ""} if ended else None
    recording = Recording(header, numbered, end)
    path = tmp_path_factory.mktemp("mcap") / "x.mcap"
    write_mcap(path, recording, None, None)
    assert ReadBack(path).recording == recording


def test_another_suffix_and_a_missing_library_are_refused_in_a_sentence(
    mission: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(PipenavError, match=r"x\.bag: a recording for Foxglove needs a name ending in \.mcap\."):
        write_mcap(tmp_path / "x.bag", mission, None, None)
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    with pytest.raises(PipenavError, match=r"needs the extra 'mcap': pip install 'pipenav\[mcap\]'\."):
        write_mcap(tmp_path / "x.mcap", mission, None, None)
    assert not list(tmp_path.iterdir())
