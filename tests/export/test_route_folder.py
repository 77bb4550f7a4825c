"""A route folder says the same in every one of its formats."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from helpers.random_routes import along_centre, rounded_length

from pipenav.arrays import Floats
from pipenav.errors import ConfigError, OutOfRange, PipenavError
from pipenav.export.route_folder import FILES, read_route_folder, route_files, route_record, write_route_folder
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_routes
from pipenav.pipes.route_solids import BEND_DEVIATION, FACETS, wall_prisms
from pipenav.pipes.system_solids import PRISM_FACES

CASES = {
    "level": parse_routes(["runs-level:5"])[0],
    "rolled": parse_routes(["runs-rolled:11"])[0],
    "bent": PipeRoute.of(90, [(90, "left", 0, 67.5), (60, "right", 90, 135), (120, "left", -45)]),
    "odd": PipeRoute.of(150, [(30, "right", 0), (180, "left", 0), (120, "left", 33)], wall_mm=5),
}


@pytest.fixture(scope="module", params=CASES.items(), ids=lambda case: case[0])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[PipeRoute, Path]:
    name, route = request.param
    return route, write_route_folder(route, name, tmp_path_factory.mktemp("runs"))


@pytest.mark.slow
def test_folder_holds_exactly_its_files(made: tuple[PipeRoute, Path]) -> None:
    route, folder = made
    assert {path.name for path in folder.iterdir()} == set(route_files(route))
    assert ("boards.stl" in route_files(route)) == route.planar
    assert list(folder.parent.iterdir()) == [folder]


@pytest.mark.slow
def test_folder_and_file_are_read_alike(made: tuple[PipeRoute, Path]) -> None:
    route, folder = made
    assert read_route_folder(folder) == read_route_folder(folder / "run.json") == route
    record = json.loads((folder / "run.json").read_text())
    np.testing.assert_array_equal(record["centre_line_m"], route.centre_line)
    np.testing.assert_array_equal(record["rotations"], route.frames.rotation)
    assert (record["wall_segments_m"] is None) == (not route.planar)


def test_stl_files_are_watertight_and_in_millimetres(made: tuple[PipeRoute, Path]) -> None:
    route, folder = made
    for path in folder.glob("*.stl"):
        body = trimesh.load(path)
        assert body.is_watertight and body.is_winding_consistent and body.volume > 0
        assert 1000 * route.centre_line[0, 0] == pytest.approx(body.bounds[0, 0], abs=0.01) or body.bounds[0, 0] < -1000


def rays(route: PipeRoute, count: int) -> tuple[Floats, Floats, Floats]:
    """Rays from the axes across the legs, away from mitres: origins, unit vectors, distances to the polygon."""
    rng = np.random.default_rng(1)
    leg, around = rng.integers(0, len(route.straights), count), rng.uniform(0, 2 * math.pi, count)
    length = np.array(route.straights)[leg]
    along = length * rng.uniform(0.48, 0.52, count)
    axes = route.legs.axes[leg]
    origins = route.legs.start[leg] + along[:, None] * axes[:, :, 0]
    directions = np.cos(around)[:, None] * axes[:, :, 1] + np.sin(around)[:, None] * axes[:, :, 2]
    turn_sign = 2 * math.pi / FACETS
    return origins, directions, route.radius / np.cos((around + turn_sign / 2) % turn_sign - turn_sign / 2)


def test_mujoco_sees_the_walls_where_the_prisms_are(made: tuple[PipeRoute, Path]) -> None:
    route, folder = made
    model = mujoco.MjModel.from_xml_path(str(folder / "pipe.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert model.nv == 0 and model.ngeom == FACETS * len(wall_prisms(route))
    for origin, direction, expected in zip(*rays(route, 200), strict=True):
        seen = mujoco.mj_ray(model, data, origin, direction, None, 1, -1, np.zeros(1, np.int32), None)
        assert seen == pytest.approx(expected, abs=1e-5)


def test_a_ball_as_wide_as_the_bore_passes_every_mitre_in_mujoco(made: tuple[PipeRoute, Path]) -> None:
    """Nothing sticks out into the bore, and the convex hulls that contacts are found with fill none of it.

    The chords of a bend do, by the share of the radius that is promised.
    """
    route, folder = made
    spec = mujoco.MjSpec.from_file(str(folder / "pipe.xml"))
    ball = spec.worldbody.add_body()
    ball.add_freejoint()
    radius = route.radius * (1 - BEND_DEVIATION * bool(route.legs.bend.any())) - 1e-4
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0])
    model = spec.compile()
    data = mujoco.MjData(model)
    for point in along_centre(route, 300, margin=route.radius):
        data.qpos[:3] = point
        mujoco.mj_forward(model, data)
        deepest = min((data.contact[i].dist for i in range(data.ncon)), default=0.0)
        assert deepest > -1e-5, point


def test_bullet_sees_the_walls_where_the_prisms_are(made: tuple[PipeRoute, Path]) -> None:
    """Bullet puts a millimetre around convex hulls."""
    bullet = pytest.importorskip("pybullet")
    route, folder = made
    origins, directions, expected = rays(route, 200)
    client = bullet.connect(bullet.DIRECT)
    try:
        body = bullet.loadURDF(str(folder / "pipe.urdf"), physicsClientId=client)
        assert bullet.getDynamicsInfo(body, -1, physicsClientId=client)[0] == 0  # without mass: it stays
        hits = bullet.rayTestBatch(origins, origins + 2 * expected[:, None] * directions, physicsClientId=client)
    finally:
        bullet.disconnect(client)
    seen = np.array([hit[2] for hit in hits]) * 2 * expected
    assert np.abs(seen - expected).max() < 1.5e-3


def test_walls_obj_holds_the_prisms_one_by_one(made: tuple[PipeRoute, Path]) -> None:
    route, folder = made
    body = trimesh.load(folder / "walls.obj", process=False)
    parts = [trimesh.Trimesh(body.vertices, faces) for faces in body.faces.reshape(-1, len(PRISM_FACES), 3)]
    assert len(parts) == FACETS * len(wall_prisms(route)) == (folder / "walls.obj").read_text().count("o wall_")
    assert all(part.is_watertight and part.volume > 0 for part in parts)
    section = FACETS * math.tan(math.pi / FACETS) * ((route.radius + route.wall) ** 2 - route.radius**2)
    chords = 3e-3 if route.legs.bend.any() else 1e-5  # an arc is longer than its chords
    assert sum(part.volume for part in parts) == pytest.approx(section * rounded_length(route), rel=chords)


def test_urdf_and_sdf_collide_with_one_convex_file_a_piece(made: tuple[PipeRoute, Path]) -> None:
    """An engine that fills a mesh up to its convex hull must find nothing to fill."""
    route, folder = made
    urdf, sdf = ET.parse(folder / "pipe.urdf").getroot(), ET.parse(folder / "pipe.sdf").getroot()
    pieces = sorted(f"walls/{path.name}" for path in (folder / "walls").iterdir())
    assert len(pieces) == FACETS * len(wall_prisms(route))
    for use, expected in (("visual", ["walls.obj"]), ("collision", pieces)):
        assert sorted(mesh.get("filename") for mesh in urdf.iterfind(f"link/{use}/geometry/mesh")) == expected
        assert sorted(uri.text for uri in sdf.iterfind(f"model/link/{use}/geometry/mesh/uri")) == expected
    whole = trimesh.load(folder / "walls.obj", process=False)
    parts = [trimesh.load(folder / piece) for piece in pieces]
    assert all(part.is_watertight for part in parts)
    for part in parts:  # convex: no vertex lies in front of any face
        ahead = np.einsum("fvx,fx->fv", part.vertices[None] - part.triangles[:, :1], part.face_normals)
        assert ahead.max() < 1e-6
    assert sum(part.volume for part in parts) == pytest.approx(whole.volume, rel=1e-6)
    assert sdf.get("version") == "1.7" and sdf.findtext("model/static") == "true"


def test_drawing_is_a_png_of_readable_size(made: tuple[PipeRoute, Path]) -> None:
    content = (made[1] / "pipe.png").read_bytes()
    width, height = (int.from_bytes(content[i : i + 4], "big") for i in (16, 20))
    assert content.startswith(b"\x89PNG") and 800 < width < 2500 and 400 < height < 3000


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Writing without the slow part, the drawing."""
    monkeypatch.setattr("pipenav.drawing.route.draw_route", lambda _, name, path: path.write_bytes(name.encode()))


@pytest.mark.usefixtures("quick")
def test_writing_again_replaces_the_folder_and_keeps_what_others_put_there(tmp_path: Path) -> None:
    folder = write_route_folder(CASES["level"], "mine", tmp_path)
    (folder / "notes.txt").write_text("mine")
    assert write_route_folder(CASES["rolled"], "mine", tmp_path) == folder
    assert read_route_folder(folder) == CASES["rolled"]
    assert {path.name for path in folder.iterdir()} == {*FILES, "notes.txt"} - {"boards.stl"}


def test_what_is_not_a_route_folder_stays(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "pipe.json").write_text("{}")
    with pytest.raises(PipenavError, match="mine exists and is not a route folder: move it away"):
        write_route_folder(CASES["level"], "mine", tmp_path)
    assert [path.name for path in tmp_path.rglob("*")] == ["mine", "pipe.json"]


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"schema": 4}, ConfigError, "schema 4: this version of pipenav reads schema 1, 2 and 3"),
        ({"diameter_mm": 90}, ConfigError, "diameter_mm 90 contradicts"),
        ({"straights_mm": [1, 2]}, ConfigError, r"straights_mm \[1, 2\] contradicts"),
        ({"corners": []}, ConfigError, "corners: list should have at least 1 item"),
        ({"corners": 3}, ConfigError, "corners: input should be a list"),
        ({"corners": [3]}, ConfigError, "corners.0: input should be"),
        ({"straights_m": ["long"]}, ConfigError, "straights.0: input should be a valid number"),
        ({"diameter_m": 0.5}, OutOfRange, "diameter 500 mm is out of range"),
    ],
)
def test_bad_route_files_are_refused_in_one_sentence(
    tmp_path: Path, change: dict[str, object], error: type[PipenavError], message: str
) -> None:
    file = tmp_path / "run.json"
    file.write_text(json.dumps({**route_record(CASES["level"], "mine"), **change}))
    with pytest.raises(error, match=message) as caught:
        read_route_folder(file)
    assert "\n" not in str(caught.value)


def test_an_angle_edited_for_people_alone_is_refused(tmp_path: Path) -> None:
    record = route_record(CASES["level"], "mine")
    record["corners"][1]["angle_deg"] += 10
    (tmp_path / "run.json").write_text(json.dumps(record))
    with pytest.raises(ConfigError, match=r"angle_deg \d+\.\d+ contradicts"):
        read_route_folder(tmp_path)
