"""Constraints on velocities: a blade, a wheel or a ball touches a plane of another body, or a formula vanishes.

    X    placement of the frame at P in that of the plane; P is the blade's point, or the centre O of a wheel
    a    axis of a wheel, or direction across a blade, axes of the plane's body
    n    normal of the plane        w    |a × n|, the sine of the angle between them
    d    from O to the point of the rim that is lowest; -r n for a ball

A contact's wrenches are the forces at the lowest point, moved to O. The one along n has a residual, the height of that
point, n·p - r w, whose rate it is; the others say nothing about places.

A formula is Σ a_k(q) u_k = 0. What keeps it has the power λ Σ a_k u_k, and that is all it says: at a wheel's rim, in a
belt or in two servos, the motion is the same, and the reactions of the joints are not. They exist where the row says
that its force acts in the joints of its velocities, as drives would; a contact says which place of which body it
touches.

Reference: Neimark and Fufaev, Dynamics of Nonholonomic Systems (1972), chapter 1.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Literal

from symdyn.arguments import suggesting
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op
from symdyn.scene.forces.attachments import AtBody, OnPlane
from symdyn.scene.forces.force_kind import ContactLaw, Forbid, ForceKind, Rim
from symdyn.scene.joints.blocks import forces, unit
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values import folding
from symdyn.scene.values.entry import Entry, EntryReader, Number, Three, entry, plain, show, shown
from symdyn.scene.values.joint import Contact, Plane, Row
from symdyn.scene.values.key import MOTION, Key, Stand, number
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, Vector, spell
from symdyn.scene.values.shape import VECTOR, choice_of, several
from symdyn.spatial import Transform, Vec, Wrench, cross, dot, scale, sub

ACROSS: Vector = (Quantity.ZERO, Quantity.ONE, Quantity.ZERO)

COMPONENTS = ("along", "across", "normal")

AXIS_HOLDS = "of the wheel, or across the blade, in the frame of the body; any length but zero"


def _axis(table: EntryReader, key: str, ball: Vector | None) -> Vector | None:
    return table.vector(key, ACROSS) if key in table else ball


def _usual(ball: bool) -> tuple[str, ...]:
    """Return the components that vanish where nothing is said."""
    return COMPONENTS if ball else COMPONENTS[:2]


def _components(table: EntryReader, key: str, _: tuple[str, ...]) -> tuple[str, ...]:
    usual = _usual("axis" not in table)
    raw = plain(table.raw.get(key, usual))
    some = isinstance(raw, (list, tuple)) and raw and all(one in COMPONENTS for one in raw)
    if not isinstance(raw, (list, tuple)) or not some or len(set(raw)) < len(raw):
        table.fault(
            f'{key} = {show(raw)} is not a list of "along", "across" and "normal"; leave it out for '
            f"{' and '.join(usual) if len(usual) == 2 else 'all three'}"
        )
        return usual
    return tuple(raw)


# Wrenches


def _blade(row: Contact, X: Transform, w: Expr) -> tuple[Wrench, ...]:
    assert row.axis is not None, "a blade has a direction across it"
    return forces(X.R @ unit(row.axis, w.graph))


def _rolling(row: Contact, X: Transform, w: Expr) -> tuple[Wrench, ...]:
    graph = w.graph
    n, r = unit(row.plane.normal, graph), row.radius.express(graph)
    if row.axis is None:
        along, d = in_plane(n), scale(-r, n)
        ways = {"along": _at_rim(along, d), "across": _at_rim(cross(n, along), d), "normal": forces(n)[0]}
        return tuple(ways[component] for component in row.components)
    a = X.R @ unit(row.axis, graph)
    if w.is_zero:
        raise DerivationError(
            f"constraints.{row.name}: {row.place.body} lies flat on its plane wherever the joints stand, "
            "its axis along the normal, so that no point of its rim is the lowest; turn the axis of the wheel"
        )
    d = scale(-r / w, sub(n, scale(dot(n, a), a)))
    ways = {
        "along": Wrench(scale(1 / w, cross(a, n)), scale(-r, a)),
        "across": _at_rim(scale(1 / w, cross(n, cross(a, n))), d),
        "normal": _at_rim(n, d),
    }
    return tuple(ways[component] for component in row.components)


def _at_rim(force: Vec, d: Vec) -> Wrench:
    return Wrench(force, cross(d, force))


def _rise(row: Contact, X: Transform, w: Expr) -> Expr:
    """Return how far the point of a blade is off its plane, m."""
    return dot(unit(row.plane.normal, w.graph), X.p)


def _height(row: Contact, X: Transform, w: Expr) -> Expr:
    """Return how far the lowest point of a wheel or a ball is off its plane, m."""
    return _rise(row, X, w) - row.radius.express(w.graph) * w


def _lean(row: Contact, X: Transform) -> Vec | None:
    graph = X.p[0].graph
    return cross(X.R @ unit(row.axis, graph), unit(row.plane.normal, graph)) if row.axis else None


def in_plane(n: Vec) -> Vec:
    """Return a unit vector of a plane: its x, unless the normal is along it."""
    graph = n[0].graph
    x, y = (graph.one, graph.zero, graph.zero), (graph.zero, graph.one, graph.zero)
    axis = y if n[1].is_zero and n[2].is_zero else x
    way = sub(axis, scale(dot(axis, n), n))
    return scale(graph.one / graph.sqrt(dot(way, way)), way)


def _words(row: Contact) -> tuple[str, ...]:
    track = {way: "" if row.axis is None else f"force {way} the track" for way in ("along", "across")}
    return tuple((track | {"normal": "normal force"})[component] for component in row.components)


# The kinds


def _three(vector: Vector) -> str:
    return f"[{', '.join(spell(x) for x in vector)}]"


def _where(plane: Plane) -> str:
    return f"the plane of {plane.body} through {_three(plane.at)}, normal {_three(plane.normal)}"


def _law_of_blade(row: Contact) -> str:
    on = f" on {_where(row.plane)}" if row.plane.declared else ""
    return f"{row.place.body} does not slide along its {_three(row.axis or NULL)} at {_three(row.place.at)}{on}"


def _law_of_rolling(row: Contact) -> str:
    kind = f"ball of radius {spell(row.radius)}"
    if row.axis is not None:
        kind = f"wheel of radius {spell(row.radius)} about its {_three(row.axis)}"
    height = "" if "normal" in row.components else "; its height is not held"
    return f"{row.place.body}, a {kind}, rolls on {_where(row.plane)} ({', '.join(row.components)}{height})"


LOST = "a constraint on velocities"

KNIFE_EDGE = ForceKind(
    section="constraints",
    noun=partial(Contact, type="knife_edge"),
    letter="r",
    parts=(
        AtBody(),
        Key("axis", EntryReader.vector, ACROSS, example="axis = [0, 1, 0]", names=None, holds=AXIS_HOLDS),
        OnPlane(needs_normal=False),
    ),
    law=ContactLaw(lambda _, X: None, _blade, _rise, lambda _: (False,), lambda _: ("force across the blade",)),
    law_words=_law_of_blade,
    words={"en": "knife edge", "sk": "čepeľ"},
    lost=LOST,
)

ROLLING = ForceKind(
    section="constraints",
    noun=partial(Contact, type="rolling"),
    letter="r",
    parts=(
        AtBody(),
        Key("axis", _axis, None, names=None, shape=VECTOR, holds=AXIS_HOLDS),
        number(
            "radius",
            "m",
            example="radius = 0.1",
            above_zero="is that of no wheel; give one above zero",
            letters=("r",),
            text="radius of {}",
            positive=True,
            geometry=True,
        ),
        OnPlane(needs_normal=True),
        Key[tuple[str, ...]](
            "components",
            _components,
            (),
            silent=lambda row: row.components == _usual(row.axis is None),
            holds="of the velocity of the point that touches, which vanish",
            shape=several(choice_of(*COMPONENTS), 1, 9),
        ),
    ),
    law=ContactLaw(_lean, _rolling, _height, lambda row: tuple(one == "normal" for one in row.components), _words),
    law_words=_law_of_rolling,
    words={"en": "rolling contact", "sk": "valenie"},
    lost=LOST,
    mark=Rim(),
)


@suggesting
def knife_edge(
    name: str,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    axis: Three,
    plane: Mapping[str, object] | None = None,
    text: str = "",
) -> Entry:
    """Declare a point of a body that has no velocity along an axis of the body, the one across the blade.

    With a plane {"body": name, "at": [x, y, z], "normal": [x, y, z]} the velocity is relative to the body that carries
    it, the ground when left out.
    """
    return entry("constraints", type="knife_edge", **locals())


@suggesting
def rolling(
    name: str,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    axis: Three | None = None,
    radius: Number,
    plane: Mapping[str, object] | None = None,
    normal: Three | None = None,
    components: Sequence[str] | None = None,
    text: str = "",
) -> Entry:
    """Declare a wheel, disc or ball that rolls on a plane without slip, see `Row`.

    Args:
        name: of the constraint.
        body: the wheel.
        at: its centre in body coordinates, m; the origin when left out.
        point: its centre, in place of body and place.
        axis: of the wheel, body axes; left out for a ball.
        radius: of the wheel, m.
        plane: {"body": name, "at": [x, y, z], "normal": [x, y, z]}, in coordinates of that body; what is left out is
            the ground, its origin, and the direction against gravity.
        normal: of the plane, in place of `plane`: then the scene does not say where it lies.
        components: of the velocity of its lowest point, those that vanish: of "along", "across" and "normal", the last
            of which holds it at its height too; for a wheel the first two when left out, for a ball all.
        text: a description, as of `spring`.
    """
    return entry("constraints", type="rolling", **locals())


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
    return any(not one.is_zero for one in slopes.values())


def _check_formula(row: Formula, stand: Stand) -> None:
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
            f'{text} looks like a wheel that rolls: type = "rolling" gives its point of contact, without which there '
            f'are no reactions; where a belt or a servo ties the joints, write acts_in = "{IN_JOINTS}"',
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
        return {name: folding.neg(x) for name, x in slopes.items()}, folding.neg(rest)
    if formula.op in (Op.ADD, Op.SUB):
        combine = folding.add if formula.op is Op.ADD else folding.sub
        names = dict.fromkeys([*slopes, *more])
        return {k: combine(slopes.get(k, Quantity.ZERO), more.get(k, Quantity.ZERO)) for k in names}, combine(
            rest, other
        )
    if formula.op is Op.MUL and slopes and more:
        raise FormulaError(f"{shown(formula)} multiplies velocities")
    if formula.op is Op.MUL:
        factor = rest if more else other
        return {name: folding.mul(factor, x) for name, x in (slopes or more).items()}, folding.mul(rest, other)
    if formula.op is Op.DIV and not more:
        return {name: folding.div(x, other) for name, x in slopes.items()}, folding.div(rest, other)
    raise FormulaError(f"{shown(formula)} is no sum of them")


FORMULA = ForceKind(
    section="constraints",
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
    check=_check_formula,
)


@suggesting
def constraint(
    name: str, formula: str | Quantity, *, acts_in: Literal["joints"] | None = None, text: str = ""
) -> Entry:
    """Declare a constraint on velocities: a formula, linear in them, that vanishes.

    With `acts_in` "joints" the force that keeps it acts in the joints of its velocities, as drives would; else nothing
    says where, and the scene has no reactions.
    """
    return entry("constraints", name, formula=formula, acts_in=acts_in, text=text)
