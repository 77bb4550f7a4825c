"""The folder of a survey: its record, tables, map and report, all of them or none."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from pipenav.storage.atomic_files import Content, atomic_write_all
from pipenav.storage.json_parts import json_parts
from pipenav.survey.html_report import html_report
from pipenav.survey.map_figure import map_png
from pipenav.survey.tables import features_csv, map_geojson

FILES = ("survey.json", "features.csv", "map.geojson", "map.png", "report.html")
"""Files of a survey."""


def write_survey(folder: Path, record: dict[str, Any]) -> None:
    """Write the files of a survey into a folder that exists.

    Raises:
        FileProblem: they cannot be written; earlier ones are untouched.
    """
    contents: tuple[Content, ...] = (
        _text(itertools.chain(json_parts(record), "\n")),
        features_csv(record),
        _text(map_geojson(record)),
        map_png(record),
        _text(html_report(record)),
    )
    atomic_write_all({folder / name: content for name, content in zip(FILES, contents, strict=True)})


def _text(parts: Iterable[str]) -> Callable[[Path], None]:
    """Writer of a file whose text is made while it is written: that of a large network does not fit beside itself."""

    def write(draft: Path) -> None:
        with draft.open("w", encoding="utf-8", newline="") as file:
            file.writelines(parts)

    return write
