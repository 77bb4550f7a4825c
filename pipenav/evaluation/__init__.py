"""Evaluations: many episodes in many pipes, stage by stage, counted, and reported beside the thesis."""

from pipenav.evaluation.config import EvaluationConfig, StageName
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.passage import EpisodePlan, Passages, StageResult, run_task
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.report import write_evaluation
from pipenav.evaluation.results import Evaluation, read_evaluation

__all__ = [
    "CheckedEvaluation",
    "EpisodePlan",
    "Evaluation",
    "EvaluationConfig",
    "Passages",
    "PipeRecord",
    "StageName",
    "StageResult",
    "read_evaluation",
    "run_task",
    "wilson",
    "write_evaluation",
]
