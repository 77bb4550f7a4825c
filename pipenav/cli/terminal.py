"""Words and tables on the terminal: paths stay whole, brackets stay brackets, progress goes to stderr."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

REDIRECTED_WIDTH = 1000
"""Columns for a table that goes to a file or another program: one line a row."""


def say(text: str, style: str = "", console: Console | None = None) -> None:
    """Print text as it is: never wrapped, cut or taken for markup, so that a path in it can be copied.

    Args:
        text: the text.
        style: colour of the whole, where the terminal has colours.
        console: where to print, by default stdout.
    """
    from rich.console import Console
    from rich.text import Text

    (console or Console()).print(Text(text, style), soft_wrap=True)


def show(*parts: RenderableType) -> None:
    """Print tables and texts as wide as the terminal; where there is none, no row is ever wrapped.

    On a terminal that is too narrow for the headings the rows run over its edge: no heading is cut.
    """
    from rich.console import Console
    from rich.measure import Measurement

    console = Console(highlight=False)
    width = console.width if console.is_terminal else REDIRECTED_WIDTH
    for part in parts:
        console.width = max(width, Measurement.get(console, console.options.update(width=10_000), part).minimum)
        console.print(part, soft_wrap=isinstance(part, str), markup=False)


def progress_console() -> Console:
    """The console for progress: stderr, so that what is piped on is the result alone."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


def refuse_ignored(given: dict[str, Any], why: str) -> None:
    """Refuse options that would be ignored.

    Args:
        given: options by their names; None, False or empty where one was not given.
        why: what the options are for, as the end of a sentence.

    Raises:
        PipenavError: one was given.
    """
    from pipenav.errors import PipenavError

    names = [name for name, value in given.items() if value is not None and value is not False and value != []]
    if names:
        raise PipenavError(f"{' and '.join(names)} would be ignored here: {why}.")
