"""Backends by name: a plugin's class is imported, checked and constructed, one at a time."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from typing import Any, NamedTuple, Protocol, cast

from pydantic import ValidationError

from pipenav.backends import plugins
from pipenav.backends.backend import Backend, BackendOptions, Simulator
from pipenav.backends.moved import UPDATE
from pipenav.backends.plugins import GROUP, INSTALL_PIPENAV, NONE_INSTALLED, BackendPlugin
from pipenav.backends.requirements import availability, without
from pipenav.errors import BackendUnavailable, ConfigError, UnknownName
from pipenav.robots.robot import RobotSpec


class Constructor(Protocol):
    """Signature of a backend's class, see `Backend`."""

    def __call__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int) -> Backend: ...


def load_backend(name: str) -> type[Backend]:
    """Import one backend's class.

    Raises:
        UnknownName: no installed distribution declares it.
        BackendUnavailable: two declare it, its import fails, or its class is no usable backend.
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
            name, f"importing {plugin.module} fails with {_one_line(error)}", plugin.report
        ) from error
    if flaw := flaw_of(loaded):
        raise BackendUnavailable(name, f"{plugin.value} {flaw.what}", flaw.remedy or plugin.report)
    return cast(type[Backend], loaded)


def open_backend(
    name: str, robot: RobotSpec, n: int, options: Mapping[str, Any] | BackendOptions, wall_segments: int = 4
) -> Backend:
    """Load a backend and construct it.

    Args:
        name: name as `find_backends` lists it.
        robot: the robot.
        n: number of robots.
        options: an instance of the backend's `Options`, or a table to validate as one.
        wall_segments: largest number of wall segments of any pipe.

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
    """Construct a backend of a class, in the way that `Backend` describes."""
    return cast(Constructor, kind)(robot, n, options, wall_segments)


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


class Flaw(NamedTuple):
    """Reason why an object is no backend, as the end of a sentence about it, and a remedy where there is one."""

    what: str
    remedy: str = ""


def flaw_of(loaded: object) -> Flaw | None:
    """Flaw that keeps an object from being a backend's class; None if there is none."""
    if not (inspect.isclass(loaded) and issubclass(loaded, Backend)):
        return Flaw("is not a subclass of pipenav.backends.Backend")
    if not issubclass(loaded, Simulator) and hasattr(loaded, "truth"):
        what = "defines truth, as only a simulator does, but does not derive from pipenav.backends.Simulator"
        return Flaw(what, UPDATE)
    if inspect.isabstract(loaded):
        return Flaw(f"does not implement {', '.join(sorted(loaded.__abstractmethods__))}")
    options = getattr(loaded, "Options", None)
    if not (inspect.isclass(options) and issubclass(options, BackendOptions)):
        return Flaw("has no Options derived from pipenav.backends.BackendOptions")
    return None


def _find(name: str) -> BackendPlugin:
    backends = plugins.find_backends()
    if not backends:
        raise BackendUnavailable(name, NONE_INSTALLED, INSTALL_PIPENAV)
    if name not in backends:
        raise UnknownName("backend", name, backends)
    return backends[name]


def _not_importable(plugin: BackendPlugin, error: ImportError) -> BackendUnavailable:
    known = availability(plugin)
    if not known.can_load:  # the source tells more than an error about its first line does
        return BackendUnavailable(plugin.name, known.missing, known.remedy)
    if isinstance(error, ModuleNotFoundError) and error.name:
        lacking = without(plugin, error.name)
        return BackendUnavailable(plugin.name, lacking.missing, lacking.remedy)
    remedy = f"reinstall what the message names, or {plugin.report}"
    return BackendUnavailable(plugin.name, _one_line(error), remedy)


def _one_line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
