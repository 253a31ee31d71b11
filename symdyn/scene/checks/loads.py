"""What acts on bodies: its places, its joints, its signs; rows are linear in the velocities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.graph import Graph, Op
from symdyn.scene.checks.contacts import check_contact
from symdyn.scene.draft import Draft, shown
from symdyn.scene.folding import FormulaError, add, div, mul, neg, sub
from symdyn.scene.loads import Damper, Place, Spring
from symdyn.scene.model import GROUND, Joint
from symdyn.scene.names import suggestion
from symdyn.scene.quantity import ONE, ZERO, Quantity, express
from symdyn.scene.table import Faults
from symdyn.scene.value import Value, value_of


def check_loads(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Report what is wrong with springs, dampers, loads and rows."""
    scene, where = draft.scene, draft.where
    bodies = [*(body.name for body in scene.bodies), GROUND]
    joints = {joint.name: joint for joint in scene.joints}
    for kind in ("springs", "dampers"):
        for place, one in zip(where[kind], getattr(scene, kind), strict=True):
            _ends(place, one, joints, bodies, [point.name for point in scene.points], faults)
    for place, damper in zip(where["dampers"], scene.dampers, strict=True):
        if len(damper.damping) == 1 and _below_zero(damper.damping[0], values):
            faults.add(place, f"damping = {shown(damper.damping[0])} is negative; give zero or more")
    for place, load in zip(where["loads"], scene.loads, strict=True):
        _body(place, "body", load.place, bodies, faults)
        if load.place.body == GROUND:
            faults.add(place, f"acts on {GROUND}, which does not move; name a body")
    for place, row in zip(where["rows"], scene.rows, strict=True):
        if row.type == "formula":
            _linear(place, row.formula, scene.velocities, faults)
        else:
            check_contact(place, row, bodies, values, faults)


def _ends(
    where: str,
    one: Spring | Damper,
    joints: Mapping[str, Joint],
    bodies: Sequence[str],
    points: Sequence[str],
    faults: Faults,
) -> None:
    if one.joint:
        joint = joints.get(one.joint)
        if joint is None:
            faults.add(where, f'joint = "{one.joint}" is not a joint of the tree; {suggestion(one.joint, joints)}')
        elif not joint.coordinate and joint.coupling is None:
            many = f"has {len(joint.coordinates)} coordinates" if joint.coordinates else "does not move"
            faults.add(where, f'joint = "{one.joint}" {many}; name one with one, or two points by from and to')
    elif not one.ends:
        faults.nameless(where, "joint", one.joint)
    for key, end in zip(("from", "to"), one.ends, strict=False):
        faults.nameless(where, key, end.body)
        if end.body and end.body not in bodies:
            near = suggestion(end.body, [*bodies, *points])
            faults.add(where, f'{key} = "{end.body}" is neither a body nor a point; {near}')
    if len(one.ends) == 2 and one.ends[0].body and one.ends[0].body == one.ends[1].body:
        faults.add(where, f'from and to are on one body, "{one.ends[0].body}", so that it never changes its length')


def _body(where: str, key: str, place: Place, bodies: Sequence[str], faults: Faults) -> None:
    faults.nameless(where, key, place.body)
    if place.body and place.body not in bodies:
        faults.add(where, f'{key} = "{place.body}" is not a body; {suggestion(place.body, bodies)}')


def _linear(where: str, formula: Quantity, velocities: Sequence[str], faults: Faults) -> None:
    text = f"formula = {shown(formula)}"
    try:
        slopes, rest = linear_parts(formula, velocities)
        alone = not express(rest, Graph()).is_zero
    except FormulaError as error:
        faults.add(where, f"{text} is not linear in the velocities: {error}; multiply out what can be")
        return
    except ZeroDivisionError:
        return  # reported as a formula without a value
    if alone:
        faults.add(where, f"{text} holds {shown(rest)}, which no velocity multiplies; a row is a sum of velocities")
    elif not slopes and formula != ZERO:
        faults.add(where, f"{text} holds no velocity; write one such as x_dot - r*phi_dot")


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


def _below_zero(quantity: Quantity, values: Mapping[str, Value]) -> bool:
    try:
        value = value_of(quantity, values)
    except FormulaError:
        return False  # reported as a formula without a value
    return value is not None and value < 0
