"""The functions that linearise: the linear systems of a scene at a point, at all positions of rest, or along a run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType
from typing import Unpack

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import native, with_fields
from symdyn.errors import SimulateError
from symdyn.linear.completeness import complete
from symdyn.linear.equilibrium import Equilibria, Equilibrium, equilibria
from symdyn.linear.linearization import Linearization
from symdyn.linear.prepared import Prepared, prepared
from symdyn.linear.steady import settled
from symdyn.rounding import in_digits
from symdyn.scene import Quantity, Scene, SceneLike, SceneUnits
from symdyn.simulation import Forces, Problem, Trajectory
from symdyn.simulation.prescribed import Entries


@with_fields(Problem)
def linearize(
    scene: SceneLike | Problem,
    *,
    outputs: str | Sequence[str] = (),
    independent: str | Sequence[str] = (),
    t: float = 0.0,
    anywhere: bool = False,
    **fields: Unpack[Problem.Fields],
) -> Linearization:
    """Return how a mechanism moves next to a point, to first order.

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
        outputs: formulas in what outputs of scenes may name, and in outputs, one by one or as "x,theta"; without, the
            outputs of the scene, or else all coordinates.
        independent: coordinates that determine the others where loops close; () leaves the choice to conditioning.
        t: time, s, of what depends on it.
        anywhere: take points too that are neither of rest nor of a steady motion.

    Raises:
        LinearizeError: there is no one linear motion there, or no equilibrium and no steady motion.
        SimulateError: with every fault of the arguments, one line each.
        DerivationError: loops cannot be closed, or friction is ideal.
    """
    (problem, _), (t,) = Problem.requested(linearize, locals()), native(float, t)
    if not math.isfinite(t):
        raise SimulateError(f"t = {t}: give a finite time, s")
    asked, start = prepared(problem, outputs, independent), problem.initial
    return settled(asked, asked.at(start.q, start.u, t, start.notes), anywhere)


def linearize_at_rest(
    scene: SceneLike | Problem,
    *,
    forces: Forces | Entries = (),
    outputs: str | Sequence[str] = (),
    independent: str | Sequence[str] = (),
    values: Mapping[str, object] | None = None,
) -> tuple[tuple[Linearization, ...], Equilibria]:
    """Return the systems at all positions of rest that seeded starts lead to, and how these were found.

    Arguments and errors as of `linearize`.
    """
    problem = Problem.requested(linearize_at_rest, locals())[0].refused("rest is looked for", "start", "start_rates")
    found = equilibria(prepared(problem, outputs, independent))
    return found.systems, found


def linearize_along(
    scene: SceneLike | Problem,
    run: Trajectory,
    *,
    forces: Forces | Entries = (),
    outputs: str | Sequence[str] = (),
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
    for t, q, u, tau, inputs in zip(run.t, run.q, run.qd, run.tau, run.inputs, strict=True):
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
