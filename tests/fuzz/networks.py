"""Tubes of random networks against the oracle: `python tests/fuzz/networks.py 200`, or `networks.py 1 57` for one.

Every STL must be watertight when it is read back, as large as the oracle says, and have the wall where the oracle has.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import numpy as np

TESTS = Path(__file__).resolve().parents[1]

POINTS = 10_000
"""Points that are asked of each tube."""


def problems(seed: int, folder: Path, most: int = 2) -> list[str]:
    """Laws that the tube of a random network breaks.

    Args:
        seed: seed of the network.
        folder: where its STL is written.
        most: fittings that it grows, see `random_network`.
    """
    from helpers.pipe_oracle import PipeOracle
    from helpers.random_networks import random_network
    from helpers.solids import differing, read_back

    from pipenav.pipes.pipe_system import network_system
    from pipenav.pipes.system_tubes import system_tube_mesh

    network, rng = random_network(seed, most), np.random.default_rng(seed)
    oracle = PipeOracle.of_network(network)
    body = read_back(system_tube_mesh(network_system(network)), folder)
    found = [] if body.is_watertight and body.is_winding_consistent else ["it is not watertight"]
    ratio = 1e-9 * body.volume / oracle.wall_volume(rng, 10_000)
    if abs(ratio - 1) > 0.01:
        found.append(f"its volume is {ratio:.4f} of what it ought to be")
    wrong = differing(body, oracle, rng, POINTS)
    return [*found, *([f"{len(wrong)} points differ, the first at {wrong[0].tolist()}"] if len(wrong) else [])]


def main(count: int, first: int = 0) -> int:
    """Try some networks; the number of those that break a law."""
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, first + count):
            for problem in (found := problems(seed, Path(folder))):
                print(f"network {seed}: {problem}", flush=True)
            failed += bool(found)
    print(f"{failed} of {count} networks break a law", flush=True)
    return failed


if __name__ == "__main__":
    sys.path[:0] = [str(TESTS), str(TESTS.parent), str(TESTS.parent / "plugins")]
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0) > 0)
