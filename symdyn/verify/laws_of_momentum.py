"""Laws of the centre of mass C and of momentum about it, A u = [p; L]; they hold where loops close a scene, too.

dC/dt = J u
p = m J u                            momentum is that of all mass at C
g = -m Jᵀ g₀                         weight acts at C; g₀ is the acceleration of free fall
d/dt (A u) = A u̇ + b
∂K/∂[v; ω] = Rᵀ [p; L + (C - r) × p] where all hangs on one free body at r, R: its share of M u is the momentum

Reference: Orin, Goswami and Lee, Centroidal dynamics of a humanoid robot, Autonomous Robots 35 (2013) 161.
"""

from __future__ import annotations

from symdyn.dynamics import Workspace
from symdyn.graph import Expr, tangents
from symdyn.scene import Quantity
from symdyn.spatial import Vec, add, cross, sub
from symdyn.verify.equality import Claim
from symdyn.verify.law import Law, entries, everywhere


def _momentum(w: Workspace) -> tuple[Expr, ...]:
    A, n = entries(w, "centroidal_momentum_matrix"), w.state.n
    return tuple(
        w.graph.total(a * u for a, u in zip(A[k : k + n], w.state.qd, strict=True)) for k in range(0, 6 * n, n)
    )


def _velocity(w: Workspace) -> Claim:
    J, n = entries(w, "centre_of_mass_jacobian"), w.state.n
    moved = tuple(
        w.graph.total(a * u for a, u in zip(J[k : k + n], w.state.qd, strict=True)) for k in range(0, 3 * n, n)
    )
    rates = tuple(tangents(entries(w, "centre_of_mass"), w.state.velocity))
    return Claim("centre of mass", "dC/dt", "J qd", rates, moved)


def _linear(w: Workspace) -> Claim:
    m = w.mass
    J = tuple(m * one for one in entries(w, "centre_of_mass_jacobian"))
    return Claim("momentum", "upper half of A", "m J", entries(w, "centroidal_momentum_matrix")[: len(J)], J)


def _weight(w: Workspace) -> Claim:
    J, n, m = entries(w, "centre_of_mass_jacobian"), w.state.n, w.mass
    pulled = tuple(-m * w.graph.total(J[i * n + k] * w.tree.gravity[i] for i in range(3)) for k in range(n))
    return Claim("weight", "g", "-m J^T g_0", entries(w, "gravity_forces"), pulled)


def _rate(w: Workspace) -> Claim:
    A, b, n = entries(w, "centroidal_momentum_matrix"), entries(w, "centroidal_momentum_bias"), w.state.n
    rates = tuple(tangents(_momentum(w), w.state.acceleration))
    sums = tuple(
        w.graph.total(a * du for a, du in zip(A[i * n : i * n + n], w.state.qdd, strict=True)) + b[i] for i in range(6)
    )
    return Claim("rate of momentum", "d/dt (A qd)", "A qdd + b", rates, sums)


def _share_of_base(w: Workspace) -> Claim | None:
    base, tree = w.scene.joints[0], w.tree
    free = len(base.rates) == 6 and len(base.coordinates) == 7  # v and ω in the moved frame
    if not free or base.armature != Quantity.ZERO or tree.parent.count(0) > 1:
        return None
    carrier, here = tree.joint[base.name][1]
    T, C = tree.placements()[carrier] @ here, entries(w, "centre_of_mass")
    p, L = _vectors(_momentum(w))
    turning = add(L, cross(sub((C[0], C[1], C[2]), T.p), p))
    share = (*T.R.T @ p, *T.R.T @ turning)
    return Claim("momentum of a free base", "its part of p = M qd", "R^T [p; L]", entries(w, "momentum")[:6], share)


def _vectors(six: tuple[Expr, ...]) -> tuple[Vec, Vec]:
    return (six[0], six[1], six[2]), (six[3], six[4], six[5])


LAWS_OF_MOMENTUM: tuple[Law, ...] = (
    everywhere(_velocity, "centre_of_mass", "centre_of_mass_jacobian"),
    everywhere(_linear, "centre_of_mass_jacobian", "centroidal_momentum_matrix"),
    everywhere(_weight, "centre_of_mass_jacobian", "gravity_forces"),
    everywhere(_rate, "centroidal_momentum_matrix", "centroidal_momentum_bias"),
    everywhere(_share_of_base, "centroidal_momentum_matrix", "centre_of_mass", "momentum"),
)
