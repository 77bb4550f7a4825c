"""Steps and time to 99 % in held-out pipes for an arm's training, with a supervised start and without one.

    pipenav drive --robot basic --operator scripted --pipes taught.toml --episodes 3 --out taught
    python benchmarks/supervised_start.py taught --seeds 5 --set learner.noise_start=0.1 learner.learning_rate=3e-4

Trains the preset `arm` without the recordings, without them but with the settings of `--set`, and with both, for each
seed in turn, and measures the policy in the set `working-range` after every 3,000 steps, until 99 % of the episodes
pass. Times are those of the processor, with the supervised start and without these measurements. The first row of a
training with a supervised start is the policy right after that start. At the end it prints steps and seconds to 99 %
for each kind: median and range over the seeds. A training takes about 15 s of a processor.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

from pipenav.evaluation.passage import run_task
from pipenav.learning.config import TrainConfig, load_config
from pipenav.learning.progress import TrainingProgress
from pipenav.learning.train import train
from pipenav.learning.training_folder import TrainingFolder
from pipenav.policies.named import PolicyController
from pipenav.policies.policy import load_policy
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.registry import task_of

HELD_OUT, EPISODES, SEED = "working-range", 2, 77
EVERY, CHECKED = 3_000, 20
GOOD = 0.99
KINDS = ["plain", "settings", "recordings"]
"""Kinds of training: as the preset says, with the settings of `--set`, and with these and the recordings."""


class HeldOut:
    """Measures the policy of every check in held-out pipes."""

    def __init__(self, folder: TrainingFolder, config: TrainConfig) -> None:
        self.folder, self.config = folder, config
        self.pipes = task_of(config.task).parse_pipes([HELD_OUT])
        self.begun, self.spent, self.rows, self.good = time.process_time(), 0.0, [], False
        self._checked = -1

    def report(self, progress: TrainingProgress) -> None:
        """Measure the policy in last.zip, which is that of the newest check."""
        if np.isnan(progress.check_seconds) or progress.check_steps == self._checked:
            return
        self._checked = progress.check_steps
        self.measure(progress.check_steps)

    def measure(self, steps: int) -> None:
        """Add a row: control steps, seconds of the processor, success in held-out pipes."""
        begun = time.process_time()
        seconds = begun - self.begun - self.spent
        controller = PolicyController(load_policy(self.folder.last))
        results = run_task(controller, self.pipes, EPISODES, SEED)
        success = float((results.outcome == Outcome.REACHED).mean())
        self.spent += time.process_time() - begun
        self.rows.append((steps, round(seconds, 1), success))
        self.good = self.good or success >= GOOD
        print(f"    {steps:7,} steps {seconds:6.1f} s {success:7.2%}", flush=True)


def trained(config: TrainConfig) -> HeldOut:
    """Train until the policy is good, or to the end."""
    with tempfile.TemporaryDirectory() as path:
        folder = TrainingFolder.create(Path(path) / "training", config, "benchmark")
        held_out = HeldOut(folder, config)
        train(config, folder, report=held_out.report, should_stop=lambda: held_out.good)
        return held_out


def summary(rows_of_seeds: list[list[tuple[int, float, float]]]) -> str:
    """Steps and seconds to `GOOD` of several trainings: median and range; a training that did not get there is last."""
    never = (float("inf"), float("inf"))
    reached = [next(((n, s) for n, s, success in rows if success >= GOOD), never) for rows in rows_of_seeds]
    words = []
    for values, unit in zip(zip(*reached, strict=True), ("steps", "s"), strict=True):
        middle = statistics.median(values)
        words.append(f"{middle:,.5g} {unit} ({min(values):,.5g} to {max(values):,.5g})")
    there = sum(one != never for one in reached)
    return f"{there} of {len(reached)} came to {GOOD:.0%}, in {' and '.join(words)}"


def main() -> None:
    """Train, measure, and print every row."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="+")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--set", nargs="*", default=[], help="settings of all but the plain training")
    parser.add_argument("--only", nargs="+", choices=KINDS, default=KINDS)
    arguments = parser.parse_args()
    results: dict[str, list[list[tuple[int, float, float]]]] = {name: [] for name in arguments.only}
    for seed in range(arguments.first, arguments.first + arguments.seeds):
        for name in arguments.only:
            print(f"seed {seed}, {name}", flush=True)
            own = [] if name == "plain" else arguments.set
            more = {"recordings.folders": arguments.recordings} if name == "recordings" else {}
            options = {"seed": seed, "check.every": EVERY, "check.episodes": CHECKED, **more}
            results[name].append(trained(load_config("arm", settings=own, options=options)).rows)
    print(json.dumps(results))
    for name, rows in results.items():
        print(f"{name}: {summary(rows)}")


if __name__ == "__main__":
    main()
