"""The pipe folder: one corner as JSON, STL, MJCF, URDF, SDF and a drawing. Format: docs/formats/pipe-folder.md."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pipenav.errors import ConfigError
from pipenav.export.scene_xml import COLOUR, Shape, about_z, add, mjcf, sdf, text, urdf, write_xml
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_solids import Box, Mesh, boards_mesh, corner_boxes, tube_mesh
from pipenav.pipes.json_keys import CORNER_KEYS
from pipenav.storage.atomic_folder import read_record, refuse_contradictions, write_folder, write_record
from pipenav.units import m_to_mm, rad_to_deg

SCHEMA = 1
"""Version of the pipe folder's format."""

FILES = {
    "pipe.json": "every parameter and the wall segments",
    "boards.stl": "two bent boards, the pipe cut in its plane (mm)",
    "tube.stl": "hollow tube (mm)",
    "pipe.xml": "MuJoCo model, walls as boxes",
    "pipe.urdf": "URDF model, walls as boxes",
    "pipe.sdf": "SDF model, walls as boxes",
    "pipe.png": "drawing with dimensions",
}
"""Files of a pipe folder, each with one line that describes it."""


def write_pipe_folder(pipe: PipeCorner, out_root: Path) -> Path:
    """Write `<out_root>/<pipe.name>/`, complete or not at all, in place of an older folder of the same pipe.

    Files that others put into the older folder are kept.

    Raises:
        FileProblem: the folder cannot be written.
        PipenavError: something that is not a pipe folder has that name.
    """
    folder = out_root / pipe.name
    write_folder(folder, "pipe folder", "pipe.json", FILES, lambda draft: _write_files(pipe, draft))
    return folder


def _write_files(pipe: PipeCorner, folder: Path) -> None:
    from pipenav.drawing.corner import draw_pipe

    boxes = corner_boxes(pipe)
    shapes = [_shape(box, pipe) for box in boxes]
    write_record(folder / "pipe.json", pipe_record(pipe))
    write_stl(folder / "boards.stl", boards_mesh(pipe))
    write_stl(folder / "tube.stl", tube_mesh(pipe))
    write_xml(folder / "pipe.xml", _mjcf(pipe, boxes))
    write_xml(folder / "pipe.urdf", urdf(pipe.name, shapes))
    write_xml(folder / "pipe.sdf", sdf(pipe.name, shapes))
    draw_pipe(pipe, folder / "pipe.png")


def pipe_record(pipe: PipeCorner) -> dict[str, Any]:
    """The content of pipe.json. The SI numbers count; the ones in mm and deg repeat them for people."""
    return {
        "schema": SCHEMA,
        "name": pipe.name,
        "turn": pipe.turn,
        "diameter_m": pipe.diameter,
        "diameter_mm": m_to_mm(pipe.diameter),
        "angle_rad": pipe.angle,
        "angle_deg": rad_to_deg(pipe.angle),
        "bend_radius_m": pipe.bend_radius,
        "bend_radius_mm": m_to_mm(pipe.bend_radius),
        "leg_m": pipe.leg,
        "leg_mm": m_to_mm(pipe.leg),
        "wall_m": pipe.wall,
        "wall_mm": m_to_mm(pipe.wall),
        "gap_m": pipe.gap,
        "inner_edge_m": pipe.inner_edge,
        "heading_change_rad": pipe.heading_change,
        "second_leg_direction": pipe.second_leg.tolist(),
        "wall_segments_m": pipe.segments.tolist(),
    }


def read_pipe(path: Path) -> PipeCorner:
    """The corner of a pipe folder, or of its pipe.json, exactly as it was written.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is not a pipe file of this version, or contradicts itself.
        OutOfRange: a number outside its allowed range.
    """
    file = path / "pipe.json" if path.is_dir() else path
    record = read_record(file, "pipe file", (SCHEMA,), list(CORNER_KEYS.values()))
    try:
        pipe = PipeCorner.model_validate({field: record[key] for field, key in CORNER_KEYS.items()})
    except ValidationError as error:
        raise ConfigError.from_validation(str(file), error) from error
    refuse_contradictions(file, record, pipe_record(pipe))
    return pipe


def write_stl(path: Path, mesh: Mesh) -> None:
    """Write a mesh as a binary STL file."""
    import trimesh

    trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(path)


def _mjcf(pipe: PipeCorner, boxes: list[Box]) -> ET.Element:
    """A static MuJoCo model: one geom per box, and a camera that sees the corner from above."""
    root, body = mjcf(pipe.name, (0.0, 0.0, 2 * pipe.leg))
    for box in boxes:
        half = text(box.length / 2, box.thickness / 2, pipe.diameter / 2)
        pose = {"pos": text(box.x, box.y, 0), "quat": about_z(box.yaw)}
        add(body, "geom", name=f"wall_{box.name}", type="box", size=half, rgba=COLOUR, **pose)
    return root


def _shape(box: Box, pipe: PipeCorner) -> Shape:
    return Shape(box.name, "box", text(box.length, box.thickness, pipe.diameter), (box.x, box.y, 0.0, box.yaw))
