"""The picture of a training."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipenav.errors import FileProblem
from pipenav.learning.figures import write_training_plot

PNG = b"\x89PNG\r\n\x1a\n"


PROGRESS = "steps,seconds,steps_per_s,success,clearance_m,reward,episode_steps,std,eval_success\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    "rows",
    [
        "",
        "800,1.0,800,,0.01,-1,,0.5,\n",
        "800,1.0,800,,0.01,-1,,0.5,\n1600,2.0,800,0.5,0.02,-1,40,0.5,0.75\n2400,3.0,nonsense,inf,,,,,\n32",
    ],
)
def test_training_plots_tolerate_what_a_training_leaves(rows: str, tmp_path: Path) -> None:
    (tmp_path / "progress.csv").write_text(PROGRESS + rows, encoding="utf-8")
    write_training_plot(tmp_path / "training.png", tmp_path / "progress.csv")
    assert (tmp_path / "training.png").read_bytes().startswith(PNG)


def test_training_plot_needs_its_file(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"cannot read .*progress.csv"):
        write_training_plot(tmp_path / "training.png", tmp_path / "progress.csv")
