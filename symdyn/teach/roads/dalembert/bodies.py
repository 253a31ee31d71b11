"""Steps about one body that is cut free: its picture, frame and motion (5.2)-(5.16), bivectors, equilibrium (5.18).

A, D, R, *R     actions, inertia, the reaction in the reference joint, reactions in other joints
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra.form import MINUS_ONE, ZERO, Form, Symbol, form_of, product_of, sum_of
from symdyn.draw import Wrench, free_body
from symdyn.dynamics.mechanism.kinematics import centre_of_mass
from symdyn.dynamics.reactions.bivectors import frames
from symdyn.emit.print.formula_text import text_of
from symdyn.emit.print.letters import body_number, head
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.spatial import apply, cross, sub, zero_vector
from symdyn.teach.document import ERRATA, Block, Box, Fold, Formula, Letter, Matrix, Picture, Step, Words
from symdyn.teach.mathematics import letter
from symdyn.teach.roads.dalembert.balance import Balance, Cut
from symdyn.teach.roads.lagrange.velocities import length
from symdyn.teach.shown_state import Chosen

WIDEST, GAP = 130, 18
"""Characters of a row from which a matrix is folded, and of the room between two of its columns."""

ABOUT_CENTRE = "_T"
"""Index of a couple about the centre of mass."""


def body_steps(lesson: Balance, j: int, chosen: Chosen) -> list[Step]:
    """Return the free body, its frame and motion, its bivectors and its equilibrium."""
    one = lesson.cuts[j]
    steps = [_free(lesson, j, chosen)]
    if one is not None:
        steps.append(_frame(lesson, j, one))
        steps.append(_motion(lesson, j, one))
        if j == _misread(lesson, chosen):
            steps.append(_acceleration(lesson, j, one, chosen))
    return [*steps, *_bivectors(lesson, j)]


def numbered(first: int, j: int) -> tuple[str, ...]:
    """Return the index of frame `first` and body j: "01", "11"."""
    number = body_number(j)
    return (f"{first}{number}",) if number < 10 else (str(first), str(number))


def _free(lesson: Balance, j: int, chosen: Chosen) -> Step:
    body, drawn = lesson.scene.bodies[j].name, _wrenches(lesson, j, chosen)
    prefix, titles = f"free{body_number(j)}-", lesson.titles
    svg = free_body(lesson.scene, body, chosen.q, drawn, chosen.parameters, prefix=prefix, titles=titles)
    alt = lesson.text("free.caption", body=body)
    picture = Picture(svg, lesson.say("free.caption", body=body), alt, f"free-{body}")
    joint, number = lesson.system.hanging.joints[j].joint.name, str(body_number(j))
    parts = [lesson.say("free.reason", joint=joint, number=number)]
    if any(one.couple_name.endswith(ABOUT_CENTRE) and any(one.couple) for one in drawn):
        parts.append(lesson.say("free.centre", number=number))
    reason = Words(tuple(part for one in parts for part in one.parts))
    return Step(f"free:{body}", lesson.say("free", body=body, number=str(body_number(j))), (picture,), reason)


def _wrenches(lesson: Balance, j: int, chosen: Chosen) -> list[Wrench]:
    """Return what acts on body j, ground frame: A and D at the centre of mass T, every unknown at its joint.

    Couples of A and D are about T, another quantity than the moments about O_j of the formulas, so they have an index.
    """
    hanging, body = lesson.workspace.hanging, lesson.scene.bodies[j]
    T, origin = frames(hanging)[j], hanging.joints[j].place_on_child
    try:
        centre, about = sub(centre_of_mass(lesson.scene, body.name, lesson.graph), origin), ABOUT_CENTRE
    except DerivationError:  # no mass
        centre, about = zero_vector(lesson.graph), ""
    known = lesson.system.bodies[j]
    spelled = latex_symbols(lesson.scene) | {
        key: letter(name.look) for key, name in lesson.names.items() if isinstance(name.look, Letter)
    }
    F, M = (head(lesson.letters[letter]) for letter in "FM")
    acting = [
        (f"{F}^A", f"{M}^A{about}", centre, known.action),
        (f"{F}^D", f"{M}^D{about}", centre, known.inertia),
    ]
    for u, one in enumerate(lesson.system.unknowns):
        if (j, u) in lesson.system.blocks:
            hinge, name = hanging.hinges[one.acts[0][0]], spelled[lesson.unknowns[u].name]
            place = hinge.place_on_child if hinge.child == j else hinge.place_on_parent
            acting.append((name, name, sub(place, origin), lesson.system.blocks[j, u]))
    drawn = []
    for name, couple_name, way, (force, moment) in acting:
        couple = sub(moment, cross(way, force))
        values = chosen.of(*T.point(way), *apply(T.R, force), *apply(T.R, couple))
        values = [0.0 if abs(x) < 1e-9 * (1 + max(map(abs, values[3:]))) else x for x in values]
        if any(values[3:]):
            drawn.append(Wrench(name, values[:3], values[3:6], values[6:], couple_name))
    return drawn


def _once(lesson: Balance, j: int, key: str) -> Words:
    """Return the reason of a step that every body has, for the first body only."""
    return lesson.say(key) if j == 0 else Words(())


# Frame and motion


def _frame(lesson: Balance, j: int, one: Cut) -> Step:
    """Return P_0j and r̃_0j, which take a bivector to the ground."""
    body, index = lesson.scene.bodies[j].name, numbered(0, j)
    blocks = (
        _matrix(lesson, Letter("P", index), one.P, "5.4"),
        _matrix(lesson, Letter("r", index, accent="tilde"), one.r, "5.2"),
    )
    claim = lesson.say("frame", body=body, number=str(body_number(j)))
    return Step(f"frame:{body}", claim, blocks, _once(lesson, j, "frame.reason"), "(5.2)-(5.5)", "full")


def _motion(lesson: Balance, j: int, one: Cut) -> Step:
    """Return what the inertia forces are made of."""
    body, index, here = lesson.scene.bodies[j].name, numbered(0, j), numbered(body_number(j), j)
    blocks = (
        _matrix(lesson, Letter("omega", index, accent="bar"), [[x] for x in one.w], ""),
        _matrix(lesson, Letter("I", here), one.I, "5.15"),
        _matrix(lesson, Letter("F", index, above="D", accent="bar"), [[x] for x in one.F], "5.11"),
        _matrix(lesson, Letter("F", here, above="*D", accent="bar"), [[x] for x in one.F_star], "5.16"),
    )
    claim, reason = lesson.say("moved", body=body), _once(lesson, j, "moved.reason")
    return Step(f"moved:{body}", claim, blocks, reason, "(5.11)-(5.16)", "full")


def _matrix(lesson: Balance, look: Letter, rows: Sequence[Sequence[Expr]], number: str) -> Block:
    """Return a matrix of the graph, or a column of x, y and z, with a name for each entry."""
    entries, width = [x for row in rows for x in row], len(rows[0])
    places = list("xyz") if width == 1 else [f"{r}{c}" for r in "123" for c in "123"]
    left, names = f"{look.letter}{look.above}{look.accent}:{','.join(look.index)}", []
    lesson.called(left, look)
    for place, node in zip(places, entries, strict=True):
        names.append(f"{left}:{place}")
        lesson.called(names[-1], Letter(look.letter, (*look.index, place), above=look.above), node)
    return _folded(lesson, Matrix(left, tuple(map(lesson.short, entries)), tuple(names), number, width))


# Where the text is wrong


def _misread(lesson: Balance, chosen: Chosen) -> int:
    """Return the first body for which (5.16) of the text changes the moment, else the first with a mass."""
    with_mass = [j for j, one in enumerate(lesson.cuts) if one is not None]
    changed = (j for j in with_mass if len(set(_moments(lesson, j, chosen))) > 1)
    return next(changed, with_mass[0] if with_mass else -1)


def _moments(lesson: Balance, j: int, chosen: Chosen) -> tuple[str, str]:
    """Return the last moment of the inertia bivector that is written, by the text and as it is, in numbers."""
    one = lesson.cuts[j]
    assert one is not None, "a body with a mass"
    wrong, right = chosen.of(lesson.kept(one.misread)[-1], lesson.kept(lesson.system.bodies[j].inertia)[-1])
    return lesson.equals(wrong), lesson.equals(right)


def _acceleration(lesson: Balance, j: int, one: Cut, chosen: Chosen) -> Step:
    """Return the box about (5.16), a position in place of an acceleration."""
    body, number = lesson.scene.bodies[j].name, str(body_number(j))
    place = lesson.name(f"r:{number}", "r", number, f"O{number}", node=None)
    here = ",".join(numbered(body_number(j), j))
    head, axis = lesson.axes[-1]
    wrong, right = _moments(lesson, j, chosen)
    blocks: list[Block] = [
        lesson.say("erratum.5.16"),
        lesson.say("erratum.reads", left=Symbol(f"F*Dbar:{here}"), form=product_of((MINUS_ONE, form_of(one.m), place))),
    ]
    if wrong != right:
        moment = Symbol(f"{head}D:{here}:{axis}")
        blocks.append(lesson.say("erratum.5.16.check", left=moment, wrong=wrong, right=right))
    title = lesson.say("erratum", number="5.16")
    return Step(f"{ERRATA}moved:{body}", Words(()), (Box("erratum", title, tuple(blocks)),))


# Bivectors and equilibrium


def _bivectors(lesson: Balance, j: int) -> list[Step]:
    body, system, here = lesson.scene.bodies[j].name, lesson.system, numbered(body_number(j), j)
    known = system.bodies[j]
    columns = [
        _bivector(lesson, kind, here, [(lesson.short(x), x) for x in lesson.kept(entries)], number)
        for kind, entries, number in (("A", known.action, "5.1"), ("D", known.inertia, "5.17"))
    ]
    for h, hinge in enumerate(system.hanging.hinges):
        own = h == j
        present = [u for u, one in enumerate(system.unknowns) if (j, u) in system.blocks and one.acts[0][0] == h]
        if present:
            index = here if own else (str(body_number(j)), hinge.joint.name)
            kind, number = ("R", "5.6") if own else ("*R", "5.10")
            columns.append(_bivector(lesson, kind, index, _exerted(lesson, j, present), number))
    balance: list[Block] = []
    for row in range(len(lesson.axes)):
        parts = [Symbol(column.names[row]) for column in columns if column.entries[row] != ZERO]
        if parts:
            balance.append(Formula("", sum_of(parts), "5.18" if row == 0 else "", ZERO))
    shown = tuple(_folded(lesson, column) for column in columns)
    claim, reason = lesson.say("bivectors", body=body), _once(lesson, j, "bivectors.reason")
    bivectors = Step(f"bivectors:{body}", claim, shown, reason, "(5.1)-(5.17)")
    claim, reason = lesson.say("balance", body=body), _once(lesson, j, "balance.reason")
    return [bivectors, Step(f"balance:{body}", claim, tuple(balance), reason, "(5.18)")]


def _exerted(lesson: Balance, j: int, present: Sequence[int]) -> list[tuple[Form, Expr]]:
    """Return what the unknowns of one joint exert on body j, as forms and as nodes."""
    columns = [lesson.kept(lesson.system.blocks[j, u]) for u in present]
    sizes = [lesson.unknowns[u] for u in present]
    entries = []
    for row in zip(*columns, strict=True):
        form = sum_of(product_of((lesson.short(x), size)) for x, size in zip(row, sizes, strict=True))
        values = [lesson.names[size.name].node for size in sizes]
        node = lesson.graph.total(x * value for x, value in zip(row, values, strict=True) if value is not None)
        entries.append((form, node))
    return entries


def _bivector(
    lesson: Balance, kind: str, index: tuple[str, ...], entries: Sequence[tuple[Form, Expr]], number: str
) -> Matrix:
    names = []
    for (F, axis), (_, node) in zip(lesson.axes, entries, strict=True):
        key = f"{F}{kind}:{','.join(index)}:{axis}"
        lesson.called(key, Letter(F, (*index, axis), above=kind), node)
        names.append(key)
    left = f"F{kind}:{','.join(index)}"
    lesson.called(left, Letter("F", index, above=kind, accent="bar"))
    return Matrix(left, tuple(form for form, _ in entries), tuple(names), number)


def _folded(lesson: Balance, matrix: Matrix) -> Block:
    """Return a matrix, or its entries one below the other in a fold where they are long."""
    terms = [length(entry) for entry in matrix.entries]
    if max(terms) <= WIDEST:  # no text is shorter than its terms
        cells = [len(text_of(entry)) for entry in matrix.entries]
        columns = [max(cells[k :: matrix.width]) for k in range(matrix.width)]
        if sum(columns) + GAP * (len(columns) - 1) <= WIDEST:
            return matrix
    pairs = zip(matrix.names, matrix.entries, strict=True)
    entries = tuple(Formula(name, form) for name, form in pairs)
    return Fold(lesson.say("long", name=Symbol(matrix.left), terms=str(sum(terms))), entries)
