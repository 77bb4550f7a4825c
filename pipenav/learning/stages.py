"""The stages of a training, one after the other: what each trains in, and where it begins and ends.

A training whose configuration has no stages has one, which is all of it.
"""

from __future__ import annotations

from itertools import accumulate, pairwise
from typing import Any, NamedTuple

from pipenav.errors import PipenavError
from pipenav.learning.config import NetworkConfig, TrainConfig, validate_config
from pipenav.learning.schedule import LearningRate, Schedule
from pipenav.learning.stage_tables import StageConfig
from pipenav.robots.robot import load_robot
from pipenav.tasks.registry import task_of

SCHEDULED = frozenset({"learning_rate", "noise_start", "noise_stop"})
"""Keys of the learner that fall by a schedule: a stage that says one of them begins a schedule of its own."""


class TrainingStage(NamedTuple):
    """A stage of a training.

    Attributes:
        number: place among the stages, from 1.
        label: words for reports, `coarse (1 of 2)`; empty where the training has no stages.
        config: configuration of the stage.
        checked: configuration that its checks have: the stage's own, with the physics of the last stage.
        checked_since: number of the first stage from which on checks have been the same: their results compare.
        last: whether no other stage follows.
        begin, end: control steps of the training at its beginning and at its end.
        schedule: steps over which learning rate and noise fall.
        trained_pipes: pipes of this stage and those before it, each once.
        record: words for policy files about this stage and those before it; empty where there are no stages.
    """

    number: int
    label: str
    config: TrainConfig
    checked: TrainConfig
    checked_since: int
    last: bool
    begin: int
    end: int
    schedule: Schedule
    trained_pipes: tuple[str, ...]
    record: str

    @property
    def learning_rate(self) -> LearningRate:
        return LearningRate(self.config.learner.learning_rate, self.schedule, self.end)


def training_stages(config: TrainConfig) -> tuple[TrainingStage, ...]:
    """The stages of a training, or the one that is all of it."""
    if not config.stages:
        whole = Schedule(0, config.steps)
        return (TrainingStage(1, "", config, config, 1, True, *whole, whole, config.pipes, ""),)
    ends = list(accumulate(stage.steps for stage in config.stages))
    begins, count = [0, *ends[:-1]], len(ends)
    configs = [validate_config(config.in_stage(stage), f"stage {stage.name}") for stage in config.stages]
    checked = [one.model_copy(update={"options": configs[-1].options}) for one in configs]
    schedules, since = _schedules(config.stages, begins, ends[-1]), _checked_since(checked)
    return tuple(
        TrainingStage(
            number=i + 1,
            label=f"{config.stages[i].name} ({i + 1} of {count})",
            config=configs[i],
            checked=checked[i],
            checked_since=since[i],
            last=i + 1 == count,
            begin=begins[i],
            end=ends[i],
            schedule=schedules[i],
            trained_pipes=tuple(dict.fromkeys(pipe for one in configs[: i + 1] for pipe in one.pipes)),
            record="; ".join(map(_in_words, config.stages[: i + 1])),
        )
        for i in range(count)
    )


def stage_at(stages: tuple[TrainingStage, ...], steps: int) -> TrainingStage:
    """The stage that goes on after so many control steps; the last one after its end."""
    return next((stage for stage in stages if steps < stage.end), stages[-1])


def with_steps(config: TrainConfig, steps: int) -> TrainConfig:
    """Configuration of a training that has begun, with another number of steps: that of its last stage changes.

    Raises:
        PipenavError: it would end before its last stage begins.
        ConfigError: no possible number of steps.
    """
    table = config.model_dump() | {"steps": steps}
    if config.stages:
        *before, last = table["stages"]
        begin = sum(stage["steps"] for stage in before)
        if steps <= begin:
            raise PipenavError(
                f"stage {last['name']} begins after {begin:,} steps, given {steps}: give more than that."
            )
        table["stages"] = [*before, last | {"steps": steps - begin}]
    return validate_config(table, "--resume")


def require_one_interface(config: TrainConfig) -> None:
    """Make sure that one policy can be trained in all stages.

    Raises:
        PipenavError: two stages differ in task or control, or a later one observes less or something else.
    """
    for before, stage in pairwise(training_stages(config)):
        known, observed = interface(before.config), interface(stage.config)
        as_before = observed._replace(scale=observed.scale[: len(known.scale)])
        if as_before != known:
            raise PipenavError(
                f"stage {stage.label} has another task, observation or control than the one before: one policy is "
                "trained in all stages, so give them the same."
            )


class Interface(NamedTuple):
    """Everything in which two trainings must be equal for one to take the other's weights."""

    network: NetworkConfig
    kind: str
    observation: str
    control: str
    scale: tuple[float, ...]


def interface(config: TrainConfig) -> Interface:
    """The interface of a training's policy."""
    scale = task_of(config.task).observation_scale(load_robot(config.robot)).tolist()
    return Interface(config.network, config.task.kind, config.task.observation, config.task.control, tuple(scale))


def _schedules(stages: tuple[StageConfig, ...], begins: list[int], end: int) -> list[Schedule]:
    """Schedule of each stage: from the last one before it that says a scheduled key, to the next one."""
    own = [i for i, stage in enumerate(stages) if i == 0 or SCHEDULED & (stage.learner or {}).keys()]
    starts = [max(k for k in own if k <= i) for i in range(len(stages))]
    following = [min((begins[k] for k in own if k > i), default=end) for i in range(len(stages))]
    return [Schedule(begins[start], stop) for start, stop in zip(starts, following, strict=True)]


def _checked_since(checked: list[TrainConfig]) -> list[int]:
    """Number of the stage since which each stage's checks have been the same, from the configurations of the checks."""
    since = [1]
    for number, (before, now) in enumerate(pairwise(checked), 2):
        since.append(since[-1] if _check_conditions(now) == _check_conditions(before) else number)
    return since


def _check_conditions(config: TrainConfig) -> tuple[object, ...]:
    return config.pipes, config.task, config.randomise, config.check.episodes


def _in_words(stage: StageConfig) -> str:
    said = ", ".join(f"{key}={value}" for key, value in _leaves(stage.settings()).items())
    return f"{stage.name}: {stage.steps} steps" + (f" with {said}" if said else "")


def _leaves(table: dict[str, Any], before: str = "") -> dict[str, Any]:
    """Values of nested tables by dotted keys."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            found |= _leaves(value, f"{before}{key}.")
        else:
            found[before + key] = ", ".join(map(str, value)) if isinstance(value, tuple) else value
    return found
