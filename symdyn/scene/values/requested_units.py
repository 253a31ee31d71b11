"""What is said and asked where a run gives a bare number to a letter that is in its writer's unit, "500 mm"."""

from __future__ import annotations

from collections.abc import Iterable

from symdyn.errors import SceneError
from symdyn.scene.values import folding
from symdyn.scene.values.folding import fraction
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.model import Letter
from symdyn.scene.values.quantity import FormulaError, Quantity
from symdyn.scene.values.spelling import spell
from symdyn.scene.values.unit import Unit, in_si


def ask_for_units(letters: Iterable[Letter], given: Iterable[tuple[str, str]], option: str) -> None:
    """Look whether bare numbers were typed for letters that are in another unit than that of SI.

    Args:
        letters: those of the scene.
        given: name and text of what was typed.
        option: in which.

    Raises:
        SceneError: there are such, and what may be meant.
    """
    chosen = {one.name: one for one in letters if one.written}
    told = (question(chosen[name], text) for name, text in given if name in chosen)
    asked = [f"{option}: {one}" for one in told if one]
    if asked:
        raise SceneError(asked)


def question(letter: Letter, text: str) -> str:
    """Return what a bare number may mean of a letter that is in another unit than that of SI; "" where all is said."""
    if not letter.written or not _is_bare(text):
        return ""
    number = fraction(quantity(text))
    size = Quantity.ONE if number is None else folding.constant(number)
    there = float(in_si(size, Unit.read(letter.written)).at({}) or 0)
    front = f"{letter.name} is given in {letter.written}: say {letter.name}="
    return f"{front}{spell(size)}{letter.written} or {letter.name}={there:.12g}{letter.unit}"


def _is_bare(text: str) -> bool:
    """Tell whether a text is a number without a unit, other than zero, which is zero in all of them."""
    try:
        found = quantity(text)
    except FormulaError:
        return False
    return not (found.unit or found.symbols or found == Quantity.ZERO)
