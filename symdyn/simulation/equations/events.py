"""Kinds of events: a guard, in which direction it is passed, what jumps there, and what it is.

    g(t, q, u, s) = 0       the guard, of which passages of zero are events
    x⁺ = R(t, x⁻)           the update, x = (q, u, s)
    δx⁺ = ∂R δx⁻ - (f⁺ - ∂R f⁻ - ∂R/∂t) δt,   δt = -∂g δx⁻ / ġ

Formulas of a user, places where equations end and where they bend, limits of joints and resets of states are rows of
one table, in this order. What of a run is changed at an event is said here alone: its update, and how small changes of
a motion go through it, the saltation, δp being among δx. A guard that is only touched, ġ = 0, has no such derivative.

Reference: Leine and Nijmeijer, Dynamics and bifurcations of non-smooth mechanical systems (2004), chapter 7.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import OUTPUTS, Workspace
from symdyn.frozen import dataclass
from symdyn.graph import Expr, substitute
from symdyn.scene.values import resets_of, spell
from symdyn.simulation.equations.monitors import SLACK, Limit

if TYPE_CHECKING:
    from symdyn.simulation.equations.system import StateEquations

DIRECTIONS = {"both": 0, "up": 1, "down": -1}
"""The sign of the rate with which a guard passes zero, by the word of a reset; 0 for any."""


@dataclass(frozen=True)
class EventKind:
    """What happens where a guard passes zero.

    Attributes:
        guard: the formula.
        direction: 1 where only passages upwards are events, -1 downwards, 0 both.
        slack: by how much it is passed before it counts, as what rests on it rounds; told is where it was passed.
        update: q, u and s behind it in terms of what is before; () where nothing jumps.
        limit: the limit of a joint that it is.
        end: why equations end there.
        text: what it is called where neither a limit, an end nor a user's formula says that.
        changes: which entries of x jump.
        bends: whether equations bend there: nothing is said, and integrators begin anew.
        contact: which contact changes its mode there, and what it does.
    """

    guard: Expr
    direction: int = 0
    slack: float = 0.0
    update: tuple[Expr, ...] = ()
    limit: Limit | None = None
    end: str = ""
    text: str = ""
    changes: tuple[int, ...] = ()
    bends: bool = False
    contact: tuple[int, str] | None = None

    @property
    def halts(self) -> bool:
        """Whether something is changed there."""
        return bool(self.update) or self.contact is not None


def event_kinds(
    w: Workspace, formulas: Iterable[Expr], bends: Iterable[Expr], limits: Iterable[Limit], place: Mapping[Expr, Expr]
) -> tuple[EventKind, ...]:
    """Return all kinds of events of a scene, formulas of the user first; `place` tells what forces and inputs are."""
    found = [EventKind(formula) for formula in formulas]
    found += [EventKind(formula, end=words) for formula, words in w.loops.ends]
    found += [EventKind(formula, bends=True) for formula in bends]
    found += [EventKind(limit.beyond, 1, SLACK, limit=limit) for limit in limits]
    return (*found, *_resets(w, place))


def _resets(w: Workspace, place: Mapping[Expr, Expr]) -> list[EventKind]:
    """Return the resets of states, of several with one guard together, as they jump at once."""
    moves, found, width, resets = (
        (*w.state.q, *w.state.qd),
        list[EventKind](),
        1 + len(w.states),
        resets_of(w.scene.states),
    )
    entries = substitute(OUTPUTS["resets"].formulations["formula"].derive(w), place) if resets else ()
    for k, ((when, way), jumps) in enumerate(resets.items()):
        guard, *behind = entries[k * width : (k + 1) * width]
        changes = tuple(len(moves) + i for i, one in enumerate(w.scene.states) if one.name in jumps)
        text = f"reset of {', '.join(jumps)}: {spell(when)}"
        found.append(EventKind(guard, DIRECTIONS[way], update=(*moves, *behind), text=text, changes=changes))
    return found


def saltation(slopes: Array, before: Array, after: Array) -> Array | None:
    """Return δx⁺ by (δx⁻, δp), shape (nx, nx + np), None where the guard is only touched.

    Args:
        slopes: of g and then R, by x, p and t, shape (1 + nx, nx + np + 1).
        before: f⁻, shape (nx,).
        after: f⁺, shape (nx,).
    """
    n, g, R = len(before), slopes[0], slopes[1:]
    rate = g[:n] @ before + g[-1]
    if abs(rate) <= TOUCHES * (np.abs(g[:n]) @ np.abs(before) + abs(g[-1])):
        return None
    return np.asarray(R[:, :-1] + np.outer(after - R[:, :n] @ before - R[:, -1], g[:-1]) / rate)


TOUCHES = 1e-9
"""The rate of a guard, over that of its parts, below which it is only touched."""


CHAIN = 100
"""Jumps that make each other happen at one time, at most."""


def jumped(
    system: StateEquations, stops: Sequence[bool], t: float, x: Array, events: Sequence[int]
) -> tuple[Array, list[int], dict[int, float]]:
    """Return the state behind events at a time, the events that jumps pass, and what is zero of guards of all these.

    Where an event stops, or nothing more is changed, no further jumps follow.

    Raises:
        ArithmeticError: jumps follow each other without end.
    """
    more, zero = list[int](), dict[int, float]()
    for _ in range(CHAIN):
        before = system.evaluate("events", t, x)
        zero |= system.residue(events, t, x)
        x = system.behind(events, t, x)
        events = [k for k in crossed(before, system.evaluate("events", t, x), system.kinds) if k not in zero]
        more += events
        if any(stops[k] for k in events) or not any(system.kinds[k].halts for k in events):
            return x, more, zero
    raise ArithmeticError("jumps follow each other without end")


def crossed(before: Array, after: Array, kinds: Sequence[EventKind]) -> list[int]:
    """Return the kinds of events that a jump passes, from values of their guards before and behind it."""
    passed = [k for k in np.flatnonzero(before * after < 0).tolist() if kinds[k].contact is None]
    return [k for k in passed if not kinds[k].direction or after[k] * kinds[k].direction > 0]
