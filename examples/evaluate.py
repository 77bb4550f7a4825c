"""Measure a policy: python examples/evaluate.py [EPISODES] [FOLDER] [POLICY]"""

import sys
from pathlib import Path

from pipenav.evaluation import CheckedEvaluation, EvaluationConfig, write_evaluation

episodes = int(sys.argv[1]) if len(sys.argv) > 1 else 20
folder = Path(sys.argv[2] if len(sys.argv) > 2 else "runs/example-evaluation")
policy = sys.argv[3] if len(sys.argv) > 3 else "arm"  # a shipped policy's name, or best.zip

config = EvaluationConfig(policy=policy, pipes=("d=90,angle=60", "d=90,angle=60,turn=right"), episodes=episodes, seed=1)
evaluation = CheckedEvaluation(config).run()
write_evaluation(folder, evaluation)

for pipe in evaluation.pipes:
    print(f"{pipe.diameter_mm:g} mm, {pipe.angle_deg:g} deg, {pipe.turn}: {pipe.successes} of {pipe.episodes}")
print(f"all: {evaluation.success:.1%} ({evaluation.success_low:.1%} to {evaluation.success_high:.1%})")
