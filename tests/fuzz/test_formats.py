"""A short part of `python -m tests.fuzz`: readers of every format refuse mutated files in a sentence, or read them."""

from __future__ import annotations

import pytest

from fuzz.__main__ import run_format
from fuzz.formats import formats


@pytest.mark.slow
@pytest.mark.parametrize("name", list(formats()))
def test_mutated_files_are_read_or_refused(name: str) -> None:
    failures, summary = run_format(name, 60)
    assert not failures
    assert sum(summary["counts"].values()) == 60
