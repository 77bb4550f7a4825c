"""`pipenav list`: everything that can be named, and the keys of the files that a person can write."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from pipenav.cli.terminal import show
from pipenav.errors import UnknownName

if TYPE_CHECKING:
    from pydantic import BaseModel
    from rich.table import Table


KEY_HEADINGS = ("key", "default", "meaning")


class _Kind(NamedTuple):
    """A kind of things that can be named.

    Attributes:
        use: where such a name is used.
        table: gives a row for each thing.
    """

    use: str
    table: Callable[[], Table]


def names(
    kind: Annotated[
        str | None, typer.Argument(metavar="[KIND]", help="One kind; without it, all kinds.", show_default=False)
    ] = None,
) -> None:
    """List all that can be named: policies, pipes, disturbances, keys of files.

    Examples:

        pipenav list

        pipenav list policies

        pipenav list training-keys
    """
    if kind is None:
        show(_table(("kind", "used as"), ((name, one.use) for name, one in KINDS.items())))
        return
    if kind not in KINDS:
        raise UnknownName("kind", kind, KINDS)
    show(KINDS[kind].table())


def _policies() -> Table:
    from pipenav.policies.named import BASELINE, BASELINES
    from pipenav.policies.policy import load_policy, policy_names, resolve_policy

    rows: list[tuple[str, ...]] = []
    for name in policy_names():
        header = load_policy(resolve_policy(name)).header
        words = str(header.training.get("description", ""))
        rows.append((name, header.robot.name, header.task.kind, header.task.control, words))
    rows += [(BASELINE + name, robot, "", "", "baseline, not trained") for name, robot in BASELINES.items()]
    return _table(("policy", "robot", "task", "control", "what it was trained for"), rows)


def _pipes() -> Table:
    from pipenav.pipes.corner_sets import corner_set_names
    from pipenav.pipes.route_sets import route_set_names
    from pipenav.storage.shipped import pipes_dir
    from pipenav.storage.text_files import read_toml

    corners = [(name, "corners", pipes_dir() / f"{name}.toml") for name in corner_set_names()]
    routes = [(name, "routes", pipes_dir() / "runs" / f"{name}.toml") for name in route_set_names()]
    rows = [(name, of, str(read_toml(file).get("description", ""))) for name, of, file in [*corners, *routes]]
    return _table(("set of pipes", "of", "which"), rows)


def _disturbances() -> Table:
    from pipenav.disturbances.disturbance import disturbance_names, load_disturbance

    rows = []
    for name in disturbance_names():
        disturbance = load_disturbance(name)
        given = disturbance.model_dump(exclude_defaults=True)
        rows.append((name, ", ".join(f"{key} {_range(value)}" for key, value in given.items())))
    return _table(("disturbance", "sets"), rows)


def _range(value: Any) -> str:
    if not isinstance(value, Sequence):
        return f"{value:g}"
    low, high = value
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _experiments() -> Table:
    from pipenav.experiments.definition import ALL, experiment_names, load_experiment

    rows = [(name, load_experiment(name).title) for name in experiment_names()]
    return _table(("experiment", "subject"), [*rows, (ALL, "all of them")])


def _presets() -> Table:
    from pipenav.cli.presets import presets_table

    return presets_table()


def _spaces() -> Table:
    from pipenav.tuning.space import load_space, space_names

    spaces = [(name, load_space(name)) for name in space_names()]
    rows = [(name, space.preset, ", ".join(space.space), space.description) for name, space in spaces]
    return _table(("space", "preset", "settings", "what is searched"), rows)


def _space_keys() -> Table:
    from pipenav.tuning.space import SearchSpace

    return _keys_table(SearchSpace)


def _robots() -> Table:
    from pipenav.cli.robots import robots_table

    return robots_table()


def _backends() -> Table:
    from pipenav.cli.backends import plugins_table

    return plugins_table()


def _training_keys() -> Table:
    from pipenav.learning.config import TrainConfig

    return _keys_table(TrainConfig)


def _robot_keys() -> Table:
    from pipenav.cli.keys import keys_of
    from pipenav.robots.joint_types import KINDS as TYPES
    from pipenav.robots.robot import RobotSpec

    types = [
        (f"{one.table}.NAME", "", f"any keys of a {name}, for each that says like = NAME (schema_version 2)")
        for name, one in TYPES.items()
    ]
    return _table(KEY_HEADINGS, [*keys_of(RobotSpec), *types])


def _disturbance_keys() -> Table:
    from pipenav.disturbances.disturbance import Disturbance

    return _keys_table(Disturbance)


KINDS = {
    "policies": _Kind("--policy of eval, view and run-real", _policies),
    "pipes": _Kind("--pipes of train, eval, view and locate-target; NAME:K as --route of gen-pipe", _pipes),
    "disturbances": _Kind("--disturb of eval", _disturbances),
    "experiments": _Kind("pipenav experiment NAME", _experiments),
    "presets": _Kind("--preset of train", _presets),
    "spaces": _Kind("--space of tune", _spaces),
    "robots": _Kind("--robot of train, eval, view, locate-target and others", _robots),
    "backends": _Kind("--backend; pipenav backends NAME lists its settings, for --option", _backends),
    "training-keys": _Kind("--set of train, and its --config FILE.toml", _training_keys),
    "space-keys": _Kind("keys of a search space's FILE.toml; NAME is a key of a training", _space_keys),
    "robot-keys": _Kind("keys of a robot.toml; [] stands for each table of a list, NAME for a name", _robot_keys),
    "disturbance-keys": _Kind("keys of a disturbance's FILE.toml, and of randomise in a training", _disturbance_keys),
}


def _keys_table(model: type[BaseModel]) -> Table:
    from pipenav.cli.keys import keys_of

    return _table(KEY_HEADINGS, keys_of(model))


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """A table whose first column stands out; nothing in it is taken for markup."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for heading in headings:
        table.add_column(Text(heading))
    for first, *others in rows:
        table.add_row(Text(first, "bold"), *map(Text, others))
    return table
