"""The space of a search: settings of a training, and the values that each may have."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, JsonValue, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from pipenav.arrays import Table
from pipenav.errors import ConfigError, UnknownName
from pipenav.learning.config import DEFAULT_PRESET
from pipenav.storage.shipped import spaces_dir
from pipenav.storage.text_files import read_toml

DEFAULT_SPACE = "arm"

MOST_SETTINGS = 50
"""Most settings that are searched at once; a search of so many would need thousands of trials."""

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")

STAGE_STEPS = re.compile(r"stages\.[^.]+\.steps")
"""Keys of the number of steps of one stage."""

Number = int | float


class ValueRange(Table):
    """Values that a setting may have: from `low` to `high`, or one of `choices`.

    Two whole numbers stand for whole numbers only.
    """

    low: Number | None = Field(None, description="smallest value; whole numbers where both ends are whole")
    high: Number | None = Field(None, description="largest value")
    log: bool = Field(False, description="whether a factor counts alike everywhere, instead of a difference")
    choices: tuple[JsonValue, ...] | None = Field(
        None, strict=False, min_length=2, max_length=100, description="values, instead of low and high"
    )

    @model_validator(mode="after")
    def _sound(self) -> Self:
        if self.choices is not None:
            if self.low is not None or self.high is not None or self.log:
                raise PydanticCustomError("range", "give either choices, or low and high")
            if len({value_text(value) for value in self.choices}) < len(self.choices):
                raise PydanticCustomError("range", "choices: two of them are equal")
            return self
        if self.low is None or self.high is None:
            raise PydanticCustomError("range", "give low and high, or choices")
        if not self.low < self.high:
            raise PydanticCustomError("range", f"low {self.low:g} must be below high {self.high:g}")
        if self.log and self.low <= 0:
            raise PydanticCustomError("range", f"log = true needs a low above 0, given {self.low:g}")
        return self

    @property
    def whole(self) -> bool:
        """Whether the values are whole numbers from `low` to `high`."""
        return isinstance(self.low, int) and isinstance(self.high, int)

    @property
    def ends(self) -> tuple[Any, ...]:
        """The two ends, or all choices."""
        return (self.low, self.high) if self.choices is None else self.choices

    def has(self, value: Any) -> bool:
        """Whether a value is among those that the setting may have."""
        if self.choices is not None:
            return value_text(value) in map(value_text, self.choices)
        number = isinstance(value, int if self.whole else int | float) and not isinstance(value, bool)
        assert self.low is not None and self.high is not None
        return number and self.low <= value <= self.high


def value_text(value: Any) -> str:
    """A value of a setting as TOML and JSON both write it: numbers, texts, flags and lists of those."""
    return json.dumps(value)


def _flat(given: Any) -> Any:
    """Ranges by dotted keys, from tables inside each other."""
    if not isinstance(given, Mapping):
        return given
    flat: dict[str, Any] = {}
    for key, value in given.items():
        if isinstance(value, Mapping) and value and not value.keys() & ValueRange.model_fields.keys():
            flat |= {f"{key}.{inner}": one for inner, one in _flat(value).items()}
        else:
            flat[key] = value
    return flat


class SearchSpace(Table):
    """A search space, as its TOML file says."""

    description: str = Field(description="one line for `pipenav list spaces`")
    preset: str = Field(DEFAULT_PRESET, description="preset whose settings are searched")
    settings: dict[str, JsonValue] = Field(default_factory=dict, description="training settings that all trials have")
    space: Annotated[dict[str, ValueRange], BeforeValidator(_flat)] = Field(
        min_length=1,
        max_length=MOST_SETTINGS,
        description="settings to search, keys as `train --set` takes them: low, high and log, or choices, of each",
    )

    @model_validator(mode="after")
    def _keys_fit(self) -> Self:
        part = next((key for key in self.space if STAGE_STEPS.fullmatch(key)), None)
        if "steps" in self.space and part is not None:
            raise PydanticCustomError("key", f"space: steps has {part} in it: search one of them")
        for key in self.space:
            if not _BARE_KEY.fullmatch(key):
                raise PydanticCustomError(
                    "key", f"space: {key!r} is no key of a training: see pipenav list training-keys"
                )
        return self


def space_names() -> list[str]:
    """The shipped spaces."""
    return sorted(path.stem for path in spaces_dir().glob("*.toml"))


def load_space(given: str) -> SearchSpace:
    """A search space by the name of a shipped one, or by the path of its TOML file.

    Raises:
        UnknownName: neither a name nor a file.
        FileProblem: the file cannot be read.
        ConfigError: it is not the file of a space.
    """
    path = Path(given)
    if given in space_names():
        path = spaces_dir() / f"{given}.toml"
    elif path.suffix != ".toml":
        raise UnknownName("space", given, space_names())
    try:
        return SearchSpace.model_validate(read_toml(path))
    except ValidationError as error:
        raise ConfigError.from_validation(str(given), error, SearchSpace.model_fields) from error
