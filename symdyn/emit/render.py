"""What reaches Jinja: templates hold the shape of a file, everything else comes in as finished text.

Text of a scene in every target, each escaped at one place: nothing in it is read as anything but characters.

    in_latex        prose of LaTeX                     in_comment      comments of C and JavaScript
    in_html         HTML and SVG, attributes too       in_docstring    docstrings
    in_markdown     prose of Markdown and notebooks    in_code         Python code, as data
    in_rustdoc      prose of Rust's doc comments
    in_script       JSON in a <script> element         in_script_code  JavaScript there
    in_percent_comment  comments and help of MATLAB    in_julia_docstring  docstrings of Julia
    in_xml          attributes of XML

Formats of scenes have their own: `scene.toml` for TOML; names, which are identifiers, are all that URDF and parameter
files hold. Terminals are the errors' own matter (`symdyn.errors.printable`).
"""

from __future__ import annotations

import json
import re
import unicodedata
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from symdyn.resources import folder
from symdyn.scene.values import GREEK

if TYPE_CHECKING:
    from jinja2 import Environment

_ASCII = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_ASCII |= {character: f"\\{character}" for character in "&%$#_{}"}

_TYPED = frozenset(  # what T1 and textcomp hold of what pdfTeX reads as UTF-8
    "ÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÐÑÒÓÔÕÖØÙÚÛÜÝÞßàáâãäåæçèéêëìíîïðñòóôõöøùúûüýþÿĂăĄąĆćČčĎďĐđĘęĚěĞğĹĺĽľŁłŃńŇňŐőŔŕŘřŚśŞşŠšŢţŤťŮůŰűŸŹźŻżŽž"
    "ŒœĲĳŊŋ¡¿«»‹›–—‘’‚“”„…·°±×÷¬µ¹²³¼½¾€£¥§©®™ªº¶†‡•‰"
)
_SIGNS = {"−": "-", "≤": r"\le", "≥": r"\ge", "≈": r"\approx", "≠": r"\ne", "→": r"\to", "∞": r"\infty", "√": r"\surd"}

_MARKDOWN = {character: f"\\{character}" for character in "`*_{}[]<>#|~&"}
_MARKDOWN |= {character: f"<span>&#{ord(character)};</span>" for character in "\\$"}  # which open mathematics
_LINK = r"(?i)(?<![a-z])(https?|ftp|mailto|xmpp)(?=:)|(?<![a-z])(www)(?=\.)|(?=@)"


def in_latex(text: str) -> str:
    """Return prose for LaTeX; a character that pdfTeX has no letter for becomes one near it, or a question mark."""
    return "".join(_ASCII.get(x, x) if x <= "~" else _beyond_ascii(x) for x in unicodedata.normalize("NFC", text))


def _beyond_ascii(character: str) -> str:
    if character in _TYPED:
        return character
    if character in _SIGNS:
        return rf"\ensuremath{{{_SIGNS[character]}}}"
    greek = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", unicodedata.name(character, ""))
    if greek:
        letter = greek[2].lower().replace("lamda", "lambda")
        letter = letter if greek[1] == "SMALL" else letter.capitalize()
        if letter in GREEK:
            return rf"\ensuremath{{\{letter}}}"
    near = [x for x in unicodedata.normalize("NFKD", character) if " " <= x <= "~"]
    return "".join(_ASCII.get(x, x) for x in near) or ("" if unicodedata.combining(character) else "?")


def in_html(text: str, quote: bool = True) -> str:
    """Return text for an element of HTML and SVG, and unless `quote` is False for an attribute in quotes."""
    from html import escape  # equations need none

    return escape(text, quote)


def in_xml(text: str) -> str:
    """Return text for an attribute of XML, in quotes: one line, without characters that XML 1.0 does not have."""
    return in_html(_printable(text))


def in_markdown(text: str) -> str:
    """Return prose in which Markdown reads nothing else: no mark, no link, no address that becomes one, no formula.

    Notebooks look for formulas in the text and, once more, in the page that is made of it; no formula spans elements.
    """
    return re.sub(_LINK, lambda found: f"{found[0]}\\", "".join(_MARKDOWN.get(x, x) for x in text))


def in_rustdoc(text: str) -> str:
    """Return prose for one line of a Rust doc comment, which is Markdown: no code in it that `cargo test` would run."""
    return in_markdown(" ".join(_printable(text).split()))


def in_script(value: Any) -> str:
    """Return JSON that cannot end the script it stands in, nor open a comment there."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def in_script_code(code: str) -> str:
    """Return JavaScript that cannot end the <script> it stands in: its comments and strings alone hold such text."""
    return code.replace("</", "<\\/").replace("<!--", "<\\!--")


def in_code(text: str) -> str:
    r"""Return text as a Python literal, as data and nothing else, to stand in brackets: each line of it on its own.

    >>> print("read(" + in_code("a = 1\nb = 2") + ")")
    read(
        'a = 1\n'
        'b = 2'
    )
    """
    lines = text.split("\n")
    whole = [repr(f"{line}\n") for line in lines[:-1]] + [repr(line) for line in lines[-1:] if line]
    return "\n" + "".join(f"    {line}\n" for line in whole) if len(lines) > 1 else repr(text)


def in_comment(text: str, prefix: str = " * ") -> str:
    """Return `text` as lines of a comment of C or JavaScript; nothing in it ends the comment or starts another one."""
    harmless = re.sub(r"\?(?=\?)", "? ", text.replace("*/", "* /").replace("/*", "/ *"))
    return "\n".join(f"{prefix}{_printable(line)}".rstrip() for line in harmless.split("\n"))


def in_percent_comment(text: str) -> str:
    """Return `text` as lines of a comment of MATLAB and Octave, whose `help` shows it as it stands.

    No line opens a comment over several lines, holds a link, which may be a command, or is read as Texinfo.
    """
    harmless = text.replace("-*-", "- * -").replace("<", "< ").replace("< =", "<=")
    return "\n".join(f"% {_printable(line)}".rstrip() for line in harmless.split("\n"))


def in_docstring(text: str, indent: int = 0) -> str:
    """Return `text` as lines of a docstring in triple quotes; nothing in it can end the docstring."""
    harmless = text.replace("\\", "\\\\").replace('"""', "'''")
    lines = [_printable(line).rstrip() for line in harmless.split("\n")]
    if lines[-1].endswith('"'):
        lines[-1] = f"{lines[-1]} "
    return "\n".join([lines[0], *(f"{' ' * indent}{line}".rstrip() for line in lines[1:-1]), *lines[1:][-1:]])


def in_julia_docstring(text: str) -> str:
    """Return `text` as lines of a string of Julia in triple quotes; nothing in it ends that or is put into it."""
    harmless = text.replace("\\", "\\\\").replace("$", "\\$").replace('"', '\\"')
    return "\n".join(_printable(line).rstrip() for line in harmless.split("\n"))


def _printable(line: str) -> str:
    """Return `line` without control and direction characters, which compilers warn about."""
    return line if line.isprintable() else "".join(one if one.isprintable() else " " for one in line)


def render(template: str, values: Mapping[str, Any]) -> str:
    """Return the text of `template` (a path below `templates/`); a value it misses is an error."""
    return _environment().get_template(template).render(values)


@cache
def verbatim(file: str) -> str:
    """Return the text of a file that is no template, such as a script, without its last end of line."""
    return (folder("templates") / file).read_text(encoding="utf-8").removesuffix("\n")


@cache
def script(file: str) -> str:
    """Return the text of a file of JavaScript without indents and without lines that are comments."""
    lines = (line.strip() for line in verbatim(file).splitlines())
    return "\n".join(line for line in lines if line and not line.startswith(("//", "/*", "*")))


@cache
def _environment() -> Environment:
    """Return the one environment, made when the first file is rendered."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    from symdyn.emit.compiled_templates import Beside

    environment = Environment(
        bytecode_cache=Beside(),
        loader=FileSystemLoader(folder("templates")),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    environment.filters |= {
        "in_comment": in_comment, "in_docstring": in_docstring, "in_html": in_html, "in_rustdoc": in_rustdoc,
        "in_percent_comment": in_percent_comment, "in_script": in_script, "in_script_code": in_script_code,
    }  # fmt: skip
    environment.globals |= {"verbatim": verbatim, "script": script}
    return environment
