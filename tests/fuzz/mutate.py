"""Mutations: of the leaves and branches of a table, of the words of a text, of bytes."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator
from random import Random
from typing import Any

from .grammar import NASTY, Table

Place = tuple[Any, Any]
"""A list or table, and an index or key in there."""

WORDS = re.compile(rb"[0-9][0-9.eE+-]*|[A-Za-z_][A-Za-z_0-9]*|\"[^\"\n]*\"|[^\sA-Za-z0-9]")

SPECIAL = (
    *(
        b"\x00",
        b"\x1b[2J",
        b"\r",
        b"\xff",
        b"\xed\xa0\x80",
        b"\xef\xbb\xbf",
        b"\xe2\x80\xae",
        b"\xc2\x9b31m",
        b"\n\n",
        b"\t",
    ),
    *(
        b'"""',
        b"'''",
        b"[[",
        b"]]",
        b"{",
        b"}",
        b"<",
        b"</",
        b"/>",
        b"<!--",
        b"-->",
        b"<![CDATA[",
        b"&lt;",
        b"&x;",
        b"(*",
        b"*)",
    ),
    *(
        b"<!DOCTYPE a [<!ENTITY b 'c'>]>",
        b"=",
        b",",
        b"#",
        b"\\",
        b"\\frac",
        b"^",
        b"_",
        b"{,}",
        b"\\begin{align}",
        b"$$",
        b"&",
    ),
)


GROWTH = 0.1
"""Of the changes that may make something large, the part that do: such cases take their time."""

LARGEST = 8 * 2**20
"""Bytes beyond which a text is changed no more: to list its words would take more memory than a case may."""

DEEP = 150
"""Levels of a table that is made deep; text is made deeper, by repeating its brackets."""


def toml(value: Table) -> str:
    """Return a table as TOML: a head for each table in it and for each in those, deeper ones in one line."""
    rows = [f"{_key(key)} = {_toml(one)}" for key, one in value.items() if not isinstance(one, dict)]
    for key, one in value.items():
        if isinstance(one, dict):
            rows += [
                f"\n[{_key(key)}]",
                *(f"{_key(k)} = {_toml(v)}" for k, v in one.items() if not isinstance(v, dict)),
            ]
            for name, entry in one.items():
                if isinstance(entry, dict):
                    rows += [f"\n[{_key(key)}.{_key(name)}]", *(f"{_key(k)} = {_toml(v)}" for k, v in entry.items())]
    return "\n".join(rows) + "\n"


def _key(key: Any) -> str:
    text = str(key)
    return text if re.fullmatch(r"[A-Za-z0-9_-]+", text) else _text(text)


def _text(text: str) -> str:
    def spelled(character: str) -> str:
        if character in '"\\':
            return "\\" + character
        return character if character.isprintable() else f"\\U{ord(character):08x}"

    return '"' + "".join(map(spelled, text)) + '"'


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_toml(v)}" for k, v in value.items()) + "}"
    return "[" + ", ".join(map(_toml, value)) + "]"


def spoil(rng: Random, value: Table, times: int) -> Table:
    """Return a table with some of its leaves or branches changed, moved, doubled or gone."""
    spoilt: Table = copy.deepcopy(value)
    grown = False  # once: what writes it down nests as deep
    for _ in range(times):
        places = list(_places(spoilt))
        if not places:
            break
        holder, key = rng.choice(places)
        match rng.randrange(10):
            case 0:
                del holder[key]
            case 1:
                other, place = rng.choice(places)
                holder[key] = copy.deepcopy(other[place])
            case 2 if isinstance(holder, dict):
                holder[str(rng.choice(NASTY))[:80]] = holder.pop(key)
            case 3 if isinstance(holder, dict):
                holder[str(key) + rng.choice("sx_1")] = holder.pop(key)
            case 4:
                holder[key] = rng.choice(([holder[key]], [holder[key]] * 3, {"value": holder[key]}, str(holder[key])))
            case 5 if not grown and rng.random() < GROWTH:
                grown, holder[key] = True, _grown(rng, holder[key])
            case _:
                holder[key] = copy.deepcopy(rng.choice(NASTY))
    return spoilt


def _grown(rng: Random, value: Any) -> Any:
    """Return something deep, long or wide."""
    size = rng.choice((100, 400, 1000, 5000))
    match rng.randrange(4):
        case 0:
            for _ in range(min(size, DEEP)):
                value = [value]
        case 1:
            for _ in range(min(size, DEEP)):
                value = {"a": value}
        case 2:
            value = [copy.deepcopy(value) for _ in range(size)]
        case _:
            value = {f"a{k}": copy.deepcopy(value) for k in range(size)}
    return value


def _places(value: Any) -> Iterator[Place]:
    """Yield every place of a nested table, branches before their leaves."""
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, one in list(entries):
        yield value, key
        yield from _places(one)


def scribble(rng: Random, text: bytes, times: int, other: bytes = b"") -> bytes:
    """Return a text with some of its words, lines or bytes changed; `other` is a text to take pieces from."""
    for _ in range(times):
        if len(text) > LARGEST:
            break
        text = rng.choice((_word, _word, _word, _line, _byte, _piece))(rng, text, other or text)
    return text


def _word(rng: Random, text: bytes, other: bytes) -> bytes:
    """Put another word in place of one: out of the text, or a hostile one."""
    words = list(WORDS.finditer(text))
    if not words:
        return text
    old = rng.choice(words)
    nasty = str(rng.choice(NASTY)).encode(errors="surrogatepass")
    new = rng.choice(
        (nasty, nasty, rng.choice(words)[0], b'"' + nasty + b'"', b"", old[0] * 2, old[0] * rng.choice((40, 300, 3000)))
    )
    return text[: old.start()] + new + text[old.end() :]


def _line(rng: Random, text: bytes, other: bytes) -> bytes:
    """Drop, double, multiply or move a line, or take one from another text."""
    rows = text.split(b"\n")
    k = rng.randrange(len(rows))
    match rng.randrange(5):
        case 0:
            del rows[k]
        case 1:
            rows.insert(k, rows[k])
        case 2:
            rows.insert(rng.randrange(len(rows)), rows.pop(k))
        case 3 if rng.random() < GROWTH:
            rows[k:k] = [rows[k].replace(b"1", b"%d" % number) for number in range(rng.choice((100, 1000, 5000)))]
        case _:
            rows.insert(k, rng.choice(other.split(b"\n")))
    return b"\n".join(rows)


def _byte(rng: Random, text: bytes, other: bytes) -> bytes:
    """Change, drop or insert some bytes."""
    at = rng.randrange(len(text) + 1)
    return text[:at] + rng.choice((*SPECIAL, bytes([rng.randrange(256)]), b"")) + text[at + rng.choice((0, 0, 1, 5)) :]


def _piece(rng: Random, text: bytes, other: bytes) -> bytes:
    """Cut the text short, double a piece, or put a piece of another one there."""
    a, b = sorted(rng.randrange(len(text) + 1) for _ in range(2))
    c, d = sorted(rng.randrange(len(other) + 1) for _ in range(2))
    return rng.choice((text[:b], text[:a] + text[b:], text[:b] + text[a:], text[:a] + other[c:d] + text[a:]))
