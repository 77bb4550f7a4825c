"""What a pipe is: one corner or a route of several, its walls, solids and named sets."""

from pipenav.pipes.centre_lines import CentreLines, LegCoordinates
from pipenav.pipes.corner import PipeCorner, Turn
from pipenav.pipes.corner_sets import parse_pipes, pipe_set_names
from pipenav.pipes.corner_solids import Box, Mesh, boards_mesh, tube_mesh, wall_boxes
from pipenav.pipes.json_keys import PipeInFile
from pipenav.pipes.pipe import LegFrames, Pipe, WallSide
from pipenav.pipes.route import Corner, CrossesItself, PipeRoute
from pipenav.pipes.route_legs import about_x
from pipenav.pipes.route_sets import parse_any, parse_routes, route_set_names
from pipenav.pipes.route_solids import route_boards_mesh, route_tube_mesh, wall_prisms

__all__ = [
    "Box",
    "CentreLines",
    "Corner",
    "CrossesItself",
    "LegCoordinates",
    "LegFrames",
    "Mesh",
    "Pipe",
    "PipeCorner",
    "PipeInFile",
    "PipeRoute",
    "Turn",
    "WallSide",
    "about_x",
    "boards_mesh",
    "parse_any",
    "parse_pipes",
    "parse_routes",
    "pipe_set_names",
    "route_boards_mesh",
    "route_set_names",
    "route_tube_mesh",
    "tube_mesh",
    "wall_boxes",
    "wall_prisms",
]
