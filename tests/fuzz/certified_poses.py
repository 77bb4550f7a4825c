"""Free poses near bottlenecks against the cells of certificates: `python -P tests/fuzz/certified_poses.py 1000000`.

Prints the number of poses that their cells do not hold, which must be 0; a million takes about 5 minutes.
"""

from __future__ import annotations

import sys
from itertools import count, product
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from certify.test_soundness import ARMS, WIDTH, lost

from pipenav.certify.model import Model
from pipenav.pipes import PipeCorner
from pipenav.robots.robot import load_robot

PIPES = [PipeCorner.of(*shape) for shape in ((62, 60), (67, 60), (56, 90), (63, 90), (50, 120), (70, 45))]


def main(wanted: int) -> None:
    """Draw at least so many poses, and exit with code 1 if one is lost."""
    drawn = missing = 0
    for seed, name, pipe in ((seed, *pair) for seed in count() for pair in product(ARMS, PIPES)):
        model = Model(load_robot(name), pipe)
        more, poses = lost(model, model, WIDTH, 20_000, seed)
        drawn, missing = drawn + poses, missing + more
        if drawn >= wanted:
            break
    print(f"{drawn:,} free poses, {missing} lost")
    sys.exit(bool(missing))


if __name__ == "__main__":
    main(int(sys.argv[1]))
