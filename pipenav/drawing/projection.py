"""Pipes seen from a point far away, from above and aside, as polygons: a closed tube, or one cut open to the viewer."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.surface import PIECE, surface
from pipenav.pipes.pipe_system import PipeSystem
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ELEVATION = math.radians(30.0)
"""Angle by which the viewer looks down [rad]."""

AZIMUTHS = np.deg2rad(np.arange(5.0, 360.0, 10.0))
"""Azimuths from which the viewer may look [rad]."""

HIDING = 0.2
"""Cost of two straights of which one hides the other, as the share of a straight's length that would cost as much."""

SAMPLES = 20
"""Points along a straight in the test whether it hides another one."""

WALL_RGB, BORE_RGB, SHADOW = (0.50, 0.57, 0.64), (0.30, 0.34, 0.38), "#e6e9ed"

OPEN_RGB, RIM_RGB, SEAM_RGB = (0.88, 0.91, 0.94), (0.29, 0.33, 0.38), (0.36, 0.40, 0.44)
"""Colours of a tube that is cut open: its bore, the wall's cut, and lines where parts join."""

MOST_PIECES = 2500
"""Pieces of one strip of the longest networks; their pipes are too thin for more to be seen."""

THIN = 0.001
"""Radius below which a pipe would be thinner than a line, as a share of the picture."""

LEVEL = 1e-6
"""Component of a direction along z below which it is level: rounding."""


class View(NamedTuple):
    """A parallel projection.

    Attributes:
        to_viewer: unit vector, (3,).
        right, up: unit vectors of the picture, (3,).
    """

    to_viewer: Floats
    right: Floats
    up: Floats

    @classmethod
    def towards(cls, azimuth: float) -> View:
        """The view from an azimuth, counted from x to y [rad]."""
        c, s, ce, se = math.cos(azimuth), math.sin(azimuth), math.cos(ELEVATION), math.sin(ELEVATION)
        return cls(np.array([ce * c, ce * s, se]), np.array([-s, c, 0.0]), np.array([-se * c, -se * s, ce]))

    @classmethod
    def from_above(cls) -> View:
        """The view straight down, x to the right."""
        return cls(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))

    @classmethod
    def of(cls, system: PipeSystem) -> View:
        """The best view of pipes: few straights hide others, and none appears much shortened.

        Pipes in a level plane are seen from above.
        """
        straights = straights_of(system)
        along = straights[:, 1] - straights[:, 0]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        if np.ptp(straights[..., 2]) < LEVEL:
            return cls.from_above()

        def worth(view: View) -> float:
            seen = float(np.linalg.norm(view.flat(along), axis=1).min())
            return seen - HIDING * view.hidden(system)

        return max((cls.towards(azimuth) for azimuth in AZIMUTHS), key=worth)

    def seen(self, direction: Floats) -> Floats:
        """A direction (3,) in the picture: to the right, upwards, and to the viewer, (3,)."""
        return np.array([direction @ self.right, direction @ self.up, direction @ self.to_viewer])

    def hidden(self, system: PipeSystem) -> int:
        """Number of pairs of straights that do not join and lie over each other in the picture."""
        straights = straights_of(system)
        share = np.linspace(0, 1, SAMPLES)[:, None]
        ends = self.flat(straights)
        points = ends[:, :1] + share * (ends[:, 1:] - ends[:, :1])  # (straights, SAMPLES, 2)
        first, second = np.triu_indices(len(points), 1)
        gaps = np.linalg.norm(straights[first][:, :, None] - straights[second][:, None], axis=-1).reshape(-1, 4)
        apart = gaps.min(axis=1) > LEVEL
        widest = 2 * (max(float(strand.legs.radius.max()) for strand in system.strands) + system.wall)
        low, high = points.min(axis=1), points.max(axis=1)
        boxes = ((low[first] < high[second] + widest) & (low[second] < high[first] + widest)).all(axis=1)
        pairs = np.stack([first, second], axis=1)[apart & boxes]
        return sum(bool(_distance(points[i], points[j]) < widest) for i, j in pairs)

    def flat(self, points: Floats) -> Floats:
        """Points (..., 3) projected into the picture, (..., 2)."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


def straights_of(system: PipeSystem) -> Floats:
    """Ends of the legs' axes, strand by strand, (straights, 2, 3) [m]."""
    starts = np.concatenate([strand.legs.start for strand in system.strands])
    steps = [strand.legs.length[:, None] * strand.legs.axes[:, :, 0] for strand in system.strands]
    return np.stack([starts, starts + np.concatenate(steps)], axis=1)


def draw_tube(axes: Axes, system: PipeSystem, view: View) -> Floats:
    """Draw the tube and its shadow, in millimetres of the picture; return all their points, (k, 2) [mm]."""
    from matplotlib.collections import PolyCollection

    straights = straights_of(system)
    length = float(np.linalg.norm(straights[:, 1] - straights[:, 0], axis=1).sum())
    quads, normal, *_ = surface(system, system.wall, max(PIECE, length / MOST_PIECES))
    thin = system.strands[0].legs.radius[0] < THIN * float(np.ptp(quads, axis=(0, 1)).max())
    edge = 1.2 if thin else 0.3
    shade = 0.72 + 0.4 * np.clip(normal @ _light(view), 0, 1)
    outside = normal @ view.to_viewer > 0
    colours = np.where(outside[:, None], np.minimum(shade[:, None] * WALL_RGB, 1.0), BORE_RGB)
    order = np.argsort(quads.mean(axis=1) @ view.to_viewer)
    ground = quads.copy()
    ground[..., 2] = quads[..., 2].min() - 2 * system.strands[0].legs.radius[0]
    shadow, tube = (m_to_mm(1.0) * view.flat(part) for part in (ground, quads[order]))
    axes.add_collection(PolyCollection(list(shadow), facecolors=SHADOW, edgecolors=SHADOW, linewidths=edge, zorder=0))
    axes.add_collection(
        PolyCollection(list(tube), facecolors=colours[order], edgecolors=colours[order], linewidths=edge, zorder=2)
    )
    return np.concatenate([shadow, tube]).reshape(-1, 2)


class CutOpen(NamedTuple):
    """A tube without the half of each leg that faces the viewer, as polygons, far ones first.

    Attributes:
        view: the view that it is cut open for.
        polygons: corners of the polygons, (q, 4, 3) [m].
        colours: colours, (q, 3).
        widths: widths of their edges, (q,) [pt].
    """

    view: View
    polygons: Floats
    colours: Floats
    widths: Floats

    @classmethod
    def of(cls, system: PipeSystem, view: View) -> CutOpen:
        """Pipes cut open for a view: the wall's cut, the bore, and lines where parts join."""
        outer, bore = surface(system, system.wall), surface(system, 0.0)
        far, _ = outer.facing(-view.to_viewer)
        seen, seams = bore.facing(-view.to_viewer)
        shade = 0.62 + 0.42 * np.clip(-bore.normals[seen] @ _light(view), 0, 1)
        lines = bore.seams[seams][:, [0, 0, 1, 1]]  # polygons without an area
        parts = [outer.quads[far], bore.quads[seen], lines]
        counts = [len(part) for part in parts]
        polygons = np.concatenate(parts)
        nearer = np.repeat([-PIECE, 0.0, 0.6 * PIECE], counts)  # a bore hides its rim
        order = np.argsort(polygons.mean(axis=1) @ view.to_viewer + nearer)
        colours = [np.tile(RIM_RGB, (counts[0], 1)), np.minimum(shade[:, None] * OPEN_RGB, 1.0)]
        colours.append(np.tile(SEAM_RGB, (counts[2], 1)))
        widths = np.repeat([0.4, 0.4, 0.9], counts)
        return cls(view, polygons[order], np.concatenate(colours)[order], widths[order])

    def near(self, point: Floats, distance: float) -> CutOpen:
        """The polygons up to a distance [m] from a point, (3,)."""
        chosen = np.linalg.norm(self.polygons.mean(axis=1) - point, axis=1) < distance
        return CutOpen(self.view, self.polygons[chosen], self.colours[chosen], self.widths[chosen])

    def draw(self, axes: Axes) -> Floats:
        """Draw it in millimetres of the picture; return all points, (k, 2) [mm]."""
        from matplotlib.collections import PolyCollection

        drawn = m_to_mm(1.0) * self.view.flat(self.polygons)
        style: dict[str, Any] = {"facecolors": self.colours, "edgecolors": self.colours, "linewidths": self.widths}
        axes.add_collection(PolyCollection(list(drawn), zorder=2, **style))
        return np.asarray(drawn.reshape(-1, 2))


def _light(view: View) -> Floats:
    """Unit vector to the light, from beside the viewer, (3,)."""
    light = view.to_viewer + view.up - 0.6 * view.right
    return np.asarray(light / np.linalg.norm(light))


def _distance(one: Floats, other: Floats) -> float:
    """Least distance of points (p, 2) and (q, 2)."""
    return float(np.linalg.norm(one[:, None] - other, axis=-1).min())
