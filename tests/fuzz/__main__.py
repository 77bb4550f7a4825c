"""Mutated files of every format, given to their readers: `python -m tests.fuzz --per-format 2000`.

A reader may refuse a file in a sentence. It may raise nothing else, take no longer than ten seconds and no more than
1 GB of memory. A failure is named by its format and number; `--show FORMAT NUMBER` writes that file out.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

TESTS = Path(__file__).resolve().parents[1]


def run_format(name: str, count: int, first: int = 0) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Failures of a format, and its counts; a reader that ends its process is a failure, and the rest goes on."""
    failures: list[dict[str, Any]] = []
    summary: dict[str, Any] = {}
    last, number = first + count, first
    while number < last:
        command = [sys.executable, str(TESTS / "fuzz" / "worker.py"), name, str(number), str(last - number)]
        paths = os.pathsep.join([str(TESTS.parent), str(TESTS.parent / "plugins"), os.environ.get("PYTHONPATH", "")])
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": paths}
        )
        lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
        failures += [line for line in lines if line.get("seed", -1) >= 0]
        if lines and "counts" in lines[-1]:
            return failures, lines[-1]
        began = max((line["began"] for line in lines if "began" in line), default=number)
        failures.append({"seed": began, "outcome": f"exit {done.returncode}", "where": done.stderr[-300:]})
        number = began + 1
    return failures, summary


def main() -> None:
    sys.path[:0] = [str(TESTS), str(TESTS.parent), str(TESTS.parent / "plugins")]
    from fuzz.formats import formats
    from fuzz.worker import mutant

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--per-format", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--format", choices=list(formats()), action="append")
    parser.add_argument("--show", nargs=2, metavar=("FORMAT", "NUMBER"))
    given = parser.parse_args()
    if given.show:
        sys.stdout.buffer.write(mutant(given.show[0], int(given.show[1])))
        return
    failed = 0
    for name in given.format or formats():
        failures, summary = run_format(name, given.per_format, given.first)
        failed += len(failures)
        print(f"{name}: {len(failures)} failures, {json.dumps(summary)}", flush=True)
        for failure in failures[:20]:
            print(f"  {name} {failure['seed']}: {failure['outcome']} {failure['where']}", flush=True)
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
