"""Forces from a function V of the state: damping of what drives do to it, and shaping of the energy that it is.

V is an output of the scene, its rate along the motion affine in driving forces, V' = L_f V + L_g V τ:

    damping   τ = -(L_g V)ᵀ            V' = L_f V - |τ|²; of V = ½ (E - E_0)², swinging up by energy
    shaping   L_f V + L_g V τ = 0      for all q, u without losses, V = ½ u·N(q) u + V_d(q)

L_g V = Γ(q) u then, a linear form for each drive, and L_f V, of third degree in u, has to vanish with it. That is what
matching conditions of interconnection and damping assignment ask of M_d = M N⁻¹ M and V_d: ṗ = -M_d M⁻¹ ∂H_d/∂q +
J_2 M_d⁻¹ p for some skew J_2, whatever it is. It is decided over a finite field; then

    τ = -∫ (Γ⁺)ᵀ ∇_u L_f V(w + s (u - w)) ds,  s from 0 to 1,   w = u - Γ⁺ Γ u,   Γ⁺ = Γᵀ (Γ Γᵀ)⁻¹

by Simpson's rule, exact for polynomials of second degree. Of one drive it is the only such force; of several the others
differ by forces that do no work on V. What is lost (friction, loads, declared forces) is not balanced.

References: Åström and Furuta, Swinging up a pendulum by energy control, Automatica 36 (2000) 287; Jurdjevic and Quinn,
Controllability and stability, J. Differential Equations 28 (1978) 381; Ortega, Spong, Gómez-Estern and Blankenstein,
Stabilization of a class of underactuated mechanical systems via interconnection and damping assignment, IEEE
Transactions on Automatic Control 47 (2002) 1218.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.mechanism.linear_solve import Singular, solve, vanishes
from symdyn.dynamics.mechanism.state import refuse_ideal_friction
from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.linearizing_outputs import drive_columns, of_signal, rate_of
from symdyn.dynamics.outputs.output import FORCES, Output
from symdyn.dynamics.outputs.signal_outputs import SIGNALS
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute, tangents


def _spread(w: Workspace, forces: Sequence[Expr]) -> list[Expr]:
    """Return forces of the drives, of all that may have one where none has, as forces of all velocities."""
    found = [w.graph.zero] * w.state.n
    for k, force in zip(drive_columns(w), forces, strict=True):
        found[k] = force
    return found


def _refused(w: Workspace, name: str, why: str) -> DerivationError:
    return DerivationError(f"{w.scene.name}: output {name} {why}")


def _damping(w: Workspace, name: str, formulation: str) -> list[Expr]:
    """Return -(L_g V)ᵀ."""
    refuse_ideal_friction(w.scene)
    rate = rate_of(w, name, formulation)
    slopes = gradient(rate, [w.state.tau[k] for k in drive_columns(w)])
    if all(map(vanishes, slopes)):
        raise _refused(w, name, "has no drive in its rate; take one that velocities are in, such as an energy")
    return _spread(w, [-x for x in slopes])


@dataclass(frozen=True)
class _Shaped:
    """What drives and the motion without losses do to V: L_f V, L_g V, and Γ⁺ column by column."""

    V: Expr
    own: Expr
    worked: list[Expr]
    inverse: list[list[Expr]]


def _shaped(w: Workspace, name: str, formulation: str) -> _Shaped:
    """Return what shaping needs.

    Raises:
        DerivationError: V is no such function, or drives do not work on it each in a way of its own.
    """
    scene, graph, u = w.scene, w.graph, w.state.qd
    if scene.prescribed_velocities:
        raise _refused(w, name, "is shaped where no motion is prescribed; give that joint a drive")
    (V,) = SIGNALS["output"].formulations[formulation].derive(w, name)
    still, double = (substitute([V], {x: factor * x for x in u})[0] for factor in (graph.zero, graph.one * 2))
    (back,) = substitute([V], {x: -x for x in u})
    letters = {*w.state.q, *u, *(graph.symbol(one.name) for one in scene.parameters)}
    if any(x.op.name == "SYMBOL" and x not in letters for x in reachable([V])):
        raise _refused(w, name, "is no function of coordinates, velocities and parameters alone, as a shaped energy is")
    if not (vanishes(back - V) and vanishes(double - 4 * V + 3 * still)):
        raise _refused(w, name, "is no shaped energy: that is quadratic in velocities, u.N(q) u/2 + V(q)")
    rest = dict.fromkeys(w.state.qdd, graph.zero)
    recursive = formulation == "recursive"
    if recursive:
        parts = zip(w.velocity_forces(list(u)), w.gravity_forces, w.elastic.forces, strict=True)
        held = [c + g + k for c, g, k in parts]
    else:
        held = [x + Q for x, Q in zip(substitute(w.energy.driving_forces(), rest), w.Q, strict=True)]
    tau = _spread(w, [w.state.tau[k] for k in drive_columns(w)])
    parents = w.tree.velocity_parents() if recursive else range(-1, w.state.n)
    moved = solve(
        parents, w.composite_mass if recursive else w.lagrange_mass, [a - b for a, b in zip(tau, held, strict=True)]
    )
    (rate,) = tangents([V], w.state.velocity | dict(zip(u, moved, strict=True)))
    drives = [w.state.tau[k] for k in drive_columns(w)]
    own, *worked = substitute([rate, *gradient(rate, drives)], dict.fromkeys(w.state.tau, graph.zero))
    G = [gradient(x, u) for x in worked]
    square = [[graph.total(a * b for a, b in zip(x, y, strict=True)) for y in G] for x in G]
    try:
        unit = [[graph.one if i == j else graph.zero for j in range(len(G))] for i in range(len(G))]
        solved = [solve(range(-1, len(G)), square, side) for side in unit]
    except Singular as fault:
        raise _refused(
            w, name, "does not feel every drive in a way of its own, so none of them can shape it"
        ) from fault
    inverse = [[graph.total(x[j] * s for x, s in zip(G, one, strict=True)) for j in range(w.state.n)] for one in solved]
    return _Shaped(V, own, worked, inverse)


def _shaping(w: Workspace, name: str, formulation: str) -> list[Expr]:
    """Return the forces that keep V where nothing is lost."""
    graph, u = w.graph, w.state.qd
    found: _Shaped = w.once(_shaped, name, formulation)
    along = [
        graph.total(column[j] * x for column, x in zip(found.inverse, found.worked, strict=True))
        for j in range(w.state.n)
    ]
    idle = {x: x - y for x, y in zip(u, along, strict=True)}
    (left,) = substitute([found.own], idle)
    if not vanishes(left):
        raise _refused(w, name, _unmatched(w, name, left))
    slopes = gradient(found.own, u)
    ends, middle = (substitute(slopes, {x: x - y * part for x, y in zip(u, along, strict=True)})
                    for part in (graph.one, graph.one / 2))  # fmt: skip
    mean = [(a + 4 * b + c) / 6 for a, b, c in zip(ends, middle, slopes, strict=True)]
    return _spread(w, [-graph.total(x * y for x, y in zip(one, mean, strict=True)) for one in found.inverse])


def _unmatched(w: Workspace, name: str, left: Expr) -> str:
    """Return which part does not match, and a state that shows it."""
    from symdyn.algebra import Floats  # with NumPy, which what asks for no shaping can do without

    u, graph = w.state.qd, w.graph
    slow = substitute(gradient(left, u), dict.fromkeys(u, graph.zero))
    part = "kinetic" if all(map(vanishes, slow)) else "potential"
    known = {one.name: None if one.value is None else one.value.at({}) for one in w.scene.parameters}
    values = {graph.symbol(name): 1.0 if value is None else float(value) for name, value in known.items()}
    values |= {q: round(0.3 + 0.2 * k, 1) for k, q in enumerate(w.state.q)}
    values |= {x: round(1 - 0.4 * k, 1) for k, x in enumerate(u)}
    idle = [values[x] for x in u]
    (rate,) = evaluate([left], Floats(), values)
    at = ", ".join(f"{x.value} = {values[x]:g}" for x in w.state.q)
    return (
        f"does not match: its {part} energy cannot be kept, for it changes where no drive works on it; by {rate:.6g} a "
        f"second at {at} and the part of qd = {idle} that no drive works on"
    )


_OF = "of a shaped energy, quadratic in velocities"

SHAPING: dict[str, Output] = {
    "damping_forces": of_signal(
        "output",
        "driving forces -(dV'/dtau)^T, by the square of which the rate V' falls, times a gain,",
        _damping,
        FORCES,
        result="tau",
        arguments=("q", "qd"),
        axes=(labels.velocities,),
        depends=("independent",),
    ),
    "shaping_forces": of_signal(
        "output",
        f"driving forces that keep the value {_OF}, where nothing is lost,",
        _shaping,
        FORCES,
        result="tau",
        arguments=("q", "qd"),
        axes=(labels.velocities,),
        when_constrained="refuse",
        depends=(),
    ),
}
"""Rows of the table, which a scene has when it is asked for them."""
