"""Panels of the maps in pages: left and right turns by diameter and shape, routes one after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pipenav.evaluation.cells import Fitting, fitting_of, in_order
from pipenav.evaluation.coarse import coarse_pipes
from pipenav.evaluation.pipe_results import PipeRecord

ROUTE_COLUMNS = 12
"""Cells in a row of the map of routes."""


def map_panels(pipes: Sequence[PipeRecord]) -> list[dict[str, Any]]:
    """Panels of the map of some pipes, as a page takes them: a cell has the places of its pipes in the sequence."""
    rounded = coarse_pipes(pipes).pipes
    panels = []
    for turn in ("left", "right"):
        here: dict[tuple[float, Fitting], list[int]] = {}
        for place, record in enumerate(rounded):
            shape = fitting_of(record)
            if shape is not None and record.turn == turn:
                here.setdefault((record.diameter_mm, shape), []).append(place)
        if here:
            rows, columns = sorted({d for d, _ in here}, reverse=True), in_order(shape for _, shape in here)
            cells = {f"{rows.index(d)} {columns.index(shape)}": places for (d, shape), places in here.items()}
            panels.append(
                _panel(f"{turn} turn", "mm / deg", [f"{d:g}" for d in rows], [c.label for c in columns], cells)
            )
    routes = [place for place, record in enumerate(pipes) if record.route is not None]
    if routes:
        count = -(-len(routes) // ROUTE_COLUMNS)
        cells = {f"{i // ROUTE_COLUMNS} {i % ROUTE_COLUMNS}": [place] for i, place in enumerate(routes)}
        rows_of = [f"from {1 + ROUTE_COLUMNS * i}" for i in range(count)]
        panels.append(_panel("routes in the order given", "route", rows_of, _numbers(len(routes)), cells))
    return panels


def _numbers(routes: int) -> list[str]:
    return [str(1 + i) for i in range(min(routes, ROUTE_COLUMNS))]


def _panel(
    name: str, corner: str, rows: Sequence[str], columns: Sequence[str], cells: Mapping[str, list[int]]
) -> dict[str, Any]:
    return {"name": name, "corner": corner, "rows": list(rows), "columns": list(columns), "cells": dict(cells)}
