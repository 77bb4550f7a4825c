"""The pipe folder: one pipe as JSON, STL, MJCF, URDF, SDF and a drawing. docs/pipe-folder.md describes the format.

The scenes (MJCF, URDF, SDF) are made of boxes only, because simulators collide a concave mesh as its convex hull. A
box has a face flush with each wall segment and lies in the wall's material entirely: nothing stands out into free
space, however sharp the corner.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import uuid
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pipenav.errors import ConfigError, FileProblem, PipenavError
from pipenav.pipe import ARC_TOLERANCE, Array, Pipe, Turn
from pipenav.units import m_to_mm, rad_to_deg

SCHEMA = 1
"""Version of the pipe folder."""

FILES = {
    "pipe.json": "every parameter, the walls as segments in metres",
    "boards.stl": "the two bent boards (the pipe cut in its plane), watertight, millimetres",
    "tube.stl": "the hollow tube, watertight, millimetres",
    "pipe.xml": "MuJoCo model, walls as boxes",
    "pipe.urdf": "URDF model, walls as boxes",
    "pipe.sdf": "SDF model, walls as boxes",
    "pipe.png": "drawing with dimensions",
}
"""The files of a pipe folder, each with one line of what it is."""

THINNING = 8.0
"""Towards a sharp inner edge each box is this many times thinner than the one before it."""

EDGE_TOLERANCE = 5e-5
"""Length [m] at the very tip of a sharp inner edge that no box fills."""

WALL_RGBA = "0.55 0.6 0.65 1"


class Box(NamedTuple):
    """A box of the pipe's height, its centre in the pipe's plane: place and size [m], yaw [rad]."""

    name: str
    x: float
    y: float
    yaw: float
    length: float
    thickness: float


def write_pipe_folder(pipe: Pipe, out_root: Path) -> Path:
    """Write `<out_root>/<pipe.name>/` as a whole or not at all, in place of an older folder of the same pipe.

    Files that others put into the older folder are kept.

    Raises:
        FileProblem: the folder cannot be written.
        PipenavError: something that is not a pipe folder has that name.
    """
    folder = out_root / pipe.name
    if (folder.exists() or folder.is_symlink()) and not _is_pipe_folder(folder):
        raise PipenavError(f"{folder} exists and is not a pipe folder: move it away or choose another --out.")
    draft = out_root / f".{pipe.name}.{uuid.uuid4().hex[:8]}"
    try:
        draft.mkdir(parents=True)
        _write_files(pipe, draft)
        _put_in_place(draft, folder)
    except OSError as error:
        raise FileProblem(folder, "write", error) from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    return folder


def read_pipe(path: Path) -> Pipe:
    """The pipe of a pipe folder, or of its `pipe.json`, exactly as it was written.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: the file is not a pipe file of this version, or contradicts itself.
        OutOfRange: a number outside its allowed range.
    """
    file = path / "pipe.json" if path.is_dir() else path
    try:
        record = _PipeFile.model_validate(json.loads(file.read_text(encoding="utf-8")))
    except OSError as error:
        raise FileProblem(file, "read", error) from error
    except ValidationError as error:
        known = (field.alias or name for name, field in _PipeFile.model_fields.items())
        raise ConfigError.from_validation(str(file), error, known) from error
    except ValueError as error:  # not JSON, or not text
        raise ConfigError(f"{file} is not a JSON file: {error}.") from error
    for key, metres_or_radians in record.twins():
        if not math.isclose(getattr(record, key), metres_or_radians, rel_tol=1e-9, abs_tol=1e-9):
            raise ConfigError(f"{file}: {key} contradicts its SI twin: change both, or make the pipe with gen-pipe.")
    return Pipe(
        diameter=record.diameter_m,
        angle=record.angle_rad,
        turn=record.turn,
        bend_radius=record.bend_radius_m,
        leg=record.leg_m,
        wall=record.wall_m,
    )


class _PipeFile(BaseModel):
    """`pipe.json`, keys in the order of the file. The SI numbers count; the ones in mm and deg are for people."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, populate_by_name=True)

    version: Literal[1] = Field(SCHEMA, alias="schema")
    name: str
    turn: Turn
    diameter_m: float
    diameter_mm: float
    angle_rad: float
    angle_deg: float
    bend_radius_m: float
    bend_radius_mm: float
    leg_m: float
    leg_mm: float
    wall_m: float
    wall_mm: float
    heading_change_rad: float
    second_leg_direction: list[float]
    gap_m: float
    inner_edge_m: float
    wall_segments_m: list[list[list[float]]]

    @classmethod
    def of(cls, pipe: Pipe) -> _PipeFile:
        return cls(
            name=pipe.name,
            turn=pipe.turn,
            diameter_m=pipe.diameter,
            diameter_mm=m_to_mm(pipe.diameter),
            angle_rad=pipe.angle,
            angle_deg=rad_to_deg(pipe.angle),
            bend_radius_m=pipe.bend_radius,
            bend_radius_mm=m_to_mm(pipe.bend_radius),
            leg_m=pipe.leg,
            leg_mm=m_to_mm(pipe.leg),
            wall_m=pipe.wall,
            wall_mm=m_to_mm(pipe.wall),
            heading_change_rad=pipe.heading_change,
            second_leg_direction=pipe.second_leg.tolist(),
            gap_m=pipe.gap,
            inner_edge_m=pipe.inner_edge,
            wall_segments_m=pipe.segments.tolist(),
        )
