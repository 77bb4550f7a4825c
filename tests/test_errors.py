"""Errors that a user can cause are sentences with advice."""

from __future__ import annotations

import contextlib
import errno
import importlib
import os
import pickle
import pkgutil
from pathlib import Path
from typing import Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pipenav.errors import (
    READ_REMEDIES,
    WRITE_REMEDIES,
    ConfigError,
    FileProblem,
    OutOfRange,
    PipenavError,
    UnknownName,
)


class _Inner(BaseModel):
    model_config = ConfigDict(extra="forbid")

    steps: int = Field(1, ge=1)


class _Settings(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    schema_version: Literal[1, 2]
    name: str
    sizes: tuple[float, ...] = Field((1.0,), strict=False, min_length=1)
    inner: _Inner = _Inner()


GOOD = {"schema_version": 1, "name": "it"}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"schema_version": 1}, "f: name: this key is missing, add it."),
        ({"schema_version": 1, "nam": "it"}, "f: unknown key 'nam': did you mean 'name'?"),
        (
            {**GOOD, "schema_version": 9},
            "f: schema_version: input should be 1 or 2, given 9; a newer pipenav may read it.",
        ),
        ({**GOOD, "sizes": 3}, "f: sizes: input should be a list, given 3."),
        ({**GOOD, "sizes": []}, "f: sizes: list should have at least 1 item, not 0."),
        ({**GOOD, "inner": 3}, "f: inner: input should be a table, given 3."),
        ({**GOOD, "inner": {"steps": {}}}, "f: inner.steps: input should be a valid integer, given a table."),
        ({**GOOD, "inner": {"steps": 1.5}}, "f: inner.steps: input should be a valid integer, given 1.5."),
        ("text", "f: input should be a table, given 'text'."),
    ],
)
def test_what_pydantic_found_is_said_in_plain_words(given: object, message: str) -> None:
    with pytest.raises(ValidationError) as found:
        _Settings.model_validate(given)
    assert str(ConfigError.from_validation("f", found.value, _Settings.model_fields)) == message


@pytest.mark.parametrize("number", [*READ_REMEDIES, errno.EIO])
def test_a_file_that_cannot_be_read_has_advice_where_there_is_any(number: int) -> None:
    message = str(FileProblem(Path("a.toml"), "read", OSError(number, os.strerror(number))))
    assert message.startswith(f"cannot read a.toml: {os.strerror(number)}") and message.endswith(".")
    assert (READ_REMEDIES.get(number) or "") in message


@pytest.mark.parametrize("number", WRITE_REMEDIES)
def test_a_file_that_cannot_be_written_has_advice(number: int) -> None:
    message = str(FileProblem(Path("a.toml"), "write", OSError(number, os.strerror(number))))
    assert message == f"cannot write a.toml: {os.strerror(number)}; {WRITE_REMEDIES[number]}."


def test_two_numbers_never_run_together() -> None:
    assert str(OutOfRange("diameter", 5, 40, 300, "mm")) == "diameter 5 mm is out of range: choose 40 to 300 mm."
    assert "length of straight 2, 5 mm, is out of range" in str(OutOfRange("length of straight 2", 5, 40, 300, "mm"))


def test_a_name_is_suggested_whatever_its_capitals() -> None:
    assert str(UnknownName("backend", "MuJoCo", ["mujoco", "pybullet"])).endswith("did you mean 'mujoco'?")
    assert str(UnknownName("backend", "gazebo", ["mujoco", "pybullet"])).endswith("choose 'mujoco' or 'pybullet'.")


def test_a_long_list_of_names_is_not_shown() -> None:
    message = str(UnknownName("key", "colour", [f"key{i}" for i in range(99)]))
    assert "none of the 99 known ones" in message and len(message) < 200


def users_errors() -> list[type[PipenavError]]:
    """All kinds of errors that a user can cause, of the core and of the plugins."""
    for package in ("pipenav", "pipenav_mujoco", "pipenav_pybullet", "pipenav_hardware"):
        for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
            if not module.name.endswith("__main__"):
                with contextlib.suppress(ImportError):  # a plugin whose library is not installed here
                    importlib.import_module(module.name)
    found, new = [PipenavError], [PipenavError]
    while new:
        new = [kind for parent in new for kind in parent.__subclasses__() if kind.__module__.startswith("pipenav")]
        found += new
    return found


@pytest.mark.slow
def test_every_error_comes_from_another_process_as_it_was() -> None:
    kinds = users_errors()
    assert len(kinds) > 20
    for kind in kinds:
        error = kind.__new__(kind, "a sentence.")  # composing it anew needs what each kind alone knows
        error.args = ("a sentence.",)
        error.more = ["of", "it"]
        error.unconfirmed = []  # what stops of an arm say besides
        again = pickle.loads(pickle.dumps(error))
        assert (type(again), str(again), again.more) == (kind, "a sentence.", error.more), kind
