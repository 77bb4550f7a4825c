"""Pictures of whole networks."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.fittings import network
from helpers.pictures import overlapping, texts

from pipenav.drawing.down import WORD
from pipenav.drawing.network import draw_network, network_figure
from pipenav.drawing.projection import MOST_PIECES
from pipenav.drawing.surface import AROUND
from pipenav.pipes.network import NetworkNode, NetworkPipe, PipeNetwork


@pytest.mark.parametrize("height", [0.0, 0.8])
def test_a_picture_of_a_network_names_every_node_and_measures_every_pipe(height: float) -> None:
    net = network(height)
    figure = network_figure(net, "mine")
    said = texts(figure)
    assert all(said.count(name) == 1 for name in net.nodes)
    assert said.count("⌀ 100, 1500") == 2
    assert {"⌀ 60, 1000", "⌀ 80, 1200"} <= set(said)
    assert WORD in said
    assert "mine: 6 nodes, 5 pipes, one tee, ⌀ 100-60 mm" in said
    assert overlapping(figure, figure.axes[0]) == []


def test_texts_without_room_are_left_out_and_counted() -> None:
    comb = {f"node number {i}": NetworkNode(position=(0.3 * i, 0.0, 0.0)) for i in range(40)}
    pipes = [NetworkPipe(start=f"node number {i}", end=f"node number {i + 1}", diameter=0.1) for i in range(39)]
    figure = network_figure(PipeNetwork(nodes=comb, pipes=tuple(pipes)), "row")
    assert any("texts without room left out" in text for text in texts(figure))
    assert overlapping(figure, figure.axes[0]) == []


def test_a_long_network_is_drawn_from_few_pieces_as_thick_as_a_line() -> None:
    nodes = {f"n{i}": NetworkNode(position=(20.0 * i, 0.0, 0.0)) for i in range(11)}
    pipes = tuple(NetworkPipe(start=f"n{i}", end=f"n{i + 1}", diameter=0.1) for i in range(10))
    tube = network_figure(PipeNetwork(nodes=nodes, pipes=pipes), "long").axes[0].collections[-1]
    assert len(tube.get_paths()) < 1.2 * AROUND * MOST_PIECES
    assert tube.get_linewidths()[0] > 1


def test_a_picture_is_written(tmp_path: Path) -> None:
    draw_network(network(0.8), "mine", tmp_path / "network.png")
    assert (tmp_path / "network.png").read_bytes().startswith(b"\x89PNG")
