"""Names of Lagrange's coefficients, what they multiply, and how many terms of them are still worth printing.

Closed forms of struts, friction and loads are geometry in normal form in laws of force:

    D       squared distance of two points, a trigonometric polynomial     s = √D     ∂s/∂q_i = ∂D/∂q_i / (2 s)
    ṡ       its rate, Σ ∂D/∂q_i q̇_i / (2 s); both may stand by names, which are defined where they are printed
    p, w    Rᵀ ∂p/∂q_i and (Rᵀ ∂R/∂q_i)∨ of the frame of a load, or both in the ground frame
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from operator import index
from typing import Any

from symdyn.algebra import Compactor, Form, Function, Number, Polynomial, Power, Symbol, TrigonometricRing
from symdyn.dynamics.mechanism.kinematics import Directions, directions
from symdyn.dynamics.mechanism.state import (
    State,
    body_placements,
    carried_forces,
    ends_apart,
    joint_forces,
    load_vectors,
    moved_placements,
    resisting,
    stored,
    strut_way,
    vector,
)
from symdyn.errors import DerivationError, quoted
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Expr, Graph, Op, evaluate, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES, elastic
from symdyn.scene.values import Load, Place, Strut
from symdyn.spatial import Transform, Wrench, dot

Key = tuple[Any, ...]  # name and indices from 0, such as ("k_z", 0, 1)

Rates = tuple[tuple[str, int], ...]
"""What a coefficient multiplies: accelerations ("qdd", j) and velocities ("qd", j), j from 0; () for nothing."""

MOST_TERMS = 100_000


def coefficients(n: int) -> dict[str, list[Rates]]:
    """Return the coefficients of Lagrange's equations of n velocities, and what each column of them multiplies.

    τ_i + Q_i = Σ k_z,ij q̈_j + Σ k_C,i,jk q̇_j q̇_k + Σ k_D,ij q̇_j² + k_G,i + k_E,i        sums over j, j < k, j
    """
    return {
        "k_z": [(("qdd", j),) for j in range(n)],
        "k_C": [(("qd", j), ("qd", k)) for j, k in combinations(range(n), 2)],
        "k_D": [(("qd", j), ("qd", j)) for j in range(n)],
        "k_G": [()],
        "k_E": [()],
    }


def check_key(key: object, n: int) -> None:
    """Raise DerivationError unless `key` is that of a coefficient of a mechanism with n coordinates."""
    sizes = {"k_z": (n, n), "k_C": (n, n * (n - 1) // 2), "k_D": (n, n), "k_G": (n,), "k_E": (n,), "K": (), "P": ()}
    name, *places = key if isinstance(key, tuple) and key else (key,)
    shape = sizes.get(name) if isinstance(name, str) else None
    fits = shape is not None and len(places) == len(shape)
    try:  # whole numbers of any library
        fits = fits and all(0 <= index(i) < size for i, size in zip(places, shape or (), strict=True))
    except TypeError:
        fits = False
    if not fits:
        pairs = f"pair in 0..{n * (n - 1) // 2 - 1}" if n > 1 else "no pair, as one coordinate has none"
        raise DerivationError(
            f"there is no coefficient {quoted(key)}; give ('k_z', i, j), ('k_C', i, pair), ('k_D', i, j), ('k_G', i), "
            f"('K',) or ('P',), with i and j in 0..{n - 1} and {pairs}"
        )


def ordered_graph(scene: Scene) -> Graph:
    """Return a graph on which parameters were born first: forms print them in declared order, before coordinates."""
    graph = Graph()
    for parameter in scene.parameters:
        graph.symbol(parameter.name)
    return graph


def too_long(scene: Scene, result: str, else_: str = "") -> DerivationError:
    """Return the error for closed forms too long to be read; `result` says how long, `else_` what also works."""
    return DerivationError(
        f"the closed form of {scene.name} is too long to be of use: {result}, and {MOST_TERMS} is the limit; "
        f"symdyn generate writes NumPy and C code, which grows with the number of joints only{else_}"
    )


WAY, RATE = " x", " v"
"""Names that no scene has."""

Arm = tuple[tuple[Polynomial, ...], tuple[Polynomial, ...]]  # p and w of one velocity


@dataclass(frozen=True)
class Slopes:
    """Derivatives X_i along velocities over a ring; `of` has the same for nodes, `along` its entries in the ring."""

    ring: TrigonometricRing
    of: Directions
    along: tuple[Mapping[Expr, Polynomial], ...]

    @classmethod
    def over(cls, ring: TrigonometricRing, of: Directions) -> Slopes:
        """Return the derivatives of a ring that has the entries of these directions."""
        entries = list(of.entries)
        found = dict(zip(entries, evaluate(entries, ring, ring.values(entries)), strict=True))
        return cls(ring, of, tuple({q: found[h] for q, h in seeds.items()} for seeds in of.along))

    def __call__(self, p: Polynomial, i: int) -> Polynomial:
        """Return X_i p in normal form."""
        ring, rates = self.ring, self.along[i]
        if list(rates.values()) == [ring.one]:
            return ring.derivative(p, *rates)
        return ring.dot(rates.values(), (ring.derivative(p, q) for q in rates))


@dataclass(frozen=True)
class LoadNodes:
    """Nodes whose normal forms are needed.

    Attributes:
        squares: squared distance of the ends of every strut between points.
        told: half its rate where coordinates rest, of struts whose ends move as they are told.
        places: for every load and every velocity that moves it the placement of the point that it acts at: in the
            ground frame, or for a load in body axes in a frame that stands before the joint.
        carried: what loads have by the motion of their bodies, shape (nv,).
    """

    squares: dict[Strut, Expr]
    told: dict[Strut, Expr]
    places: tuple[dict[int, Transform], ...]
    carried: tuple[Expr, ...]

    @property
    def needed(self) -> list[Expr]:
        return [
            *self.squares.values(),
            *self.told.values(),
            *self.carried,
            *(x for moved in self.places for T in moved.values() for row in (*T.R, T.p) for x in row),
        ]


def load_nodes(scene: Scene, graph: Graph) -> LoadNodes:
    """Return what the closed forms of the loads are made of."""
    placed = body_placements(scene, graph) if scene.loads else {}
    squares: dict[Strut, Expr] = {}
    for strut in scene.struts:
        if strut.ends and not strut.is_rope:
            apart = ends_apart(scene, strut.ends, graph)
            squares[strut] = dot(apart, apart)
    seeds = scene.clock(graph)
    rates = zip(squares, tangents([D / 2 for D in squares.values()], seeds) if seeds else [], strict=False)
    told = {strut: rate for strut, rate in rates if not rate.is_zero}
    carrier = {joint.child: joint for joint in scene.joints}
    places = []
    for load in scene.loads:
        moved = dict(moved_placements(scene, carrier.get(load.place.body), graph))
        if load.frame == "ground":
            moved = dict.fromkeys(moved, placed[load.place.body])
        at = vector(scene.seated(load).place.at, graph)
        places.append({i: Transform(T.R, T.point(at)) for i, T in moved.items()})
    return LoadNodes(squares, told, tuple(places), tuple(carried_forces(scene, graph)))


@dataclass(frozen=True)
class ClosedLoads:
    """What acts beside gravity and drives: D and ∂D/∂q_i / 2 of struts between points, p, w of loads by coordinate.

    Of struts whose ends move as they are told there is ∂D/∂t / 2.

    Attributes:
        carried: what loads have by the motion of their bodies, of every coordinate.
        names: of s and ṡ of struts between points, by which they stand in forms; those of others are written out.
    """

    scene: Scene
    state: State
    squares: dict[Strut, Polynomial]
    slopes: dict[Strut, tuple[Polynomial, ...]]
    arms: tuple[dict[int, Arm], ...]
    told: Mapping[Strut, Polynomial]
    carried: tuple[Polynomial, ...]
    names: Mapping[Strut, tuple[str, str]] = field(default_factory=dict)

    def named(self, names: Mapping[Strut, tuple[str, str]]) -> ClosedLoads:
        return replace(self, names=names)

    def alongside(self) -> list[list[Strut]]:
        """Return the struts between points in the scene's order, those together whose length is the same function."""
        found: list[list[Strut]] = []
        for strut, square in self.squares.items():
            same = next((some for some in found if self.squares[some[0]] == square), None)
            if same is None:
                found.append([strut])
            else:
                same.append(strut)
        ropes: dict[tuple[Place, ...], list[Strut]] = {}
        for strut in (one for one in self.scene.struts if one.is_rope and not one.is_ordered):
            ropes.setdefault(strut.ends, []).append(strut)
        return [*found, *ropes.values()]

    def length(self, strut: Strut, compact: Compactor) -> Form:
        """Return s = √D of a strut between points, an amount where D is a square of a sum; or the length of a rope."""
        if strut.is_rope:
            return Form.of(self._position(strut, ordered_graph(self.scene)))
        root = compact.ring.square_root(self.squares[strut])
        if root is not None and len((way := compact(root)).terms) > 1:
            return Function(Op.ABS, (way.plus_first,))
        return Function(Op.SQRT, (compact(self.squares[strut]),))

    def rate(self, strut: Strut, compact: Compactor) -> Form:
        """Return ṡ = Σ ∂D/∂q_i q̇_i / (2 s) of a strut between points, s by its name where it has one."""
        if strut.is_rope:
            slopes = [self._slope(strut, compact, i) for i in range(self.state.n)]
            return self.named({})._rate(strut, slopes)
        shares = zip(self.slopes[strut], self.state.qd, strict=True)
        moved = [compact(slope).signed_product(Symbol(str(u.value))) for slope, u in shares]
        total = Form.sum([*moved, *([compact(self.told[strut])] if strut in self.told else [])])
        return Form.product((total, self._way(strut, compact).power(-1)))

    def energy(self, compact: Compactor) -> Form:
        return Form.sum(self._energy(strut, compact) for strut in elastic(self.scene))

    def elastic(self, compact: Compactor, i: int) -> Form:
        """Return k_E,i."""
        terms = []
        for strut in elastic(self.scene):
            force = self._force(strut, compact, Form.of(ordered_graph(self.scene).zero))
            terms.append(_product(force, self._slope(strut, compact, i)))
        return Form.sum(terms)

    def acting(self, compact: Compactor) -> list[Form]:
        """Return Q of every coordinate."""
        graph = ordered_graph(self.scene)
        forces = [[term.in_powers for term in Form.of(force).terms] for force in joint_forces(self.scene, graph)]
        for strut in resisting(self.scene):
            if strut.ends:
                slopes = [self._slope(strut, compact, i) for i in range(self.state.n)]
                known = strut not in self.told or strut in self.names
                rate = self._rate(strut, slopes) if known else self.rate(strut, compact)
                against = Form.product((Number.MINUS_ONE, self._force(strut, compact, rate)))
                for terms, slope in zip(forces, slopes, strict=True):
                    terms.append(_product(against, slope))
        for load, arm in zip(self.scene.loads, self.arms, strict=True):
            components = [Form.of(x) for part in load_vectors(load, self.scene, graph) for x in part]
            for i, (p, w) in arm.items():
                shares = zip(components, (*p, *w), strict=True)
                forces[i] += [Form.product((force, compact(share))) for force, share in shares]
        for terms, share in zip(forces, self.carried, strict=True):
            terms.append(compact(share))
        return [Form.sum(terms) for terms in forces]

    def _force(self, strut: Strut, compact: Compactor, rate: Form) -> Form:
        graph = ordered_graph(self.scene)
        strut, way = self._stretched(strut, compact)
        law = FORCES[strut.kind].pull.force(strut, graph.symbol(WAY), graph.symbol(RATE))
        return Form.of(law).substitute({WAY: way, RATE: rate})

    def _energy(self, strut: Strut, compact: Compactor) -> Form:
        strut, way = self._stretched(strut, compact)
        energy = stored(strut, ordered_graph(self.scene).symbol(WAY))
        return Form.of(energy).substitute({WAY: way})

    def _stretched(self, strut: Strut, compact: Compactor) -> tuple[Strut, Form]:
        """Return a strut and its way; of a spring whose ends keep their order one free at zero, and its stretch."""
        if not strut.is_ordered:
            return strut, self._way(strut, compact)
        graph = ordered_graph(self.scene)
        stretch = self._position(strut, graph) - strut.free.express(graph)
        ring = TrigonometricRing([stretch])
        (found,) = evaluate([stretch], ring, ring.values([stretch]))
        return replace(strut, free=Quantity.ZERO), Compactor(ring, ())(found).plus_first

    def _way(self, strut: Strut, compact: Compactor) -> Form:
        """Return the position of a joint, the distance of two points or the length of a rope."""
        if strut.joint:
            return Form.of(self._position(strut, ordered_graph(self.scene)))
        return Symbol(self.names[strut][0]) if strut in self.names else self.length(strut, compact)

    def _position(self, strut: Strut, graph: Graph) -> Expr:
        """Return the position of a joint or the length of a rope."""
        return strut_way(self.scene, {} if strut.joint else body_placements(self.scene, graph), strut, graph)

    def _rate(self, strut: Strut, slopes: Sequence[Form]) -> Form:
        """Return the rate of the distance of two points from its derivatives."""
        if strut in self.names:
            return Symbol(self.names[strut][1])
        pairs = zip(slopes, self.state.qd, strict=True)
        return Form.sum(Form.product((slope, Symbol(str(u.value)))) for slope, u in pairs).plus_first

    def _slope(self, strut: Strut, compact: Compactor, i: int) -> Form:
        """Return the derivative of the way along velocity i."""
        if strut.ends and not strut.is_rope:
            share = compact(self.slopes[strut][i])
            return Form.product((share, self._way(strut, compact).power(-1)))
        graph = ordered_graph(self.scene)
        return Form.of(directions(self.scene, graph).derivative([self._position(strut, graph)], i)[0])


def closed_loads(
    scene: Scene, state: State, slopes: Slopes, nodes: LoadNodes, result: Mapping[Expr, Polynomial]
) -> ClosedLoads:
    """Return the closed forms of what acts on a scene; `result` are normal forms of `nodes.needed`."""
    squares = {strut: result[square] for strut, square in nodes.squares.items()}
    halves = {e: tuple(slopes(D, i) / 2 for i in range(state.n)) for e, D in squares.items()}
    arms = []
    for load, moved in zip(scene.loads, nodes.places, strict=True):
        arm: dict[int, Arm] = {}
        acts = load_vectors(load, scene, state.q[0].graph)
        for i, T in sorted(moved.items()):
            R, p = [[result[x] for x in row] for row in T.R], [result[x] for x in T.p]
            arm[i] = _arm(slopes, R, p, i, load, acts)
        arms.append(arm)
    told = {strut: result[rate] for strut, rate in nodes.told.items()}
    carried = tuple(result[x] for x in nodes.carried)
    return ClosedLoads(scene, state, squares, halves, tuple(arms), told, carried)


def _arm(slopes: Slopes, R: list[list[Polynomial]], p: list[Polynomial], i: int, load: Load, acts: Wrench) -> Arm:
    """Return how a placement moves with one velocity, along its own axes or the ground's, where that does work."""
    push, turn = (any(not x.is_zero for x in part) for part in acts)
    dR, dp, ring = [[slopes(x, i) for x in row] for row in R], [slopes(x, i) for x in p], slopes.ring
    none, pairs = (ring.zero,) * 3, ((2, 1), (0, 2), (1, 0))
    if load.frame == "ground":
        return tuple(dp), tuple(ring.dot(dR[a], R[b]) for a, b in pairs) if turn else none
    columns, rates = list(zip(*R, strict=True)), list(zip(*dR, strict=True))
    moved = tuple(ring.dot(column, dp) for column in columns) if push else none
    return moved, tuple(ring.dot(columns[a], rates[b]) for a, b in pairs) if turn else none


def _product(*parts: Form) -> Form:
    """Return a product with equal factors as one power, and a squared root as what stands under it."""
    factors = list[Form]()
    for factor in Form.product(parts).in_powers.factors:
        base, exponent = (factor.base, factor.exponent) if isinstance(factor, Power) else (factor, 1)
        if isinstance(base, Function) and base.op is Op.SQRT:
            pairs = int(exponent / 2)
            factors.append(base.args[0].power(pairs))
            exponent -= 2 * pairs
        factors.append(base.power(exponent))
    return Form.product(factors)
