"""The identified scene: parameters as they were found in place of those that were declared, to be written as a file.

Bodies that were declared by numbers get ten numbers near their own (`physical`). Where bodies are made of parameters
with names, these get values (`fit_names`), and formulas stay as they are.

Values of a scene's own parameters, m1 or l2c, are those that give the estimated base parameters:

    minimise    (beta(theta) - e)^T Sigma^-1 (beta(theta) - e)

beta are formulas of the parameters, not always linear ones (m1 h1^2). Parameters of the geometry are no unknowns: the
regressor was made with their values. Parameters that the data do not determine stay where they were, by a prior a
thousand times their size. Where the data determine combinations only, the nearest values that give the estimates are
taken.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from fractions import Fraction

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.arguments import argument, checked, native
from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs import BaseColumns
from symdyn.errors import IdentifyError, SceneError, choice, listed
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, evaluate, gradient, reachable
from symdyn.identification.identification import Identification
from symdyn.identification.linear_model import TEN, never_negative, places_of, unknowns, without_values
from symdyn.identification.physical import SPREAD, Physical, nearest_physical
from symdyn.scene import Quantity, Scene, SceneUnits, bind, with_force_parameters
from symdyn.scene.formats import possible
from symdyn.scene.values import Body, Faults
from symdyn.shown import Shown
from symdyn.simulation.prescribed import read_number

WEAK = 1e-3
"""One over the standard deviation of the prior, in sizes of a parameter."""

UNTOLD = 1e-3
"""Share in directions that the prior decides, not the data, from which on a parameter is not identifiable by itself."""

AT_LIMIT = 1e-9
"""In sizes of a parameter that cannot be negative: below it is zero."""


@dataclass(frozen=True)
class Named:
    """Values of parameters that have names in the scene.

    Attributes:
        names: of the parameters that were unknown, shape (k,).
        before: their values in the scene, NaN where it has none, shape (k,).
        values: as found, shape (k,).
        errors: standard errors, shape (k,); NaN for what is not identifiable by itself.
        distance: of the estimates from what these parameters can give, in standard errors (Mahalanobis).
        spare: how many more combinations were estimated than there are identifiable parameters: distance^2 is about
            this if the scene is right.
        fixed: names of parameters of geometry and gravity, which keep their values.
    """

    names: tuple[str, ...]
    before: Array
    values: Array
    errors: Array
    distance: float
    spare: int
    fixed: tuple[str, ...]


def inertial_names(scene: Scene) -> tuple[str, ...]:
    """Return the parameters that bodies are made of, and nothing of the geometry is."""
    places = {name for one in Quantity.inside(_geometry(scene)) for name in one.symbols}
    used = {name for one in Quantity.inside(scene.bodies) for name in one.symbols}
    return tuple(p.name for p in scene.parameters if p.name in used and p.name not in places)


def fit_names(
    scene: Scene,
    base: Sequence[str],
    combinations: Array,
    estimate: Array,
    covariance: Array,
    unbound: Collection[str] = (),
) -> Named:
    """Return values of the scene's parameters, by least squares in the metric of the covariance.

    Args:
        scene: the mechanism; parameters of its geometry have values.
        base: names of the base parameters, shape (b,).
        combinations: C, shape (k, b): estimated were C · base parameters.
        estimate: shape (k,).
        covariance: shape (k, k).
        unbound: parameters that are unknowns although they are zero.
    """
    from scipy.optimize import least_squares

    w = Workspace(without_values(scene, unbound))
    told, graph = BaseColumns.of(w).named(), w.graph
    told += tuple((name, graph.symbol(name)) for name in base if name not in dict(told))  # of rates of states alone
    beta = [told[k][1] for k in places_of(base, [name for name, _ in told])]
    places = {name for one in Quantity.inside(_geometry(scene)) for name in one.symbols}
    met = {str(node.value) for node in reachable(beta)}
    unknown = [p for p in scene.parameters if p.name in met and p.name not in places]
    fixed = [p for p in scene.parameters if p.name not in {one.name for one in unknown}]
    known = {graph.symbol(p.name): _number(p.value) for p in fixed if p.value is not None}
    before = np.array([np.nan if p.value is None else _number(p.value) for p in unknown])
    start = np.where(np.isnan(before), 1.0, before)
    size = np.where(np.abs(start) > 0, np.abs(start), 1.0)
    symbols = [graph.symbol(p.name) for p in unknown]
    slopes = [one for row in (gradient(entry, symbols) for entry in beta) for one in row]
    orders = reachable(beta), reachable(slopes)

    def at(theta: Array, entries: Sequence[Expr], order: Sequence[Expr]) -> Array:
        values = {**known, **dict(zip(symbols, map(float, theta), strict=True))}
        return np.array(evaluate(entries, Floats(), values, order=order))

    least = 1e-9 * np.maximum(np.abs(estimate), 1e-3 * float(np.abs(estimate).max(initial=1e-12)))
    weigh = np.linalg.solve(np.linalg.cholesky(covariance + np.diag(least**2)), np.eye(len(estimate)))

    def off(theta: Array) -> Array:
        data = weigh @ (combinations @ at(theta, beta, orders[0]) - estimate)
        return np.concatenate([data, WEAK * (theta - start) / size])

    def slope(theta: Array) -> Array:
        rows = at(theta, slopes, orders[1]).reshape(len(beta), len(symbols))
        return np.vstack([weigh @ combinations @ rows, WEAK * np.diag(1 / size)])

    bounded = {str(quantity.value) for _, quantity in never_negative(scene) if quantity.op is Op.SYMBOL}
    low = np.array([0.0 if p.positive or p.name in bounded else -np.inf for p in unknown])
    begin = np.where(np.isfinite(low), np.maximum(start, 1e-9 * size), start)
    found = least_squares(off, begin, slope, bounds=(low, np.inf), x_scale=size, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    rows = slope(found.x)
    _, s, turned = np.linalg.svd(rows * size, full_matrices=False)
    errors = size * np.linalg.norm(turned.T / s, axis=1)
    _, told_by, Vt = np.linalg.svd(rows[: len(estimate)] * size)
    known_by_data = int(np.sum(told_by > WEAK))
    errors[np.linalg.norm(Vt[known_by_data:], axis=0) > UNTOLD] = np.nan
    distance = float(np.linalg.norm(off(found.x)[: len(estimate)]))
    felt = np.linalg.norm(rows[: len(estimate)] * size, axis=0) > WEAK
    values = np.where(felt, found.x, start)
    values = np.where(np.isfinite(low) & (values < AT_LIMIT * size), 0.0, values)
    return Named(
        tuple(p.name for p in unknown), before, values, errors, distance, len(estimate) - known_by_data,
        tuple(p.name for p in fixed),
    )  # fmt: skip


def _number(value: Quantity) -> float:
    return float(value.at({}) or 0)


def _geometry(scene: Scene) -> Scene:
    """Return the scene without what acts and what is heavy."""
    joints = tuple(
        replace(joint, armature=Quantity.ZERO, damping=Quantity.ZERO, friction=Quantity.ZERO, dry=None, forces=())
        for joint in scene.joints
    )
    return replace(scene, bodies=(), elements=(), joints=joints, parameters=(), outputs=(), states=(), signals=())


DIGITS = 10
"""Significant digits that identified numbers are written with."""

HARDLY = 1e4
"""Standard errors between estimates and bodies that no noise of a real log makes."""

NOTHING = 1e-9
"""Part of the largest entry of its kind below which an entry of a body is zero."""


@dataclass(frozen=True, eq=False)
class Identified(Shown):
    """A scene with the parameters that were found.

    Attributes:
        scene: ready to be derived from, simulated and written.
        values: what was put in, by the name of the linear parameter or of the scene's own.
        physical: how the inertias were found; None where parameters with names were solved for.
        named: how those were found; None where inertias were.
        notes: what is written as what, one line each.
    """

    scene: Scene
    values: Mapping[str, float]
    physical: Physical | None
    named: Named | None
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        how = "values of parameters with names" if self.physical is None else "inertias that bodies can have"
        return f"<Identified {self.scene.name}: {how}>"


@checked(IdentifyError)
def identified(
    identification: Identification,
    total_mass: float | None = None,
    inside: Mapping[str, tuple[Sequence[float], Sequence[float]]] | None = None,
    spread: float = SPREAD,
) -> Identified:
    """Return the scene with identified parameters, which some mechanism can have.

    Args:
        identification: what `identify` returned.
        total_mass: of all bodies together, kg; None leaves it to the data. It and `inside` are of bodies that were
            declared by numbers: with parameters that have names they do nothing, which a note reports.
        inside: for bodies by name, an ellipsoid that holds all of their mass: centre and half axes along the body
            axes, m.
        spread: how far a body may be from the scene's own, in its own size, where data are weak.

    Raises:
        IdentifyError: clarabel is needed and not there, or no bodies have what is asked.
        SceneError: parameters of the geometry without a value; or parameters were found that bodies cannot have.
    """
    total_mass, spread = native(float, total_mass, spread)
    model, scene = identification.model, identification.model.scene
    declared = {parameter.name for parameter in identification.declared.parameters}
    added = [parameter.name for parameter in scene.parameters if parameter.name not in declared]
    if inertial_names(scene):
        named = fit_names(scene, model.names, *identifiable_combinations(identification), added)
        values = {name: float(x) for name, x in zip(named.names, named.values, strict=True)}
        notes = [*_named_notes(scene, named), *_gain_notes(identification)]
        if total_mass is not None or inside:
            asked = " and ".join(
                ["the total mass"] * (total_mass is not None) + ["ellipsoids of bodies"] * bool(inside)
            )
            notes.append(
                f"{asked}: of no effect, since masses are made of parameters with names; what is known of these is "
                f"bound ({argument('values', {'m1': 2})}), or masses are declared as numbers"
            )
        return Identified(with_parameters(scene, values), values, None, named, tuple(notes))
    known = unknowns(scene, added)
    combinations, estimate, covariance = identifiable_combinations(identification, model.base)
    rows = known.map[places_of(model.names[: model.base], known.base)]
    physical = nearest_physical(known, combinations @ rows, estimate, covariance, total_mass, inside, spread)
    changed = [k for k, name in enumerate(known.bodies) if name not in physical.kept]
    values = {known.names[k]: float(physical.values[k]) for k in _places(changed, len(known.bodies), len(known.names))}
    rated = zip(model.names, identification.after.tolist(), strict=False)
    values |= dict(list(rated)[model.base : len(model.names)])
    return Identified(
        with_parameters(scene, values),
        values,
        physical,
        None,
        (*_physical_notes(physical), *_gain_notes(identification)),
    )


def identifiable_combinations(identification: Identification, first: int | None = None) -> tuple[Array, Array, Array]:
    """Return C, e, Sigma: identifiable combinations of base parameters, shape (k, b), estimates, covariance.

    The base parameters are the `first` of `found.model.names`, None for all, in their order.
    """
    regression = identification.regression
    count = len(identification.model.names)
    assert regression.names[:count] == identification.model.names, "gains and payloads stand behind base parameters"
    count = count if first is None else first
    estimate, covariance = regression.estimate[:count], regression.covariance[:count, :count]
    if not len(regression.null_space):
        return np.eye(count), estimate, covariance
    _, sizes, Vt = np.linalg.svd(regression.null_space[:, :count])
    C = Vt[int(np.sum(sizes > NOTHING)) :] * regression.scale[:count]
    return C, C @ estimate, C @ covariance @ C.T


@checked(SceneError)
def with_parameters(scene: Scene, values: Mapping[str, float | str]) -> Scene:
    """Return the scene with other values of what its forces are linear in, or of its own parameters.

    A body of which one of the ten is given becomes mass, centre of mass and inertia about it, in numbers; the others
    stay as they are declared. Numbers have `DIGITS` digits, exactly.

    Args:
        scene: the mechanism.
        values: by name of a column of `regressor` (m2, mx2, ..., Iyz2, fv1, k1) or of a parameter; in SI, or text.

    Raises:
        SceneError: a name that is none of these, or a scene that cannot be, such as an inertia that no body has.
    """
    faults, letter = Faults(""), SceneUnits(scene).letter
    read = {name: read_number(x, {}, f"values: {name}", faults, letter(name)) or 0.0 for name, x in values.items()}
    faults.close()
    opened = with_force_parameters(scene)
    own = {parameter.name for parameter in scene.parameters}
    ten = [tuple(str(q.value) for q in (b.mass, *(b.first_moment or ()), *b.inertia)) for b in opened.bodies]
    made = {p.name: p.value for p in opened.parameters if p.name not in own and p.value is not None}
    known = {*own, *made, *(name for one in ten for name in one)}
    for name in read:
        if name not in known:
            raise SceneError(f"{scene.name}: {name} is no parameter of it; {choice(name, tuple(known))}")
    made |= {name: _like(_exact(read[name]), made[name]) for name in made if name in read}
    settled = opened.substituted(made)
    bodies = list(scene.bodies)
    if any(name in read for one in ten for name in one):
        declared = unknowns(scene)
        for k, names in enumerate(ten):
            if any(name in read for name in names):
                before = declared.values[TEN * k : TEN * (k + 1)]
                given = [float(read.get(name, x)) for name, x in zip(names, before, strict=True)]
                bodies[k] = body_of_ten(scene.bodies[k], given)
    changed = replace(
        scene,
        bodies=tuple(bodies),
        joints=settled.joints,
        elements=settled.elements,
        parameters=tuple(
            replace(p, value=_exact(read[p.name]), positive=p.positive and read[p.name] > 0) if p.name in read else p
            for p in scene.parameters
        ),
    )
    bind(changed, {})  # which checks all of it
    return changed


def body_of_ten(body: Body, ten: Sequence[float]) -> Body:
    """Return the body with mass, first moment and inertia about its frame, written about its centre of mass.

    Args:
        body: whose name and looks are kept.
        ten: m, mx, my, mz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the body frame; kg, kg m, kg m^2.
    """
    m, x, y, z, xx, yy, zz, xy, xz, yz = ten
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    h = np.array([x, y, z])
    if m == 0:
        told = tuple(_exact(e, scale) for e, scale in zip((*h, *_six(inertia)), (*[1.0] * 9,), strict=True))
        return Body(body.name, Quantity.number(0), None, told[:3], told[3:], "frame", (), True, body.shape)  # type: ignore[arg-type]
    centre = h / m
    reach = float(np.abs(centre).max())
    com = [_like(_exact(float(one), reach), *(body.com or ())) for one in centre]
    central = inertia - (h @ h * np.eye(3) - np.outer(h, h)) / m
    largest = float(np.abs(central).max())
    entries = possible([_exact(e, largest).value for e in _six(central)])  # type: ignore[misc]
    six = tuple(_like(Quantity.number(Fraction(e)), *body.inertia) for e in entries)
    return Body(body.name, _like(_exact(float(m)), body.mass), tuple(com), None, six, "com", (), False, body.shape)  # type: ignore[arg-type]


def _six(matrix: Array) -> tuple[float, ...]:
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return tuple(float(matrix[place]) for place in places)


def _like(quantity: Quantity, *declared: Quantity) -> Quantity:
    """Return a number that is to be written in the unit that one of the declared ones was written in."""
    return replace(quantity, unit=next((one.unit for one in declared if one.unit), ""))


def _exact(value: float, scale: float = 0.0) -> Quantity:
    """Return a number of `DIGITS` digits, zero beside what is much larger."""
    if abs(value) <= NOTHING * scale:
        return Quantity.number(0)
    return Quantity.number(Fraction(f"{value:.{DIGITS}g}"))


def _places(changed: Sequence[int], bodies: int, count: int) -> list[int]:
    return [TEN * k + i for k in changed for i in range(TEN)] + list(range(TEN * bodies, count))


# In words


def _named_notes(scene: Scene, named: Named) -> list[str]:
    known = [name for name, e in zip(named.names, named.errors, strict=True) if not np.isnan(e)]
    lost = [k for k, e in enumerate(named.errors) if np.isnan(e)]
    start = np.where(np.isnan(named.before), 1.0, named.before)
    kept = [named.names[k] for k in lost if named.values[k] == start[k]]
    tied = [named.names[k] for k in lost if named.values[k] != start[k]]
    notes = [f"{listed(known)}: values that give the estimates; formulas stay as they are"] if known else []
    if kept:
        notes.append(f"{listed(kept)}: not identifiable from these data, as before (1 where there was no value)")
    if tied:
        notes.append(
            f"{listed(tied)}: identifiable in combinations only; of all values that give the estimates, those nearest "
            "to the scene's (1 where there was no value)"
        )
    if named.fixed:
        notes.append(f"{listed(named.fixed)}: geometry or gravity, as before")
    used = set(inertial_names(scene))
    plain = [b.name for b in scene.bodies if not any(s in used for q in _of(b) for s in q.symbols) and any(_of(b))]
    if plain:
        notes.append(
            f"{listed(plain)}: of numbers among parameters with names, as declared; name them to identify them"
        )
    if named.spare > 0 and named.distance > 3 * np.sqrt(named.spare):
        notes.append(
            f"the estimates are {named.distance:.3g} standard errors from what these parameters can give: masses lie "
            "elsewhere than in the scene, or a force acts that it does not have"
        )
    return notes


def _of(body: Body) -> list[Quantity]:
    entries = (body.mass, *(body.com or ()), *(body.first_moment or ()), *body.inertia)
    return [q for q in (*entries, *(p.mass for p in body.particles)) if q.symbols or q.at({})]


def _gain_notes(identification: Identification) -> list[str]:
    known = [f"{g.drive} {g.value:.5g} ± {g.error:.2g} {g.unit}" for g in identification.gains if np.isfinite(g.error)]
    return [f"gains of drives, which a scene does not hold: {listed(known)}"] if known else []


def _physical_notes(physical: Physical) -> list[str]:
    count, notes = physical.identifiable, list[str]()
    moved = [name for name in physical.unknowns.bodies if name not in physical.kept]
    if moved:
        notes.append(
            f"{listed(moved)}: ten inertial parameters each, of which {count} combinations are identifiable; the rest "
            "is nearest to the scene's own"
        )
    if physical.kept:
        notes.append(f"{listed(physical.kept)}: not identifiable from any motion, as declared")
    if physical.projected and physical.distance > 0.1:
        notes.append(
            "the estimates themselves are not physically consistent; the nearest that are lie "
            f"{physical.distance:.3g} standard errors away, all {count} together, and miss "
            f"{100 * physical.missed:.2g} % of them"
        )
        if physical.distance > HARDLY and physical.missed < 1:
            notes.append("standard errors of a log with hardly any noise: a distance of many of them means little")
    if physical.at_limit:
        notes.append(
            f"{listed(physical.at_limit)}: at the edge of physical consistency: data are weak, or a model is wrong"
        )
    return notes
