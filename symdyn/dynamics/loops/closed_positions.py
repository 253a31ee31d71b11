"""Positions of closed mechanisms: in closed form where a loop is planar, else assembled and followed in numbers.

Closed forms are those of planar loops with two unknown joints: four-bars, slider-cranks, chains of them. Walk a loop
from the cut J to the same P again, as `constraint_rows` does. The unknown positions are u and v, all else is known:

    U, V          origins of the two joints       z     normal of the plane
    d0, d1, d2    J → U,  U → V,  V → P, each in axes on the predecessor side of the unknown joint before it, and along
                  the plane: what lies across it adds up to nothing, and is no side of a triangle

Two turns make a triangle J U V with known sides l0, l1, l2. Its angle at U is γ with

    tan(γ/2)² = (l2 - l1 + l0) (l2 + l1 - l0) / ((l0 + l1 - l2) (l0 + l1 + l2))

which keeps all digits at the folds, where the cosine of γ would leave half of them. A turn and a slide along s make a
line that meets a circle of radius l: x = -s·d ± sqrt((l - h) (l + h)), h = z·(s × d). The second unknown follows from
the direction that remains. A cut that slides along s adds an unknown x and tells the sum of the turns, A B R = 1: of
two turns d0 + Rᵀ d2 - s x = -A d1 is a line and a circle again; a turn is known, and a slide beside it has two lines
meet. Which of two signs is the branch is read off the assembled position, and stays. Angles are found modulo a turn.

In numbers Newton's method from the last position keeps the branch as long as steps are short: a step is halved where
the loops do not close from it, or where it takes a joint further than its tangent says. Velocities solve G u = 0.

Position-level rows decide which positions are independent, whatever else rolls: a wheel's normal row is one, a row
along its track is none. Dependent velocities of these are dependent ones of all rows, so that independent velocities
move independent positions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain, groupby
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics.loops.assembly import Assembly
from symdyn.dynamics.loops.constraint_rows import Cut, cuts
from symdyn.dynamics.loops.loop_decisions import LoopDecisions, pivots, unit_rows
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.loops.newton import NEGLIGIBLE
from symdyn.dynamics.loops.partition import LoopBlock, Partition, blocks
from symdyn.dynamics.mechanism.tree import Tree
from symdyn.errors import DerivationError, choice, listed
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, evaluate, substitute
from symdyn.scene import Scene
from symdyn.spatial import Mat, Transform, Vec, add, cross, dot, neg, scale, sub, zero_vector

if TYPE_CHECKING:
    from symdyn.dynamics.outputs.workspace import Workspace

CLOSED = 1e-6
"""Most by which a closed form may miss the assembled position, rad and m."""


@dataclass(frozen=True)
class _Unknown:
    """An unknown joint on the way round a loop: its velocity, whether it slides, its sense, axis s or z before it."""

    velocity: int
    slides: bool
    sense: int
    axis: Vec


FORCE, COUPLE = (True, False), (False, True)
"""What the wrench of a row has: two forces hold a pin in the plane, a force and a couple a slide."""


def positions(w: Workspace) -> list[Expr]:
    """Return q, shape (nq,), by independent coordinates; DerivationError where a loop has no closed form."""
    values: dict[Expr, Expr] = {}
    basis, labels = w.loops.decisions.independent_rows, w.loops.recursive.labels
    by_name = {cut.owner: cut for cut in cuts(w.scene, w.graph) if cut.joint}
    if any(q not in w.state.q for q in w.loops.coordinates) or w.state.n != len(w.state.q):
        raise _none(w, "a joint of it is described by a quaternion")
    every = w.loops.decisions.partition.blocks
    for _, some in groupby(every, lambda block: {labels[basis[r]].words for r in block.rows}):
        parts = zip(*((one.rows, one.velocities) for one in some), strict=True)
        block = LoopBlock(*(tuple(chain(*one)) for one in parts))  # of a slide each row may tell one unknown
        rows = [labels[basis[r]] for r in block.rows]
        ties = list(dict.fromkeys(one.words for one in rows))
        if len(rows) != 2 or len(ties) != 1 or not all(one.loop for one in rows):
            raise _none(w, f"they need a loop with two unknowns, against {len(rows)} from {listed(ties)}")
        wrenches = [tuple(any(not x.is_zero for x in part) for part in one.wrench or ((), ())) for one in rows]
        if sorted(wrenches) not in ([FORCE, FORCE], [COUPLE, FORCE]):
            kind = next(one.type for one in w.scene.loops if one.name == rows[0].owner)
            raise _none(w, f"{ties[0]} is cut at a {kind} joint (cut at a revolute one it may have one)")
        slide = rows[wrenches.index(FORCE)].wrench if COUPLE in wrenches else None
        values |= _solve(w, by_name[rows[0].owner], block, values, slide and slide[0])
    return [values.get(q, q) for q in w.state.q]


def _none(w: Workspace, why: str) -> DerivationError:
    there = dict(zip(w.state.q, zip(w.scene.coordinates, w.loops.decisions.assembly.q, strict=True), strict=True))
    free = [there.get(w.loops.coordinates[k]) for k in w.loops.position_level[1].independent]
    laws = ", ".join(f'"{one[0]}": {one[1]:.3g}' for one in free if one)
    call = f"inverse(scene, {{{laws}}}, times=[0.0])" if all(free) else "simulate(scene, until=1)"
    told = f"{w.scene.name}: positions have no closed form here: {why}"
    return DerivationError(f"{told}; symdyn.{call}.q has them in numbers")


def _solve(w: Workspace, cut: Cut, block: LoopBlock, known: dict[Expr, Expr], across: Vec | None) -> dict[Expr, Expr]:
    """Return the two coordinates of a block's velocities, with `known` ones put in; `across` is to a cut's slide."""
    unknowns, ways, z, R = _way_round(w, w.tree, cut, block)
    d0, d1, d2 = (sub(way, scale(dot(way, z), z)) for way in ways)  # bodies may lie in planes one above the other
    q = [w.loops.coordinates[one.velocity] for one in unknowns]
    first, second = unknowns
    signs = [w.graph.constant(sign) for sign in (1, -1)]
    if across is None:
        candidates = [_with_sign(sign, first, second, d0, d1, d2, z) for sign in signs]
    else:
        s = cross(z, across)
        s = scale(w.graph.one / w.graph.sqrt(dot(s, s)), s)
        candidates = [_with_slide(sign, first, second, d0, d1, d2, z, s, R) for sign in signs]
    settled = [tuple(substitute(pair, known)) for pair in candidates]
    return dict(zip(q, _branch(w, unknowns, settled), strict=True))


def _way_round(w: Workspace, tree: Tree, cut: Cut, block: LoopBlock) -> tuple[list[_Unknown], list[Vec], Vec, Mat]:
    """Return the unknown joints in the order of the walk, d0, d1, d2, z, and the axes at P while unknowns are zero."""
    graph = tree.graph
    i, at_parent = tree.home[cut.parent]
    j, at_child = tree.home[cut.child]
    last = at_child @ cut.on_child
    inner, outer = tree.paths(i, j)
    walk = [(b, -1) for b in inner] + [(b, 1) for b in outer]
    T = (at_parent @ cut.on_parent).inverse()
    still = zero_vector(graph)
    unknowns: list[_Unknown] = []
    ways = [T.p]
    normal: Vec | None = None

    def step(T: Transform) -> Transform:
        """Add a way to the last one; what is left is a turn."""
        ways[-1] = add(ways[-1], T.p)
        return Transform(T.R, still)

    T = Transform(T.R, still)
    for b, sense in walk:
        turns, slides = tree.S[b]
        before = T.R if sense < 0 else (T @ tree.base[b]).R
        if not all(x.is_zero for x in turns):
            axis = before @ turns
            normal = axis if normal is None else normal
            if axis != normal and axis != neg(normal):
                raise _none(w, f"the axes of the loop {cut.owner} are not written as parallel")
        if not any(k in block.velocities for k, _ in tree.A[b]):
            T = step(T @ (tree.T[b].inverse() if sense < 0 else tree.T[b]))
            continue
        if len(tree.A[b]) != 1 or tree.A[b][0][1] is not graph.one:
            raise _none(w, f"unknown joints of the loop {cut.owner} are coupled")
        is_slide = all(x.is_zero for x in turns)
        if sense > 0:  # the constant part, then the joint's motion is left out
            T = step(T @ tree.base[b])
        axis = T.R @ (slides if is_slide else turns)
        unknowns.append(_Unknown(tree.A[b][0][0], is_slide, sense, axis))
        ways.append(still)
        if sense < 0:
            T = step(T @ tree.base[b].inverse())
    ways[-1] = add(ways[-1], T.R @ last.p)
    if len(unknowns) != 2 or normal is None or all(one.slides for one in unknowns):
        raise _none(w, f"the loop {cut.owner} has no two unknowns of which one turns")
    return unknowns, ways, normal, T.R @ last.R


def _with_sign(sign: Expr, first: _Unknown, second: _Unknown, d0: Vec, d1: Vec, d2: Vec, z: Vec) -> tuple[Expr, Expr]:
    """Return the two coordinates on one branch; all vectors are in axes of J with both unknowns at zero.

    J + d0 + A (d1 + B d2) = J with A, B the motions of the two joints.
    """
    graph = sign.graph
    if first.slides:  # d0 + d1 + x s + B d2 = 0
        d, s = add(d0, d1), scale(first.sense, first.axis)
        x = _on_circle(d, s, z, dot(d2, d2), sign)
        turned = _angle(d2, neg(add(d, scale(x, s))), second.axis)
        return x, second.sense * turned
    if second.slides:  # d0 + A (d1 + d2 + x s) = 0
        d, s = add(d1, d2), scale(second.sense, second.axis)
        x = _on_circle(d, s, z, dot(d0, d0), sign)
        return first.sense * _angle(add(d, scale(x, s)), neg(d0), first.axis), x
    l0, l1, l2 = (graph.sqrt(dot(d, d)) for d in (d0, d1, d2))
    above = graph.sqrt((l2 - l1 + l0) * (l2 + l1 - l0))
    below = graph.sqrt((l0 + l1 - l2) * (l0 + l1 + l2))
    half = graph.function(Op.ATAN2, above, below)
    phi = _angle(d1, neg(d0), first.axis) + sign * 2 * half  # turns U → V to γ off U → J
    to_v = add(d0, _turned(d1, phi, first.axis))
    at_zero = _turned(d2, phi, first.axis)
    return first.sense * phi, second.sense * _angle(at_zero, neg(to_v), second.axis)


def _with_slide(
    sign: Expr, first: _Unknown, second: _Unknown, d0: Vec, d1: Vec, d2: Vec, z: Vec, s: Vec, R: Mat
) -> tuple[Expr, Expr]:
    """Return the two coordinates on one branch where the cut slides along s: d0 + A (d1 + B d2) = x s, A B R = 1."""

    def on_line(d: Vec, way: Vec) -> Expr:  # d + y way is along s
        return -dot(z, cross(s, d)) / dot(z, cross(s, way))

    if first.slides:
        y = on_line(add(add(d0, d1), R.T @ d2), scale(first.sense, first.axis))
        return y, second.sense * _angle(R @ s, s, second.axis)
    if second.slides:
        y = on_line(add(d0, R.T @ add(d1, d2)), R.T @ scale(second.sense, second.axis))
        return first.sense * _angle(R @ s, s, first.axis), y
    d = add(d0, R.T @ d2)
    x = _on_circle(d, s, z, dot(d1, d1), sign)
    phi = _angle(d1, neg(add(d, scale(x, s))), first.axis)
    rest = -phi if first.axis == second.axis else phi
    return first.sense * phi, second.sense * (_angle(R @ s, s, second.axis) + rest)


def _on_circle(d: Vec, s: Vec, z: Vec, square: Expr, sign: Expr) -> Expr:
    """Return x with |d + x s|² = square, s a unit vector."""
    h, radius = dot(z, cross(s, d)), d[0].graph.sqrt(square)
    return sign * d[0].graph.sqrt((radius - h) * (radius + h)) - dot(s, d)


def _angle(a: Vec, b: Vec, z: Vec) -> Expr:
    """Return the angle about z from a to b, rad."""
    return a[0].graph.function(Op.ATAN2, dot(z, cross(a, b)), dot(a, b))


def _turned(a: Vec, angle: Expr, z: Vec) -> Vec:
    """Return a vector of the plane turned about its normal."""
    graph = angle.graph
    return add(scale(graph.cos(angle), a), scale(graph.sin(angle), cross(z, a)))


def _branch(w: Workspace, unknowns: Sequence[_Unknown], candidates: Sequence[tuple[Expr, ...]]) -> tuple[Expr, ...]:
    """Return the candidate that is at the assembled position; none is where what moves leaves the plane of the loop."""
    known = w.loops.values(w.loops.decisions.assembly.regular)
    there = np.array([known[w.loops.coordinates[one.velocity]] for one in unknowns])
    slides = np.array([one.slides for one in unknowns])

    def off(pair: tuple[Expr, ...]) -> float:
        try:
            way = np.array(evaluate(pair, Floats(), known)) - there
        except (ArithmeticError, ValueError):
            return float("inf")
        return float(np.abs(np.where(slides, way, np.sin(way / 2))).max())

    found = min(candidates, key=off)
    if off(found) > CLOSED:
        raise _none(w, "a loop does not stay in a plane")
    return found


FINEST = 2.0**-20
"""Part of a step of the path below which it is given up."""

STRAIGHT = 0.1
"""Radians or metres by which a joint may leave its tangent in one step."""


def assemble(
    scene: Scene,
    guess: Mapping[str, float] | None = None,
    held: Sequence[str] | None = None,
    parameters: Mapping[str, float] | None = None,
) -> Assembly:
    """Return a position at which every loop is closed.

    Args:
        scene: the mechanism.
        guess: coordinates to begin with, beside those of the scene's `start`; rad, m or 1.
        held: coordinates that keep their guess; None holds those with a drive, unless the loops do not close so.
        parameters: values of the free parameters.

    Raises:
        DerivationError: the loops cannot be assembled from the guess, or a name or value is missing.
    """
    numbers = _numbers(scene, parameters)
    q = None
    if guess is not None:
        q = numbers.start()
        for name, value in guess.items():
            q[_index(scene, scene.coordinates, name)] = value
    return numbers.closed_position(q, None if held is None else [_velocity(scene, name) for name in held])


def follow(scene: Scene, begin: Assembly, path: Mapping[str, Sequence[float]]) -> Array:
    """Return closed positions along a path, on the branch where it begins.

    Args:
        scene: the mechanism.
        begin: where it begins.
        path: values of the coordinates that lead, all equally many; rad or m.

    Returns:
        q at every point of the path, shape (points, nq).

    Raises:
        DerivationError: the loops do not close at a point of the path: it ends before, at a fold or a change point.
    """
    numbers = _numbers(scene, dict(begin.parameters))
    leading = [_index(scene, scene.coordinates, name) for name in path]
    locked = [_velocity(scene, name) for name in path]
    q, found = np.array(begin.q), []
    for goal in np.array(list(path.values()), dtype=np.float64).T:
        q = _stepped_to(numbers, q, leading, locked, goal, begin.rank)
        found.append(q)
    return np.array(found).reshape(-1, len(scene.coordinates))


def _stepped_to(numbers: Numbers, q: Array, leading: list[int], locked: list[int], goal: Array, rank: int) -> Array:
    """Return the closed position with the leading coordinates at their goal, in as many steps as it takes."""
    step, done = 1.0, 0.0
    begin = q[leading]
    while done < 1.0:
        step = min(step, 1.0 - done)
        way = (begin + (done + step) * (goal - begin)) - q[leading]
        tangent = _tangent(numbers, q, locked, way)
        guess = numbers.retract(q, tangent)
        guess[leading] = begin + (done + step) * (goal - begin)
        tried = numbers.newton(guess, locked)
        if numbers.is_closed(tried) and float(np.abs(tried - guess).max()) < STRAIGHT:
            q, done, step = tried, done + step, 2 * step
            continue
        step /= 2
        if step < FINEST:
            values = np.linalg.svd(numbers.dimensionless(q, 1.0), compute_uv=False)
            smallest = values[rank - 1] if rank else 0.0
            names = ", ".join(
                f"{numbers.scene.coordinates[k]} = {x:.6g}" for k, x in zip(leading, q[leading], strict=True)
            )
            raise DerivationError(
                f"{numbers.scene.name}: the path ends at {names}: the loops do not close beyond, a turning or change "
                f"point; the smallest singular value of their constraints there is {smallest:.3g}"
            )
    return q


def _tangent(numbers: Numbers, q: Array, locked: list[int], way: Array) -> Array:
    """Return the step along the velocities that the loops allow, with the locked ones given."""
    G = numbers.jacobian(q)
    free = [k for k in range(numbers.state.n) if k not in locked]
    step = np.zeros(numbers.state.n)
    step[locked] = way
    if free and len(G):
        step[free] = np.linalg.lstsq(G[:, free], -G[:, locked] @ way, rcond=1e-10)[0]
    return step


def consistent(scene: Scene, assembly: Assembly, rates: Mapping[str, float] | None = None) -> Array:
    """Return velocities that constraint rows allow, shape (nv,).

    Args:
        scene: the mechanism.
        assembly: a closed position.
        rates: some velocities; None takes those that joints give as `start_rates`. The rest follows from them; what
            does not is zero.

    Raises:
        DerivationError: the given velocities contradict each other.
    """
    numbers = _numbers(scene, dict(assembly.parameters))
    if rates is None:
        given = numbers.declared_rates()
    else:
        given = {_index(scene, scene.velocities, name): value for name, value in rates.items()}
    return numbers.fitting_rates(np.array(assembly.q), given)


def _numbers(scene: Scene, parameters: Mapping[str, float] | None) -> Numbers:
    known = dict(parameters or {})
    missing = [parameter.name for parameter in scene.free_parameters if parameter.name not in known]
    if missing:
        raise DerivationError(
            f"{scene.name}: {', '.join(missing)} {'has' if len(missing) == 1 else 'have'} no value; give parameters"
        )
    return Numbers(scene).bound_to(known)


def _velocity(scene: Scene, coordinate: str) -> int:
    """Return the velocity that is the rate of a coordinate."""
    k = 0
    for joint in scene.moving:
        if coordinate in joint.coordinates:
            if joint.velocities:
                raise DerivationError(f"{scene.name}: {coordinate} has no velocity of its own, so it cannot be held")
            return k + joint.coordinates.index(coordinate)
        k += len(joint.rates)
    told = choice(coordinate, scene.coordinates)
    raise DerivationError(f"{scene.name}: there is no coordinate {coordinate!r}; {told}")


def _index(scene: Scene, names: Sequence[str], name: str) -> int:
    if name not in names:
        raise DerivationError(f"{scene.name}: there is no {name!r}; {choice(name, names)}")
    return list(names).index(name)


def position_level(numbers: Numbers, decisions: LoopDecisions) -> tuple[tuple[int, ...], Partition]:
    """Return the position-level rows, counted among all, and their partition, independent velocities first."""
    kept = [k for k, one in enumerate(numbers.constraints.labels) if one.holonomic and k not in decisions.zero_rows]
    partition, n = decisions.partition, numbers.state.n
    if set(decisions.independent_rows) <= set(kept):
        return decisions.independent_rows, partition
    G = numbers.dimensionless(np.array(decisions.assembly.regular), decisions.assembly.length)
    count = int(np.linalg.matrix_rank(G[kept], tol=NEGLIGIBLE * float(np.abs(G).max()))) if kept else 0
    chosen = tuple(sorted(kept[i] for i in pivots(unit_rows(G[kept]), [list(range(len(kept)))], count)[0]))
    among = sorted(partition.dependent, reverse=True)
    dependent = tuple(sorted(pivots(G[list(chosen)].T, [among], count)[0]))
    independent = (*partition.independent, *(k for k in partition.dependent if k not in dependent))
    rows = [numbers.constraints.G[k] for k in chosen]
    assert len(independent) + len(dependent) == n, "a velocity is one or the other"
    return chosen, Partition(
        independent, dependent, tuple(blocks([[k for k in dependent if not row[k].is_zero] for row in rows]))
    )
