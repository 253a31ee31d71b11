"""Text of a scene in every target, each escaped at one place: nothing in it is read as anything but characters.

    in_latex        prose of LaTeX                     in_comment      comments of C and JavaScript
    in_html         HTML and SVG, attributes too       in_docstring    docstrings
    in_markdown     prose of Markdown and notebooks    in_code         Python code, as data
    in_rustdoc      prose of Rust's doc comments
    in_script       JSON in a <script> element         in_script_code  JavaScript there
    in_percent_comment  comments and help of MATLAB    in_julia_docstring  docstrings of Julia
    in_xml          attributes of XML

Formats of scenes have their own: `toml_writer` for TOML; names, which are identifiers, are all that URDF and parameter
files hold. Terminals are the errors' own matter (`symdyn.errors.printable`).

The one place that puts files on disk, for all that write any: all of a file or nothing of it.

Each is filled aside, in its own folder, and renamed, so that a reader sees the old contents or the new ones and never
half of them, a full disk leaves nothing, and a link that stands where the file goes is replaced, not followed.
"""

from __future__ import annotations

import html
import json
import os
import re
import tempfile
import unicodedata
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from errno import EILSEQ, EISDIR, ENAMETOOLONG, ENOSPC
from pathlib import Path, PurePosixPath
from typing import IO, Any

from symdyn.errors import EmitError, quoted
from symdyn.scene.values import GREEK

_ASCII = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_ASCII |= {character: f"\\{character}" for character in "&%$#_{}"}

_TYPED = frozenset(  # what T1 and textcomp hold of what pdfTeX reads as UTF-8
    "ÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÐÑÒÓÔÕÖØÙÚÛÜÝÞßàáâãäåæçèéêëìíîïðñòóôõöøùúûüýþÿĂăĄąĆćČčĎďĐđĘęĚěĞğĹĺĽľŁłŃńŇňŐőŔŕŘřŚśŞşŠšŢţŤťŮůŰűŸŹźŻżŽž"
    "ŒœĲĳŊŋ¡¿«»‹›–—‘’‚“”„…·°±×÷¬µ¹²³¼½¾€£¥§©®™ªº¶†‡•‰"
)
_SIGNS = {"−": "-", "≤": r"\le", "≥": r"\ge", "≈": r"\approx", "≠": r"\ne", "→": r"\to", "∞": r"\infty", "√": r"\surd"}

_MARKDOWN = {character: f"\\{character}" for character in "`*_{}[]<>#|~&"}
_MARKDOWN |= {character: f"<span>&#{ord(character)};</span>" for character in "\\$"}  # which open mathematics
_LINK = re.compile(r"(?i)(?<![a-z])(https?|ftp|mailto|xmpp)(?=:)|(?<![a-z])(www)(?=\.)|(?=@)")


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
    return html.escape(text, quote)


def in_xml(text: str) -> str:
    """Return text for an attribute of XML, in quotes: one line, without characters that XML 1.0 does not have."""
    return html.escape(_printable(text))


def in_markdown(text: str) -> str:
    """Return prose in which Markdown reads nothing else: no mark, no link, no address that becomes one, no formula.

    Notebooks look for formulas in the text and, once more, in the page that is made of it; no formula spans elements.
    """
    return _LINK.sub(lambda found: f"{found[0]}\\", "".join(_MARKDOWN.get(x, x) for x in text))


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


def in_percent_comment(text: str, prefix: str = "% ") -> str:
    """Return `text` as lines of a comment of MATLAB and Octave, whose `help` shows it as it stands.

    No line opens a comment over several lines, holds a link, which may be a command, or is read as Texinfo.
    """
    harmless = text.replace("-*-", "- * -").replace("<", "< ").replace("< =", "<=")
    return "\n".join(f"{prefix}{_printable(line)}".rstrip() for line in harmless.split("\n"))


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


ELSEWHERE = "give a folder that you may write to"
SPELLED = "give names of characters that UTF-8 has"

WAYS_OUT: Mapping[int | None, str] = {
    EILSEQ: SPELLED,
    EISDIR: "give another name",
    ENAMETOOLONG: "give a shorter name",
    ENOSPC: "make room, or give a folder on another disk",
}
"""What helps against what a system says, where it is not another folder."""

Contents = str | bytes | Callable[[IO[bytes]], None]


def write(files: Mapping[str, Contents], folder: str | Path) -> tuple[Path, ...]:
    """Write files into a folder and return the paths; all are filled before the first is renamed.

    Args:
        files: contents by name, with a folder or several before a stroke: text, which becomes UTF-8, bytes, or what
            fills an open file.
        folder: where they go; it is made if it is missing, as are the folders in it.

    Raises:
        EmitError: the folder cannot be made or written to; two names are one where capital letters do not count.
    """
    place = Path(folder)
    if "\0" in "".join(map(str, (place, *files))):
        raise EmitError(f"{place / next(iter(files), '')}: no system allows this name; give another folder")
    folded: dict[str, str] = {}
    for name in files:
        other = folded.setdefault(name.casefold(), name)
        if other != name:
            raise EmitError(
                f"{other} and {name} differ in capital letters alone, and are one file on many systems; rename one"
            )
    try:
        place.mkdir(parents=True, exist_ok=True)
        with ExitStack() as left_over:
            aside = []
            for name, contents in files.items():
                inside = PurePosixPath(name)
                assert str(inside) == name, "a name has one form"
                assert not {"..", inside.anchor} & {*inside.parts}, "files lie in the folder, nowhere else"
                (place / inside.parent).mkdir(parents=True, exist_ok=True)
                _check_place(place / name)
                aside.append(temporary := _aside((place / name).parent))
                left_over.callback(temporary.unlink, missing_ok=True)
                _fill(temporary, contents)
            for temporary, name in zip(aside, files, strict=True):
                os.replace(temporary, place / name)
    except (OSError, ValueError) as fault:  # a name that no system can spell
        reason = getattr(fault, "strerror", None) or str(fault)
        advice = WAYS_OUT.get(fault.errno, ELSEWHERE) if isinstance(fault, OSError) else SPELLED
        raise EmitError(f"{place}: cannot write {', '.join(files)} there ({reason}); {advice}") from fault
    return tuple(place / name for name in files)


def write_file(file: str | Path, contents: Contents) -> Path:
    """Write one file, as `write` does.

    Raises:
        EmitError: it cannot be written, or has no name.
    """
    path = Path(file)
    if path.name in ("", ".."):
        raise EmitError(f"file = {quoted(str(file))} is a folder; give the path of a file")
    return write({path.name: contents}, path.parent)[0]


def _check_place(path: Path) -> None:
    """Raise OSError for what no file can replace, before another file is renamed."""
    if path.is_dir() and not path.is_symlink():
        raise IsADirectoryError(EISDIR, "a folder of that name stands there")


def _aside(place: Path) -> Path:
    """Return a new empty file in a folder, with the permissions of any other file there."""
    handle, name = tempfile.mkstemp(prefix=".symdyn-", dir=place)
    os.close(handle)
    mask = os.umask(0)
    os.umask(mask)
    os.chmod(name, 0o666 & ~mask)
    return Path(name)


def _fill(path: Path, contents: Contents) -> None:
    with path.open("wb") as file:
        if callable(contents):
            contents(file)
        else:
            file.write(contents.encode() if isinstance(contents, str) else contents)
