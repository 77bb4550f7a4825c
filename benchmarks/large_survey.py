"""Time and memory of `pipenav survey` on a large map: `python benchmarks/large_survey.py`.

The map is copies of the example's mains side by side, level and in 102.2 mm: 1,053 fittings each, the same classes in
all of them. A first survey, of one copy, tries the classes that the cache does not hold yet.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import resource
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # also where PYTHONSAFEPATH is set

from revisions import ROOT, run_pipenav

from pipenav.networks.reader import read_network_map
from pipenav.storage.atomic_files import atomic_write

EXAMPLE = ROOT / "examples" / "schutterwald" / "network.json"
BORE_MM = 102.2
APART = 5000.0
"""Distance between copies [m], more than the example is wide."""


def main() -> None:
    """Make the map, survey it and print what that took."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--copies", type=int, default=95, help="copies of the example: 95 have 100,035 fittings")
    parser.add_argument("--out", type=Path, help="folder for maps and surveys, by default a temporary one")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        out = given.out or Path(folder)
        out.mkdir(parents=True, exist_ok=True)
        for copies in (1, given.copies):
            file = out / f"copies-{copies}.csv"
            write_map(file, copies)
            began, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
            run_pipenav(ROOT, f"survey {file.name} --diameter bore:mm --out survey-{copies}", out)
            took = time.monotonic() - began
        record = json.loads((out / f"survey-{given.copies}" / "survey.json").read_text(encoding="utf-8"))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    busy = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    peak = 1024 * after.ru_maxrss / 1e9
    print(
        f"{len(record['features']):,} fittings, {len(record['classes'])} classes, {len(record['entries']['points'])} "
        f"entries: {took:.1f} s, {busy:.1f} s of processor time, {peak:.2f} GB"
    )


def write_map(file: Path, copies: int) -> None:
    """Write copies of the example's mains as CSV of lines."""
    network = read_network_map(EXAMPLE)
    mains = [network.points_of(line)[:, :2] for line in range(len(network.line_names)) if not network.service[line]]
    rows = [["wkt", "bore"]]
    for copy in range(copies):
        corner = [APART * (copy % 10), APART * (copy // 10)]
        for points in mains:
            course = ", ".join(f"{x:.3f} {y:.3f} 0" for x, y in points + corner)
            rows.append([f"LINESTRING Z ({course})", f"{BORE_MM}"])
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    atomic_write(file, text.getvalue())


if __name__ == "__main__":
    main()
