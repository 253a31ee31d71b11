"""Where a simulation starts: what the scene and the user give, completed by loops and prescribed motions.

Of a start that is given for a closed mechanism, what can be chosen freely is kept, and the rest follows:

    N        basis of the velocities that the constraints allow, one a row; f of them
    k        one more coordinate or velocity can be given beside others if column k of N raises their rank

Further coordinates that are given say where the assembly begins: they choose among its branches. Given velocities
replace those of the scene, of which only those are kept that the given ones leave free.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np

from symdyn.algebra import Array, Floats, constants
from symdyn.dynamics.loops import Assembly, Numbers, free_motions
from symdyn.dynamics.mechanism import TIME, prescribed, quaternions
from symdyn.errors import DerivationError, SimulateError, suggestion
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Graph, evaluate, substitute
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.joints import start_of
from symdyn.scene.values import Faults, split_commas, velocity_name
from symdyn.simulation.equations.compiled_routines import opened
from symdyn.simulation.equations.monitors import values_on
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.prescribed.formulas_in_time import bound, number_of, parameter_values, read_formula, words

CONSISTENT, FAR = 1e-9, 1.0
"""By how much a start is moved without a note, rad, m and per s; and from where on it may be that of another place."""

TIP = "tip is the child's frame seen from the joint, child_origin the joint from it"

NOTHING = 1e-9
"""Singular values of columns of N that are zero."""

DRAWS = 20
"""Random values of coordinates that are not given, from which the loops may close with those that are."""


def closed_start(
    numbers: Numbers, q: Array, given: Sequence[int], moved: Sequence[int], drawn: bool = False
) -> tuple[Assembly, list[str]]:
    """Return a closed position next to q and what a user should know of it.

    The user gives some coordinates; velocities that are `moved` have a prescribed motion.

    Raises:
        SimulateError: a coordinate that could be chosen freely has a value that the loops do not reach.
        DerivationError: the loops do not close, or a wheel lies flat.
    """
    flat = numbers.lying_flat(q)
    if flat:  # the contact has no height to close there
        raise DerivationError(f"{numbers.scene.name}: {flat}")
    names, drives = list(numbers.scene.velocities), numbers.scene.drives
    rates = {k: velocity_name(numbers.scene.coordinates[k]) for k in given}
    places = {names.index(rate): k for k, rate in rates.items() if rate in names}
    order = sorted(places, key=lambda k: (not drives[k], k))
    kept, begin = order, q
    if not _closes(numbers, q, (*moved, *order)):
        kept = []
        for k in order:
            kept = [*kept, k] if _closes(numbers, q, (*moved, *kept, k)) else kept
        begin = numbers.newton(numbers.normalised(q), tuple({*moved, *order}))  # to what is given, not to the scene's
    held = sorted({*moved, *kept})
    assembly = numbers.closed_position(begin if held or any(q) else None, held or None)
    closed = np.array(assembly.q)
    lost = [k for k in order if k not in kept and abs(closed[places[k]] - q[places[k]]) > CONSISTENT]
    N = free_motions(numbers.dimensionless(closed, 1.0))
    for k in (one for one in lost if _rank(N, (*moved, *kept, one)) > _rank(N, (*moved, *kept))):
        tried = sorted({*moved, *kept, k})
        if not drawn and (elsewhere := numbers.closed_elsewhere(q, [*given], tried, DRAWS)) is not None:
            elsewhere[[*given]] = q[[*given]]
            return closed_start(numbers, elsewhere, given, moved, drawn=True)
        name = numbers.scene.coordinates[places[k]]
        raise SimulateError(
            f"start: the loops do not close with {name} = {q[places[k]]:.6g}; from there they close at {name} = "
            f"{closed[places[k]]:.6g}; give another value, or guesses of the other coordinates too"
        )
    return assembly, [*assembly.notes, *_guessed(numbers, closed, places, kept, lost)]


def _closes(numbers: Numbers, q: Array, held: Sequence[int]) -> bool:
    """Whether the loops close with some coordinates as they are, where equations of motion say something."""
    found = numbers.newton(numbers.normalised(q), tuple(sorted({*held})))
    return numbers.is_closed(found) and not (numbers.singular_angles(found) or numbers.lying_flat(found))


def _guessed(
    numbers: Numbers, closed: Array, places: dict[int, int], kept: Sequence[int], lost: Sequence[int]
) -> list[str]:
    if not lost:
        return []
    coordinates = numbers.scene.coordinates
    follow = ", ".join(f"{coordinates[places[k]]} = {closed[places[k]]:.9g}" for k in lost)
    from_kept = ", ".join(coordinates[places[k]] for k in kept)
    return [
        f"start: more coordinates are given than can be chosen freely; {from_kept or 'prescribed motions'} kept, "
        f"the others say where the assembly begins, and follow: {follow}"
    ]


def closed_rates(
    numbers: Numbers, q: Array, u: Array, given: Sequence[int], moved: Sequence[int]
) -> tuple[Array, list[str]]:
    """Return velocities that the rows allow at a closed position, and what a user should know of them.

    Of u, shape (nv,), those count that the scene declares, the user gives or a prescribed motion has.

    Raises:
        DerivationError: the given velocities contradict each other.
    """
    declared = [k for k in numbers.declared_rates() if k not in (*given, *moved)]
    held = [*moved, *given]
    if given:
        N = free_motions(numbers.dimensionless(q, 1.0))
        for k in declared:
            held = [*held, k] if _rank(N, (*held, k)) > _rank(N, held) else held
    else:
        held += declared
    found = numbers.fitting_rates(q, {k: float(u[k]) for k in sorted(held)})
    lost = [k for k in declared if abs(found[k] - u[k]) > CONSISTENT * max(1.0, abs(float(u[k])))]
    names = numbers.scene.velocities
    notes = [
        f"start rates: what is given leaves no choice of {names[k]}, {u[k]:.6g} in the scene; it is {found[k]:.9g}"
        for k in lost
    ]
    return found, notes


def _rank(N: Array, columns: Sequence[int]) -> int:
    chosen = N[:, sorted({*columns})]
    return int(np.linalg.matrix_rank(chosen, tol=NOTHING)) if chosen.size else 0


SINGULAR = 1e-14
"""Smallest eigenvalue of the mass matrix with unit diagonal that is not zero."""

NEAR = Fraction(1, 2**50)
"""What a number may be off beside its size and still be the double of its formula; else it was moved, and stays."""

NAMED = 6
"""Coordinates that a note names."""


@dataclass(frozen=True)
class Start:
    """A state to start from.

    Attributes:
        q: coordinates, shape (nq,).
        u: velocities, shape (nv,).
        s: states of one's own, shape (ns,); () where they start as the scene says.
        notes: what was changed so that loops close, one line each.
        formulas: what was said of q, u and s, parameters bound; () where they are numbers.
    """

    q: Array
    u: Array
    notes: tuple[str, ...] = ()
    formulas: tuple[Quantity, ...] = ()
    s: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def moving(self) -> Array:
        """Velocities, and then states of one's own, shape (nu,)."""
        return np.append(self.u, self.s)

    @classmethod
    def guess(cls, scene: Scene, start: Values | Start | None = None) -> Array:
        """Return coordinates as the scene and the user say, loops open or closed, shape (nq,).

        Raises:
            SimulateError: with every fault, one line each.
        """
        if isinstance(start, Start):
            return start.q
        faults = Faults("")
        _, at = apart(scene, by_name(start, "start", faults))
        q, *_ = _position(scene, at, parameter_values(scene), faults)
        faults.close(SimulateError)
        return opened(scene).numbers().normalised(q)


Values: TypeAlias = Mapping[str, Any] | str
"""Formulas or numbers by name, or as in a shell, "q1=0.3,q2=pi/2"."""


def read_start(
    scene: Scene,
    start: Values | Start | None = None,
    rates: Values | None = None,
    inputs: Mapping[str, Quantity] = MappingProxyType({}),
) -> Start:
    """Return the state at t = 0, consistent with loops and prescribed motions.

    Args:
        scene: the mechanism, its parameters bound.
        start: formulas in parameters by coordinate, or as "q1=0.3,q2=pi/2", in place of what the scene says, and by
            velocity; or a whole state, which stays.
        rates: likewise by velocity, or by coordinate where the velocity is its rate.
        inputs: what those are that prescribe motions, at t = 0, formulas in parameters and t.

    Raises:
        SimulateError: with every fault, one line each; also where angles are singular there, or a wheel lies flat.
    """
    if isinstance(start, Start):
        no_equations(opened(scene).numbers(), start.q)
        return start if len(start.s) == len(scene.states) else replace(start, s=read_start(scene).s)
    values = parameter_values(scene)
    faults = Faults("")
    moving, at = apart(scene, by_name(start, "start", faults))
    q, given_q, formulas, own = _position(scene, at, values, faults)
    u = np.array([number_of(x, values, "start_rates", faults) or 0.0 for x in start_of(scene).velocity])
    formulas += start_of(scene).velocity
    moved = scene.prescribed_velocities
    given_u: list[int] = []
    velocities, units = scene.velocities, SceneUnits(scene).letters
    for name, text in (*moving.items(), *by_name(rates, "start rates", faults).items()):
        named = velocity_name(name) if name not in velocities and velocity_name(name) in velocities else name
        k = _index(named, velocities, "start rates", faults, scene)
        if k in given_u:
            faults.add("start rates", f"{named} is given twice")
        formula, value = _value(scene, text, values, f"start rates: {name}", faults, units.get(named, ""))
        if k is not None and formula is not None and value is not None:
            u[k], formulas[len(q) + k] = value, formula
            given_u.append(k)
            if k in moved:
                faults.add("start rates", f"{name} has a prescribed motion, which says how it starts")
    numbers = opened(scene).numbers()
    _prescribe(scene, q, u, given_q, inputs, faults)
    names = list(scene.coordinates)
    parts = {", ".join(one): slice(names.index(one[0]), names.index(one[0]) + 4) for one in quaternions(scene)}
    for group, part in parts.items():
        if not np.linalg.norm(q[part]) > 0:
            faults.add("start", f"the quaternion ({group}) has length zero; (1, 0, 0, 0) is no rotation")
    faults.close(SimulateError)
    notes = [
        f"start: the quaternion ({group}) has length {np.linalg.norm(q[part]):.6g}; it was divided by that"
        for group, part in parts.items()
        if abs(np.linalg.norm(q[part]) - 1.0) > CONSISTENT
    ]
    notes += [
        f'start: {scene.coordinates[k]} = {q[k]:g} is in rad; write "{q[k]:g} deg" for degrees'
        for k in range(len(q))
        if units.get(scene.coordinates[k]) == "rad" and abs(q[k]) > 2 * np.pi and q[k] == np.rint(q[k])
        if not formulas[k].unit and isinstance(formulas[k].value, Fraction)
    ]
    q = numbers.normalised(q)
    if scene.is_constrained:
        q, u, more = _closed(numbers, q, u, given_q, given_u, faults)
        notes += more
        faults.close(SimulateError)
    no_equations(numbers, q)
    s = np.array([number_of(one, values, "start", faults) for one in own], dtype=np.float64)
    formulas += own
    return Start(q, u, tuple(notes), tuple(bound(one, values) for one in formulas), s)


def beyond_doubles(scene: Scene, start: Start, size: int) -> Array:
    """Return what the formulas of a start are beyond its doubles, shape (size,); zero where there are none.

    A third of a radian is no double, and a run with 31 digits starts there.

    Quaternions are brought to length one.
    """
    low, graph = np.zeros(size), Graph()
    numbers = [formula.express(graph) for formula in start.formulas]
    for group in quaternions(scene) if numbers else ():
        first = list(scene.coordinates).index(group[0])
        four = numbers[first : first + 4]
        length = graph.sqrt(graph.total(x * x for x in four))
        numbers[first : first + 4] = [x / length for x in four]
    known = constants(numbers)
    for k, (number, double) in enumerate(zip(numbers, (*start.q, *start.u, *start.s)[: len(numbers)], strict=True)):
        off = known[number] - Fraction(float(double))
        low[k] = float(off) if abs(off) <= NEAR * abs(known[number]) else 0.0
    return low


def _position(
    scene: Scene, start: Mapping[str, Any], values: Mapping[str, Quantity], faults: Faults
) -> tuple[Array, list[int], list[Quantity], list[Quantity]]:
    """Return coordinates at the start, which of them the user gives, and the formulas of all, and of states."""
    formulas, given = [*start_of(scene).position], list[int]()
    own, names = [one.value for one in scene.states], (*scene.coordinates, *(one.name for one in scene.states))
    q = np.array([number_of(x, values, "start", faults) or 0.0 for x in formulas])
    units = SceneUnits(scene).letters
    for name, text in start.items():
        k = _index(name, names, "start", faults, scene)
        formula, value = _value(scene, text, values, f"start: {name}", faults, units.get(name, ""))
        if k is None or formula is None or value is None:
            continue
        if k < len(q):
            q[k], formulas[k] = value, formula
            given.append(k)
        else:
            own[k - len(q)] = formula
    return q, given, formulas, own


def no_equations(numbers: Numbers, q: Array) -> None:
    """Refuse a start at which equations of motion say nothing.

    Raises:
        SimulateError: angles are singular there, or a wheel lies flat.
    """
    why = numbers.singular_angles(q) or numbers.lying_flat(q)
    if why:
        raise SimulateError(f"start: {why}")


def by_name(values: object, what: str, faults: Faults) -> Mapping[str, Any]:
    """Return formulas and numbers by name, none after a fault."""
    if isinstance(values, str):
        return words(split_commas(values), what, faults)
    if values is None or isinstance(values, Mapping):
        return values or {}
    if hasattr(values, "keys") and hasattr(values, "items"):  # a series of pandas
        return dict(values.items())
    faults.add(what, f"a {type(values).__name__} names nothing; give values by name, such as {{'q1': 0.3}}")
    return {}


def apart(scene: Scene, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what is given of velocities, and the rest, of a state that is given by name."""
    moving = {name: x for name, x in given.items() if name in scene.velocities and name not in scene.coordinates}
    return moving, {name: x for name, x in given.items() if name not in moving}


def _index(name: str, names: Sequence[str], where: str, faults: Faults, scene: Scene) -> int | None:
    if name in names:
        return list(names).index(name)
    faults.add(where, f"{name} is not known; {suggestion(name, names, scene)}")
    return None


def _value(
    scene: Scene, text: str, values: Mapping[str, Quantity], where: str, faults: Faults, unit: str
) -> tuple[Quantity | None, float | None]:
    formula = read_formula(text, values, where, faults, unit=unit, scene=scene)
    return formula, None if formula is None else number_of(formula, values, where, faults)


def _prescribe(
    scene: Scene, q: Array, u: Array, given: Sequence[int], inputs: Mapping[str, Quantity], faults: Faults
) -> None:
    graph = Graph()
    motion = prescribed(scene, graph)
    if not motion.place:
        return
    known = {graph.symbol(p.name): p.value.express(graph) for p in scene.parameters if p.value is not None}
    told = {one.name: one.value for one in scene.inputs} | dict(inputs)
    placed = {graph.symbol(name): one.express(graph) for name, one in told.items()}
    entries = substitute([*motion.position, *motion.velocity], placed)
    found = evaluate(substitute(entries, known | {graph.symbol(TIME): graph.zero}), Floats(), {})
    for i, k in enumerate(motion.place):
        name = scene.velocities[k].removesuffix("_dot")
        place = scene.coordinates.index(name)
        if place in given:
            faults.add("start", f"{name} has a prescribed motion, which says where it starts")
        q[place], u[k] = found[i], found[len(motion.place) + i]


def _closed(
    numbers: Numbers, q: Array, u: Array, given_q: Sequence[int], given_u: Sequence[int], faults: Faults
) -> tuple[Array, Array, list[str]]:
    """Return a state that closes the loops; what can be chosen and is given stays, the rest follows."""
    moved = list(numbers.scene.prescribed_velocities)
    try:
        assembly, notes = closed_start(numbers, q, given_q, moved)
    except (DerivationError, SimulateError) as fault:
        faults.add("start" if isinstance(fault, DerivationError) else "", str(fault))
        return q, u, []
    closed = np.array(assembly.q)
    ways = _ways(numbers.scene, q, closed)
    if ways and not any("follow: " in note for note in notes):
        far = np.abs(closed - q).max() > FAR and any(loop.tip.steps for loop in numbers.scene.loops)
        meant = f"; if that is not what was meant: {TIP}" if far else ""
        notes.append(f"{numbers.left_open(q)}; the start was moved so that the loops close, {ways}{meant}")
    try:
        u, more = closed_rates(numbers, closed, u, given_u, moved)
    except DerivationError as fault:
        faults.add("start rates", str(fault))
        return closed, u, notes
    return closed, u, [*notes, *more]


def _ways(scene: Scene, q: Array, closed: Array) -> str:
    """Return by how much coordinates were moved, and where to, the farthest first, "" if none was."""
    way = closed - q
    far = [int(k) for k in np.argsort(-np.abs(way), kind="stable") if abs(way[k]) > CONSISTENT]
    words = [f"{scene.coordinates[k]} by {abs(way[k]):.3g} to {closed[k]:.6g}" for k in far[:NAMED]]
    return ", ".join(words) + (f", and {len(far) - NAMED} more" if len(far) > NAMED else "")


def singular(system: StateEquations, x: Array) -> str:
    """Return which velocity moves no mass at a state, shape (nx,), "" if all but prescribed ones do; of a tree."""
    scene, graph, n = system.scene, system.mass[0].graph, system.nv
    free = np.setdiff1d(np.arange(n), scene.prescribed_velocities)
    known = zip((*scene.coordinates, *scene.first_order), x.tolist(), strict=False)  # work stands behind them
    values = values_on(graph, {**system.opened.values, **dict(known)})
    M = np.array(evaluate(system.mass, Floats(), values), dtype=np.float64).reshape(n, n)
    if not np.all(np.isfinite(M)):
        return "the mass matrix has no finite value at the start"
    M = M[np.ix_(free, free)]
    size = np.sqrt(np.abs(np.diag(M)))
    if np.any(size == 0):
        return f"{scene.velocities[free[size.argmin()]]} moves no mass at the start"
    eigenvalues, vectors = np.linalg.eigh(M / np.outer(size, size))
    if eigenvalues.min(initial=1) > SINGULAR:
        return ""
    velocity = scene.velocities[free[np.abs(vectors[:, 0]).argmax()]]
    return (
        f"the mass matrix is singular at the start, a motion with {velocity} moves no mass; "
        "give another start, or a mass or an inertia"
    )
