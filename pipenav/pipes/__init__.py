"""Pipes: one corner or a route of several, their walls, solids and named sets."""

from pipenav.pipes.branch import Branch
from pipenav.pipes.centre_lines import CentreLines, LegCoordinates
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import corner_set_names, parse_corners
from pipenav.pipes.corner_solids import Box, Mesh, boards_mesh, corner_boxes, tube_mesh
from pipenav.pipes.json_keys import PipeInFile
from pipenav.pipes.pipe import LegFrames, Pipe, Turn, WallSide
from pipenav.pipes.rotations import about_x
from pipenav.pipes.route import PipeRoute, as_route
from pipenav.pipes.route_checks import CrossesItself
from pipenav.pipes.route_corner import Corner
from pipenav.pipes.route_sets import NamedRoute, parse_pipes, parse_routes, route_set_names
from pipenav.pipes.route_solids import route_boards_mesh, route_tube_mesh, wall_prisms
from pipenav.pipes.solid_walls import WallSolids, wall_solids

__all__ = [
    "Box",
    "Branch",
    "CentreLines",
    "Corner",
    "CrossesItself",
    "LegCoordinates",
    "LegFrames",
    "Mesh",
    "NamedRoute",
    "Pipe",
    "PipeCorner",
    "PipeInFile",
    "PipeRoute",
    "Turn",
    "WallSide",
    "WallSolids",
    "about_x",
    "as_route",
    "boards_mesh",
    "corner_boxes",
    "corner_set_names",
    "parse_corners",
    "parse_pipes",
    "parse_routes",
    "route_boards_mesh",
    "route_set_names",
    "route_tube_mesh",
    "tube_mesh",
    "wall_prisms",
    "wall_solids",
]
