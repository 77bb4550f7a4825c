"""ESRI shapefiles of polylines, read by the library pyshp (MIT), which `pip install pipenav[survey]` installs."""

from __future__ import annotations

import io
from itertools import pairwise
from pathlib import Path
from typing import Any

from pipenav.errors import ConfigError, PipenavError, shown
from pipenav.networks.draft import MapDraft, Point
from pipenav.networks.fields import ReadOptions, facts_of
from pipenav.networks.model import NetworkMap
from pipenav.networks.polylines import PolyLine, joined_map
from pipenav.networks.text import MAX_NETWORK
from pipenav.storage.text_files import read_bytes, shown_path

POLYLINES = (3, 13, 23)
"""Types of shapes that are polylines: plain, with heights, with measures (ESRI Shapefile Technical Description)."""


def read_shapefile(path: Path, options: ReadOptions) -> NetworkMap:
    """The map of a shapefile; its table `.dbf` lies beside it.

    Raises:
        FileProblem: a file cannot be read.
        PipenavError: pyshp is not installed.
        ConfigError: it is no shapefile of polylines, with the feature that does not fit.
    """
    try:
        import shapefile
    except ImportError as error:
        raise PipenavError(
            f"{shown_path(path)} needs pyshp to be read: install it with pip install pipenav[survey], or save the "
            "lines as GeoJSON."
        ) from error
    where, table = shown_path(path), path.with_suffix(".dbf")
    if path.is_file() and not table.is_file():
        raise ConfigError(f"{where} has no {shown(table.name, quoted=False)} beside it, its table: put it there.")
    parts = {kind: io.BytesIO(read_bytes(path.with_suffix(f".{kind}"), MAX_NETWORK)) for kind in ("shp", "dbf")}
    draft = MapDraft(where, "shapefile")
    projection = path.with_suffix(".prj")
    degrees = projection.is_file() and read_bytes(projection, 1 << 16).lstrip().upper().startswith(b"GEOGCS")
    try:
        reader = shapefile.Reader(**parts, encodingErrors="replace")
        if reader.shapeType not in POLYLINES:
            raise ConfigError(f"{where} holds {shown(reader.shapeTypeName)}: give a shapefile of polylines.")
        names = [str(column[0]) for column in reader.fields if column[0] != "DeletionFlag"]
        lines = [
            line
            for i, record in enumerate(reader.iterShapeRecords(), 1)
            for line in _lines(draft, record.shape, dict(zip(names, record.record, strict=True)), i, options)
        ]
    except PipenavError:
        raise
    except Exception as error:  # the library raises errors of many kinds for damaged files
        raise ConfigError(f"{where} is no readable shapefile ({shown(error, quoted=False)}): save it anew.") from error
    return joined_map(draft, lines, options, degrees)


def _lines(draft: MapDraft, shape: Any, fields: dict[str, object], i: int, options: ReadOptions) -> list[PolyLine]:
    place = f"feature {i}"
    if not shape.points:
        draft.note("other-geometry", "info", "features without a shape were left out", place)
        return []
    facts = facts_of(draft, fields, options, place)
    heights = list(shape.z) if hasattr(shape, "z") else [None] * len(shape.points)
    points: list[Point] = [
        (float(point[0]), float(point[1]), None if z is None else float(z))
        for point, z in zip(shape.points, heights, strict=True)
    ]
    starts = [*shape.parts, len(points)]
    pieces = [points[a:b] for a, b in pairwise(starts)]
    return [
        PolyLine(str(i) if len(pieces) == 1 else f"{i}.{k}", piece, facts, place) for k, piece in enumerate(pieces, 1)
    ]
