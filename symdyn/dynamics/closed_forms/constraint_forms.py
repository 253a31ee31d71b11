"""Closed forms of the rows that loops and contacts add: residual, G and Ġ u as trigonometric polynomials.

    M u̇ + h = τ + Gᵀ λ,    r(q) = 0,    G u = 0,    G u̇ + Ġ u = 0

They come from the rows by differentiation, in a ring of their own: loops lead from one chain of parallel axes to
another, so that differences of their angles make short forms here, and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from operator import itemgetter

from symdyn.algebra import Compactor, Form, Number, Polynomial, TrigonometricRing
from symdyn.dynamics.closed_forms.coefficient_key import MOST_TERMS, ordered_graph
from symdyn.dynamics.closed_forms.parallel import angle_groups
from symdyn.dynamics.loops.constraint_rows import Constraints, Label, differentiated
from symdyn.dynamics.mechanism.state import State
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Graph, evaluate, reachable
from symdyn.scene import Scene


@dataclass(frozen=True)
class ClosedRow:
    """One row.

    Attributes:
        owner: name of the loop, or of the scene's row.
        loop: whether that is a loop.
        closes: whether it holds a position, so that its residual vanishes too.
        words: what it forbids, such as "force along x".
        uses: for each velocity whether its entry of G may differ from zero.
        residual: what vanishes where the loop is closed; None without a closed form.
        G: entries by velocity; () without a closed form.
        bias: Ġ u by pairs of velocities: (j, k, coefficient of u_j u_k), j <= k, those that vanish left out.
    """

    owner: str
    loop: bool
    closes: bool
    words: str
    uses: tuple[bool, ...]
    residual: Form | None = None
    G: tuple[Form, ...] = ()
    bias: tuple[tuple[int, int, Form], ...] = ()


@dataclass(frozen=True)
class ClosedConstraints:
    """The rows that functions of the scene keep, one a multiplier; and why they have no closed form, or ""."""

    rows: tuple[ClosedRow, ...]
    missing: str = ""


def closed_constraints(scene: Scene) -> ClosedConstraints:
    """Return the rows of a closed scene; DerivationError where nobody knows which are independent."""
    decisions = Workspace(scene).loops.decisions
    graph = ordered_graph(scene)
    state = State.of(scene, graph)
    found = differentiated(scene, graph, state)
    rows = []
    for k in decisions.kept:
        label, uses = found.labels[k], tuple(not entry.is_zero for entry in found.G[k])
        words = _words(label, state, decisions.names[k])
        rows.append(ClosedRow(label.owner, label.loop, label.closes, words, uses))
    try:
        return ClosedConstraints(_written(rows, found, decisions.kept, state, graph, scene))
    except DerivationError as fault:
        return ClosedConstraints(tuple(rows), str(fault))


def _words(label: Label, state: State, name: str) -> str:
    """Return what a row forbids; where its direction moves, `name`, read at one position, would mislead."""
    if label.wrench is None or label.name:
        return label.name or "row"
    force, moment = label.wrench
    if not set(state.q).intersection(reachable([*force, *moment])):
        return name.removeprefix(f"{label.owner}: ")
    return "moment" if all(x.is_zero for x in force) else "force"


def _written(
    rows: list[ClosedRow], constraints: Constraints, kept: tuple[int, ...], state: State, graph: Graph, scene: Scene
) -> tuple[ClosedRow, ...]:
    """Return the rows with their closed forms."""
    if state.rates != state.qd:
        raise DerivationError("a quaternion's rates are no velocities")
    needed = [entry for k in kept for entry in (constraints.residual[k], *constraints.G[k])]
    parallel = angle_groups(scene, graph, across=True)
    ring = TrigonometricRing([*needed, *state.qd], (*state.q, *state.qd), parallel)
    value = dict(zip(needed, evaluate(needed, ring, ring.values(needed)), strict=True))
    if (terms := sum(map(len, value.values()))) > MOST_TERMS:
        raise DerivationError(f"they have {terms} terms, and {MOST_TERMS} is the limit")
    compact = Compactor(ring, parallel)
    written = []
    for row, k in zip(rows, kept, strict=True):
        G = [value[entry] for entry in constraints.G[k]]
        slopes = [[ring.derivative(entry, q) for q in state.q] for entry in G]
        bias = [(i, i, compact(slopes[i][i])) for i in range(state.n)]
        bias += [(i, j, _mixed(compact, slopes[i][j], slopes[j][i])) for i, j in combinations(range(state.n), 2)]
        bias.sort(key=itemgetter(0, 1))
        written.append(
            ClosedRow(
                row.owner,
                row.loop,
                row.closes,
                row.words,
                tuple(bool(entry) for entry in G),
                compact(value[constraints.residual[k]]),
                tuple(map(compact, G)),
                tuple((i, j, entry) for i, j, entry in bias if entry.terms),
            )
        )
    return tuple(written)


def _mixed(compact: Compactor, a: Polynomial, b: Polynomial) -> Form:
    """Return a + b, the coefficient of a product of two velocities; 2 a where they are equal."""
    return compact(a).signed_product(Number(Fraction(2))) if a == b else compact(a + b)
