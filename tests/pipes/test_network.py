"""Networks of pipes: the routes through them, their files, and what is refused."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from helpers.pipe_oracle import PipeOracle
from helpers.random_networks import random_network, ways_through
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.errors import ConfigError, PipenavError
from pipenav.pipes.network import NetworkNode, NetworkPipe, PipeNetwork
from pipenav.pipes.network_file import read_network, read_network_routes

seeds = st.integers(0, 2**31 - 1)

SURE = 2e-4
"""Distance from a surface at which steps, which are short cones, differ no more [m]."""


def own_frame(network: PipeNetwork, way: list[str]) -> tuple[Floats, Floats]:
    """Origin and axes as columns of a route's frame: x along its first leg, y level."""
    first, second = (np.array(network.nodes[name].position) for name in way[:2])
    along = (second - first) / np.linalg.norm(second - first)
    left = np.cross([0.0, 0.0, 1.0], along)
    left /= np.linalg.norm(left)
    return second, np.stack([along, left, np.cross(along, left)], axis=1)


@given(seeds)
@settings(max_examples=25, deadline=None)
def test_routes_lie_where_the_nodes_are(seed: int) -> None:
    network = random_network(seed, 3)
    for way in ways_through(network)[:5]:
        origin, axes = own_frame(network, way)
        nodes = np.array([network.nodes[name].position for name in way])
        route = network.route(way)
        np.testing.assert_allclose(origin + route.centre_line @ axes.T, nodes, atol=1e-7)
        bores = [network.pipe_between(*pair).diameter / 2 for pair in pairwise(way)]
        np.testing.assert_allclose(route.legs.radius, bores)


@given(seeds)
@settings(max_examples=15, deadline=None)
def test_two_ways_in_opposite_directions_are_each_others_reverse(seed: int) -> None:
    network = random_network(seed, 2)
    whole = PipeOracle.of_network(network)
    points = whole.around(600, np.random.default_rng(seed))
    for way in ways_through(network)[:3]:
        if network.nodes[way[-1]].capped:
            continue
        inside, sure = [], np.abs(whole.bore(points)) > SURE
        for names in (way, way[::-1]):
            origin, axes = own_frame(network, names)
            route, seen = network.route(names), (points - origin) @ axes
            inside.append(route.contains(seen))
            sure &= np.abs(PipeOracle.of_route(route).bore(seen)) > SURE
        assert (inside[0] == inside[1])[sure].all()
        assert not (inside[0] & (whole.bore(points) > SURE)).any()
        assert inside[0].any()


@given(seeds)
@settings(max_examples=25, deadline=None)
def test_a_network_is_the_same_when_its_file_is_read(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    network = random_network(seed, 3)
    ways = {f"way {i}": way for i, way in enumerate(ways_through(network)[:3])}
    file = tmp_path_factory.mktemp("network") / "network.toml"
    file.write_text(as_toml(network, ways))
    read = read_network(file)
    assert read.pipes == network.pipes or _close(read, network)
    assert list(read.nodes) == list(network.nodes)
    if ways:
        routes = read_network_routes(file)
        assert {name: route.name for name, route in routes.items()} == {
            name: read.route(way).name for name, way in ways.items()
        }
        for name, way in ways.items():
            np.testing.assert_allclose(routes[name].centre_line, network.route(way).centre_line, atol=1e-9)


def _close(one: PipeNetwork, other: PipeNetwork) -> bool:
    """Whether two networks differ by the rounding from metres to millimetres and back alone."""
    pipes = zip(one.pipes, other.pipes, strict=True)
    same = all(a.start == b.start and a.end == b.end and math.isclose(a.diameter, b.diameter) for a, b in pipes)
    return same and math.isclose(one.wall, other.wall)


def as_toml(network: PipeNetwork, ways: dict[str, list[str]]) -> str:
    """A network as the file that people write."""
    lines = ["schema = 1", f"wall_mm = {1000 * network.wall!r}"]
    for name, node in network.nodes.items():
        lines += [f"[nodes.{name}]", f"at_mm = {[1000 * x for x in node.position]}"]
        lines += [f"bend_radius_mm = {1000 * node.bend_radius!r}", f"reducer_mm = {1000 * node.length!r}"]
        lines += [f"capped = {str(node.capped).lower()}"]
    for pipe in network.pipes:
        lines += ["[[pipes]]", f'from = "{pipe.start}"', f'to = "{pipe.end}"', f"diameter_mm = {1000 * pipe.diameter}"]
    return "\n".join([*lines, "[routes]", *(f'"{name}" = {way}'.replace("'", '"') for name, way in ways.items())])


Places = dict[str, list[float]]
Pipes = list[tuple[str, str, float]]

TEE: Places = {"a": [-600, 0], "t": [0, 0], "b": [600, 0], "c": [0, 600]}
THREE: Pipes = [("a", "t", 100), ("t", "b", 100), ("t", "c", 100)]
ELBOW: Places = {"a": [-600, 0], "t": [0, 0], "b": [0, 600]}
LINE: Places = {"a": [-600, 0], "t": [0, 0], "b": [600, 0]}
TWO: Pipes = [("a", "t", 100), ("t", "b", 100)]
SQUARE: Places = {"t": [0, 0], "u": [900, 0], "v": [900, 900], "w": [0, 900]}
AROUND: Pipes = [("t", "u", 80), ("u", "v", 80), ("v", "w", 80), ("w", "t", 80)]


def text(nodes: Places, pipes: Pipes, routes: str = "", **fields: str) -> str:
    """A network file; `fields` are lines for nodes by name, `top` those before them."""
    lines = ["schema = 1", fields.get("top", "")]
    for name, place in nodes.items():
        lines += [f"[nodes.{name}]", f"at_mm = {place}", fields.get(name, "")]
    for start, end, diameter in pipes:
        lines += ["[[pipes]]", f'from = "{start}"', f'to = "{end}"', f"diameter_mm = {diameter}"]
    return "\n".join([*lines, *(["[routes]", routes] if routes else [])])


NAN = float("nan")

REFUSED = {
    "wide branch": (
        text(TEE, [*THREE[:2], ("t", "c", 110)]),
        r"whose corner 1 is 't': diameter of a branch at corner 1 \(at most its run's\), 110 mm, .* 40 to 100 mm",
    ),
    "narrow angle": (
        text({**TEE, "c": [600, 200]}, THREE),
        "'t': angle between a branch at corner 1 and its run .* deg is out of range: choose 30 to 150 deg",
    ),
    "overlapping fittings": (
        text(
            {**TEE, "s": [100, 0], "e": [100, 600]},
            [("a", "t", 100), ("t", "s", 100), ("s", "b", 100), ("t", "c", 100), ("s", "e", 100)],
        ),
        "2 is 's': length of straight 2, 100 mm, is out of range: choose 116 to 20000 mm",
    ),
    "no run": (text({**TEE, "c": [-300, 400], "b": [500, 400]}, THREE), "corner 1 is 't': corner 1 has no run"),
    "twice": (text(TEE, THREE, 'x = ["a", "t", "c", "t"]'), "the route comes to 't' twice: name each node once"),
    "nowhere": (text(TEE, THREE, 'x = ["a", "t", "x"]'), "unknown node 'x': choose 'a', 'b', 'c' or 't'"),
    "no pipe": (text(TEE, THREE, 'x = ["a", "b", "t"]'), "no pipe leads from 'b' to 'a': from there pipes lead to t"),
    "two nodes": (text(TEE, THREE, 'x = ["a", "t"]'), "a route needs three nodes or more"),
    "a cap first": (
        text(TEE, THREE, 'x = ["a", "t", "b"]', a="capped = true"),
        "the route begins in 'a', which a cap closes: begin in an open end",
    ),
    "no route": (text(TEE, THREE), r"names no route: add a table \[routes\]"),
    "crossing": (
        text({**TEE, "b": [2000, 0], "d": [1500, -400], "e": [1500, 600]}, [*THREE, ("c", "e", 100), ("e", "d", 100)]),
        "the network crosses itself: the pipes t to b and e to d would touch or nearly touch",
    ),
    "a sharp bend": (
        text(ELBOW, TWO, t="bend_radius_mm = 40"),
        r"'t': bend radius of corner 1 \(0 is a mitre\), 40 mm, is out of range: choose 75 to 3000 mm",
    ),
    "a wide bend": (text(ELBOW, TWO, t="bend_radius_mm = 900"), "straight 1, 600 mm, .* choose 910 to 20000 mm"),
    "five": (
        text({**TEE, "d": [0, -600], "e": [0, 0, 600]}, [*THREE, ("t", "d", 100), ("t", "e", 100)]),
        "5 pipes meet in node 't': choose 1 to 4",
    ),
    "a capped tee": (text(TEE, THREE, t="capped = true"), "node 't' is capped, but 3 pipes meet there"),
    "a bent tee": (text(TEE, THREE, t="bend_radius_mm = 90"), "node 't' has a bend radius .* and 3 pipes meet there"),
    "two pieces": (text({**TEE, "x": [0, 3000], "y": [600, 3000]}, [*THREE, ("x", "y", 100)]), "from 'a' to 'x': join"),
    "a ring": (text(SQUARE, AROUND), "the network has no open end, so that no robot gets in: open a ring"),
    "only caps": (text(LINE, TWO, a="capped = true", b="capped = true"), "no open end, .* leave out a cap"),
    "a ring at one tee": (
        text({**SQUARE, "a": [-900, 0]}, [*AROUND, ("a", "t", 80)]),
        "a ring leads from 't' by .* back to 't': let it end in another tee or cross",
    ),
    "schema 2": (text(TEE, THREE).replace("schema = 1", "schema = 2"), "schema: input should be 1, given 2"),
    "no schema": (text(TEE, THREE).replace("schema = 1", ""), "schema: this key is missing, add it"),
    "NaN": (text({**TEE, "b": [NAN, 0]}, THREE), "x of node 'b', nan m, is out of range: choose -1000 to 1000 m"),
    "infinite": (text({**TEE, "b": [0, math.inf]}, THREE), "y of node 'b', inf m, is out of range"),
    "huge": (text({**TEE, "b": [1e300, 0]}, THREE), r"x of node 'b', 1e\+297 m, is out of range"),
    "huge whole number": (text(TEE, THREE).replace("600", "1" + 400 * "0"), "the largest that is allowed is"),
    "NaN diameter": (text(TEE, [*THREE[:2], ("t", "c", NAN)]), "from 't' to 'c', nan mm, is out of range: choose 40"),
    "NaN wall": (text(TEE, THREE, top="wall_mm = nan"), "wall thickness nan mm is out of range: choose 0.5 to 50 mm"),
    "NaN bend": (text(ELBOW, TWO, t="bend_radius_mm = nan"), "nan mm, is out of range: choose 75 to 3000 mm"),
    "NaN reducer": (text(LINE, [TWO[0], ("t", "b", 80)], t="reducer_mm = nan"), "length of reducer 1, nan mm"),
    "two bores": (text(ELBOW, [TWO[0], ("t", "b", 80)]), "interior angle of reducer 1, 90 deg, .* choose 180"),
    "named twice": (text(TEE, THREE) + "\n[nodes.a]\nat_mm = [1, 1]\n", "Cannot declare .* twice"),
    "a loop": (text(TEE, [*THREE, ("a", "a", 100)]), "a pipe leads from 'a' to itself: name two nodes"),
    "one place": (text({**TEE, "d": [600, 0]}, [*THREE, ("b", "d", 100)]), "'b' and 'd' of a pipe lie in one place"),
    "two pipes": (text(TEE, [*THREE, ("t", "a", 100)]), "2 pipes lead from a to t: give one"),
    "a node alone": (text({**TEE, "d": [0, -600]}, THREE), "0 pipes meet in node 'd': choose 1 to 4, or leave it out"),
    "unknown node": (text(TEE, [*THREE, ("t", "z", 100)]), "unknown node 'z': choose 'a', 'b', 'c' or 't'"),
    "one coordinate": (text({**TEE, "b": [600]}, THREE), "nodes.b.at_mm: list should have at least 2 items"),
    "a word": (text(TEE, THREE).replace("[600, 0]", '["x", 0]'), r"nodes.b.at_mm.0: input should be a valid number"),
    "a wrong key": (text(TEE, THREE, b="position = 1"), "unknown key 'nodes.b.position'"),
    "a long pipe": (
        text({"a": [0, 0], "b": [600_000, 0]}, [("a", "b", 100)]),
        "length of the pipe from 'a' to 'b', 600000 mm, is out of range: choose 1 to 20000 mm",
    ),
    "not quite in line": (
        text({"a": [-600, 0], "t": [0, 0], "b": [15_000, 14]}, [("a", "t", 100), ("t", "b", 80)]),
        "'b' would lie 14.0 mm from its place, .* give nodes that are exactly in line",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_network_is_refused_in_one_sentence(name: str, tmp_path: Path) -> None:
    content, message = REFUSED[name]
    file = tmp_path / "network.toml"
    file.write_text(content)
    with pytest.raises(ConfigError, match=message) as caught:
        read_network(file)
        read_network_routes(file)
    assert str(caught.value).startswith(str(file)) and "\n" not in str(caught.value)


def test_routes_through_the_tee_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "network.toml"
    ways = 'on = ["a", "t", "b"]\nout = ["c", "t", "b"]'
    file.write_text(text(TEE, THREE, ways, b="capped = true"))
    on, out = read_network_routes(file).values()
    assert on.corners[0].straight_on and on.capped and on.corners[0].branches[0].turn == "left"
    assert out.corners[0].turn == "left" and out.corners[0].branches[0].turn == "right"


def test_a_network_in_python_is_checked_too() -> None:
    nodes = {name: NetworkNode(position=(x / 1e3, y / 1e3, 0.0)) for name, (x, y) in TEE.items()}
    pipes = tuple(NetworkPipe(start=a, end=b, diameter=d / 1e3) for a, b, d in THREE)
    assert PipeNetwork(nodes=nodes, pipes=pipes).strands == [["a", "t"], ["t", "b"], ["t", "c"]]
    with pytest.raises(PipenavError, match="a network of 0 pipes is not possible: give 1 to 500"):
        PipeNetwork(nodes=nodes, pipes=())
