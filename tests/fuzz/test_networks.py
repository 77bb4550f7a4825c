"""A short part of `python tests/fuzz/networks.py 200`: tubes of random networks are what the oracle says."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzz.networks import problems


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_the_tube_of_a_random_network_is_watertight_and_right(seed: int, tmp_path: Path) -> None:
    assert problems(seed, tmp_path) == []
