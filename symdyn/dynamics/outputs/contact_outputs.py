"""Outputs of contacts that open and close: gaps, their rates, forces in every mode, and what an impact does.

The impact of one contact alone is a formula. With v = (ġ⁻, s⁻), D its Delassus' matrix, and Λ of one phase:

    stick    Λ = -D⁻¹ v, where |Λt| ≤ μ Λn        else slip    Λn = -v_n/(D_nn - z μ D_nt), Λt = -z μ Λn

z is the sign of the slip, against which friction acts: 1 where Λn and s⁺ are above zero with it, else -1. By Poisson's
law expansion begins with e Λn, and ends where that is left; by Newton's law v_n is (1 + e) ġ⁻.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), sections 6.5 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice

from symdyn.dynamics.outputs import (
    constrained_outputs as constrained,
    result_labels as labels,
    tree_formulations as trees,
)
from symdyn.dynamics.outputs.contact_equations import ContactEquations, columns_of, contact_equations, dot
from symdyn.dynamics.outputs.contact_rows import Row, Touch, touching, unilaterals_of
from symdyn.dynamics.outputs.named_functions import MODES, direction, mode_names
from symdyn.dynamics.outputs.output import Formulation, Output
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError, choice
from symdyn.graph import Expr, Op
from symdyn.scene import Scene

DIRECTIONS = ("normal", "along", "across")
"""The rows of a contact; those along which it cannot slip are zero."""


def every_touch(w: Workspace, by_recursion: bool = True) -> tuple[Touch, ...]:
    """Return all contacts.

    Raises:
        DerivationError: there are none.
    """
    found: tuple[Touch, ...] = w.once(touching, by_recursion)
    if not found:
        advice = 'declare one, such as [contacts.floor] body = "NAME"'
        raise DerivationError(f"{w.scene.name} has no contacts; {advice}")
    return found


def _touch(w: Workspace, name: str, by_recursion: bool) -> Touch:
    """Return a contact by its name; DerivationError where there is none so called."""
    every = every_touch(w, by_recursion)
    found = {one.law.name: one for one in every}
    if name not in found:
        raise DerivationError(f"{w.scene.name}: there is no contact {name!r} in [contacts]; {choice(name, found)}")
    return found[name]


def _rows(w: Workspace, name: str, by_recursion: bool) -> list[Row]:
    touch = _touch(w, name, by_recursion)
    none = Row(tuple(w.zeros), w.graph.zero)
    found = [touch.normal or none, *touch.slips]
    return [*found, *[none] * (len(DIRECTIONS) - len(found))]


def _gap(w: Workspace, name: str, by_recursion: bool) -> list[Expr]:
    touch = _touch(w, name, by_recursion)
    if touch.law.at_rates:
        raise DerivationError(f"{w.scene.name}: {name} is a law of rates, 0 <= gap_rate:{name}, and has no gap")
    return [touch.gap]


def _free(w: Workspace, by_recursion: bool) -> list[Expr]:
    forward = (constrained.forward, constrained.lagrange_forward), (trees.forward_crba, trees.lagrange_forward)
    return w.once(forward[not w.scene.is_constrained][not by_recursion])


def _impact_matrix(w: Workspace, name: str, by_recursion: bool) -> list[Expr]:
    free = _free(w, by_recursion)
    columns = [columns_of(w, free, row) for row in _rows(w, name, by_recursion)]
    return [entry for parts in zip(*columns, strict=True) for entry in parts]


def _all(w: Workspace, by_recursion: bool) -> ContactEquations:
    every_touch(w, by_recursion)
    return contact_equations(w, _free(w, by_recursion), by_recursion)


def _in_mode(w: Workspace, by_recursion: bool) -> list[Expr]:
    """Return accelerations and forces, the mode told by mask and slip; of least size where rows may hold the same."""
    c: ContactEquations = w.once(_all, by_recursion)
    masks, slips = (iter(direction(w.graph, name, len(mode_names(w, name)))) for name in MODES)
    one, touches = w.graph.one, list[Touch]()
    for touch in c.touches:
        along = tuple(islice(slips, max(1, len(touch.tangents))))
        sticks = one - w.graph.total(part * part for part in along)
        touches.append(replace(touch, mode=(next(masks), sticks, one, one), directions=along))
    told = replace(c, touches=tuple(touches), shared=len(c.rows) > _free_ways(w))
    return [*told.accelerations, *told.forces]


# One impact


def _free_ways(w: Workspace) -> int:
    """Return how many velocities are free."""
    return len(w.prescribed.free) - (len(w.loops.decisions.independent_rows) if w.scene.is_constrained else 0)


def _impact(w: Workspace, name: str, by_recursion: bool) -> list[Expr]:
    """Return u⁺ and Λ where a contact strikes alone."""
    touch, free = _touch(w, name, by_recursion), _free(w, by_recursion)
    if touch.normal is None:
        raise DerivationError(f"{w.scene.name}: {name} is dry friction of a joint, which strikes nothing")
    if len(touch.tangents) > 1:
        raise DerivationError(
            f"{w.scene.name}: contacts.{name}: it can slip along two directions, and no formula says how"
        )
    rows = list(touch.rows)
    if len(rows) > _free_ways(w) > 0:
        told = f"{len(rows)} impulses act, and {_free_ways(w)} velocity is free, so that they are not unique"
        raise DerivationError(f"{w.scene.name}: contacts.{name}: {told}; leave its friction out")
    columns = [columns_of(w, free, row) for row in rows]
    D = [[dot(row.entries, column) for column in columns] for row in rows]
    if D[0][0].is_zero:
        raise DerivationError(f"{w.scene.name}: contacts.{name}: nothing moves along its normal, nothing strikes")
    v = [dot(row.entries, w.state.qd) for row in rows]
    e, zero, one = touch.restitution, w.graph.zero, w.graph.one
    if touch.law.law == "newton":
        found = _phase(D, [(one + e) * v[0], *v[1:]], touch, zero)
    else:
        found = _phase(D, v, touch, zero)
        again = [a + dot(row, found) for a, row in zip(v, D, strict=True)]
        more = _phase(D, again, touch, e * found[0])
        found = [a + b for a, b in zip(found, more, strict=True)]
    found = [where(v[0], zero, part) for part in found]  # what parts already does not strike
    after = [u + dot(parts, found) for u, parts in zip(w.state.qd, zip(*columns, strict=True), strict=True)]
    return [*after, *found, *[zero] * (2 - len(found))]


def _phase(D: Sequence[Sequence[Expr]], v: Sequence[Expr], touch: Touch, least: Expr) -> list[Expr]:
    """Return Λ of a phase that ends where the gap's rate is zero, its normal impulse `least` at least.

    Where the least is more than that takes, the rate is above zero in the end.
    """
    if len(v) == 1:
        return [_larger(-v[0] / D[0][0], least)]
    (a, b), (_, c) = D
    mu, det = touch.friction, a * c - b * b
    sticking = _larger((b * v[1] - c * v[0]) / det, least)
    held = -(v[1] + b * sticking) / c
    beyond = held * held - mu * mu * sticking * sticking
    ahead, back = (_larger(-v[0] / (a - z * mu * b), least) for z in (1, -1))
    goes_on = v[1] + (b - mu * c) * ahead  # what slips ahead has to
    found = []
    for stuck, one, other in ((sticking, ahead, back), (held, -mu * ahead, mu * back)):
        slips = where(a - mu * b, where(goes_on, one, other), other)
        found.append(where(-sticking, slips, where(beyond, slips, stuck)))
    return found


def where(condition: Expr, positive: Expr, otherwise: Expr) -> Expr:
    """Return one of two numbers, the first where a condition is above zero."""
    return condition.graph.function(Op.SELECT, condition, positive, otherwise)


def _larger(a: Expr, b: Expr) -> Expr:
    return a if b.is_zero else where(a - b, a, b)


# The table


def _contact_rows(w: Workspace) -> tuple[str, ...]:
    every = every_touch(w)
    found = list[str]()
    for one in every:
        words = ("tangent",) if len(one.tangents) == 1 else DIRECTIONS[1:]
        chosen = (*(("normal",) if one.normal else ()), *words[: len(one.tangents)])
        found += [f"{word} of {one.law.name}" for word in chosen]
    return tuple(found)


def _both(derive: Callable[..., list[Expr]], up_to: float = 4) -> dict[str, Formulation]:
    def way(by_recursion: bool) -> Callable[..., list[Expr]]:
        return lambda w, *name: derive(w, *name, by_recursion)

    return {"recursive": Formulation(way(True)), "differentiation": Formulation(way(False), up_to=up_to)}


def touches(scene: Scene) -> bool:
    """Return whether a scene has contacts."""
    return bool(unilaterals_of(scene))


_PLACED = partial(Output, when_constrained="same", place="contact", default_in="verify", exists=touches)
_STRUCK = partial(_PLACED, may_fail="reported", depends=("independent",))
_OF_ALL = partial(
    Output,
    when_constrained="same",
    may_fail="reported",
    default_in="verify",
    exists=touches,
    depends=("independent", "alpha", "beta"),
)
_UNITS = "m/s or rad/s"

CONTACTS: Mapping[str, Output] = {
    "gap": _PLACED("gap of {name}", ("q",), "g", (), "m or rad", may_fail="reported", formulations=_both(_gap, 8)),
    "gap_jacobian": _PLACED(
        "Jacobian of the rates of gap and slip of {name}",
        ("q",),
        "W",
        (labels.fixed(*DIRECTIONS), labels.velocities),
        "m, rad or 1",
        formulations=_both(lambda w, *touch: [entry for row in _rows(w, *touch) for entry in row.entries], 8),
    ),
    "gap_rate": _PLACED(
        "rates of gap and slip of {name}",
        ("q", "qd"),
        "v",
        (labels.fixed(*DIRECTIONS),),
        _UNITS,
        formulations=_both(lambda w, *touch: [dot(row.entries, w.state.qd) for row in _rows(w, *touch)], 8),
    ),
    "gap_jdot": _PLACED(
        "accelerations of gap and slip of {name} at qdd = 0",
        ("q", "qd"),
        "gamma",
        (labels.fixed(*DIRECTIONS),),
        f"{_UNITS}, per s",
        formulations=_both(lambda w, *touch: [row.bias for row in _rows(w, *touch)], 8),
    ),
    "impact_matrix": _STRUCK(
        "velocities by a unit of impulse at {name}, M^-1 W^T",
        ("q",),
        "C",
        (labels.velocities, labels.fixed(*DIRECTIONS)),
        "per N s or N m s",
        formulations=_both(_impact_matrix),
    ),
    "impact": _STRUCK(
        "velocities behind an impact of {name} alone, and its impulses",
        ("q", "qd"),
        "qd_after",
        (lambda w: (*w.scene.velocities, "normal impulse", "tangential impulse"),),
        "of velocities; N s or N m s",
        formulations=_both(_impact),
    ),
    "delassus": _OF_ALL(
        "accelerations of gaps and slips by a unit of force, W M^-1 W^T",
        ("q",),
        "D",
        (_contact_rows, _contact_rows),
        "per kg or kg m^2",
        depends=("independent",),
        formulations=_both(lambda w, by_recursion: trees.flat(w.once(_all, by_recursion).delassus)),
    ),
    "contact_bias": _OF_ALL(
        "accelerations of gaps and slips without contact forces, W qdd + Wdot qd",
        ("q", "qd", "tau"),
        "b",
        (_contact_rows,),
        "m/s^2 or rad/s^2",
        formulations=_both(lambda w, by_recursion: w.once(_all, by_recursion).drift),
    ),
    "contact_dynamics": _OF_ALL(
        "accelerations and contact forces in a mode: mask closes contacts, slip is 0 where they stick",
        ("q", "qd", "tau", *MODES),
        "qdd",
        (lambda w: (*w.scene.velocities, *_contact_rows(w)),),
        "of accelerations; N or N m",
        formulations=_both(_in_mode),
    ),
}
