"""Routes from TOML: one route, corner by corner, or a set drawn by a rule. Formats: docs/formats/route-folder.md."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from pipenav.errors import ConfigError, PipenavError, UnknownName, shown
from pipenav.pipes.corner_sets import corner_set_names, parse_corners
from pipenav.pipes.network_file import read_network_routes
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.reducer import ReducerSetFile
from pipenav.pipes.route import PipeRoute, as_route
from pipenav.pipes.route_file import read_route
from pipenav.pipes.route_set_file import RouteSetFile
from pipenav.pipes.s_bend import SBendSetFile
from pipenav.pipes.set_file import read_as
from pipenav.storage import shipped
from pipenav.storage.text_files import read_toml


class NamedRoute(NamedTuple):
    """A route and the name under which its folder is made."""

    name: str
    route: PipeRoute


def route_set_names() -> list[str]:
    """Names of the shipped sets of routes."""
    return sorted(path.stem for path in _folder().glob("*.toml"))


def parse_pipes(given: Sequence[str]) -> list[Pipe]:
    """All pipes of the given sets, single corners and routes, in order, each once.

    Args:
        given: `runs-level` or another shipped name, `runs-level:3` for its third route, a TOML file of one route, of a
            set of routes or of a set of corners, or anything else that `pipenav.pipes.corner_sets.parse_corners` takes.

    Raises:
        PipenavError: something that is none of these, or a pipe that is not possible.
    """
    return list(dict.fromkeys(pipe for text in given for pipe in _parse_one(text)))


def parse_routes(given: Sequence[str]) -> list[PipeRoute]:
    """All pipes of the given sets as routes, in order, each once; a single corner counts as a route of one.

    Args:
        given: sets and pipes as `parse_pipes` takes them.

    Raises:
        PipenavError: something that is none of these, or a route that is not possible.
    """
    return list(dict.fromkeys(as_route(pipe) for pipe in parse_pipes(given)))


def parse_route(text: str) -> NamedRoute:
    """A single route, named like its TOML file, or `runs-level-3` for the third route of that shipped set.

    Raises:
        PipenavError: something that is neither, or a route that is not possible.
    """
    name, colon, number = text.partition(":")
    if name in route_set_names():
        if not colon:
            raise PipenavError(f"{text} is a set of routes: choose one of them by its number, as in {text}:1.")
        return NamedRoute(f"{name}-{number}", parse_routes([text])[0])
    if not text.endswith(".toml"):
        raise UnknownName("route", text, [*(f"{known}:1" for known in route_set_names()), "FILE.toml"])
    return NamedRoute(Path(text).stem, read_route(Path(text)))


def _parse_one(text: str) -> Sequence[Pipe]:
    name, colon, number = text.partition(":")
    if name in route_set_names():
        routes = _read_set(_folder() / f"{name}.toml")
        return [routes[_index(text, number, len(routes))]] if colon else routes
    if text.endswith(".toml"):
        table = read_toml(Path(text))
        if "s_bend" in table or "reducers_mm" in table:
            return _read_set(Path(text))
        if "nodes" in table:
            return list(read_network_routes(Path(text)).values())
        if "corners" in table:
            return _read_set(Path(text)) if "runs" in table else [read_route(Path(text))]
    elif "=" not in text and text not in corner_set_names():
        raise UnknownName(
            "set of pipes or routes", text, [*route_set_names(), *corner_set_names(), "FILE.toml", "d=90,angle=60"]
        )
    return parse_corners([text])


def _index(text: str, number: str, count: int) -> int:
    if not (number.isascii() and number.isdigit() and len(number) <= 9 and 1 <= int(number) <= count):
        raise PipenavError(
            f"{shown(text)} names no route of the set: write a number from 1 to {count} after the colon."
        )
    return int(number) - 1


def _read_set(path: Path) -> list[PipeRoute]:
    table = read_toml(path)
    kind: type[SBendSetFile | ReducerSetFile | RouteSetFile] = RouteSetFile
    if "s_bend" in table:
        kind = SBendSetFile
    elif "reducers_mm" in table:
        kind = ReducerSetFile
    file = read_as(kind, path)
    try:
        return file.draw()
    except PipenavError as error:
        raise ConfigError(f"{path}: {error}") from error


def _folder() -> Path:
    return shipped.pipes_dir() / "runs"
