"""A pipe folder says the same in every one of its formats."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from pipenav.arrays import Floats
from pipenav.export.corner_folder import FILES, read_pipe, write_pipe_folder
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_solids import corner_boxes

TENTH_OF_A_MM = 1e-4
CASES = [
    PipeCorner.of(100, 75),
    PipeCorner.of(70, 30, "right"),
    PipeCorner.of(120, 180),
    PipeCorner.of(100, 90, "left", 150),
    PipeCorner.of(100, 60, "right", 20, wall_mm=5),
]


@pytest.fixture(scope="module", params=CASES, ids=lambda pipe: pipe.name)
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[PipeCorner, Path]:
    return request.param, write_pipe_folder(request.param, tmp_path_factory.mktemp("pipes"))


@pytest.mark.slow
def test_stl_files_are_watertight_and_in_millimetres(made: tuple[PipeCorner, Path]) -> None:
    pipe, folder = made
    for name in ("boards.stl", "tube.stl"):
        body = trimesh.load(folder / name)
        assert body.is_watertight and body.is_winding_consistent and body.volume > 0
        assert body.bounds[0, 0] == pytest.approx(-1000 * pipe.leg, abs=0.01)
    assert np.ptp(trimesh.load(folder / "boards.stl").bounds[:, 2]) == pytest.approx(1000 * pipe.diameter, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["boards.stl", "tube.stl"])
def test_stl_cut_in_the_pipes_plane_shows_its_walls(made: tuple[PipeCorner, Path], name: str) -> None:
    pipe, folder = made
    body = trimesh.load(folder / name)
    cut = trimesh.intersections.mesh_plane(body, [0, 0, 1], [0, 0, 1e-4])
    edges = cut[:, :, :2] / 1000  # (e, 2, 2) [m]
    for origin, direction in rays(pipe, 50):
        hit = origin + distance_to_segments(origin, direction, edges) * direction
        assert distance_to_point(hit, pipe.segments) < TENTH_OF_A_MM


@pytest.mark.slow
def test_tube_has_its_diameters_all_around(made: tuple[PipeCorner, Path]) -> None:
    pipe, folder = made
    body = trimesh.load(folder / "tube.stl")
    x = -1000 * (pipe.leg - 0.02 * pipe.diameter)
    cut = trimesh.intersections.mesh_plane(body, [1, 0, 0], [x, 0, 0])
    first_leg = cut[np.abs(cut[:, :, 1]).max(axis=1) < 1000 * (pipe.radius + pipe.wall) + 1]
    radii = np.linalg.norm(first_leg.mean(axis=1)[:, 1:], axis=1) / 1000
    inner, outer = radii[radii < pipe.radius + pipe.wall / 2], radii[radii > pipe.radius + pipe.wall / 2]
    assert len(inner) > 30 and len(outer) > 30
    assert np.abs(inner - pipe.radius).max() < TENTH_OF_A_MM
    assert np.abs(outer - pipe.radius - pipe.wall).max() < TENTH_OF_A_MM


def rays(pipe: PipeCorner, count: int) -> list[tuple[Floats, Floats]]:
    """Rays from the centre line, in all directions, that meet a wall well within the legs."""
    rng = np.random.default_rng(1)
    line = pipe.line(0.0)
    chosen: list[tuple[Floats, Floats]] = []
    while len(chosen) < count:
        i = rng.integers(0, len(line) - 1)
        origin = line[i] + rng.uniform(0.05, 0.95) * (line[i + 1] - line[i])
        heading = rng.uniform(-math.pi, math.pi)
        direction = np.array([math.cos(heading), math.sin(heading)])
        if distance_to_segments(origin, direction, pipe.segments) < math.inf:
            chosen.append((origin, direction))
    return chosen


def all_hits(origin: Floats, direction: Floats, segments: Floats) -> Floats:
    """Distances along a ray to the segments (s, 2, 2) that it crosses."""
    start, step = segments[:, 0] - origin, segments[:, 1] - segments[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = direction[0] * step[:, 1] - direction[1] * step[:, 0]
        along = (start[:, 0] * step[:, 1] - start[:, 1] * step[:, 0]) / cross
        share = (start[:, 0] * direction[1] - start[:, 1] * direction[0]) / cross
    return along[(share >= 0) & (share < 1) & (along > 0)]


def distance_to_segments(origin: Floats, direction: Floats, segments: Floats) -> float:
    return float(min(all_hits(origin, direction, segments), default=math.inf))


def distance_to_point(point: Floats, segments: Floats) -> float:
    start, step = segments[:, 0], segments[:, 1] - segments[:, 0]
    share = np.clip(np.sum((point - start) * step, axis=1) / np.sum(step**2, axis=1), 0, 1)
    return float(np.linalg.norm(start + share[:, None] * step - point, axis=1).min())


def test_mujoco_sees_the_same_walls(made: tuple[PipeCorner, Path]) -> None:
    pipe, folder = made
    model = mujoco.MjModel.from_xml_path(str(folder / "pipe.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert model.nv == 0 and (model.geom_type == int(mujoco.mjtGeom.mjGEOM_BOX)).all()
    for origin, direction in rays(pipe, 200):
        hit = np.zeros(1, np.int32)
        seen = mujoco.mj_ray(model, data, np.append(origin, 0.0), np.append(direction, 0.0), None, 1, -1, hit, None)
        expected = distance_to_segments(origin, direction, pipe.segments)
        assert seen == pytest.approx(expected, abs=TENTH_OF_A_MM)


def test_bullet_sees_the_same_walls(made: tuple[PipeCorner, Path]) -> None:
    """Bullet's rays are exact on long faces; by a box's edges and in bends they err by a millimetre or so."""
    bullet = pytest.importorskip("pybullet")
    pipe, folder = made
    sent = rays(pipe, 300)
    expected = np.array([distance_to_segments(*ray, pipe.segments) for ray in sent])
    ends = np.array([origin + 1.5 * far * direction for (origin, direction), far in zip(sent, expected, strict=True)])
    client = bullet.connect(bullet.DIRECT)
    try:
        body = bullet.loadURDF(str(folder / "pipe.urdf"), physicsClientId=client)
        assert bullet.getDynamicsInfo(body, -1, physicsClientId=client)[0] == 0  # without mass: it stays
        starts = [[*origin, 0.0] for origin, _ in sent]
        hits = bullet.rayTestBatch(starts, [[*end, 0.0] for end in ends], physicsClientId=client)
    finally:
        bullet.disconnect(client)
    seen = np.array([hit[2] for hit in hits]) * 1.5 * expected
    joints = pipe.segments.reshape(-1, 2)
    clear = 0
    for (origin, direction), far, distance in zip(sent, expected, seen, strict=True):
        assert distance_to_point(origin + distance * direction, pipe.segments) < 1.6e-3
        path = np.array([[origin, origin + far * direction]])
        if not pipe.bend_radius and min(distance_to_point(joint, path) for joint in joints) > 5e-3:
            assert distance == pytest.approx(far, abs=TENTH_OF_A_MM)
            clear += 1
    assert pipe.bend_radius or clear > 200


SDF_CHILDREN = {  # in the order of SDFormat's description files; * marks what must be there
    "sdf": ["model*"],
    "model": ["static", "pose", "link*"],
    "link": ["pose", "inertial", "collision", "visual"],
    "collision": ["pose", "geometry*"],
    "visual": ["pose", "material", "geometry*"],
    "material": ["ambient", "diffuse"],
    "geometry": ["box*"],
    "box": ["size*"],
}
SDF_ATTRIBUTES = {"sdf": {"version"}, **{tag: {"name"} for tag in ("model", "link", "collision", "visual")}}


def test_sdf_keeps_the_rules_of_its_schema(made: tuple[PipeCorner, Path]) -> None:
    pipe, folder = made
    root = ET.parse(folder / "pipe.sdf").getroot()
    assert root.tag == "sdf" and root.get("version") == "1.7" and root.findtext("model/static") == "true"
    for element in root.iter():
        rule = SDF_CHILDREN.get(element.tag, [])
        children, order = [child.tag for child in element], [name.rstrip("*") for name in rule]
        assert children == sorted(children, key=order.index), element.tag
        assert {name[:-1] for name in rule if name.endswith("*")} <= set(children), element.tag
        assert set(element.attrib) == SDF_ATTRIBUTES.get(element.tag, set()), element.tag
        names = [child.get("name") for child in element if child.get("name")]
        assert len(names) == len(set(names)) and not any("__" in name for name in names)
    for size in root.iter("size"):
        assert len(size.text.split()) == 3 and min(map(float, size.text.split())) > 0
    assert [len(pose.text.split()) for pose in root.iter("pose")] == [6] * 2 * len(corner_boxes(pipe))


def test_scenes_hold_the_same_boxes(made: tuple[PipeCorner, Path]) -> None:
    pipe, folder = made
    expected = [(box.x, box.y, box.yaw, box.length, box.thickness, pipe.diameter) for box in corner_boxes(pipe)]
    urdf, sdf = ET.parse(folder / "pipe.urdf").getroot(), ET.parse(folder / "pipe.sdf").getroot()
    for part in ("collision", "visual"):
        ours = [
            (*origin.get("xyz").split()[:2], origin.get("rpy").split()[2], *box.get("size").split())
            for origin, box in zip(
                urdf.iterfind(f"link/{part}/origin"), urdf.iterfind(f"link/{part}/geometry/box"), strict=True
            )
        ]
        np.testing.assert_allclose(np.array(ours, float), expected, atol=1e-7)
        poses = [pose.text.split() for pose in sdf.iterfind(f"model/link/{part}/pose")]
        sizes = [size.text.split() for size in sdf.iterfind(f"model/link/{part}/geometry/box/size")]
        theirs = [(*pose[:2], pose[5], *size) for pose, size in zip(poses, sizes, strict=True)]
        np.testing.assert_allclose(np.array(theirs, float), expected, atol=1e-7)


def test_drawing_is_a_png_of_readable_size(made: tuple[PipeCorner, Path]) -> None:
    content = (made[1] / "pipe.png").read_bytes()
    width, height = (int.from_bytes(content[i : i + 4], "big") for i in (16, 20))
    assert content.startswith(b"\x89PNG") and 800 < width < 2500 and 400 < height < 2500


def test_folder_and_file_are_read_alike(made: tuple[PipeCorner, Path]) -> None:
    pipe, folder = made
    assert read_pipe(folder) == read_pipe(folder / "pipe.json") == pipe
    record = json.loads((folder / "pipe.json").read_text())
    np.testing.assert_array_equal(record["wall_segments_m"], pipe.segments)
    np.testing.assert_array_equal(record["second_leg_direction"], pipe.second_leg)


def test_folder_holds_exactly_its_files(made: tuple[PipeCorner, Path]) -> None:
    pipe, folder = made
    assert folder.name == pipe.name and {path.name for path in folder.iterdir()} == set(FILES)
    assert list(folder.parent.iterdir()) == [folder]
