"""Data in a page cannot leave the element that it lies in."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.pages.page import DATA, HEAD, HELPERS, SCRIPTS, STYLE, filled_page

TEMPLATE = f"{HEAD}<title>Page</title>{SCRIPTS}after"
EVIL = st.sampled_from(
    ["</script>", "<!--", "<script>", "]]>", STYLE, HELPERS, DATA, HEAD, SCRIPTS, "\u2028", "\\", "'", '"', "&lt;"]
)

data = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text() | EVIL,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text() | EVIL, inner, max_size=4),
)


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "template.html"
    path.write_text(TEMPLATE, encoding="utf-8")
    return path


@given(given=data)
def test_data_come_back_as_they_were(template: Path, given: object) -> None:
    page = filled_page(template, given)
    found = re.search(r'<script id="data" type="application/json">(.*?)</script', page, re.DOTALL)
    assert found and json.loads(found[1]) == given
    assert "<" not in found[1]
    assert page.endswith("after")


@given(given=data)
def test_data_change_nothing_else_in_the_page(template: Path, given: object) -> None:
    with_data, empty = filled_page(template, given), filled_page(template, None)
    body = json.dumps(given, separators=(",", ":")).replace("<", "\\u003c")
    assert with_data == empty.replace(">null<", f">{body}<", 1)


def test_numbers_that_are_not_finite_are_refused(template: Path) -> None:
    with pytest.raises(ValueError):
        filled_page(template, {"x": float("nan")})
