"""Laws of mechanics as claims about the derived equations; each is proved for the scene at hand, not sampled.

M = ∂²K/∂q̇²                         the mass matrix is the Hessian of the kinetic energy
Ṁ = C + Cᵀ                           so that Ṁ - 2C is skew
C q̇ = c
∂P/∂q = g + k_E
τ = k_z q̈ + k_C q̇q̇ + k_D q̇² + k_G + k_E - Q      the textbook's sum, with this product's signs
q̇·(τ + Q) = d/dt (K + P)            power in is the rate of energy
FD(q, q̇, ID(q, q̇, q̈)) = q̈          forward dynamics inverts inverse dynamics, prescribed motions in q̈
S·R = τ + Q                          along its joint's freedom a reaction is the drive and the joint's own forces
Σ R·(S q̇) = (τ + Q)·q̇               all the rest of the reactions is without power in any motion that the loops allow
Σ R + Σ loads = d/dt [p; L]          reactions of the ground and loads change momentum and angular momentum
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import combinations

from symdyn.dynamics import DYNAMICS, Workspace, derive_one
from symdyn.graph import Expr, gradient, substitute, tangents
from symdyn.verify.equality import Claim
from symdyn.verify.laws_of_loops import LAWS_OF_LOOPS, Law
from symdyn.verify.laws_of_reactions import LAWS_OF_REACTIONS


def laws(workspace: Workspace, outputs: Collection[str] = DYNAMICS) -> list[Claim]:
    """Return the laws about `outputs` as claims; one that needs another output is left out.

    Raises:
        DerivationError: an output does not exist, such as forward dynamics where M is singular.
    """
    table = [*(_closed_laws() if workspace.scene.is_closed else LAWS), *LAWS_OF_REACTIONS]
    claims = [law(workspace) for needed, law in table if set(needed) <= set(outputs)]
    return [claim for claim in claims if claim is not None]


def _closed_laws() -> list[Law]:
    """Return the laws of trees, which hold for the spanning tree with the forces on it, and those of loops."""
    of_trees: list[Law] = [
        (tuple("tree_forces" if name == "inverse_dynamics" else name for name in needed), law)
        for needed, law in LAWS
        if law is not _inverse
    ]
    return [*of_trees, *LAWS_OF_LOOPS]


def _entries(w: Workspace, name: str) -> tuple[Expr, ...]:
    return derive_one(w, name).entries


def _driving(w: Workspace) -> tuple[Expr, ...]:
    """Return what drives of the tree must exert."""
    return _entries(w, "tree_forces" if w.scene.is_closed else "inverse_dynamics")


def _hessian(w: Workspace) -> Claim:
    (K,) = _entries(w, "kinetic_energy")
    slopes = gradient(K, w.state.qd)
    rows = tuple(entry for slope in slopes for entry in gradient(slope, w.state.qd))
    return Claim("mass matrix", "Hessian of K", "M", rows, _entries(w, "mass_matrix"))


def _skew(w: Workspace) -> Claim:
    n, C = w.state.n, _entries(w, "coriolis_matrix")
    rates = tangents(_entries(w, "mass_matrix"), w.state.velocity)
    sums = tuple(C[i * n + j] + C[j * n + i] for i in range(n) for j in range(n))
    return Claim("passivity", "dM/dt", "C + C^T", tuple(rates), sums)


def _product(w: Workspace) -> Claim:
    n, C = w.state.n, _entries(w, "coriolis_matrix")
    product = tuple(w.graph.total(C[i * n + j] * w.state.qd[j] for j in range(n)) for i in range(n))
    return Claim("velocity forces", "C qd", "c", product, _entries(w, "velocity_forces"))


def _slope(w: Workspace) -> Claim:
    (P,) = _entries(w, "potential_energy")
    slopes, g = tuple(w.directions.slopes(P)), _entries(w, "gravity_forces")
    if not w.scene.springs:
        return Claim("gravity forces", "dP/dq", "g", slopes, g)
    sums = tuple(a + b for a, b in zip(g, _entries(w, "elastic_forces"), strict=True))
    return Claim("gravity and elastic forces", "dP/dq", "g + k_E", slopes, sums)


def _textbook(w: Workspace) -> Claim:
    n, s = w.state.n, w.state
    pairs = list(combinations(range(n), 2))
    k_z, k_C, k_D, k_G, k_E = (_entries(w, name) for name in ("k_z", "k_C", "k_D", "k_G", "k_E"))
    sums = []
    for i in range(n):
        terms = [k_z[i * n + j] * s.qdd[j] for j in range(n)]
        terms += [k_C[i * len(pairs) + m] * s.qd[j] * s.qd[k] for m, (j, k) in enumerate(pairs)]
        terms += [k_D[i * n + j] * s.qd[j] * s.qd[j] for j in range(n)]
        sums.append(w.graph.total(terms) + k_G[i] + k_E[i] - w.Q[i])
    right = _driving(w)
    elastic = " + k_E" if w.scene.springs else ""
    return Claim("coefficients", f"k_z qdd + k_C qd qd + k_D qd^2 + k_G{elastic} - Q", "tau", tuple(sums), right)


def _power(w: Workspace) -> Claim:
    (K,), (P,) = _entries(w, "kinetic_energy"), _entries(w, "potential_energy")
    s, tau = w.state, _driving(w)
    power = w.graph.total((t + force) * qd for t, force, qd in zip(tau, w.Q, s.qd, strict=True))
    return Claim("power balance", "qd.(tau + Q)", "d(K + P)/dt", (power,), tuple(tangents([K + P], s.acceleration)))


def _inverse(w: Workspace) -> Claim:
    qdd = w.prescribed.entered(w.state.qdd)
    drive = substitute(_entries(w, "inverse_dynamics"), dict(zip(w.state.qdd, qdd, strict=True)))
    given = dict(zip(w.state.tau, drive, strict=True))
    back = substitute(_entries(w, "forward_dynamics"), given)
    return Claim("forward dynamics", "FD(q, qd, ID(q, qd, qdd))", "qdd", tuple(back), tuple(qdd))


LAWS: tuple[Law, ...] = (
    (("kinetic_energy", "mass_matrix"), _hessian),
    (("mass_matrix", "coriolis_matrix"), _skew),
    (("coriolis_matrix", "velocity_forces"), _product),
    (("potential_energy", "gravity_forces"), _slope),
    (("inverse_dynamics", "k_z", "k_C", "k_D", "k_G"), _textbook),
    (("inverse_dynamics", "kinetic_energy", "potential_energy"), _power),
    (("inverse_dynamics", "forward_dynamics"), _inverse),
)
"""Each law with the outputs that it is about."""
