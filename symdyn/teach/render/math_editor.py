"""Answers in two dimensions: a page of exercises with MathLive's field for formulas (https://mathlive.io) in it."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Mapping
from pathlib import Path

from symdyn.emit import render
from symdyn.emit.print import latex_symbols
from symdyn.errors import EmitError
from symdyn.scene import Scene
from symdyn.scene.values import acceleration_name, velocity_name
from symdyn.teach.document import Document
from symdyn.teach.languages import language_of

SCRIPT, RULES = "mathlive.min.js", "mathlive-fonts.css"
FONTS = re.compile(
    r"@font-face\{[^}]*?url\((fonts/KaTeX_(?:AMS|Main|Math|Size[1-4])-(?:Regular|Italic)\.woff2)\)[^}]*\}"
)
"""Rules of the fonts that formulas of mechanics take."""

KEYS = (
    *(("7", "8", "9", r"\frac{#@}{#?}", "(", ")", r"\sin", r"\dot{#?}"),),
    *(("4", "5", "6", r"\cdot", "#@^{2}", "#@^{#?}", r"\cos", r"\ddot{#?}"),),
    *(("1", "2", "3", "-", r"\sqrt{#?}", "#@_{#?}", r"\tan", "[left]"),),
    *(("0", ".", "=", "+", r"\pi", "[backspace]", "[right]", "[return]"),),
)
"""Of the keyboard on a screen, besides the scene's letters."""


def with_math_editor(page: str, document: Document, folder: str) -> str:
    """Return a page of exercises whose boxes take formulas in two dimensions; one that asks for none as it is.

    Args:
        page: HTML, as `html_page` writes it.
        document: of the page.
        folder: MathLive's, as `npm install mathlive` makes it: node_modules/mathlive.

    Raises:
        EmitError: what is needed of MathLive is not there.
    """
    if 'type="text"' not in page or "const QUESTIONS" not in page:
        return page
    place, words = Path(folder), language_of(document.language).lesson
    editor = {
        "letters": letters(document.scene),
        "keys": KEYS,
        "words": {key: words[f"editor.{key}"] for key in ("text", "formula", "letters")},
    }
    try:
        rules = (place / RULES).read_text(encoding="utf-8")
        fonts = "\n".join(_inside(found, place) for found in FONTS.finditer(rules))
        mathlive = (place / SCRIPT).read_text(encoding="utf-8").replace("</script", r"<\/script")
    except OSError as fault:
        raise EmitError(
            f"{folder}: {Path(fault.filename or folder).name} is not there; npm install mathlive makes a folder"
            " node_modules/mathlive, which is to be given"
        ) from None
    values = {"fonts": fonts, "mathlive": mathlive, "editor": editor}
    before, _, after = page.rpartition("</body>")
    return before + render("teach/math_editor.html.jinja", values).rstrip("\n") + after


def letters(scene: Scene) -> Mapping[str, str]:
    """Return the scene's letters in LaTeX by what is typed for them: m1, q1, q1' and q1''."""
    symbols = latex_symbols(scene)
    primes = {
        name + prime: symbols[rate]
        for name in scene.coordinates
        for prime, rate in (("'", velocity_name(name)), ("''", acceleration_name(velocity_name(name))))
        if rate in symbols
    }
    return {name.replace("_", ""): latex for name, latex in (symbols | primes).items() if len(name) > 1} | {
        latex: latex for latex in symbols.values() if len(latex) == 1
    }


def _inside(rule: re.Match[str], place: Path) -> str:
    """Return a rule with its font inside."""
    font = b64encode((place / rule[1]).read_bytes()).decode()
    return rule[0].replace(rule[1], f"data:font/woff2;base64,{font}")
