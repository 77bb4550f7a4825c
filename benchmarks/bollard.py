"""The bollard test: travel and pull of robots on wheels in straight, level pipes, and the cable that they haul.

A robot clamps as a zigzag and turns its wheels at full speed. Travel is its speed without a load; the pull is the force
with which it stretches a spring behind it until it stands. What its motors allow is the pull of all wheels at
standstill; where the measured one is less, its tyres slip. `--friction` gives the tyres another grip.
"""

from __future__ import annotations

import argparse
import math

from pipenav.robots import traction
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.traverse.tether import TetherConfig
from pipenav.testing import Haulage

FRICTIONS = {"PVC": 0.3, "corroded steel": 0.6}
"""Friction of a cable in pipes."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", action="append", help="a robot on wheels; default: pirate and pirate-strong")
    parser.add_argument("--backend", default="mujoco", help="a simulator in which forces can pull")
    parser.add_argument("--diameter", type=float, nargs="+", default=[70.0, 100.0, 120.0], help="bores [mm]")
    parser.add_argument("--friction", type=float, nargs="+", help="friction of the tyres; default: the robot's own")
    given = parser.parse_args()
    print("robot            tyres  bore [mm]  motors [N]  pull [N]  travel [mm/s]  hauls in PVC / corroded steel [m]")
    for name in given.robot or ["pirate", "pirate-strong"]:
        for friction in given.friction or [None]:
            robot = with_friction(load_robot(name), friction)
            for diameter in given.diameter:
                row(robot, given.backend, diameter)


def with_friction(robot: RobotSpec, friction: float | None) -> RobotSpec:
    """The robot with another friction of its tyres."""
    if friction is None:
        return robot
    links = [
        link.model_copy(update={"wheel": link.wheel and link.wheel.model_copy(update={"friction": friction})})
        for link in robot.links
    ]
    return robot.model_copy(update={"links": tuple(links)})


def row(robot: RobotSpec, backend: str, diameter: float) -> None:
    subject = Haulage(robot, backend, diameter)
    pulled, travel, motors = subject.bollard_pull(), subject.speed(), traction.pull(robot)
    cable = [math.floor(pulled / TetherConfig(friction=friction).per_metre) for friction in FRICTIONS.values()]
    tyres = robot.wheels[0].friction
    print(
        f"{robot.name:15}  {tyres:5.2f}  {diameter:9.0f}  {motors:10.1f}  {pulled:8.2f}  {1e3 * travel:13.1f}  "
        f"{cable[0]:6} / {cable[1]}"
    )


if __name__ == "__main__":
    main()
