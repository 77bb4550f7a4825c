"""A page from its template: the shared style and helpers put in, and the data, which cannot leave its element."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

STYLE, HELPERS, DATA = "/*STYLE*/", "/*HELPERS*/", "/*DATA*/"
"""Places in a template for the shared style, the shared functions, and the data."""

HERE = Path(__file__).parent


def filled_page(template: Path, data: Any) -> str:
    """The page of a template, whole in itself.

    Names of strangers' files stand in the data, so no `<` of it reaches the page: it could end the element that the
    data lies in. The page's script puts data into the document as text alone, never as markup.

    Args:
        template: the template, with the three places.
        data: what the page shows, as JSON can hold it.

    Raises:
        ValueError: a number in the data is not finite.
    """
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    page = template.read_text(encoding="utf-8")
    for place, name in ((STYLE, "page.css"), (HELPERS, "page.js")):
        page = page.replace(place, (HERE / name).read_text(encoding="utf-8").rstrip("\n"), 1)
    return page.replace(DATA, text, 1)
