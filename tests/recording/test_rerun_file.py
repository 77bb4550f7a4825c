"""Recordings for the Rerun viewer, read back by its SDK: every pose, beam and number is that of the motion."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipenav.deployment.telemetry import read_telemetry
from pipenav.errors import PipenavError
from pipenav.motions.trajectory import Trajectory
from pipenav.pipes import parse_pipes
from pipenav.pipes.route import as_route
from pipenav.recording.posed_motion import PosedMotion, posed_in_space, posed_trajectory
from pipenav.recording.posed_telemetry import posed_telemetry, robot_of
from pipenav.recording.record_rolling import SpaceRecording
from pipenav.recording.rerun_file import PAUSE, write_rerun
from pipenav.robots.outline import link_outlines
from pipenav.robots.robot import load_robot

MISSION = Path(__file__).parents[1] / "data" / "0.1" / "mission" / "telemetry.jsonl"


def read_back(path: Path) -> dict[str, dict[str, Any]]:
    """Columns of every entity, by its path; times in seconds under `time`."""
    chunk = pytest.importorskip("rerun.chunk")
    found: dict[str, dict[str, Any]] = {}
    for part in chunk.RrdReader(path).stream().to_chunks():
        batch = part.to_record_batch()
        columns = found.setdefault(str(part.entity_path), {})
        for name in batch.schema.names[1:]:
            if name == "time":
                columns["time"] = batch.column(name).cast("int64").to_numpy() / 1e9
            elif name != "log_time":
                columns[name.partition(":")[2]] = batch.column(name).to_pylist()
    return found


def written(path: Path, *motions: PosedMotion) -> dict[str, dict[str, Any]]:
    pytest.importorskip("rerun")
    write_rerun(path, motions)
    return read_back(path)


def rolled() -> SpaceRecording:
    """A whole robot that lies straight in the first leg of a route, its front half turned."""
    robot, route = load_robot("pirate"), as_route(parse_pipes(["runs-rolled:1"])[0])
    along = np.concatenate([[0.0], np.cumsum([link.length for link in robot.links])])
    points = np.zeros((4, len(along), 3))
    points[..., 0] = along - 1.5 + 0.01 * np.arange(4)[:, None]
    normals = np.tile([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]], (4, 1, 1))
    doing = ("roll", "roll", "drive", "drive")
    return SpaceRecording(route, robot, "pirate", "mujoco", "reached", points, normals, np.arange(4.0), doing)


def check_robot(motion: PosedMotion, entities: dict[str, dict[str, Any]], before: str = "/") -> None:
    for i, link in enumerate(motion.robot.links):
        pose = entities[f"{before}robot/{link.name}"]
        places = np.array(pose["translation"]).reshape(-1, 3)
        turns = np.array(pose["mat3x3"]).reshape(-1, 3, 3).swapaxes(1, 2)  # Rerun stores columns one after the other
        np.testing.assert_allclose(places, motion.start[:, i], atol=1e-6)
        np.testing.assert_allclose(turns, motion.axes[:, i], atol=1e-6)
        (half,) = entities[f"{before}robot/{link.name}/shape"]["half_sizes"]
        np.testing.assert_allclose(2 * np.array(half[0]), [link.length, link.width, link.height], rtol=1e-6)
        assert (f"{before}robot/{link.name}/wheel" in entities) == (link.wheel is not None)
    np.testing.assert_allclose(np.array(entities[f"{before}robot_tip"]["positions"])[:, 0], motion.tip, atol=1e-6)
    np.testing.assert_allclose(
        np.array(motion.axes) @ np.array(motion.axes).swapaxes(-1, -2),
        np.broadcast_to(np.eye(3), motion.axes.shape),
        atol=1e-9,
    )
    strips = entities[f"{before}pipe/walls"]["strips"][0] if motion.walls else []
    assert len(strips) == len(motion.walls)
    for strip, wall in zip(strips, motion.walls, strict=True):
        np.testing.assert_allclose(strip, wall, atol=1e-6)


def check_series(
    motion: PosedMotion, entities: dict[str, dict[str, Any]], before: str = "/", begin: float = 0.0
) -> None:
    for name, values in motion.series.items():
        known = np.isfinite(values)
        if not known.any():
            assert before + name not in entities
            continue
        columns = entities[before + name]
        np.testing.assert_allclose(columns["time"], motion.time[known] - motion.time[0] + begin, atol=1e-9)
        np.testing.assert_array_equal(np.array(columns["scalars"])[:, 0], values[known])
    assert [text for (text,) in entities[before + "events"]["text"]] == [text for _, text in motion.events]


def test_a_motion_in_the_plane_comes_back(front: Trajectory, tmp_path: Path) -> None:
    motion = posed_trajectory(front)
    entities = written(tmp_path / "a.rrd", motion)
    check_robot(motion, entities)
    check_series(motion, entities)
    assert motion.beams is not None and front.header.goal_m is not None
    for row, hits in enumerate(entities["/laser"]["positions"]):
        shown = np.array(hits or []).reshape(-1, 3)
        np.testing.assert_allclose(shown, motion.beams.ends[row][motion.beams.met[row]], atol=1e-6)
    np.testing.assert_allclose(entities["/pipe/target"]["positions"][0][0], [*front.header.goal_m, 0.0], atol=1e-6)
    assert entities["/succeeded"]["scalars"] == [[1.0]]


def test_links_are_where_pictures_have_them(front: Trajectory) -> None:
    motion = posed_trajectory(front)
    for i, (link, outlines) in enumerate(zip(front.robot.links, link_outlines(front.robot, front.q), strict=True)):
        middle = motion.start[:, i] + motion.axes[:, i, :, 0] * link.length / 2
        box = np.asarray(outlines[0]).mean(axis=1) + np.array([front.header.base_m, 0.0])
        np.testing.assert_allclose(middle[:, :2], box, atol=1e-9)
        np.testing.assert_allclose(middle[:, 2], 0.0)


def test_motions_follow_each_other(front: Trajectory, tmp_path: Path) -> None:
    motion = posed_trajectory(front)
    entities = written(tmp_path / "a.rrd", motion, replace(motion, target=None))
    second = float(motion.time[-1] - motion.time[0]) + PAUSE
    for before, begin in (("/motion_1/", 0.0), ("/motion_2/", second)):
        check_robot(motion, entities, before)
        check_series(motion, entities, before, begin)
    assert "/motion_1/pipe/target" in entities and "/motion_2/pipe/target" not in entities


def test_a_motion_in_space_comes_back(tmp_path: Path) -> None:
    motion = posed_in_space(rolled())
    entities = written(tmp_path / "a.rrd", motion)
    check_robot(motion, entities)
    check_series(motion, entities)
    assert [text for _, text in motion.events] == ["roll", "drive", "reached"]
    np.testing.assert_allclose(motion.axes[:, 0, :, 2], [[0, 0, 1]] * 4)
    np.testing.assert_allclose(motion.axes[:, -1, :, 2], [[0, 1, 0]] * 4)


def test_a_mission_comes_back(tmp_path: Path) -> None:
    recording = read_telemetry(MISSION)
    robot = robot_of(MISSION, recording.header)
    assert robot is not None
    motion = posed_telemetry(recording, robot)
    assert motion is not None and len(motion.time) == len([tick for tick in recording.ticks if "q" in tick])
    entities = written(tmp_path / "a.rrd", motion)
    check_robot(motion, entities)
    check_series(motion, entities)
    assert motion.series["celsius/theta1"].min() >= 20
    assert motion.events[-1][1] == "passed"


def test_another_suffix_and_a_missing_library_are_refused_in_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(PipenavError, match=r"x\.png: a recording for Rerun needs a name ending in \.rrd\."):
        write_rerun(tmp_path / "x.png", [])
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(PipenavError, match=r"needs the extra 'rerun': pip install 'pipenav\[rerun\]'\."):
        write_rerun(tmp_path / "x.rrd", [])
    assert not list(tmp_path.iterdir())
