"""Laws of closed mechanisms; they hold off the constraint manifold too, but for the last one.

G T u_i = 0                          the velocities that loops allow; λ does no work on them
G u̇ + Ġ u = 0                        accelerations keep the loops closed
M u̇ + h = τ + Gᵀ λ                   with u̇ and λ from q, u, τ
FD(q, u, ID(q, u, u̇)) = u̇            for every u̇ that the loops allow, where drives and freedoms are equally many
ID(q, u, FD(q, u, τ)) = τ            at the drives, τ zero elsewhere
u·(τ + Q) = d/dt (K + P)             along u̇ for u that the loops allow: multipliers have no power
r(positions(q_i)) = 0                the closed form closes the loops
"""

from __future__ import annotations

from symdyn.dynamics import Workspace
from symdyn.graph import Expr, substitute, tangents
from symdyn.verify.equality import Claim
from symdyn.verify.law import Law, entries, of_loops


def _rows(w: Workspace) -> list[tuple[Expr, ...]]:
    G, n = entries(w, "constraint_jacobian"), w.state.n
    return [G[k : k + n] for k in range(0, len(G), n)]


def _product(w: Workspace, row: tuple[Expr, ...], x: tuple[Expr, ...]) -> Expr:
    return w.graph.total(a * b for a, b in zip(row, x, strict=True))


def _drives(w: Workspace) -> tuple[Expr, ...]:
    """Return τ, at prescribed motions what they take."""
    return entries(w, "drive_forces") if w.prescribed.place else w.state.tau


def _allowed(w: Workspace) -> Claim:
    u = entries(w, "velocities")
    rates = tuple(_product(w, row, u) for row in _rows(w))
    return Claim("velocities", "G qd", "0", rates, (w.graph.zero,) * len(rates))


def _kept_closed(w: Workspace) -> Claim:
    qdd = entries(w, "forward_dynamics")
    left = tuple(_product(w, row, qdd) for row in _rows(w))
    if w.closing.alpha or w.closing.beta:
        right = tuple(-one for one in w.loops.gamma(w.loops.recursive))
        return Claim("accelerations", "G qdd", "-Gdot qd - Baumgarte", left, right)
    return Claim("accelerations", "G qdd", "-Gdot qd", left, tuple(-one for one in entries(w, "constraint_bias")))


def _balance(w: Workspace) -> Claim:
    motion = dict(zip(w.state.qdd, entries(w, "forward_dynamics"), strict=True))
    forces = substitute(entries(w, "tree_forces"), motion)
    pairs = list(zip(_rows(w), entries(w, "multipliers"), strict=True))
    right = tuple(tau + w.graph.total(row[k] * x for row, x in pairs) for k, tau in enumerate(_drives(w)))
    return Claim("multipliers", "M qdd + h", "tau + G^T lambda", tuple(forces), right)


def _forward_of_inverse(w: Workspace) -> Claim | None:
    free = len(w.loops.decisions.partition.independent)
    if (len(w.scene.driven_velocities) or free) != free:
        return None
    reduced = w.loops.motion
    qdd = reduced.spread([w.state.qdd[i] for i in reduced.independent])
    tau = substitute(entries(w, "inverse_dynamics"), dict(zip(w.state.qdd, qdd, strict=True)))
    back = substitute(entries(w, "forward_dynamics"), dict(zip(w.state.tau, tau, strict=True)))
    return Claim("forward dynamics", "FD(q, qd, ID(q, qd, qdd))", "qdd", tuple(back), tuple(qdd))


def _inverse_of_forward(w: Workspace) -> Claim | None:
    driven = w.scene.driven_velocities or list(w.loops.decisions.partition.independent)
    passive = {tau: w.graph.zero for k, tau in enumerate(w.state.tau) if k not in driven}
    qdd = substitute(entries(w, "forward_dynamics"), passive)
    back = substitute(entries(w, "inverse_dynamics"), dict(zip(w.state.qdd, qdd, strict=True)))
    drives = substitute(_drives(w), passive)
    tau = tuple(drives[k] if k in driven else w.graph.zero for k in range(w.state.n))
    return Claim("inverse dynamics", "ID(q, qd, FD(q, qd, tau))", "tau", tuple(back), tau)


def _power(w: Workspace) -> Claim:
    (K,), (P,), s = entries(w, "kinetic_energy"), entries(w, "potential_energy"), w.state
    free = w.loops.decisions.partition.independent
    allowed = dict(zip(s.qd, entries(w, "velocities"), strict=True))
    others = {qd: x for k, (qd, x) in enumerate(allowed.items()) if k not in free}
    moving = s.velocity | dict(zip(s.qd, entries(w, "forward_dynamics"), strict=True))
    power = w.graph.total((t + force) * qd for t, force, qd in zip(_drives(w), w.Q, s.qd, strict=True))
    (rate,) = tangents([K + P], moving)
    left, right = substitute([power, rate], others)
    return Claim("power balance", "qd.(tau + Q)", "d(K + P)/dt", (left,), (right,))


def _closed(w: Workspace) -> Claim:
    q = dict(zip(w.state.q, entries(w, "positions"), strict=True))
    left = substitute(entries(w, "constraint_residual"), q)
    return Claim("positions", "residual", "0", tuple(left), (w.graph.zero,) * len(left))


LAWS_OF_LOOPS: tuple[Law, ...] = (
    of_loops(_allowed, "velocities", "constraint_jacobian"),
    of_loops(_kept_closed, "forward_dynamics", "constraint_jacobian", "constraint_bias"),
    of_loops(_balance, "forward_dynamics", "multipliers", "tree_forces", "constraint_jacobian"),
    of_loops(_forward_of_inverse, "forward_dynamics", "inverse_dynamics"),
    of_loops(_inverse_of_forward, "forward_dynamics", "inverse_dynamics"),
    of_loops(_power, "forward_dynamics", "velocities", "kinetic_energy", "potential_energy"),
    of_loops(_closed, "positions", "constraint_residual"),
)
