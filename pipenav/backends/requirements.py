"""Requirements of backend plugins: what is missing for one here, and the command that brings it. Imports nothing.

A plugin declares what it needs by importing it at the top of its module (`pipenav.backends.source_imports`), and how it
is installed by the requirements and extras of its distribution.
"""

from __future__ import annotations

import re
import sys
from importlib.metadata import requires
from typing import NamedTuple

from pipenav.backends.moved import UPDATE, no_longer_here, outdated
from pipenav.backends.plugins import BackendPlugin
from pipenav.backends.source_imports import can_find, imported_modules

_DISTRIBUTION_OF = {"serial": "pyserial", "OpenGL": "pyopengl", "cv2": "opencv-python", "yaml": "pyyaml"}
"""Distributions that are not named like their module."""

_LAST_PYTHON = {"pybullet": (3, 11)}
"""Modules that have no wheels for later versions of Python (pybullet 3.2.7: Linux wheels for 3.10 and 3.11)."""


class Availability(NamedTuple):
    """Whether a plugin can be loaded here; if not, what is missing and what to do about it."""

    can_load: bool
    missing: str = ""
    remedy: str = ""


def availability(plugin: BackendPlugin) -> Availability:
    """Whether `load_backend` would find all that the plugin's module imports. Imports nothing."""
    if plugin.rivals:
        names = [plugin.distribution, *(rival.rpartition(" ")[0] for rival in plugin.rivals)]
        both = " and ".join([plugin.origin, *plugin.rivals])
        remedy = "uninstall one of them: " + " or ".join(f"pip uninstall {name}" for name in names)
        return Availability(False, f"{both} both declare it", remedy)
    try:
        needed = list(imported_modules(plugin.module))
    except (SyntaxError, ValueError, OSError) as error:
        return Availability(False, f"its source cannot be read: {error}", plugin.report)
    if old := outdated(needed):
        return Availability(False, old, UPDATE)
    for top in dict.fromkeys(name.partition(".")[0] for name in needed):
        if not can_find(top):
            return without(plugin, top)
    return Availability(True)


def without(plugin: BackendPlugin, module: str) -> Availability:
    """Availability of a plugin that imports a module which is not here, or which has another name now."""
    if old := outdated([module]):
        return Availability(False, old, UPDATE)
    if module.startswith("pipenav."):
        return Availability(False, no_longer_here(module), UPDATE)
    return Availability(False, f"Python module {module!r} is not installed", _remedy(plugin, module))


def _remedy(plugin: BackendPlugin, module: str) -> str:
    """Command that brings a missing module."""
    top = module.partition(".")[0]
    if top == plugin.module.partition(".")[0]:
        return f"reinstall {plugin.distribution} from where you got it"
    command = _install_command(plugin, top)
    last = _LAST_PYTHON.get(top)
    if last and sys.version_info[:2] > last:
        here, newest = (".".join(map(str, version)) for version in (sys.version_info[:2], last))
        return f"it has no wheels for Python {here}: use Python {newest}, and there {command}"
    return command


def _install_command(plugin: BackendPlugin, top: str) -> str:
    project = _normalised(_DISTRIBUTION_OF.get(top, top))
    requirements = requires(plugin.distribution) or []
    ours = [text for text in requirements if _normalised(re.split(r"[^\w.-]", text, maxsplit=1)[0]) == project]
    extras = [extra for text in ours for extra in re.findall(r"extra\s*==\s*['\"]([^'\"]+)['\"]", text)]
    if extras:
        extra = plugin.name if plugin.name in extras else extras[0]
        return f"pip install '{plugin.distribution}[{extra}]'"
    if ours:
        return f"pip install {plugin.distribution}"
    return f"install the package that brings it, which {plugin.origin} does not declare"


def _normalised(project: str) -> str:
    return re.sub(r"[-_.]+", "-", project).lower()
