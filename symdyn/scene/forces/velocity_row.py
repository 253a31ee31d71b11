"""A row that is a formula: Σ a_k(q) u_k = 0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.graph import Graph, Op
from symdyn.scene.forces.force_kind import Forbid, ForceKind
from symdyn.scene.values.element import Row
from symdyn.scene.values.folding import FormulaError, add, div, mul, neg, sub
from symdyn.scene.values.key import MOTION, Key, Stand, always_said
from symdyn.scene.values.quantity import ONE, ZERO, Quantity, express
from symdyn.scene.values.spelling import spell
from symdyn.scene.values.table import Entry, Table, entry, shown


@dataclass(frozen=True)
class Formula(Row):
    """Σ a_k(q) u_k = 0; the formula is its left side, linear in the velocities."""

    formula: Quantity

    kind = "formula"


def _check(row: Formula, stand: Stand) -> None:
    """Report a formula that is not linear in the velocities, or holds none."""
    text = f"formula = {shown(row.formula)}"
    try:
        slopes, rest = linear_parts(row.formula, stand.scene.velocities)
        alone = not express(rest, Graph()).is_zero
    except FormulaError as error:
        stand.fault(f"{text} is not linear in the velocities: {error}; multiply out what can be")
        return
    except ZeroDivisionError:
        return  # reported as a formula without a value
    if alone:
        stand.fault(f"{text} holds {shown(rest)}, which no velocity multiplies; a row is a sum of velocities")
    elif not slopes and row.formula != ZERO:
        stand.fault(f"{text} holds no velocity; write one such as x_dot - r*phi_dot")


def linear_parts(formula: Quantity, velocities: Sequence[str]) -> tuple[dict[str, Quantity], Quantity]:
    """Return the coefficient of every velocity in a formula, and the rest, all free of velocities.

    Raises:
        FormulaError: it is not linear as it is written.
    """
    if not set(formula.symbols) & set(velocities):
        return {}, formula
    if formula.op is Op.SYMBOL:
        return {str(formula.value): ONE}, ZERO
    parts = [linear_parts(arg, velocities) for arg in formula.args]
    (slopes, rest), (more, other) = parts[0], parts[-1]
    if formula.op is Op.NEG:
        return {name: neg(x) for name, x in slopes.items()}, neg(rest)
    if formula.op in (Op.ADD, Op.SUB):
        combine = add if formula.op is Op.ADD else sub
        names = dict.fromkeys([*slopes, *more])
        return {k: combine(slopes.get(k, ZERO), more.get(k, ZERO)) for k in names}, combine(rest, other)
    if formula.op is Op.MUL and slopes and more:
        raise FormulaError(f"{shown(formula)} multiplies velocities")
    if formula.op is Op.MUL:
        factor = rest if more else other
        return {name: mul(factor, x) for name, x in (slopes or more).items()}, mul(rest, other)
    if formula.op is Op.DIV and not more:
        return {name: div(x, other) for name, x in slopes.items()}, div(rest, other)
    raise FormulaError(f"{shown(formula)} is no sum of them")


FORMULA = ForceKind(
    section="rows",
    noun=Formula,
    letter="r",
    parts=(Key("formula", Table.quantity, ZERO, silent=always_said, names=MOTION),),
    needs=("formula",),
    missing='formula is missing; write what vanishes, such as formula = "x_dot - r*phi_dot"',
    law=Forbid(lambda row: row.formula),
    says=lambda row: f"{spell(row.formula)} = 0",
    words={"en": "constraint", "sk": "väzba"},
    lost="a constraint on velocities",
    check=_check,
)


def row(name: str, formula: str | Quantity) -> Entry:
    """Declare a constraint on velocities: a formula, linear in them, that vanishes."""
    return entry("rows", name, formula=formula)
