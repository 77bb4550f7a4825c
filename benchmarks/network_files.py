"""Pipes of EPANET files as pipenav reads them, beside those that the EPANET toolkit itself reads.

pip download --no-deps wntr epyt        # both bring networks, wntr the toolkit too; unpack the wheels
python benchmarks/network_files.py FOLDER libepanet22.so
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

from pipenav.errors import PipenavError
from pipenav.networks import read_network_map

LINKS, DIAMETER, LENGTH, FLOW_UNITS_OF_THE_US, PIPES = 2, 0, 1, 5, (0, 1)
"""Numbers of the toolkit (EPANET 2.2, epanet2_enums.h): what is counted, two properties, flow units, kinds of links."""

Pipes = dict[str, tuple[float, float]]
"""Length and diameter [m] of each pipe by its name."""


def by_the_toolkit(library: str, file: Path) -> Pipes:
    """Pipes of a file, check valves included; none where the toolkit refuses it."""
    toolkit, found = ctypes.CDLL(library), Pipes()
    with tempfile.TemporaryDirectory() as folder:
        outputs = (os.fsencode(Path(folder) / name) for name in ("report", "results"))
        if toolkit.ENopen(os.fsencode(file), *outputs) > 100:
            return found
        count, flow, kind = ctypes.c_int(), ctypes.c_int(), ctypes.c_int()
        toolkit.ENgetcount(LINKS, ctypes.byref(count))
        toolkit.ENgetflowunits(ctypes.byref(flow))
        bore, length = (0.0254, 0.3048) if flow.value < FLOW_UNITS_OF_THE_US else (1e-3, 1.0)
        for i in range(1, count.value + 1):
            toolkit.ENgetlinktype(i, ctypes.byref(kind))
            if kind.value not in PIPES:
                continue
            name, values = ctypes.create_string_buffer(64), (ctypes.c_float * 2)()
            toolkit.ENgetlinkid(i, name)
            toolkit.ENgetlinkvalue(i, LENGTH, ctypes.byref(values, 0))
            toolkit.ENgetlinkvalue(i, DIAMETER, ctypes.byref(values, 4))
            found[_text(name.value)] = (values[0] * length, values[1] * bore)
        toolkit.ENclose()
    return found


def _text(name: bytes) -> str:
    """A name as its file spells it, which is UTF-8 or, in older files, Latin-1."""
    try:
        return name.decode("utf-8")
    except UnicodeDecodeError:
        return name.decode("latin-1")


def compared(library: str, file: Path) -> str:
    """Agreement of the two readers on a file, in words."""
    try:
        read = read_network_map(file)
    except PipenavError as error:
        return f"refused: {error}"
    with multiprocessing.get_context("spawn").Pool(1) as pool:  # the toolkit crashes on some files
        try:
            theirs = pool.apply_async(by_the_toolkit, (library, file)).get(60)
        except multiprocessing.TimeoutError:
            return "the toolkit crashed"
    if not theirs:
        return f"the toolkit refuses it, pipenav reads {len(read.line_names)} pipes"
    ours = {
        name: (length, diameter)
        for name, length, diameter in zip(read.line_names, read.length.tolist(), read.diameter.tolist(), strict=True)
    }
    if ours.keys() != theirs.keys() or not all(np.allclose(ours[name], theirs[name], rtol=1e-5) for name in ours):
        return f"DIFFERENT: {len(ours)} and {len(theirs)} pipes"
    return f"equal, {len(ours)} pipes"


def main() -> None:
    """Print a line for each file below a folder."""
    folder, library = sys.argv[1:]
    for file in sorted(Path(folder).rglob("*.inp")):
        print(f"{file.name}: {compared(library, file)}", flush=True)


if __name__ == "__main__":
    main()
