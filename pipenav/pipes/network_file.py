"""A network as TOML: nodes, pipes and named routes. Format: docs/formats/network.md."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from pipenav.errors import ConfigError, PipenavError
from pipenav.pipes.network import NetworkNode, NetworkPipe, PipeNetwork
from pipenav.pipes.network_checks import MAX_NETWORK_PIPES
from pipenav.pipes.pipe import DEFAULT_WALL
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.set_file import read_as
from pipenav.units import m_to_mm, mm_to_m

Position = Annotated[list[float], Field(min_length=2, max_length=3)]
"""Coordinates of a node: x, y and, if it is not 0, z [mm]."""


class NodeEntry(BaseModel):
    """A node as TOML."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    at_mm: Position
    bend_radius_mm: float = 0.0
    reducer_mm: float = 0.0
    capped: bool = False

    def node(self) -> NetworkNode:
        """The node."""
        x, y, z = (mm_to_m(value) for value in [*self.at_mm, 0.0][:3])
        return NetworkNode(
            position=(x, y, z),
            bend_radius=mm_to_m(self.bend_radius_mm),
            length=mm_to_m(self.reducer_mm),
            capped=self.capped,
        )


class NetworkPipeEntry(BaseModel):
    """A pipe as TOML."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    from_: str = Field(alias="from")
    to: str
    diameter_mm: float


class NetworkFile(BaseModel):
    """A network as TOML."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    schema_: Literal[1] = Field(alias="schema")
    description: str = ""
    wall_mm: float = m_to_mm(DEFAULT_WALL)
    nodes: dict[str, NodeEntry] = Field(min_length=2, max_length=2 * MAX_NETWORK_PIPES)
    pipes: list[NetworkPipeEntry] = Field(min_length=1, max_length=MAX_NETWORK_PIPES)
    routes: dict[str, list[str]] = {}

    def network(self) -> PipeNetwork:
        """The network that the file describes.

        Raises:
            PipenavError: the network is not possible.
        """
        pipes = [NetworkPipe(start=pipe.from_, end=pipe.to, diameter=mm_to_m(pipe.diameter_mm)) for pipe in self.pipes]
        nodes = {name: entry.node() for name, entry in self.nodes.items()}
        return PipeNetwork(nodes=nodes, pipes=tuple(pipes), wall=mm_to_m(self.wall_mm))


def read_network(path: Path) -> PipeNetwork:
    """The network of a TOML file.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no network, or not a possible one.
    """
    file = read_as(NetworkFile, path, NodeEntry)
    try:
        return file.network()
    except PipenavError as error:
        raise ConfigError(f"{path}: {error}") from error


def read_network_routes(path: Path) -> dict[str, PipeRoute]:
    """The named routes of a network's TOML file.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no network, not a possible one, or names no route.
    """
    file = read_as(NetworkFile, path, NodeEntry)
    if not file.routes:
        raise ConfigError(f'{path} names no route: add a table [routes] with lines such as main = ["a", "b", "c"].')
    try:
        network = file.network()
        return {name: network.route(way) for name, way in file.routes.items()}
    except PipenavError as error:
        raise ConfigError(f"{path}: {error}") from error
