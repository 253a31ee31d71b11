"""States of one's own and signals: their keys; and names that stand for formulas, in any order, circles told.

Derived parameters and signals are such names. Their formulas stand in place of them wherever they are used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symdyn.errors import suggestion
from symdyn.graph import Op
from symdyn.scene.declaration.reading import read_coherent
from symdyn.scene.declaration.scene_table import LATEX
from symdyn.scene.values.description import DESCRIBED
from symdyn.scene.values.entry import EntryReader, Faults, shown
from symdyn.scene.values.folding import substituted
from symdyn.scene.values.formula import DEEPEST, MOST_NODES
from symdyn.scene.values.key import TIMED, Key, Part, keys_of, number, one_of, shape_of
from symdyn.scene.values.letters import WAYS, Parameter, Reset, Signal
from symdyn.scene.values.quantity import FormulaError, Quantity
from symdyn.scene.values.shape import TEXT

_RESET: tuple[Key[Quantity] | Key[str], ...] = (
    number("when", names=TIMED, example='a formula that passes zero, such as when = "s - 1"'),
    number("to", names=TIMED),
    one_of("way", WAYS, "which passages count", WAYS[0]),
)


def _reset(table: EntryReader, key: str, usual: Reset | None) -> Reset | None:
    if key not in table:
        return usual
    inner = table.inner(key, keys_of(_RESET), 'write reset = { when = "s - 1", to = 0, way = "up" }')
    when, to, way = (one.declared(inner) for one in _RESET)
    if "when" in inner and isinstance(when, Quantity) and not when.symbols:
        inner.fault(f'when = {shown(when)} never passes zero; write a formula that does, such as when = "s - 1"')
    return Reset(when, to, way)  # type: ignore[arg-type]


STATE: tuple[Part, ...] = (
    number("rate", names=TIMED, example='its rate, such as rate = "(u - R*i)/L"', holds="its rate, a formula"),
    number("start", field="value", holds="where it starts; zero when left out"),
    Key("unit", read_coherent, "", holds="of SI", shape=TEXT),
    Key("reset", _reset, None, inside=_RESET, holds="where it jumps, and to what", shape=shape_of(_RESET, ["when"])),
    LATEX,
    DESCRIBED,
)

SIGNAL: tuple[Part, ...] = (
    number("formula", names=TIMED, example='what it is, such as formula = "k*(q1 - q2)"', holds="which others use"),
    Key("unit", read_coherent, "", holds="of SI", shape=TEXT),
    DESCRIBED,
)


def signals_apart(signals: tuple[Signal, ...], places: Sequence[str], faults: Faults) -> tuple[Signal, ...]:
    """Return signals without names of other ones in their formulas; those in a circle are zero, and a fault."""
    where = dict(zip((one.name for one in signals), places, strict=True))
    found: dict[str, Quantity] = {}
    formulas = {one.name: one.formula for one in signals}
    for name in formulas:
        _derive(name, formulas, (), where, found, faults, "formula")
    return tuple(replace(one, formula=found[one.name]) for one in signals)


Parameters = tuple[Parameter, ...]


def derived_apart(parameters: Parameters, places: Sequence[str], faults: Faults) -> tuple[Parameters, Parameters]:
    """Return the parameters that are plain, and the ones that are formulas of others, in plain ones alone.

    What is derived wrongly, such as in a circle, is a fault, and without a value then.
    """
    where = dict(zip((one.name for one in parameters), places, strict=True))
    formulas = {one.name: one.value for one in parameters if one.value is not None and one.value.symbols}
    found: dict[str, Quantity] = {}
    for name in formulas:
        _derive(name, formulas, (), where, found, faults)
    apart = tuple(replace(one, value=found.get(one.name)) for one in parameters if one.name in formulas)
    for one in apart:
        if one.tolerance is not None:
            faults.add(where[one.name], f"{one.name} is derived; give the tolerance to what it is derived from")
    return tuple(one for one in parameters if one.name not in formulas), apart


def _derive(
    name: str,
    formulas: Mapping[str, Quantity],
    path: tuple[str, ...],
    where: Mapping[str, str],
    found: dict[str, Quantity],
    faults: Faults,
    key: str = "value",
) -> None:
    """Put what a name stands for into `found`, those first that its formula names; values know no others."""
    if name in found:
        return
    formula, place, closed = formulas[name], where[name], key == "value"
    told = f"{key} = {shown(formula)}"
    found[name] = Quantity.ZERO  # until it is known, and after a fault
    for other in formula.symbols:
        if other in (*path, name):
            circle = " -> ".join([*(*path, name)[(*path, name).index(other) :], other])
            advice = "give one of them a number" if closed else "make one of them a state, or solve it by hand"
            faults.add(place, f"{told} depends on itself: {circle}; {advice}")
            return
        if closed and other not in where:
            faults.add(place, f"{told} uses the undefined symbol {other}; {suggestion(other, where)}")
            return
        if other in formulas:
            _derive(other, formulas, (*path, name), where, found, faults, key)
    try:
        nodes, depth = _extent(
            formula, {name: _extent(one, {}) for name, one in found.items() if name in formula.symbols}
        )
        if nodes > MOST_NODES or depth > DEEPEST:
            raise FormulaError("multiplies out to too many terms; give a part of it as a number")
        found[name] = substituted(formula, found)
    except FormulaError as error:
        faults.add(place, f"{told} {error}")


def _extent(part: Quantity, known: Mapping[str, tuple[int, int]]) -> tuple[int, int]:
    """Return how many nodes a formula has, and how many levels, symbols in `known` counted as those say."""
    if part.op is Op.SYMBOL:
        return known.get(str(part.value), (1, 1))
    inside = [_extent(arg, known) for arg in part.args]
    return 1 + sum(nodes for nodes, _ in inside), 1 + max((depth for _, depth in inside), default=0)
