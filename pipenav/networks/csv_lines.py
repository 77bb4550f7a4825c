"""CSV of lines: a row for each pipe, its course in `wkt` (LINESTRING) or in `x1`, `y1`, `x2`, `y2` (and `z1`, `z2`)."""

from __future__ import annotations

import csv
import re
from pathlib import Path

from pipenav.errors import ConfigError, shown
from pipenav.networks.draft import MapDraft, Point
from pipenav.networks.fields import ReadOptions, facts_of
from pipenav.networks.model import NetworkMap
from pipenav.networks.polylines import PolyLine, joined_map
from pipenav.networks.text import network_text
from pipenav.networks.units import number
from pipenav.storage.text_files import shown_path

NAMES = ("name", "id", "fid")
"""Columns that may name a line."""

COURSE = ("x1", "y1", "x2", "y2")

_WKT = re.compile(r"\s*LINESTRING\s*(?:ZM?|M)?\s*\(([^()]*)\)\s*", re.IGNORECASE)


def read_csv_lines(path: Path, options: ReadOptions) -> NetworkMap:
    """The map of a CSV file of lines, separated by commas, semicolons or tabs.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no such file, with the line that does not fit.
    """
    where = shown_path(path)
    text = network_text(path)
    head = text.split("\n", 1)[0]
    delimiter = max(",;\t", key=head.count)
    reader = csv.reader(text.split("\n"), delimiter=delimiter)
    draft = MapDraft(where, "CSV of lines")
    lines: list[PolyLine] = []
    try:
        columns = [column.strip() for column in next(reader)]
        _check_columns(columns, where)
        for row in reader:
            if any(cell.strip() for cell in row):
                lines.append(_line(draft, columns, row, reader.line_num, options))
    except csv.Error as error:
        raise ConfigError(f"{where}, line {reader.line_num}: {error}: correct it there.") from error
    return joined_map(draft, lines, options, degrees=False)


def _check_columns(columns: list[str], where: str) -> None:
    low = [column.lower() for column in columns]
    if "wkt" not in low and not set(COURSE) <= set(low):
        raise ConfigError(
            f"{where} has no column wkt and no columns x1, y1, x2, y2: name those in its first line, given "
            f"{shown(', '.join(columns))}."
        )
    if twice := next((name for i, name in enumerate(low) if name in low[:i]), None):
        raise ConfigError(f"{where} has two columns {shown(twice)}: rename one of them.")


def _line(draft: MapDraft, columns: list[str], row: list[str], at: int, options: ReadOptions) -> PolyLine:
    place = f"line {at}"
    if len(row) != len(columns):
        raise draft.refuse(place, f"it has {len(row)} columns, the first line {len(columns)}: make them the same.")
    fields: dict[str, object] = dict(zip(columns, row, strict=True))
    low = {name.lower(): str(value).strip() for name, value in fields.items()}
    named = next((low[name] for name in NAMES if low.get(name)), str(at))
    return PolyLine(named, _points(draft, low, place), facts_of(draft, fields, options, place), place)


def _points(draft: MapDraft, low: dict[str, str], place: str) -> list[Point]:
    where = f"{draft.file}, {place}"
    if "wkt" in low:
        match = _WKT.fullmatch(low["wkt"])
        if match is None:
            raise draft.refuse(place, f"{shown(low['wkt'])} is no LINESTRING: correct it there.")
        return [_point(pair.split(), where) for pair in match[1].split(",")]
    ends = [[low[f"{axis}{end}"] for axis in "xyz" if low.get(f"{axis}{end}")] for end in "12"]
    return [_point(words, where) for words in ends]


def _point(words: list[str], where: str) -> Point:
    if len(words) not in (2, 3, 4):
        raise ConfigError(f"{where}: {shown(' '.join(words))} is no point of x and y: correct it there.")
    numbers = [number(word, axis, where) for word, axis in zip(words, "xyz", strict=False)]
    return (numbers[0], numbers[1], numbers[2] if len(numbers) > 2 else None)
