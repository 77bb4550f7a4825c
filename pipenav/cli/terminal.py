"""Words and tables on the terminal: paths stay whole, brackets stay brackets, progress goes to stderr."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

REDIRECTED_WIDTH = 1000
"""Columns for a table that goes to a file or another program: one line a row."""

CUT, WIDER = "\N{HORIZONTAL ELLIPSIS}", 8
"""Sign of a word that was cut, and the columns by which a table gets wider until there is none."""


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

    On a terminal that is too narrow for the words of a table its rows run over the edge: no word is cut.
    """
    from rich.console import Console

    console = Console(highlight=False)
    width = console.width if console.is_terminal else REDIRECTED_WIDTH
    for part in parts:
        console.width = _width_for(part, console, width)
        console.print(part, soft_wrap=isinstance(part, str), markup=False)


def _width_for(part: RenderableType, console: Console, width: int) -> int:
    """The least width from the terminal's on at which nothing is cut."""
    for wide in range(width, REDIRECTED_WIDTH, WIDER):
        console.width = wide
        with console.capture() as captured:
            console.print(part, markup=False)
        if CUT not in captured.get():
            return wide
    return REDIRECTED_WIDTH


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
        leave = "leave it out" if len(names) == 1 else "leave them out"
        raise PipenavError(f"{' and '.join(names)} would be ignored here: {why}; {leave}.")
