"""What of a start that is given a closed mechanism keeps: what can be chosen freely is held, the rest follows.

    N        basis of the velocities that the rows allow, one a row; f of them
    k        one more coordinate or velocity can be given beside others if column k of N raises their rank

Coordinates that are given beyond that say where the assembly begins: they choose among its branches. Velocities that
are given replace those of the scene, of which only such are held that they leave open.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops import Assembly, Numbers, free_motions
from symdyn.errors import DerivationError, SimulateError
from symdyn.scene.values import velocity_name

CONSISTENT = 1e-9
"""Largest coordinate by which a start is moved without a note, rad or m; and velocity, rad/s or m/s."""

NOTHING = 1e-9
"""Singular values of columns of N that are zero."""


def closed_start(numbers: Numbers, q: Array, given: Sequence[int], moved: Sequence[int]) -> tuple[Assembly, list[str]]:
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
    kept = order
    if not _closes(numbers, q, (*moved, *order)):
        kept = []
        for k in order:
            kept = [*kept, k] if _closes(numbers, q, (*moved, *kept, k)) else kept
    held = sorted({*moved, *kept})
    assembly = numbers.closed_position(q if held or any(q) else None, held or None)
    return assembly, [*assembly.notes, *_guessed(numbers, np.array(assembly.q), q, places, kept, moved)]


def _closes(numbers: Numbers, q: Array, held: Sequence[int]) -> bool:
    """Whether the loops close with some coordinates as they are, where equations of motion say something."""
    found = numbers.newton(numbers.normalised(q), tuple(sorted({*held})))
    return numbers.is_closed(found) and not (numbers.singular_angles(found) or numbers.lying_flat(found))


def _guessed(
    numbers: Numbers, closed: Array, q: Array, places: dict[int, int], kept: Sequence[int], moved: Sequence[int]
) -> list[str]:
    """Return what is said of coordinates that were given and not kept."""
    coordinates = numbers.scene.coordinates
    N = free_motions(numbers.dimensionless(closed, 1.0))
    lost = [k for k in places if k not in kept and abs(closed[places[k]] - q[places[k]]) > CONSISTENT]
    for k in lost:
        if _rank(N, (*moved, *kept, k)) > _rank(N, (*moved, *kept)):
            name = coordinates[places[k]]
            raise SimulateError(
                f"start: the loops do not close with {name} = {q[places[k]]:.6g}; from there they close at {name} = "
                f"{closed[places[k]]:.6g}; give another value, or guesses of the other coordinates too"
            )
    if not lost:
        return []
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
