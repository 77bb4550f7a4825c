"""Places by name, as distributions declare them in the entry-point group `pipenav.places`."""

from __future__ import annotations

import inspect
from importlib.metadata import entry_points

from pipenav.errors import PipenavError, UnknownName
from pipenav.jobs.here import HerePlace
from pipenav.jobs.place import Place

GROUP = "pipenav.places"
"""Entry-point group in which distributions declare places."""

PROCESSES, CLUSTER = "processes", "ray"
"""Names of the places that `--jobs` and `--cluster` choose."""

INSTALL = {CLUSTER: "pip install 'pipenav[ray]'"}
"""Remedy where a place of ours lacks what it needs."""


def load_place(name: str) -> type[Place]:
    """Import the class of one place.

    Raises:
        UnknownName: no installed distribution declares it.
        PipenavError: two declare it, its import fails, or it is no place.
    """
    points = entry_points(group=GROUP)
    found = {point.value: point for point in points if point.name == name}
    if not found:
        raise UnknownName("place for jobs", name, {point.name for point in points})
    if len(found) > 1:
        raise PipenavError(
            f"place {name!r} is declared twice, as {' and '.join(sorted(found))}: uninstall one of them."
        )
    (point,) = found.values()
    try:
        loaded = point.load()
    except ImportError as error:
        remedy = INSTALL.get(name, "install what it needs")
        raise PipenavError(f"place {name!r} cannot be used, {error}: {remedy}.") from error
    if not (inspect.isclass(loaded) and issubclass(loaded, Place)):
        raise PipenavError(f"place {name!r} is no subclass of pipenav.jobs.Place: report it to its authors.")
    return loaded


def chosen_place(jobs: int | None, cluster: str | None) -> Place:
    """The place that a command's options choose: processes, a cluster, or by default this process.

    Args:
        jobs: number of processes, `--jobs`.
        cluster: address of a cluster, `--cluster`.

    Raises:
        PipenavError: both are given, or as `load_place` and the place's constructor.
    """
    if jobs is not None and cluster is not None:
        raise PipenavError("--jobs chooses processes of this machine and --cluster another place: give one of them.")
    if cluster is not None:
        return load_place(CLUSTER)(cluster)
    return HerePlace() if jobs is None else load_place(PROCESSES)(str(jobs))
