"""A short part of `python tests/fuzz/simulate.py 250`: what is accepted runs, what is refused leaves nothing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.slow
def test_accepted_files_can_be_simulated() -> None:
    command = [sys.executable, str(Path(__file__).with_name("simulate.py")), "15"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]
