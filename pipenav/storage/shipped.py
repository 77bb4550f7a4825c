"""Where the data that pipenav ships lies: beside the package in a checkout, inside it when installed."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent


def data_root() -> Path:
    """The folder that holds `pipes/` and `models/`."""
    installed = _PACKAGE / "_data"
    return installed if installed.is_dir() else _PACKAGE.parent


def pipes_dir() -> Path:
    return data_root() / "pipes"


def robots_dir() -> Path:
    return data_root() / "models" / "robots"


def policies_dir() -> Path:
    return data_root() / "models" / "policies"


def presets_dir() -> Path:
    return _PACKAGE / "learning" / "presets"


def disturbances_dir() -> Path:
    return _PACKAGE / "disturbances"
