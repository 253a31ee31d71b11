"""Pages of docs as a test reads them: the commands in their indented blocks, and what stands below each."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"


def commands(page: Path) -> list[tuple[str, str]]:
    """Return the commands of a page, behind "    $ ", and what stands below each."""
    found = []
    for block in re.split(r"^    \$ ", page.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
        command, _, below = block.partition("\n")
        shown = re.match(r"(?:    .*\n|\n(?=    ))*", below)
        assert shown
        found.append((command, re.sub(r"^    ", "", shown[0], flags=re.MULTILINE).rstrip("\n")))
    return found
