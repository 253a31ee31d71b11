"""Laws of reactions as claims; the momentum that they are compared with comes from positions, differentiated.

The first law is D'Alembert's: the reactions, which recursion found, are a solution of the whole system (5.18) with
every component of every joint. Where that has one solution they are it; where it has more, they differ from any other
by what is in equilibrium with itself.

R, S     a reaction and the relative motion of its joint for unit velocities, at the origin of the moved frame
p, L     momentum, and angular momentum about the origin of the ground: ∫ r × ṙ dm
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from fractions import Fraction

from symdyn.dynamics import Workspace
from symdyn.dynamics.mechanism import body_placements, vector
from symdyn.dynamics.reactions import Equilibrium, JointFrames
from symdyn.errors import DerivationError
from symdyn.graph import Expr, substitute, tangents
from symdyn.scene.forces import without_place
from symdyn.spatial import (
    Inertia,
    Mat,
    Transform,
    Wrench,
    add,
    cross,
    scale,
)
from symdyn.verify.equality import Claim
from symdyn.verify.law import Law, entries, everywhere, of_loops


def _reactions(w: Workspace) -> list[Wrench]:
    """Return the derived reactions, axes of the child bodies."""
    return _wrenches(entries(w, "reactions"))


def _wrenches(R: Sequence[Expr]) -> list[Wrench]:
    return [Wrench((R[k], R[k + 1], R[k + 2]), (R[k + 3], R[k + 4], R[k + 5])) for k in range(0, len(R), 6)]


def _motion(w: Workspace) -> dict[Expr, Expr] | None:
    """Return accelerations that are possible: any, where no velocity is without both a drive and a say in the loops.

    Else those that driving forces give; None where forward dynamics does not exist.
    """
    if not w.scene.is_closed or len(w.scene.undriven_velocities) == len(w.loops.decisions.kept):
        return {}
    passive = {w.state.tau[k]: w.graph.zero for k in w.scene.undriven_velocities}
    try:
        moved = substitute(entries(w, "forward_dynamics"), passive)
    except DerivationError:
        return None
    return dict(zip(w.state.qdd, moved, strict=True))


def _contacts(w: Workspace) -> list[tuple[JointFrames, Wrench]]:
    """Return contacts with what they exert on their bodies, axes of the bodies."""
    hanging, first = w.hanging, len(w.hanging.loops)
    total = [Wrench.none(w.graph)] * len(hanging.cuts)
    for one, size in w.hanging.carried() if w.scene.is_closed else []:
        if one.wrench is not None:
            total[one.loop] = total[one.loop] + one.wrench.scaled(size)
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
    for one, size in w.hanging.carried() if w.scene.is_closed else []:
        if one.wrench is None:  # what keeps a formula goes through the joints of its velocities
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
        twists = zip(hinge.velocities, hinge.S, strict=True)
        if hinge in hanging.cuts:
            terms += [here.power(twist) * u[k] for k, twist in hanging.relative_twists(hinge).items()]
        terms += [hinge.ratio * here.power(twist) * u[k] for k, twist in twists]
    tau = entries(w, "inverse_dynamics")
    given = [t * v for t, v in zip(tau, u, strict=True)]
    for hinge in hanging.joints:
        pushes = zip(hinge.rates, hanging.own_forces(hinge), strict=True)
        given += [rate * force for rate, force in pushes]
    sides = substitute([graph.total(terms), graph.total(given)], motion)
    if w.scene.is_closed:
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
