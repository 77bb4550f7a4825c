"""`pipenav hw-check`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.text import Text

from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.backends.real_robot import Finding

STYLES = {"ok": "green", "warning": "yellow", "problem": "red"}


def hw_check(
    arm: Annotated[Path, typer.Option(help="The arm's description, from pipenav calibrate.")] = Path("arm.toml"),
) -> None:
    """Look at the arm's bus, servos and sensors, name what is missing and the next cable; change nothing.

    Example:

        pipenav hw-check --arm arm.toml
    """
    from pipenav.backends.real_robot import load_real_robot
    from pipenav.backends.registry import check_options

    backend_class = load_real_robot()
    options = check_options("hardware", backend_class, {"arm": str(arm)})
    problems = show_findings(Console(), backend_class.check(options))
    if problems:
        raise PipenavError(f"the arm has {problems} problem(s), see above.")


def show_findings(console: Console, findings: Iterator[Finding]) -> int:
    """Print findings as they come.

    Returns:
        The number of problems among them.
    """
    problems = 0
    for finding in findings:
        problems += finding.level == "problem"
        remedy = f": {finding.remedy}" if finding.remedy else ""
        level = (f"{finding.level:8} ", STYLES[finding.level])
        console.print(Text.assemble(level, f"{finding.what}{remedy}"), soft_wrap=True)
    return problems
