"""Commands as processes, with everything that they start."""

from __future__ import annotations

import os
import subprocess
import sys
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

MARK = "PIPENAV_TEST_FAMILY"


class Family(NamedTuple):
    """A command and the processes that descend from it, however they have left it.

    Attributes:
        command: the command's own process.
        name: value of the variable in the environment of all of them.
    """

    command: subprocess.Popen[str]
    name: str

    def alive(self) -> dict[int, str]:
        """Processes of the family that run, with their command lines."""
        wanted = f"{MARK}={self.name}".encode()
        found = {}
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                if wanted in (folder / "environ").read_bytes().split(b"\0"):
                    found[int(folder.name)] = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            except OSError:  # it ended meanwhile
                continue
        return found


@contextmanager
def started(*arguments: str, folder: Path, **variables: str) -> Iterator[Family]:
    """The command `pipenav ARGUMENTS` in a folder, in a process group of its own; killed with all of it at the end."""
    name = uuid.uuid4().hex
    with subprocess.Popen(
        [sys.executable, "-m", "pipenav", *arguments],
        cwd=folder,
        env=os.environ | variables | {MARK: name},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as process:
        family = Family(process, name)
        try:
            yield family
        finally:
            for number in family.alive():
                os.kill(number, 9)
