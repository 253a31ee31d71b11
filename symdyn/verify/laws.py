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
Y π = τ                              regressors times declared parameters, which stand in `laws_of_regressors`
dC/dt = J u, p = m J u               laws of the centre of mass, which stand in `laws_of_momentum`
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from math import prod

from symdyn.dynamics import Workspace, coefficients
from symdyn.graph import Expr, gradient, substitute, tangents
from symdyn.scene.forces import elastic
from symdyn.verify.equality import Claim
from symdyn.verify.law import Law, entries, everywhere
from symdyn.verify.laws_of_loops import LAWS_OF_LOOPS
from symdyn.verify.laws_of_momentum import LAWS_OF_MOMENTUM
from symdyn.verify.laws_of_reactions import LAWS_OF_REACTIONS
from symdyn.verify.laws_of_regressors import LAWS_OF_REGRESSORS


def laws(workspace: Workspace, outputs: Collection[str]) -> list[Claim]:
    """Return the laws about `outputs` as claims.

    A law that needs another output is left out.

    Raises:
        DerivationError: an output does not exist, such as forward dynamics where M is singular.
    """
    claims = (law.claim(workspace) for law in LAWS if law.fits(workspace.scene, outputs))
    return [claim for claim in claims if claim is not None]


DRIVING, DRIVING_TREE = "inverse_dynamics", "tree_forces"
"""What drives of a tree must exert, and those of the spanning tree where loops close."""


def _driving(w: Workspace) -> tuple[Expr, ...]:
    return entries(w, DRIVING_TREE if w.scene.is_closed else DRIVING)


def _of_driving(claim: Callable[[Workspace], Claim | None], *outputs: str) -> Law:
    return Law((DRIVING, *outputs), (DRIVING_TREE, *outputs), claim)


def _hessian(w: Workspace) -> Claim:
    (K,) = entries(w, "kinetic_energy")
    slopes = gradient(K, w.state.qd)
    rows = tuple(entry for slope in slopes for entry in gradient(slope, w.state.qd))
    return Claim("mass matrix", "Hessian of K", "M", rows, entries(w, "mass_matrix"))


def _skew(w: Workspace) -> Claim:
    n, C = w.state.n, entries(w, "coriolis_matrix")
    rates = tangents(entries(w, "mass_matrix"), w.state.velocity)
    sums = tuple(C[i * n + j] + C[j * n + i] for i in range(n) for j in range(n))
    return Claim("passivity", "dM/dt", "C + C^T", tuple(rates), sums)


def _product(w: Workspace) -> Claim:
    n, C = w.state.n, entries(w, "coriolis_matrix")
    product = tuple(w.graph.total(C[i * n + j] * w.state.qd[j] for j in range(n)) for i in range(n))
    return Claim("velocity forces", "C qd", "c", product, entries(w, "velocity_forces"))


def _slope(w: Workspace) -> Claim:
    (P,) = entries(w, "potential_energy")
    slopes, g = tuple(w.directions.slopes(P)), entries(w, "gravity_forces")
    if not elastic(w.scene):
        return Claim("gravity forces", "dP/dq", "g", slopes, g)
    sums = tuple(a + b for a, b in zip(g, entries(w, "elastic_forces"), strict=True))
    return Claim("gravity and elastic forces", "dP/dq", "g + k_E", slopes, sums)


def _textbook(w: Workspace) -> Claim:
    rate = {"qd": w.state.qd, "qdd": w.state.qdd}
    terms: list[list[Expr]] = [[] for _ in w.state.qd]
    for name, columns in coefficients(w.state.n).items():
        k = iter(entries(w, name))
        for row in terms:
            row += [prod((rate[of][j] for of, j in rates), start=next(k)) for rates in columns]
    sums = [w.graph.total(row) - Q for row, Q in zip(terms, w.Q, strict=True)]
    right = _driving(w)
    pulled = " + k_E" if elastic(w.scene) else ""
    return Claim("coefficients", f"k_z qdd + k_C qd qd + k_D qd^2 + k_G{pulled} - Q", "tau", tuple(sums), right)


def _power(w: Workspace) -> Claim:
    (K,), (P,) = entries(w, "kinetic_energy"), entries(w, "potential_energy")
    s, tau = w.state, _driving(w)
    power = w.graph.total((t + force) * qd for t, force, qd in zip(tau, w.Q, s.qd, strict=True))
    return Claim("power balance", "qd.(tau + Q)", "d(K + P)/dt", (power,), tuple(tangents([K + P], s.acceleration)))


def _inverse(w: Workspace) -> Claim:
    qdd = w.prescribed.entered(w.state.qdd)
    drive = substitute(entries(w, "inverse_dynamics"), dict(zip(w.state.qdd, qdd, strict=True)))
    given = dict(zip(w.state.tau, drive, strict=True))
    back = substitute(entries(w, "forward_dynamics"), given)
    return Claim("forward dynamics", "FD(q, qd, ID(q, qd, qdd))", "qdd", tuple(back), tuple(qdd))


LAWS: list[Law] = [
    everywhere(_hessian, "kinetic_energy", "mass_matrix"),
    everywhere(_skew, "mass_matrix", "coriolis_matrix"),
    everywhere(_product, "coriolis_matrix", "velocity_forces"),
    everywhere(_slope, "potential_energy", "gravity_forces"),
    _of_driving(_textbook, "k_z", "k_C", "k_D", "k_G"),
    _of_driving(_power, "kinetic_energy", "potential_energy"),
    Law(("inverse_dynamics", "forward_dynamics"), None, _inverse),
    *LAWS_OF_LOOPS,
    *LAWS_OF_REACTIONS,
    *LAWS_OF_MOMENTUM,
    *LAWS_OF_REGRESSORS,
]
"""The laws that are proved; those of trees hold for the spanning tree of a closed scene, with the forces on it."""
