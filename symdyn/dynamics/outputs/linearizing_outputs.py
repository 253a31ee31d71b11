"""Feedback linearisation: forces that give wanted accelerations, zero dynamics, and how drives move outputs.

    a, p     velocities with a drive, velocities without one; M and h = c + g + k_E - Q in their blocks
    τ        (M_aa - M_ap M_pp⁻¹ M_pa) v + h_a - M_ap M_pp⁻¹ h_p gives u̇_a = v            collocated
    τ        of u̇_a = -M_pa⁻¹ (M_pp v + h_p) gives u̇_p = v, where M_pa is square          not collocated
    u̇        of the others where u = u̇ = 0 of what is held                                zero dynamics
    y^(r)    a(x) + B(x) τ, r the first derivative of an output that drives are in         relative degree

What is wanted is entered as a motion that is prescribed is: accelerations are known there, and forces are not.
B vanishes nowhere but at single points, or everywhere: that is decided over a finite field (see `linear_solve`).

References: Spong, Partial feedback linearization of underactuated mechanical systems (1994), and The swing up control
problem for the acrobot (1995); Isidori, Nonlinear Control Systems (1995), chapters 4 and 5.

Forces from a function V of the state: damping of what drives do to it, and shaping of the energy that it is.

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

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from symdyn.dynamics.loops.partition import solve_square, squared
from symdyn.dynamics.mechanism.linear_solve import Singular, solve, vanishes
from symdyn.dynamics.mechanism.state import TIME, Prescribed, accelerations, refuse_ideal_friction
from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.output import FORCES, Formulation, Output, Size, by_lagrange
from symdyn.dynamics.outputs.signal_outputs import SIGNALS, Moving
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError, listed
from symdyn.frozen import dataclass
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute, tangents
from symdyn.scene import Scene


def _driven(scene: Scene) -> list[int]:
    """Return the velocities that a drive moves freely."""
    return [k for k in scene.actuated_velocities if k not in scene.prescribed_velocities]


def _leading(scene: Scene, led: str) -> tuple[Sequence[int], str]:
    """Return the velocities that are led, "driven" or "passive" ones, and why drives cannot lead them, else ""."""
    driven, passive = _driven(scene), scene.passive_velocities
    names = [listed([scene.velocities[k] for k in some]) for some in (driven, passive)]
    why = ""
    if not driven:
        why = "no joint has a drive that could linearise it; name one, drive = NAME"
    elif not passive:
        why = "every joint is driven; inverse_dynamics at the wanted accelerations linearises all of it"
    elif led == "passive" and len(driven) != len(passive):
        why = (
            f"as many passive velocities are led as there are drives; driven: {names[0]}; passive: {names[1]}; "
            "linearizing_forces leads what is driven"
        )
    return passive if led == "passive" else driven, why


def _wanted(w: Workspace, led: str) -> Prescribed:
    """Return the motion that is known, prescribed or wanted; DerivationError where drives cannot lead it."""
    leading, why = _leading(w.scene, led)
    if why:
        raise DerivationError(f"{w.scene.name}: {why}")
    known = dict(zip(w.prescribed.place, w.prescribed.acceleration, strict=True))
    known |= {k: w.state.qdd[k] for k in leading}
    place = tuple(sorted(known))
    return replace(w.prescribed, place=place, acceleration=tuple(known[k] for k in place))


def _bias(w: Workspace, qdd: Sequence[Expr], formulation: str) -> list[Expr]:
    """Return M u̇ + h, the forces of a motion."""
    if formulation == "recursive":
        return w.forces(list(qdd))
    return substitute(w.energy.driving_forces(), dict(zip(w.state.qdd, qdd, strict=True)))


def _motion(w: Workspace, led: str, formulation: str) -> list[Expr]:
    """Return u̇ where no force acts on what is passive, shape (nv,)."""
    refuse_ideal_friction(w.scene)
    given, passive = _wanted(w, led), w.scene.passive_velocities
    recursive, bias = formulation == "recursive", _bias(w, given.entered(w.zeros), formulation)
    M = w.composite_mass if recursive else w.lagrange_mass
    if led == "driven":
        parents = w.tree.velocity_parents(given.free) if recursive else range(-1, len(given.free))
        return accelerations(given, parents, M, w.zeros, bias)
    found, coupling = given.entered(w.zeros), [[M[i][j] for j in given.free] for i in passive]
    try:
        squared(coupling)
    except Singular as fault:
        raise DerivationError(
            f"{w.scene.name}: forces cannot lead what is passive: no inertia couples all of it with what is driven, in "
            "no configuration; linearizing_forces leads what is driven"
        ) from fault
    for k, value in zip(given.free, solve_square(coupling, [-bias[i] for i in passive]), strict=True):
        found[k] = value
    return found


def _forces(w: Workspace, led: str, formulation: str) -> list[Expr]:
    """Return the forces of that motion, none where it is passive."""
    found = _bias(w, w.once(_motion, led, formulation), formulation)
    return [w.graph.zero if k in w.scene.passive_velocities else force for k, force in enumerate(found)]


def _held(w: Workspace, led: str, formulation: str) -> list[Expr]:
    """Return u̇ of the others, what is led being held."""
    still = {x: w.graph.zero for k in _leading(w.scene, led)[0] for x in (w.state.qd[k], w.state.qdd[k])}
    return substitute([w.once(_motion, led, formulation)[k] for k in _wanted(w, led).free], still)


# Outputs of the scene along the motion


def _rates(w: Workspace, name: str, entry: Expr, formulation: str) -> Expr:
    """Return the rate of a function of time, q, qd and states along the motion; DerivationError where it is none."""
    scene, graph, state = w.scene, w.graph, w.state
    without = {graph.symbol(one.name): one.name for one in scene.inputs if one.name not in scene.rates}
    unknown = dict.fromkeys(state.tau, "driving forces") | {x: f"the input {one}" for x, one in without.items()}
    there = reachable([entry])
    if found := next((unknown[node] for node in there if node in unknown), ""):
        raise DerivationError(
            f"{scene.name}: output {name} depends on {found}, directly or by accelerations or reactions, and nothing "
            "tells the rate of that; write an output of coordinates, velocities, states and time"
        )
    seeds = {**state.velocity, graph.symbol(TIME): graph.one, **dict(zip(w.states, w.state_rates, strict=True))}
    if any(x in there for x in state.qd):
        seeds |= zip(state.qd, Moving.driven(w, formulation).accelerations(), strict=True)
    return tangents([entry], seeds)[0]


def _along(w: Workspace, *asked: str) -> list[Expr]:
    """Return dy/dt of one output of the scene, or of all, by a formulation, which is told last."""
    *name, formulation = asked
    entries = SIGNALS["output" if name else "outputs"].formulations[formulation].derive(w, *name)
    names = name or [one.name for one in w.scene.outputs]
    return [_rates(w, one, y, formulation) for one, y in zip(names, entries, strict=True)]


def rate_of(w: Workspace, name: str, formulation: str) -> Expr:
    """Return dy/dt of one output of the scene along the motion; DerivationError where it is none."""
    (rate,) = _along(w, name, formulation)
    return rate


def drive_columns(w: Workspace) -> list[int]:
    """Return the velocities whose drives may move an output; all that may have one where no joint has."""
    return _driven(w.scene) or w.prescribed.free


def _decoupled(w: Workspace, name: str, formulation: str = "recursive") -> tuple[int, list[Expr]]:
    """Return the relative degree r of an output, and [a | B] of y^(r) = a + B tau; DerivationError where r > 2."""
    refuse_ideal_friction(w.scene)
    (entry,) = _along(w, name, formulation)
    for degree in (1, 2):
        slopes = gradient(entry, [w.state.tau[k] for k in drive_columns(w)])
        drift, *slopes = substitute([entry, *slopes], dict.fromkeys(w.state.tau, w.graph.zero))
        if not all(map(vanishes, slopes)):
            return degree, [drift, *slopes]
        entry = _rates(w, name, drift, formulation) if degree == 1 else drift
    raise DerivationError(
        f"{w.scene.name}: output {name} has no relative degree of 1 or 2: no driving force is in its first two rates; "
        "take an output that a driven joint moves"
    )


def _matrix(w: Workspace, *asked: str) -> list[Expr]:
    """Return [a | B] of one output or of all, row by row, likewise."""
    *name, formulation = asked
    _along(w, *asked)  # tells where there is none
    names = name or [one.name for one in w.scene.outputs]
    return [x for one in names for x in w.once(_decoupled, one, formulation)[1]]


def _degrees(w: Workspace) -> tuple[str, ...]:
    """Return a label for each output, which tells its relative degree."""
    names = [one.name for one in w.scene.outputs]
    return tuple(f"{'second ' * (w.once(_decoupled, one)[0] == 2)}rate of {one}" for one in names)


def _drives(w: Workspace) -> tuple[str, ...]:
    """Return what the columns of [a | B] stand for."""
    velocities, drives = w.scene.velocities, w.scene.drives
    return ("drift", *(drives[k] or f"force on {velocities[k]}" for k in drive_columns(w)))


def _degree(w: Workspace, name: str) -> str:
    """Return the formula and the relative degree behind a text."""
    formula = SIGNALS["output"].remark
    return f"{formula(w, name) if formula else ''}; relative degree {w.once(_decoupled, name)[0]}"


# Rows of the table


def _two(derive: Callable[..., list[Expr]], *led: str) -> dict[str, Formulation]:
    """Return the formulations by recursion and by Lagrange's equations, which a derivation takes last."""
    return {
        "recursive": Formulation(lambda w, *name: derive(w, *led, *name, "recursive")),
        "lagrange": by_lagrange(lambda w, *name: derive(w, *led, *name, "lagrange")),
    }


def _of_led(at: str, led: str, rest: str) -> dict[str, Output]:
    """Return the rows of forces that lead what is driven, or what is passive."""
    usual = partial(
        Output,
        when_constrained="refuse",
        default_in="request",
        exists=lambda scene: not _leading(scene, led)[1],
        may_fail="reported",
        size=Size((0, 40)),
    )
    return {
        f"linearizing_forces{at}": usual(
            f"driving forces, zero at passive velocities, that give the {led} ones the accelerations qdd; those of "
            f"{rest} ones are not read",
            ("q", "qd", "qdd"),
            "tau",
            (labels.velocities,),
            FORCES,
            formulations=_two(_forces, led),
        ),
        f"zero_dynamics{at}": usual(
            f"accelerations of the {rest} coordinates while drives hold the {led} ones, whose velocities are not read",
            ("q", "qd"),
            "qdd",
            (lambda w: tuple(w.scene.velocities[k] for k in _wanted(w, led).free),),
            "rad/s^2 or m/s^2",
            formulations=_two(_held, led),
        ),
    }


def of_signal(of: str, what: str, derive: Callable[..., list[Expr]], units: str, **changes: object) -> Output:
    """Return a row about what outputs of the scene do along the motion."""
    usual: dict[str, object] = {"units": units, "default_in": "request", "formulations": _two(derive)}
    return replace(SIGNALS[of], text=f"{what} of {SIGNALS[of].text}", **usual, **changes)  # type: ignore[arg-type]


_FIRST = "[a | B] of y' or y'' = a + B tau, the rate that driving forces are first in,"
_PER = "of the output, per second or second squared, and per unit of force"

LINEARIZING: dict[str, Output] = {
    **_of_led("", "driven", "passive"),
    **_of_led(":passive", "passive", "driven"),
    "output_rates": of_signal("outputs", "rates along the motion", _along, "of each, per second", result="dy"),
    "output_rate": of_signal("output", "rate along the motion", _along, "of the output, per second", result="dy"),
    "decoupling_matrix": of_signal(
        "outputs", _FIRST, _matrix, _PER, result="aB", arguments=("q", "qd"), axes=(_degrees, _drives)
    ),
    "decoupling_row": of_signal(
        "output", _FIRST, _matrix, _PER, result="aB", arguments=("q", "qd"), axes=(_drives,), remark=_degree
    ),
}
"""Rows of the table, which a scene has when it is asked for them."""


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
    """Return what shaping needs; DerivationError where V is no such function, or drives do not each work on it."""
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
    square = [[graph.dot(x, y) for y in G] for x in G]
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
    return _spread(w, [-graph.dot(one, mean) for one in found.inverse])


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
        "driving forces that keep the value of a shaped energy, quadratic in velocities, where nothing is lost,",
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
