"""Routes and networks with tees, crosses, reducers, bends and caps, of which pictures are drawn."""

from __future__ import annotations

import math

from pipenav.pipes.branch import Branch
from pipenav.pipes.network import NetworkNode, NetworkPipe, PipeNetwork
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner, corner_of, reducer_corner
from pipenav.pipes.route_ends import RouteEnds


def fitted(roll_deg: float, capped: bool = True) -> PipeRoute:
    """An elbow, a tee, a reducer, a cross and a mitre in a row; the tee and the cross are rolled."""
    roll = math.radians(roll_deg)
    side = Branch(angle=math.radians(60), turn="right", roll=roll, diameter=0.06, length=0.3)
    on = Branch(angle=math.pi, diameter=0.08, length=0.3, closed=True)
    left = Branch(angle=math.pi / 2, turn="left", roll=roll, diameter=0.08, length=0.25)
    corners = (
        corner_of(90, "left", 0, 150),
        Corner(angle=math.pi, branches=(side,)),
        reducer_corner(80, 60),
        Corner(angle=math.pi / 2, turn="right", roll=roll, branches=(on, left)),
        corner_of(75, "left"),
    )
    return PipeRoute.with_default_straights(
        0.1, corners, [500, 610, 520, 530, 440, 550], 0.003, RouteEnds(capped=capped)
    )


PLANE, SPACE = fitted(0), fitted(90)


def network(height: float) -> PipeNetwork:
    """A tee and a reducer; one end lies above the others [m]."""
    places = {
        "inlet": (0.0, 0.0, 0.0),
        "tee": (1.5, 0.0, 0.0),
        "reducer": (3.0, 0.0, 0.0),
        "end": (4.0, 0.0, 0.0),
        "bend": (1.5, 1.2, 0.0),
        "top": (0.5, 1.2, height),
    }
    nodes = {name: NetworkNode(position=at) for name, at in places.items()}
    nodes["bend"] = nodes["bend"].model_copy(update={"bend_radius": 0.15})
    nodes["reducer"] = nodes["reducer"].model_copy(update={"length": 0.06})
    nodes["top"] = nodes["top"].model_copy(update={"capped": True})
    pipes = [("inlet", "tee", 0.1), ("tee", "reducer", 0.1), ("reducer", "end", 0.06), ("tee", "bend", 0.08)]
    pipes.append(("bend", "top", 0.08))
    return PipeNetwork(nodes=nodes, pipes=tuple(NetworkPipe(start=a, end=b, diameter=d) for a, b, d in pipes))
