"""The plan of a search: its space, the training that it changes, and what every trial of it must have in common."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import JsonValue

from pipenav.errors import ConfigError, PipenavError
from pipenav.learning.config import EXTENDS, TrainConfig, load_config, nested, validate_config
from pipenav.learning.rehearsal import rehearse
from pipenav.learning.stage_tables import laid_over
from pipenav.learning.stages import require_one_interface, training_stages
from pipenav.storage.text_files import merged, read_toml
from pipenav.tuning.objective import Objective
from pipenav.tuning.space import STAGE_STEPS, SearchSpace, value_text

FREE_TASK_KEYS = frozenset({"reward", "observation", "control"})
"""Keys of a task that change how it is learned, and not what a check counts as a success."""


LAYER = "settings of a trial"
"""Name of a trial's settings in messages."""


class BaseTraining(NamedTuple):
    """The training that a search changes, as it was typed.

    Attributes:
        space: the search space, which names a preset and has settings of its own.
        file: file for `train --config`, laid over the preset.
        settings: `key=value` texts, laid over both.
        steps: control steps of each trial; None as the preset says.
        seed: seed of every trial.
    """

    space: SearchSpace
    file: Path | None
    settings: Sequence[str]
    steps: int | None
    seed: int

    def config(self, trial: Mapping[str, Any] | None = None, seed: int | None = None) -> TrainConfig:
        """Configuration with a trial's settings in it, by dotted keys.

        Raises:
            PipenavError: they do not fit each other.
        """
        common = [f"{key}={value_text(value)}" for key, value in _leaves(self.space.settings).items()]
        options = {"steps": self.steps, "seed": self.seed if seed is None else seed}
        config = load_config(self.preset, self.file, [*common, *self.settings], options)
        if not trial:
            return config
        layer: dict[str, Any] = {}
        for key, value in trial.items():
            layer = merged(layer, nested(key, value))
        return validate_config(laid_over(config.model_dump(exclude_none=True), layer, LAYER), LAYER)

    @property
    def preset(self) -> str:
        """Name of the preset below it all: what the file extends, or the space's."""
        extended = None if self.file is None else read_toml(self.file).get(EXTENDS)
        return self.space.preset if extended is None else extended


def _leaves(table: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Values of tables inside each other, by dotted keys; an empty table is a value."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            found |= _leaves(value, f"{before}{key}.")
        else:
            found[before + key] = value
    return found


class TunePlan(NamedTuple):
    """A search that has been checked.

    Attributes:
        base: training that it changes.
        config: configuration of that training as it is.
        objective: number that it makes small.
        trials: settings to try, besides those of the preset.
        again: other seeds with which the best settings and the preset are trained in the end.
        out: folder of the search.
    """

    base: BaseTraining
    config: TrainConfig
    objective: Objective
    trials: int
    again: int
    out: Path

    @property
    def space(self) -> SearchSpace:
        return self.base.space

    @property
    def request(self) -> dict[str, JsonValue]:
        """Everything that decides what the search finds, apart from how long it goes on."""
        return {
            "objective": self.objective.model_dump(mode="json"),
            "space": self.space.model_dump(mode="json")["space"],
            "training": self.config.model_dump(mode="json"),
        }

    def preset_settings(self) -> dict[str, Any] | None:
        """The searched settings as the preset has them; None where any of them is outside the space."""
        table = self.config.model_dump(mode="json")
        table["stages"] = {stage["name"]: stage for stage in table["stages"]}
        found: dict[str, Any] = {}
        for key, values in self.space.space.items():
            value = _at(table, key)
            if not values.has(value):
                return None
            found[key] = value
        return found

    def trial_config(self, settings: Mapping[str, Any], seed: int | None = None) -> TrainConfig:
        """Configuration of a trial, in which a robot has stood.

        Raises:
            PipenavError: its settings fit no training, or its checks measure something else than the preset's.
        """
        config = self.base.config(settings, seed)
        require_one_interface(config)
        _require_same_checks(config, self.config.model_copy(update={"seed": config.seed}))
        rehearse(config)
        return config


def checked_plan(base: BaseTraining, objective: Objective, trials: int, again: int, out: Path) -> TunePlan:
    """A plan whose space fits its training.

    Raises:
        PipenavError: the training itself does not fit together, a setting is not one of a training, no end of its range
            fits, or it decides what is measured.
    """
    config = base.config()
    require_one_interface(config)
    plan = TunePlan(base, config, objective, trials, again, out)
    for key, values in base.space.space.items():
        _check_key(plan, key, values.ends)
    rehearse(config)
    return plan


def _check_key(plan: TunePlan, key: str, ends: Sequence[Any]) -> None:
    """Refuse a setting of which no value fits the preset, or that decides what the search measures."""
    if plan.objective.name == "success" and (key == "steps" or STAGE_STEPS.fullmatch(key)):
        raise PipenavError(
            f"space: {key} decides how long a trial trains, and --objective success compares trials of one length: "
            "leave it out of the space, or choose --objective steps."
        )
    problems: list[PipenavError] = []
    for value in ends:
        try:
            config = plan.base.config({key: value})
        except PipenavError as problem:
            problems.append(problem)
        else:
            _require_same_checks(config, plan.config, f"space: {key}")
    if len(problems) == len(ends):
        raise ConfigError(f"space: no value of {key} fits the training: {problems[0]}") from problems[0]


def _require_same_checks(config: TrainConfig, base: TrainConfig, what: str = "a trial's settings") -> None:
    """Make sure that the last checks of a trial measure what those of the preset do.

    Raises:
        PipenavError: they do not.
    """
    mine, preset = _measured(config), _measured(base)
    for key, value in mine.items():
        if value != preset[key]:
            raise PipenavError(
                f"{what} would change {key}, and with it what the checks at the end of a trial measure: search keys of "
                "learner, network, steps and task.reward, or of stages before the last one."
            )


def _measured(config: TrainConfig) -> dict[str, Any]:
    """Everything that decides what the checks in the last stage measure."""
    last = training_stages(config)[-1].checked
    table = last.model_dump(mode="json", include={"robot", "backend", "options", "pipes", "randomise", "check", "seed"})
    table["task"] = last.task.model_dump(mode="json", exclude=set(FREE_TASK_KEYS))
    return table


def _at(table: Mapping[str, Any], key: str) -> Any:
    """Value at a dotted key; None where there is none."""
    value: Any = table
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    return value
