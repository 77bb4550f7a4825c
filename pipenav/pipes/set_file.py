"""Parts of all files that describe sets of pipes: numbers as a list or a range, and how such a file is read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from pipenav.errors import ConfigError, first_problem
from pipenav.storage.text_files import read_toml

_File = TypeVar("_File", bound=BaseModel)

MAX_STEPS = 1000
"""Most steps of a range: more is a slip of the keyboard."""


MAX_CORNERS = 10_000
"""Most corners of a set: several times the largest that is shipped."""

MAX_TURNS = 100
"""Most entries in a list of turns."""


class Range(BaseModel):
    """Evenly spaced values, both ends included."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    start: float
    stop: float
    step: float = Field(gt=0)

    @model_validator(mode="after")
    def _whole_steps(self) -> Range:
        steps = (self.stop - self.start) / self.step
        if not 0 <= steps <= MAX_STEPS or abs(steps - round(steps)) > 1e-6:
            raise PydanticCustomError(
                "whole_steps",
                f"from {self.start:g} up to {self.stop:g} must be a whole number of steps of {self.step:g}, "
                f"at most {MAX_STEPS}",
            )
        return self

    def values(self) -> list[float]:
        count = round((self.stop - self.start) / self.step) + 1
        return [round(float(x), 6) for x in np.linspace(self.start, self.stop, count)]


_List = Annotated[list[float], Field(min_length=1, max_length=MAX_STEPS + 1)]
Values = Annotated[
    Annotated[_List, Tag("<list>")] | Annotated[Range, Tag("<range>")],
    Discriminator(lambda given: "<range>" if isinstance(given, dict | Range) else "<list>"),
]
"""Numbers in a set's file: a list, or a range with both ends. Only the kind that was meant reports a problem."""


def too_large(count: int) -> ConfigError:
    """The error that refuses a set of so many corners."""
    return ConfigError(f"a set of {count:,} corners is too large: give it {MAX_CORNERS:,} at most.")


def values_of(given: Values) -> list[float]:
    """The numbers that were given, one by one."""
    return given.values() if isinstance(given, Range) else given


def read_as(kind: type[_File], path: Path, inner: type[BaseModel] = Range) -> _File:
    """A TOML file as a model.

    Args:
        kind: model of the whole file.
        path: the file.
        inner: model of the tables in it, for the keys that a message suggests.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no TOML, or does not fit.
    """
    table = read_toml(path)
    try:
        return kind.model_validate(table)
    except ValidationError as error:
        prefix = [str(part) for part in first_problem(error)["loc"][:-1]]
        fields = (inner if prefix else kind).model_fields
        known = [".".join([*prefix, field.alias or name]) for name, field in fields.items()]
        raise ConfigError.from_validation(str(path), error, known) from error
