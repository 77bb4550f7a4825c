"""Simulators by name: backends that know the truth, in the plane and in space."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, cast

from pipenav.backends.backend import BackendOptions, Simulator
from pipenav.backends.refusals import PlaneOnly
from pipenav.backends.registry import check_options, load_backend, open_backend
from pipenav.backends.spatial import SpaceBackend
from pipenav.errors import BackendUnavailable
from pipenav.robots.robot import RobotSpec


def load_simulator(name: str) -> type[Simulator]:
    """Import the class of a backend that is a simulator.

    Raises:
        UnknownName: no installed distribution declares it.
        BackendUnavailable: it cannot be loaded, or it is not a simulator.
    """
    kind = load_backend(name)
    if not issubclass(kind, Simulator):
        raise BackendUnavailable(name, "it is not a simulator", "choose one that is, such as mujoco")
    return kind


def open_simulator(
    name: str, robot: RobotSpec, n: int, options: Mapping[str, Any] | BackendOptions, wall_segments: int = 4
) -> Simulator:
    """Load a simulator and construct it, as `open_backend` does.

    Raises:
        UnknownName, BackendUnavailable, ConfigError: as `open_backend`; also where the backend is no simulator.
    """
    load_simulator(name)
    return cast(Simulator, open_backend(name, robot, n, options, wall_segments))


def load_spatial(name: str) -> type[Simulator]:
    """Import the class of a simulator that moves robots in space.

    Raises:
        PlaneOnly: it moves them in a plane alone.
        UnknownName, BackendUnavailable: as `load_simulator`.
    """
    kind = load_simulator(name)
    if not kind.moves_in_space:
        raise PlaneOnly(name)
    return kind


def open_space(name: str, robot: RobotSpec, n: int, options: Mapping[str, Any] | BackendOptions) -> SpaceBackend:
    """Load a simulator and construct its robots in space.

    Args:
        name: name as `find_backends` lists it.
        robot: the robot, with a roll joint.
        n: number of robots.
        options: an instance of the simulator's `Options`, or a table to validate as one.

    Raises:
        PlaneOnly: the simulator moves robots in a plane alone.
        UnknownName, BackendUnavailable, ConfigError: as `open_backend`.
    """
    kind = load_spatial(name)
    return kind.in_space(robot, n, check_options(name, kind, options))


CORES_OPTIONS = ("threads", "processes")
"""Settings by which simulators say how many cores they use; 0 stands for all."""


class SimulatorSettings(NamedTuple):
    """Choice of a simulator, with its own settings; see `open_simulator`."""

    backend: str = "mujoco"
    options: Mapping[str, Any] = MappingProxyType({})

    def on_cores(self, cores: int) -> SimulatorSettings:
        """The simulator with so many cores, unless its settings say how many; results do not depend on them."""
        known = load_simulator(self.backend).Options.model_fields
        given = {name: cores for name in CORES_OPTIONS if name in known and not self.options.get(name)}
        return self._replace(options={**self.options, **given})

    def open(self, robot: RobotSpec, n: int, wall_segments: int = 4) -> Simulator:
        """Open the simulator with n robots, as `open_simulator` does."""
        return open_simulator(self.backend, robot, n, self.options, wall_segments)


DEFAULT_SIMULATOR = SimulatorSettings()
