"""Names as MathML, which every browser sets by itself: an accent stands clear of a tall letter."""

from __future__ import annotations

import re
from html import escape

from symdyn.draw.lettering import ACCENTS, Run, from_latex

OVER = {"vec": "→", "dot": "˙", "ddot": "¨", "hat": "^", "bar": "¯", "tilde": "~"}
SIGNS = {ACCENTS[name]: sign for name, sign in OVER.items()}
ALONE = re.compile(r"<(mi|mn|mover)[^>]*>(?:(?!</\1>).)*</\1>")
PIECE = re.compile(rf"(\d+|[^\W\d_]+?|.)([{''.join(SIGNS)}]?)", re.DOTALL)


def symbol(latex: str, power: str = "") -> str:
    r"""Return the LaTeX of a name, such as `\dot\theta_1`, as a `<math>` element, raised to a power if there is one.

    >>> symbol(r"\\dot q_1")
    '<math><msub><mover accent="true"><mi>q</mi><mo>˙</mo></mover><mn>1</mn></msub></math>'
    """
    groups: list[tuple[str, str, str]] = []  # base, below, above
    for run in from_latex(latex).runs:
        base, below, above = groups.pop() if run.level and groups else ("", "", "")
        text = _row(run)
        groups.append((base + text * (run.level == 0), below + text * (run.level < 0), above + text * (run.level > 0)))
    base, below, above = groups.pop() if groups else ("", "", "")
    groups.append((base, below, above + (f"<mn>{escape(power)}</mn>" if power else "")))
    return f"<math>{''.join(_scripted(*group) for group in groups)}</math>"


def _scripted(base: str, below: str, above: str) -> str:
    tag = {(True, True): "msubsup", (True, False): "msub", (False, True): "msup"}.get((bool(below), bool(above)))
    if tag is None:
        return base
    rows = [base, *(x for x in (below, above) if x)]
    return f"<{tag}>{''.join(x if ALONE.fullmatch(x) else f'<mrow>{x}</mrow>' for x in rows)}</{tag}>"


def _row(run: Run) -> str:
    """Return the characters of a run, a word as one."""
    if not run.face and run.text.isalpha() and len(run.text) > 1:
        return f"<mi>{escape(run.text)}</mi>"
    if run.face == "t":
        return f'<mi mathvariant="normal">{escape(run.text)}</mi>'
    return "".join(_token(text, accent, run.face) for text, accent in PIECE.findall(run.text))


def _token(text: str, accent: str, face: str) -> str:
    if text.isdigit():
        token = f"<mn>{text}</mn>"
    elif text.isalpha():
        token = f"<mi>{escape(text)}</mi>" if face == "i" else f'<mi mathvariant="normal">{escape(text)}</mi>'
    elif text == " ":
        token = '<mspace width="0.2em"></mspace>'
    else:
        token = f"<mo>{escape(text)}</mo>"
    return f'<mover accent="true">{token}<mo>{SIGNS[accent]}</mo></mover>' if accent else token
