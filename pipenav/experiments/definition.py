"""An experiment: what it trains and measures, as its TOML file says."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any, Self

from pydantic import Field, TypeAdapter, ValidationError, model_validator

from pipenav.arrays import Table
from pipenav.errors import ConfigError, UnknownName
from pipenav.evaluation.config import StageName
from pipenav.learning.config import TrainConfig, load_config
from pipenav.locating.locator import Variant
from pipenav.storage.text_files import read_toml

FOLDER = Path(__file__).parent
ALL = "all"
BEST_OF = "best of "
"""Beginning of the name of an agent that is the best one of another experiment."""


class Agent(Table):
    """A training recipe: a preset with settings laid over it."""

    preset: str
    settings: dict[str, Any] = Field(default_factory=dict, description="dotted keys of TrainConfig")

    def config(self, seed: int, steps: int | None, backend: str | None = None) -> TrainConfig:
        """The resolved configuration; None keeps the preset's."""
        return load_config(self.preset, options={**self.settings, "seed": seed, "steps": steps, "backend": backend})


class Row(Table):
    """A row of an experiment's table: an agent in a stage, or a stage that needs none.

    `table` and `label` name the thesis's row that it stands beside, if the thesis has one.
    """

    label: str
    note: str | None = Field(None, description="words that set it apart from a row of the same label")
    agent: str | None = None
    robot: str | None = Field(None, description="robot of a stage without an agent")
    stage: StageName = "reach"
    variant: Variant = Field("map", description="how the stages that locate a target do it")
    table: str | None = Field(None, description="the thesis's table, e.g. 5.1")
    candidate: bool = Field(True, description="whether the experiment's best agent is chosen from it too")

    @property
    def title(self) -> str:
        """The row's label, and its note if it has one."""
        return f"{self.label}, {self.note}" if self.note else self.label

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if (self.agent is None) != (self.stage == "locate"):
            raise ValueError("every stage but locate needs an agent, and locate has none")
        if (self.robot is None) != (self.stage != "locate"):
            raise ValueError("only the stage locate names a robot; an agent brings its own")
        return self


class Experiment(Table):
    """An experiment of the thesis.

    Attributes:
        title, question, finding: subject, question, and what the thesis found.
        rows: rows of its table.
        pipes: pipes in which its rows are measured.
    """

    title: str
    question: str
    finding: str
    rows: tuple[Row, ...] = Field(min_length=1, strict=False)
    pipes: str = "thesis"


def experiment_names() -> list[str]:
    """The shipped experiments."""
    return sorted(path.stem for path in FOLDER.glob("?.toml"))


def chosen(name: str) -> list[str]:
    """The experiments that a name stands for: one, or all of them.

    Raises:
        UnknownName: no such experiment.
    """
    if name == ALL:
        return experiment_names()
    if name not in experiment_names():
        raise UnknownName("experiment", name, [*experiment_names(), ALL])
    return [name]


@lru_cache(maxsize=8)
def load_experiment(name: str) -> Experiment:
    """A shipped experiment."""
    return _checked(Experiment, FOLDER / f"{name}.toml")


@lru_cache(maxsize=1)
def load_agents() -> dict[str, Agent]:
    """The agents by name."""
    table = read_toml(FOLDER / "agents.toml")
    return TypeAdapter(dict[str, Agent]).validate_python(table)


def _checked(model: type[Experiment], path: Path) -> Experiment:
    try:
        return model.model_validate(read_toml(path))
    except ValidationError as error:
        raise ConfigError.from_validation(str(path), error, model.model_fields) from error


def agents_of(experiments: list[str]) -> list[str]:
    """The agents that these experiments need, each once, in order, with those that the best agent is chosen from."""
    names: dict[str, None] = {}
    for experiment in experiments:
        for row in load_experiment(experiment).rows:
            if row.agent is None:
                continue
            if row.agent.startswith(BEST_OF):
                names |= dict.fromkeys(agents_of([row.agent.removeprefix(BEST_OF)]))
            else:
                names[row.agent] = None
    return list(names)
