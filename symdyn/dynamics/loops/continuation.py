"""Closed mechanisms in numbers: assembled, moved along a path on the same branch, given velocities that fit.

Newton's method from the last position keeps the branch as long as steps are short: a step is halved where the loops
do not close from it, or where it takes a joint further than its tangent says. Velocities solve G u = 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops.assembly import Assembly
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.errors import DerivationError
from symdyn.scene import Scene

FINEST = 2.0**-20
"""Part of a step of the path below which it is given up."""

STRAIGHT = 0.1
"""Radians or metres by which a joint may leave its tangent in one step."""


def assemble(
    scene: Scene,
    guess: Mapping[str, float] | None = None,
    held: Sequence[str] | None = None,
    parameters: Mapping[str, float] | None = None,
) -> Assembly:
    """Return a position at which every loop is closed.

    Args:
        scene: the mechanism.
        guess: coordinates to begin with, beside those of the scene's `start`; rad, m or 1.
        held: coordinates that keep their guess; None holds the driven ones, unless the loops do not close so.
        parameters: values of the free parameters.

    Raises:
        DerivationError: the loops cannot be assembled from the guess, or a name or value is missing.
    """
    numbers = _numbers(scene, parameters)
    q = None
    if guess is not None:
        q = numbers.start()
        for name, value in guess.items():
            q[_index(scene, scene.coordinates, name)] = value
    return numbers.closed_position(q, None if held is None else [_velocity(scene, name) for name in held])


def follow(
    scene: Scene,
    begin: Assembly,
    path: Mapping[str, Sequence[float]],
) -> Array:
    """Return closed positions along a path, on the branch where it begins.

    Args:
        scene: the mechanism.
        begin: where it begins.
        path: values of the coordinates that lead, all equally many; rad or m.

    Returns:
        q at every point of the path, shape (points, nq).

    Raises:
        DerivationError: the loops do not close at a point of the path: it ends before, at a fold or a change point.
    """
    numbers = _numbers(scene, dict(begin.parameters))
    places = [_index(scene, scene.coordinates, name) for name in path]
    held = [_velocity(scene, name) for name in path]
    q, found = np.array(begin.q), []
    for goal in np.array(list(path.values()), dtype=np.float64).T:
        q = _led(numbers, q, places, held, goal, begin.rank)
        found.append(q)
    return np.array(found).reshape(-1, len(scene.coordinates))


def _led(numbers: Numbers, q: Array, places: list[int], held: list[int], goal: Array, rank: int) -> Array:
    """Return the closed position with the leading coordinates at their goal, in as many steps as it takes."""
    step, done = 1.0, 0.0
    begin = q[places]
    while done < 1.0:
        step = min(step, 1.0 - done)
        way = (begin + (done + step) * (goal - begin)) - q[places]
        tangent = _tangent(numbers, q, held, way)
        guess = numbers.moved(q, tangent)
        guess[places] = begin + (done + step) * (goal - begin)
        tried = numbers.newton(guess, held)
        if numbers.is_closed(tried) and float(np.abs(tried - guess).max()) < STRAIGHT:
            q, done, step = tried, done + step, 2 * step
            continue
        step /= 2
        if step < FINEST:
            values = np.linalg.svd(numbers.dimensionless(q, 1.0), compute_uv=False)
            smallest = values[rank - 1] if rank else 0.0
            names = ", ".join(
                f"{numbers.scene.coordinates[k]} = {x:.6g}" for k, x in zip(places, q[places], strict=True)
            )
            raise DerivationError(
                f"{numbers.scene.name}: the path ends at {names}: the loops do not close beyond, a fold or a change "
                f"point; the smallest singular value of their constraints there is {smallest:.3g}"
            )
    return q


def _tangent(numbers: Numbers, q: Array, held: list[int], way: Array) -> Array:
    """Return the step along the velocities that the loops allow, with the held ones given."""
    G = numbers.jacobian(q)
    loose = [k for k in range(numbers.state.n) if k not in held]
    step = np.zeros(numbers.state.n)
    step[held] = way
    if loose and len(G):
        step[loose] = np.linalg.lstsq(G[:, loose], -G[:, held] @ way, rcond=1e-10)[0]
    return step


def consistent(scene: Scene, assembly: Assembly, rates: Mapping[str, float] | None = None) -> Array:
    """Return velocities that the loops and rows allow, shape (nv,).

    Args:
        scene: the mechanism.
        assembly: a closed position.
        rates: some velocities; None takes those that joints give as `start_rates`. The rest follows from them; what
            does not is zero.

    Raises:
        DerivationError: the given velocities contradict each other.
    """
    numbers = _numbers(scene, dict(assembly.parameters))
    if rates is None:
        given = numbers.declared_rates()
    else:
        given = {_index(scene, scene.velocities, name): value for name, value in rates.items()}
    return numbers.fitting_rates(np.array(assembly.q), given)


def _numbers(scene: Scene, parameters: Mapping[str, float] | None) -> Numbers:
    known = dict(parameters or {})
    missing = [parameter.name for parameter in scene.free_parameters if parameter.name not in known]
    if missing:
        raise DerivationError(
            f"{scene.name}: {', '.join(missing)} {'has' if len(missing) == 1 else 'have'} no value; give parameters"
        )
    return Numbers(scene).bound_to(known)


def _velocity(scene: Scene, coordinate: str) -> int:
    """Return the velocity that is the rate of a coordinate."""
    k = 0
    for joint in scene.moving:
        if coordinate in joint.coordinates:
            if joint.velocities:
                raise DerivationError(f"{scene.name}: {coordinate} has no velocity of its own, so it cannot be held")
            return k + joint.coordinates.index(coordinate)
        k += len(joint.rates)
    raise DerivationError(f"{scene.name}: there is no coordinate {coordinate!r}; {', '.join(scene.coordinates)}")


def _index(scene: Scene, names: Sequence[str], name: str) -> int:
    if name not in names:
        raise DerivationError(f"{scene.name}: there is no {name!r}; there are {', '.join(names)}")
    return list(names).index(name)
