"""Pipes within 6 mm of the shipped robots' frontiers: `python benchmarks/frontier_sets.py --out pipes`, some 5 minutes.

For each angle, six bores 1 mm apart from the smallest one on that `pipenav.certify` finds passable, to either side,
each with a motion of its own. Mitres between boards. `frontier-ROBOT.toml` has every 10 deg and bores of a quarter of a
millimetre more than a whole one; `frontier-ROBOT-train.toml` has the angles 2.5 and 7.5 deg beside and bores of three
quarters more. So the two share no bore and no angle, and none of their pipes is in any other shipped set. At the angles
of the latter `wider-pirate-train.toml` has bores from 6 mm above the shipped frontier up to 130 mm.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipenav.certify import verdict
from pipenav.certify.frontier import shipped_frontier
from pipenav.certify.model import Model
from pipenav.certify.needed_bore import narrowest
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Turn
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.storage.atomic_files import atomic_write
from pipenav.units import m_to_mm

ROBOTS = ("basic", "real-setup", "high-fidelity", "pirate")
BORES = 6
"""Bores at each angle, 1 mm apart: the next smaller one has no motion, so that all are within 6 mm of the frontier."""
WIDE_MM = 130
"""Largest bore of the wider set."""
WIDEST_MM = 100
"""Bore that every shipped robot passes at every angle."""


class Kind(NamedTuple):
    """A kind of set: what its name and description end in, its angles [deg], and a bore's part of a millimetre."""

    name: str
    use: str
    angles: Sequence[float]
    part: float


KINDS = (
    Kind("", "", np.arange(40.0, 141.0, 10.0).tolist(), 0.25),
    Kind("-train", ", for training", np.arange(42.5, 140.0, 5.0).tolist(), 0.75),
)


def symmetric(robot: RobotSpec) -> bool:
    """Whether a robot is its own mirror image: then a motion to the left shows one to the right."""
    limits = [(joint.lower, joint.upper) for joint, hinge in zip(robot.joints, robot.hinges, strict=True) if hinge]
    return all(part.y == 0 for link in robot.links for part in link.outline) and all(a == -b for a, b in limits)


def passable(robot: RobotSpec, diameter: float, angle: float) -> bool:
    """Whether there is a motion through the corner [mm, deg], to either side: in the mirror it is the same motion."""
    turns: tuple[Turn, ...] = ("left",) if symmetric(robot) else ("left", "right")
    return all(verdict.passable(Model(robot, PipeCorner.of(diameter, angle, turn)), None) is not None for turn in turns)


def bores(robot: RobotSpec, angle: float, part: float, expected: float) -> list[float]:
    """The passable bores nearest to the frontier, of which the smallest is expected near some bore [mm]."""
    least = math.ceil(m_to_mm(narrowest(robot)) - part) + part
    lowest = max(least, math.floor(expected) + part)
    while lowest > least and passable(robot, lowest - 1, angle):
        lowest -= 1
    found: list[float] = []
    for diameter in np.arange(lowest, WIDEST_MM).tolist():
        if passable(robot, diameter, angle):
            found.append(diameter)
        elif found:  # a motion below and none here: those below are no frontier that can be told
            found.clear()
        if len(found) == BORES:
            break
    return found


def text(description: str, rows: Mapping[float, Sequence[float]]) -> str:
    """A set as TOML: its bores at each angle [mm, deg]."""
    lines = [f'description = "{description}"', 'turns = ["left", "right"]']
    for angle, diameters in rows.items():
        lines += ["", "[[rows]]", f"angle_deg = {angle:g}", f"diameters_mm = {list(diameters)}"]
    return "\n".join(lines) + "\n"


def near(robot: RobotSpec, kind: Kind) -> dict[float, list[float]]:
    """Bores near the frontier at each angle [mm, deg]."""
    rows, expected = {}, float(WIDEST_MM)
    for angle in kind.angles:
        found = bores(robot, angle, kind.part, expected)
        expected = found[0]
        print(f"{robot.name}{kind.name}: {angle:g} deg, from {found[0]:g} mm", flush=True)
        rows[angle] = found
    return rows


def wider(robot: RobotSpec, angles: Sequence[float]) -> dict[float, list[float]]:
    """Bores at each angle beyond those near the frontier [mm, deg]; the shipped frontier between its angles."""
    frontier = shipped_frontier(robot, "plane", 0.0)
    assert frontier is not None
    least = {angle: frontier.passable(angle) for angle in angles}
    return {
        angle: np.arange(math.ceil(bore + 6.5) + 0.25, WIDE_MM, 4.0).tolist()
        for angle, bore in least.items()
        if bore is not None
    }


def main() -> None:
    """Write the sets."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", action="append", help="a robot; repeatable; default: the four shipped shapes")
    parser.add_argument("--out", type=Path, required=True, help="folder for the sets")
    given = parser.parse_args()
    for robot in map(load_robot, given.robot or ROBOTS):
        for kind in KINDS:
            rows, words = near(robot, kind), f"within 6 mm of the smallest that {robot.name} passes{kind.use}"
            atomic_write(given.out / f"frontier-{robot.name}{kind.name}.toml", text(f"passable mitres {words}", rows))
        if robot.name == "pirate":
            words = (
                f"mitres of up to {WIDE_MM} mm, 6 mm and more wider than the smallest that pirate passes, for training"
            )
            atomic_write(given.out / "wider-pirate-train.toml", text(words, wider(robot, list(rows))))


if __name__ == "__main__":
    main()
