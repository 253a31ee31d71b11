"""What a joint can transmit, split: wrenches that its freedoms never feel, and one for every freedom.

    W    reactions: t wrenches without power, Sᵀ W = 0
    D    drives: one a velocity, Sᵀ D = 1: the free places of (5.7), which the unknown drives take

D is a moment where the freedoms turn (a screw is turned, not pushed), else what has no part along W.
"""

from __future__ import annotations

import numpy as np

from symdyn.dynamics.loops.loop_decisions import pivots
from symdyn.dynamics.mechanism.ldl import solve
from symdyn.dynamics.reactions.hinges import Hinge, plus, power, times
from symdyn.dynamics.reactions.probes import Samples
from symdyn.graph import Expr
from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.forbidden import everywhere, forces, moments
from symdyn.spatial import Wrench

TINY = 1e-9

PLACES = (2, 3)
"""Seeds of the generic positions."""


def drives(hinge: Hinge, samples: Samples) -> tuple[Wrench, ...]:
    """Return D, axes of J, about P; one for every velocity of the joint."""
    if not hinge.S:
        return ()
    zero = hinge.graph.zero
    n = len(hinge.S)
    still = (zero, zero, zero)
    turning = [(still, omega) for _, omega in hinge.S]
    turns = [samples.at([x for _, omega in turning for x in omega], seed).reshape(n, 3) for seed in PLACES]
    S = turning if any(np.linalg.matrix_rank(at, tol=TINY) == n for at in turns) else list(hinge.S)
    gram = [[power(a, b) for b in S] for a in S]
    flat = [x for row in gram for x in row]
    unit = [float(i == j) for i in range(n) for j in range(n)]
    if all(abs(samples.at(flat, seed) - unit).max() < TINY for seed in PLACES):
        return tuple(S)
    one = hinge.graph.one
    columns = [solve(range(-1, n), gram, [one if i == k else zero for i in range(n)]) for k in range(n)]
    return tuple(_combined(S, column) for column in columns)


def reactions_of(hinge: Hinge, samples: Samples) -> tuple[Wrench, ...]:
    """Return W, axes of J, about P; t of them.

    Those of a joint that has no formula for them are units less what the drives take of them. The units that are left
    out are those that the drives themselves have large, else a combination of the others would be a drive.
    """
    kind = JOINTS.get(hinge.joint.type)  # a contact has none
    if kind is None or kind.forbids:
        return hinge.wrenches
    axes = everywhere(hinge.graph)
    units, D = forces(*axes) + moments(*axes), drives(hinge, samples)
    numbers = samples.at([x for force, moment in D for x in (*force, *moment)], PLACES[0]).reshape(len(D), 6)
    taken, _ = pivots(numbers.T, [range(6)], len(D))
    return tuple(_remainder(e, hinge, D) for k, e in enumerate(units) if k not in taken)


def _remainder(e: Wrench, hinge: Hinge, D: tuple[Wrench, ...]) -> Wrench:
    """Return e - D Sᵀ e."""
    for twist, drive in zip(hinge.S, D, strict=True):
        e = plus(e, times(-power(e, twist), drive))
    return e


def _combined(S: list[Wrench], shares: list[Expr]) -> Wrench:
    """Return Σ share · S."""
    total = times(shares[0], S[0])
    for share, twist in zip(shares[1:], S[1:], strict=True):
        total = plus(total, times(share, twist))
    return total
