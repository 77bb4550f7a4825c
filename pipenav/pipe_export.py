"""The pipe folder: one pipe as JSON, STL, MJCF, URDF, SDF and a drawing. docs/pipe-folder.md describes the format."""

from __future__ import annotations

import json
import math
import shutil
import uuid
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pipenav.errors import ConfigError, FileProblem, PipenavError
from pipenav.pipe import Pipe
from pipenav.pipe_shapes import Box, Mesh, boards_mesh, tube_mesh, wall_boxes
from pipenav.units import m_to_mm, rad_to_deg

SCHEMA = 1
"""Version of the pipe folder."""

FILES = {
    "pipe.json": "every parameter and the wall segments",
    "boards.stl": "two bent boards, the pipe cut in its plane (mm)",
    "tube.stl": "hollow tube (mm)",
    "pipe.xml": "MuJoCo model, walls as boxes",
    "pipe.urdf": "URDF model, walls as boxes",
    "pipe.sdf": "SDF model, walls as boxes",
    "pipe.png": "drawing with dimensions",
}
"""The files of a pipe folder, each with one line of what it is."""

FIELD_KEYS = {
    "turn": "turn",
    "diameter": "diameter_m",
    "angle": "angle_rad",
    "bend_radius": "bend_radius_m",
    "leg": "leg_m",
    "wall": "wall_m",
}
"""The keys of pipe.json that a pipe is read from; the others follow from these."""

COLOUR = "0.55 0.6 0.65 1"


def write_pipe_folder(pipe: Pipe, out_root: Path) -> Path:
    """Write `<out_root>/<pipe.name>/`, whole or not at all, in place of an older folder of the same pipe.

    Files that others put into the older folder are kept.

    Raises:
        FileProblem: the folder cannot be written.
        PipenavError: something that is not a pipe folder has that name.
    """
    folder = out_root / pipe.name
    mark = uuid.uuid4().hex[:8]
    draft, old = (out_root / f".{pipe.name}-{mark}-{part}" for part in ("new", "old"))
    try:
        if folder.is_symlink() or (folder.exists() and not (folder / "pipe.json").is_file()):
            raise PipenavError(f"{folder} exists and is not a pipe folder: move it away or choose another place.")
        draft.mkdir(parents=True)
        _write_files(pipe, draft)
        _swap(draft, folder, old)
    except OSError as error:
        raise FileProblem(folder, "write", error) from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    return folder


def _swap(draft: Path, folder: Path, old: Path) -> None:
    """Put the finished draft in the folder's place; what was there passes through `old`."""
    if not folder.exists():
        draft.rename(folder)
        return
    folder.rename(old)
    try:
        draft.rename(folder)
    except OSError:
        old.rename(folder)
        raise
    for path in old.iterdir():
        if path.name not in FILES:
            path.rename(folder / path.name)
    shutil.rmtree(old)


def _write_files(pipe: Pipe, folder: Path) -> None:
    from pipenav.pipe_drawing import draw_pipe

    boxes = wall_boxes(pipe)
    (folder / "pipe.json").write_text(json.dumps(pipe_record(pipe), indent=2) + "\n", encoding="utf-8")
    _write_stl(folder / "boards.stl", boards_mesh(pipe))
    _write_stl(folder / "tube.stl", tube_mesh(pipe))
    _write_xml(folder / "pipe.xml", _mjcf(pipe, boxes))
    _write_xml(folder / "pipe.urdf", _urdf(pipe, boxes))
    _write_xml(folder / "pipe.sdf", _sdf(pipe, boxes))
    draw_pipe(pipe, folder / "pipe.png")


def pipe_record(pipe: Pipe) -> dict[str, Any]:
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


def read_pipe(path: Path) -> Pipe:
    """The pipe of a pipe folder, or of its pipe.json, exactly as it was written.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is not a pipe file of this version, or contradicts itself.
        OutOfRange: a number outside its allowed range.
    """
    file = path / "pipe.json" if path.is_dir() else path
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileProblem(file, "read", error) from error
    except ValueError as error:  # not JSON, or not even text
        raise ConfigError(f"{file} is not a JSON file: {error}.") from error
    if not isinstance(record, dict) or "schema" not in record:
        raise ConfigError(f"{file} is not a pipe file: it has no 'schema'.")
    if record["schema"] != SCHEMA:
        raise ConfigError(f"{file} has schema {record['schema']!r}: this version of pipenav reads schema {SCHEMA}.")
    missing = [key for key in FIELD_KEYS.values() if key not in record]
    if missing:
        raise ConfigError(f"{file} lacks {', '.join(missing)}: make the folder again with gen-pipe.")
    try:
        pipe = Pipe.model_validate({field: record[key] for field, key in FIELD_KEYS.items()})
    except ValidationError as error:
        raise ConfigError.from_validation(str(file), error) from error
    _refuse_contradictions(file, record, pipe)
    return pipe


def _refuse_contradictions(file: Path, record: dict[str, Any], pipe: Pipe) -> None:
    """Someone who edits `diameter_mm` by hand must not get the pipe of `diameter_m` without a word."""
    for key, value in pipe_record(pipe).items():
        given = record.get(key, value)
        if key.endswith(("_mm", "_deg")) and not (isinstance(given, int | float) and math.isclose(given, value)):
            raise ConfigError(f"{file}: {key} {given!r} contradicts the same length or angle in SI units, {value:g}.")


def _write_stl(path: Path, mesh: Mesh) -> None:
    import trimesh

    trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(path)


def _mjcf(pipe: Pipe, boxes: list[Box]) -> ET.Element:
    """A static MuJoCo model: one geom per box, and a camera that sees the corner from above."""
    root = ET.Element("mujoco", model=pipe.name)
    _add(root, "compiler", angle="radian")
    world = _add(root, "worldbody")
    body = _add(world, "body", name="pipe")
    _add(body, "camera", name="above", pos=_text(0, 0, 2 * pipe.leg))
    for box in boxes:
        half = _text(box.length / 2, box.thickness / 2, pipe.diameter / 2)
        place = {"pos": _text(box.x, box.y, 0), "euler": _text(0, 0, box.yaw)}
        _add(body, "geom", name=f"wall_{box.name}", type="box", size=half, rgba=COLOUR, **place)
    return root


def _urdf(pipe: Pipe, boxes: list[Box]) -> ET.Element:
    """One link without mass, which loaders take for a fixed one."""
    root = ET.Element("robot", name=pipe.name)
    _add(_add(root, "material", name="wall"), "color", rgba=COLOUR)
    link = _add(root, "link", name="pipe")
    inertial = _add(link, "inertial")
    _add(inertial, "mass", value="0")
    _add(inertial, "inertia", **dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0"))
    for kind in ("visual", "collision"):
        for box in boxes:
            part = _add(link, kind, name=f"wall_{box.name}")
            _add(part, "origin", xyz=_text(box.x, box.y, 0), rpy=_text(0, 0, box.yaw))
            _add(_add(part, "geometry"), "box", size=_text(box.length, box.thickness, pipe.diameter))
            if kind == "visual":
                _add(part, "material", name="wall")
    return root


def _sdf(pipe: Pipe, boxes: list[Box]) -> ET.Element:
    """One static model with one link, children in the order of SDFormat's own description files."""
    root = ET.Element("sdf", version="1.7")
    model = _add(root, "model", name=pipe.name)
    _add(model, "static").text = "true"
    link = _add(model, "link", name="pipe")
    for kind in ("collision", "visual"):
        for box in boxes:
            part = _add(link, kind, name=f"wall_{box.name}_{kind}")
            _add(part, "pose").text = _text(box.x, box.y, 0, 0, 0, box.yaw)
            if kind == "visual":
                material = _add(part, "material")
                _add(material, "ambient").text = COLOUR
                _add(material, "diffuse").text = COLOUR
            shape = _add(_add(part, "geometry"), "box")
            _add(shape, "size").text = _text(box.length, box.thickness, pipe.diameter)
    return root


def _add(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    return ET.SubElement(parent, tag, attributes)


def _text(*numbers: float) -> str:
    return " ".join(f"{number:.9g}" for number in numbers)


def _write_xml(path: Path, root: ET.Element) -> None:
    ET.indent(root)
    ET.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
