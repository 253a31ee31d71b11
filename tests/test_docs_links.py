"""Every link of a page into this checkout leads to a file and to a heading that are there."""

from __future__ import annotations

import re
from pathlib import Path

import pages
import pytest

HOME = "https://github.com/symdyn/symdyn/blob/main/"
RAW = "https://raw.githubusercontent.com/symdyn/symdyn/main/"


def prose(page: Path) -> str:
    """Return a page without its code."""
    text = re.sub(r"(?ms)^ *```.*?^ *```", "", page.read_text(encoding="utf-8"))
    return re.sub(r"`([^`\n]*)`", lambda code: code[1].replace("](", ""), text)


def anchors(page: Path) -> set[str]:
    """Return where links into a page may go: its headings, as GitHub and the site call them."""
    headings = re.findall(r"(?m)^#+ (.*)$", prose(page))
    return {re.sub(r"[^\w\- ]", "", one.lower()).strip().replace(" ", "-") for one in headings}


def broken(page: Path) -> list[str]:
    """Return the links of a page into this checkout that lead nowhere."""
    found = []
    for link in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        inside = link.removeprefix(HOME).removeprefix(RAW)
        path, _, anchor = inside.partition("#")
        if re.match(r"\w+:", inside):
            continue
        target = (pages.ROOT if inside != link else page.parent) / path if path else page
        if not target.exists() or (anchor and target.suffix == ".md" and anchor not in anchors(target)):
            found.append(link)
    return found


PAGES = [*pages.ROOT.glob("*.md"), *pages.DOCS.rglob("*.md"), *(pages.ROOT / "tests").rglob("*.md")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(pages.ROOT)))
def test_every_link_of_a_page_leads_somewhere(page: Path) -> None:
    assert broken(page) == []


def test_a_link_that_leads_nowhere_is_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# One thing\n[a](#one-thing) [b](#two) [c](page.md#one-thing) [d](none.md) `[e](code)`\n")
    text = page.read_text() + f"[f]({HOME}README.md) [g]({HOME}README.md#nowhere) [h]({HOME}none)\n[i](https://x.org)"
    page.write_text(text)
    assert broken(page) == ["#two", "none.md", f"{HOME}README.md#nowhere", f"{HOME}none"]
