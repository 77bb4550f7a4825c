"""The pages that people read, taken apart: code blocks, commands, links and headings."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]

PAGES = sorted(
    [
        *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / "models/policies").glob("*/README.md"),
    ]
)


class Block(NamedTuple):
    """A fenced block of code.

    Attributes:
        page: file that it stands in.
        line: number of its first line of code.
        language: word behind the fence; empty where there is none.
        code: the code, without the indentation of a list that it stands in.
    """

    page: Path
    line: int
    language: str
    code: str


class Command(NamedTuple):
    """A command line as a page prints it.

    Attributes:
        page: file that it stands in.
        line: number of its line.
        argv: its words, without comments.
    """

    page: Path
    line: int
    argv: tuple[str, ...]

    @property
    def where(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def blocks(page: Path) -> list[Block]:
    """All fenced blocks of a page."""
    found, opened = [], None
    lines = page.read_text(encoding="utf-8").splitlines()
    for number, line in enumerate(lines, 1):
        fence = re.match(r"^(\s*)```(\S*)", line)
        if fence and opened is None:
            opened = (number + 1, fence[1], fence[2])
        elif fence and opened is not None:
            first, indent, language = opened
            code = "\n".join(text.removeprefix(indent) for text in lines[first - 1 : number - 1]) + "\n"
            found.append(Block(page, first, language, code))
            opened = None
    assert opened is None, f"{page}: a block of code is not closed"
    return found


def prose(page: Path) -> str:
    """A page with its fenced blocks blanked out, line for line."""
    lines = page.read_text(encoding="utf-8").splitlines()
    for block in blocks(page):
        for number in range(block.line - 2, block.line + block.code.count("\n")):
            lines[number] = ""
    return "\n".join(lines)


def fenced_commands(page: Path) -> Iterator[Command]:
    """Commands in a page's shell blocks; reports put a name and a colon before each of theirs."""
    for block in blocks(page):
        if block.language != "sh":
            continue
        number = block.line
        for text in re.sub(r"\\\n\s*", "\0", block.code).splitlines():
            argv = tuple(shlex.split(re.sub(r"^[\w-]+: ", "", text.replace("\0", " ")), comments=True))
            if argv:
                yield Command(page, number, argv)
            number += 1 + text.count("\0")


def inline_commands(page: Path) -> Iterator[Command]:
    """Commands of pipenav in a page's text, such as `pipenav robots`."""
    for number, line in enumerate(prose(page).splitlines(), 1):
        for text in re.findall(r"`(pipenav [^`]+)`", line):
            yield Command(page, number, tuple(shlex.split(text)))


def links(page: Path) -> Iterator[tuple[int, str]]:
    """Line and target of each link and picture."""
    for number, line in enumerate(prose(page).splitlines(), 1):
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
            yield number, target


def anchors(page: Path) -> set[str]:
    """Names by which a page's headings can be linked to, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
