"""The command line in this process, for tests."""

from __future__ import annotations

import pytest

from pipenav.cli import main


def run(*args: str) -> int:
    """The exit code of `pipenav ARGS`."""
    with pytest.raises(SystemExit) as left:
        main(args)
    code = left.value.code
    assert code is None or isinstance(code, int)
    return code or 0
