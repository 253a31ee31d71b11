"""The equations of a mechanism in six velocities a body, solved at once, whatever its joints and loops are.

    ν̇, u̇        rates of the bodies' twists and of the velocities; A u: the joints' own rates, for some joints follow
    w, λ         whole wrench in every joint of the tree, six of them; size of every wrench of a loop or contact
    c, μ, τ      force of a coupling, of a row that is a formula, of a drive
B, β         what rotors add along own rates: matrix, and forces at u̇ = 0

    M ν̇ + b = Dᵀ w + (W D)ᵀ λ + weights, springs, loads        Newton and Euler, of every body
    D ν̇ - S A u̇ = (D ν̇)₀                                      every joint moves as its freedoms allow
    W D ν̇ = (W D ν̇)₀ - (its rate)₀                             loops and contacts forbid what they forbid
    a u̇ = -ȧ u                                                  so do formulas in velocities
    Sᵀ w + B A u̇ + β = τ + Q + c + aᵀ μ                          what goes through a joint along its own freedoms

(·)₀ is at u̇ = 0, as the placements move. Of every velocity the rate or the drive may be given, or both, or neither:
inverse dynamics gives rates, forward dynamics gives drives. What is not unique comes as the least solution, with the
null space beside it.

Reference: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 11.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .mechanism import Array, State

RANK = 1e-10


@dataclass(frozen=True)
class Solution:
    """What the equations give.

    Attributes:
        du, tau: rates of the velocities, and drives, (nv,).
        wrenches: whole wrenches of joints and loops on the child, ground axes, about the moved frame, (rows, 6).
        loose: a basis of what may be added to the three, (k, nv), (k, nv), (k, rows, 6).
        missed: what the equations leave unbalanced, over the largest term: not zero where the motion is impossible.
    """

    du: Array
    tau: Array
    wrenches: Array
    loose: tuple[Array, Array, Array]
    missed: float


def balance(state: State, du: Array, tau: Array) -> Solution:
    """Return the motion and the forces; what is not given in du or tau is nan.

    Args:
        state: positions and velocities; its own du must be zero.
        du: rates of the velocities, shape (nv,).
        tau: drives, shape (nv,).
    """
    m, contacts = state.m, state.contacts()
    (M, b), twists = state.inertias(), state.twists()[1]
    D, S, A = state.tree
    W, bias = state.forbidden(contacts)
    a, formula_bias = state.formulas()
    (pulls, pulled), (drags, dragged) = state.pulls(), state.drags()
    B, beta = state.rotors()
    free, open_ = np.isnan(du), np.isnan(tau)
    known = {"u": np.where(free, 0, du), "tau": np.where(open_, 0, tau)}
    own, follows = A.copy(), [m.first[joint.name] for joint in m.scene.joints if joint.coupling is not None]
    own[follows] = 0.0  # which own rate is a velocity
    couplings = (np.eye(len(A)) - own @ A.T)[:, follows]  # c on the joint that follows, -ratio c on its leader

    size = {"nu": len(b), "w": len(D), "lam": len(W), "mu": len(a)}
    size |= {"c": len(follows), "u": int(free.sum()), "tau": int(open_.sum())}
    ends = np.cumsum([0, *size.values()])
    at = {name: slice(*pair) for name, pair in zip(size, pairwise(ends), strict=True)}
    blocks = [
        (b - state.weights() - pulls - drags, {"nu": -M, "w": D.T, "lam": W.T}),
        (D @ twists + S @ A @ known["u"], {"nu": D, "u": -(S @ A)[:, free]}),
        (W @ twists - bias, {"nu": W}),
        (-formula_bias - a @ known["u"], {"u": a[:, free]}),
        (
            own @ known["tau"] + pulled + dragged - beta - B @ A @ known["u"],
            {
                "w": S.T, "u": (B @ A)[:, free], "tau": -own[:, open_], "mu": -own @ a.T,
                "c": -couplings,
            },
        ),
    ]  # fmt: skip
    left, right = np.zeros((sum(len(one) for one, _ in blocks), ends[-1])), np.concatenate([one for one, _ in blocks])
    row = 0
    for one, parts in blocks:
        for name, matrix in parts.items():
            left[row : row + len(one), at[name]] = matrix
        row += len(one)
    x, N, missed = least(left, right)
    loops = contacts[: len(m.scene.loops)]
    ends = np.cumsum([0, *(len(loop.wrenches) for loop in loops)])

    def whole(vector: Array) -> Array:
        lam = vector[at["lam"]]
        closing = [lam[i:j] @ loop.acting for loop, (i, j) in zip(loops, pairwise(ends), strict=True)]
        return np.array([*vector[at["w"]].reshape(-1, 6), *closing])

    def spread(vectors: Array, name: str, some: Array) -> Array:
        result = np.zeros((vectors.shape[1], len(some)))
        result[:, some] = vectors[at[name]].T
        return result

    found = {name: spread(x[:, None], name, some)[0] + known[name] for name, some in (("u", free), ("tau", open_))}
    loose = np.array([whole(vector) for vector in N.T]).reshape(-1, len(m.scene.joints) + len(loops), 6)
    return Solution(found["u"], found["tau"], whole(x), (spread(N, "u", free), spread(N, "tau", open_), loose), missed)


def least(A: Array, b: Array) -> tuple[Array, Array, float]:
    """Return the least solution of A x = b, a basis of the null space of A, and the part of b that is missed."""
    sizes = np.linalg.norm(A, axis=1)
    sizes[sizes == 0] = 1.0
    U, s, Vt = np.linalg.svd(A / sizes[:, None])
    rank = int((s > RANK * s[0]).sum())
    x = Vt[:rank].T @ ((U[:, :rank].T @ (b / sizes)) / s[:rank])
    missed = np.abs(A @ x - b).max(initial=0.0) / max(1.0, np.abs(b).max(initial=0.0), np.abs(x).max(initial=0.0))
    return x, Vt[rank:].T, float(missed)
