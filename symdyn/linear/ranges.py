"""Values as users give them: a range, a list, or a number that is a formula without names."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import LinearizeError
from symdyn.scene import Scene, parse
from symdyn.scene.values import FormulaError, Parameter, Unit, fits, question, split_commas

MOST = 20_000
"""Values of a parameter at most."""

RANGES: Mapping[str, Callable[[float, float, int], Array]] = {"linspace": np.linspace, "geomspace": np.geomspace}

RANGE = re.compile(r"(?P<kind>\w+)\s*\((?P<inside>.*)\)\Z", re.DOTALL)

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")

FORM = '"NAME=linspace(0,10,100)", geomspace(0.1,10,50) or [1, 2, 5]'


def read_values(text: str, option: str = "--over", scene: Scene | None = None) -> tuple[str, Array]:
    """Return the name and the values of `NAME=linspace(a,b,n)`, `geomspace(a,b,n)` or `[a, b, ...]`.

    With a scene, numbers are asked about that are bare where its parameter is in another unit than that of SI.

    Raises:
        LinearizeError: it is none of these.
    """
    name, equals, said = (part.strip() for part in text.partition("="))
    if not equals or not NAME.match(name):
        raise LinearizeError(f'{option}: "{text}" names nothing; write {FORM}')
    letters = () if scene is None else scene.parameters
    return name, numbers(said, f"{option} {name}", next((one for one in letters if one.name == name), None))


def numbers(specified: str, where: str, letter: Parameter | None = None) -> Array:
    """Return the values of a range or a list, as of `read_values`."""
    found = RANGE.match(specified)
    if found and found["kind"] in RANGES:
        texts = split_commas(found["inside"])
        parts = [_number(part, where, letter if k < 2 else None) for k, part in enumerate(texts)]
        if len(parts) != 3 or parts[2] != int(parts[2]) or not 2 <= parts[2] <= MOST:
            raise LinearizeError(f"{where}: {specified} wants a beginning, an end and how many, 2 to {MOST}")
        if found["kind"] == "geomspace" and not parts[0] * parts[1] > 0:
            raise LinearizeError(f"{where}: {specified} begins and ends on the same side of zero")
        return np.asarray(RANGES[found["kind"]](parts[0], parts[1], int(parts[2])))
    if specified.startswith("[") and specified.endswith("]"):
        return np.array([_number(part, where, letter) for part in split_commas(specified[1:-1])])
    raise LinearizeError(f'{where}: "{specified}" is no range; write {FORM}')


def number_in(text: str, letter: Parameter | None = None) -> float:
    """Return the number that a formula without names is, of a letter or of none.

    Raises:
        FormulaError: it is none, or in a unit that does not fit the letter's, or in none where it has one of its own.
    """
    formula = parse(text)
    if letter is not None:
        fits(formula, Unit.read(letter.unit) if letter.unit else None)
        if asked := question(letter, text):
            raise FormulaError(asked)
    if formula.symbols:
        raise FormulaError(f"{text} is no number; it names {', '.join(formula.symbols)}")
    value = formula.at({})
    assert value is not None, "a formula without names has a value, or raises"
    return float(value)


def _number(text: str, where: str, letter: Parameter | None) -> float:
    try:
        return number_in(text, letter)
    except FormulaError as error:
        raise LinearizeError(f"{where}: {text}: {error}") from None
