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
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from symdyn.dynamics.loops.partition import solve_square, squared
from symdyn.dynamics.mechanism.linear_solve import Singular, vanishes
from symdyn.dynamics.mechanism.state import TIME, Prescribed, accelerations, refuse_ideal_friction
from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.output import FORCES, Formulation, Output, Size, by_lagrange
from symdyn.dynamics.outputs.signal_outputs import SIGNALS, Moving
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError, listed
from symdyn.graph import Expr, gradient, reachable, substitute, tangents
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
