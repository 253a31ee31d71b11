"""The state that the lesson shows, and the multipliers there.

    A u = 0, A u̇ + Ȧ u = 0             what the conditions allow; prescribed motions are rows of their own
    E_i(u̇) - A_ki λ_k = 0              where nothing drives velocity i and no motion is prescribed for it

Rates and accelerations of independent velocities are chosen near those of all lessons; the rest follows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import null_space

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import prescribed
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient, substitute
from symdyn.teach.derivations.multipliers.constrained import Constrained
from symdyn.teach.shown_state import ACCELERATIONS, RATES, Chosen, choose_state, starting_rates

TINY = 1e-9
WAYS = (0.3, 0.2, 0.4, 0.25, 0.35, 0.15)
"""rad or m: how far undriven coordinates are shown from where the mechanism is drawn."""


def choose_tied_motion(lesson: Constrained, chosen: Chosen | None = None) -> Chosen:
    """Return a position, that drawn where none is given, with rates and accelerations that fit all equations.

    Raises:
        DerivationError: no accelerations fit that position, as at a change point.
    """
    if chosen is None:
        chosen = _away(lesson, choose_state(lesson.scene, lesson.state, lesson.graph, moving=not lesson.ties))
    state, n, m = lesson.state, lesson.state.n, len(lesson.ties)
    led = prescribed(lesson.scene, lesson.graph)
    pins = np.eye(n)[list(led.place)].reshape(-1, n)
    A = _matrix(chosen, [tie.slopes for tie in lesson.ties], n)
    free = [k for k in lesson.partition.independent if k not in led.place]
    given = starting_rates(lesson.scene, chosen.parameters)
    wanted = [given[k] or RATES[place % len(RATES)] for place, k in enumerate(free)]
    u = _near(np.vstack([A, pins]), [*[0.0] * m, *chosen.of(*led.velocity)], free, wanted)
    chosen = _with(chosen, state.qd, u)
    bias = [-x for x in chosen.of(*(tie.bias for tie in lesson.ties))]
    idle = [k for k in range(n) if lesson.scene.drives[k] is None and k not in led.place]
    forces = [lesson.drives[k] for k in idle]
    rest = chosen.of(*substitute(forces, dict.fromkeys(state.qdd, lesson.graph.zero)))
    M = _matrix(chosen, [gradient(force, state.qdd) for force in forces], n)
    zeros = np.zeros((len(A) + len(pins), m))
    C = np.block([[np.vstack([A, pins]), zeros], [M, -A[:, idle].T.reshape(len(idle), m)]])
    right = [*bias, *chosen.of(*led.acceleration), *(-x for x in rest)]
    driven = [k for k in free if lesson.scene.drives[k]] or free
    found = _near(C, right, driven, [ACCELERATIONS[k % len(ACCELERATIONS)] for k in range(len(driven))])
    if abs(C @ found - right).max(initial=0.0) > 1e-7 * (1 + np.abs(right).max(initial=0.0)):
        raise DerivationError(
            f"{lesson.scene.name}: where the lesson shows numbers no accelerations fit the loops and rows (a change "
            "point); give the joints another start"
        )
    chosen = _with(chosen, state.qdd, found[:n])
    told = [k for k in lesson.partition.dependent if lesson.scene.drives[k]]
    carried = A.T @ found[n:]
    drives = [chosen.of(lesson.drives[k])[0] - carried[k] for k in told]
    return _with(chosen, [lesson.graph.symbol(str(lesson.scene.drives[k])) for k in told], np.array(drives))


def _away(lesson: Constrained, chosen: Chosen) -> Chosen:
    """Return another position that the conditions allow, where undriven coordinates hide nothing."""
    led = lesson.scene.led_velocities
    idle = [k for k in lesson.partition.independent if lesson.scene.drives[k] is None and k not in led]
    if not idle or lesson.scene.free_parameters:
        return chosen
    numbers, n, free = lesson.workspace.loops.numbers, lesson.state.n, lesson.partition.independent
    wanted = [WAYS[place % len(WAYS)] if k in idle else 0.0 for place, k in enumerate(free)]
    A = _matrix(chosen, [tie.slopes for tie in lesson.ties], n)
    step = _near(A, [0.0] * len(A), free, wanted)
    try:
        q = numbers.closed_position(numbers.moved(np.array(chosen.q), step), ()).q
    except DerivationError:  # the loops do not close there
        return chosen
    moved = chosen.moved(dict(zip(lesson.state.q, map(float, q), strict=True)))
    return replace(moved, q=tuple(map(float, q)))


def _matrix(chosen: Chosen, rows: Sequence[Sequence[Expr]], width: int) -> Array:
    return np.array(chosen.of(*(x for row in rows for x in row))).reshape(-1, width)


def _near(C: Array, right: Sequence[float], free: Sequence[int], requested: Sequence[float]) -> Array:
    """Return x with C x = right whose free entries are as near those wanted as C allows."""
    if not len(C):
        return np.array(requested)
    x: Array = np.linalg.lstsq(C, np.array(right), rcond=1e-10)[0]
    ways = null_space(C, rcond=1e-10)
    moved = np.linalg.lstsq(ways[list(free)], np.array(requested) - x[list(free)], rcond=1e-10)[0]
    return np.asarray(x + ways @ moved)


def _with(chosen: Chosen, symbols: Sequence[Expr], values: Array) -> Chosen:
    rounded = [0.0 if abs(x) < TINY else float(x) for x in values]
    return chosen.moved(dict(zip(symbols, rounded, strict=True)))
