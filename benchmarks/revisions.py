"""Trees of other revisions, and how their code is run."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@contextlib.contextmanager
def tree_of(revision: str) -> Iterator[Path]:
    """The files of a revision, as git names it, in a folder that goes at the end."""
    with tempfile.TemporaryDirectory() as scratch:
        tree = Path(scratch, "tree")
        added = git("worktree", "add", "--detach", str(tree), revision)
        if added.returncode:
            sys.exit(f"git has no revision {revision}: {added.stderr.strip().splitlines()[-1]}")
        try:
            yield tree
        finally:
            git("worktree", "remove", "--force", str(tree))


def git(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Git's answer in this repository."""
    return subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True)


def run_pipenav(tree: Path, command: str, folder: Path) -> None:
    """Run `pipenav COMMAND` with the code of a tree in a folder, silently.

    Raises:
        SystemExit: the command failed; its last lines are told.
    """
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tree), str(tree / "plugins")])}
    words = [sys.executable, "-P", "-m", "pipenav", *command.split()]
    ended = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True)
    if ended.returncode:
        sys.exit(f"pipenav {command} failed in {tree}:\n{(ended.stdout + ended.stderr)[-2000:]}")
