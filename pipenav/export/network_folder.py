"""The network folder: a whole network as JSON, mesh, MJCF, URDF, SDF and a picture. Format: docs/formats/network.md."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from pipenav.export.corner_folder import write_stl
from pipenav.export.scene_xml import Shape, sdf, urdf, write_xml
from pipenav.export.wall_files import wall_shapes, walls_mjcf, write_walls
from pipenav.pipes.network import PipeNetwork
from pipenav.pipes.pipe_system import Polygon, network_system
from pipenav.pipes.route_solids import BEND_DEVIATION, FACETS
from pipenav.pipes.system_solids import system_wall_pieces
from pipenav.pipes.system_tubes import system_tube_mesh
from pipenav.storage.atomic_folder import write_folder, write_record
from pipenav.units import m_to_mm

SCHEMA = 1
"""Version of the network folder's format."""

FILES = {
    "network.json": "nodes, pipes and wall, in m and mm",
    "tube.stl": "hollow tube of the whole network (mm)",
    "walls.obj": "the wall as convex pieces, one object each (m)",
    "walls": "folder of those pieces, one OBJ file each (m)",
    "pipe.xml": "MuJoCo model, walls as those pieces",
    "pipe.urdf": "URDF model, walls as the files in walls",
    "pipe.sdf": "SDF model, walls as the files in walls",
    "pipe.png": "picture with names, bores and lengths",
}
"""Files of a network folder, each with one line that describes it."""


def write_network_folder(network: PipeNetwork, name: str, out_root: Path) -> Path:
    """Write `<out_root>/<name>/`, complete or not at all, in place of an older folder of a network.

    Raises:
        FileProblem: the folder cannot be written.
        PipenavError: something that is not a network folder has that name.
    """
    folder = out_root / name
    write_folder(folder, "network folder", "network.json", FILES, lambda draft: _write_files(network, name, draft))
    return folder


def network_record(network: PipeNetwork, name: str) -> dict[str, Any]:
    """The content of network.json. The SI numbers count; the ones in mm repeat them for people."""
    nodes = {
        node_name: {
            "position_m": list(node.position),
            "bend_radius_m": node.bend_radius,
            "reducer_m": node.length,
            "capped": node.capped,
            "pipes": len(network.pipes_at(node_name)),
        }
        for node_name, node in network.nodes.items()
    }
    pipes = [
        {"from": pipe.start, "to": pipe.end, "diameter_m": pipe.diameter, "diameter_mm": m_to_mm(pipe.diameter)}
        for pipe in network.pipes
    ]
    return {"schema": SCHEMA, "name": name, "wall_m": network.wall, "nodes": nodes, "pipes": pipes}


def _write_files(network: PipeNetwork, name: str, folder: Path) -> None:
    from pipenav.drawing.network import draw_network

    system = network_system(network)
    parts = system_wall_pieces(system, Polygon(FACETS), network.wall, BEND_DEVIATION)
    walls = {f"wall_{number}": part for number, part in enumerate(parts, 1)}
    pieces, seen = wall_shapes(walls), [Shape("all", "mesh", "walls.obj")]
    write_record(folder / "network.json", network_record(network, name))
    write_stl(folder / "tube.stl", system_tube_mesh(system))
    write_walls(folder, walls)
    points = np.array([node.position for node in network.nodes.values()])
    write_xml(folder / "pipe.xml", walls_mjcf(name, walls, points))
    write_xml(folder / "pipe.urdf", urdf(name, pieces, seen))
    write_xml(folder / "pipe.sdf", sdf(name, pieces, seen))
    draw_network(network, name, folder / "pipe.png")
