"""Files that are accepted are also simulated: mutated numbers of robots, tasks and options go through whole commands.

`python tests/fuzz/simulate.py COUNT [FIRST]` prints a line for each input at which a command did not end in 0, or in 1
with one sentence and nothing left on disk.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import signal
import sys
import tempfile
from pathlib import Path
from typing import Any

TESTS = Path(__file__).resolve().parents[1]

LONGEST = 60
"""Seconds that a command may take: it simulates some episodes, on a machine that may be busy."""

FACTORS = [0.0, -1.0, 1e-6, 1e-3, 0.1, 0.5, 1.5, 3.0, 10.0, 100.0, 1e4, 1e8]


def changed_numbers(tree: Any, rng: random.Random, share: float = 0.3) -> Any:
    """The values with one to three numbers multiplied, or set to ends of what is allowed."""
    places = list(_numbers(tree))
    for _ in range(rng.choice([1, 1, 2, 3])):
        holder, key = rng.choice(places)
        value = holder[key]
        if rng.random() < share:
            new = rng.choice([0, 1, 1e-3, 2e-3, 0.05, 0.3, 1, 2, 20, 100, 1000])
        else:
            new = value * rng.choice(FACTORS)
        holder[key] = round(new) if isinstance(value, int) else float(new)
    return tree


def _numbers(tree: Any) -> Any:
    for key in list(tree) if isinstance(tree, dict) else range(len(tree)):
        if isinstance(tree[key], dict | list):
            yield from _numbers(tree[key])
        elif isinstance(tree[key], int | float) and not isinstance(tree[key], bool) and key != "schema_version":
            yield tree, key


def command(seed: int, folder: Path) -> list[str]:
    """A command on a mutated file in the folder."""
    from fuzz.mutations import as_toml
    from pipenav.learning.config import load_config
    from pipenav.robots.robot import load_robot

    rng, file = random.Random(seed), folder / "input.toml"
    kind = seed % 5
    if kind < 3:
        name = ("basic", rng.choice(["real-setup", "high-fidelity"]), "pirate")[kind]
        robot = load_robot(name).model_dump(mode="json", exclude_none=True)
        file.write_bytes(as_toml(changed_numbers(robot, rng)))
        task = ["eval", "--pipes", "d=110,angle=120", "--episodes", "1", "--robot", str(file), "--policy"]
        if kind == 2:
            return [*task, rng.choice(["baseline:sequence-line", "baseline:random"])]
        locate = ["locate-target", "--d", "110", "--angle", "100", "--robot", str(file)]
        return rng.choice([locate, [*task, "baseline:random"], [*task, "baseline:centreline"]])
    small = {"steps": 8, "pipes": ["d=110,angle=120"], "network.policy": [4], "network.value": [4]}
    learner = {"robots": 2, "rollout_steps": 2, "batch_size": 4, "epochs": 1}
    small |= {f"learner.{key}": value for key, value in learner.items()} | {"check.episodes": 1}
    config = load_config(("arm", "pirate")[kind - 3], options=small).model_dump(mode="json", exclude_none=True)
    config["options"] = {"timestep": 0.005, "contact_time_constant": 0.01, "contact_impedance": [0.95, 0.99, 0.001]}
    kept = {key: config[key] for key in ("steps", "network", "check")} | {"robots": config["learner"]["robots"]}
    changed = changed_numbers({key: config[key] for key in ("task", "options", "randomise", "learner")}, rng)
    changed["learner"]["robots"] = kept.pop("robots")
    file.write_bytes(as_toml({**config, **changed, **kept}))
    return ["train", "--config", str(file), "--out", "made"]


def run(seed: int) -> str:
    """Outcome of an input: ok, refused, or what is wrong."""
    from pipenav.cli import main

    with tempfile.TemporaryDirectory() as folder:
        arguments = command(seed, Path(folder))
        work = Path(folder) / "work"
        work.mkdir()
        os.chdir(work)
        errors, code = io.StringIO(), 0
        signal.alarm(LONGEST)
        try:
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(errors):
                main(arguments)
        except SystemExit as left:
            code = int(left.code or 0)
        finally:
            signal.alarm(0)
            os.chdir("/")
        made = sorted(path.name for path in work.iterdir())
    message = errors.getvalue().strip().splitlines()[-1:] or [""]
    if code == 0:
        return "ok"
    if code == 1 and (not made or "diverged.json" in message[0]):
        return "refused"
    return f"exit {code}, made {made}: {' '.join(arguments[:3])} {message[0]}"


def main(count: int, first: int = 0) -> int:
    """Run some inputs; the number of those that failed."""
    counts: dict[str, int] = {}
    for seed in range(first, first + count):
        print(json.dumps({"began": seed}), file=sys.stderr, flush=True)
        outcome = run(seed)
        word = outcome if outcome in ("ok", "refused") else "failed"
        counts[word] = counts.get(word, 0) + 1
        if word == "failed":
            print(f"{seed}: {outcome}", flush=True)
    print(json.dumps(counts), flush=True)
    return counts.get("failed", 0)


if __name__ == "__main__":
    sys.path[:0] = [str(TESTS), str(TESTS.parent), str(TESTS.parent / "plugins")]
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0) > 0)
