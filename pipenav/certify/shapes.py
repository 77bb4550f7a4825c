"""Outlines of a robot's links as boxes and discs in arrays: what proofs and motions are computed from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.robots.parts import BoxPart
from pipenav.robots.robot import RobotSpec


class Boxes(NamedTuple):
    """Boxes of a robot's links.

    Attributes:
        link: index of the link that carries each box, (boxes,).
        centre: middle in the link's frame, (boxes, 2) [m].
        half: half length and half width, (boxes, 2) [m].
        height: size across the robot's plane, (boxes,) [m].
    """

    link: Ints
    centre: Floats
    half: Floats
    height: Floats


class Discs(NamedTuple):
    """Discs of a robot's links, wheels among them.

    Attributes:
        link: index of the link that carries each disc, (discs,).
        centre: middle in the link's frame, (discs, 2) [m].
        radius: radius in the robot's plane, (discs,) [m].
        height: size across the robot's plane, (discs,) [m].
    """

    link: Ints
    centre: Floats
    radius: Floats
    height: Floats


class Shapes(NamedTuple):
    """All parts of a chain of links; the chain may be a stretch of a robot's.

    Attributes:
        boxes: the boxes.
        discs: the discs.
        lengths: lengths of the links, (links,) [m].
    """

    boxes: Boxes
    discs: Discs
    lengths: Floats

    def inflated(self, margin: float) -> Shapes:
        """The parts made larger by a margin all around, for motions that keep their distance [m]."""
        boxes = self.boxes._replace(half=self.boxes.half + margin)
        return self._replace(boxes=boxes, discs=self.discs._replace(radius=self.discs.radius + margin))

    def eroded(self, by: float) -> Shapes:
        """The parts made smaller by as much as they may overlap with a wall; a line or a point is the least [m]."""
        half = np.maximum(self.boxes.half - by, 0.0)
        discs = self.discs._replace(radius=np.maximum(self.discs.radius - by, 0.0))
        return self._replace(boxes=self.boxes._replace(half=half), discs=discs)

    def stretch(self, first: int, last: int) -> Shapes:
        """The chain of links `first` to `last`, with the wheel that the next link has on its joint.

        A disc around a joint belongs to both links that meet there.
        """
        boxes, discs = self.boxes, self.discs
        kept = (boxes.link >= first) & (boxes.link <= last)
        inside = (discs.link >= first) & (discs.link <= last)
        at_end = (discs.link == last + 1) & (np.abs(discs.centre) < 1e-9).all(axis=1)
        centre = discs.centre + np.where(at_end[:, None], [self.lengths[last], 0.0], 0.0)
        link = np.where(at_end, last, discs.link)
        shorter = Discs(link - first, centre, discs.radius, discs.height)
        return Shapes(
            Boxes(boxes.link[kept] - first, boxes.centre[kept], boxes.half[kept], boxes.height[kept]),
            Discs(*(column[inside | at_end] for column in shorter)),
            self.lengths[first : last + 1],
        )


def shapes_of(robot: RobotSpec, turn_sign: float = 1.0) -> Shapes:
    """Parts of a robot, seen in the canonical frame of a corner.

    Args:
        robot: the robot.
        turn_sign: +1 for a left turn, -1 for a right one, in which the robot is reflected.
    """
    found = [(i, part) for i, link in enumerate(robot.links) for part in link.outline]
    boxes = [(i, part) for i, part in found if isinstance(part, BoxPart)]
    discs = [(i, part) for i, part in found if not isinstance(part, BoxPart)]
    return Shapes(
        Boxes(
            np.array([i for i, _ in boxes], np.intp),
            np.array([[part.x, turn_sign * part.y] for _, part in boxes]).reshape(-1, 2),
            np.array([[part.length / 2, part.width / 2] for _, part in boxes]).reshape(-1, 2),
            np.array([part.height for _, part in boxes]),
        ),
        Discs(
            np.array([i for i, _ in discs], np.intp),
            np.array([[part.x, turn_sign * part.y] for _, part in discs]).reshape(-1, 2),
            np.array([part.width / 2 for _, part in discs]),
            np.array([part.height for _, part in discs]),
        ),
        np.array(robot.lengths),
    )
