"""JSON in parts, against the library's own in one piece."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.storage.json_parts import json_parts

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(st.text(), values, max_size=5), st.lists(values, max_size=5))
def test_parts_are_the_text_in_one_piece(table: dict[str, object], entries: list[object]) -> None:
    whole = json.dumps({**table, "entries": entries}, separators=(",", ":"), allow_nan=False)
    assert "".join(json_parts({**table, "entries": iter(entries)})) == whole
    assert "".join(json_parts(table)) == json.dumps(table, separators=(",", ":"), allow_nan=False)


@pytest.mark.parametrize("table", [{"x": float("nan")}, {"x": [1.0, float("inf")]}])
def test_numbers_that_are_not_finite_are_refused(table: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        "".join(json_parts(table))
