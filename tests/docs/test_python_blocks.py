"""Python in the docs runs, in a folder with the files that it names."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.doc_pages import PAGES, ROOT, Block, blocks
from helpers.documented import pipenav

from pipenav.pipes import parse_routes
from pipenav.robots import load_robot

BLOCKS = [block for page in PAGES for block in blocks(page) if block.language == "python"]


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: f"{block.page.relative_to(ROOT)}:{block.line}")
def test_python_block_runs(block: Block, among_shown_files: Path) -> None:
    del among_shown_files
    for words in FILES_OF.get(block.page.name, ()):
        assert pipenav(*words) == 0
    exec(compile(block.code, f"{block.page.name}:{block.line}", "exec"), {"__name__": "documented"})


FILES_OF = {
    "pipe-folder.md": [("gen-pipe", "--d", "100", "--angle", "75")],
    "route-folder.md": [("gen-pipe", "--route", "my-route.toml")],
    "evaluation-folder.md": [
        ("eval", "--policy", "arm", "--pipes", "d=100,angle=90", "--episodes", "1", "--out", "eval")
    ],
}
"""Commands that make what the Python of a page reads."""


def test_shown_robot_can_be_read(among_shown_files: Path) -> None:
    del among_shown_files
    assert [joint.name for joint in load_robot("finger.toml").joints] == ["slide", "shoulder", "elbow"]


def test_shown_set_of_routes_can_be_read(among_shown_files: Path) -> None:
    del among_shown_files
    assert len(parse_routes(["my-routes.toml"])) == 24
