"""A robot's links as meshes, made from the parts that its description lists."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pipenav.robots.parts import BoxPart, Link
from pipenav.robots.robot import RobotSpec
from pipenav.storage.atomic_files import atomic_write_all, prepare_folder
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    import trimesh

ROUND_SECTIONS = 96
"""Sides of the prism that stands for a disc: within 0.02 mm of a disc of 40 mm."""


def link_mesh(link: Link) -> trimesh.Trimesh:
    """Parts of a link as closed shells [m] in the link's frame: x from the joint along the link, z across the plane."""
    import trimesh

    shells = []
    for part in link.parts:
        if isinstance(part, BoxPart):
            shell = trimesh.creation.box((part.length, part.width, part.height))
        else:
            shell = trimesh.creation.cylinder(part.diameter / 2, part.height, ROUND_SECTIONS)
        shell.apply_translation((part.x, part.y, 0.0))
        shells.append(shell)
    return trimesh.util.concatenate(shells)


def write_meshes(robot: RobotSpec, folder: Path) -> list[Path]:
    """Write `<link>.stl` of every link, in millimetres as printers read it.

    Raises:
        FileProblem: a file cannot be written.
    """
    prepare_folder(folder)
    files = {}
    for link in robot.links:
        mesh = link_mesh(link)
        mesh.apply_scale(m_to_mm(1.0))
        files[folder / f"{link.name}.stl"] = mesh.export(file_type="stl")
    atomic_write_all(files)
    return list(files)
