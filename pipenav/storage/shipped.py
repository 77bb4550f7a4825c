"""Place of the data that pipenav ships: beside the package in a checkout, inside it when installed."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent


def data_root() -> Path:
    """The folder that holds `pipes/` and `models/`."""
    installed = _PACKAGE / "_data"
    return installed if installed.is_dir() else _PACKAGE.parent


def pipes_dir() -> Path:
    """Folder of the shipped sets of corners; `runs/` in it holds the sets of routes."""
    return data_root() / "pipes"


def starts_dir() -> Path:
    """Folder of the shipped sets of starts."""
    return pipes_dir() / "starts"


def robots_dir() -> Path:
    """Folder that holds one folder per shipped robot, with its robot.toml."""
    return data_root() / "models" / "robots"


def policies_dir() -> Path:
    """Folder of the shipped policies."""
    return data_root() / "models" / "policies"


def presets_dir() -> Path:
    """Folder of the training presets."""
    return _PACKAGE / "learning" / "presets"


def spaces_dir() -> Path:
    """Folder of the search spaces of `pipenav tune`."""
    return _PACKAGE / "tuning" / "spaces"


def disturbances_dir() -> Path:
    """Folder of the named disturbances."""
    return _PACKAGE / "disturbances"


def mappings_dir() -> Path:
    """Folder of the mappings of keys, buttons and faders of `pipenav drive`."""
    return _PACKAGE / "driving" / "mappings"
