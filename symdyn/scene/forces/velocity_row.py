"""A row that is a formula: Σ a_k(q) u_k = 0.

What keeps it has the power λ Σ a_k u_k, and that is all a formula says: at a wheel's rim, in a belt or in two servos,
the motion is the same, and the reactions of the joints are not. They exist where the row says that its force acts in
the joints of its velocities, as drives would; a contact says which place of which body it touches.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from symdyn.graph import Graph, Op
from symdyn.scene.forces.force_kind import Forbid, ForceKind
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.entry import Entry, EntryReader, entry, show, shown
from symdyn.scene.values.folding import add, div, mul, neg, sub
from symdyn.scene.values.joint import Row
from symdyn.scene.values.key import MOTION, Key, Stand, number
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity, spell
from symdyn.scene.values.shape import choice_of


@dataclass(frozen=True)
class Formula(Row):
    """Σ a_k(q) u_k = 0.

    Attributes:
        formula: its left side, linear in the velocities.
        acts_in: "joints" where the force that keeps it acts in the joints of its velocities; "" where nothing says
            which bodies it acts on.
    """

    formula: Quantity
    acts_in: str = ""

    kind = "formula"


IN_JOINTS = "joints"
"""What a row says of the place of its force: each of its velocities feels it in its own joint, as a drive."""


def _acts_in(table: EntryReader, key: str, usual: str) -> str:
    said = table.text(key, usual)
    if said in (usual, IN_JOINTS):
        return said
    table.fault(
        f'{key} = {show(said)} is no place of a force; write {key} = "{IN_JOINTS}" where belts, gears or servos of its '
        'joints keep the row, and type = "rolling" for a wheel'
    )
    return usual


def lacks_place(row: Formula, velocities: Sequence[str]) -> bool:
    """Tell whether a row exerts a force and does not say where."""
    slopes = {} if row.acts_in else linear_parts(row.formula, velocities)[0]
    return any(not one.express(Graph()).is_zero for one in slopes.values())


def _check(row: Formula, stand: Stand) -> None:
    """Report a formula that is not linear in the velocities, or holds none."""
    text = f"formula = {shown(row.formula)}"
    try:
        slopes, rest = linear_parts(row.formula, stand.scene.velocities)
        alone = not rest.express(Graph()).is_zero
    except FormulaError as error:
        stand.fault(f"{text} is not linear in the velocities: {error}; multiply out what can be")
        return
    except ZeroDivisionError:
        return  # reported as a formula without a value
    if alone:
        stand.fault(f"{text} holds {shown(rest)}, which no velocity multiplies; a row is a sum of velocities")
    elif not slopes and row.formula != Quantity.ZERO:
        stand.fault(f"{text} holds no velocity; write one such as x_dot - r*phi_dot")
    elif not row.acts_in and sorted(_units(stand.scene, slopes)) == ["m", "rad"]:
        stand.faults.note(
            stand.where,
            f'{text} looks like a wheel that rolls: type = "rolling" says where it touches too, without which there '
            f'are no reactions; where a belt or a servo ties the joints, acts_in = "{IN_JOINTS}" says so',
        )


def _units(scene: Scene, velocities: Iterable[str]) -> list[str]:
    """Return the units of some velocities but for their second, "rad" or "m"."""
    units = [unit for joint in scene.moving for unit in JOINTS[joint.type].velocities(joint)]
    return [unit for name, unit in zip(scene.velocities, units, strict=False) if name in set(velocities)]


def linear_parts(formula: Quantity, velocities: Sequence[str]) -> tuple[dict[str, Quantity], Quantity]:
    """Return the coefficient of every velocity in a formula, and the rest, all free of velocities.

    Raises:
        FormulaError: it is not linear as it is written.
    """
    if not set(formula.symbols) & set(velocities):
        return {}, formula
    if formula.op is Op.SYMBOL:
        return {str(formula.value): Quantity.ONE}, Quantity.ZERO
    parts = [linear_parts(arg, velocities) for arg in formula.args]
    (slopes, rest), (more, other) = parts[0], parts[-1]
    if formula.op is Op.NEG:
        return {name: neg(x) for name, x in slopes.items()}, neg(rest)
    if formula.op in (Op.ADD, Op.SUB):
        combine = add if formula.op is Op.ADD else sub
        names = dict.fromkeys([*slopes, *more])
        return {k: combine(slopes.get(k, Quantity.ZERO), more.get(k, Quantity.ZERO)) for k in names}, combine(
            rest, other
        )
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
    parts=(
        number(
            "formula",
            example='what vanishes, such as formula = "x_dot - r*phi_dot"',
            names=MOTION,
            holds="what vanishes: velocities, each times a formula in coordinates and parameters",
        ),
        Key("acts_in", _acts_in, "", holds="where its force acts", shape=choice_of(IN_JOINTS)),
    ),
    law=Forbid(lambda row: row.formula),
    law_words=lambda row: f"{spell(row.formula)} = 0" + f", its force in the {row.acts_in}" * bool(row.acts_in),
    words={"en": "constraint", "sk": "väzba"},
    lost="a constraint on velocities",
    check=_check,
)


def row(name: str, formula: str | Quantity, *, acts_in: Literal["joints"] | None = None) -> Entry:
    """Declare a constraint on velocities: a formula, linear in them, that vanishes.

    With `acts_in` "joints" the force that keeps it acts in the joints of its velocities, as drives would; else nothing
    says where, and the scene has no reactions.
    """
    return entry("rows", name, formula=formula, acts_in=acts_in)
