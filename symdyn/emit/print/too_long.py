"""Pages that would be too long: their formulas are counted before one is written, and refused with their size."""

from __future__ import annotations

from collections.abc import Iterable

from symdyn.algebra import Form
from symdyn.errors import EmitError

MOST = 5.0
"""Megabytes of a page."""

BYTES = 5
"""Of a page in LaTeX for every part of its formulas, in long ones."""


def refuse_too_long(name: str, what: str, forms: Iterable[Form], ask: str) -> None:
    """Do nothing where formulas fit on a page that somebody may read.

    Args:
        name: of the scene.
        what: is written, such as "D'Alembert's system".
        forms: all that are written, as often as they are.
        ask: what to do instead.

    Raises:
        EmitError: they do not.
    """
    known: dict[int, tuple[Form, int]] = {}
    size = BYTES * sum(_parts(form, known) for form in forms) / 1e6
    if size > MOST:
        raise EmitError(
            f"{name}: {what} would be some {float(f'{size:.1g}'):g} MB of formulas, and {MOST:g} MB are the most that "
            f"are written; {ask}"
        )


def _parts(form: Form, known: dict[int, tuple[Form, int]]) -> int:
    """Return of how many parts a form is written; `known` holds it by identity, as long forms share theirs."""
    if id(form) not in known:
        known[id(form)] = form, 1 + sum(_parts(part, known) for part in form.parts)
    return known[id(form)][1]
