"""Robots: their description, the poses of their links, the readings of their laser."""

from pipenav.robots import bodies, frames, kinematics, laser, space_kinematics
from pipenav.robots.kinematics import ChainPose
from pipenav.robots.parts import Actuator, BoxPart, DiscPart, Joint, Laser, Link, Roll, Wheel
from pipenav.robots.robot import BASE, RobotSpec, load_robot
from pipenav.robots.variants import robot_names

__all__ = [
    "BASE",
    "Actuator",
    "BoxPart",
    "ChainPose",
    "DiscPart",
    "Joint",
    "Laser",
    "Link",
    "RobotSpec",
    "Roll",
    "Wheel",
    "bodies",
    "frames",
    "kinematics",
    "laser",
    "load_robot",
    "robot_names",
    "space_kinematics",
]
