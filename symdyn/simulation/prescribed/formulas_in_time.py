"""Formulas in time and state as a user writes them: parsed, their names checked, their parameters bound."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from symdyn.bounds import BOUNDS
from symdyn.errors import SceneError, SimulateError
from symdyn.scene import Quantity, Scene, SceneUnits, parse, read_bounded
from symdyn.scene.values import Faults, FormulaError, Unit, fits, spell, substituted, suggestion

LARGEST_FILE = BOUNDS["bytes of a file of numbers or formulas"]
"""A million rows of three numbers have room in it."""


def read_formula(
    text: object,
    allowed: Iterable[str],
    where: str,
    faults: Faults,
    advice: Callable[[str], str] | None = None,
    unit: str = "",
) -> Quantity | None:
    """Return a formula whose symbols are among `allowed`; None after a fault, with advice about a name behind it.

    `unit` is that of what it is for; a value that is written with one of another kind is a fault.
    """
    known = tuple(dict.fromkeys(allowed))
    try:
        formula = parse(text if isinstance(text, str) else str(text))
        fits(formula, Unit.read(unit) if unit else None, known)
    except FormulaError as error:
        faults.add(where, f"{text} {error}" if str(error).startswith("is in ") else str(error))
        return None
    unknown = [name for name in formula.symbols if name not in known]
    for name in unknown:
        more = f", {advice(name)}" if advice else ""
        faults.add(where, f'"{text}" uses {name}, which is not known here; {suggestion(name, known)}{more}')
    return None if unknown else formula


def read_seen(scene: Scene, text: object, where: str, faults: Faults) -> Quantity | None:
    """Return a formula in what can be looked at: letters of `signals`, parameters, outputs; None after a fault."""
    words = re.findall(r"\w+", str(text))
    parameters, outputs = (one.name for one in scene.parameters), {one.name: one.formula for one in scene.outputs}
    formula = read_formula(text, (*scene.letters(words), *parameters, *outputs), where, faults)
    if formula is None:
        return None
    seen = substituted(formula, outputs)
    SceneUnits(scene).check(seen, where, faults)
    return seen


def parameter_values(scene: Scene) -> dict[str, Quantity]:
    """Return the values of the scene's parameters.

    Raises:
        SimulateError: one has no value.
    """
    free = [parameter.name for parameter in scene.free_parameters]
    if free:
        binding = ",".join(f"{name}=1" for name in free)
        have = "has" if len(free) == 1 else "have"
        raise SimulateError(f"{scene.name}: {', '.join(free)} {have} no value; give them, as in --bind {binding}")
    return {parameter.name: parameter.value for parameter in scene.parameters if parameter.value is not None}


def bound(formula: Quantity, values: Mapping[str, Quantity]) -> Quantity:
    """Return the formula with values in place of parameters.

    Raises:
        FormulaError: it divides by what is now zero, or takes a root or logarithm that does not exist.
    """
    return substituted(formula, values)


def number_of(formula: Quantity, values: Mapping[str, Quantity], where: str, faults: Faults) -> float | None:
    """Return the value of a formula in parameters, None after a fault."""
    try:
        value = bound(formula, values).at({})
    except FormulaError as error:
        faults.add(where, f"{spell(formula)} {error}")
        return None
    assert value is not None, "all symbols were checked"
    return float(value)


def words(entries: Iterable[str], what: str, faults: Faults) -> dict[str, str]:
    """Return name and text of every `name=text` in order; what is none is a fault of the option `what`."""
    found: dict[str, str] = {}
    for entry in entries:
        name, equals, text = (piece.strip() for piece in entry.partition("="))
        if not name or not equals or not text:
            files = what in ("forces", "motion")
            known = "is neither a file nor name=formula" if files else "is not name=formula"
            faults.add(what, f'"{entry}" {known}')
        elif name in found:
            faults.add(what, f"{name} is given twice, as {found[name]} and as {text}")
        else:
            found[name] = text
    return found


def read_file(path: Path) -> str:
    """Return the text of a file.

    Raises:
        SimulateError: it cannot be read, and why.
    """
    try:
        return read_bounded(path, LARGEST_FILE, "a file", "give fewer rows").decode("utf-8-sig")
    except SceneError as fault:
        raise SimulateError(fault.faults) from None
    except UnicodeDecodeError as error:
        raise SimulateError(f"{path}: byte {error.start} is not UTF-8; save the file as UTF-8 text") from None
