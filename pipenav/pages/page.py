"""A page from its template: the shared head and helpers put in, and the data, which cannot leave its element."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

HEAD, TOP, SCRIPTS = "<!--HEAD-->", "<!--TOP-->", "<!--DATA-->"
"""Places in a template for all that comes before its title, for the page's top with title, subject and totals, where it
has these, and for the data with the shared functions."""

STYLE, HELPERS, DATA = "/*STYLE*/", "/*HELPERS*/", "/*DATA*/"
"""Places in the shared parts for the style, the functions, and the data."""

FUNCTIONS = ("page.js", "chart.js", "robot.js", "map.js")
"""Files with the shared functions."""

HERE = Path(__file__).parent


def filled_page(template: Path, data: Any) -> str:
    """The page of a template, whole in itself.

    Names of strangers' files stand in the data, so no `<` of it reaches the page: it could end the element that the
    data lies in. The page's script, which finds the data as `S`, puts it into the document as text alone, never as
    markup.

    Args:
        template: the template, with its places.
        data: what the page shows, as JSON can hold it.

    Raises:
        ValueError: a number in the data is not finite.
    """
    return "".join(page_parts(template, [json.dumps(data, separators=(",", ":"), allow_nan=False)]))


def page_parts(template: Path, data: Iterable[str]) -> Iterator[str]:
    """The page of `filled_page` in parts, from the text of its data in parts."""
    head = _shared("head.html").replace(STYLE, _shared("page.css"), 1)
    helpers = "\n".join(map(_shared, FUNCTIONS))
    scripts = _shared("data.html").replace(HELPERS, helpers, 1)
    whole = template.read_text(encoding="utf-8").replace(HEAD, head, 1).replace(TOP, _shared("top.html"), 1)
    whole = whole.replace(SCRIPTS, scripts, 1)
    before, after = whole.split(DATA, 1)
    yield before
    for part in data:
        yield part.replace("<", "\\u003c")
    yield after


def _shared(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8").rstrip("\n")
