"""A process that gives mutated files of one format to its reader; it prints a line of JSON for each failure."""

from __future__ import annotations

import json
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

LONGEST = 10
"""Seconds that a reader may take."""

MOST_MEMORY = 1 << 30
"""Bytes that a reader may take on top of what its libraries take."""


LONGEST_MESSAGE = 4000
"""Characters that a message may have: an unknown key of a training may list every key that there is."""


class TooLong(BaseException):
    """A reader that takes longer than it may."""


def _stop(*_: object) -> None:
    raise TooLong


def limit_memory() -> None:
    """Let this process take `MOST_MEMORY` more than it has now."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + MOST_MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def attempt(reader: Callable[[Path], Any], path: Path) -> tuple[str, str]:
    """Outcome of a reader in a word, and the place of its failure: ok, refused, or the exception's name."""
    from pipenav.errors import PipenavError

    signal.signal(signal.SIGALRM, _stop)
    signal.alarm(LONGEST)
    try:
        reader(path)
    except PipenavError as error:
        text = " ".join(str(error).split())  # as the command line shows it
        fine = len(text) < LONGEST_MESSAGE and text.endswith((".", "?"))
        return ("refused", "") if fine else ("message", text[:300])
    except (Exception, TooLong) as error:
        frames = traceback.extract_tb(error.__traceback__, limit=-30)
        ours = [f"{Path(frame.filename).name}:{frame.lineno}" for frame in frames if "pipenav" in frame.filename]
        return type(error).__name__, f"{' '.join(ours[-3:])}: {str(error)[:200]}"
    finally:
        signal.alarm(0)
    return "ok", ""


def mutant(name: str, seed: int) -> bytes:
    """The content number `seed` of a format."""
    from fuzz.formats import formats, tree_of
    from fuzz.mutations import as_json, as_toml, mutated_bytes, mutated_tree

    rng = random.Random(f"{name}-{seed}")
    known = formats()[name]
    content = rng.choice(known.seeds)
    tree = tree_of(name, content)
    if tree is None or rng.random() < 0.35:
        return mutated_bytes(content, rng)
    tree, usual = mutated_tree(tree, rng), sys.getrecursionlimit()
    sys.setrecursionlimit(20_000)  # writing deep nesting down is ours; reading it is what is tested
    try:
        return as_toml(tree) if known.suffix == ".toml" else as_json(tree)
    finally:
        sys.setrecursionlimit(usual)


def main(name: str, first: int, count: int) -> None:
    from fuzz.formats import formats

    known = formats()[name]
    counts: dict[str, int] = {}
    slowest = 0.0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"input{known.suffix}"
        path.write_bytes(known.seeds[0])
        print(json.dumps({"seed": -1, "outcome": attempt(known.open, path)}), flush=True)
        limit_memory()
        for seed in range(first, first + count):
            print(json.dumps({"began": seed}), flush=True)
            path.write_bytes(mutant(name, seed))
            started = time.monotonic()
            outcome, where = attempt(known.open, path)
            slowest = max(slowest, time.monotonic() - started)
            counts[outcome] = counts.get(outcome, 0) + 1
            if outcome not in ("ok", "refused"):
                print(json.dumps({"seed": seed, "outcome": outcome, "where": where}), flush=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
    print(json.dumps({"counts": counts, "slowest_s": round(slowest, 2), "peak_mib": peak}), flush=True)


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
