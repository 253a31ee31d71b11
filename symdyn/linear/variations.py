"""Functions that linearising evaluates: forces, constraints, outputs, and their derivatives along all directions.

    e        M u̇ + h - τ(t, q, u, w) - Pᵀ λ = 0, P being G but for the friction of contacts that slip
    r        residuals of positions; of a prescribed motion q_k - p_k(t, w)
    s        G u = 0, the constraints; of a prescribed motion u_k - ṗ_k(t, w)
    c        G u̇ + Ġ u = 0, rate of a constraint; of a prescribed motion u̇_k - p̈_k(t, w) = 0
    X_k f    d/dε f(q ∘ exp(ε X_k)), all else held: a column for every velocity

States s of one's own stand behind velocities as if they were such, of mass 1: e has the rows ṡ - rate(t, q, u, s, w),
and u below is (u, s). No positions belong to them.

Outputs are formulas in the letters of `symdyn.scene.values.grammar`, parameters, and the outputs that the scene
declares.

All is on one graph, derived once for all values of parameters and every point. Nothing is eliminated there: which
positions and velocities are independent is decided in numbers at the point, and no formula is larger than those of
forces and constraints.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from symdyn.algebra import Array, Batches, Floats
from symdyn.arguments import SympyExpression, argument
from symdyn.dynamics import LoopChoices, Workspace, derive_one
from symdyn.dynamics.mechanism import refuse_ideal_friction
from symdyn.dynamics.outputs import Moving
from symdyn.errors import DerivationError, LinearizeError, SimulateError
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, growing, reachable, repeated, substitute, tangents
from symdyn.linear.contact_mode import HeldContacts, Mode, scene_in_mode
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import LETTERS, Faults, acceleration_name, formula_text, split_commas
from symdyn.simulation import read_output
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class Outputs:
    """Formulas as the user wrote them, read, and their units, "" where nobody tells."""

    names: tuple[str, ...]
    formulas: tuple[Quantity, ...]
    units: tuple[str, ...]


def read_outputs(scene: Scene, texts: str | Sequence[str | SympyExpression]) -> Outputs:
    """Return what is looked at; where nothing is said the outputs of the scene, or else all coordinates.

    Raises:
        SimulateError: with every fault, one line each.
        LinearizeError: names of their own, which the scene declares.
    """
    declared = {one.name: one for one in scene.outputs}
    if isinstance(texts, Mapping):
        raise LinearizeError(
            f"outputs: a name is declared in the scene, [outputs.{next(iter(texts), 'y')}]; give formulas"
        )
    texts = tuple(split_commas(texts) if isinstance(texts, str) else map(formula_text, texts)) or tuple(declared)
    if not texts:
        units = tuple(scene.shown_unit(unit) for unit in SceneUnits(scene).coordinates)
        return Outputs(scene.coordinates, tuple(map(Quantity.symbol, scene.coordinates)), units)
    faults = Faults("")
    read = [read_output(scene, text, "outputs", faults) for text in texts]
    for text in dict.fromkeys(text for text in texts if texts.count(text) > 1):
        faults.add("outputs", f"{text} is given twice; give it once")
    faults.close(SimulateError)
    found = [one for one in read if one is not None]
    told = [declared[text].unit if text in declared else "" for text in texts]
    known = tuple(one or unit for one, (_, unit) in zip(told, found, strict=True))
    return Outputs(texts, tuple(formula for formula, _ in found), known)


def on_graph(
    w: Workspace, formulas: Sequence[Quantity], multipliers: Sequence[Expr], acting: Mapping[Expr, Expr]
) -> list[Expr]:
    """Return formulas as entries; `acting` tells what driving forces and inputs are.

    Raises:
        LinearizeError: a reaction or a multiplier that there is not.
    """

    def reactions(axes: str) -> list[Expr]:
        name = "forward_reactions" if w.scene.is_constrained else "reactions"
        return substitute(derive_one(w, name if axes == LETTERS.axes[0] else f"{name}:{axes}").entries, acting)

    moving = Moving(
        w, lambda: w.state.qdd, lambda: [acting[tau] for tau in w.state.tau], reactions, lambda: multipliers
    )
    try:
        return moving.expressed(formulas, inputs={one: acting[one] for one in w.inputs})
    except DerivationError as fault:
        raise LinearizeError(str(fault)) from None


Formulas = tuple[tuple[int, Quantity], ...]
Entries = Mapping[str, tuple[tuple[int, ...], Sequence[Expr]]]


@dataclass(frozen=True)
class VariationBlock:
    """Arrays of entries that are evaluated together."""

    parts: Entries
    order: Sequence[Expr] = field(repr=False)

    def at(self, values: Mapping[Expr, float]) -> dict[str, Array]:
        """Return the arrays at one state.

        Raises:
            NoValueError: something has no value there.
        """
        flat = iter(self._of_one(values))
        return {
            name: np.array([next(flat) for _ in entries], dtype=np.float64).reshape(shape)
            for name, (shape, entries) in self.parts.items()
        }

    def over(self, values: Mapping[Expr, Any], count: int) -> dict[str, Array]:
        """Return the arrays at many states, each of shape (count, ...); NaN where something has no value."""
        with np.errstate(all="ignore"):
            flat = iter(self._of_many(values))
        found = {}
        for name, (shape, entries) in self.parts.items():
            array = np.empty((count, len(entries)))
            for k in range(len(entries)):
                array[:, k] = next(flat)
            found[name] = array.reshape(count, *shape)
        return found

    @cached_property
    def _of_one(self) -> Callable[[Mapping[Expr, float]], list[float]]:
        return repeated(self._entries, Floats())

    @cached_property
    def _of_many(self) -> Callable[[Mapping[Expr, Any]], list[Any]]:
        return repeated(self._entries, Batches())

    @property
    def _entries(self) -> list[Expr]:
        return [entry for _, entries in self.parts.values() for entry in entries]


def block(**parts: tuple[tuple[int, ...], Sequence[Expr]]) -> VariationBlock:
    """Return arrays of entries to be evaluated together, each given as shape and entries."""
    return VariationBlock(parts, reachable([entry for _, entries in parts.values() for entry in entries]))


@dataclass(frozen=True)
class Variations:
    """The functions of a scene under forces.

    Attributes:
        w: what they are derived on.
        u: velocities, and then states of one's own, shape (nu,).
        a: rates of these, shape (nu,).
        multipliers: symbols λ of the independent rows, then of contacts and of prescribed motions.
        holding: which are position-level rows.
        inputs: names of the inputs, deviations from what is given.
        contacts: the contact of each row that holds one, by number of the row.
        motion: what tells accelerations and multipliers: "M", "h" (e at u̇ = 0 and λ = 0), "G", "P", "b" (c at u̇ = 0),
            "r" (residuals), "s", "push" (formulas of forces), "H" (q̇ = H u), "inputs".
        slopes: "e" and the part "p" of it that formulas of forces have, along q, u, u̇ and w, shape (nu, 3 nu + nw); "c"
            along q, u and w, "s" along q and w, "r" along w.
        outputs: "y", and "y_" along q, u, u̇, λ, τ and w.
    """

    w: Workspace = field(repr=False)
    u: tuple[Expr, ...]
    a: tuple[Expr, ...]
    multipliers: tuple[Expr, ...]
    holding: tuple[bool, ...]
    inputs: tuple[str, ...]
    contacts: Mapping[int, str]
    motion: VariationBlock = field(repr=False)
    slopes: VariationBlock = field(repr=False)
    outputs: VariationBlock = field(repr=False)

    @cached_property
    def corners(self) -> VariationBlock:
        """What signs and absolute values in the forces are of: where one is zero, they have no one derivative."""
        forces = self.motion.parts["h"][1]
        turned = dict.fromkeys(guard for node in reachable(forces) for guard in node.guards)
        return block(of=((len(turned),), list(turned)))

    @cached_property
    def statics(self) -> VariationBlock:
        """At rest: "f" = e at u = u̇ = 0, "K" its derivative along q and s, "G", "r" of position-level rows, "push".

        States of one's own are among what is looked for; "H" says how q, and then s, move.
        """
        w, n, zero = self.w, len(self.u), self.w.graph.zero
        owned = range(w.state.n, n)
        still = dict.fromkeys([*w.state.qd, *self.a], zero)
        (rows, _), G = self.motion.parts["G"]
        (_, width), e = self.slopes.parts["e"]
        K = substitute([e[i * width + k + n * (k in owned)] for i in range(n) for k in range(n)], still)
        H = [*self.motion.parts["H"][1], *(w.graph.one if i == k else zero for i in owned for k in range(n))]
        forces = substitute(self.motion.parts["h"][1], still)
        pulled = [w.graph.total(G[r * n + k] * x for r, x in enumerate(self.multipliers)) for k in range(n)]
        driven = (*w.state.tau, *(zero for _ in owned))
        f = [h - tau - more for h, tau, more in zip(forces, driven, pulled, strict=True)]
        r = [one for one, holds in zip(self.motion.parts["r"][1], self.holding, strict=True) if holds]
        push = substitute(self.motion.parts["push"][1], still)
        return block(
            f=((n,), f), K=((n, n), K), G=((rows, n), list(G)), r=((len(r),), r), H=((len(H) // n, n), H),
            push=((n,), push),
        )  # fmt: skip


@lru_cache(maxsize=16)
def variations(
    scene: Scene, closing: LoopChoices, formulas: Formulas, outputs: tuple[Quantity, ...], mode: Mode = ()
) -> Variations:
    """Return the functions of a scene, its parameters free, under formulas of driving forces by velocity.

    Raises:
        DerivationError: loops cannot be assembled, or friction is ideal.
    """
    return _written(scene, closing, formulas, outputs, mode)


@growing()
def _written(
    scene: Scene, closing: LoopChoices, formulas: Formulas, outputs: tuple[Quantity, ...], mode: Mode
) -> Variations:
    scene = scene_in_mode(scene, mode)
    refuse_ideal_friction(scene)
    if not mode:
        scene.refuse_contacts(
            f"linearization without a mode, {argument('mode', {one.name: 'open' for one in scene.unilaterals})},",
            DerivationError,
        )
    w = Workspace(scene, closing)
    graph, state, n = w.graph, w.state, w.state.n
    places = dict(formulas)
    zero = graph.zero
    letters, owned = w.inputs, w.states
    u, a = (*state.qd, *owned), (*state.qdd, *(graph.symbol(acceleration_name(str(one.value))) for one in owned))
    more = len(owned)
    acting = {one: one + places[k].express(graph) if k in places else one for k, one in enumerate(letters, n)}
    push = substitute([places[k].express(graph) if k in places else zero for k in range(n)], acting)
    acting |= {tau: tau + force for tau, force in zip(state.tau, push, strict=True)}
    push += [zero] * more
    held = HeldContacts.of(w, mode)
    bias, G, residual, holding = _rows(w, held)
    first = len(G) - len(w.prescribed.place) - len(held.rows)
    bias = substitute(bias, {one: acting[one] for one in letters})
    G = [[*row, *[zero] * more] for row in G]
    rates = [graph.total(entry * x for entry, x in zip(row, u, strict=True)) for row in G]
    multipliers = tuple(graph.symbol(f"lambda[{k}]") for k in range(len(G)))
    pulled = [graph.total(row[k] * x for row, x in zip(G, multipliers, strict=True)) for k in range(n + more)]
    rubbed = [*held.friction(w, multipliers[first:]), *[zero] * more]
    pulled = [x + y for x, y in zip(pulled, rubbed, strict=True)]
    balance = [*w.forces(list(state.qdd)), *(x - rate for x, rate in zip(a[n:], w.state_rates, strict=True))]
    forces = substitute(balance, {one: acting[one] for one in letters})
    along = [*w.directions.along, *({} for _ in owned)]
    own = list(letters)

    def columns(entries: Sequence[Expr], *groups: Sequence[Mapping[Expr, Expr]]) -> tuple[tuple[int, int], list[Expr]]:
        seeds = [dict(one) for group in groups for one in group]
        found = [tangents(entries, one) if entries else [] for one in seeds]
        return (len(entries), len(seeds)), [column[i] for i in range(len(entries)) for column in found]

    def each(symbols: Sequence[Expr]) -> list[dict[Expr, Expr]]:
        return [{one: graph.one} for one in symbols]

    by_u, by_a = each(u), each(a)
    balance = [f - p - r for f, p, r in zip(forces, push, pulled, strict=True)]
    swept = columns(balance, along, by_u, by_a, each(own))
    if not scene.is_constrained and not scene.given:  # in the formulation that is preferred
        direct = derive_one(w, "inverse_dynamics_derivatives")
        others = columns([p + r for p, r in zip(push, pulled, strict=True)], along, by_u, by_a)
        swept = (n, 3 * n), [x - y for x, y in zip(direct.entries, others[1], strict=True)]
    still = dict.fromkeys([*a, *multipliers], zero)
    resting = [
        one - p - r for one, p, r in zip(substitute(forces, still), push, substitute(pulled, still), strict=True)
    ]
    moving = [c + graph.dot(row, a) for c, row in zip(bias, G, strict=True)]
    along_q = [along_k.get(one, zero) for one in state.q for along_k in along]
    led = [[zero] * (len(G) - len(x)) + [-one for one in x] for x in (w.prescribed.position, w.prescribed.velocity)]
    apart, slides = (substitute(some, {one: acting[one] for one in letters}) for some in led)
    missed = [x + y for x, y in zip(rates, slides, strict=True)]
    leading = dict(zip(w.prescribed.place, multipliers[len(G) - len(w.prescribed.place) :], strict=True))
    drives = {
        state.tau[k]: acting[state.tau[k]] + force for k, force in leading.items()
    }  # what prescribed motions take
    y = on_graph(w, outputs, multipliers, acting | drives)
    return Variations(
        w, u, a, multipliers, tuple(holding), tuple(one.name for one in scene.inputs),
        dict(enumerate((name for name, *_ in held.rows), first)),
        block(
            M=columns(forces, by_a), h=((len(u),), resting), G=((len(G), len(u)), [x for row in G for x in row]),
            P=columns(pulled, each(multipliers)),
            b=((len(G),), bias), r=((len(G),), residual), s=((len(G),), rates), push=((len(u),), push),
            H=((len(state.q), len(u)), along_q), inputs=((len(own),), [acting[one] for one in own]),
        ),
        block(
            e=swept, p=columns(push, along, by_u, by_a, each(own)), c=columns(moving, along, by_u, each(own)),
            s=columns(missed, along, each(own)), r=columns(apart, each(own)),
        ),
        block(y=((len(y),), y), y_=columns(y, along, by_u, by_a, each(multipliers), each(state.tau), each(own))),
    )  # fmt: skip


def _rows(w: Workspace, held: HeldContacts) -> tuple[list[Expr], list[list[Expr]], list[Expr], list[bool]]:
    """Return Ġ u, G and residuals of independent rows, of contacts and of prescribed motions; which hold positions."""
    graph, n = w.graph, w.state.n
    bias: list[Expr] = []
    G: list[list[Expr]] = []
    residual: list[Expr] = []
    holding: list[bool] = []
    if w.scene.is_constrained:
        rows, kept = w.loops.recursive, w.loops.decisions.independent_rows
        bias, G, residual = w.loops.bias(rows), w.loops.G(rows), w.loops.residual(rows)
        holding = [rows.labels[k].holonomic for k in kept]
    for _, row, gap, holds in held.rows:
        bias, G = [*bias, row.bias], [*G, list(row.entries)]
        residual, holding = [*residual, gap], [*holding, holds]
    for k, acceleration in zip(w.prescribed.place, w.prescribed.acceleration, strict=True):
        bias.append(-acceleration)
        G.append([graph.one if i == k else graph.zero for i in range(n)])
        residual.append(graph.zero)
        holding.append(True)
    return bias, G, residual, holding
