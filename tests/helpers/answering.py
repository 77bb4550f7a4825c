"""A worker that sends every message back, whatever it imports on the way."""

from __future__ import annotations

import json  # noqa: F401
import queue  # noqa: F401
from collections.abc import Sequence

import numpy as np  # noqa: F401

from pipenav.processes.children import worker_end


def main(arguments: Sequence[str]) -> None:
    end = worker_end(arguments)
    while True:
        try:
            end.send(end.recv())
        except EOFError:
            return
