"""Which trainings and evaluations an experiment still needs."""

from __future__ import annotations

from pipenav.experiments.definition import load_agents, load_experiment
from pipenav.experiments.jobs import measurements, trainings
from pipenav.experiments.plan import ExperimentPlan, resolved_agent


def test_the_best_agent_is_taken_over(thesis_plan: ExperimentPlan) -> None:
    (row,) = load_experiment("d").rows
    assert resolved_agent(thesis_plan, row) == "position-history-c3-1_5"


def test_what_is_there_is_not_done_again(thesis_plan: ExperimentPlan) -> None:
    assert measurements(thesis_plan, ("reach", "reach-rear", "locate", "passage")) == []
    assert len(trainings(thesis_plan)) == 2 * len(load_agents())
