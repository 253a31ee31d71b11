"""What a notebook shows of every noun that a door returns: in HTML and LaTeX, light and dark, and nothing hostile."""

from __future__ import annotations

import base64
import pickle
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from browser import chromium, opened
from hostile import PAYLOADS, in_browser, scene_with, unescaped
from kernels import executed

import symdyn
from symdyn.notebook import bundle
from symdyn.notebook.page import LATEX, NOUNS
from symdyn.scene import bind, read_text
from symdyn.scene.scene_files import Starter
from symdyn.shown import Shown

VOID = ("br", "img", "mspace", "wbr")


class Elements(HTMLParser):
    """Reads HTML that must be whole: every element that begins also ends."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(html)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open[-1:] != ["style"]:
            self.text += data


def shown(noun: Any) -> Elements:
    return Elements(bundle(noun)["text/html"])


def classes() -> Iterator[type]:
    for name in NOUNS:
        module, _, noun = name.partition(":")
        yield getattr(import_module(module), noun)


def _below(kind: type) -> set[type]:
    return set(kind.__subclasses__()).union(*map(_below, kind.__subclasses__()))


def test_every_noun_that_shows_itself_has_a_row_and_every_row_a_function() -> None:
    listed = set(classes())
    assert {one for one in listed if issubclass(one, Shown)} == listed
    below = _below(Shown)
    assert listed <= below, "a row has no noun"
    assert not [one for one in below if not listed & set(one.__mro__)], "a noun that shows itself has no row"
    assert set(LATEX) <= set(NOUNS)
    for place in (*NOUNS.values(), *LATEX.values()):
        file, _, name = place.partition(":")
        assert callable(getattr(import_module(f"symdyn.notebook.{file}"), name))


def test_what_doors_return_shows_itself() -> None:
    """Doors say what they return; text, scenes and functions aside, each of these has a row."""
    names = {one.__name__ for one in classes()} | {"None", "Path"}
    for door in symdyn.__all__:
        returns = str(getattr(getattr(symdyn, door), "__annotations__", {}).get("return"))
        assert {word for word in re.findall(r"\w+", returns) if word[0].isupper()} <= names, f"{door} returns {returns}"


def test_a_scene_shows_its_picture_and_its_tables() -> None:
    found = shown(symdyn.example("four_bar"))
    (image,) = [attributes for tag, attributes in found.found if tag == "img"]

    svg = base64.b64decode(str(image["src"]).removeprefix("data:image/svg+xml;base64,")).decode()
    assert "body-coupler" in svg
    assert "prefers-color-scheme:dark" in svg
    for word in ("3 coordinates", "1 loop", "psi", "length of the crank", "9.81", "m/s^2"):
        assert word in found.text


def test_pictures_and_animations_are_text_that_a_notebook_shows() -> None:
    scene = bind(symdyn.example("two_link"), {"m1": 1, "m2": 1, "h1": 1, "h2": 1, "g": 9.81})
    picture, film = symdyn.picture(scene), symdyn.animation(scene, [0, 1], [[0, 0], [1, 1]])

    assert picture.startswith("<svg")
    assert len(repr(picture)) < 40
    assert pickle.loads(pickle.dumps(picture)) == picture
    assert [tag for tag, _ in shown(picture).found if tag == "img"]
    (frame,) = [attributes for tag, attributes in shown(film).found if tag == "iframe"]
    assert frame["srcdoc"] == film
    assert frame["sandbox"] == "allow-scripts"


@pytest.mark.parametrize("name", ["two_link", "four_bar"])
def test_equations_show_their_mathematics_in_html_and_latex(name: str) -> None:
    pytest.importorskip("latex2mathml")
    equations = symdyn.equations(symdyn.example(name))
    both = bundle(equations)

    assert both["text/latex"] == equations.latex()
    assert [tag for tag, _ in shown(equations).found].count("math") > 10
    assert "sin" in both["text/html"]


def test_equations_that_are_long_or_have_no_closed_form_say_so() -> None:
    chain = read_text(Starter("chain").from_template("chain", 60), "chain.toml")
    long, none = symdyn.equations(symdyn.example("arm7")), symdyn.equations(chain)

    assert "more than a notebook shows; .latex(), .text() and .sympy() give them" in shown(long).text
    assert "k_C alone has 106200 entries, and 100000 is the limit" in shown(none).text
    assert "text/latex" not in bundle(long) | bundle(none)


def test_sympys_matrices_are_shown_where_they_are_short() -> None:
    pytest.importorskip("latex2mathml")
    small, large = (symdyn.equations(symdyn.example(name)).sympy() for name in ("two_link", "puma560"))

    assert "6 × 6" not in shown(small).text
    assert "6 × 6" in shown(large).text
    assert "mass matrix" in shown(small).text


@pytest.mark.long
@pytest.mark.runs
def test_runs_show_plots_and_how_they_ended() -> None:
    pytest.importorskip("matplotlib")
    cart = symdyn.example("cart_pole")
    run = symdyn.simulate(cart, forces="F=0.5", until=0.5, stops=["x - 0.01"])
    found = shown(run)

    (image,) = [attributes for tag, attributes in found.found if tag == "img"]
    assert b"theta" in base64.b64decode(str(image["src"]).partition(",")[2])
    assert "x - 0.01" in found.text
    assert "ended the run" in found.text


@pytest.mark.runs
def test_linear_systems_show_matrices_modes_and_stability() -> None:
    found = symdyn.linearize(symdyn.example("cart_pole"))

    text = shown(found).text
    for word in ("unstable: one eigenvalue has a positive real part", "theta_dot", "modes", "damping ratio"):
        assert word in text
    assert r"\dot{\mathbf{x}}" in bundle(found)["text/latex"]


@pytest.mark.long(0)
@pytest.mark.runs
def test_a_certificate_shows_its_verdict(numpy_alone: None) -> None:
    found = symdyn.certify(symdyn.example("pendulum"), ["mass_matrix", "inverse_dynamics"])
    page = shown(found)
    assert [attributes["class"] for tag, attributes in page.found if tag == "p"][1] == "good"
    assert "passed" in page.text
    assert re.search(r"a false one passed is below 1e-\d\d", page.text)

    from dataclasses import replace

    wrong = replace(found.findings[0], verdict="fails", where=3)
    failed = shown(replace(found, findings=(wrong, *found.findings[1:])))
    assert [attributes["class"] for tag, attributes in failed.found if tag == "p"][1] == "bad"
    assert wrong.claim in failed.text.partition("claims")[0] + failed.text


def strangers() -> Iterator[Any]:
    """Yield nouns whose scene holds a text of a stranger wherever it may."""
    scene = read_text(scene_with(PAYLOADS), "stranger.toml")
    yield from (scene, symdyn.equations(scene), symdyn.equations(scene).sympy(), symdyn.closed_form(scene))
    yield from (
        symdyn.dynamics.derive(scene, ["mass_matrix"]),
        symdyn.program.lower(symdyn.dynamics.derive(scene, ["mass_matrix"])),
    )


@pytest.mark.long(0)
def test_nothing_of_a_stranger_becomes_markup() -> None:
    for noun in strangers():
        for tag, attributes in shown(noun).found:
            assert tag not in ("script", "svg", "a", "iframe"), tag
            assert not [name for name in attributes if name.startswith("on") or name in ("href", "autofocus")]
            assert str(attributes.get("src", "data:image/")).startswith("data:image/")


@pytest.mark.long(0)
@pytest.mark.runs("chromium")
def test_nothing_of_a_stranger_runs_in_a_browser(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    with chromium() as browser:
        path.write_text("".join(bundle(noun)["text/html"] for noun in strangers()), encoding="utf-8")
        assert not [seen for seen in in_browser(browser, path) if not seen.startswith("data:image/")]
        with unescaped("in_html", lambda text, quote=True: text):  # the test sees what it looks for
            path.write_text(bundle(next(strangers()))["text/html"], encoding="utf-8")
            assert [seen for seen in in_browser(browser, path) if not seen.startswith("data:image/")]


CELLS = """
import symdyn; scene = symdyn.example("four_bar"); scene
symdyn.equations(scene)
symdyn.equations(scene).sympy()
symdyn.linearize(symdyn.example("cart_pole"))
symdyn.animation(scene, [0, 1], [[0.8, 0.14, 2.0], [0.8, 0.14, 2.0]])
symdyn.simulate(symdyn.example("cart_pole"), forces="F=0.5", until=1)
"""

FITS = """() => [...document.querySelectorAll('.symdyn-shown img')].filter(x => x.naturalWidth < 100).length
  + document.documentElement.scrollWidth - innerWidth"""


@pytest.mark.slow
@pytest.mark.long(0)
@pytest.mark.runs("chromium")
def test_a_notebook_run_by_jupyter_looks_right_in_a_browser(tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    cells = [nbformat.v4.new_code_cell(text) for text in CELLS.strip().splitlines()]
    book = nbformat.v4.new_notebook(cells=cells)
    executed(book, resources={"metadata": {"path": str(tmp_path)}})
    outputs = [cell.outputs[-1].data for cell in book.cells]
    assert all({"text/html", "text/plain"} <= set(data) for data in outputs)
    assert "text/latex" in outputs[1]

    path = tmp_path / "page.html"
    style = "<style>body{background:Canvas;color:CanvasText;color-scheme:light dark}</style>"
    path.write_text('<!doctype html><meta charset="utf-8">' + style + "".join(x["text/html"] for x in outputs), "utf-8")
    with chromium() as browser:
        for scheme, width in (("light", 1000), ("dark", 1000), ("light", 420)):
            with opened(browser, path, width, scheme) as shown_page:
                assert shown_page.evaluate(FITS) <= 0, (scheme, width)
