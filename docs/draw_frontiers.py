"""Draws docs/guides/frontiers.png: `python docs/draw_frontiers.py`.

The picture of docs/guides/certify.md: the bore in mitres, between boards, of the shipped robots whose frontiers ship.
"""

from __future__ import annotations

from pathlib import Path

from pipenav.certify.frontier import SHIPPED, read_frontier
from pipenav.certify.frontier_figure import frontier_figure
from pipenav.drawing.style import png

TEXT = "mitres, between boards: passable above the line, impossible below the band"


def main() -> None:
    """Draw the picture."""
    every = [read_frontier(path) for path in sorted(SHIPPED.glob("frontier-*-plane-mitre.json"))]
    figure = frontier_figure(every, "The bore that a robot needs", TEXT)
    Path(__file__).with_name("guides").joinpath("frontiers.png").write_bytes(png(figure))


if __name__ == "__main__":
    main()
