"""Functions that other formulations are written by: Hamilton's H and rates, Routh's function, Gibbs' and Appell's.

    p          generalized momenta M(q) u, an argument in place of velocities; u = M⁻¹ p
    H          p·u - L = ½ p·M⁻¹ p + P, a function of q and p
    ṗ          X K - g - k_E + Q + τ + Gᵀ λ + Σ γ u p + Ṁ u, slopes X of K(q, u) at u held; λ where rows tie the
               velocities; Ṁ of states that masses are made of
    R          L - Σ p_c u_c over cyclic velocities c: ½ u_r·M_rr u_r - ½ u_c·M_cc u_c - P, M_cc u_c = p_c - M_cr u_r
    S          ½ u̇·M u̇ + u̇·c, what of ½ ∫ a² dm holds an acceleration, so that ∂S/∂u̇ = M u̇ + c

γ are brackets of the directions of velocities: Lie and Poisson's terms, where these are no rates of coordinates. The
other formulations come from K and P of positions, and from accelerations of points; ṗ there is d/dt (∂K/∂u) along the
motion that Lagrange's equations give.

References: Goldstein, Classical Mechanics (1980), 8.1 and 8.3; Gibbs, On the fundamental formulae of dynamics (1879);
Marsden and Ratiu, Introduction to Mechanics and Symmetry (1999), 13.1 (Lie-Poisson).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from symdyn.dynamics.mechanism.linear_solve import solve
from symdyn.dynamics.outputs.named_functions import MOMENTA, direction
from symdyn.dynamics.outputs.output import Formulation, Output, Size, by_lagrange
from symdyn.dynamics.outputs.signal_outputs import Moving
from symdyn.dynamics.outputs.tree_formulations import cheaper_forward
from symdyn.dynamics.outputs.workspace import Matrix, Workspace
from symdyn.dynamics.recursive.reduced_tree import potential_energy
from symdyn.dynamics.recursive.tree_dynamics import aba, rnea
from symdyn.errors import DerivationError, listed
from symdyn.graph import Expr, substitute, tangents


def _momenta(w: Workspace) -> tuple[Expr, ...]:
    return direction(w.graph, MOMENTA, w.state.n)


def _speeds(w: Workspace) -> list[Expr]:
    """Return u = M⁻¹ p, by what forward dynamics takes."""
    if w.once(cheaper_forward) == "aba":
        return aba(w.recursion_tree.without_gravity, w.zeros, _momenta(w))
    return solve(w.tree.velocity_parents(), w.composite_mass, list(_momenta(w)))


def _lagrange_speeds(w: Workspace) -> list[Expr]:
    """Return the same by the Hessian of K."""
    return solve(range(-1, w.state.n), w.lagrange_mass, list(_momenta(w)))


def _at(w: Workspace, speeds: Sequence[Expr], entries: Sequence[Expr]) -> list[Expr]:
    """Return functions of q and u as functions of q and p."""
    return substitute(entries, dict(zip(w.state.qd, speeds, strict=True)))


# Hamilton


def _energy(w: Workspace) -> list[Expr]:
    """Return H as half of p·u, and heights along the tree."""
    return [w.graph.dot(_momenta(w), w.once(_speeds)) / 2 + potential_energy(w.reduced) + w.elastic.energy]


def _legendre(w: Workspace) -> list[Expr]:
    """Return H = p·u - L of energies from positions."""
    u = w.once(_lagrange_speeds)
    (L,) = _at(w, u, [w.energy.K - w.energy.P])
    return [w.graph.dot(_momenta(w), u) - L]


def _rates(w: Workspace) -> list[Expr]:
    """Return u and ṗ by the slopes of the kinetic energy."""
    p, moving, u = _momenta(w), Moving.driven(w), w.once(_speeds)
    K, _ = w.energies_by_momentum()
    held = rnea(w.recursion_tree, w.zeros, w.zeros, w.unrotated_loads)
    lost = w.by_states(w.momentum)
    parts = zip(w.directions.slopes(K), moving.drives(), w.pushes, lost, held, w.elastic.forces, strict=True)
    rates = [slope + tau + push + more - weight - pull for slope, tau, push, more, weight, pull in parts]
    for (j, i), terms in w.directions.brackets.items():
        for m, value in terms:
            rates[i] = rates[i] + value * w.state.qd[j] * p[m]
    if w.scene.is_constrained:
        exerted = w.loops.constraint_forces(moving.multipliers())
        rates = [rate + force for rate, force in zip(rates, exerted, strict=True)]
    return [*u, *_at(w, u, rates)]


def _lagrange_rates(w: Workspace) -> list[Expr]:
    """Return u and ṗ = d/dt ∂K/∂u along the motion of Lagrange's equations."""
    u = w.once(_lagrange_speeds)
    moved = dict(zip(w.state.qdd, Moving.driven(w, "lagrange").accelerations(), strict=True))
    seeds = w.state.acceleration | dict(zip(w.states, w.state_rates, strict=True))
    return [*u, *_at(w, u, substitute(tangents(w.energy.momenta(), seeds), moved))]


# Routh


def _cyclic(w: Workspace) -> tuple[int, ...]:
    """Return the cyclic velocities; DerivationError where there is none."""
    if not w.cyclic:
        raise DerivationError(
            f"{w.scene.name}: Routh's function does not exist: no coordinate is cyclic; each has a drive or a force, "
            "or the energies depend on it"
        )
    return w.cyclic


def _routhian(w: Workspace, M: Matrix, parents: Sequence[int], potential: Expr) -> list[Expr]:
    cyclic, p, u = _cyclic(w), _momenta(w), w.state.qd
    left = [k for k in range(w.state.n) if k not in cyclic]
    A = [[M[i][j] for j in cyclic] for i in cyclic]
    known = solve(parents, A, [p[i] - w.graph.total(M[i][j] * u[j] for j in left) for i in cyclic])
    own = w.graph.total(M[i][j] * u[i] * u[j] for i in left for j in left)
    held = w.graph.total(a * x * y for row, x in zip(A, known, strict=True) for a, y in zip(row, known, strict=True))
    return [(own - held) / 2 - potential]


def _routhian_by_recursion(w: Workspace) -> list[Expr]:
    """Return R from M by composite bodies."""
    parents = w.tree.velocity_parents(list(_cyclic(w)))
    return _routhian(w, w.composite_mass, parents, potential_energy(w.reduced) + w.elastic.energy)


def _routhian_by_definition(w: Workspace) -> list[Expr]:
    """Return R = L - Σ p u of energies from positions."""
    cyclic, p, u = _cyclic(w), _momenta(w), w.state.qd
    M = w.lagrange_mass
    rest = [p[i] - w.graph.total(M[i][j] * u[j] for j in range(w.state.n) if j not in cyclic) for i in cyclic]
    known = solve(range(-1, len(cyclic)), [[M[i][j] for j in cyclic] for i in cyclic], rest)
    (L,) = substitute([w.energy.K - w.energy.P], {u[i]: x for i, x in zip(cyclic, known, strict=True)})
    return [L - w.graph.dot([p[i] for i in cyclic], known)]


def _named(w: Workspace) -> str:
    rates = [w.state.rates.index(w.state.qd[k]) for k in w.cyclic]
    return f"; cyclic: {listed([w.scene.coordinates[k] for k in rates])}"


# Gibbs and Appell


def _accelerating(w: Workspace) -> list[Expr]:
    """Return S = u̇·(½ M u̇ + c) by one recursion."""
    return [w.graph.dot(w.state.qdd, w.velocity_forces(list(w.state.qd), [x / 2 for x in w.state.qdd]))]


_row = partial(Output, default_in="request", axes=())

CANONICAL: dict[str, Output] = {
    "hamiltonian": _row(
        "Hamiltonian H(q, p) = p.qd - L = p.M^-1 p / 2 + P(q) of generalized momenta p = M qd",
        ("q", MOMENTA),
        "H",
        units="J",
        when_constrained="same",
        formulations={"recursive": Formulation(_energy), "lagrange": by_lagrange(_legendre)},
        may_fail="reported",
    ),
    "canonical_rates": _row(
        "velocities qd = dH/dp and rates of the generalized momenta, dp/dt = -dH/dq + tau + Q, and G^T lambda of rows",
        ("q", MOMENTA, "tau"),
        "rates",
        axes=(lambda w: (*w.scene.velocities, *(f"rate of momentum of {name}" for name in w.scene.velocities)),),
        units="rad/s or m/s, and N m or N",
        when_constrained="same",
        formulations={"recursive": Formulation(_rates), "lagrange": by_lagrange(_lagrange_rates)},
        may_fail="reported",
        depends=("independent", "alpha", "beta"),
        size=Size((650.0,)),
    ),
    "routhian": _row(
        "Routh's function R = L - sum of p qd over cyclic coordinates, of q, velocities and momenta; those velocities, "
        "and momenta of others, are not read",
        ("q", "qd", MOMENTA),
        "R",
        units="J",
        when_constrained="refuse",
        formulations={
            "recursive": Formulation(_routhian_by_recursion),
            "lagrange": by_lagrange(_routhian_by_definition),
        },
        exists=lambda scene: bool(Workspace(scene).cyclic),
        may_fail="reported",
        remark=_named,
        size=Size((0, 31)),
    ),
    "gibbs_function": _row(
        "function of Gibbs and Appell S = qdd.M qdd / 2 + qdd.c(q, qd), dS/dqdd = M qdd + c",
        ("q", "qd", "qdd"),
        "S",
        units="J/s^2",
        when_constrained="same",
        formulations={"rnea": Formulation(_accelerating), "kane": by_lagrange(lambda w: [w.kane.gibbs_function()])},
    ),
}
"""Rows of the table, which a scene has when it is asked for them."""
