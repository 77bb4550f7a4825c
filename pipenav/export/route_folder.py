"""The route folder: one route as JSON, meshes, MJCF, URDF, SDF and a drawing. Format: docs/formats/route-folder.md."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pipenav.errors import ConfigError
from pipenav.export.corner_folder import write_stl
from pipenav.export.scene_xml import Shape, sdf, urdf, write_xml
from pipenav.export.wall_files import wall_shapes, walls_mjcf, write_walls
from pipenav.pipes.json_keys import ROUTE_KEYS, keys_of_branches, optional_route_keys, route_fields
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner
from pipenav.pipes.route_solids import route_boards_mesh, route_tube_mesh, wall_pieces
from pipenav.storage.atomic_folder import read_record, refuse_contradictions, write_folder, write_record
from pipenav.units import m_to_mm, rad_to_deg

SCHEMA, SCHEMA_OF_BENDS, SCHEMA_OF_BRANCHES = 1, 2, 3
"""Versions of the route folder's format: a route of mitres has the first, one with bends or reducers the second, one
with tees, crosses, a cap or a slope the third."""

FILES = {
    "run.json": "every parameter, the centre line and the frames of the straights",
    "boards.stl": "two bent boards, the route cut in its plane (mm)",
    "tube.stl": "hollow tube (mm)",
    "walls.obj": "the wall as convex pieces, one object each (m)",
    "walls": "folder of those pieces, one OBJ file each (m)",
    "pipe.xml": "MuJoCo model, walls as those pieces",
    "pipe.urdf": "URDF model, walls as the files in walls",
    "pipe.sdf": "SDF model, walls as the files in walls",
    "pipe.png": "drawing with dimensions",
}
"""Files of a route folder, each with one line that describes it; `boards.stl` for planar routes only."""


def route_files(route: PipeRoute) -> dict[str, str]:
    """Files of the folder of a given route, each with one line that describes it."""
    return {name: purpose for name, purpose in FILES.items() if route.planar or name != "boards.stl"}


def write_route_folder(route: PipeRoute, name: str, out_root: Path) -> Path:
    """Write `<out_root>/<name>/`, complete or not at all, in place of an older folder of a route.

    Files that others put into the older folder are kept.

    Raises:
        FileProblem: the folder cannot be written.
        PipenavError: something that is not a route folder has that name.
    """
    folder = out_root / name
    write_folder(folder, "route folder", "run.json", FILES, lambda draft: _write_files(route, name, draft))
    return folder


def _write_files(route: PipeRoute, name: str, folder: Path) -> None:
    from pipenav.drawing.route import draw_route

    walls = wall_pieces(route)
    pieces = wall_shapes(walls)
    seen = [Shape("all", "mesh", "walls.obj")]
    write_record(folder / "run.json", route_record(route, name))
    if route.planar:
        write_stl(folder / "boards.stl", route_boards_mesh(route))
    write_stl(folder / "tube.stl", route_tube_mesh(route))
    write_walls(folder, walls)
    write_xml(folder / "pipe.xml", walls_mjcf(name, walls, route.centre_line))
    write_xml(folder / "pipe.urdf", urdf(name, pieces, seen))
    write_xml(folder / "pipe.sdf", sdf(name, pieces, seen))
    draw_route(route, name, folder / "pipe.png")


def route_record(route: PipeRoute, name: str) -> dict[str, Any]:
    """The content of run.json. The SI numbers count; the ones in mm and deg repeat them for people."""
    return {
        "schema": _schema(route),
        "name": name,
        "planar": route.planar,
        "diameter_m": route.diameter,
        "diameter_mm": m_to_mm(route.diameter),
        "wall_m": route.wall,
        "wall_mm": m_to_mm(route.wall),
        "corners": [_corner_record(corner) for corner in route.corners],
        "straights_m": list(route.straights),
        "straights_mm": [m_to_mm(straight) for straight in route.straights],
        "centre_line_m": route.centre_line.tolist(),
        "rotations": route.frames.rotation.tolist(),
        "wall_segments_m": route.segments.tolist() if route.planar else None,
        **optional_route_keys(route),
        **({"slope_deg": rad_to_deg(route.slope)} if route.slope else {}),
    }


def _schema(route: PipeRoute) -> int:
    if route.has_fittings or route.slope:
        return SCHEMA_OF_BRANCHES
    return SCHEMA if all(corner.mitre for corner in route.corners) else SCHEMA_OF_BENDS


def _corner_record(corner: Corner) -> dict[str, Any]:
    record: dict[str, Any] = {
        "turn": corner.turn,
        "angle_rad": corner.angle,
        "angle_deg": rad_to_deg(corner.angle),
        "roll_rad": corner.roll,
        "roll_deg": rad_to_deg(corner.roll),
    }
    if corner.bend_radius:
        record |= {"bend_radius_m": corner.bend_radius, "bend_radius_mm": m_to_mm(corner.bend_radius)}
    if corner.to_diameter is not None:
        record |= {"to_diameter_m": corner.to_diameter, "to_diameter_mm": m_to_mm(corner.to_diameter)}
        record |= {"length_m": corner.length, "length_mm": m_to_mm(corner.length)}
    if corner.branches:
        record["branches"] = [
            keys
            | {"angle_deg": rad_to_deg(branch.angle), "roll_deg": rad_to_deg(branch.roll)}
            | {"diameter_mm": m_to_mm(branch.diameter), "length_mm": m_to_mm(branch.length)}
            for branch, keys in zip(corner.branches, keys_of_branches(corner.branches), strict=True)
        ]
    return record


def read_route_folder(path: Path) -> PipeRoute:
    """The route of a route folder, or of its run.json, exactly as it was written.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is not a route file of this version, or contradicts itself.
        PipenavError: the route is not possible.
    """
    file = path / "run.json" if path.is_dir() else path
    record = read_record(file, "route file", (SCHEMA, SCHEMA_OF_BENDS, SCHEMA_OF_BRANCHES), list(ROUTE_KEYS.values()))
    try:
        route = PipeRoute.model_validate(route_fields(record))
    except ValidationError as error:
        raise ConfigError.from_validation(str(file), error) from error
    refuse_contradictions(file, record, route_record(route, str(record.get("name"))))
    return route
