"""The configuration of a training: a preset, with a file, `--set` and options laid over it.

A preset may begin with `extends = "NAME"`: it then says only what differs from the preset of that name, which must not
extend another one itself. An empty table in it, such as `options = {}`, leaves nothing of the table below. A file for
`--config` may begin with the same key, instead of naming the preset by `--preset`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, get_args

from pydantic import BaseModel, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from pipenav.arrays import Table
from pipenav.disturbances.disturbance import UNDISTURBED, Disturbance
from pipenav.errors import ConfigError, PipenavError, UnknownName, shown
from pipenav.learning.stage_tables import (
    DEFAULT_BACKEND,
    MOST_STAGES,
    MOST_STEPS,
    STAGES,
    StageConfig,
    laid_over,
)
from pipenav.storage import shipped
from pipenav.storage.text_files import MAX_DEPTH, merged, parse_toml, read_toml
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.registry import TaskConfig

DEFAULT_PRESET = "arm"

EXTENDS = "extends"
"""Key by which a preset or a file names the preset that it differs from."""

_Widths = tuple[Annotated[int, Field(ge=1, le=4096)], ...]


MOST_WEIGHTS = 1 << 20
"""Most weights between hidden layers: with four bytes each, they fit into a policy file."""

MOST_SAMPLES = 1 << 20
"""Most control steps between two updates: the learner keeps an observation of each."""


class NetworkConfig(Table):
    """Fully connected tanh networks, widths from input to output."""

    policy: _Widths = Field((64, 64), strict=False, max_length=16, description="hidden layers of the policy")
    value: _Widths = Field((64, 64), strict=False, max_length=16, description="hidden layers of the value function")

    @model_validator(mode="after")
    def _small(self) -> NetworkConfig:
        for name, widths in (("policy", self.policy), ("value", self.value)):
            weights = sum(a * b for a, b in pairwise(widths))
            if weights > MOST_WEIGHTS:
                problem = f"{name} has {weights:,} weights between its layers, at most {MOST_WEIGHTS:,} fit into a file"
                raise PydanticCustomError("weights", problem)
        return self


class LearnerConfig(Table):
    """PPO (clip) with generalised advantage estimation."""

    robots: int = Field(192, ge=1, le=4096, description="robots that are stepped together")
    rollout_steps: int = Field(16, ge=2, le=100_000, description="control steps of each robot between two updates")
    batch_size: int = Field(512, ge=2, le=MOST_SAMPLES, description="samples of a gradient step")
    epochs: int = Field(8, ge=1, le=1000, description="passes over a rollout")
    learning_rate: float = Field(
        1e-3, ge=1e-12, description="learning rate at the start; falls linearly to a twentieth"
    )
    gamma: float = Field(0.98, ge=0, le=1, description="discount per control step")
    gae_lambda: float = Field(0.95, ge=0, le=1, description="lambda of the advantage estimate")
    clip: float = Field(0.2, ge=1e-6, le=100, description="clip range of the probability ratio")
    noise_start: float = Field(0.6, ge=1e-6, le=100, description="standard deviation of exploration at the start")
    noise_stop: float = Field(
        0.1,
        ge=1e-6,
        le=100,
        description="standard deviation from nine tenths of the steps on: the noise falls linearly, so that the policy "
        "ends up precise by itself instead of leaning on its own noise",
    )

    @model_validator(mode="after")
    def _fits(self) -> LearnerConfig:
        if (self.robots * self.rollout_steps) % self.batch_size:
            samples = self.robots * self.rollout_steps
            problem = f"batch_size {self.batch_size} must divide robots x rollout_steps = {samples}"
            raise PydanticCustomError("batch_size", problem)
        if self.robots * self.rollout_steps > MOST_SAMPLES:
            problem = f"robots x rollout_steps = {self.robots * self.rollout_steps:,}, at most {MOST_SAMPLES:,} fit"
            raise PydanticCustomError("samples", problem)
        return self


class CheckConfig(Table):
    """Checks during training: the noise-free policy on some episodes; the best one becomes best.zip."""

    every: int = Field(60_000, ge=1, le=MOST_STEPS, description="control steps between two checks")
    episodes: int = Field(
        200, ge=1, le=100_000, description="episodes of a check, spread evenly over the training pipes"
    )


class RecordingsConfig(Table):
    """A supervised start: before PPO, the policy learns to do what recordings of `pipenav drive` show."""

    folders: tuple[str, ...] = Field(
        (),
        strict=False,
        max_length=100,
        description="drive folders whose episodes are learned from; none: no such start",
    )
    failed: bool = Field(False, description="whether episodes that failed are learned from as well")
    epochs: int = Field(60, ge=1, le=10_000, description="passes over all recorded control steps")
    batch_size: int = Field(256, ge=1, le=MOST_SAMPLES, description="control steps of a gradient step")
    learning_rate: float = Field(2e-3, ge=1e-12, le=10, description="learning rate at the start; falls linearly to 0")


class TrainConfig(Table):
    """Everything that decides what a training computes."""

    description: str = Field(description="one line for `pipenav presets`")
    robot: str = Field("basic", description="robot, by name or as the path of its robot.toml")
    backend: str = Field(DEFAULT_BACKEND, description="simulator backend")
    options: dict[str, Any] = Field(default_factory=dict, description="the backend's own settings")
    pipes: tuple[str, ...] = Field(
        ("thesis-train",), strict=False, min_length=1, max_length=100, description="pipe sets to train in"
    )
    steps: int = Field(120_000, ge=1, le=MOST_STEPS, description="control steps of all robots together")
    seed: int = Field(0, ge=0, lt=2**32, description="seed of everything random")
    task: TaskConfig = ReachConfig()
    network: NetworkConfig = NetworkConfig()
    learner: LearnerConfig = LearnerConfig()
    check: CheckConfig = CheckConfig()
    randomise: Disturbance = UNDISTURBED
    recordings: RecordingsConfig = RecordingsConfig()
    stages: tuple[StageConfig, ...] = Field(
        (), strict=False, max_length=MOST_STAGES, description="parts with other settings, one after the other"
    )

    @model_validator(mode="after")
    def _stages_fit(self) -> TrainConfig:
        names = [stage.name for stage in self.stages]
        if len(set(names)) < len(names):
            problem = f"{STAGES}: two stages have one name, given {', '.join(names)}: give each its own"
            raise PydanticCustomError("stages", problem)
        together = sum(stage.steps for stage in self.stages)
        if names and together != self.steps:
            problem = f"steps: the stages have {together} steps together, given {self.steps}: make them agree"
            raise PydanticCustomError("stages", problem)
        return self

    def in_stage(self, stage: StageConfig) -> dict[str, Any]:
        """Table of this configuration as it is in one of its stages, for `validate_config`."""
        return merged(self.model_dump(exclude={STAGES}), stage.settings())


def preset_names() -> list[str]:
    """The shipped presets."""
    return sorted(path.stem for path in shipped.presets_dir().glob("*.toml"))


def load_config(
    preset: str | None = None,
    file: Path | None = None,
    settings: Sequence[str] = (),
    options: Mapping[str, Any] | None = None,
) -> TrainConfig:
    """A preset with a TOML file laid over it, and `key=value` settings and options over both.

    Args:
        preset: name of a shipped preset; None: what the file extends, or the default.
        file: TOML with any part of a TrainConfig.
        settings: `learner.epochs=4` and the like, values as in TOML.
        options: dotted keys to values; None means not given.

    Raises:
        UnknownName: no such preset or key.
        ConfigError: a value that does not fit.
        FileProblem: a file that cannot be read.
    """
    preset = preset_below(preset, file)
    table = _preset_table(preset)
    where = f"preset {preset}"
    if file is not None:
        where = str(file)
        table = laid_over(table, {key: value for key, value in read_toml(file).items() if key != EXTENDS}, where)
    typed: dict[str, Any] = {}
    for text in settings:
        key, equals, value = text.partition("=")
        if not (equals and key.strip()):
            raise PipenavError(f"{shown(text)} is not a setting: write it as key=value, for example seed=1.")
        if key.count(".") >= MAX_DEPTH:
            raise PipenavError(
                f"setting {shown(text)} has a key of more than {MAX_DEPTH} parts: see pipenav list training-keys."
            )
        typed = merged(typed, nested(key.strip(), toml_value(value.strip())))
        where = f"--set {shown(text, quoted=False)}"
    for key, value in (options or {}).items():
        if value is not None:
            typed = merged(typed, nested(key, value))
    return validate_config(laid_over(table, typed, where), where)


def preset_below(preset: str | None, file: Path | None) -> str:
    """Name of the preset that everything else is laid over: the one given, what the file extends, or the default.

    Raises:
        UnknownName: no such preset.
        ConfigError: the file extends another preset than the one given, or none that there is.
        FileProblem: the file cannot be read.
    """
    extended = None if file is None else _extended_name(read_toml(file), str(file))
    if preset is not None and extended not in (None, preset):
        raise ConfigError(f"{file} extends preset {extended!r}, given {preset!r}: leave out --preset.")
    name = preset or extended or DEFAULT_PRESET
    if name not in preset_names():
        raise UnknownName("preset", name, preset_names())
    return name


def _extended_name(table: Mapping[str, Any], where: str) -> str | None:
    """Name of the preset that a table extends, if it extends any."""
    name = table.get(EXTENDS)
    if name is None:
        return None
    if not isinstance(name, str):
        raise ConfigError(f"{where}: extends: input should be the name of a preset, given {shown(name)}.")
    if name not in preset_names():
        raise ConfigError(f"{where}: extends: {UnknownName('preset', name, preset_names())}")
    return name


def _preset_table(name: str) -> dict[str, Any]:
    """A shipped preset, with what it extends below it."""
    where, table = f"preset {name}", _read_preset(name)
    extended = _extended_name(table, where)
    if extended is None:
        return laid_over({}, table, where)
    below = _read_preset(extended)
    if EXTENDS in below:
        raise ConfigError(f"{where}: extends: preset {extended!r} extends {below[EXTENDS]!r} itself: extend that one.")
    own = {key: value for key, value in table.items() if key != EXTENDS}
    return laid_over(laid_over({}, below, f"preset {extended}"), own, where)


def _read_preset(name: str) -> dict[str, Any]:
    return read_toml(shipped.presets_dir() / f"{name}.toml")


def validate_config(table: Mapping[str, Any], where: str) -> TrainConfig:
    """A TrainConfig from plain values, sound in each of its stages; errors name `where` and the nearest key."""
    config = _validated(table, where)
    for stage in config.stages:
        _validated(config.in_stage(stage), f"{where}: stage {stage.name}")
    return config


def _validated(table: Mapping[str, Any], where: str) -> TrainConfig:
    try:
        return TrainConfig.model_validate(table)
    except ValidationError as error:
        raise ConfigError.from_validation(where, error, _keys(TrainConfig)) from error


def _keys(model: type[BaseModel], prefix: str = "") -> list[str]:
    """Every dotted key of a nested model."""
    keys = []
    for name, field in model.model_fields.items():
        keys.append(prefix + name)
        for inner in _models(field.annotation):
            keys += _keys(inner, f"{prefix}{name}.")
    return list(dict.fromkeys(keys))


def _models(annotation: Any) -> list[type[BaseModel]]:
    """The models that a field may hold."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models(part)]


def nested(dotted: str, value: Any) -> dict[str, Any]:
    """Tables inside each other with a value at a dotted key."""
    first, _, rest = dotted.partition(".")
    return {first: nested(rest, value) if rest else value}


def toml_value(text: str) -> Any:
    """A value as TOML reads it; a bare word is a string."""
    assignment = f"value = {text}"
    try:
        table = parse_toml(assignment, "a setting")
    except ConfigError as error:
        if isinstance(error.__cause__, tomllib.TOMLDecodeError):
            return text
        raise
    return table["value"] if len(table) == 1 else text
