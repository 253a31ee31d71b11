"""The model that logs are compared with: driving forces of a scene as its base regressor times base parameters.

    beta = map · pi                 pi: ten of every body about its frame, armatures, friction, stiffness, ... (linear
                                    parameters); beta: base parameters, its identifiable combinations
    S · pi >= 0                     what no body or joint can have below zero: armature, damping, dry friction

The pseudo-inertia of a body is [[J, h], [h, m]], J = tr(I)/2 · 1 - I its second moments about the frame, h = m r.

Friction, armatures and offsets that the scene does not declare are added to it as parameters with the value zero: so
they are estimated like any other, and can be written back. Columns of a fit and unknowns of a file are matched by their
names, in any order.

Reference: Gautier and Khalil (1990); Wensing, Kim and Slotine (2018).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from functools import cache

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.arguments import argument
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.outputs import BaseColumns, Linear
from symdyn.errors import DerivationError, IdentifyError, SceneError, choice
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, evaluate, gradient, reachable, substitute
from symdyn.identification.filtered import Motion
from symdyn.identification.rate_rows import apart, rate_rows, width
from symdyn.rounding import in_digits
from symdyn.runtime import load
from symdyn.scene import INERTIAL, Quantity, Scene, SceneUnits, bind
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.scene.values import Joint, Parameter, force_unit, velocity_name
from symdyn.simulation.prescribed import drive_names

TEN = len(INERTIAL)


@dataclass(frozen=True)
class Unknowns:
    """The linear parameters of a scene, with their values there."""

    scene: Scene  # whose they are
    opened: Scene  # the same scene with these parameters as symbols; everything else as it was
    names: tuple[str, ...]  # of the parameters, as columns of `regressor`; ten a body, then what acts
    values: Array  # as the scene declares them, shape (p,); kg, kg m, kg m^2 and the units of what acts
    base: tuple[str, ...]  # names of the base parameters, as columns of `base_regressor`
    map: Array  # shape (b, p): base parameters are map · values
    signs: Array  # shape (s, p): signs · values is not negative in any real mechanism
    signed: tuple[str, ...]  # what each of these rows is, such as "damping of shoulder"

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, whose ten come first, in this order."""
        return tuple(body.name for body in self.scene.bodies)

    def ten(self, values: Array) -> Array:
        """Return the ten of every body out of values of all parameters, shape (bodies, 10)."""
        return np.asarray(values[: TEN * len(self.scene.bodies)].reshape(-1, TEN))

    def inertias(self, values: Array) -> list[tuple[float, Array, Array, Array]]:
        """Return mass, centre of mass, principal moments and spread of every body, as of `ten_of_body`."""
        return [ten_of_body(ten) for ten in self.ten(values)]


def unknowns(scene: Scene, unbound: Collection[str] = ()) -> Unknowns:
    """Return the linear parameters of a scene whose numbers are known.

    Args:
        scene: the mechanism.
        unbound: parameters that are unknowns although they are zero; what is zero drops out of a derivation else.

    Raises:
        SceneError: parameters without a value, on which masses, inertias or places depend.
    """
    free = [parameter.name for parameter in scene.free_parameters]
    if free:
        told = ", ".join(free)
        raise SceneError(f"{scene.source or scene.name}: {told}: without a value; give each one, such as {free[0]}=1")
    w = Workspace(without_values(scene, unbound))
    found, base = Linear.of(w), BaseColumns.of(w)
    there = found.workspace
    graph = there.graph
    columns = [graph.symbol(name) for name in found.columns]
    rows = [gradient(one, columns) for one in substitute(base.of_columns(), found.known)]
    signed, signs = _signs(there, columns)
    values = _numbers(found.declared, there, scene)
    return Unknowns(
        scene,
        there.scene,
        found.columns,
        np.array(values),
        base.names,
        np.array([_numbers(row, there, scene) for row in rows]).reshape(-1, len(columns)),
        np.array(signs).reshape(-1, len(columns)),
        signed,
    )


def without_values(scene: Scene, names: Collection[str]) -> Scene:
    """Return the scene with some parameters left open."""
    return replace(scene, parameters=tuple(replace(p, value=None) if p.name in names else p for p in scene.parameters))


def _signs(w: Workspace, columns: list[Expr]) -> tuple[tuple[str, ...], list[list[float]]]:
    """Return what is never negative, as rows that the parameters are multiplied by; what is not linear has none."""
    told, rows = list[str](), list[list[float]]()
    for what, quantity in never_negative(w.scene):
        slopes = gradient(quantity.express(w.graph), columns)
        if any(not slope.is_zero for slope in slopes) and not {*reachable(slopes)} & {*columns}:
            told.append(what)
            rows.append(_numbers(slopes, w))
    return tuple(told), rows


def never_negative(scene: Scene) -> list[tuple[str, Quantity]]:
    """Return what no joint can have below zero, each with its name: armature, damping, dry friction."""
    found = list[tuple[str, Quantity]]()
    for joint in scene.joints:
        found += [(f"armature of {joint.name}", joint.armature), (f"damping of {joint.name}", joint.damping)]
        if joint.dry is not None:
            known = {x.key: x.quantity for part in FORCES[joint.dry.kind].parts for x in part.numbers(joint.dry)}
            found += [(f"{key} friction of {joint.name}", known[key]) for key in ("coulomb", "static") if key in known]
    return found


def _numbers(entries: Sequence[Expr], w: Workspace, scene: Scene | None = None) -> list[float]:
    """Return the values of formulas, with the values that the scene has for its parameters."""
    known = {p.name: p.value for one in (w.scene, scene or w.scene) for p in one.parameters if p.value is not None}
    values = {
        w.graph.symbol(name): evaluate([value.express(w.graph)], Floats(), {})[0] for name, value in known.items()
    }
    return [float(x) for x in evaluate(list(entries), Floats(), values)]


def base_frames(scene: Scene) -> dict[str, tuple[str, str, str]]:
    """Return of frames in names of base parameters, such as "R1": body, joint, and the place in the body's frame."""
    w, found = Workspace(scene), dict[str, tuple[str, str, str]]()
    joints = [joint.name for joint in scene.joints for _ in joint_motion(joint, w.graph).joints]
    homes = {k: (name, place.inverse()) for name, (k, place) in reversed(w.tree.home.items())}
    for k, (joint, moved) in enumerate(zip(joints, w.whole.moved[1:], strict=True), 1):
        body, back = homes.get(k, ("", None))  # between axes of one joint there is no body
        T = back @ moved if back else moved
        said, (x, _, z) = list[str](), T.R.T
        for what, three, usual in ("origin", T.p, [0, 0, 0]), ("x along", x, [1, 0, 0]), ("z along", z, [0, 0, 1]):
            if (numbers := [round(one, 9) + 0.0 for one in _numbers(three, w)]) != usual:
                said.append(f"{what} ({', '.join(in_digits(one, 6) for one in numbers)})")
        found[f"R{k}"] = body, joint, ", ".join(said) or "the body's own"
    return found


def ten_of_body(ten: Array) -> tuple[float, Array, Array, Array]:
    """Return mass, kg, centre of mass, m, principal moments about it, kg m^2, and the spread of its mass, m^2.

    Args:
        ten: m, m r, I about the body frame, shape (10,).

    Returns:
        The spread is the covariance of places of mass, shape (3, 3); where there is no mass, what is over it is NaN.
    """
    m, xx, yy, zz, xy, xz, yz = (float(ten[k]) for k in (0, 4, 5, 6, 7, 8, 9))
    h = np.asarray(ten[1:4], dtype=float)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if m == 0:
        none = np.full((3, 3), np.nan)
        return m, none[0], np.linalg.eigvalsh(inertia), none
    central = inertia - (h @ h * np.eye(3) - np.outer(h, h)) / m
    spread = (np.trace(central) / 2 * np.eye(3) - central) / m
    return m, h / m, np.linalg.eigvalsh(central), spread


@dataclass(frozen=True)
class LinearModel:
    """Driving forces that are linear in what is not known.

    Attributes:
        scene: with a parameter for each term of friction that it did not have.
        names: of the base parameters, and then of those that rates of states alone know, shape (p,).
        base: how many of them are base parameters.
        prior: their values in the scene, shape (p,); NaN where it has no number.
        drives, units: of the rows: driving forces, and behind them rates of states, shape (r,).
        rows: indices of those whose equation depends on parameters, shape (m,).
        jumps: indices of the velocities at whose standstill a force jumps.
        regressor: (q, qd, qdd) of shapes (N, nq), (N, nv), (N, nv) to Y, shape (N, r, p); behind q is what `rate_rows`
            says.
        ten: the same arguments to the columns of the ten parameters of every body, shape (N, r, 10 bodies); compiled
            when it is called.
        beside: the motion of a log with what stands for driving forces in rows of states.
    """

    scene: Scene
    names: tuple[str, ...]
    base: int
    prior: Array
    drives: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[int, ...]
    jumps: tuple[int, ...]
    regressor: Callable[[Array, Array, Array], Array]
    ten: Callable[[Array, Array, Array], Array]
    beside: Callable[[Motion], Motion]

    @property
    def driven(self) -> tuple[int, ...]:
        """Indices of the rows that are those of a drive."""
        return tuple(j for j in self.rows if j < len(self.scene.drives) and self.scene.drives[j])


@dataclass(frozen=True)
class Term:
    """One law of the force of a drive that a scene may lack."""

    symbol: str  # of its parameter; the number of the joint follows
    unit: tuple[str, str]  # of the parameter, at a joint that turns, and at one that slides
    text: str  # for tables
    lacks: Callable[[Joint], bool]  # whether a joint has none of its own
    given: Callable[[Joint, Quantity], Joint]  # the joint with it, from the joint and a symbol


def _rubbed(joint: Joint, coulomb: Quantity) -> Joint:
    return replace(joint, dry=FORCES["friction"].noun(joint.name, coulomb))


def _pushed(joint: Joint, offset: Quantity) -> Joint:
    own = joint.forces or (Quantity.ZERO,)
    return replace(joint, forces=(own[0] + -offset, *own[1:]))


FORCE = (force_unit("rad"), force_unit("m"))
"""Units of a generalized force: of a joint that turns, and of one that slides."""

TERMS: dict[str, Term] = {
    "viscous": Term(
        "fv",
        ("N m s/rad", "N s/m"),
        "viscous friction of {}",
        lambda joint: joint.damping == Quantity.ZERO,
        lambda joint, x: replace(joint, damping=x),
    ),
    "coulomb": Term("fc", FORCE, "dry friction of {}", lambda joint: joint.dry is None, _rubbed),
    "offset": Term("f0", FORCE, "offset of the drive of {}", lambda joint: True, _pushed),
    "armature": Term(
        "Ia",
        ("kg m^2", "kg"),
        "rotor inertia at {}",
        lambda joint: joint.armature == Quantity.ZERO,
        lambda joint, x: replace(joint, armature=x),
    ),
}
"""What `identify` may add to every joint with one drive, by its name in `--friction`."""


def with_terms(scene: Scene, terms: Sequence[str]) -> Scene:
    """Return the scene with a parameter of value zero for every term that a driven joint lacks.

    Raises:
        IdentifyError: there is no such term.
    """
    for name in terms:
        if name not in TERMS:
            raise IdentifyError(f"friction: there is no term {name}; {choice(name, tuple(TERMS))}")
    taken = {parameter.name for parameter in scene.parameters} | scene.moving_names
    joints, added = list[Joint](), list[Parameter]()
    for k, joint in enumerate(scene.joints, start=1):
        one = joint
        if len(joint.drives) == 1 and joint.drives[0] is not None and joint.motion is None:
            slides = JOINTS[joint.type].slides(joint)
            for term in (TERMS[name] for name in terms):
                if term.lacks(joint):
                    name = f"{term.symbol}{k}"
                    while name in taken:
                        name += "_b"
                    taken.add(name)
                    text = term.text.format(joint.name)
                    added.append(Parameter(name, Quantity.number(0), unit=term.unit[slides], text=text))
                    one = term.given(one, Quantity.symbol(name))
        joints.append(one)
    return replace(scene, joints=tuple(joints), parameters=(*scene.parameters, *added)) if added else scene


def linear_model(scene: Scene, terms: Sequence[str] = ()) -> LinearModel:
    """Return the base regressor of a scene, compiled, and what its columns stand for.

    Args:
        scene: the mechanism; parameters that only inertias are made of need no values.
        terms: of `TERMS`, those that joints lack are added.

    Raises:
        IdentifyError: a parameter of the geometry has no value, the scene has neither drives nor states, inputs with
            rates, states that jump, or parts of its forces that no parameter stands for.
        DerivationError: the scene has no driving forces.
    """
    _check(scene)
    declared = {parameter.name for parameter in scene.parameters}
    augmented = with_terms(scene, terms)
    # what is zero drops out of a derivation: open, it stays
    opened = [p if p.name in declared else replace(p, value=None) for p in augmented.parameters]
    scene = replace(augmented, parameters=tuple(opened))
    told = BaseColumns.of(Workspace(scene)).named()
    if not told:
        raise IdentifyError(f"{scene.name}: its driving forces depend on no parameter")
    w = Workspace(scene)
    try:
        entries = derive_one(w, "base_regressor").entries
        left = Linear.of(w).remainder()
    except DerivationError as error:
        raise IdentifyError(f"{scene.name}: {error}") from None
    if not all(one.is_zero for one in left):
        raise IdentifyError(
            f"{scene.name}: a part of its driving forces depends on no linear parameter, such as a spring whose "
            f"stiffness and free length are both parameters; give the free length by {argument('values')}"
        )
    met = {str(node.value) for node in reachable(list(entries))}
    free = {parameter.name for parameter in scene.free_parameters}
    lacking = [p.name for p in scene.parameters if p.name in free & met]
    if lacking:
        raise IdentifyError(
            f"{scene.name}: {', '.join(lacking)} {'has' if len(lacking) == 1 else 'have'} no value, and it is geometry "
            f"or gravity, which is not identified; give it, as in {argument('values', dict.fromkeys(lacking, 1))}"
        )
    own = rate_rows(w, *_seen(w, told, entries))
    more = [(name, value) for name, value in zip(own.names, own.values, strict=True) if name not in dict(told)]
    known = {p.name: float(p.value.at({}) or 0) for p in augmented.parameters if p.value is not None}
    prior = np.array([np.nan if value is None else _number(value, known) for _, value in (*told, *more)])
    names = [name for name, _ in (*told, *more)]
    bound = bind(scene, dict.fromkeys(free, 1)) if free else scene
    call = load(bound, ["base_regressor"]).base_regressor
    places, n, extra = [names.index(name) for name in own.names], len(scene.velocities), len(scene.states)

    def forces(of: Callable[..., Array], q: Array, qd: Array, qdd: Array, columns: int) -> Array:
        at = apart(scene, q) | {"qd": qd, "qdd": qdd}
        found = np.zeros((len(q), n + extra, columns))
        told = np.asarray(of(*(at[one.name] for one in of.operands)), dtype=np.float64)  # type: ignore[attr-defined]
        found[:, :n] = np.pad(told, ((0, 0), (0, 0), (0, max(0, columns - told.shape[2]))))[..., :columns]
        return found

    def regressor(q: Array, qd: Array, qdd: Array) -> Array:
        found = forces(call, q, qd, qdd, len(names))
        if extra:
            found[:, n:, places] = own.slopes(apart(scene, q) | {"qd": qd})
        return found

    @cache
    def every() -> Callable[..., Array]:
        return load(bound, ["regressor"]).regressor

    def ten(q: Array, qd: Array, qdd: Array) -> Array:
        return forces(every(), q, qd, qdd, TEN * len(bound.bodies))

    def beside(motion: Motion) -> Motion:
        if not extra:
            return motion
        return replace(motion, tau=np.hstack([motion.tau, own.known(apart(scene, motion.q) | {"qd": motion.qd})]))

    rng = np.random.default_rng(1)
    q, qd, qdd = (rng.uniform(-1, 1, (8, count)) for count in (width(scene), n, n))
    said = np.abs(np.nan_to_num(regressor(q, qd, qdd))).max(axis=(0, 2))
    rows = tuple(int(k) for k in np.flatnonzero(said > 0))
    drives = (*drive_names(scene), *(f"rate of {one.name}" for one in scene.states))
    units = (*(scene.shown_unit(force_unit(unit)) for unit in SceneUnits(scene).velocities), *own.units)
    return LinearModel(
        augmented, tuple(names), len(told), prior, drives, units, rows, _jumps(scene), regressor, ten, beside
    )


def _seen(w: Workspace, told: Sequence[tuple[str, Expr]], entries: Sequence[Expr]) -> tuple[list[str], list[str]]:
    """Return parameters that are columns of driving forces, and those that these know of otherwise.

    Raises:
        IdentifyError: one that rates know too is a column together with others.
    """
    columns = [name for name, _ in told]
    together = {part: name for name in columns for part in name.split(" + ") if part != name}
    rated = {str(node.value) for node in reachable(w.state_rates) if node.op is Op.SYMBOL}
    if mixed := [name for name in together if name in rated]:
        raise IdentifyError(
            f"{w.scene.name}: {', '.join(mixed)}: forces know it in {together[mixed[0]]} alone, and the rate of a "
            "state by itself; make it a number, or leave the others out"
        )
    return columns, [str(node.value) for node in reachable(list(entries)) if node.op is Op.SYMBOL]


def _number(value: object, known: dict[str, float]) -> float:
    """Return the value of a formula, NaN where a parameter has none."""
    names = {str(node.value): node for node in reachable([value]) if str(node.value) in known}  # type: ignore[list-item]
    try:
        return float(evaluate([value], Floats(), {node: known[name] for name, node in names.items()})[0])  # type: ignore[list-item]
    except (KeyError, ArithmeticError, ValueError, TypeError):
        return float("nan")


def _jumps(scene: Scene) -> tuple[int, ...]:
    """Return the velocities of joints whose dry friction has an ideal sign, or nearly one."""
    rates = {name: k for k, name in enumerate(scene.velocities)}
    dry = {velocity_name(name) for joint in scene.joints if joint.dry is not None for name in joint.coordinates}
    return tuple(k for name, k in rates.items() if name in dry)


def _check(scene: Scene) -> None:
    if not (any(scene.drives) or scene.states):
        raise IdentifyError(
            f'{scene.name}: no joint has a drive, so no force is measured; name one, as in drive = "tau1", or fit '
            f"motions alone, by output error: {argument('by', 'output-error', 'symdyn.identification.output_error')}"
        )
    if rated := [one.name for one in scene.inputs if one.rates]:
        told = "inputs with rates are not identified with; bind numbers in place"
        raise IdentifyError(f"{scene.name}: {', '.join(rated)}: {told}")
    if jumping := [one.name for one in scene.states if one.reset is not None]:
        told = "states that jump are not identified with; take the resets out, and give logs between jumps"
        raise IdentifyError(f"{scene.name}: {', '.join(jumping)}: {told}")
    scene.refuse_contacts("identification", IdentifyError)


def places_of(requested: Sequence[str], there: Sequence[str]) -> list[int]:
    """Return where each wanted name stands among those that are there, shape (len(wanted),); both have the same names.

    >>> places_of(["fv1", "fc1"], ["fc1", "fv1"])
    [1, 0]
    """
    assert Counter(requested) == Counter(there), f"two lists of one thing part: {[*requested]} and {[*there]}"
    place = {name: k for k, name in enumerate(there)}
    assert len(place) == len(there), f"a name stands twice: {[*there]}"
    return [place[name] for name in requested]
