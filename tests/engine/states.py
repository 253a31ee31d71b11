"""Positions and velocities that loops, wheels and blades allow: Newton's method, and the null space of their rows."""

from __future__ import annotations

import numpy as np

from .mechanism import Array, Mechanism, State

RANK = 1e-9


def start(m: Mechanism) -> Array:
    """Return the coordinates of no motion: zeros, and 1, 0, 0, 0 for a quaternion."""
    q = []
    for joint in m.scene.moving:
        q += [0.0] * len(joint.coordinates)
        if len(joint.coordinates) > len(joint.rates):
            q[-4] = 1.0
    return np.array(q)


def moved(m: Mechanism, q: Array, way: Array) -> Array:
    """Return the coordinates a step along the velocities further, quaternions of length 1."""
    q = q + m.at(q, way).rates
    i = 0
    for joint in m.scene.moving:
        i += len(joint.coordinates)
        if len(joint.coordinates) > len(joint.rates):
            q[i - 4 : i] /= np.linalg.norm(q[i - 4 : i])
    return q


def rows(state: State) -> Array:
    """Return the rows of all contacts and formulas on the velocities, (m, nv)."""
    return np.vstack([state.forbidden(state.contacts())[0] @ state.columns, state.formulas()[0]])


def rank(G: Array) -> int:
    """Return how many rows are independent."""
    s = np.linalg.svd(G, compute_uv=False) if G.size else np.zeros(0)
    return int((s > RANK * s.max(initial=1.0)).sum())


def free_motions(G: Array) -> Array:
    """Return an orthonormal basis of the velocities that rows allow, one a column."""
    _, s, Vt = np.linalg.svd(G) if G.size else (None, np.zeros(0), np.eye(G.shape[1]))
    return Vt[int((s > RANK * s.max(initial=1.0)).sum()) :].T


def residual(m: Mechanism, q: Array, way: Array | None = None) -> tuple[Array, Array]:
    """Return the residuals of all contacts, and their rates along a way."""
    found = [one for contact in m.at(q, way).contacts() for one in contact.residual]
    return np.array([float(one.x) for one in found]), np.array([float(one.v) for one in found])


def assemble(m: Mechanism, q: Array, held: Array | None = None) -> Array | None:
    """Return coordinates near q at which everything is closed; None where Newton's method does not end so.

    Args:
        m: the mechanism.
        q: where to begin.
        held: velocities along which nothing moves.
    """
    if not any(contact.residual for contact in m.at(q).contacts()):
        return q
    n = len(m.names)
    loose = np.ones(n, bool) if held is None else ~np.isin(np.arange(n), held)
    for _ in range(40):
        r, _ = residual(m, q)
        if np.abs(r).max(initial=0.0) < 1e-13:
            break
        slopes = np.array([residual(m, q, one)[1] for one in np.eye(n)[loose]]).T
        step = np.zeros(n)
        step[loose] = np.linalg.lstsq(slopes, -r, rcond=1e-10)[0]
        q = moved(m, q, step * min(1.0, 0.5 / max(1e-300, np.abs(step).max())))
    return q if np.abs(residual(m, q)[0]).max(initial=0.0) < 1e-11 and right_way_round(m, q) else None


def right_way_round(m: Mechanism, q: Array) -> bool:
    """Tell whether no loop is closed with an axis reversed: there residuals move otherwise than wrenches work."""
    state = m.at(q)
    loops = state.contacts()[: len(m.scene.loops)]
    if not loops:
        return True
    works = state.forbidden(loops)[0] @ state.columns
    count = len(works)
    slopes = np.array([residual(m, q, one)[1][:count] for one in np.eye(len(m.names))]).T
    return rank(np.vstack([works, slopes])) == rank(works) == rank(slopes)
