r"""LaTeX as MathML, by latex2mathml, with what browsers need beside it: spaces around functions, low accents, lines.

Lessons hold thousands of formulas, so the markup is short: thin spaces stand in the tokens beside them, as characters.
"""

from __future__ import annotations

import re
from functools import cache
from itertools import accumulate

from symdyn.emit.print import BREAK, latex_width
from symdyn.errors import EmitError
from symdyn.extras import install

BRACKET = 150.0  # pt at 10 pt: what is no longer stays in one line, which a phone has room for
PART = " <wbr>"  # the space belongs to the line that ends
NAMES = "sin|cos|tan|tanh|exp|ln|operatorname{[a-z]+}"
_BEFORE = re.compile(rf"(?<=[\w}})]) (?=\\(?:{NAMES})(?![a-z]))")
_AFTER = re.compile(rf"(\\(?:{NAMES})(?:\^(?:\d|{{\d+}}))?) (?=[\w\\])")
_ACCENTED = re.compile(r"<mover>((?:(?!</?mover>).)*)<mo>([¨˙])</mo></mover>")
_BRACED = re.compile(r"<munder><munder>(.*?)<mo>⏟</mo></munder>")
_NUMBERED = re.compile(r"&#x0*([0-9A-Fa-f]+);")
_OPERATOR = re.compile(r"\s*([=+-]|\\approx(?![A-Za-z])|)\s*(.*?)\s*", re.DOTALL)
_THIN = '<mspace width="0.167em" />'
_THIN_AFTER = re.compile(rf"(<mn>[^<]*|<mi>[^<]{{2,}})(</m[in]>){_THIN}")
_THIN_RAISED = re.compile(rf"(<mn>[^<]*)(</mn></m(?:sup|sub|subsup)>){_THIN}")
_THIN_BEFORE = re.compile(rf"{_THIN}((?:<m(?:sup|row)>)*<mi>)(?=[a-z]{{2}})")
_ALONE = re.compile(r"<mrow>(<m[ino]>[^<]*</m[ino]>)</mrow>")
_WRAPPED = re.compile(r"<math[^>]*><mrow>(.*)</mrow></math>", re.DOTALL)


def inline(latex: str) -> str:
    """Return a formula that stands in a line of text."""
    return f"<math>{inner(latex)}</math>"


def flow(left: str, right: str) -> str:
    r"""Return "left = right" in pieces, between which lines may part: terms, and terms in brackets that are long."""
    return PART.join(pieces(left, right))


def pieces(left: str, right: str) -> list[str]:
    r"""Return "left", where there is one, and the terms of "= right"."""
    shown = [inline(left)] if left else []
    term: list[str] = []
    depth = 0
    for piece in _whole(right.split(BREAK)):
        found = _OPERATOR.fullmatch(piece)
        assert found is not None, "a pattern of any text"
        sign, rest = found[1].replace("-", "−").replace(r"\approx", "≈"), found[2]
        term.append(f"{sign} {inline(rest)}" if sign else inline(rest))
        depth += _depths(piece)[-1]
        if depth <= 0:
            shown.append(term[0] if len(term) == 1 else f'<span class="term">{PART.join(term)}</span>')
            term = []
    return [*shown, *term]


def _whole(pieces: list[str]) -> list[str]:
    """Return the pieces with short brackets put together."""
    found = [pieces[-1]]
    for piece in reversed(pieces[:-1]):
        found.append(piece)
        while (count := _closing(found)) and latex_width(whole := "".join(reversed(found[-count:]))) <= BRACKET:
            found[-count:] = [whole]
    return found[::-1]


def _closing(pieces: list[str]) -> int:
    """Return how many pieces, the last first, close a bracket that the last one opens; 0 where it opens none."""
    depth = inside = _depths(pieces[-1])[-1]
    if depth > 0:
        for count, piece in enumerate(reversed(pieces[:-1]), 2):
            depths = _depths(piece)
            if inside + min(depths) < depth:
                return count
            inside += depths[-1]
    return 0


def _depths(piece: str) -> list[int]:
    """Return the depth of brackets before and behind each of them."""
    return [0, *accumulate(1 if x == "(" else -1 for x in piece if x in "()")]


@cache
def inner(latex: str) -> str:
    """Return the MathML of a formula without the element around it.

    Raises:
        EmitError: latex2mathml is not installed.
    """
    try:
        from latex2mathml.converter import convert
    except ModuleNotFoundError as fault:
        raise EmitError(f"mathematics in HTML needs latex2mathml: {install('teach')}") from fault
    if not latex.strip():
        return ""
    spaced = _AFTER.sub(r"\1 \\, ", _BEFORE.sub(r" \\, ", latex))
    found = _WRAPPED.fullmatch(convert(spaced))
    assert found is not None, "latex2mathml writes one mrow in one math element"
    text = _NUMBERED.sub(_character, found[1])
    text = _BRACED.sub(r'<munder><mrow class="brace">\1</mrow>', text)  # a glyph that browsers stretch in part only
    text = text.replace('<mo stretchy="true" fence="true" minsize', "<mo minsize")
    text = _ALONE.sub(r"\1", text)
    text = _THIN_BEFORE.sub("\\1\u2009", _THIN_AFTER.sub("\\1\u2009\\2", text))
    text = _THIN_RAISED.sub("\\1\u2005\\2", text)  # as wide, in smaller type
    return _ACCENTED.sub(_dotted, text)


def _dotted(match: re.Match[str]) -> str:
    """Return a base with dots: low ones on a letter, above a word where they are none of its own letters'."""
    word = match[1].count("<mi") > 1
    low = "" if word else ' accent="true"'
    return f"<mover{low}>{match[1]}<mo>{match[2]}</mo></mover>"


def _character(match: re.Match[str]) -> str:
    character = chr(int(match[1], 16))
    return match[0] if character in "<>&" else character
