"""Links lead somewhere, code blocks say their language, and paths that the code names exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.doc_pages import PAGES, ROOT, anchors, blocks, links

LANGUAGES = {"sh", "python", "toml", "json", "text"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for line, target in links(page):
        if target.startswith(("https://", "mailto:")):
            continue
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        assert file.exists(), f"{page.relative_to(ROOT)}:{line} links to {name}, which is not there"
        if anchor:
            assert anchor in anchors(file), f"{page.relative_to(ROOT)}:{line}: {name or 'the page'} has no #{anchor}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_code_blocks_say_their_language(page: Path) -> None:
    """Else their commands would not be run."""
    for block in blocks(page):
        assert block.language in LANGUAGES, f"{page.relative_to(ROOT)}:{block.line}: language {block.language!r}"


def test_every_page_can_be_reached_from_the_readme() -> None:
    reached, waiting = set[Path](), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page.suffix == ".md" and page.exists() and page not in reached:
            reached.add(page)
            waiting += [(page.parent / target.partition("#")[0]).resolve() for _, target in links(page)]
    assert set(PAGES) - reached - set((ROOT / "models").rglob("*.md")) == set()


def test_pages_that_the_code_names_exist() -> None:
    files = [path for folder in ("pipenav", "plugins") for path in (ROOT / folder).rglob("*.py")]
    for file in files:
        for name in re.findall(r"docs/[\w/.-]+\.md", file.read_text(encoding="utf-8")):
            assert (ROOT / name).exists(), f"{file.relative_to(ROOT)} names {name}, which is not there"
