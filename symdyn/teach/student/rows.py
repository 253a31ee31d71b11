"""A student's rows of constraints: whether they hold where loops are closed, and the rows that they come nearest to.

    position        r(q) = 0            velocity    G u = 0            acceleration    G u̇ + Ġ u = 0

A row may be written in many ways that are no multiple of the scene's: in the axes of the ground in place of those of a
joint, as a sum of others. All of them vanish wherever the loops are closed, which is looked at in numbers: positions
are assembled for parameters of all values near the scene's, then rates and accelerations drawn that the loops allow.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np

from symdyn.algebra import Array, Form, Symbol
from symdyn.dynamics import Workspace
from symdyn.dynamics.loops import Numbers, differentiated, free_motions
from symdyn.dynamics.mechanism import TIME, State, body_placements, quaternions
from symdyn.dynamics.reactions import JointFrames
from symdyn.emit.print import Printable
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, gradient, reachable, tangents
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import acceleration_name
from symdyn.spatial import Transform, sub

LEVELS = ("position", "velocity", "acceleration")

POSITIONS = 3
SPREAD = 0.04  # of parameters, about the scene's values
WAY = 0.4  # from the scene's start, rad or m
HELD = 1e-8  # of what a formula is worth where the loops are open: what counts as zero


@dataclass(frozen=True)
class StudentRow:
    """One row that a formula is compared with: its name, such as "velocity row 2", and what vanishes."""

    name: str
    form: Form


def level_of(form: Form, scene: Scene) -> str:
    """Return one of LEVELS for the highest derivative in a formula."""
    named = set(form.symbols)
    if named & {acceleration_name(u) for u in scene.velocities}:
        return LEVELS[2]
    return LEVELS[1] if named & set(scene.velocities) else LEVELS[0]


def may_be_row(form: Form, page: Printable) -> bool:
    """Whether a formula has nothing that only equations of motion have: drives, multipliers, masses, gravity."""
    rows = page.constraints.rows
    if not rows:
        return False
    scene = page.scene
    geometry = _geometry(page)
    others = {name for row in page.rows for c in row for name in c.form.symbols} - geometry - set(scene.coordinates)
    others |= {name for right in page.right for name in right.symbols} - set(scene.velocities) - geometry
    others |= {row.multiplier for row in rows} | {drive for drive in scene.drives if drive}
    return not others & set(form.symbols)


def _geometry(page: Printable) -> set[str]:
    """Return the names in the rows: of their closed forms, and of themselves where they have none."""
    parts = [part for row in page.constraints.rows for part in (*row.G, row.residual) if part is not None]
    names = {name for part in parts for name in part.symbols}
    if page.constraints.missing:
        rows = Workspace(page.scene).loops.recursive
        nodes = reachable([*rows.residual, *(entry for row in rows.G for entry in row)])
        names |= {str(node.value) for node in nodes if node.op is Op.SYMBOL}
    return names


def scene_rows(page: Printable, level: str) -> list[StudentRow]:
    """Return the scene's rows of a level, as `symdyn equations` prints them."""
    found = page.constraints
    rows = (found.positions, found.rates, found.accelerations)[LEVELS.index(level)]()
    return [StudentRow(f"{level} row {k}", form) for k, form in enumerate(rows, 1)]


def ground_rows(scene: Scene, level: str) -> list[StudentRow]:
    """Return that the points of each loop's joint coincide, in the axes of the ground: what is written by hand."""
    w = Workspace(scene)
    placed = body_placements(scene, w.graph)
    found = []
    for hinge in w.hanging.loops:
        if not keeps_points(hinge):
            continue
        entries = points_apart(hinge, placed)
        if level != LEVELS[0]:
            entries = tangents(entries, w.state.velocity)
        if level == LEVELS[2]:
            entries = tangents(entries, w.state.acceleration)
        found += [
            StudentRow(f"{level} of {hinge.joint.name} along {axis}", Form.of(x))
            for axis, x in zip("xyz", entries, strict=True)
            if not x.is_zero
        ]
    return found


def keeps_points(hinge: JointFrames) -> bool:
    """Whether a joint keeps two points together."""
    kind = JOINTS.get(hinge.joint.type)  # a contact has none
    return kind is not None and kind.pins(hinge.joint)


def points_apart(hinge: JointFrames, placed: Mapping[str, Transform]) -> list[Expr]:
    """Return the way from a joint's point on the child to that on the parent, m, axes of the ground, shape (3,)."""
    on_parent, on_child = placed[hinge.joint.parent], placed[hinge.joint.child]
    return list(sub(on_parent.point(hinge.origin.p), on_child.point(hinge.place_on_child)))


def holds(form: Form, scene: Scene) -> bool:
    """Whether a formula vanishes wherever the loops are closed, and not everywhere.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    for seed in range(POSITIONS):
        numbers, q = assembled(scene, seed)
        rng = random.Random(f"{scene.name}:{seed}:rates")
        state = _moving(numbers, q, rng)
        off = q + np.array([rng.uniform(-0.3, 0.3) for _ in q])
        wild = {symbol: rng.uniform(0.5, 1.5) for symbol in state}
        value, elsewhere = _value(form, numbers, q, state), _value(form, numbers, off, wild)
        if elsewhere == 0 or abs(value) > HELD * abs(elsewhere):
            return False
    return True


def independent(conditions: Sequence[Form], scene: Scene) -> bool:
    """Whether no condition on positions follows from the others, looked at where the loops are closed.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    numbers, q = assembled(scene, 0)
    rates = [x for form in conditions for x in gradient(form.express(numbers.graph), numbers.state.q)]
    found = np.array(numbers.at(rates, q, {}), dtype=np.float64).reshape(len(conditions), -1)
    return int(np.linalg.matrix_rank(found, tol=1e-7 * np.abs(found).max(initial=1e-300))) == len(conditions)


def assembled(scene: Scene, seed: int, near: bool = True) -> tuple[Numbers, Array]:
    """Return the mechanism with the scene's parameters or near them, no two related, and a closed position."""
    rng = random.Random(f"{scene.name}:{seed}")
    plain = _numbers(scene)
    values = {p.name: plain.value(p.value) for p in scene.parameters if p.value is not None}
    spread = SPREAD if near else 0.0
    values = {name: value * (1 + spread * rng.uniform(-1, 1)) for name, value in values.items()}
    freed = replace(scene, parameters=tuple(replace(p, value=None) for p in scene.parameters))
    try:
        numbers, assembly = _numbers(freed).witness(values)
    except DerivationError:  # a loop that closes for these values alone
        numbers, assembly = plain.witness({})
    q = np.array(assembly.q)
    free = free_motions(numbers.jacobian(q))
    step = WAY * np.array([rng.uniform(-1, 1) for _ in free]) @ free
    try:
        return numbers, np.array(numbers.closed_position(numbers.retract(q, step), ()).q)
    except DerivationError:
        return numbers, q


_numbers = lru_cache(maxsize=2)(Numbers)  # one scene is assembled many times, with and without its values


def _moving(numbers: Numbers, q: Array, rng: random.Random) -> Mapping[Expr, float]:
    """Return random rates and accelerations that the loops allow, and a time."""
    state, G = numbers.state, numbers.jacobian(q)
    free = free_motions(G)
    u = np.array([rng.uniform(0.5, 1.5) for _ in free]) @ free
    rates = dict(zip(state.qd, u.tolist(), strict=True))
    bias = numbers.at(numbers.constraints.bias, q, rates)
    a = np.array([rng.uniform(0.5, 1.5) for _ in free]) @ free - np.linalg.pinv(G, rcond=1e-10) @ bias
    moment = {numbers.graph.symbol(TIME): rng.uniform(0.5, 1.5)}
    return {**rates, **dict(zip(state.qdd, a.tolist(), strict=True)), **moment}


def _value(form: Form, numbers: Numbers, q: Array, others: Mapping[Expr, float]) -> float:
    return float(numbers.at([form.express(numbers.graph)], q, others)[0])


@lru_cache(maxsize=2)
def in_ground(scene: Scene) -> dict[str, Form]:
    """Return the multipliers of loops along axes of the ground, as lessons number them, in those of the scene's rows.

    Rows of a loop that are forces alone along directions d_k make Σ_k λ_k d_k: its components are what lessons call λ.
    """
    if not scene.loops or quaternions(scene):
        return {}
    graph, found = Graph(), dict[str, Form]()
    state, placed = State.of(scene, graph), body_placements(scene, graph)
    rows, kept = differentiated(scene, graph, state), Workspace(scene).loops.decisions.independent_rows
    names = [row.multiplier for row in Printable.of(scene, lengths=None).constraints.rows]
    for cut in rows.cuts:
        own = [(name, rows.labels[k]) for name, k in zip(names, kept, strict=True) if rows.labels[k].owner == cut.owner]
        wrenches = [(name, label.wrench) for name, label in own if label.loop and label.wrench is not None]
        on_child, on_parent = placed[cut.child].point(cut.on_child.p), placed[cut.parent].point(cut.on_parent.p)
        ways = [a for a, gap in enumerate(sub(on_child, on_parent)) if not gap.is_zero]
        if len(ways) != len(own) or len(wrenches) != len(own) or not all(x.is_zero for _, w in wrenches for x in w[1]):
            continue
        R = (placed[cut.parent] @ cut.on_parent).R
        along = [
            (name, [graph.total(x * f for x, f in zip(row, w[0], strict=True)) for row in R]) for name, w in wrenches
        ]
        for (name, _), a in zip(along, ways, strict=True):
            found[name] = Form.of(graph.total(graph.symbol(other) * d[a] for other, d in along))
    return {name: form for name, form in found.items() if form != Symbol(name)}
