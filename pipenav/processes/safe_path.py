"""The import path of a process of pipenav: nothing that lies in the current folder is run.

A folder that somebody has unpacked may hold a `numpy.py`. `python -m` puts the current folder first on the path, and so
does an empty entry of PYTHONPATH. This module itself may import only what Python has loaded before.
"""

import os
import sys

SAFE = "PYTHONSAFEPATH"
"""Environment variable by which Python leaves the current folder off the path of every process that inherits it."""

_left: list[bool] = []
"""Not empty once the current folder has been taken off the path."""


def leave_current_folder() -> None:
    """Keep this process, and whatever it starts, from importing from the current folder; twice is harmless."""
    if _left:
        return
    _left.append(True)
    here, named = _here(), os.environ.get("PYTHONPATH", "").split(os.pathsep)
    if not sys.flags.safe_path and sys.path and sys.path[0] in ("", here):
        del sys.path[0]  # `python -m` put it there
    if len(named) > 1 and "" in named and here not in named and here in sys.path:
        sys.path.remove(here)
    environment = safe_environment()
    os.environ.pop("PYTHONPATH", None)
    os.environ.update(environment)


def safe_environment() -> dict[str, str]:
    """The environment for a child process that is to import nothing from the current folder."""
    environment = dict(os.environ)
    environment[SAFE] = "1"
    named = environment.pop("PYTHONPATH", "")
    entries = [entry for entry in named.split(os.pathsep) if entry]  # an empty one is the current folder
    if entries:
        environment["PYTHONPATH"] = os.pathsep.join(entries)
    return environment


def _here() -> str:
    try:
        return os.getcwd()  # noqa: PTH109  # pathlib is not loaded yet
    except OSError:  # the folder has been removed
        return ""
