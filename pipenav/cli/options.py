"""Options that several commands share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.recording.record import RecordingSettings

SIMULATOR = "On what"
"""Panel in a command's help of the options that choose a simulator."""

BackendOption = Annotated[
    str, typer.Option(help="Simulator backend; see `pipenav backends`.", rich_help_panel=SIMULATOR)
]
SettingsOption = Annotated[
    list[str] | None,
    typer.Option("--option", help="Backend setting, key=value; repeatable.", rich_help_panel=SIMULATOR),
]


def parse_options(given: list[str]) -> dict[str, Any]:
    """A table of `key=value` texts; values as in TOML."""
    from pipenav.learning.config import toml_value

    options = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not (equals and key.strip()):
            raise PipenavError(f"option {text!r} is not a setting: write it as key=value, for example timestep=0.001.")
        if key.strip() in options:
            raise PipenavError(f"option {key.strip()!r} is given twice: give it once.")
        options[key.strip()] = toml_value(value.strip())
    return options


def recording_settings(backend: str, given: list[str]) -> RecordingSettings:
    """The settings of a simulator that records episodes, checked.

    Raises:
        PipenavError: no such simulator, or a setting that does not fit.
    """
    from pipenav.recording.record import RecordingSettings

    return RecordingSettings(backend, checked_options(backend, given))


def checked_options(backend: str, given: list[str]) -> dict[str, Any]:
    """The settings of a simulator from `key=value` texts, checked.

    Raises:
        PipenavError: no such simulator, or a setting that does not fit.
    """
    from pipenav.backends.registry import check_options
    from pipenav.backends.simulators import load_simulator

    options = parse_options(given)
    check_options(backend, load_simulator(backend), options)
    return options
