"""Backend plugins as their distributions declare them: found without importing anything.

A plugin is any installed distribution with an entry point in the group `pipenav.backends`; pipenav's own backends are
declared in the same way.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import entry_points

GROUP = "pipenav.backends"
"""Entry-point group in which distributions declare backends."""

NONE_INSTALLED = "no installed distribution declares a backend"
"""Problem where there is no backend at all."""

INSTALL_PIPENAV = "install pipenav itself (pip install -e . in a checkout)"
"""Remedy where there is no backend at all: pipenav's own come with its installation."""


@dataclass(frozen=True)
class BackendPlugin:
    """A backend that a distribution declares; nothing of it has been imported.

    Attributes:
        name: name that a person types.
        value: place of its class, `module:attribute`.
        distribution: distribution that declares it.
        version: version of the distribution.
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

    @property
    def report(self) -> str:
        """Remedy for a flaw of the plugin."""
        return f"report it to the authors of {self.origin}"


def find_backends() -> dict[str, BackendPlugin]:
    """Installed backends by name. Reads metadata only."""
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
