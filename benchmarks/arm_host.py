"""A host program to be killed: drives the arm of an `arm.toml` to and fro until something ends it.

    python benchmarks/arm_host.py ARM.TOML [raise SECONDS]

It prints `on` when torque is on. `raise` has it end by an exception; `segfault` by a segmentation fault.
"""

from __future__ import annotations

import ctypes
import math
import sys
import time

import numpy as np

from pipenav.deploy import guarded
from pipenav.machine import load_machine
from pipenav.registry import open_backend
from pipenav.robot import load_robot
from pipenav.safety import Stopped
from pipenav.state import Command


def main() -> int:
    arm, ending, seconds = sys.argv[1], *(sys.argv[2:] or ["never", "inf"])
    machine = open_backend("hardware", load_robot("basic"), 1, {"arm": arm, "patience": 5.0})
    assert isinstance(machine, load_machine())
    try:
        with guarded(machine):
            start = machine.read().q
            machine.reset(np.array([0]), [], start, np.zeros(1))
            print("on", flush=True)
            begun = time.monotonic()
            while True:
                machine.read()
                t = time.monotonic() - begun
                swing = np.array([0.0, 0.3, -0.3, 0.3]) * math.sin(3 * t)
                machine.step(Command("position", start + swing))
                if t > float(seconds):
                    _end(ending)
    except Stopped as stopped:
        print(stopped, flush=True)
        return 3
    finally:
        machine.close()


def _end(how: str) -> None:
    if how == "segfault":
        ctypes.string_at(0)
    if how == "exit":
        sys.exit(4)
    raise RuntimeError("an exception somewhere in the loop")


if __name__ == "__main__":
    sys.exit(main())
