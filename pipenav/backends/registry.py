"""Backend plugins: listed without importing anything, loaded one at a time.

A plugin is any installed distribution with an entry point in the group `pipenav.backends`; pipenav's own enter by the
same door. A plugin declares what it needs by importing it at the top of its module (`pipenav.backends.source_imports`), and the
command that brings it by the requirements and extras of its distribution.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points, requires
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, cast

from pydantic import ValidationError

from pipenav.backends.backend import Backend, BackendOptions, Simulator
from pipenav.backends.source_imports import can_find, imported_packages
from pipenav.backends.spatial import SpaceBackend
from pipenav.errors import BackendUnavailable, ConfigError, PipenavError, UnknownName
from pipenav.robots.robot import RobotSpec

GROUP = "pipenav.backends"

NONE_INSTALLED = (
    "no installed distribution declares a backend",
    "install pipenav itself (pip install -e . in a checkout)",
)
"""What is missing, and the remedy, where there is no backend at all: pipenav's own come with its installation."""

_DISTRIBUTION_OF = {"serial": "pyserial", "OpenGL": "pyopengl", "cv2": "opencv-python", "yaml": "pyyaml"}
"""Distributions that are not named like their module."""

_LAST_PYTHON = {"pybullet": (3, 11)}
"""Modules that have no wheels for later versions of Python (pybullet 3.2.7: Linux wheels for 3.10 and 3.11)."""


class Constructor(Protocol):
    """How a backend's class is called, see `Backend`."""

    def __call__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int) -> Backend: ...


@dataclass(frozen=True)
class BackendPlugin:
    """A backend that a distribution declares; nothing of it has been imported.

    Attributes:
        name: what a person types.
        value: where its class is, `module:attribute`.
        distribution: who declares it.
        version: of the distribution.
        rivals: other distributions that declare the same name, with their versions.
    """

    name: str
    value: str
    distribution: str
    version: str
    rivals: tuple[str, ...] = ()

    @property
    def module(self) -> str:
        return self.value.partition(":")[0].strip()

    @property
    def origin(self) -> str:
        return f"{self.distribution} {self.version}"


class Availability(NamedTuple):
    """Whether a plugin can be loaded here; if not, what is missing and what to do about it."""

    can_load: bool
    missing: str = ""
    remedy: str = ""


def find_backends() -> dict[str, BackendPlugin]:
    """The installed backends by name. Reads metadata only."""
    found: dict[str, list[BackendPlugin]] = {}
    for point in entry_points(group=GROUP):
        who, version = (point.dist.name, point.dist.version) if point.dist else ("an unknown distribution", "?")
        found.setdefault(point.name, []).append(BackendPlugin(point.name, point.value, who, version))
    backends = {}
    for name in sorted(found):
        first, *others = sorted(found[name], key=lambda plugin: plugin.distribution)
        rivals = tuple(plugin.origin for plugin in others)
        backends[name] = BackendPlugin(name, first.value, first.distribution, first.version, rivals)
    return backends


def availability(plugin: BackendPlugin) -> Availability:
    """Whether `load_backend` would find all that the plugin's module imports. Imports nothing."""
    if plugin.rivals:
        names = [plugin.distribution, *(rival.rpartition(" ")[0] for rival in plugin.rivals)]
        both = " and ".join([plugin.origin, *plugin.rivals])
        remedy = "uninstall one of them: " + " or ".join(f"pip uninstall {name}" for name in names)
        return Availability(False, f"{both} both declare it", remedy)
    try:
        needed = list(imported_packages(plugin.module))
    except (SyntaxError, ValueError, OSError) as error:
        return Availability(
            False, f"its source cannot be read: {error}", f"report it to the authors of {plugin.origin}"
        )
    for module in needed:
        if not can_find(module):
            return Availability(False, f"Python module {module!r} is not installed", _remedy(plugin, module))
    return Availability(True)


def load_backend(name: str) -> type[Backend]:
    """Import one backend's class.

    Raises:
        UnknownName: no installed distribution declares it.
        BackendUnavailable: two declare it, its import fails, or what it names is no usable backend.
    """
    plugin = _find(name)
    if plugin.rivals:
        raise BackendUnavailable(name, *availability(plugin)[1:])
    try:
        loaded = EntryPoint(plugin.name, plugin.value, GROUP).load()
    except ImportError as error:
        raise _not_importable(plugin, error) from error
    except Exception as error:  # a stranger's module may raise anything, and only its own backend may suffer
        raise BackendUnavailable(
            name, f"importing {plugin.module} fails with {_one_line(error)}", _report_to(plugin)
        ) from error
    flaw = _flaw(loaded)
    if flaw:
        raise BackendUnavailable(name, f"{plugin.value} {flaw}", _report_to(plugin))
    return cast(type[Backend], loaded)


def open_backend(
    name: str, robot: RobotSpec, n: int, options: Mapping[str, Any] | BackendOptions, wall_segments: int = 4
) -> Backend:
    """Load a backend and construct it.

    Args:
        name: as `find_backends` lists it.
        robot: the robot.
        n: how many robots.
        options: an instance of the backend's `Options`, or a table to validate as one.
        wall_segments: the most wall segments that any pipe will have.

    Raises:
        UnknownName, BackendUnavailable: as `load_backend`, also for imports that the constructor makes.
        ConfigError: the options do not fit.
    """
    kind = load_backend(name)
    checked = check_options(name, kind, options)
    try:
        return construct(kind, robot, n, checked, wall_segments)
    except ImportError as error:
        raise _not_importable(_find(name), error) from error


def construct(
    kind: type[Backend], robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int = 4
) -> Backend:
    """Construct a backend of a class, which `Backend` says how to call."""
    return cast(Constructor, kind)(robot, n, options, wall_segments)


def load_simulator(name: str) -> type[Simulator]:
    """Import the class of a backend that is a simulator.

    Raises:
        UnknownName: no installed distribution declares it.
        BackendUnavailable: it cannot be loaded, or it is no simulator.
    """
    kind = load_backend(name)
    if not issubclass(kind, Simulator):
        raise BackendUnavailable(name, "it is no simulator", "choose --backend mujoco; see pipenav backends")
    return kind


def open_simulator(
    name: str, robot: RobotSpec, n: int, options: Mapping[str, Any] | BackendOptions, wall_segments: int = 4
) -> Simulator:
    """Load a simulator and construct it, as `open_backend` does.

    Raises:
        UnknownName, BackendUnavailable, ConfigError: see `open_backend`; also where the backend is no simulator.
    """
    load_simulator(name)
    return cast(Simulator, open_backend(name, robot, n, options, wall_segments))


class SimulatorSettings(NamedTuple):
    """Which simulator, with which settings of its own; see `open_simulator`."""

    backend: str = "mujoco"
    options: Mapping[str, Any] = MappingProxyType({})

    def open(self, robot: RobotSpec, n: int, wall_segments: int = 4) -> Simulator:
        """The simulator with n robots, as `open_simulator` gives it."""
        return open_simulator(self.backend, robot, n, self.options, wall_segments)


DEFAULT_SIMULATOR = SimulatorSettings()


def load_spatial(name: str) -> type[Simulator]:
    """Import the class of a simulator that moves robots in space.

    Raises:
        PipenavError: it moves them in a plane alone.
        UnknownName, BackendUnavailable: see `load_simulator`.
    """
    kind = load_simulator(name)
    if not kind.moves_in_space:
        raise PipenavError(
            f"backend {name!r} moves robots in a plane alone: choose --backend mujoco, or routes without rolls, as "
            "runs-level."
        )
    return kind


def open_space(
    name: str, robot: RobotSpec, n: int, options: Mapping[str, Any] | BackendOptions, gravity: float
) -> SpaceBackend:
    """Load a simulator and construct its robots in space.

    Raises:
        PipenavError: the simulator moves robots in a plane alone.
        UnknownName, BackendUnavailable, ConfigError: see `open_backend`.
    """
    kind = load_spatial(name)
    return kind.in_space(robot, n, check_options(name, kind, options), gravity)


def check_options(name: str, kind: type[Backend], options: Mapping[str, Any] | BackendOptions) -> BackendOptions:
    """Options as an instance of the backend's own class.

    Raises:
        ConfigError: an unknown key or a wrong value, or the options of another backend.
    """
    if isinstance(options, BackendOptions):
        if not isinstance(options, kind.Options):
            given = type(options).__name__
            raise ConfigError(f"backend {name!r} takes {kind.Options.__name__}, given {given}.")
        return options
    try:
        return kind.Options.model_validate(dict(options))
    except ValidationError as error:
        raise ConfigError.from_validation(f"options of backend {name!r}", error, kind.Options.model_fields) from error


def _find(name: str) -> BackendPlugin:
    backends = find_backends()
    if not backends:
        raise BackendUnavailable(name, *NONE_INSTALLED)
    if name not in backends:
        raise UnknownName("backend", name, backends)
    return backends[name]


def _flaw(loaded: object) -> str:
    """What keeps a loaded object from being a backend; empty if nothing does."""
    if not (inspect.isclass(loaded) and issubclass(loaded, Backend)):
        return "is not a subclass of pipenav.backends.Backend"
    if inspect.isabstract(loaded):
        return f"does not implement {', '.join(sorted(loaded.__abstractmethods__))}"
    options = getattr(loaded, "Options", None)
    if not (inspect.isclass(options) and issubclass(options, BackendOptions)):
        return "has no Options derived from pipenav.backends.BackendOptions"
    return ""


def _not_importable(plugin: BackendPlugin, error: ImportError) -> BackendUnavailable:
    if isinstance(error, ModuleNotFoundError) and error.name:
        missing = f"Python module {error.name!r} is not installed"
        return BackendUnavailable(plugin.name, missing, _remedy(plugin, error.name))
    remedy = f"reinstall what the message names, or {_report_to(plugin)}"
    return BackendUnavailable(plugin.name, _one_line(error), remedy)


def _report_to(plugin: BackendPlugin) -> str:
    return f"report it to the authors of {plugin.origin}"


def _remedy(plugin: BackendPlugin, module: str) -> str:
    """The command that brings a missing module."""
    top = module.partition(".")[0]
    if top == plugin.module.partition(".")[0]:
        return f"reinstall it: pip install --force-reinstall {plugin.distribution}"
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


def _one_line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
