"""Pictures of a robot in several planes."""

from __future__ import annotations

import numpy as np
from helpers.rolling import ROBOT

from pipenav.recording.rolling_film import SIDES, faces


def test_a_robot_is_drawn_in_its_halves_planes() -> None:
    """Every face of a straight robot lies around it at the links' width and height, turned with the half's plane."""
    points = np.zeros((len(ROBOT.links) + 1, 3))
    points[1:, 0] = np.cumsum(ROBOT.lengths)
    links, wheels, half = faces(ROBOT, points, np.array([[0.0, 0, 1], [0, -1, 0]]))
    pieces = len(ROBOT.links) + 1  # the roll joint divides one
    assert links.shape == (6 * pieces, 4, 3) and len(wheels) == len(ROBOT.wheels)
    assert list(half) == [0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1]
    width, height = ROBOT.links[0].width, ROBOT.links[0].height
    sizes = np.ptp(links.reshape(pieces, -1, 3), axis=1)[:, 1:]
    np.testing.assert_allclose(sizes, [[width, height]] * 4 + [[height, width]] * 4)
    for disc, of in zip(wheels, half[pieces:], strict=True):
        assert disc.shape == (SIDES, 3)
        np.testing.assert_allclose(disc[:, 2 if of == 0 else 1], 0.0, atol=1e-12)
