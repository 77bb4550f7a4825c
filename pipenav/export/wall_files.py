"""Walls of convex pieces as files: OBJ, one for all and one for each, and the MuJoCo model of them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from pipenav.arrays import Floats
from pipenav.export.scene_xml import COLOUR, Shape, add, mjcf, text
from pipenav.pipes.system_solids import ConvexPiece


def wall_shapes(walls: dict[str, ConvexPiece]) -> list[Shape]:
    """The pieces as shapes of URDF and SDF models, in the files that `write_walls` writes."""
    return [Shape(part.removeprefix("wall_"), "mesh", f"walls/{part}.obj") for part in walls]


def walls_mjcf(name: str, walls: dict[str, ConvexPiece], points: Floats) -> ET.Element:
    """A static MuJoCo model: one convex mesh per piece of wall, and a camera that sees the whole from above.

    Args:
        name: name of the model.
        walls: pieces by name.
        points: points that the camera sees, (n, 3) [m].
    """
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, _ = (low + high) / 2
    root, body = mjcf(name, (float(x), float(y), float(high[2] + 1.4 * max(high - low))))
    assets = add(root, "asset")
    for part, piece in walls.items():
        # The scale is said because a model that includes this one may set another by default.
        add(assets, "mesh", name=part, scale="1 1 1", vertex=text(*piece.vertices.ravel()))
        add(body, "geom", name=part, type="mesh", mesh=part, rgba=COLOUR)
    return root


def write_walls(folder: Path, walls: dict[str, ConvexPiece]) -> None:
    """Write walls.obj, every piece as an object of its own, and every piece as a file of its own."""
    (folder / "walls").mkdir()
    lines: list[str] = []
    first = 1
    for part, piece in walls.items():
        (folder / "walls" / f"{part}.obj").write_text("\n".join(_object(part, piece, 1)) + "\n", encoding="utf-8")
        lines += _object(part, piece, first)
        first += len(piece.vertices)
    (folder / "walls.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _object(part: str, piece: ConvexPiece, first: int) -> list[str]:
    """Lines of an OBJ file for a piece of wall, whose vertices are numbered from `first`."""
    vertices = [f"v {text(*corner)}" for corner in piece.vertices]
    return [f"o {part}", *vertices, *("f {} {} {}".format(*(first + face)) for face in piece.faces)]
