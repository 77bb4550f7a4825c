"""`pipenav backends`: a list of the installed backends and of what is missing for them, or the settings of one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.cli.terminal import show

if TYPE_CHECKING:
    from rich.table import Table


def backends(
    name: Annotated[str | None, typer.Argument(help="Backend whose settings are shown.", show_default=False)] = None,
) -> None:
    """List the installed backends, or the settings of one.

    Examples:

        pipenav backends

        pipenav backends mujoco
    """
    show(plugins_table() if name is None else _settings(name))


def plugins_table() -> Table:
    """The installed backends, a row each."""
    from rich.table import Table
    from rich.text import Text

    from pipenav.backends.plugins import INSTALL_PIPENAV, NONE_INSTALLED, find_backends
    from pipenav.backends.requirements import availability
    from pipenav.errors import PipenavError

    if not find_backends():
        raise PipenavError(f"{NONE_INSTALLED}; {INSTALL_PIPENAV}.")
    table = Table("backend", "runs here", "from", "why not, and what to do", box=None, pad_edge=False)
    for plugin in find_backends().values():
        known = availability(plugin)
        runs = Text("yes", "green") if known.can_load else Text("no", "red")
        why = Text(f"{known.missing}; {known.remedy}" if known.missing else "")
        table.add_row(Text(plugin.name, "bold"), runs, plugin.origin, why)
    return table


def _settings(name: str) -> Table:
    from rich.table import Table
    from rich.text import Text

    from pipenav.backends.registry import load_backend

    table = Table("setting", "default", "meaning", box=None, pad_edge=False)
    for key, field in load_backend(name).Options.model_fields.items():
        default = "required" if field.is_required() else repr(field.get_default(call_default_factory=True))
        table.add_row(Text(key, "bold"), Text(default), Text(field.description or ""))
    return table
