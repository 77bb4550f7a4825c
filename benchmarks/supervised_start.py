"""Steps and time to 99 % in held-out pipes for an arm's training, with a supervised start and without one.

    pipenav drive --robot basic --operator scripted --pipes taught.toml --episodes 3 --out taught
    python benchmarks/supervised_start.py taught --set learner.noise_start=0.1 learner.learning_rate=3e-4

Trains the preset `arm` without the recordings and with them, for each seed in turn, and measures the policy in the set
`working-range` after every 3,000 steps. Times are those of the processor, with the supervised start and without these
measurements. The first row of a training with a supervised start is the policy right after that start.
"""

from __future__ import annotations

import argparse
import json
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


def main() -> None:
    """Train, measure, and print every row."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="+")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--set", nargs="*", default=[], help="settings of the training with recordings alone")
    parser.add_argument("--only", choices=["with", "without"])
    arguments = parser.parse_args()
    kinds = {"without": {}, "with": {"recordings.folders": arguments.recordings}}
    results = {}
    for seed in range(arguments.first, arguments.first + arguments.seeds):
        for name, more in kinds.items():
            if arguments.only in (None, name):
                print(f"seed {seed}, {name} recordings", flush=True)
                own = arguments.set if name == "with" else []
                config = load_config(
                    "arm", settings=own, options={"seed": seed, "check.every": EVERY, "check.episodes": CHECKED, **more}
                )
                results[f"{name} {seed}"] = trained(config).rows
    print(json.dumps(results))


if __name__ == "__main__":
    main()
