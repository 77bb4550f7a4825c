"""The experiments as they are defined: they fit the tables of the thesis, and every agent is one of its recipes."""

from __future__ import annotations

import pytest
from helpers.thesis_results import thesis_figures

from pipenav.evaluation.thesis import thesis_rows
from pipenav.experiments.definition import agents_of, chosen, experiment_names, load_agents, load_experiment


@pytest.mark.parametrize("name", experiment_names())
def test_every_row_that_names_a_table_stands_in_it(name: str) -> None:
    for row in load_experiment(name).rows:
        assert bool(thesis_figures(row.table, row.label)) == (row.table is not None)


def test_every_row_of_the_thesis_stands_in_an_experiment() -> None:
    ours = {(row.table, row.label) for name in experiment_names() for row in load_experiment(name).rows}
    assert {(row.table, row.agent) for row in thesis_rows()} <= ours


@pytest.mark.parametrize("agent", load_agents())
def test_every_agent_is_a_recipe_of_the_thesis(agent: str) -> None:
    config = load_agents()[agent].config(seed=3, steps=None)
    assert config.seed == 3
    assert config.steps == 120_000
    assert config.pipes == ("thesis-train",)
    assert config.task.control == ("torque" if agent.startswith("torque") else "position")
    assert config.task.observation == ("basic" if "basic" in agent else "history")
    assert agent in agents_of(chosen("all"))


def test_an_agent_that_several_experiments_show_is_trained_once() -> None:
    names = agents_of(chosen("all"))
    assert len(names) == len(set(names)) == len(load_agents())
