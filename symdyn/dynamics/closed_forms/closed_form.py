"""Closed forms of Lagrange's coefficients: every k_z, k_C, k_D, k_G as a trigonometric polynomial in normal form.

Positions are differentiated, as in lagrange.py, but over the ring and one coordinate at a time. K does not depend on
the frame in which a body's velocity is written, so it is written in the body, where the inertia is constant:

    T = (R, p)   placement of body B in a frame that stands before joint i
    X_i          ∂/∂q_i for a rate of a coordinate, else the derivative along velocity i: kinematics.py
    v_i          Rᵀ X_i p            velocity of B's origin for u_i = 1, body frame
    w_i          (Rᵀ X_i R)∨         angular velocity for u_i = 1, body frame
    k_z          M_ij = Σ_B m v_i·v_j + v_i·(w_j × h) + v_j·(w_i × h) + w_i·I w_j      h = m r, I about B's origin
    k_C, k_D     from X M and the brackets of the velocities, signs as in kinematics.py; k_G = X P
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, product
from typing import Any

from symdyn.algebra import AngleGroup, Compactor, Form, Polynomial, Symbol, TrigonometricRing
from symdyn.arguments import suggesting
from symdyn.dynamics.closed_forms.coefficient_key import (
    MOST_TERMS,
    ClosedLoads,
    Key,
    Slopes,
    check_key,
    closed_loads,
    load_nodes,
    ordered_graph,
    too_long,
)
from symdyn.dynamics.closed_forms.constraint_forms import angle_groups
from symdyn.dynamics.mechanism.kinematics import directions
from symdyn.dynamics.mechanism.state import State, body_placements, moved_placements, vector
from symdyn.dynamics.mechanism.tree import body_inertia
from symdyn.errors import DerivationError, listed
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.scene.forces import elastic
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.shown import Shown
from symdyn.spatial import Inertia, Mat, Transform, dot, zero_vector
from symdyn.unlocked import cached_property

Row = tuple[Polynomial, ...]
Matrix = tuple[Row, ...]


@dataclass(frozen=True)
class ClosedForm(Shown):
    """All coefficients of Lagrange's equations of a scene, elements of `ring` in normal form.

    Attributes:
        scene: the mechanism.
        ring: where the coefficients live.
        state: symbols of q, u on the ring's graph.
        slopes: derivatives X along the velocities.
        parallel: joints that turn about parallel axes; sums of their angles make short forms.
        M: k_z, shape (n, n); kg m^2, kg m or kg.
        k_D: multiplies u_j², shape (n, n).
        k_C: multiplies u_j u_k, j < k in lexicographic order, shape (n, n(n-1)/2).
        k_G: gravity and nothing else, shape (n,); N m or N.
        K, P: kinetic energy, potential energy of gravity, J.
        loads: struts, friction and loads, whose forms are no polynomials.
    """

    scene: Scene
    ring: TrigonometricRing
    state: State
    slopes: Slopes
    parallel: tuple[AngleGroup, ...]
    M: Matrix
    k_D: Matrix
    k_C: Matrix
    k_G: Row
    K: Polynomial
    P: Polynomial
    loads: ClosedLoads

    def __repr__(self) -> str:
        coordinates = listed(self.scene.coordinates)
        return f"<ClosedForm of {self.scene.name}: k_z, k_C, k_D, k_G, k_E, K and P in {coordinates}>"

    @property
    def n(self) -> int:
        return self.state.n

    def coefficient_names(self) -> list[Key]:
        """Return the keys of all coefficients, row by row: of k_z, k_C, k_D, then k_G, k_E where there are springs."""
        n = range(self.n)
        keys: list[Key] = [("k_z", i, j) for i in n for j in n]
        keys += [("k_C", i, pair) for i in n for pair in range(len(self.k_C[i]))]
        keys += [("k_D", i, j) for i in n for j in n]
        keys += [("k_G", i) for i in n]
        return [*keys, *(("k_E", i) for i in n if elastic(self.scene))]

    def refuse_too_long(self, instead: str) -> None:
        """Raise DerivationError where its coefficients have more terms than anyone reads; `instead` says what works."""
        if (terms := sum(len(self[key]) for key in self.coefficient_names() if key[0] != "k_E")) > MOST_TERMS:
            raise too_long(self.scene, f"its coefficients have {terms} terms", instead)

    def __getitem__(self, key: Key) -> Polynomial:
        """Return one coefficient: ("k_z", i, j), ("k_C", i, pair), ("k_D", i, j), ("k_G", i), ("K",) or ("P",).

        Raises:
            DerivationError: there is no such coefficient; indices count from 0, and k_E has a form only.
        """
        check_key(key, self.n)
        name, *places = key
        if name == "k_E":
            raise DerivationError(f"{key!r} is no polynomial; closed.form(*key) and closed.sympy(*key) write it")
        table = {"k_z": self.M, "k_C": self.k_C, "k_D": self.k_D, "k_G": self.k_G, "K": self.K, "P": self.P}
        value = table[name]
        for i in places:
            value = value[i]
        return value

    def __reduce__(self) -> tuple[Callable[[Scene], ClosedForm], tuple[Scene]]:
        return closed_form, (self.scene,)  # polynomials of FLINT have no bytes to keep

    def form(self, *key: Any) -> Form:
        """Return one coefficient as short as the ring can write it; P with springs; K as Σ k_z,ij q̇_i q̇_j / 2."""
        check_key(key, self.n)
        if key[0] == "k_E":
            return self.loads.elastic(self.compactor, key[1])
        value = self[key]
        if key[0] == "P":
            return Form.sum((self.compactor(value), self.loads.energy(self.compactor)))
        if key[0] != "K":
            return self.compactor(value)
        terms = []
        for i in range(self.n):
            for j in range(i, self.n):
                rates = [Symbol(str(self.state.qd[k].value)) for k in (i, j)]
                speeds = [rates[0].power(2)] if i == j else rates
                form = self.compactor(self.M[i][j] / 2 if i == j else self.M[i][j])
                if form.terms:
                    terms.append(Form.product((form, *speeds)))
        return Form.sum(terms)

    def sympy(self, *key: Any) -> Any:
        """Return one coefficient as a compact SymPy expression; key as in `closed["k_z", 0, 1]`.

        Symbols are real, those of parameters declared positive are positive.
        """
        return self.form(*key).to_sympy([p.name for p in self.scene.parameters if p.positive])

    @cached_property
    def compactor(self) -> Compactor:
        """What turns coefficients into forms; it remembers the parts that coefficients share."""
        return Compactor(self.ring, self.parallel)


@suggesting
def closed_form(scene: SceneLike) -> ClosedForm:
    """Return the closed forms of a scene.

    >>> import symdyn
    >>> closed = symdyn.closed_form(symdyn.example("cart_pole"))
    >>> closed.sympy("k_z", 0, 1)
    -l*mp*cos(theta)/2

    Args:
        scene: a scene, a path or an open file.

    Raises:
        DerivationError: a coordinate stands in a function or a denominator, so that there is no trigonometric
            polynomial; or there are more terms than anyone reads.
    """
    scene = scene_of(scene)
    entries = len(scene.velocities) ** 2 * (len(scene.velocities) - 1) // 2
    if entries > MOST_TERMS:
        raise too_long(scene, f"k_C alone has {entries} entries")
    graph = ordered_graph(scene)
    state = State.of(scene, graph)
    nodes = load_nodes(scene, graph)
    massive = [
        (inertia, list(dict(moved_placements(scene, joint, graph)).items()))
        for joint, body in zip(scene.joints, scene.bodies, strict=True)
        if (inertia := body_inertia(body, graph)) != Inertia.none(graph)
    ]
    massive += _balls(scene, graph)
    potential = _potential(scene, graph)
    along = directions(scene, graph)
    needed = [*state.qd, potential, *nodes.needed, *along.entries]
    for inertia, chain in massive:
        needed += [inertia.m, *inertia.h, *(x for row in inertia.I for x in row)]
        needed += [x for _, T in chain for x in (*T.R[0], *T.R[1], *T.R[2], *T.p)]
    rotors = _rotors(scene, graph)
    needed += [rotor for _, _, rotor in rotors]
    parallel = angle_groups(scene, graph)
    ring = TrigonometricRing(needed, (*state.q, *state.qd), parallel, state.spheres)
    found = dict(zip(needed, evaluate(needed, ring, ring.values(needed)), strict=True))
    slopes = Slopes.over(ring, along)
    M = [[ring.zero] * state.n for _ in range(state.n)]
    for body in massive:
        _add_body(M, body, slopes, found)
        if (terms := sum(len(M[i][j]) for i, j in product(range(state.n), repeat=2) if i <= j)) > MOST_TERMS:
            raise too_long(scene, f"k_z alone has more than {terms} terms")
    for i, j, rotor in rotors:
        M[i][j] = M[i][j] + found[rotor]
    P = found[potential]
    k_C, k_D = _christoffel(M, slopes)
    k_G = tuple(slopes(P, i) for i in range(state.n))
    half = ring.one / 2
    K = half * sum(
        (M[i][j] * found[state.qd[i]] * found[state.qd[j]] for i, j in product(range(state.n), repeat=2)), ring.zero
    )
    loads = closed_loads(scene, state, slopes, nodes, found)
    return ClosedForm(scene, ring, state, slopes, parallel, tuple(map(tuple, M)), k_D, k_C, k_G, K, P, loads)


def _rotors(scene: Scene, graph: Graph) -> list[tuple[int, int, Expr]]:
    """Return each pair of velocities that turn a rotor, and the rotor's inertia seen at them, kg m^2 or kg."""
    number = {velocity: i for i, velocity in enumerate(scene.velocities)}
    rotors = []
    for joint in scene.joints:
        inertia = joint.armature.express(graph)
        if joint.moves and not inertia.is_zero and not JOINTS[joint.type].ball(joint):
            moved = [(number[name], ratio) for name, _, ratio in joint.moved_by(graph)]
            rotors += [(i, j, x * y * inertia) for i, x in moved for j, y in moved]
    return rotors


def _balls(scene: Scene, graph: Graph) -> list[tuple[Inertia, list[tuple[int, Transform]]]]:
    """Return the rotors of spherical joints as bodies that nothing but their joint moves, as `_add_body` takes them."""
    number = {velocity: i for i, velocity in enumerate(scene.velocities)}
    found = []
    for joint in scene.joints:
        a, zero = joint.armature.express(graph), graph.zero
        if not a.is_zero and JOINTS[joint.type].ball(joint):
            X = joint_motion(joint, graph).placement
            inertia = Inertia(zero, zero_vector(graph), Mat.symmetric(a, a, a, zero, zero, zero))
            found.append((inertia, [(number[u], X) for u in joint.rates]))
    return found


def _add_body(
    M: list[list[Polynomial]],
    body: tuple[Inertia, list[tuple[int, Transform]]],
    slopes: Slopes,
    result: dict[Expr, Polynomial],
) -> None:
    """Add one body's share to M; `body` is its inertia and its `moved_placements`."""
    (inertia, moved), ring = body, slopes.ring
    m, h = result[inertia.m], [result[x] for x in inertia.h]
    matrix = [[result[x] for x in row] for row in inertia.I]
    columns = []
    for i, T in moved:
        R = [[result[x] for x in row] for row in T.R]
        dR = [[slopes(x, i) for x in row] for row in R]
        dp = [slopes(result[x], i) for x in T.p]
        v = [ring.dot(column, dp) for column in zip(*R, strict=True)]
        w = [ring.dot((row[a] for row in R), (row[b] for row in dR)) for a, b in ((2, 1), (0, 2), (1, 0))]
        linear = [m * v[k] + x for k, x in enumerate(_cross(w, h))]
        angular = [
            sum((a * b for a, b in zip(row, w, strict=True)), x) for row, x in zip(matrix, _cross(h, v), strict=True)
        ]
        columns.append((i, [*v, *w], [*linear, *angular]))
    for i, motion, _ in columns:
        for j, _, momentum in columns:
            if j >= i:
                M[i][j] = M[j][i] = M[i][j] + ring.dot(motion, momentum)


def _cross(a: list[Polynomial], b: list[Polynomial]) -> list[Polynomial]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _potential(scene: Scene, graph: Graph) -> Expr:
    """Return P = -Σ g·(m p + R h), ground frame."""
    gravity, placed = vector(scene.gravity, graph), body_placements(scene, graph)
    total = graph.zero
    for body in scene.bodies:
        inertia, T = body_inertia(body, graph), placed[body.name]
        total = total - dot(gravity, T.R @ inertia.h) - inertia.m * dot(gravity, T.p)
    return total


def _christoffel(M: list[list[Polynomial]], slopes: Slopes) -> tuple[Matrix, Matrix]:
    """Return k_C and k_D."""
    n = range(len(M))
    slope = {(i, j, k): slopes(M[i][j], k) for i, j in product(n, repeat=2) if i <= j for k in n}

    def d(i: int, j: int, k: int) -> Polynomial:
        return slope[min(i, j), max(i, j), k]

    def turned(j: int, i: int, k: int) -> Polynomial:
        return sum((M[m][k] * value for m, value in slopes.of.brackets.get((j, i), ())), slopes.ring.zero)

    k_C = tuple(
        tuple(d(i, j, k) + d(i, k, j) - d(j, k, i) - turned(j, i, k) - turned(k, i, j) for j, k in combinations(n, 2))
        for i in n
    )
    k_D = tuple(tuple(d(i, j, j) - d(j, j, i) / 2 - turned(j, i, j) for j in n) for i in n)
    return k_C, k_D
