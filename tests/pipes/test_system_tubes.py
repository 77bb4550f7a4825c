"""Tubes of small networks and of routes with fittings, read back from their STL, against the oracle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.pipe_oracle import PipeOracle
from helpers.random_networks import random_network, random_routes
from helpers.solids import differing, read_back
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.pipes.network import NetworkNode, NetworkPipe, PipeNetwork
from pipenav.pipes.pipe_system import network_system
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_solids import route_tube_mesh
from pipenav.pipes.system_tubes import system_tube_mesh

seeds = st.integers(0, 2**31 - 1)


@pytest.mark.slow
@given(seed=seeds)
@settings(max_examples=10, deadline=None)
def test_tubes_of_small_networks(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    network, rng = random_network(seed, 1), np.random.default_rng(seed)
    body = read_back(system_tube_mesh(network_system(network)), tmp_path_factory.mktemp("tube"))
    oracle = PipeOracle.of_network(network)
    assert body.is_watertight and body.is_winding_consistent
    assert 1e-9 * body.volume == pytest.approx(oracle.wall_volume(rng), rel=0.01)
    assert len(differing(body, oracle, rng, 2000)) == 0


@pytest.mark.slow
@given(seed=seeds)
@settings(max_examples=6, deadline=None)
def test_tubes_of_routes_through_networks(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    for route in random_routes(seed)[:2]:
        body = read_back(route_tube_mesh(route), tmp_path_factory.mktemp("tube"))
        assert body.is_watertight and body.is_winding_consistent
        assert len(differing(body, PipeOracle.of_route(route), np.random.default_rng(seed), 2000)) == 0


@pytest.mark.parametrize("capped", [False, True])
def test_a_straight_capped_pipe_has_the_volume_of_its_formula(capped: bool) -> None:
    nodes = {"a": NetworkNode(position=(0, 0, 0)), "b": NetworkNode(position=(0.3, 0.4, 1.2), capped=capped)}
    network = PipeNetwork(nodes=nodes, pipes=(NetworkPipe(start="a", end="b", diameter=0.1),), wall=0.004)
    mesh = system_tube_mesh(network_system(network))
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    volume = 1e-9 * float((np.cross(a, b) * c).sum()) / 6
    expected = math.pi * (0.054**2 - 0.05**2) * 1.3 + capped * math.pi * 0.054**2 * 0.004
    assert volume == pytest.approx(expected, rel=2e-3)


def test_the_same_pipes_give_the_same_mesh() -> None:
    one, other = (system_tube_mesh(network_system(random_network(3, 2))) for _ in range(2))
    np.testing.assert_array_equal(one.vertices, other.vertices)
    np.testing.assert_array_equal(one.faces, other.faces)


def test_a_route_without_fittings_has_the_same_tube_either_way() -> None:
    """The mesh of a single row of legs is that of the route, whichever function makes it."""
    route = PipeRoute.of(90, [(90, "left", 0, 100), (60, "right", 90)])
    capped = route.model_copy(update={"capped": True})
    plain, closed = route_tube_mesh(route), route_tube_mesh(capped)
    sizes = []
    for mesh in (plain, closed):
        a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
        sizes.append(1e-9 * float((np.cross(a, b) * c).sum()) / 6)
    outside = route.radius + route.wall
    assert sizes[1] - sizes[0] == pytest.approx(math.pi * outside**2 * route.wall, rel=0.02)
