"""Stages of a training as tables: their keys, and how a layer of a configuration is laid over those below it.

A key that a layer gives holds in all stages of the layers below: theirs is taken out of them. The number of steps is
shared by the stages in the proportion that they have, and a layer with stages of its own brings its own number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import Field

from pipenav.arrays import Table
from pipenav.errors import ConfigError, UnknownName
from pipenav.storage.text_files import merged

DEFAULT_BACKEND = "mujoco"

MOST_STEPS = 10**12
"""Most control steps of a training: years on any machine."""

MOST_STAGES = 100

STAGES, STEPS, BACKEND, OPTIONS = "stages", "steps", "backend", "options"

_Part = Annotated[dict[str, Any], Field(min_length=1)]


class StageConfig(Table):
    """Part of a training with other settings; what it does not say is as the training says."""

    name: str = Field(
        pattern="^[a-z][a-z0-9-]{0,39}$", description="name of the stage, in reports and in --set stages.NAME.KEY=VALUE"
    )
    steps: int = Field(ge=1, le=MOST_STEPS, description="control steps of the stage, of all robots together")
    pipes: tuple[str, ...] | None = Field(
        None, strict=False, min_length=1, max_length=100, description="pipe sets to train in, in this stage"
    )
    options: _Part | None = Field(None, description="the backend's own settings in this stage")
    task: _Part | None = Field(None, description="keys of task in this stage")
    learner: _Part | None = Field(None, description="keys of learner in this stage")
    check: _Part | None = Field(None, description="keys of check in this stage")
    randomise: _Part | None = Field(None, description="keys of randomise in this stage")

    def settings(self) -> dict[str, Any]:
        """Settings in which the stage differs, keys as in the training's own table."""
        return self.model_dump(exclude={"name", "steps"}, exclude_none=True)


def laid_over(below: Mapping[str, Any], layer: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Table of a training's configuration with a layer laid over it.

    An empty table in the layer leaves nothing of the table below. Another backend leaves none of the options below:
    they are those of the backend that they were written for.

    Args:
        below: table of all layers below.
        layer: table of the layer; its `stages` are a list, or a table of changes by the stages' names.
        where: name of the layer for messages.

    Raises:
        ConfigError: steps that do not fit the stages, or a change to a stage that there is not.
    """
    if layer.get(BACKEND, _backend(below)) != _backend(below):
        below = _without(below, {OPTIONS: {}}) | {STAGES: _stages_without(below, {OPTIONS: {}})}
    said = {key: value for key, value in layer.items() if key != STAGES}
    kept = {key: value for key, value in below.items() if said.get(key) != {}}
    table = merged(kept, said)
    stages, changes = _stages_without(below, said), layer.get(STAGES)
    if isinstance(changes, Mapping):
        stages = _changed(stages, changes, where)
    elif changes is not None:
        stages = changes
    if stages or STAGES in layer:
        table[STAGES] = stages
    return _with_steps_settled(table, layer, where)


def _backend(table: Mapping[str, Any]) -> Any:
    return table.get(BACKEND, DEFAULT_BACKEND)


def _stages_without(table: Mapping[str, Any], said: Mapping[str, Any]) -> Any:
    """Stages of a table, without the settings that a layer above has said."""
    stages = table.get(STAGES) or []
    if not isinstance(stages, Sequence):
        return stages
    above = {key: value for key, value in said.items() if key != STEPS}
    return [_without(stage, above) if isinstance(stage, Mapping) else stage for stage in stages]


def _without(table: Mapping[str, Any], said: Mapping[str, Any]) -> dict[str, Any]:
    """Table without the keys that another one has; a table in it that loses all its keys is left out."""
    kept = {}
    for key, value in table.items():
        above = said.get(key)
        rest = _without(value, above) if isinstance(value, Mapping) and isinstance(above, Mapping) and above else None
        if key not in said:
            kept[key] = value
        elif rest:
            kept[key] = rest
    return kept


def _changed(stages: Any, changes: Mapping[str, Any], where: str) -> Any:
    """Stages with changes to those that are named.

    Raises:
        ConfigError: there is no such stage.
    """
    names = [str(stage.get("name")) for stage in stages if isinstance(stage, Mapping)]
    for name in changes:
        if name not in names:
            problem = UnknownName("stage", name, names) if names else f"there are no stages, given stage {name!r}"
            raise ConfigError(f"{where}: {STAGES}: {problem}")
    return [_changed_stage(stage, changes.get(stage.get("name"), {})) for stage in stages]


def _changed_stage(stage: Mapping[str, Any], change: Any) -> Any:
    if not isinstance(change, Mapping):  # the checks of the whole table will refuse it
        return change
    return {key: value for key, value in merged(stage, change).items() if change.get(key) != {}}


def _with_steps_settled(table: dict[str, Any], layer: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Table whose number of steps is that of its stages together.

    Raises:
        ConfigError: the layer says both, and they differ, or too few steps for so many stages.
    """
    counts = _step_counts(table.get(STAGES))
    if not counts:  # none, or the checks of the whole table will refuse them
        return table
    if STAGES not in layer:
        return _with_steps_shared(table, counts, where) if STEPS in layer else table
    if STEPS in layer and layer[STEPS] != sum(counts):
        raise ConfigError(
            f"{where}: steps are {layer[STEPS]} and those of the stages {sum(counts)} together: say either of them."
        )
    return table | {STEPS: sum(counts)}


def _with_steps_shared(table: dict[str, Any], counts: list[int], where: str) -> dict[str, Any]:
    """Table whose stages share its number of steps in the proportion of their own."""
    steps = table[STEPS]
    if not _is_count(steps):
        return table
    ends = [round(steps * sum(counts[: i + 1]) / sum(counts)) for i in range(len(counts))]
    shares = [end - begin for begin, end in zip([0, *ends], ends, strict=False)]
    if min(shares) < 1:
        raise ConfigError(f"{where}: steps: {steps} are too few for {len(counts)} stages: give more.")
    return table | {STAGES: [stage | {STEPS: share} for stage, share in zip(table[STAGES], shares, strict=True)]}


def _step_counts(stages: Any) -> list[int]:
    """Steps of each stage; empty where any of them is no number of steps."""
    if not isinstance(stages, Sequence) or not all(isinstance(stage, Mapping) for stage in stages):
        return []
    counts = [stage.get(STEPS) for stage in stages]
    return counts if all(_is_count(count) for count in counts) else []


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= MOST_STEPS
