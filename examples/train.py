"""Train a policy: python examples/train.py [STEPS] [FOLDER]"""

import sys
from pathlib import Path

from pipenav.learning.config import load_config
from pipenav.learning.train import train
from pipenav.learning.training_folder import TrainingFolder

steps = int(sys.argv[1]) if len(sys.argv) > 1 else 240_000
path = Path(sys.argv[2] if len(sys.argv) > 2 else "runs/example")

config = load_config(
    preset="arm",
    settings=["learner.epochs=4", "check.episodes=20"],  # as --set on the command line
    options={"steps": steps, "pipes": ["d=90,angle=60", "d=100,angle=90,turn=right"]},
)
folder = TrainingFolder.create(path, config, command="python examples/train.py")
summary = train(config, folder, report=lambda progress: print(f"{progress.steps:,} steps", end="\r"))
print(f"{summary.steps:,} steps in {summary.seconds:.0f} s; success of the best check {summary.check_success:.0%}")
print(f"policy: {folder.best}")
