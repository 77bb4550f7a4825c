"""`pipenav robots`: the shipped robots, the numbers of one, its links as meshes, and all of it for engines."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.cli.terminal import say, show

if TYPE_CHECKING:
    from rich.table import Table

    from pipenav.robots.parts import Joint, Laser
    from pipenav.robots.robot import RobotSpec


def robots(
    name: Annotated[
        str | None, typer.Argument(help="Show the links of this robot, or of a robot.toml.", show_default=False)
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER|FILE",
            help="FILE.urdf, or FILE.mjcf or .xml for MuJoCo: write the robot for a physics engine. FOLDER: its links "
            "as STL meshes, in mm.",
        ),
    ] = None,
) -> None:
    """List the robots that can be trained and driven.

    Any other robot is named by the path of its robot.toml: pipenav train --robot my-robot/robot.toml

    The links of one robot, also as meshes: pipenav robots high-fidelity --out meshes

    A robot for other simulators: pipenav robots pirate --out pirate.urdf
    """
    from pipenav.robots.robot import load_robot

    if name is None:
        if out is not None:
            raise typer.BadParameter("--out needs the name of a robot, for example: pipenav robots basic --out meshes")
        show(robots_table())
        return
    robot = load_robot(name)
    show(robot.description, _links(robot), *filter(None, [_wheels(robot)]), f"laser: {_laser(robot.laser)}")
    if out is not None and out.suffix and not out.is_dir():
        from pipenav.export.robot_model import write_robot

        write_robot(robot, out)
        say(f"Made {out}")
    elif out is not None:
        from pipenav.robots.meshes import write_meshes

        say(f"Made {', '.join(str(path) for path in write_meshes(robot, out))}")


def robots_table() -> Table:
    """The shipped robots, a row each."""
    from rich.table import Table
    from rich.text import Text

    from pipenav.robots.robot import load_robot
    from pipenav.robots.variants import robot_names
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
    return table


def _links(robot: RobotSpec) -> Table:
    from rich.table import Table
    from rich.text import Text

    from pipenav.units import m_to_mm

    table = Table("link", "joint", box=None, pad_edge=False)
    for column in ("range", "top speed", "stall effort", "length [mm]", "width [mm]", "mass [g]", "parts"):
        table.add_column(Text(column), justify="right")
    for link in robot.links:
        table.add_row(
            Text(link.name, "bold"),
            *(_motion(robot, link.joint) if link.joint else ["none: stands free", "", "", ""]),
            f"{m_to_mm(link.length):g}",
            f"{m_to_mm(link.width):g}",
            f"{1e3 * link.mass:g}",
            str(len(link.parts)),
        )
    return table


def _motion(robot: RobotSpec, joint: Joint) -> list[str]:
    """A joint's name, range, top speed and stall effort."""
    from pipenav.units import m_to_mm, rad_to_deg

    actuator = robot.actuators[joint.actuator]
    edge, unit, force = (rad_to_deg, "deg", "N m") if joint.type == "hinge" else (m_to_mm, "mm", "N")
    return [
        f"{joint.name} ({joint.type})",
        f"{edge(joint.lower):.0f} to {edge(joint.upper):.0f} {unit}",
        f"{edge(actuator.speed_limit):.0f} {unit}/s",
        f"{actuator.effort_limit:.3g} {force}",
    ]


def _wheels(robot: RobotSpec) -> str:
    """Sentences about the wheels and the roll joint."""
    from pipenav.units import m_to_mm

    parts = []
    if robot.wheels:
        rims = sorted({wheel.radius * robot.actuators[wheel.actuator].speed_limit for wheel in robot.wheels})
        sizes = sorted({wheel.diameter for wheel in robot.wheels})
        parts.append(
            f"wheels: {len(robot.wheels)}, {', '.join(f'{m_to_mm(size):g}' for size in sizes)} mm, driven, "
            f"up to {', '.join(f'{m_to_mm(rim):g}' for rim in rims)} mm/s at the rim"
        )
    if robot.roll:
        parts.append(f"roll joint: {robot.roll.joint.name}, across {robot.roll.link}; held at 0 in a plane")
    return "\n".join(parts)


def _laser(laser: Laser) -> str:
    from pipenav.units import m_to_mm

    reach = f"{m_to_mm(laser.range_min):g}-{m_to_mm(laser.range_max):g} mm"
    return f"{laser.beams} beams over {laser.fan_deg:g} deg, {reach}"
