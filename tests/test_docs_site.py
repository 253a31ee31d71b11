"""The site of documentation is built without a warning, loads nothing from elsewhere, and its search finds things."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
from browser import window
from reference import catalogue
from searched import MEANT, missed

pytest.importorskip("sphinx", reason="Sphinx is not installed (extra docs)")
pytest.importorskip("furo", reason="Furo is not installed (extra docs)")
pytest.importorskip("myst_nb", reason="MyST-NB is not installed (extra docs)")

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"

pytestmark = pytest.mark.slow

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


def test_pages_of_lessons_open(site: Path) -> None:
    text = (site / "walkthroughs" / "README.html").read_text(encoding="utf-8")
    links = re.findall(r'<a class="reference internal" href="(\.\./_downloads/[^"]*/four_bar\.html)">', text)
    assert len(links) == 1
    assert (site / "walkthroughs" / links[0]).is_file()


PROBE = """() => ({
  excess: document.documentElement.scrollWidth - innerWidth,
  missing: [...document.images].filter(one => one.loading !== "lazy" && !one.naturalWidth).length,
  dark: getComputedStyle(document.body).colorScheme,
  formulas: [...document.querySelectorAll("math")].filter(one => one.getBoundingClientRect().width < 1).length,
})"""


@pytest.fixture
def offline(browser: Any) -> Iterator[Any]:
    """Yield a page whose browser is offline, and that fails the test on any request but for files, and on any word."""
    page, said = window(browser, offline=True), []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda fault: said.append(str(fault)))
    page.on("request", lambda one: said.append(one.url) if not one.url.startswith(("file:", "data:")) else None)
    yield page
    page.context.close()
    assert said == []


@pytest.mark.parametrize(("width", "scheme"), [(1400, "light"), (390, "dark")])
def test_pages_fit_and_show_everything_without_a_network(site: Path, offline: Any, width: int, scheme: str) -> None:
    offline.set_viewport_size({"width": width, "height": 900})
    offline.emulate_media(color_scheme=scheme)
    names = ("index", "words", "api", "performance", "gallery/README", "gallery/furuta", "walkthroughs/two_link")
    for name in ("api/symdyn.simulate", "api/symdyn.linear.Linearization", *names):
        offline.goto((site / f"{name}.html").as_uri())
        found = offline.evaluate(PROBE)
        assert found == {"excess": found["excess"], "missing": 0, "dark": scheme, "formulas": 0}, name
        assert found["excess"] <= 0, name
    assert offline.evaluate("document.querySelectorAll('math').length") > 50


class Silent(SimpleHTTPRequestHandler):
    """A server that writes no log."""

    def log_message(self, *_: object) -> None:
        """Say nothing."""


@pytest.fixture(scope="module")
def served(site: Path) -> Iterator[str]:
    """Yield the address of the site on a server of this machine."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Silent, directory=str(site))) as server:
        thread = Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()


@pytest.fixture
def served_page(browser: Any, served: str) -> Iterator[Any]:
    """Yield a page that reaches that server and nothing else."""
    page, said = window(browser, base_url=served), []
    page.on("console", lambda message: said.append(message.text))
    page.on("request", lambda one: None if one.url.startswith(served) else said.append(one.url))
    yield page
    page.context.close()
    assert said == []


@pytest.mark.parametrize(
    ("words", "page"),
    [
        ("quaternion", "scenes.html#joints"),
        ("lambdify", "api/symdyn.lambdify.html#symdyn.lambdify"),
        ("units", "units.html"),
        ("rope over a pulley", "scenes.html#ropes"),
        ("dimensions", "units.html"),
    ],
)
def test_the_search_finds(served_page: Any, words: str, page: str) -> None:
    served_page.goto(f"/search.html?q={words}")
    served_page.wait_for_selector(".search-summary:has-text('found')")
    links = served_page.eval_on_selector_all("#search-results a", "all => all.map(one => one.getAttribute('href'))")
    assert any(link.startswith(page) for link in links), links


@pytest.mark.runs("node")
def test_the_first_hit_of_a_word_of_the_field_is_the_page_that_is_meant(site: Path) -> None:
    """As Sphinx's own script ranks them; `make docs` looks too. A word is added to docs/site/search_words.toml."""
    assert missed(site) == []
    assert len(MEANT) > 50


def test_a_word_leads_to_one_section(site: Path) -> None:
    table = tomllib.loads((DOCS / "site" / "search_words.toml").read_text(encoding="utf-8"))
    words = [word.lower() for names in table.values() for word in names]
    assert len(set(words)) == len(words)


def test_the_search_finds_nothing_where_nothing_is(served_page: Any) -> None:
    served_page.goto("/search.html?q=zwiebelkuchen")
    served_page.wait_for_selector(".search-summary:has-text('did not match')")


def test_every_name_of_the_reference_has_a_page_and_a_line_for_readers_of_text(site: Path) -> None:
    text = (site / "llms.txt").read_text(encoding="utf-8")
    names = [name for names in catalogue().values() for name in names]
    assert [name for name in names if f'id="{name}"' not in (site / "api" / f"{name}.html").read_text("utf-8")] == []
    assert [name for name in names if f"](api/{name}.html): " not in text] == []
    assert [path for path in re.findall(r"\]\(([^)]+)\)", text) if not (site / path).is_file()] == []
    assert 'id="symdyn.errors.SymdynError"' in (site / "api.html").read_text(encoding="utf-8")


def test_the_wheel_holds_no_documentation() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["hatch"]["build"]["targets"]
    brought = [*settings["wheel"]["packages"], *settings["wheel"].get("force-include", {})]
    assert not [path for path in brought if path.startswith("docs")]


def test_the_reader_of_pages_sees_what_is_loaded() -> None:
    loads = Loads()
    loads.feed('<script src="//a.org/b.js"></script><link href="https://a.org/c.css"><a href="https://a.org">read</a>')
    assert len(loads.found) == 2
    assert IN_STYLES.search('@import url("https://a.org/font.css")')
