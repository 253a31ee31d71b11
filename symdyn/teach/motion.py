"""The state that D'Alembert's lesson shows: of a closed mechanism one whose rates and accelerations the loops allow.

    G u = 0, G u̇ + Ġ u = 0      rows of the loops at the drawn position, with prescribed motions as rows of their own

Rates of independent velocities are chosen, the others follow. A velocity that nothing drives and no loop ties (the
spin of a rod between two balls) is accelerated as it is without a drive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symdyn.algebra.numeric import Floats
from symdyn.dynamics.reactions.samples import Array
from symdyn.graph import Expr, evaluate
from symdyn.teach.balance import Balance
from symdyn.teach.state import ACCELERATIONS, RATES, Chosen, choose_state, starting_rates

SMALL = 1e-9


def choose_motion(lesson: Balance) -> Chosen:
    """Return the drawn position with rates and accelerations that are not all alike and that the loops allow."""
    chosen = choose_state(lesson.scene, lesson.state, lesson.graph, moving=not lesson.closed)
    w, n = lesson.workspace, lesson.state.n
    led = w.prescribed
    if not lesson.closed and not led.place:
        return chosen
    rows = w.closed.recursive if lesson.closed else None
    G = w.closed.G(rows) if rows else []
    pins = np.eye(n)[list(led.place)].reshape(-1, n)
    A = np.vstack([np.array(chosen.of(*(x for row in G for x in row))).reshape(-1, n), pins])
    free = _independent(lesson, led.place)
    given = starting_rates(lesson.scene, chosen.parameters)
    wanted = [given[k] or RATES[place % len(RATES)] for place, k in enumerate(free)]
    u = _tied(A, np.array([*(0.0 for _ in G), *chosen.of(*led.velocity)]), free, wanted)
    chosen = _with(chosen, lesson.state.qd, u)
    bias = [-x for x in chosen.of(*w.closed.bias(rows))] if rows else []
    right = np.array([*bias, *chosen.of(*led.acceleration)])
    chosen = _with(chosen, lesson.state.qdd, _tied(A, right, free, ACCELERATIONS))
    return _without_idle_drives(lesson, chosen, A, right, free)


def solved_at(lesson: Balance, chosen: Chosen) -> tuple[Array, bool]:
    """Return the least x with A x + b = 0 of (5.18) in numbers, and whether it is the only one."""
    matrix, right = _system_at(lesson, chosen)
    x, _, rank, _ = np.linalg.lstsq(matrix, -right, rcond=1e-10)
    left = abs(matrix @ x + right).max(initial=0.0)
    assert left <= 1e-8 * (1 + abs(right).max(initial=0.0)), "the bodies are not in equilibrium at the chosen state"
    return np.where(np.abs(x) < SMALL * (np.abs(x).max() or 1.0), 0.0, x), rank == len(x)


def determined(lesson: Balance, chosen: Chosen, unknowns: list[int]) -> bool:
    """Return whether (5.18) determines some of its unknowns at the chosen state."""
    matrix, _ = _system_at(lesson, chosen)
    units = np.eye(matrix.shape[1])[unknowns].reshape(-1, matrix.shape[1])
    return bool(np.linalg.matrix_rank(matrix) == np.linalg.matrix_rank(np.vstack([matrix, units])))


def _system_at(lesson: Balance, chosen: Chosen) -> tuple[Array, Array]:
    """Return A and b of (5.18) in numbers."""
    A, b = lesson.system.matrix(), lesson.system.right()
    found = np.array(evaluate([*(x for row in A for x in row), *b], Floats(), chosen.values), dtype=np.float64)
    size = (len(A), len(lesson.unknowns))
    return found[: size[0] * size[1]].reshape(size), found[size[0] * size[1] :]


def _independent(lesson: Balance, led: tuple[int, ...]) -> list[int]:
    """Return the velocities whose rates may be chosen."""
    free = list(lesson.workspace.closed.closure.partition.independent) if lesson.closed else range(lesson.state.n)
    return [k for k in free if k not in led]


def _tied(A: Array, right: Array, free: list[int], wanted: Sequence[float]) -> Array:
    """Return x with A x = right whose free entries are as wanted, or near where A does not allow it."""
    x = np.zeros(A.shape[1])
    x[free] = [wanted[k % len(wanted)] for k in range(len(free))]
    others = [k for k in range(len(x)) if k not in free]
    if others and len(A):
        x[others] = np.linalg.lstsq(A[:, others], right - A[:, free] @ x[free], rcond=1e-10)[0]
    if len(A) and abs(A @ x - right).max() > SMALL * (1 + abs(x).max()):  # a dead centre
        x += np.linalg.lstsq(A, right - A @ x, rcond=1e-10)[0]
    return x


def _with(chosen: Chosen, symbols: tuple[Expr, ...], values: Array) -> Chosen:
    rounded = [0.0 if abs(x) < SMALL else float(x) for x in values]
    return replace(chosen, values={**chosen.values, **dict(zip(symbols, rounded, strict=True))})


def _without_idle_drives(lesson: Balance, chosen: Chosen, A: Array, right: Array, free: list[int]) -> Chosen:
    """Return the state with accelerations changed, within what A allows, so that drives nobody declared are zero."""
    idle = [lesson.system.unknowns.index(one) for one in lesson.system.passive] if lesson.closed else []
    if not idle:
        return chosen

    def needed(wanted: tuple[float, ...]) -> tuple[Chosen, Array]:
        state = _with(chosen, lesson.state.qdd, _tied(A, right, free, wanted))
        return state, solved_at(lesson, state)[0][idle]

    start = [ACCELERATIONS[k % len(ACCELERATIONS)] for k in range(len(free))]
    _, before = needed(tuple(start))
    slopes = []
    for k in range(len(free)):
        moved = [x + (i == k) for i, x in enumerate(start)]
        slopes.append(needed(tuple(moved))[1] - before)
    driven = [k for k, v in enumerate(free) if lesson.scene.drives[v]]
    slopes_of_idle = np.array([s if k not in driven else 0 * s for k, s in enumerate(slopes)]).T
    step = np.linalg.lstsq(slopes_of_idle, -before, rcond=1e-10)[0]
    return needed(tuple(np.array(start) + step))[0]
