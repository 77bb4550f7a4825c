"""`pipenav robots`: the shipped robots."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipenav.cli import table_console

if TYPE_CHECKING:
    from pipenav.robot import Laser


def robots() -> None:
    """List the robots that can be trained and driven.

    Any other robot is named by the path of its robot.toml: pipenav train --robot my-robot/robot.toml
    """
    from rich.table import Table
    from rich.text import Text

    from pipenav.robot import load_robot, robot_names
    from pipenav.units import m_to_mm

    table = Table("robot", "joints", box=None, pad_edge=False)
    for column in ("length [mm]", "width [mm]"):
        table.add_column(Text(column), justify="right")  # a plain string's [mm] would be taken for markup
    table.add_column("laser")
    table.add_column("description")
    for name in robot_names():
        robot = load_robot(name)
        joints = ", ".join(joint.name for joint in robot.joints)
        length, width = f"{m_to_mm(robot.length):g}", f"{m_to_mm(robot.width):g}"
        table.add_row(Text(name, "bold"), joints, length, width, _laser(robot.laser), Text(robot.description))
    table_console().print(table)


def _laser(laser: Laser) -> str:
    from pipenav.units import m_to_mm

    reach = f"{m_to_mm(laser.range_min):g}-{m_to_mm(laser.range_max):g} mm"
    return f"{laser.beams} beams over {laser.fan_deg:g} deg, {reach}"
