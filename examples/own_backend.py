"""Drive robots on a backend of your own, without its installation: python examples/own_backend.py [STEPS]"""

import sys
from contextlib import closing
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parent / "backend"))  # an installed plugin needs no such line

from pipenav_lag import LagBackend, LagOptions

from pipenav.backends import Command
from pipenav.pipes import PipeCorner
from pipenav.robots import load_robot

steps = int(sys.argv[1]) if len(sys.argv) > 1 else 10
robot = load_robot("basic")
pipes = [PipeCorner.of(90, 60), PipeCorner.of(100, 90, "right")]  # one robot in each
n, joints = len(pipes), len(robot.joints)

with closing(LagBackend(robot, n, LagOptions(time_constant=0.1))) as backend:
    backend.reset(np.arange(n), pipes, np.zeros((n, joints)), np.full(n, -robot.length - 0.10))
    for _ in range(steps):
        backend.step(Command("position", np.tile([0.1, 0.0, 0.1, 0.3], (n, 1))))  # slide [m], three hinges [rad]
        reading, truth = backend.read(), backend.truth()
        print(f"{reading.time[0]:.1f} s, q {np.round(reading.q[0], 3)}, least reading {reading.ranges.min(axis=1)} m")
    print(f"tips in the pipes' frames [m, m, rad]:\n{truth.tip.round(3)}")
