"""A linear system in axes that do not spin with the body that they are of, in which A may be constant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.dynamics.mechanism.placements import body_placements
from symdyn.dynamics.mechanism.state import placement, vector
from symdyn.linear.linearization import Linearization
from symdyn.scene import JOINTS, Joint
from symdyn.simulation.equations.opened import numbers_at

STILL = 1e-12
"""Velocities, rad/s or m/s, that are none."""

EQUAL = 1e-6
"""Differences, over the largest entry, that are none."""


def spins(found: Linearization) -> list[tuple[str, Array]]:
    """Return ways to look at what turns in a moved frame, none first: words, and Ω of Ṙ = Ω R, shape (nv, nv).

    R takes components in the body's axes to those of a frame that turns with the body but for its spin about an axis n:
    ω = a n + b e with e the vertical, Ω = a ñ.
    """
    n = len(found.point.u)
    ways = [("", np.zeros((n, n)))]
    first = 0
    for joint in found.scene.moving:
        at = first
        for block in JOINTS[joint.type].blocks(joint):
            wide = len(block.velocities)
            turning = found.point.u[at + wide - 3 : at + wide] if block.letters else np.zeros(0)
            if np.abs(turning).max(initial=0.0) > STILL:
                vertical = _vertical(found, joint)
                for k, axis in enumerate(np.eye(3)):
                    basis = np.stack([axis, vertical], axis=1)
                    parts = np.linalg.lstsq(basis, turning, rcond=1e-9)[0]
                    if np.abs(basis @ parts - turning).max() <= EQUAL * np.abs(turning).max():
                        spin = np.zeros((n, n))
                        for part in range(at, at + wide, 3):
                            spin[part : part + 3, part : part + 3] = parts[0] * _skew(axis)
                        ways.append((f"in axes of {joint.child} that do not spin with it about its {'xyz'[k]}", spin))
            at += wide
        first += len(joint.rates)
    return ways


def _vertical(found: Linearization, joint: Joint) -> Array:
    """Return the direction of gravity, or zero, in the frame that a joint has moved."""
    numbers = numbers_at(found.scene)
    graph = numbers.graph
    R = (body_placements(found.scene, graph)[joint.child] @ placement(joint.tip, graph).inverse()).R
    down = vector(found.scene.gravity, graph)
    turned = numbers.at([sum((R[r][c] * down[r] for r in range(3)), graph.zero) for c in range(3)], found.point.q)
    return turned / (float(np.linalg.norm(turned)) or 1.0)


def _skew(axis: Array) -> Array:
    x, y, z = axis
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _turn(spin: Array) -> Array:
    """Return exp of a skew matrix, by its eigenvectors."""
    values, vectors = np.linalg.eigh(1j * spin)
    return np.asarray((vectors * np.exp(-1j * values)) @ vectors.conj().T).real


def turned(
    found: Linearization, start: Linearization, labels: Sequence[str], spin: Array, time: float
) -> Linearization:
    """Return a system after some time with its states in a frame that spins by Ω against the body's axes.

    States are some entries P of N x, N of the point in that frame; there N stays, so

        X = P R⁻¹ N,  x̃ = X⁻¹ x,  Ã = X⁻¹ A X + X⁻¹ P R⁻¹ Ω N
    """
    if not spin.any():
        return found
    p = start.positions
    N = np.vstack([np.hstack([start.directions, np.zeros((len(spin), len(start.states) - p))]), start.rates])
    velocities = start.scene.velocities
    n = len(spin)
    chosen = [labels.index(name) for name in start.states.names[:p]]
    chosen += [n + velocities.index(name) for name in start.states.names[p:]]
    back = np.kron(np.eye(2), _turn(-time * spin))
    both = np.kron(np.eye(2), spin)
    X = (back @ N)[chosen]
    A = np.linalg.solve(X, found.A @ X + (back @ both @ N)[chosen])
    return replace(found, A=A)
