"""A picture of a whole network of pipes in space, or from above where it lies in one level plane."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.dimensions import DIMENSION, INK, WIDTH_IN, DimensionedDrawing, number, save_figure, write_title
from pipenav.drawing.down import down_sign
from pipenav.drawing.labels import Labels, Place, around
from pipenav.drawing.projection import View, draw_tube
from pipenav.drawing.words import counted
from pipenav.pipes.network import PipeNetwork
from pipenav.pipes.pipe_system import network_system
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LARGEST_IN = 22.0
"""Width of the picture of the largest networks [in]."""

PER_PIPE_IN = 0.35
"""Width by which a picture grows with each pipe beyond those for which `WIDTH_IN` is enough [in]."""

FEW_PIPES = 15
"""Pipes for which `WIDTH_IN` is enough."""

TALLEST = 1.2
"""Height of a picture at most, as a share of its width; the width shrinks where it would be more."""

COVERED = 0.15
"""Share of a text that may touch others; a text without a better place is left out, and the picture says so."""


def draw_network(network: PipeNetwork, name: str, path: Path) -> None:
    """Draw a network into a PNG file, under a name."""
    save_figure(network_figure(network, name), path)


def network_figure(network: PipeNetwork, name: str) -> Figure:
    """The picture of a network as a matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(facecolor="white", layout="constrained")
    axes = figure.add_subplot()
    system = network_system(network)
    view = View.of(system)
    drawn = draw_tube(axes, system, view)
    width = min(WIDTH_IN + PER_PIPE_IN * max(len(network.pipes) - FEW_PIPES, 0), LARGEST_IN)
    sketch = _NetworkSketch(network, axes, view, drawn, width)
    left_out = sketch.names() + sketch.sizes()
    low, high = sketch.frame()
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()
    tall = width * float((high[1] - low[1]) / (high[0] - low[0]))
    shrink = min(1.0, TALLEST * width / tall)
    figure.set_size_inches(max(width * shrink, 6.5) + 0.4, tall * shrink + 1.2)
    axes.add_artist(down_sign(view.seen(np.array([0.0, 0.0, -1.0])), axes.transAxes, (1.0, 1.0)))
    facts = f"{_length(network):.2f} m of pipes; bores and lengths in mm, lengths from node to node"
    missing = f"; {left_out} texts without room left out" if left_out else ""
    write_title(axes, f"{name}: {_counts(network)}", facts + missing)
    return figure


class _NetworkSketch(DimensionedDrawing):
    """Texts at nodes and along pipes."""

    def __init__(self, network: PipeNetwork, axes: Axes, view: View, drawn: Floats, width: float) -> None:
        mm = m_to_mm(1.0)
        super().__init__(axes, drawn)
        self.unit *= WIDTH_IN / width
        self.network = network
        self.nodes = {name: mm * view.flat(np.array(node.position)) for name, node in network.nodes.items()}
        ends = np.array([[self.nodes[pipe.start], self.nodes[pipe.end]] for pipe in network.pipes])
        half = mm * (np.array([pipe.diameter / 2 for pipe in network.pipes]) + network.wall)
        self.ends, self.half, self.labels = ends, half, Labels(ends, half, self.unit)

    def names(self) -> int:
        """Write every node's name beside it; return how many found no room."""
        left_out = 0
        for name, at in self.nodes.items():
            pipes = self.network.pipes_at(name)
            steps = np.array([self.nodes[pipe.other(name)] - at for pipe in pipes])
            away = -(steps / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-9)).sum(axis=0)
            off = m_to_mm(max(pipe.diameter for pipe in pipes) / 2 + self.network.wall)
            places = [place for gap in (1.5, 4.0) for place in around(at, off + gap * self.unit, away)]
            left_out += not self._write(name, places, INK)
            self.axes.plot(*at, "o", color="white", markeredgecolor=INK, markersize=4, zorder=6)
        return left_out

    def sizes(self) -> int:
        """Write bore and length of every pipe along it; return how many found no room."""
        left_out = 0
        for (start, end), half, pipe in zip(self.ends, self.half, self.network.pipes, strict=True):
            step = end - start
            size = float(np.linalg.norm(step))
            along = step / size if size > 1e-6 else np.array([1.0, 0.0])
            tilt = (math.degrees(math.atan2(along[1], along[0])) + 90.0) % 180.0 - 90.0
            across = (half + 1.6 * self.unit) * np.array([-along[1], along[0]])
            places = [
                Place(start + share * step + side * across, tilt=tilt)
                for share in (0.5, 0.35, 0.65)
                for side in (1, -1)
            ]
            nodes = (self.network.nodes[name].position for name in (pipe.start, pipe.end))
            length = m_to_mm(math.dist(*nodes))
            text = f"⌀ {number(m_to_mm(pipe.diameter))}, {number(round(length))}"
            left_out += not self._write(text, places, DIMENSION)
        return left_out

    def _write(self, text: str, places: list[Place], colour: str) -> bool:
        """Write a text at the first good place; whether there is one."""
        place = min(places, key=lambda place: self.labels.covered(text, place))
        points = self.labels.points(text, place)
        if self.labels.covered(text, place) > COVERED * len(points):
            return False
        self.labels.take(text, place)
        self.drawn.append(points)
        style: dict[str, Any] = {"ha": place.ha, "va": place.va, "rotation": place.tilt, "fontsize": 9.5}
        x, y = place.at
        self.axes.text(x, y, text, color=colour, rotation_mode="anchor", zorder=7, **style)
        return True


def _counts(network: PipeNetwork) -> str:
    """`12 nodes, 11 pipes, 3 tees, ⌀ 100-60 mm`."""
    kinds = [{3: "tee", 4: "cross"}.get(len(network.pipes_at(name)), "") for name in network.nodes]
    bores = sorted({round(m_to_mm(pipe.diameter), 3) for pipe in network.pipes}, reverse=True)
    shown = number(bores[0]) if len(bores) == 1 else f"{number(bores[0])}-{number(bores[-1])}"
    many = len(network.pipes)
    parts = [f"{len(network.nodes)} nodes", "one pipe" if many == 1 else f"{many} pipes"]
    return ", ".join([*parts, *filter(None, [counted(kinds, ("tee", "cross"))]), f"⌀ {shown} mm"])


def _length(network: PipeNetwork) -> float:
    """Length of all pipes, from node to node [m]."""
    nodes = network.nodes
    return sum(math.dist(nodes[pipe.start].position, nodes[pipe.end].position) for pipe in network.pipes)
