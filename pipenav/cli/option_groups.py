"""Options that belong together as one parameter of a command, and as one panel of its help.

A group is a frozen dataclass whose fields are annotated as the parameters of a typer command are:

    @dataclass(frozen=True)
    class StoppingOptions(OptionGroup):
        panel: ClassVar[str] = "Stopping"
        ticks: Annotated[int | None, typer.Option(help="End after so many ticks.")] = None

    @takes_option_groups
    def run_real(policy: Annotated[str, typer.Option()], stopping: StoppingOptions) -> None: ...
"""

from __future__ import annotations

import copy
import functools
import inspect
from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields
from inspect import Parameter
from typing import Annotated, Any, ClassVar, get_args, get_type_hints

from typer.models import OptionInfo


class OptionGroup:
    """Base class of a group of options.

    Attributes:
        panel: title of the group's panel in the help.
    """

    panel: ClassVar[str]


def takes_option_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Make a typer command of a function that takes groups: every field of a group becomes an option of its own.

    Args:
        command: function whose parameters are groups, or annotated options of typer.

    Returns:
        The same function with one keyword parameter for every option; typer reads its signature.
    """
    hints = get_type_hints(command, include_extras=True)
    groups = {name: hint for name, hint in hints.items() if inspect.isclass(hint) and issubclass(hint, OptionGroup)}
    parameters: list[Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        parameters += _options(groups[name]) if name in groups else [_keyword(name, hints[name], parameter.default)]

    @functools.wraps(command)
    def with_single_options(**given: Any) -> None:
        filled = {}
        for name, group in groups.items():
            filled[name] = group(**{option.name: given.pop(option.name) for option in _options(group)})
        command(**given, **filled)

    with_single_options.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    with_single_options.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return with_single_options


def _options(group: type[OptionGroup]) -> Iterator[Parameter]:
    """The fields of a group as a command's parameters, shown in the group's panel."""
    hints = get_type_hints(group, include_extras=True)
    for field in fields(group):  # type: ignore[arg-type]  # every group is a dataclass
        kind, option = get_args(hints[field.name])
        assert isinstance(option, OptionInfo)
        option = copy.copy(option)
        option.rich_help_panel = group.panel
        default = Parameter.empty if field.default is MISSING else field.default
        yield _keyword(field.name, Annotated[kind, option], default)


def _keyword(name: str, annotation: Any, default: Any) -> Parameter:
    return Parameter(name, Parameter.KEYWORD_ONLY, annotation=annotation, default=default)
