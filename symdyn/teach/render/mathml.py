r"""LaTeX as MathML, by latex2mathml, with what browsers need beside it: spaces around functions, low accents, lines."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache

from symdyn.errors import EmitError

NAMES = "sin|cos|tan|tanh|exp|ln|operatorname{[a-z]+}"
_BEFORE = re.compile(rf"(?<=[\w}})]) (?=\\(?:{NAMES})(?![a-z]))")
_AFTER = re.compile(rf"(\\(?:{NAMES})(?:\^(?:\d|{{\d+}}))?) (?=[\w\\])")
_ACCENTED = re.compile(r"<mover>((?:(?!</?mover>).)*)<mo>([¨˙])</mo></mover>")
_BRACED = re.compile(r"<munder><munder>(.*?)<mo>⏟</mo></munder>")
_NUMBERED = re.compile(r"&#x0*([0-9A-Fa-f]+);")
_WRAPPED = re.compile(r"<math[^>]*><mrow>(.*)</mrow></math>", re.DOTALL)


def inline(latex: str) -> str:
    """Return a formula that stands in a line of text."""
    return f"<math>{inner(latex)}</math>"


def display(lines: Sequence[str]) -> str:
    r"""Return lines "left &= right" as one formula, aligned at the & of each."""
    rows = []
    for line in lines:
        left, _, right = line.partition("&")
        cells = f'<mtd class="l">{inner(left)}</mtd><mtd class="r">{inner(right.replace("{}", "", 1))}</mtd>'
        rows.append(f"<mtr>{cells}</mtr>")
    return f'<math display="block" class="lines"><mtable displaystyle="true">{"".join(rows)}</mtable></math>'


@cache
def inner(latex: str) -> str:
    """Return the MathML of a formula without the element around it.

    Raises:
        EmitError: latex2mathml is not installed.
    """
    try:
        from latex2mathml.converter import convert
    except ModuleNotFoundError as fault:
        raise EmitError("mathematics in HTML needs latex2mathml: pip install 'symdyn[teach]'") from fault
    if not latex.strip():
        return ""
    spaced = _AFTER.sub(r"\1 \\, ", _BEFORE.sub(r" \\, ", latex))
    found = _WRAPPED.fullmatch(convert(spaced))
    assert found is not None, "latex2mathml writes one mrow in one math element"
    text = _NUMBERED.sub(_character, found[1])
    text = _BRACED.sub(r'<munder><mrow class="brace">\1</mrow>', text)  # a glyph that browsers stretch in part only
    text = text.replace('<mo stretchy="true" fence="true" minsize', '<mo lspace="0" rspace="0" fence="true" minsize')
    return _ACCENTED.sub(r'<mover accent="true">\1<mo stretchy="false">\2</mo></mover>', text)


def _character(found: re.Match[str]) -> str:
    character = chr(int(found[1], 16))
    return found[0] if character in "<>&" else character
