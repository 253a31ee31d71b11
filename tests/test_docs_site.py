"""The site of documentation is built without a warning, loads nothing from elsewhere, and its search finds things."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

pytest.importorskip("sphinx", reason="Sphinx is not installed (extra docs)")
pytest.importorskip("furo", reason="Furo is not installed (extra docs)")
pytest.importorskip("myst_nb", reason="MyST-NB is not installed (extra docs)")

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"

pytestmark = [pytest.mark.long(0)]

LOADING = {"src", "srcset", "data", "poster", "xlink:href"}
"""Attributes that a browser fetches; `href` too, but of a link that a reader follows."""

ELSEWHERE = re.compile(r"\s*(?:https?:)?//", re.IGNORECASE)
IN_STYLES = re.compile(r"""(?:@import\s+(?:url\()?|url\()\s*["']?\s*(?:https?:)?//""", re.IGNORECASE)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the site, built as `make docs` builds it."""
    from sphinx.cmd.build import build_main

    folder = tmp_path_factory.mktemp("site")
    words = ["-q", "-W", "--keep-going", "-E", "-c", str(DOCS / "site"), "-d", str(folder / "read")]
    assert build_main([*words, str(DOCS), str(folder / "site")]) == 0
    return folder / "site"


class Loads(HTMLParser):
    """What a page fetches from another address."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            fetched = key in LOADING or (key == "href" and tag != "a")
            if fetched and ELSEWHERE.match(value or ""):
                self.found.append(f"{tag} {key}={value}")
            if key == "style" and IN_STYLES.search(value or ""):
                self.found.append(f"{tag} {value}")


def test_no_page_loads_anything_from_elsewhere(site: Path) -> None:
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > len(list(DOCS.glob("*.md")))
    for page in pages:
        text = page.read_text(encoding="utf-8")
        loads = Loads()
        loads.feed(text)
        assert loads.found == [], page
        assert not IN_STYLES.search(text), page
    for style in site.rglob("*.css"):
        assert not IN_STYLES.search(style.read_text(encoding="utf-8")), style


def test_the_reader_of_pages_sees_what_is_loaded() -> None:
    loads = Loads()
    loads.feed('<script src="//a.org/b.js"></script><link href="https://a.org/c.css"><a href="https://a.org">read</a>')
    assert len(loads.found) == 2
    assert IN_STYLES.search('@import url("https://a.org/font.css")')
