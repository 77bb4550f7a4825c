"""The report of a fault of pipenav itself: what a person who mends it needs to know."""

from __future__ import annotations

import os
import platform
import shlex
import sys
import tempfile
import traceback
from datetime import datetime
from pathlib import Path

LONGEST_TEXT = 20_000
"""Most characters of the traceback, and of the command."""


def write_report(error: BaseException) -> Path:
    """Write a report of an error into the folder for temporary files; the path of the report.

    Raises:
        OSError: it cannot be written.
    """
    from pipenav.policies.header import installed_versions

    trace = "".join(traceback.format_exception(error, limit=-40))
    command = shlex.join(sys.argv)
    lines = [
        "Report of a fault of pipenav",
        f"time     {datetime.now().isoformat(timespec='seconds')}",
        f"command  {command[:LONGEST_TEXT]}",
        f"folder   {Path.cwd()}",
        f"system   {platform.platform()}",
        *(f"{name:<8} {version}" for name, version in installed_versions().items()),
        "",
        trace[-LONGEST_TEXT:],
    ]
    descriptor, name = tempfile.mkstemp(prefix="pipenav-report-", suffix=".txt")
    with os.fdopen(descriptor, "w", encoding="utf-8", errors="backslashreplace") as file:
        file.write("\n".join(lines))
    return Path(name)
