"""`pipenav hw-check`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
    """Check the arm's bus, servos and sensors; say what is missing and which cable to look at. Changes nothing.

    Example:

        pipenav hw-check --arm arm.toml
    """
    from pipenav.backends.real_robot import load_real_robot
    from pipenav.backends.registry import check_options

    backend_class = load_real_robot()
    options = check_options("hardware", backend_class, {"arm": str(arm)})
    if count := problems(show_findings(Console(), backend_class.check(options))):
        raise PipenavError(f"the arm has {count} problem(s), see above.")


def problems(findings: Sequence[Finding]) -> int:
    """Number of problems among findings."""
    return sum(finding.level == "problem" for finding in findings)


def show_findings(console: Console, findings: Iterator[Finding]) -> list[Finding]:
    """Print findings as they come.

    Returns:
        All of them.
    """
    shown = []
    for finding in findings:
        shown.append(finding)
        remedy = f": {finding.remedy}" if finding.remedy else ""
        level = (f"{finding.level:8} ", STYLES[finding.level])
        console.print(Text.assemble(level, f"{finding.what}{remedy}"), soft_wrap=True)
    return shown
