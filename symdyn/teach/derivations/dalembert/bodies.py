"""Steps about one body that is cut free: its picture, frame and motion (5.2)-(5.16), bivectors, equilibrium (5.18).

A, D, R, *R     actions, inertia, the reaction in the reference joint, reactions in other joints
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.algebra import Form, Number, Symbol
from symdyn.draw import Wrench, free_body
from symdyn.emit.print import Letters, latex_symbols, text_of
from symdyn.graph import Expr
from symdyn.spatial import cross, sub, zero_vector
from symdyn.teach.derivations.dalembert.balance import Balance, Cut
from symdyn.teach.derivations.dalembert.spatial_loop import balance_steps, named_steps, numbered
from symdyn.teach.derivations.velocities import MOST, folded, length
from symdyn.teach.document import ERRATA, Block, Box, Fold, Formula, Letter, Matrix, Picture, Step, Words
from symdyn.teach.mathematics import letter
from symdyn.teach.shown_state import Chosen

NEAR = 1e-9
"""m: points that are one."""

WIDEST, GAP = 130, 18
"""Characters of a row from which a matrix is folded, and of the room between two of its columns."""


def body_steps(lesson: Balance, j: int, chosen: Chosen) -> list[Step]:
    """Return the free body, its frame and motion, its bivectors and its equilibrium."""
    one = lesson.cuts[j]
    steps = [_free(lesson, j, chosen)]
    if one is not None:
        steps.append(_frame(lesson, j, one))
        if lesson.in_letters:
            steps += named_steps(lesson, j, one, chosen)
        else:
            steps += [_acceleration(lesson, j, one), _motion(lesson, j, one)]
        if j == _misread(lesson, chosen):
            steps.append(_misprint(lesson, j, one, chosen))
        if not lesson.in_letters and not all(x.is_zero for x in one.arm):
            steps.append(_about(lesson, j, one))
    return [*steps, *(balance_steps(lesson, j, chosen) if lesson.in_letters else _bivectors(lesson, j))]


def _free(lesson: Balance, j: int, chosen: Chosen) -> Step:
    body, drawn = lesson.scene.bodies[j].name, _wrenches(lesson, j, chosen)
    prefix, titles = f"free{Letters.body_number(j)}-", lesson.titles
    points, parameters = _points(lesson, j, chosen), chosen.parameters
    svg = free_body(lesson.scene, body, chosen.q, drawn, parameters, prefix=prefix, titles=titles, points=points)
    alt = lesson.text("free.caption", body=body)
    picture = Picture(svg, lesson.say("free.caption", body=body), alt, f"free-{body}")
    joint, number = lesson.system.hanging.joints[j].joint.name, str(Letters.body_number(j))
    parts = [lesson.say("free.reason", joint=joint, number=number)]
    if lesson.cuts[j] is not None:
        parts.append(lesson.say("free.points", number=number))
    reason = Words(tuple(part for one in parts for part in one.parts))
    return Step(f"free:{body}", lesson.say("free", body=body, number=str(Letters.body_number(j))), (picture,), reason)


def _points(lesson: Balance, j: int, chosen: Chosen) -> dict[str, tuple[float, float, float]]:
    """Return O_j and T_j as they are written and where they are, ground frame; one point where they are one."""
    one, number = lesson.cuts[j], Letters.body_number(j)
    O, T = (f"{lesson.letters.latex(letter)}_{{{number}}}" for letter in "OT")  # noqa: E741  the book's name
    x, y, z = chosen.of(*lesson.workspace.hanging.frames[j].p)
    if one is None:
        return {O: (x, y, z)}
    a, b, c = chosen.of(*one.centre[0])
    if max(abs(a - x), abs(b - y), abs(c - z)) < NEAR:
        return {f"{O} = {T}": (x, y, z)}
    return {O: (x, y, z), T: (a, b, c)}


def _wrenches(lesson: Balance, j: int, chosen: Chosen) -> list[Wrench]:
    """Return what acts on body j, ground frame: A and D at O_j with their moments about it, as the formulas have them.

    Every unknown is at its joint, with its own name.
    """
    hanging = lesson.workspace.hanging
    T, origin = hanging.frames[j], hanging.joints[j].place_on_child
    here, still = "".join(numbered(Letters.body_number(j), j)), zero_vector(lesson.graph)
    known = lesson.system.bodies[j]
    spelled = latex_symbols(lesson.scene) | {
        key: letter(name.look) for key, name in lesson.names.items() if isinstance(name.look, Letter)
    }
    F, M = (lesson.letters.latex(letter) for letter in "FM")
    acting = [
        (f"{F}_{{{here}}}^A", f"{M}_{{{here}}}^A", still, known.action),
        (f"{F}_{{{here}}}^D", f"{M}_{{{here}}}^D", still, known.inertia),
    ]
    for u, one in enumerate(lesson.system.unknowns):
        if (j, u) in lesson.system.blocks:
            hinge, name = hanging.hinges[one.acts[0][0]], spelled[lesson.unknowns[u].name]
            place = hinge.place_on_child if hinge.child == j else hinge.place_on_parent
            acting.append((name, name, sub(place, origin), lesson.system.blocks[j, u]))
    drawn = []
    for name, couple_name, way, (force, moment) in acting:
        couple = sub(moment, cross(way, force))
        values = chosen.of(*T.point(way), *T.R @ force, *T.R @ couple)
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
    claim = lesson.say("frame", body=body, number=str(Letters.body_number(j)))
    return Step(f"frame:{body}", claim, blocks, _once(lesson, j, "frame.reason"), "(5.2)-(5.5)")


def _acceleration(lesson: Balance, j: int, one: Cut) -> Step:
    """Return places of the centre of mass and of the origin, differentiated twice; one alone where both are one."""
    body, number = lesson.scene.bodies[j].name, str(Letters.body_number(j))
    points = {f"T{number}": one.centre, f"O{number}": one.origin}
    places: dict[str, str | Form] = {"body": body}
    for point, key in zip(points, ("centre", "origin"), strict=True):
        places[key] = lesson.called(f"point:{point}", Letter(point[0], (number,)))
    blocks: list[Block] = []
    if one.centre[0] == one.origin[0]:
        points.pop(f"O{number}")
        blocks.append(lesson.say("accelerated.one", **places))
    for point, moved in points.items():
        if all(x.is_zero for x in moved[1]):
            at = places["centre" if point.startswith("T") else "origin"]
            blocks.append(lesson.say("accelerated.still", point=at))
            continue
        for dots, vector in enumerate(moved):
            blocks.append(_matrix(lesson, Letter("r", ("0", point), dots), [[x] for x in vector], ""))
    reason = _once(lesson, j, "accelerated.reason")
    claim = lesson.say("accelerated", **places)
    return Step(f"accelerated:{body}", claim, tuple(blocks), reason, "(5.11)", show=(f"body:{body}", "accelerations"))


def _motion(lesson: Balance, j: int, one: Cut) -> Step:
    """Return what the inertia forces are made of."""
    body, index, here = lesson.scene.bodies[j].name, numbered(0, j), numbered(Letters.body_number(j), j)
    blocks = (
        _matrix(lesson, Letter("omega", index), [[x] for x in one.w], ""),
        _matrix(lesson, Letter("omega", index, 1), [[x] for x in one.dw], ""),
        _matrix(lesson, Letter("I", here), one.I, "5.15"),
        _matrix(lesson, Letter("F", index, above="D"), [[x] for x in one.F], "5.11", _weighed(lesson, j, one)),
        _matrix(lesson, Letter("F", here, above="*D"), [[x] for x in one.F_star], "5.16"),
    )
    claim, reason = lesson.say("moved", body=body), _once(lesson, j, "moved.reason")
    return Step(f"moved:{body}", claim, blocks, reason, "(5.11)-(5.16)")


def _about(lesson: Balance, j: int, one: Cut) -> Step:
    """Return what (5.14) takes for a centre of mass that is not the origin: its arm, the product, Steiner's term."""
    body, number = lesson.scene.bodies[j].name, str(Letters.body_number(j))
    here, arm = numbered(Letters.body_number(j), j), (number, f"T{number}")
    product, about = Letter("M", here, above="*D"), Letter("I", arm)
    tilde = lesson.called(f"rtilde:{','.join(arm)}", Letter("r", arm, accent="tilde"))
    I_O, m = Symbol(f"I:{','.join(here)}"), lesson.short(one.m)
    names = {key: Symbol(f"point:{letter}{number}") for key, letter in (("centre", "T"), ("origin", "O"))}
    blocks: list[Block] = [
        _matrix(lesson, Letter("r", arm), [[x] for x in one.arm], ""),
        Formula(f"M*D:{','.join(here)}", Form.product((tilde, Symbol(f"F*D:{','.join(here)}")))),
    ]
    lesson.called(f"M*D:{','.join(here)}", product)
    still = all(x.is_zero for x in one.F_star)
    vanished = lesson.say("about.still", origin=names["origin"], tensor=I_O)
    blocks.append(vanished if still else _matrix(lesson, product, [[x] for x in one.moved], ""))
    blocks.append(lesson.say("about.steiner", **names, tensor=I_O))
    blocks.append(_matrix(lesson, about, one.I_T, ""))
    steiner = Form.product((Number.MINUS_ONE, m, tilde.power(2)))
    blocks.append(Formula(I_O.name, Form.sum((Symbol(f"I:{','.join(arm)}"), steiner))))
    claim, reason = (
        lesson.say("about", body=body, **names),
        lesson.say("about.reason", **names) if j == 0 else Words(()),
    )
    return Step(f"about:{body}", claim, tuple(blocks), reason, "(5.14)")


def _weighed(lesson: Balance, j: int, one: Cut) -> list[Form]:
    """Return -m r̈ by the names that the step before gave to the acceleration of T_j."""
    names = (f"ddr:0,T{Letters.body_number(j)}:{axis}" for axis in "xyz")
    pairs = zip(names, one.F, strict=True)
    minus = (Number.MINUS_ONE, lesson.short(one.m))
    return [Number.ZERO if force.is_zero else Form.product((*minus, Symbol(name))) for name, force in pairs]


def _matrix(
    lesson: Balance, look: Letter, rows: Sequence[Sequence[Expr]], number: str, forms: Sequence[Form] | None = None
) -> Block:
    """Return a matrix of the graph, or a column of x, y and z, with a name for each entry; `forms` may be given."""
    entries, width = [x for row in rows for x in row], len(rows[0])
    places = list("xyz") if width == 1 else [f"{r}{c}" for r in "123" for c in "123"]
    left, names = f"{'d' * look.dots}{look.letter}{look.above}{look.accent}:{','.join(look.index)}", []
    lesson.called(left, look)
    for place, node in zip(places, entries, strict=True):
        names.append(f"{left}:{place}")
        lesson.called(names[-1], Letter(look.letter, (*look.index, place), look.dots, above=look.above), node)
    shown = tuple(map(lesson.short, entries)) if forms is None else tuple(forms)
    return _folded(lesson, Matrix(left, shown, tuple(names), number, width))


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
    wrong, right = chosen.of(
        lesson.system.written(one.misread)[-1], lesson.system.written(lesson.system.bodies[j].inertia)[-1]
    )
    return lesson.equals(wrong), lesson.equals(right)


def _misprint(lesson: Balance, j: int, one: Cut, chosen: Chosen) -> Step:
    """Return the box about (5.16), a position in place of an acceleration."""
    body, number = lesson.scene.bodies[j].name, str(Letters.body_number(j))
    place = lesson.name(f"r:{number}", "r", number, f"O{number}", node=None)
    here = ",".join(numbered(Letters.body_number(j), j))
    head, axis = lesson.axes[-1]
    wrong, right = _moments(lesson, j, chosen)
    blocks: list[Block] = [
        lesson.say("erratum.5.16"),
        lesson.say(
            "erratum.quoted", left=Symbol(f"F*D:{here}"), form=Form.product((Number.MINUS_ONE, Form.of(one.m), place))
        ),
    ]
    if wrong != right:
        index = (*numbered(Letters.body_number(j), j), axis)
        moment = lesson.called(f"{head}D:{here}:{axis}", Letter(head, index, above="D"))
        blocks.append(lesson.say("erratum.5.16.check", left=moment, wrong=wrong, right=right))
    title = lesson.say("erratum", number="5.16")
    return Step(f"{ERRATA}moved:{body}", Words(()), (Box("erratum", title, tuple(blocks)),))


# Bivectors and equilibrium


def _bivectors(lesson: Balance, j: int) -> list[Step]:
    body, system, here = lesson.scene.bodies[j].name, lesson.system, numbered(Letters.body_number(j), j)
    known = system.bodies[j]
    columns = [
        _bivector(lesson, j, kind, here, [(lesson.short(x), x) for x in lesson.system.written(entries)], number)
        for kind, entries, number in (("A", known.action, "5.1"), ("D", known.inertia, "5.17"))
    ]
    for h, hinge in enumerate(system.hanging.hinges):
        own = h == j
        present = [u for u, one in enumerate(system.unknowns) if (j, u) in system.blocks and one.acts[0][0] == h]
        if present:
            index = here if own else (str(Letters.body_number(j)), hinge.joint.name)
            kind, number = ("R", "5.6") if own else ("*R", "5.10")
            columns.append(_bivector(lesson, j, kind, index, _exerted(lesson, j, present), number))
    balance: list[Block] = []
    substituted: list[Block] = []
    for row in range(len(lesson.axes)):
        present_in = [column for column in columns if column.entries[row] != Number.ZERO]
        if present_in:
            parts = [Symbol(column.names[row]) for column in present_in]
            balance.append(Formula("", Form.sum(parts), "5.18" if row == 0 else "", Number.ZERO))
            whole = Form.sum(column.entries[row] for column in present_in)
            substituted.append(folded(lesson, Formula("", whole, right=Number.ZERO)))
    if lesson.empty and j == 0:
        columns = [_of_six_rows(lesson, column) for column in columns]
    shown = [_folded(lesson, column) for column in columns]
    if lesson.empty and j == 0:
        shown.append(lesson.say("bivectors.plane", rows=lesson.empty))
    claim, reason = lesson.say("bivectors", body=body), _once(lesson, j, "bivectors.reason")
    bivectors = Step(f"bivectors:{body}", claim, tuple(shown), reason, "(5.1)-(5.17)")
    claim, reason = lesson.say("balance", body=body), _once(lesson, j, "balance.reason")
    put_in = lesson.say("substituted", body=body)
    return [
        bivectors,
        Step(f"balance:{body}", claim, tuple(balance), reason, "(5.18)"),
        Step(f"substituted:{body}", put_in, tuple(substituted), _once(lesson, j, "substituted.reason"), "(5.18)"),
    ]


def _exerted(lesson: Balance, j: int, present: Sequence[int]) -> list[tuple[Form, Expr]]:
    """Return what the unknowns of one joint exert on body j, as forms and as nodes."""
    columns = [lesson.system.written(lesson.system.blocks[j, u]) for u in present]
    sizes = [lesson.unknowns[u] for u in present]
    entries = []
    for row in zip(*columns, strict=True):
        form = Form.sum(Form.product((lesson.short(x), size)) for x, size in zip(row, sizes, strict=True))
        values = [lesson.names[size.name].node for size in sizes]
        node = lesson.graph.total(x * value for x, value in zip(row, values, strict=True) if value is not None)
        entries.append((form, node))
    return entries


def _bivector(
    lesson: Balance, j: int, kind: str, index: tuple[str, ...], entries: Sequence[tuple[Form, Expr]], number: str
) -> Matrix:
    names = []
    for (F, axis), (_, node) in zip(lesson.axes, entries, strict=True):
        key = f"{F}{kind}:{','.join(index)}:{axis}"
        lesson.called(key, Letter(F, (*index, axis), above=kind), node)
        names.append(key)
    left = f"F{kind}:{','.join(index)}"
    lesson.called(left, Letter("F", index, above=kind, accent="bar"))
    tag = number if j == 0 or len(names) == 6 else ""  # three rows of a plane are no bivector of the book
    return Matrix(left, tuple(form for form, _ in entries), tuple(names), tag)


def _of_six_rows(lesson: Balance, column: Matrix) -> Matrix:
    """Return a bivector of a plane with the rows that are empty there."""
    above, index, _ = column.names[0].split(":")
    entries, names = list(column.entries), list(column.names)
    for row, (F, axis) in enumerate((F, axis) for F in "FM" for axis in "xyz"):
        if row not in lesson.system.kept:
            key = f"{F}{above[1:]}:{index}:{axis}"
            lesson.called(key, Letter(F, (*index.split(","), axis), above=above[1:]), lesson.graph.zero)
            entries.insert(row, Number.ZERO)
            names.insert(row, key)
    return replace(column, entries=tuple(entries), names=tuple(names))


def _folded(lesson: Balance, matrix: Matrix) -> Block:
    """Return a matrix, or its entries one below the other in a fold where they are long."""
    terms = [length(entry) for entry in matrix.entries]
    if max(terms) <= WIDEST:  # no text is shorter than its terms
        cells = [len(text_of(entry)) for entry in matrix.entries]
        columns = [max(cells[k :: matrix.width]) for k in range(matrix.width)]
        if sum(columns) + GAP * (len(columns) - 1) <= WIDEST:
            return matrix
    if sum(terms) > MOST:
        return lesson.say("longer", name=Symbol(matrix.left), terms=str(sum(terms)))
    pairs = zip(matrix.names, matrix.entries, strict=True)
    entries = tuple(Formula(name, form) for name, form in pairs)
    return Fold(lesson.say("long", name=Symbol(matrix.left), terms=str(sum(terms))), entries)
