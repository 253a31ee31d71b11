"""Laws of mechanics as claims about the derived equations; each is proved for the scene at hand, not sampled.

    M = ∂²K/∂q̇²                         the mass matrix is the Hessian of the kinetic energy
    Ṁ = C + Cᵀ                           so that Ṁ - 2C is skew
    C q̇ = c
    ∂P/∂q = g + k_E
    τ = k_z q̈ + k_C q̇q̇ + k_D q̇² + k_G + k_E - Q      the textbook's sum, with this product's signs
    q̇·(τ + Q) = d/dt (K + P)            power in is the rate of energy
    FD(q, q̇, ID(q, q̇, q̈)) = q̈          forward dynamics inverts inverse dynamics, prescribed motions in q̈
    Y π = τ, dC/dt = J u, p = m J u      regressors, centre of mass and momentum: see `claims.py`
    H, R, S, feedback linearisation      see `laws_of_functions.py`
    contacts that open and close         see `laws_of_contacts.py`

Reactions are compared with momentum that comes from positions, differentiated:

    S·R = τ + Q                          along its joint's freedom a reaction is the drive and the joint's own forces
    Σ R·(S q̇) = (τ + Q)·q̇               all the rest of the reactions has no power in any motion that the loops allow
    Σ R + Σ loads = d/dt [p; L]          reactions of the ground and loads change momentum and angular momentum

    R, S     a reaction and the relative motion of its joint for unit velocities, at the origin of the moved frame
    p, L     momentum, and angular momentum about the origin of the ground: ∫ r × ṙ dm

The first law of reactions is D'Alembert's: the reactions, which recursion found, are a solution of the whole system
(5.18) with every component of every joint. If that has only one solution, they are it; if it has more, they differ from
any other by what is in equilibrium with itself.

Closed mechanisms; all but the last one hold off the constraint manifold too:

    G T u_i = 0                          the velocities that loops allow; λ does no work on them
    G u̇ + Ġ u = 0                        accelerations keep the loops closed
    M u̇ + h = τ + Gᵀ λ                   with u̇ and λ from q, u, τ
    FD(q, u, ID(q, u, u̇)) = u̇            for every u̇ that the loops allow, where drives and freedoms are equally many
    ID(q, u, FD(q, u, τ)) = τ            at the drives, τ zero elsewhere
    u·(τ + Q) = d/dt (K + P)             along u̇ for u that the loops allow: multipliers have no power
    r(positions(q_i)) = 0                the closed form closes the loops
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from math import prod

from symdyn.dynamics import Workspace, coefficients
from symdyn.dynamics.mechanism import body_placements, vector
from symdyn.dynamics.reactions import Equilibrium, JointFrames
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient, substitute, tangents
from symdyn.scene.forces import elastic, without_place
from symdyn.spatial import Inertia, Mat, Transform, Wrench, add, cross, scale
from symdyn.verify.claims import (
    LAWS_OF_MOMENTUM,
    LAWS_OF_REGRESSORS,
    Law,
    driving,
    entries,
    everywhere,
    of_driving,
    of_loops,
    product,
)
from symdyn.verify.equality import Claim
from symdyn.verify.laws_of_contacts import LAWS_OF_CONTACTS
from symdyn.verify.laws_of_functions import LAWS_OF_ARMS, LAWS_OF_CANONICAL, LAWS_OF_LINEARIZING


def _drives(w: Workspace) -> tuple[Expr, ...]:
    """Return τ, at prescribed motions what they take."""
    return entries(w, "drive_forces") if w.prescribed.place else w.state.tau


def _allowed(w: Workspace) -> Claim:
    rates = tuple(product(w, entries(w, "constraint_jacobian"), entries(w, "velocities")))
    return Claim("velocities", "G qd", "0", rates, (w.graph.zero,) * len(rates))


def _kept_closed(w: Workspace) -> Claim:
    left = tuple(product(w, entries(w, "constraint_jacobian"), entries(w, "forward_dynamics")))
    if w.closing.alpha or w.closing.beta:
        right = tuple(-one for one in w.loops.gamma(w.loops.recursive))
        return Claim("accelerations", "G qdd", "-Gdot qd - Baumgarte", left, right)
    return Claim("accelerations", "G qdd", "-Gdot qd", left, tuple(-one for one in entries(w, "constraint_bias")))


def _balance(w: Workspace) -> Claim:
    motion = dict(zip(w.state.qdd, entries(w, "forward_dynamics"), strict=True))
    forces = substitute(entries(w, "tree_forces"), motion)
    G, x, n = entries(w, "constraint_jacobian"), entries(w, "multipliers"), w.state.n
    exerted = (w.graph.dot(G[k::n], x) for k in range(n))
    right = tuple(tau + force for tau, force in zip(_drives(w), exerted, strict=True))
    return Claim("multipliers", "M qdd + h", "tau + G^T lambda", tuple(forces), right)


def _forward_of_inverse(w: Workspace) -> Claim | None:
    free = len(w.loops.decisions.partition.independent)
    if (len(w.scene.actuated_velocities) or free) != free:
        return None
    reduced = w.loops.motion
    qdd = reduced.expand([w.state.qdd[i] for i in reduced.independent])
    tau = substitute(entries(w, "inverse_dynamics"), dict(zip(w.state.qdd, qdd, strict=True)))
    back = substitute(entries(w, "forward_dynamics"), dict(zip(w.state.tau, tau, strict=True)))
    return Claim("forward dynamics", "FD(q, qd, ID(q, qd, qdd))", "qdd", tuple(back), tuple(qdd))


def _inverse_of_forward(w: Workspace) -> Claim | None:
    driven = w.scene.actuated_velocities or list(w.loops.decisions.partition.independent)
    passive = {tau: w.graph.zero for k, tau in enumerate(w.state.tau) if k not in driven}
    qdd = substitute(entries(w, "forward_dynamics"), passive)
    back = substitute(entries(w, "inverse_dynamics"), dict(zip(w.state.qdd, qdd, strict=True)))
    drives = substitute(_drives(w), passive)
    tau = tuple(drives[k] if k in driven else w.graph.zero for k in range(w.state.n))
    return Claim("inverse dynamics", "ID(q, qd, FD(q, qd, tau))", "tau", tuple(back), tau)


def _power_of_loops(w: Workspace) -> Claim:
    (K,), (P,), s = entries(w, "kinetic_energy"), entries(w, "potential_energy"), w.state
    free = w.loops.decisions.partition.independent
    allowed = dict(zip(s.qd, entries(w, "velocities"), strict=True))
    others = {qd: x for k, (qd, x) in enumerate(allowed.items()) if k not in free}
    moving = s.velocity | dict(zip(s.qd, entries(w, "forward_dynamics"), strict=True))
    power = w.graph.total((t + force) * qd for t, force, qd in zip(_drives(w), w.Q, s.qd, strict=True))
    (rate,) = tangents([K + P], moving)
    left, right = substitute([power + _brought_in(w, P), rate], others)
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
    of_loops(_power_of_loops, "forward_dynamics", "velocities", "kinetic_energy", "potential_energy"),
    of_loops(_closed, "positions", "constraint_residual"),
)


def _reactions(w: Workspace) -> list[Wrench]:
    R = entries(w, "reactions")
    return [Wrench((R[k], R[k + 1], R[k + 2]), (R[k + 3], R[k + 4], R[k + 5])) for k in range(0, len(R), 6)]


def _motion(w: Workspace) -> dict[Expr, Expr] | None:
    """Return accelerations that are possible: any, where no velocity is without both a drive and a say in the loops.

    Else those that driving forces give; None where forward dynamics does not exist.
    """
    if not w.scene.is_constrained or len(w.scene.passive_velocities) == len(w.loops.decisions.independent_rows):
        return {}
    passive = {w.state.tau[k]: w.graph.zero for k in w.scene.passive_velocities}
    try:
        moved = substitute(entries(w, "forward_dynamics"), passive)
    except DerivationError:
        return None
    return dict(zip(w.state.qdd, moved, strict=True))


def _contacts(w: Workspace) -> list[tuple[JointFrames, Wrench]]:
    """Return contacts with what they exert on their bodies, axes of the bodies."""
    hanging, first = w.hanging, len(w.hanging.loops)
    total = [Wrench.none(w.graph)] * len(hanging.cuts)
    for one, size in w.hanging.carried() if w.scene.is_constrained else []:
        for number, wrench in one.acts:
            total[number] = total[number] + wrench.scaled(size)
    return [(hinge, hinge.on_child(wrench)) for hinge, wrench in zip(hanging.cuts[first:], total[first:], strict=True)]


def _equilibrium(w: Workspace) -> Claim | None:
    """(5.18) is met by the reactions, whatever else may meet it; where it has one solution, they are that."""
    motion = _motion(w)
    if motion is None:
        return None
    return _met(w, Equilibrium.of(w.hanging, whole=True), entries(w, "reactions"), motion, "reactions")


def _forward_equilibrium(w: Workspace) -> Claim | None:
    """(5.18) is met by the reactions of forward dynamics, with the drives given.

    Of trees it is the same recursion, and no multiplier in it.
    """
    if without_place(w.scene):
        return None
    tau = entries(w, "drive_forces") if w.prescribed.place else w.state.tau
    motion = dict(zip(w.state.qdd, entries(w, "forward_dynamics"), strict=True))
    R = entries(w, "forward_reactions")
    return _met(w, Equilibrium.of(w.hanging, tau=tau, whole=True), R, motion, "forward_reactions")


def _met(w: Workspace, system: Equilibrium, R: Sequence[Expr], motion: Mapping[Expr, Expr], name: str) -> Claim:
    """Return the claim that there are sizes x of all unknowns with A x + b = 0 whose wrenches are R."""
    rows = [*system.rows(), *system.wrench_rows(R)]
    if motion:
        found = iter(substitute([entry for row in rows for entry in row.values()], motion))
        rows = [{c: next(found) for c in row} for row in rows]
    return Claim.solvable(name, "recursive", "equilibrium (5.18) of every body", rows, len(system.unknowns))


def drives_in_reactions(w: Workspace) -> Claim | None:
    """Return that along its freedoms a joint's reaction is the drive, and what its own elements do."""
    motion = _motion(w)
    if motion is None:
        return None
    driving = w.hanging.driving(w.hanging.felt(_reactions(w)[: len(w.scene.joints)]))
    tau = list(entries(w, "inverse_dynamics"))
    for one, size in w.hanging.carried() if w.scene.is_constrained else []:
        if not one.acts:  # what keeps a formula goes through the joints of its velocities
            tau = [force + size * x for force, x in zip(tau, one.G, strict=True)]
    sides = substitute([*driving, *tau], motion)
    return Claim("drives in reactions", "S.R - Q of joints", "tau", tuple(sides[: len(tau)]), tuple(sides[len(tau) :]))


def power_of_reactions(w: Workspace) -> Claim | None:
    """Return that all the rest of the reactions is without power in any motion that the loops allow."""
    motion = _motion(w)
    if motion is None:
        return None
    hanging, u, graph = w.hanging, w.state.qd, w.graph
    terms = []
    for hinge, R in [*zip((*hanging.joints, *hanging.loops), _reactions(w), strict=True), *_contacts(w)]:
        here = hinge.in_joint_axes(R)
        if hinge in hanging.cuts:
            terms += [here.power(twist) * u[k] for k, twist in hanging.relative_twists(hinge).items()]
        terms += [ratio * here.power(hinge.S[own]) * u[k] for k, own, ratio in hinge.moved_by]
    tau = entries(w, "inverse_dynamics")
    given = [t * v for t, v in zip(tau, u, strict=True)]
    for hinge in hanging.joints:
        pushes = zip(hinge.rates, hanging.own_forces(hinge), strict=True)
        given += [rate * force for rate, force in pushes]
    sides = substitute([graph.total(terms), graph.total(given)], motion)
    if w.scene.is_constrained:
        sides = substitute(sides, dict(zip(u, entries(w, "velocities"), strict=True)))
    return Claim("power of reactions", "R.(relative motion)", "(tau + Q of joints).qd", (sides[0],), (sides[1],))


def momentum(w: Workspace) -> Claim:
    """Return that what the ground exerts, with weight and loads, changes momentum and angular momentum."""
    hanging, graph, state = w.hanging, w.graph, w.state
    placed = body_placements(w.scene, graph)
    total = Wrench.none(graph)
    for hinge, R in [*zip((*hanging.joints, *hanging.loops), _reactions(w), strict=True), *_contacts(w)]:
        if (hinge.parent < 0) == (hinge.child < 0):
            continue  # between two moving bodies: action = reaction
        T = placed[hinge.joint.child]
        exerted = R.rotated(T.R).about(T.point(hinge.place_on_child))
        total = total + (exerted if hinge.parent < 0 else -exerted)
    gravity = vector(w.scene.gravity, graph)
    p, L = [graph.zero] * 3, [graph.zero] * 3
    for body, I, load in zip(w.scene.bodies, hanging.inertias, hanging.acting, strict=True):  # noqa: E741  the book's
        T = placed[body.name]
        h = add(T.R @ I.h, scale(I.m, T.p))
        weight = Wrench(scale(I.m, gravity), cross(h, gravity))
        total = total + (weight + load.rotated(T.R).about(T.p))
        p = [a + b for a, b in zip(p, tangents(h, state.velocity), strict=True)]
        L = [a + b for a, b in zip(L, _angular(w, I, T), strict=True)]
    rates = tangents([*p, *L], state.acceleration)
    return Claim("momentum", "R of the ground + loads", "d/dt [p; L]", (*total[0], *total[1]), tuple(rates))


def _angular(w: Workspace, body: Inertia, T: Transform) -> list[Expr]:
    """Return ∫ r × ṙ dm from ∫ r ṙᵀ dm, with ∫ x xᵀ dm = ½ tr(I) 1 - I in the body."""
    graph, m, h, I, R, p = w.graph, body.m, body.h, body.I, T.R, T.p  # noqa: E741  the book's name
    half = (I[0][0] + I[1][1] + I[2][2]) * Fraction(1, 2)
    spread = Mat.identity(graph).scaled(half) + I.scaled(-1)
    rates = tangents([*R[0], *R[1], *R[2], *p], w.state.velocity)
    turning = Mat(((rates[0], rates[1], rates[2]), (rates[3], rates[4], rates[5]), (rates[6], rates[7], rates[8])))
    moving = (rates[9], rates[10], rates[11])
    A = R @ spread @ turning.T
    A = A + Mat.outer(R @ h, moving)
    A = A + Mat.outer(p, add(turning @ h, scale(m, moving)))
    return [A[1][2] - A[2][1], A[2][0] - A[0][2], A[0][1] - A[1][0]]


def claims_of_reactions(w: Workspace) -> dict[str, Claim]:
    """Return what can be claimed of all reactions: drives in "joints", their "power" and the "momentum"."""
    found = {}
    for name, law in (("joints", drives_in_reactions), ("power", power_of_reactions), ("momentum", momentum)):
        with suppress(DerivationError):  # reactions are not unique
            if (claim := law(w)) is not None:
                found[name] = claim
    return found


LAWS_OF_REACTIONS: tuple[Law, ...] = (
    everywhere(_equilibrium, "reactions"),
    of_loops(_forward_equilibrium, "forward_dynamics", "multipliers"),
    everywhere(drives_in_reactions, "reactions", "inverse_dynamics"),
    everywhere(power_of_reactions, "reactions", "inverse_dynamics"),
    everywhere(momentum, "reactions"),
)


def laws(workspace: Workspace, outputs: Collection[str]) -> list[Claim]:
    """Return the laws about `outputs` as claims.

    A law that needs another output is left out.

    Raises:
        DerivationError: an output does not exist, such as forward dynamics where M is singular.
    """
    claims = (law.claim(workspace) for law in LAWS if law.fits(workspace.scene, outputs))
    return [claim for claim in claims if claim is not None]


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
    moved = tuple(product(w, entries(w, "coriolis_matrix"), w.state.qd))
    return Claim("velocity forces", "C qd", "c", moved, entries(w, "velocity_forces"))


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
    right = driving(w)
    pulled = " + k_E" if elastic(w.scene) else ""
    return Claim("coefficients", f"k_z qdd + k_C qd qd + k_D qd^2 + k_G{pulled} - Q", "tau", tuple(sums), right)


def _power(w: Workspace) -> Claim:
    (K,), (P,) = entries(w, "kinetic_energy"), entries(w, "potential_energy")
    s, tau = w.state, driving(w)
    power = w.graph.total((t + force) * qd for t, force, qd in zip(tau, w.Q, s.qd, strict=True))
    left, rate = power + _brought_in(w, P), tangents([K + P], s.acceleration)
    return Claim("power balance", "qd.(tau + Q)", "d(K + P)/dt", (left,), tuple(rate))


def _brought_in(w: Workspace, P: Expr) -> Expr:
    """Return the power that ends of springs bring in which move as they are told, W."""
    return tangents([P], w.state.clock)[0] if w.state.clock else w.graph.zero


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
    of_driving(_textbook, "k_z", "k_C", "k_D", "k_G"),
    of_driving(_power, "kinetic_energy", "potential_energy"),
    Law(("inverse_dynamics", "forward_dynamics"), None, _inverse),
    *LAWS_OF_LOOPS,
    *LAWS_OF_REACTIONS,
    *LAWS_OF_MOMENTUM,
    *LAWS_OF_REGRESSORS,
    *LAWS_OF_CANONICAL,
    *LAWS_OF_LINEARIZING,
    *LAWS_OF_ARMS,
    *LAWS_OF_CONTACTS,
]
"""The laws that are proved; those of trees hold for the spanning tree of a closed scene, with the forces on it."""
