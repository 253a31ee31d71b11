"""Closed forms of the rows that loops and contacts add: residual, G and Ġ u as trigonometric polynomials.

    M u̇ + h = τ + Gᵀ λ,    r(q) = 0,    G u = 0,    G u̇ + Ġ u = 0

They come from the rows by differentiation, in a ring of their own: loops lead from one chain of parallel axes to
another, so that differences of their angles make short forms here, and nowhere else. Angles of joints that turn about
parallel axes add up, and sines of the sums make short closed forms.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations
from operator import itemgetter
from typing import TYPE_CHECKING

from symdyn.algebra import AngleGroup, Compactor, Form, Number, Polynomial, TrigonometricRing
from symdyn.dynamics.closed_forms.coefficient_key import MOST_TERMS, Slopes, ordered_graph
from symdyn.dynamics.mechanism.kinematics import directions
from symdyn.dynamics.mechanism.state import State
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, evaluate, reachable
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, unit
from symdyn.scene.values import Joint
from symdyn.spatial import Vec, dot

if TYPE_CHECKING:
    from symdyn.dynamics.loops.constraint_rows import Constraints, Label


@dataclass(frozen=True)
class Neighbours:
    """A joint that only turns and the next one below it."""

    q: Expr  # the joint's coordinate
    below: Expr | None  # the coordinate of the next revolute joint towards the ground; None if there is none
    alignment: Expr  # cosine of the angle between the two axes, which is ±1 for parallel ones
    stand: str  # name of the body that carries the axis, with joints between that do not turn it
    axis: Vec  # the axis as that body sees it


def _axis(joint: Joint, graph: Graph) -> Vec | None:
    """Return the axis of a joint that turns about it and does nothing else; None of others."""
    kind = JOINTS[joint.type]
    axis = None if kind.slides(joint) else kind.axis(joint)
    return axis and unit(axis, graph)


def _neighbours(joint: Joint, carrier: dict[str, Joint], graph: Graph) -> Neighbours:
    q, axis, below = graph.symbol(joint.coordinate), _axis(joint, graph), joint
    assert axis, "only joints that turn have neighbours"
    while below.parent != Scene.GROUND:
        axis = below.origin.transform(graph).R @ axis
        below = carrier[below.parent]
        axis = below.tip.transform(graph).R @ axis
        kind, other = JOINTS[below.type], _axis(below, graph)
        if (kind.axis(below) is None and kind.velocities(below)) or (other and below.coupling):
            return Neighbours(q, None, graph.zero, below.child, axis)  # no angle of the ring
        if other:
            return Neighbours(q, graph.symbol(below.coordinate), dot(axis, other), below.child, axis)
    return Neighbours(q, None, graph.zero, Scene.GROUND, below.origin.transform(graph).R @ axis)


def angle_groups(scene: Scene, graph: Graph, across: bool = False) -> tuple[AngleGroup, ...]:
    """Return the groups of two and more joints with parallel axes, with every sum of angles along a path.

    `across` makes chains that stand side by side on one body, or on the ground, one group, as loops between them need;
    the differences of their total angles are then among the sums.
    """
    carrier = {joint.child: joint for joint in scene.joints}
    turning = [joint for joint in scene.joints if _axis(joint, graph) and not joint.coupling]
    neighbours = [_neighbours(joint, carrier, graph) for joint in turning]
    beside = {
        (one.q, pair.q): dot(one.axis, pair.axis)
        for k, pair in enumerate(neighbours)
        for one in neighbours[:k]
        if across and one.stand == pair.stand
    }
    nodes = [*(pair.alignment for pair in neighbours), *beside.values()]
    ring = TrigonometricRing(nodes)  # where "equal to ±1" is decided, exactly
    found = dict(zip(nodes, evaluate(nodes, ring, ring.values(nodes)), strict=True))
    members: list[list[Expr]] = []
    signs: dict[Expr, int] = {}
    previous: dict[Expr, Expr] = {}
    group: dict[Expr, int] = {}

    def parallel(cosine: Expr) -> int:
        return next((sign for sign in (1, -1) if ring.is_zero(found[cosine] - sign)), 0)

    for pair in neighbours:
        relative = parallel(pair.alignment)
        twin = next((a for (a, b), cosine in beside.items() if b is pair.q and parallel(cosine)), None)
        if pair.below is not None and relative:
            group[pair.q], signs[pair.q] = group[pair.below], signs[pair.below] * relative
            previous[pair.q] = pair.below
        elif twin is not None:
            group[pair.q], signs[pair.q] = group[twin], signs[twin] * parallel(beside[twin, pair.q])
        else:
            group[pair.q], signs[pair.q] = len(members), 1
            members.append([])
        members[group[pair.q]].append(pair.q)
    return tuple(_group(atoms, signs, previous) for atoms in members if len(atoms) > 1)


def _group(atoms: list[Expr], signs: dict[Expr, int], previous: dict[Expr, Expr]) -> AngleGroup:
    """Return the group with the sums q_a ± … ± q_b over every stretch of every path, the first sign positive.

    Where paths stand side by side, the differences of their total angles follow.
    """
    sums, totals = [], []
    for end in atoms:
        path: list[Expr] = []
        joint: Expr | None = end
        while joint is not None:
            path.append(joint)
            first = signs[joint]
            sums.append(tuple(first * signs[atom] if atom in path else 0 for atom in atoms))
            joint = previous.get(joint)
        totals.append((path[-1], tuple(signs[atom] * (atom in path) for atom in atoms)))
    for k, (root, b) in enumerate(totals):
        for other, a in totals[:k]:
            if other is not root:
                difference = [x - y for x, y in zip(a, b, strict=True)]
                first = next(x for x in difference if x)
                sums.append(tuple(first * x for x in difference))
    return AngleGroup(tuple(atoms), tuple(sums), tuple((signs[atom], previous.get(atom)) for atom in atoms))


@dataclass(frozen=True)
class ClosedRow:
    """One row.

    Attributes:
        owner: name of the loop, or of the scene's row.
        loop: whether that is a loop.
        holonomic: whether it is a constraint on positions, so that its residual vanishes too.
        words: what it forbids, such as "force along x".
        uses: for each velocity whether its entry of G may differ from zero.
        residual: what vanishes where the loop is closed; None without a closed form.
        G: entries by velocity; () without a closed form.
        bias: Ġ u by pairs of velocities: (j, k, coefficient of u_j u_k), j <= k, those that vanish left out.
    """

    owner: str
    loop: bool
    holonomic: bool
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
    """Return the rows of a closed scene; DerivationError where it is not known which are independent."""
    from symdyn.dynamics.loops.constraint_rows import differentiated  # trees need none
    from symdyn.dynamics.outputs.workspace import Workspace

    decisions = Workspace(scene).loops.decisions
    graph = ordered_graph(scene)
    state = State.of(scene, graph)
    found = differentiated(scene, graph, state)
    rows = []
    for k in decisions.independent_rows:
        label, uses = found.labels[k], tuple(not entry.is_zero for entry in found.G[k])
        words = _words(label, state, decisions.names[k])
        rows.append(ClosedRow(label.owner, label.loop, label.holonomic, words, uses))
    try:
        return ClosedConstraints(_written(rows, found, decisions.independent_rows, state, graph, scene))
    except DerivationError as fault:
        return ClosedConstraints(tuple(rows), str(fault))


def _words(label: Label, state: State, name: str) -> str:
    """Return what a row forbids; where its direction moves, `name`, read at one position, would mislead."""
    if label.wrench is None or label.name:
        return label.name or "constraint"
    force, moment = label.wrench
    if not set(state.q).intersection(reachable([*force, *moment])):
        return name.removeprefix(f"{label.owner}: ")
    return "moment" if all(x.is_zero for x in force) else "force"


def _written(
    rows: list[ClosedRow], constraints: Constraints, kept: tuple[int, ...], state: State, graph: Graph, scene: Scene
) -> tuple[ClosedRow, ...]:
    needed = [entry for k in kept for entry in (constraints.residual[k], *constraints.G[k])]
    parallel, along = angle_groups(scene, graph, across=True), directions(scene, graph)
    every = [*needed, *state.q, *state.qd, *along.entries]
    ring = TrigonometricRing(every, (*state.q, *state.qd), parallel, state.spheres)
    X = Slopes.over(ring, along)
    value = dict(zip(needed, evaluate(needed, ring, ring.values(needed)), strict=True))
    if (terms := sum(map(len, value.values()))) > MOST_TERMS:
        raise DerivationError(f"they have {terms} terms, and {MOST_TERMS} is the limit")
    compact = Compactor(ring, parallel)
    written = []
    for row, k in zip(rows, kept, strict=True):
        G = [value[entry] for entry in constraints.G[k]]
        slopes = [[X(entry, i) for i in range(state.n)] for entry in G]
        bias = [(i, i, compact(slopes[i][i])) for i in range(state.n)]
        bias += [(i, j, _mixed(compact, slopes[i][j], slopes[j][i])) for i, j in combinations(range(state.n), 2)]
        bias.sort(key=itemgetter(0, 1))
        written.append(
            ClosedRow(
                row.owner,
                row.loop,
                row.holonomic,
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
