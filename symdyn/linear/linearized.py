"""The functions that linearise a scene: at a point, at all positions of rest, along a run, and over values of a name.

Whether all positions of rest are known is counted exactly where the equations are polynomials over the rationals:

    I        ideal of the forces at rest, in sines s and cosines c of angles, s² + c² = 1, and in slides
    D        dimension of ℚ[s, c, x]/I: finite where positions of rest are isolated, complex ones too
    T        trace form, T_ij = tr(multiplication by b_i b_j), b a basis of monomials

The signature of T is the number of different real solutions, each a position, angles to whole turns. If as many were
found, there are no others. Nothing is rounded: numbers are fractions, and signs are those of exact coefficients, by
Descartes' rule, which counts exactly where all roots are real, as those of a symmetric matrix are.

Over values of a parameter, or of a symbol that positions, rates or forces name, equations are derived once, with
parameters free; only a value that changes their form, as zero does, derives again. Where a value moves the place of
rest, or of a steady motion, it is followed from the last one. That A is the same at two times of a steady motion is
looked at for the first value; at the others, that velocities stay and that the same positions are cyclic. Where axes do
not spin with a body it is looked at for every value, as their spin is another.

Reference: Cox, Little and O'Shea, Using Algebraic Geometry (2005), chapter 2, section 5 (Hermite, Pedersen, Roy).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise, product
from types import MappingProxyType
from typing import Any, Unpack

import numpy as np
from flint import fmpq, fmpq_mat

from symdyn.algebra import Array, TrigonometricRing
from symdyn.arguments import SympyExpression, argument, checked, native, suggesting, with_fields
from symdyn.errors import DerivationError, LinearizeError, SimulateError
from symdyn.graph import Expr, evaluate, substitute
from symdyn.linear.contact_mode import read_mode
from symdyn.linear.equilibrium import Equilibria, Equilibrium, equilibria
from symdyn.linear.evolution import STILL
from symdyn.linear.linearization import Linearization
from symdyn.linear.locus import RootLocus, number, read_values, root_locus
from symdyn.linear.modes import untouched
from symdyn.linear.prepared import Prepared, prepared
from symdyn.linear.search import nearest
from symdyn.linear.steady import BALANCED, settled, steady_next_to
from symdyn.rounding import in_digits
from symdyn.scene import Quantity, Scene, SceneLike, SceneUnits, scene_of, with_values
from symdyn.scene.values import FormulaError, Parameter, formula_text
from symdyn.simulation import Forces, Problem, Trajectory, opened
from symdyn.simulation.prescribed import Entries

CIRCLE = ("sin", "cos")

MOST_UNKNOWNS, MOST_SOLUTIONS = 4, 32
"""Sines, cosines and slides, and complex solutions, that are few."""


def complete(equilibria: Equilibria) -> bool:
    """Tell whether it is proved that a tree has no positions of rest but those found; False where nothing is proved."""
    prepared = equilibria.prepared
    if prepared.scene.is_constrained or prepared.functions.multipliers or prepared.scene.given or equilibria.singular:
        return False
    if prepared.forces.tables or any(place.family for place in equilibria.places):
        return False
    equations = _equations(prepared)
    return equations is not None and _real_solutions(*equations) == len(equilibria.places)


def _equations(prepared: Prepared) -> tuple[list[dict[tuple[int, ...], Fraction]], int] | None:
    """Return polynomials that vanish at rest, coefficients by exponents, and how many unknowns; None if not."""
    w = prepared.functions.w
    values: dict[Expr, Expr] = {}
    for parameter in prepared.scene.parameters:
        if parameter.value is not None:
            values[w.graph.symbol(parameter.name)] = parameter.value.express(w.graph)
    values |= dict.fromkeys([*w.state.tau, *w.state.qd], w.graph.zero)
    try:
        forces = substitute(substitute(list(prepared.functions.statics.parts["f"][1]), values), values)
        forces = [one for one in forces if not one.is_zero]
        ring = TrigonometricRing(forces)
        polynomials = evaluate(forces, ring, ring.values(forces))
    except (DerivationError, FormulaError, ZeroDivisionError):
        return None
    named = {k for p in polynomials for powers in p.monoms() for k, power in enumerate(powers) if power}
    turning = {one.node for k, one in enumerate(ring.generators) if k in named and one.kind in CIRCLE}
    kept = [k for k, one in enumerate(ring.generators) if k in named or (one.kind in CIRCLE and one.node in turning)]
    generators = [ring.generators[k] for k in kept]
    units = dict(zip(w.state.q, SceneUnits(prepared.scene).coordinates, strict=True))
    for one in generators:
        wanted = "rad" if one.kind in CIRCLE and one.unit == 1 else "m" if one.kind == "symbol" else None
        if one.node is None or wanted is None or units.get(one.node) != wanted:
            return None
    n = len(generators)
    if not 0 < n <= MOST_UNKNOWNS:
        return None
    equations = [
        {tuple(int(powers[k]) for k in kept): Fraction(int(c.p), int(c.q)) for powers, c in p.terms()}
        for p in polynomials
    ]
    places = {(one.kind, one.node): k for k, one in enumerate(generators)}
    for q in w.state.q:
        if q in turning:
            squares = (tuple(2 * (j == places[kind, q]) for j in range(n)) for kind in CIRCLE)
            equations.append(dict.fromkeys(squares, Fraction(1)) | {(0,) * n: Fraction(-1)})
    return equations, n


def _real_solutions(equations: Sequence[dict[tuple[int, ...], Fraction]], n: int) -> int:
    """Return the number of different real solutions, -1 where there are infinitely many complex ones, or too many."""
    from sympy import QQ, Poly, groebner, symbols

    unknowns = symbols(f"z:{n}")
    polynomials = [Poly({powers: QQ(c.numerator, c.denominator) for powers, c in one.items()}, *unknowns, domain=QQ)
                   for one in equations]  # fmt: skip
    basis = groebner(polynomials, *unknowns, order="grevlex", domain=QQ)
    if basis.exprs == [1]:
        return 0
    if not basis.is_zero_dimensional:
        return -1
    leading = [one.monoms(order="grevlex")[0] for one in basis.polys]
    highest = [min(m[k] for m in leading if sum(m) == m[k] and m[k]) for k in range(n)]
    standard = [m for m in product(*(range(top) for top in highest))
                if not any(all(a >= b for a, b in zip(m, one, strict=True)) for one in leading)]  # fmt: skip
    if len(standard) > MOST_SOLUTIONS:
        return -1
    place = {m: k for k, m in enumerate(standard)}
    reduced: dict[tuple[int, ...], dict[int, Any]] = {}

    def coordinates(monomial: tuple[int, ...]) -> dict[int, Any]:
        if monomial not in reduced:
            rest = basis.reduce(Poly({monomial: QQ(1)}, *unknowns, domain=QQ))[1]
            terms = Poly(rest, *unknowns, domain=QQ).terms() if rest != 0 else []
            reduced[monomial] = {place[m]: c for m, c in terms}
        return reduced[monomial]

    def trace(monomial: tuple[int, ...]) -> Any:
        shifted = (coordinates(tuple(a + b for a, b in zip(monomial, m, strict=True))) for m in standard)
        return sum((row.get(k, 0) for k, row in enumerate(shifted)), start=0)

    entries = []
    for one in standard:
        for other in standard:
            value = trace(tuple(a + b for a, b in zip(one, other, strict=True)))
            entries.append(fmpq(int(value.p), int(value.q)) if value != 0 else fmpq(0))
    polynomial = fmpq_mat(len(standard), len(standard), entries).charpoly()
    signs = [c for c in (polynomial[k] for k in range(len(standard) + 1)) if c != 0]
    turned = [c * (-1) ** k for k, c in enumerate(polynomial[k] for k in range(len(standard) + 1)) if c != 0]
    return _changes(signs) - _changes(turned)


def _changes(signs: Sequence[Any]) -> int:
    return sum((a > 0) != (b > 0) for a, b in pairwise(signs))


@with_fields(Problem)
def linearize(
    scene: SceneLike | Problem,
    *,
    outputs: str | Sequence[str | SympyExpression] = (),
    independent: str | Sequence[str] = (),
    t: float = 0.0,
    anywhere: bool = False,
    mode: Mapping[str, str] | None = None,
    **fields: Unpack[Problem.Fields],
) -> Linearization:
    """Return the linear motion of a mechanism about a point, to first order.

    >>> import symdyn
    >>> system = symdyn.linearize(symdyn.example("cart_pole"))
    >>> system
    <Linearization of cart_pole at rest:
        4 states: x, theta, x_dot, theta_dot
        1 inputs: F
        2 outputs: x, theta>
    >>> system.A.shape, system.B.shape
    ((4, 4), (4, 1))

    Args:
        scene: the mechanism, its parameters bound; or a `Problem`. Its start is the point, and deviations from its
            forces are the inputs of the system.
        **fields: of `Problem`.
        outputs: formulas in coordinates, velocities, point_tip_x, reaction_hinge_fx, ... as "x,theta" or one by one;
            nothing takes the outputs of the scene, or else all coordinates.
        independent: coordinates that determine the others where loops close; nothing takes the best conditioned.
        t: time, s, of what depends on it.
        anywhere: take points too that are neither of rest nor of a steady motion.
        mode: what contacts, stops and dry friction do there, by name: open (those not named are),
            closed (without friction), stick, slip+ or slip-. A and B are those of the motion that they leave.

    Raises:
        LinearizeError: there is no one linear motion there, or no equilibrium and no steady motion.
        SimulateError: with every fault of the arguments, one line each.
        DerivationError: loops cannot be closed, or friction is ideal.
    """
    (problem, _), (t,) = Problem.requested(linearize, locals()), native(float, t)
    if not math.isfinite(t):
        raise SimulateError(f"t = {t}: give a finite time, s")
    asked = prepared(problem, outputs, independent, read_mode(problem.scene, mode or {}))
    start = problem.initial
    return settled(asked, asked.at(start.q, start.moving, t, start.notes), anywhere)


@suggesting
def linearize_at_rest(
    scene: SceneLike | Problem,
    *,
    forces: Forces | Entries = (),
    outputs: str | Sequence[str | SympyExpression] = (),
    independent: str | Sequence[str] = (),
    values: Mapping[str, object] | None = None,
) -> tuple[tuple[Linearization, ...], Equilibria]:
    """Return the systems at all positions of rest that seeded starts lead to, and how these were found.

    Arguments and errors as of `linearize`.
    """
    problem = Problem.requested(linearize_at_rest, locals())[0].refused("rest is looked for", "start", "start_rates")
    found = equilibria(prepared(problem, outputs, independent))
    return found.systems, found


@suggesting
def linearize_along(
    scene: SceneLike | Problem,
    run: Trajectory,
    *,
    forces: Forces | Entries = (),
    outputs: str | Sequence[str | SympyExpression] = (),
    independent: str | Sequence[str] = (),
) -> tuple[Linearization, ...]:
    """Return the systems along a run, one a sample, whose driving forces are inputs that stay at what they are there.

    Independent positions and velocities are those of the first sample.
    Arguments and errors as of `linearize`; where `forces` give a drive a formula, that feeds back.
    """
    problem = Problem.requested(linearize_along, locals())[0].refused("points are a run's", "start", "start_rates")
    return along(prepared(problem, outputs, independent), run)


def along(requested: Prepared, run: Trajectory) -> tuple[Linearization, ...]:
    """Return the systems along a run; see `linearize_along`."""
    fed, n = [*requested.forces.formulas, *requested.functions.w.prescribed.place], len(requested.scene.velocities)
    usual = [
        0.0 if k in requested.forces.outside else float(one.value.at({}) or 0)
        for k, one in enumerate(requested.scene.inputs, n)
    ]
    found: list[Linearization] = []
    moving = np.hstack([run.qd, run.own_states])
    for t, q, u, tau, inputs in zip(run.t, run.q, moving, run.tau, run.inputs, strict=True):
        given = np.concatenate([tau, inputs - usual])
        given[fed] = 0.0
        like = found[0] if found else None
        found.append(replace(requested.at(q, u, float(t), given=given, like=like), kind="moving"))
    return tuple(found)


def rests(
    scene: Scene, values: Mapping[str, float] = MappingProxyType({}), start: Array | None = None, t: float = 0.0
) -> Equilibria:
    """Return where a mechanism rests without drives, what is next to each place, and how they were found.

    Unlike `linearize_at_rest` it takes places at which a motion moves no mass, or coordinates are singular.

    Args:
        scene: the mechanism.
        values: of parameters that have none in the scene, SI; whether bodies can have them is not looked at.
        start: coordinates on which nothing depends stay as here, shape (nq,), in place of as the scene starts.
        t: time, s, of what depends on it.

    Raises:
        LinearizeError, SimulateError, DerivationError: as of `linearize`.
    """
    given = {name: Quantity.number(Fraction(value)) for name, value in values.items()}
    parameters = tuple(p if p.value is not None else replace(p, value=given.get(p.name)) for p in scene.parameters)
    return equilibria(prepared(Problem(replace(scene, parameters=parameters))), t, start=start)


MOST = 6
"""Places without a linear motion that are told one by one."""


def search_report(places: Equilibria) -> list[str]:
    """Return what is said of how positions of rest were found."""
    count, others = len(places.places), [*places.crossings, *places.locked]
    starts = f"from {places.starts} seeded starts of Newton's method"
    if count:
        sure = complete(places)
        there = "these are all: the equations are polynomials, solved exactly" if sure else "there may be more"
        lines = [f"{count} position{'s' * (count > 1)} of rest found {starts}; {there}"]
    elif others:
        lines = [
            f"{len(others)} position{'s' * (len(others) > 1)} of rest found {starts}, none with one linear motion next "
            "to it; there may be more"
        ]
    else:
        lines = [f"no position of rest was found {starts}"]
    if count and places.idle:
        many = len(places.idle) > 1
        lines.append(
            f"{', '.join(places.idle)} may have any value{'s' * many}: no force depends on {'them' if many else 'it'}"
        )
    if places.singular:
        lines.append(
            f"{places.singular} of them led to where angles are singular, a wheel lies flat or loops lose rank and "
            "balance nothing, which are no equilibria"
        )
    for some, where in ((places.crossings, "branches of loops meet"), (places.locked, "coordinates are singular")):
        lines += [_unmoved(places, place, where) for place in some[:MOST]]
        if len(some) > MOST:
            lines.append(f"and at {len(some) - MOST} places more where {where}")
    if unseeded := sum(not place.starts for place in (*places.places, *others)):
        lines.append(
            f"to {unseeded} of these positions no seed led: they are exact, or a force changes its sign next to them"
        )
    if any(place.family for place in places.places):
        lines.append("where equilibria are not isolated, one of each family is told")
    if places.more:
        lines.append(f"{places.more} of the starts led to further such places, which differ from these")
    return lines


def _unmoved(places: Equilibria, place: Equilibrium, where: str) -> str:
    """Return what is said of a place where it rests and has no linear motion."""
    scene = places.prepared.scene
    units = SceneUnits(scene).coordinates
    values = [
        f"{name} = {scene.in_shown_unit(in_digits(float(x) + 0.0, 6), '' if unit == '1' else unit)}"
        for name, x, unit in zip(scene.coordinates, place.q, units, strict=True)
        if name not in places.idle
    ]
    times = f" ({place.starts} start{'s' * (place.starts > 1)})" if place.starts else ""
    return f"it rests at {', '.join(values)}{times}, where {where}: it has no one linear motion there"


@checked(LinearizeError)
def systems(
    problem: Problem | SceneLike, name: str, independent: str | Sequence[str] = (), anywhere: bool = False
) -> Callable[[float | str], Linearization]:
    """Return the system at a value of a name; forces are texts or formulas by name, else as of `linearize`.

    Raises:
        LinearizeError: the name is no parameter, and no formula has it; of the function, what a bare value may mean.
    """
    problem = problem if isinstance(problem, Problem) else Problem(scene_of(problem))
    found, letter = _systems(problem, name, independent, anywhere), SceneUnits(problem.scene).letter(name)
    return lambda value: found(number(value, argument("over"), letter))


def _systems(
    problem: Problem, name: str, independent: str | Sequence[str], anywhere: bool
) -> Callable[[float], Linearization]:
    scene, forces = problem.scene, problem.forces
    parts = (*problem.by_name, forces if isinstance(forces, Mapping) else {"forces": forces})
    formulas = [formula_text(one) for part in parts for one in part.values()]
    inputs, over = (one.name for one in scene.inputs), argument("over")
    if name in {*scene.coordinates, *scene.first_order, *filter(None, scene.drives), *inputs, "t"}:
        raise LinearizeError(f"{over}: {name} moves; a range is of a parameter, or of a symbol that formulas name")
    if name not in [one.name for one in scene.parameters]:
        if told := scene.derived_words(name):
            raise LinearizeError(f"{over}: {told}")
        if not any(re.search(rf"\b{re.escape(name)}\b", text) for text in formulas):
            there = ", ".join(one.name for one in scene.parameters) or "none"
            raise LinearizeError(
                f"{over}: {name} is no parameter (they are: {there}) and in no formula; say what it "
                f"does, as in {argument('start_rates', {scene.velocities[0]: name})}"
            )
        scene = replace(scene, parameters=(*scene.parameters, Parameter(name)))
    derived: dict[Scene, Prepared] = {}
    known: dict[tuple[Scene, bool], tuple[Linearization, Linearization]] = {}
    last: list[Array] = []

    def system(value: float) -> Linearization:
        bound = with_values(scene, {name: value})
        form = opened(bound).scene
        here = replace(problem, scene=bound)
        if form not in derived:
            derived[form] = prepared(here, (), independent)
        asked = replace(derived[form], scene=bound, forces=here.driving)
        start = here.initial
        still = bool(np.abs(start.u).max() <= STILL)
        like, slim = known.get((form, still), (None, None))
        found = asked.at(start.q, start.moving, 0.0, start.notes, like=like)
        if not (anywhere or stays(found)):
            found = _followed(asked, found, start.q, still, last) or found
        if like is not None and slim is not None and not slim.spin.any() and stays(found):
            dropped = [found.states.names.index(one) for one in slim.dropped]
            if len(untouched(found.A, dropped)) == len(dropped):
                last[:] = [found.point.q]
                return replace(found.without(dropped), kind=slim.kind)
        known[form, still] = found, settled(asked, found, anywhere)
        last[:] = [found.point.q]
        return known[form, still][1]

    return system


def _followed(
    requested: Prepared, system: Linearization, start: Array, still: bool, last: Sequence[Array]
) -> Linearization | None:
    """Return the system at the place of rest, or the steady motion, next to the last one; None where none is near."""
    if still:
        place = nearest(requested, last[-1] if last else start, system.point.u)
        return None if place is None else requested.at(*place, like=system)
    return steady_next_to(requested, system, last[-1] if last else None)


def stays(system: Linearization) -> bool:
    """Whether the independent velocities stay at the point of a system."""
    velocities = system.velocities
    size = max(1.0, float(np.abs(system.A[system.positions :]).max(initial=0.0)))
    return bool(np.all(np.abs(system.point.udot[velocities]) <= BALANCED * size))


def locus_over(problem: Problem, specified: str, independent: Sequence[str] = (), anywhere: bool = False) -> RootLocus:
    """Return the root locus over what `read_values` reads; other arguments and errors as of `systems`, `root_locus`."""
    name, values = read_values(specified, scene=problem.scene)
    return root_locus(name, values, _systems(problem, name, independent, anywhere), problem.scene.name)
