"""The reach of an arm in the bends of a set, and why it is no longer: `python benchmarks/bend_reach.py`.

Starts and depths are those of the task, drawn anew. A target past the end of a bend is out of reach for certain where a
string from the first hinge to it, pulled taut around the inner wall, is longer than the hinged links: with the slide
just short of what counts as its limit, half the thinnest link beside the wall, and the tip within its tolerance.
"""

from __future__ import annotations

import argparse
import math
from collections import defaultdict

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import parse_corners
from pipenav.robots.bend_reach import Bends, reach_along
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.reach.config import ReachConfig
from pipenav.units import m_to_mm, rad_to_deg

TASK = ReachConfig()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="basic", help="a shipped arm")
    parser.add_argument("--pipes", default="elbows", help="a set of bends")
    parser.add_argument("--draws", type=int, default=20, help="starts and depths per pipe")
    given = parser.parse_args()
    robot, rng = load_robot(given.robot), np.random.default_rng(0)
    rows: dict[tuple[float, float], list[Floats]] = defaultdict(list)
    for pipe in parse_corners([given.pipes]):
        if pipe.turn == "left" and pipe.bend_radius:
            key = round(pipe.bend_radius / pipe.diameter, 3), round(180 - rad_to_deg(pipe.angle), 1)
            rows[key] += [draw(robot, pipe, rng) for _ in range(given.draws)]
    print("radius [D]  turn [deg]  nearer [%], by [mm]  out of reach by the string [%]  reach past the end [mm]")
    for (times, turn), found in sorted(rows.items()):
        missing, out, past = np.array(found).T
        nearer = missing[missing > 0]
        by = m_to_mm(float(nearer.mean())) if len(nearer) else 0.0
        ends = f"{m_to_mm(float(past.min())):.0f} to {m_to_mm(float(past.max())):.0f}"
        share = 100 * np.mean(missing > 0)
        print(f"{times:10g}  {turn:10g}  {share:10.0f}, {by:7.0f}  {100 * out.mean():30.0f}  {ends}")


def draw(robot: RobotSpec, pipe: PipeCorner, rng: np.random.Generator) -> Floats:
    """Facts of a draw: what the reach lacks [m], whether the string is too long, and the reach past the bend [m]."""
    gap, depth = rng.uniform(*TASK.start_gap), rng.uniform(*TASK.target_depth)
    bends = Bends(np.array([pipe.radius]), np.array([pipe.bend_radius]), np.array([math.pi - pipe.angle]))
    base = -gap - robot.length
    reach = float(reach_along(robot, bends, np.array([base]))[0])
    end = float(bends.end[0])
    travel = TASK.limit_margin * float((robot.upper - robot.lower)[0])
    hinge = np.array([base + robot.lengths[0] + robot.upper[0] - travel, 0.0])
    target = bends.points(np.array([end + depth]), np.zeros(1))[0]
    string = taut_string(bends, hinge, target, min(link.width for link in robot.links) / 2)
    out = string - TASK.reach_tolerance > robot.lengths[1:].sum()
    return np.array([max(end + depth - reach, 0.0), out, reach - end])


def taut_string(bends: Bends, start: Floats, end: Floats, keep_off: float) -> float:
    """Length of a string between two points, (2,) each, pulled taut around a bend's inner wall [m].

    Args:
        bends: the bend, k = 1.
        start: a point before the bend, in the bend's frame.
        end: a point past it.
        keep_off: distance of the string from the wall [m].
    """
    turning, radius = np.array([0.0, bends.middle_radius[0]]), bends.middle_radius[0] - bends.radius[0] + keep_off
    a, b = start - turning, end - turning
    far = [max(float(np.linalg.norm(point)), radius) for point in (a, b)]
    between = (math.atan2(b[1], b[0]) - math.atan2(a[1], a[0])) % (2 * math.pi)
    touching = between - sum(math.acos(radius / away) for away in far)
    if touching <= 0:
        return float(np.linalg.norm(end - start))
    return float(radius * touching + sum(math.sqrt(away**2 - radius**2) for away in far))


if __name__ == "__main__":
    main()
