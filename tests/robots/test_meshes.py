"""Links as meshes: closed, of the volume and extent that the description says, and readable again from the files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from pipenav.cli import main
from pipenav.robots.meshes import link_mesh
from pipenav.robots.parts import BoxPart
from pipenav.robots.robot import load_robot
from pipenav.robots.variants import robot_names


@pytest.mark.parametrize("name", robot_names())
def test_meshes_are_closed_and_as_large_as_the_parts(name: str) -> None:
    for link in load_robot(name).links:
        mesh = link_mesh(link)
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(sum(part.volume for part in link.parts), rel=1e-3)
        half = [part.length / 2 if isinstance(part, BoxPart) else part.diameter / 2 for part in link.parts]
        front = max(part.x + h for part, h in zip(link.parts, half, strict=True))
        assert mesh.bounds[1, 0] == pytest.approx(front, abs=1e-5)
        assert np.ptp(mesh.bounds[:, 1]) == pytest.approx(link.width, abs=1e-5)


def test_the_command_writes_meshes_in_millimetres(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["robots", "basic", "--out", str(tmp_path)])
    assert not left.value.code
    assert "end_effector" in capsys.readouterr().out
    mesh = trimesh.load_mesh(tmp_path / "end_effector.stl")
    assert mesh.extents == pytest.approx([110, 20, 20])
    assert mesh.is_watertight


def test_out_without_a_robot_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["robots", "--out", "meshes"])
    assert left.value.code == 2
    assert "needs the name of a robot" in capsys.readouterr().err
