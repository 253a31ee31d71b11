"""The D'Alembert road as a document: every body cut free, its bivectors (5.1)-(5.17), its equilibrium (5.18).

Bodies are numbered as the textbook does, the ground being 1; frame j has its origin in the joint that carries body j.
Where the mechanism moves in a plane of coordinates of all frames, three equations a body are written.

    A, D, R, *R     actions, inertia, the reaction in the reference joint, reactions in other joints
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from symdyn.algebra.compact import Compactor
from symdyn.algebra.form import ZERO, Form, Number, Symbol, form_of, power_of, product_of, sum_of
from symdyn.algebra.numeric import Floats
from symdyn.algebra.sums_of_angles import total_angles
from symdyn.algebra.trigonometric import TrigonometricRing
from symdyn.draw import Wrench, free_body
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.closed_forms.parallel import angle_groups
from symdyn.dynamics.kinematics import centre_of_mass
from symdyn.dynamics.lagrange import driving_forces
from symdyn.dynamics.loops.words import in_words
from symdyn.dynamics.reactions.dalembert import DRIVE, REACTION, Equilibrium, Unknown, equilibrium, frames
from symdyn.emit.formula_text import text_of
from symdyn.emit.symbols import latex_symbols
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Expr, evaluate
from symdyn.scene import Scene
from symdyn.spatial import apply, cross, dot, sub, zero_vector
from symdyn.teach.document import (
    Block,
    Column,
    Document,
    Fold,
    Formula,
    Letter,
    Name,
    Picture,
    Section,
    Step,
    Values,
    Words,
)
from symdyn.teach.lesson import Prose, together
from symdyn.teach.notation import notation_step, scene_step
from symdyn.teach.numbers import Chosen, choose_state, scene_picture, written
from symdyn.teach.render.spelling import letter
from symdyn.teach.velocities import PAGE, length
from symdyn.verify.equality import PROVED, Claim, prove
from symdyn.verify.laws_of_reactions import LAWS_OF_REACTIONS

MOST_UNKNOWNS = 40
"""Beyond which nobody reads the lesson."""
WIDEST = 130
"""Characters of an entry from which a column is folded."""


@dataclass
class Balance(Prose):
    """One scene with its system (5.18) while the document is being written."""

    def __post_init__(self) -> None:
        """Set the system up, in a plane where there is one."""
        for joint in self.scene.joints:
            if joint.velocities:
                raise DerivationError(
                    f"{self.scene.name}: joint {joint.name} turns by a quaternion, for which there are no formulas to "
                    'read; write orientation = "zyx" (or another sequence of axes) to have them'
                )
        self.workspace = Workspace(self.scene)
        self.scene = self.workspace.scene
        self.graph, self.state = self.workspace.graph, self.workspace.state
        self.closed = bool(self.scene.loops or self.scene.rows)
        try:
            self.system = equilibrium(self.workspace.hanging, planar=True)
        except DerivationError:
            self.system = equilibrium(self.workspace.hanging)
        if len(self.system.unknowns) > MOST_UNKNOWNS:
            raise EmitError(
                f"{self.scene.name}: {len(self.system.unknowns)} unknowns are more than anyone reads (the limit is "
                f"{MOST_UNKNOWNS}); the outputs reactions and reactions:joint compute them"
            )
        self.axes = [("F", "xyz"[k]) if k < 3 else ("M", "xyz"[k - 3]) for k in self.system.kept]
        self.solved = None if self.closed else self._solution()
        self.short = _forms(self.system, self.solved or [])
        self.unknowns = [self._unknown(u, one) for u, one in enumerate(self.system.unknowns)]

    def _solution(self) -> list[Expr]:
        """Return the unknowns of an open mechanism: its joints' wrenches, found from the tips to the ground, split.

        Every reaction is a unit force or moment along an axis of its joint frame, so that its size is a component.
        """
        R = derive_one(self.workspace, "reactions").entries
        hinges = self.workspace.hanging.hinges
        sizes = []
        for one in self.system.unknowns:
            h, (force, moment) = one.acts[0]
            here = hinges[h].in_joint_axes((R[6 * h : 6 * h + 3], R[6 * h + 3 : 6 * h + 6]))  # type: ignore[arg-type]
            size = dot(force, here[0]) + dot(moment, here[1])
            if one.kind == DRIVE and self.system.own[h]:
                size = size - self.system.own[h][one.number]
            sizes.append(size)
        return sizes

    def _unknown(self, u: int, one: Unknown) -> Symbol:
        """Name an unknown; its value is the solution, or the symbol itself where loops leave only numbers."""
        key = f"{one.kind}:{one.joint}:{one.number}"
        node = self.graph.symbol(key) if self.solved is None else self.solved[u]
        if one.kind == DRIVE:
            joint = next(joint for joint in self.scene.joints if joint.name == one.joint)
            drive = joint.drives[one.number] if one.number < len(joint.drives) else None
            if drive:
                self.names[drive] = Name(None, node)
                return Symbol(drive)
            return self.name(key, "tau", one.joint, str(one.number + 1), node=node)
        words = self.along(one)
        if one.kind == REACTION and words[-2:] in (" x", " y", " z"):
            return self.name(key, "F" if words.startswith("force") else "M", one.joint, words[-1], node=node)
        return self.name(key, "R", one.joint, str(one.number + 1), node=node)

    def along(self, one: Unknown) -> str:
        """Return "force along x" for a unit wrench of fixed direction in its joint frame, else ""."""
        force, moment = one.acts[0][1]
        first, second = (self.workspace.hanging.samples.at([*force, *moment], seed) for seed in (2, 3))
        return in_words(first[:3], first[3:]) if abs(first - second).max() < 1e-12 else ""

    def kept(self, wrench: tuple[Sequence[Expr], Sequence[Expr]]) -> list[Expr]:
        """Return the components that are written."""
        entries = (*wrench[0], *wrench[1])
        return [entries[k] for k in self.system.kept]


def _forms(system: Equilibrium, solved: Sequence[Expr]) -> Callable[[Expr], Form]:
    """Return what writes an entry: as short as the ring of sines can, as it stands where there is no such ring."""
    state, graph = system.hanging.state, system.hanging.graph
    needed = [x for known in system.bodies for part in (*known.action, *known.inertia) for x in part]
    needed += [x for block in system.blocks.values() for part in block for x in part]
    for more in (list(solved), []):  # a solution with a pivot that moves is no polynomial
        try:
            parallel = angle_groups(system.hanging.scene, graph)
            ring = TrigonometricRing([*needed, *more], (*state.q, *state.qd, *state.qdd), total_angles(parallel))
            nodes = list(dict.fromkeys([*needed, *more]))
            values = dict(zip(nodes, evaluate(nodes, ring, ring.values(nodes)), strict=True))
        except DerivationError:
            continue
        compact = Compactor(ring, parallel)
        return lambda node: compact(values[node]) if node in values else form_of(node)
    return form_of


def dalembert_walkthrough(scene: Scene, language: str = "en") -> Document:
    """Return the walkthrough by D'Alembert's method (5.1)-(5.20), for open and closed mechanisms.

    Raises:
        EmitError: there are more unknowns than anyone reads.
    """
    lesson = Balance(scene, language)
    chosen = choose_state(lesson.scene, lesson.state, lesson.graph, moving=not lesson.closed)
    bodies = [step for j in range(len(lesson.scene.bodies)) for step in _body(lesson, j, chosen)]
    first = [scene_step(lesson, scene_picture(lesson, chosen)), notation_step(lesson), _unknown_table(lesson)]
    sections = (
        Section("scene", lesson.text("section.scene"), tuple(first)),
        Section("count", lesson.text("section.count"), (_count(lesson),)),
        Section("bodies", lesson.text("section.bodies"), tuple(bodies)),
        Section("reactions", lesson.text("section.reactions"), (*_solved(lesson), _numbers(lesson, chosen))),
        Section("roads", lesson.text("section.roads"), (_roads(lesson),)),
    )
    title = lesson.text("title.dalembert", scene=lesson.scene.name)
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, sections)


# Unknowns


def _unknown_table(lesson: Balance) -> Step:
    rows = []
    for symbol, one in zip(lesson.unknowns, lesson.system.unknowns, strict=True):
        words = lesson.along(one)
        kind = "unknown.drive" if one.kind == DRIVE else f"unknown.{words.split(' ')[0]}" if words else "unknown.other"
        rows.append((Words((symbol,)), lesson.say(kind, joint=one.joint, axis=words[-1:])))
    head = (lesson.say("table.symbol"), lesson.say("table.meaning"))
    reason = lesson.say("unknowns.reason")
    return Step("unknowns", lesson.say("unknowns"), (Values(head, tuple(rows)),), reason, "(5.6), (5.7)")


def _count(lesson: Balance) -> Step:
    """Return (5.18)-(5.20) in numbers."""
    system, rows = lesson.system, []
    counts = [one.joint for one in system.unknowns if one.kind != DRIVE]
    for joint in (*lesson.scene.joints, *lesson.scene.loops):
        kind = lesson.say(f"joint.{joint.type}")
        rows.append((Words((joint.name,)), kind, Words((str(counts.count(joint.name)),))))
    head = (lesson.say("table.joint"), lesson.say("table.kind"), lesson.say("table.class"))
    places = {
        "equations": str(system.equations),
        "each": str(len(system.kept)),
        "bodies": str(len(system.bodies)),
        "reactions": str(system.reactions),
        "drives": str(system.drives),
    }
    correct = system.equations == len(system.unknowns)
    blocks: list[Block] = [Values(head, tuple(rows)), lesson.say("count.sum", **places)]
    blocks.append(lesson.say("count.correct" if correct else "count.over"))
    plane = lesson.say("count.plane") if len(system.kept) == 3 else Words(())
    return Step("count", lesson.say("count", **places), tuple(blocks), plane, "(5.18)-(5.20)")


# Bodies


def _body(lesson: Balance, j: int, chosen: Chosen) -> list[Step]:
    """Return the free body, its bivectors and its equilibrium."""
    body, system = lesson.scene.bodies[j], lesson.system
    known, here = system.bodies[j], f"{j + 2}{',' if j > 7 else ''}{j + 2}"
    caption = lesson.say("free.caption", body=body.name)
    drawn, prefix = _wrenches(lesson, j, chosen), f"free{j + 2}-"
    svg = free_body(lesson.scene, body.name, chosen.q, drawn, chosen.parameters, prefix=prefix)
    alt = lesson.text("free.caption", body=body.name)
    picture = Picture(svg, caption, alt, f"free-{body.name}")
    joint = system.hanging.joints[j].joint.name
    columns = [
        _column(lesson, "A", here, lesson.kept(known.action), "5.1"),
        _column(lesson, "D", here, lesson.kept(known.inertia), "5.17"),
    ]
    for h, hinge in enumerate(system.hanging.hinges):
        own = h == j
        present = [u for u, one in enumerate(system.unknowns) if (j, u) in system.blocks and one.acts[0][0] == h]
        if present:
            index = here if own else f"{j + 2},{hinge.joint.name}"
            columns.append(_reaction(lesson, ("R" if own else "*R", index), j, present, "5.6" if own else "5.10"))
    balance: list[Block] = []
    for row in range(len(lesson.axes)):
        parts = [Symbol(column.names[row]) for column in columns if column.entries[row] != ZERO]
        if parts:
            balance.append(Formula("", sum_of(parts), "5.18" if row == 0 else "", ZERO))
    shown = [_folded(lesson, column) for column in columns]
    claim = lesson.say("free", body=body.name, number=str(j + 2))
    cut = Step(f"free:{body.name}", claim, (picture,), lesson.say("free.reason", joint=joint, number=str(j + 2)))
    named = lesson.say("bivectors", body=body.name)
    bivectors = Step(f"bivectors:{body.name}", named, tuple(shown), lesson.say("bivectors.reason"), "(5.1)-(5.17)")
    claim, reason = lesson.say("balance", body=body.name), lesson.say("balance.reason")
    return [cut, bivectors, Step(f"balance:{body.name}", claim, tuple(balance), reason, "(5.18)")]


def _wrenches(lesson: Balance, j: int, chosen: Chosen) -> list[Wrench]:
    """Return what acts on body j, ground frame: A and D at the centre of mass, every unknown at its joint."""
    hanging, body = lesson.workspace.hanging, lesson.scene.bodies[j]
    T, origin = frames(hanging)[j], hanging.joints[j].place_on_child
    try:
        centre = sub(centre_of_mass(lesson.scene, body.name, lesson.graph), origin)
    except DerivationError:  # no mass
        centre = zero_vector(lesson.graph)
    known = lesson.system.bodies[j]
    spelled = latex_symbols(lesson.scene) | {
        key: letter(name.look) for key, name in lesson.names.items() if isinstance(name.look, Letter)
    }
    acting = [("F^A", centre, known.action), ("F^D", centre, known.inertia)]
    for u, one in enumerate(lesson.system.unknowns):
        if (j, u) in lesson.system.blocks:
            hinge = hanging.hinges[one.acts[0][0]]
            place = hinge.place_on_child if hinge.child == j else hinge.place_on_parent
            acting.append((spelled[lesson.unknowns[u].name], sub(place, origin), lesson.system.blocks[j, u]))
    drawn = []
    for name, way, (force, moment) in acting:
        couple = sub(moment, cross(way, force))
        values = chosen.of(*T.point(way), *apply(T.R, force), *apply(T.R, couple))
        values = [0.0 if abs(x) < 1e-9 * (1 + max(map(abs, values[3:]))) else x for x in values]
        if any(values[3:]):
            drawn.append(Wrench(name, values[:3], values[3:6], values[6:]))
    return drawn


def _column(lesson: Balance, kind: str, index: str, entries: Sequence[Expr], number: str) -> Column:
    forms = tuple(lesson.short(entry) for entry in entries)
    return _named(lesson, (kind, index), list(zip(forms, entries, strict=True)), number)


def _reaction(lesson: Balance, look: tuple[str, str], j: int, present: Sequence[int], number: str) -> Column:
    """Return what the unknowns of one joint exert on body j."""
    columns = [lesson.kept(lesson.system.blocks[j, u]) for u in present]
    sizes = [lesson.unknowns[u] for u in present]
    entries = []
    for row in zip(*columns, strict=True):
        form = sum_of(product_of((lesson.short(x), size)) for x, size in zip(row, sizes, strict=True))
        values = [lesson.names[size.name].node for size in sizes]
        node = lesson.graph.total(x * value for x, value in zip(row, values, strict=True) if value is not None)
        entries.append((form, node))
    return _named(lesson, look, entries, number)


def _named(lesson: Balance, look: tuple[str, str], entries: Sequence[tuple[Form, Expr]], number: str) -> Column:
    kind, index = look
    names = []
    for (head, axis), (_, node) in zip(lesson.axes, entries, strict=True):
        key = f"{head}{kind}:{index}:{axis}"
        lesson.names[key] = Name(Letter(head, (*index.split(","), axis), above=kind), node)
        names.append(key)
    left = f"F{kind}:{index}"
    lesson.names[left] = Name(Letter("F", tuple(index.split(",")), above=kind, accent="bar"))
    return Column(left, tuple(form for form, _ in entries), tuple(names), number)


def _folded(lesson: Balance, column: Column) -> Block:
    """Return a column, or its entries one below the other in a fold where they are long."""
    if max(len(text_of(entry)) for entry in column.entries) <= WIDEST:
        return column
    pairs = zip(column.names, column.entries, strict=True)
    entries = tuple(Formula(name, form) for name, form in pairs)
    terms = str(sum(map(length, column.entries)))
    return Fold(lesson.say("long", name=Symbol(column.left), terms=terms), entries)


# The solution


def _solved(lesson: Balance) -> list[Step]:
    """Return every unknown solved for, of an open mechanism; closed ones have numbers only."""
    if lesson.solved is None:
        return []
    blocks: list[Block] = []
    for symbol, node in zip(lesson.unknowns, lesson.solved, strict=True):
        form = lesson.short(node)
        formula = Formula(symbol.name, form)
        long = lesson.say("long", name=symbol, terms=str(length(form)))
        blocks.append(formula if length(form) <= PAGE else Fold(long, (formula,)))
    return [Step("solved", lesson.say("solved"), tuple(blocks), lesson.say("solved.reason"))]


def _numbers(lesson: Balance, chosen: Chosen) -> Step:
    """Return every unknown at the chosen state, from A x + b = 0 in numbers."""
    A, b = lesson.system.matrix(), lesson.system.right()
    flat = [x for row in A for x in row]
    found = evaluate([*flat, *b], Floats(), chosen.values)
    size = (len(A), len(lesson.unknowns))
    matrix, right = np.array(found[: len(flat)], dtype=float).reshape(size), np.array(found[len(flat) :], dtype=float)
    x, _, rank, _ = np.linalg.lstsq(matrix, -right, rcond=1e-10)
    x = np.where(np.abs(x) < 1e-9 * (np.abs(x).max() or 1.0), 0.0, x)
    rows = []
    for symbol, one, value in zip(lesson.unknowns, lesson.system.unknowns, x, strict=True):
        unit = _unit(lesson, one)
        rows.append((Words((symbol,)), Words((written(float(value)),)), Words((unit,))))
    head = (lesson.say("table.symbol"), lesson.say("table.value"), lesson.say("table.unit"))
    where = lesson.say("reactions.moving" if not lesson.closed else "reactions.rest")
    unique = rank == len(x)
    blocks: list[Block] = [where, Values(head, tuple(rows))]
    if not unique:
        blocks.append(lesson.say("reactions.least"))
    return Step("reactions", lesson.say("reactions"), tuple(blocks), lesson.say("reactions.reason"))


def _unit(lesson: Balance, one: Unknown) -> str:
    """Return N for what has a force at unit size, else N m."""
    force = lesson.workspace.hanging.samples.at([*one.acts[0][1][0]], 2)
    return "N" if abs(force).max() > 1e-12 else "N m"


def _roads(lesson: Balance) -> Step:
    """Return the proof that D'Alembert's drives are those of the other road, over finite fields."""
    w = lesson.workspace
    if lesson.solved is not None:
        drives = [x for x, one in zip(lesson.solved, lesson.system.unknowns, strict=True) if one.kind == DRIVE]
        claims = [Claim("drives", "D'Alembert", "Lagrange", tuple(drives), tuple(_driven(lesson)))]
        left = _left(lesson, lesson.solved)
        claims.append(Claim("equilibrium", "A x + b", "0", tuple(left), (lesson.graph.zero,) * len(left)))
    else:
        claims = [claim for _, law in LAWS_OF_REACTIONS if (claim := law(w)) is not None]
    fields, findings = prove(claims, positive=[p.name for p in lesson.scene.parameters if p.positive])
    assert all(one.verdict == PROVED for one in findings), "the two roads differ, or cannot be compared exactly"
    chance = max(one.error_log10 for one in findings)
    key = "roads.open" if lesson.solved is not None else "roads.closed"
    names: list[Form] = [s for s, one in zip(lesson.unknowns, lesson.system.unknowns, strict=True) if one.kind == DRIVE]
    said = lesson.say(
        key,
        names=together(names),
        points=str(fields.points),
        primes=str(len(fields.primes)),
        chance=power_of(Number(Fraction(10)), int(chance)),
    )
    return Step("roads", lesson.say("roads"), (said,), lesson.say("roads.reason"), "(5.21)")


def _driven(lesson: Balance) -> list[Expr]:
    """Return Lagrange's driving forces of the velocities that have an unknown drive, in the order of the joints."""
    forces = iter(driving_forces(lesson.workspace.energy))
    wanted = {(one.joint, one.number) for one in lesson.system.unknowns if one.kind == DRIVE}
    pairs = [(joint.name, k) for joint in lesson.scene.joints for k in range(len(joint.rates))]
    return [force for pair, force in zip(pairs, forces, strict=True) if pair in wanted]


def _left(lesson: Balance, x: Sequence[Expr]) -> list[Expr]:
    """Return A x + b."""
    rows = zip(lesson.system.matrix(), lesson.system.right(), strict=True)
    return [lesson.graph.total([b, *(a * y for a, y in zip(row, x, strict=True))]) for row, b in rows]
