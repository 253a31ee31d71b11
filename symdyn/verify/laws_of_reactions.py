"""Laws of reactions as claims; the momentum that they are compared with comes from positions, differentiated.

R, S     a reaction and the relative motion of its joint for unit velocities, at the origin of the moved frame
p, L     momentum, and angular momentum about the origin of the ground: ∫ r × ṙ dm
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.positions import body_placements
from symdyn.dynamics.reactions.hinges import about, nothing, plus, power, relative_twists
from symdyn.dynamics.reactions.members import acting, own_forces
from symdyn.dynamics.reactions.ties import ties, undriven
from symdyn.dynamics.state import vector
from symdyn.dynamics.tree import body_inertia
from symdyn.graph import Expr, substitute, tangents
from symdyn.scene.joints import Wrench
from symdyn.spatial import (
    Inertia,
    Transform,
    add,
    add_matrices,
    apply,
    cross,
    identity,
    multiply,
    neg,
    outer,
    scale,
    scale_matrix,
)
from symdyn.spatial import transpose as transposed
from symdyn.verify.equality import Claim


def _reactions(w: Workspace) -> list[Wrench]:
    """Return the derived reactions, axes of the child bodies."""
    R = derive_one(w, "reactions").entries
    return [((R[k], R[k + 1], R[k + 2]), (R[k + 3], R[k + 4], R[k + 5])) for k in range(0, len(R), 6)]


def _is_settled(w: Workspace) -> bool:
    """Whether every passive velocity takes part in finding what the loops transmit, so that none is without force."""
    return not (w.scene.loops or w.scene.rows) or len(undriven(w.scene)) == len(ties(w.hanging))


def _drives(w: Workspace) -> Claim | None:
    if not _is_settled(w) or w.scene.rows:
        return None
    driving = w.hanging.driving(w.hanging.felt(_reactions(w)[: len(w.scene.joints)]))
    tau = derive_one(w, "inverse_dynamics").entries
    return Claim("drives in reactions", "S.R - Q of joints", "tau", tuple(driving), tau)


def _power(w: Workspace) -> Claim | None:
    if not _is_settled(w):
        return None
    hanging, u, graph = w.hanging, w.state.qd, w.graph
    terms = []
    for hinge, R in zip((*hanging.joints, *hanging.loops), _reactions(w), strict=True):
        here = hinge.in_joint_axes(R)
        twists = zip(hinge.velocities, hinge.S, strict=True)
        if hinge in hanging.loops:
            terms += [power(here, twist) * u[k] for k, twist in relative_twists(hinge, hanging.joints).items()]
        terms += [hinge.ratio * power(here, twist) * u[k] for k, twist in twists]
    tau = derive_one(w, "inverse_dynamics").entries
    given = [t * v for t, v in zip(tau, u, strict=True)]
    for hinge in hanging.joints:
        pushes = zip(hinge.rates, own_forces(w.scene, hinge, w.state), strict=True)
        given += [rate * force for rate, force in pushes]
    sides = [graph.total(terms), graph.total(given)]
    if w.scene.loops or w.scene.rows:
        sides = substitute(sides, dict(zip(u, derive_one(w, "velocities").entries, strict=True)))
    return Claim("power of reactions", "R.(relative motion)", "(tau + Q of joints).qd", (sides[0],), (sides[1],))


def _momentum(w: Workspace) -> Claim | None:
    hanging, graph, state = w.hanging, w.graph, w.state
    if len(hanging.cuts) > len(hanging.loops):
        return None  # what the ground exerts in a contact is in no row
    placed = body_placements(w.scene, graph)
    total = nothing(graph)
    for hinge, R in zip((*hanging.joints, *hanging.loops), _reactions(w), strict=True):
        if (hinge.parent < 0) == (hinge.child < 0):
            continue  # between two moving bodies: action = reaction
        T = placed[hinge.joint.child]
        force, moment = about((apply(T.R, R[0]), apply(T.R, R[1])), T.point(hinge.place_on_child))
        total = plus(total, (force, moment) if hinge.parent < 0 else (neg(force), neg(moment)))
    gravity = vector(w.scene.gravity, graph)
    pushed = acting(w.scene, hanging.joints, state)
    p, L = [graph.zero] * 3, [graph.zero] * 3
    for body, load in zip(w.scene.bodies, pushed, strict=True):
        I, T = body_inertia(body, graph), placed[body.name]  # noqa: E741  the book's name
        h = add(apply(T.R, I.h), scale(I.m, T.p))
        weight = scale(I.m, gravity), cross(h, gravity)
        total = plus(total, plus(weight, about((apply(T.R, load[0]), apply(T.R, load[1])), T.p)))
        p = [a + b for a, b in zip(p, tangents(h, state.velocity), strict=True)]
        L = [a + b for a, b in zip(L, _angular(w, I, T), strict=True)]
    rates = tangents([*p, *L], state.acceleration)
    return Claim("momentum", "R of the ground + loads", "d/dt [p; L]", (*total[0], *total[1]), tuple(rates))


def _angular(w: Workspace, body: Inertia, T: Transform) -> list[Expr]:
    """Return ∫ r × ṙ dm from ∫ r ṙᵀ dm, with ∫ x xᵀ dm = ½ tr(I) 1 - I in the body."""
    graph, m, h, I, R, p = w.graph, body.m, body.h, body.I, T.R, T.p  # noqa: E741  the book's name
    half = (I[0][0] + I[1][1] + I[2][2]) * Fraction(1, 2)
    spread = add_matrices(scale_matrix(half, identity(graph)), scale_matrix(-1, I))
    rates = tangents([*R[0], *R[1], *R[2], *p], w.state.velocity)
    turning = ((rates[0], rates[1], rates[2]), (rates[3], rates[4], rates[5]), (rates[6], rates[7], rates[8]))
    moving = (rates[9], rates[10], rates[11])
    A = multiply(multiply(R, spread), transposed(turning))
    A = add_matrices(A, outer(apply(R, h), moving))
    A = add_matrices(A, outer(p, add(apply(turning, h), scale(m, moving))))
    return [A[1][2] - A[2][1], A[2][0] - A[0][2], A[0][1] - A[1][0]]


LAWS_OF_REACTIONS: tuple[tuple[tuple[str, ...], Callable[[Workspace], Claim | None]], ...] = (
    (("reactions", "inverse_dynamics"), _drives),
    (("reactions", "inverse_dynamics"), _power),
    (("reactions",), _momentum),
)
"""Each law with the outputs that it is about; None where it says nothing about a scene."""
