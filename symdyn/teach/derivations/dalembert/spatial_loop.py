"""A loop in space with its motion left in letters, as figure 5.39 has it: vectors, six rows a body, one block matrix.

Written out, an acceleration of such a loop is longer than anyone reads. It is known all the same, and so the equations
are of its name:

    F̄^R_jj - Σ R̄_je P̄_je F̄^R_ee = -F̄^A_jj - F̄^D_jj      (5.18), e the other joints of body j

Beside every name stands its value at the state that the lesson shows.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.algebra import Form, Number, Symbol
from symdyn.draw import Lettered, Wrench, picture
from symdyn.dynamics.reactions import JointFrames
from symdyn.emit.print import Letters
from symdyn.spatial import sub
from symdyn.teach.derivations.dalembert.balance import Balance, Cut
from symdyn.teach.derivations.dalembert.shown_motion import SMALL, solved_at
from symdyn.teach.document import Block, Formula, Letter, Matrix, Picture, Step, Words
from symdyn.teach.shown_state import Chosen


def numbered(first: int, j: int) -> tuple[str, ...]:
    """Return the index of frame `first` and body j: "01", "11"."""
    number = Letters.body_number(j)
    return (f"{first}{number}",) if number < 10 else (str(first), str(number))


def other_joints(lesson: Balance, j: int) -> list[tuple[int, JointFrames, bool]]:
    """Return the joints of body j but its reference joint, by number; whether it takes their wrench as it is written.

    That is so where it is the child of a joint that closes a loop; everything else takes the opposite.
    """
    hinges = enumerate(lesson.system.hanging.hinges)
    return [(h, hinge, hinge.child == j) for h, hinge in hinges if h != j and j in (hinge.parent, hinge.child)]


class Named:
    """The names of a lesson's vectors and matrices, made when they are asked for."""

    def __init__(self, lesson: Balance) -> None:
        """Name what belongs to a lesson."""
        self.lesson = lesson

    def of(self, letter: str, *index: str, dots: int = 0, above: str = "", accent: str = "") -> Symbol:
        """Name a vector or a matrix of one body."""
        key = f"{'d' * dots}{letter}{above}{accent}:{','.join(index)}"
        return self.lesson.called(key, Letter(letter, index, dots, above=above, accent=accent))

    def carried(self, j: int, h: int) -> tuple[str, ...]:
        """Return the index of what takes the wrench of joint h to body j: the book's je."""
        number, joints = Letters.body_number(j), self.lesson.scene.joints
        if h < len(joints):
            return numbered(number, h)
        return str(number), self.lesson.system.hanging.hinges[h].joint.name

    def transmitted(self, h: int) -> Symbol:
        """Name the bivector of joint h: of the body that it carries, or of the joint where it carries none."""
        if h < len(self.lesson.scene.joints):
            return self.of("F", *numbered(Letters.body_number(h), h), above="R", accent="bar")
        return self.of("F", self.lesson.system.hanging.hinges[h].joint.name, above="R", accent="bar")

    def shifts(self, j: int, h: int) -> tuple[Symbol, Symbol]:
        """Name R̄_je and P̄_je."""
        index = self.carried(j, h)
        return self.of("R", *index, accent="bar"), self.of("P", *index, accent="bar")


def named_steps(lesson: Balance, j: int, one: Cut, chosen: Chosen) -> list[Step]:
    """Return the motion of body j in letters with its values, and its inertia forces of them."""
    names, body, number = Named(lesson), lesson.scene.bodies[j].name, str(Letters.body_number(j))
    index, here, arm = numbered(0, j), numbered(Letters.body_number(j), j), (number, f"T{number}")
    a_T, a_O = (names.of("r", "0", f"{point}{number}", dots=2) for point in "TO")
    w, dw, spin = (names.of("omega", *index, dots=k, accent=accent) for k, accent in ((0, ""), (1, ""), (0, "tilde")))
    rows = (
        (a_T, one.centre[2], "m/s²"),
        (a_O, one.origin[2], "m/s²"),
        (w, one.w, "rad/s"),
        (dw, one.dw, "rad/s²"),
    )
    heads: list[str | Symbol] = ["symbol", *(names.of(axis) for axis in "xyz"), "unit"]
    shown: list[list[str | Form | Words]] = [
        [symbol, *_numbers(lesson, chosen.of(*vector)), unit] for symbol, vector, unit in rows
    ]
    centred = all(x.is_zero for x in one.arm)
    claim, reason = lesson.say("letters", body=body), lesson.say("letters.reason") if j == 0 else Words(())
    motion = Step(f"letters:{body}", claim, (lesson.table(heads, shown),), reason)
    m, back = lesson.short(one.m), names.of("P", *index, above="T")
    F, M = (names.of(letter, *here, above="D") for letter in "FM")
    star, lever = names.of("F", *here, above="*D"), names.of("r", *arm, accent="tilde")
    tensor = names.of("I", *here)
    blocks: list[Block] = [Formula(F.name, Form.product((Number.MINUS_ONE, m, back, a_T)), "5.13")]
    spun = Form.product((Number.MINUS_ONE, Form.sum((Form.product((tensor, dw)), Form.product((spin, tensor, w))))))
    if centred:
        blocks.append(Formula(M.name, spun, "5.14"))
    else:
        blocks.append(Formula(star.name, Form.product((Number.MINUS_ONE, m, back, a_O)), "5.16"))
        blocks.append(Formula(M.name, Form.sum((spun, Form.product((lever, star)))), "5.14"))
    return [motion, Step(f"inertia:{body}", lesson.say("letters.inertia", body=body), tuple(blocks))]


def balance_steps(lesson: Balance, j: int, chosen: Chosen) -> list[Step]:
    """Return what the other joints do, (5.8)-(5.10), and (5.18) of body j: in letters, and its six rows in numbers."""
    names, body, here = Named(lesson), lesson.scene.bodies[j].name, numbered(Letters.body_number(j), j)
    known, x = lesson.system.bodies[j], solved_at(lesson, chosen)[0]
    A, D = (names.of("F", *here, above=above, accent="bar") for above in "AD")
    columns: list[tuple[Symbol, Sequence[float]]] = [
        (symbol, chosen.of(*wrench[0], *wrench[1])) for symbol, wrench in ((A, known.action), (D, known.inertia))
    ]
    columns = [(symbol, entries) for symbol, entries in columns if any(entries)]
    columns.append((names.transmitted(j), _exerted(lesson, j, j, x, chosen)))
    others: list[Block] = []
    for h, hinge, as_written in other_joints(lesson, j):
        star = names.of("F", str(Letters.body_number(j)), hinge.joint.name, above="*R", accent="bar")
        others.append(Formula(star.name, _carried(names, j, h, as_written), "" if others else "5.10"))
        columns.append((star, _exerted(lesson, j, h, x, chosen)))
    kinds = [(names.of(letter, axis), "N" if letter == "F" else "N m") for letter in "FM" for axis in "xyz"]
    values = [_numbers(lesson, entries) for _, entries in columns]
    rows: list[list[str | Form | Words]] = [
        [symbol, *(one[k] for one in values), unit] for k, (symbol, unit) in enumerate(kinds)
    ]
    equation = Formula("", Form.sum(symbol for symbol, _ in columns), "5.18", Number.ZERO)
    blocks = (*others, equation, lesson.table(("symbol", *(symbol for symbol, _ in columns), "unit"), rows))
    P, R = (names.of(letter, "je", accent="bar") for letter in "PR")
    reason = lesson.say("letters.balance.reason", P=P, R=R) if j == 0 else Words(())
    return [Step(f"balance:{body}", lesson.say("balance", body=body), blocks, reason, "(5.8)-(5.18)")]


def _carried(names: Named, j: int, h: int, as_written: bool) -> Form:
    """Return what joint h exerts on body j as its matrices make it of the wrench that it transmits."""
    form = Form.product((*names.shifts(j, h), names.transmitted(h)))
    return form if as_written else Form.product((Number.MINUS_ONE, form))


def block_matrices(lesson: Balance, A: Symbol, x: Symbol, b: Symbol) -> list[Block]:
    """Return A, x and b of the whole system in blocks of six rows: a row of blocks a body, a column a joint."""
    names, hinges = Named(lesson), lesson.system.hanging.hinges
    unit, nothing = (lesson.called(f"block:{sign}", Letter(rf"\mathbf{{{sign}}}")) for sign in "10")
    blocks: list[Form] = []
    known: list[Form] = []
    for j in range(len(lesson.scene.bodies)):
        others = {h: as_written for h, _, as_written in other_joints(lesson, j)}
        for h in range(len(hinges)):
            own = unit if h == j else nothing
            shifts = Form.product(names.shifts(j, h)) if h in others else own
            blocks.append(Form.product((Number.MINUS_ONE, shifts)) if others.get(h) is False else shifts)
        here = numbered(Letters.body_number(j), j)
        known.append(Form.sum(names.of("F", *here, above=above, accent="bar") for above in "AD"))
    unknown = [names.transmitted(h) for h in range(len(hinges))]

    def shown(left: Symbol, entries: Sequence[Form], width: int = 1) -> Matrix:
        keys = tuple(next(iter(entry.symbols), nothing.name) for entry in entries)
        return Matrix(left.name, tuple(entries), keys, "", width)

    return [shown(A, blocks, len(hinges)), shown(x, unknown), shown(b, known), lesson.say("letters.blocks", one=unit)]


def _exerted(lesson: Balance, j: int, h: int, x: np.ndarray, chosen: Chosen) -> list[float]:
    """Return what joint h exerts on body j at the shown state; axes of frame j, about O_j."""
    total = np.zeros(6)
    for u, one in enumerate(lesson.system.unknowns):
        if one.acts[0][0] == h and (j, u) in lesson.system.blocks:
            force, moment = lesson.system.blocks[j, u]
            total += x[u] * np.array(chosen.of(*force, *moment))
    return [float(value) for value in total]


def _numbers(lesson: Balance, values: Sequence[float]) -> list[str]:
    """Return numbers of one vector; what is nothing beside the others is zero."""
    size = max(map(abs, values), default=0.0)
    return [lesson.written(0.0 if abs(value) < SMALL * size else value) for value in values]


def loop_picture(lesson: Balance, chosen: Chosen) -> Step:
    """Return the mechanism with the letters of figure 5.39: O and T of the bodies, and the joints of the one cut free.

    That is a body away from the ground: at its reference joint O_j with the actions F^A and M^A, at every other joint
    S_e and O_je with the reaction F_je.
    """
    hanging = lesson.system.hanging
    grounded = {
        body for hinge in hanging.hinges if -1 in (hinge.parent, hinge.child) for body in (hinge.parent, hinge.child)
    }
    cut = next((j for j in range(len(lesson.scene.bodies)) if j not in grounded), 0)
    O, T, S, F, M = (lesson.letters.latex(letter) for letter in "OTSFM")  # noqa: E741  the book's names
    number = Letters.body_number(cut)
    named: dict[tuple[float, ...], list[str]] = {(0.0, 0.0, 0.0): [f"{O}_0"]}
    for j, one in enumerate(lesson.cuts):
        places = {O: hanging.frames[j].p} | ({T: one.centre[0]} if one is not None else {})
        for letter, place in places.items():
            at = tuple(round(value, 9) + 0.0 for value in chosen.of(*place))
            named.setdefault(at, []).append(f"{letter}_{{{Letters.body_number(j)}}}")
    frame, x = hanging.frames[cut], solved_at(lesson, chosen)[0]
    start, known = chosen.of(*frame.p), lesson.system.bodies[cut].action
    here = "".join(numbered(number, cut))
    names = f"{F}_{{{here}}}^A", f"{M}_{{{here}}}^A"
    couple = chosen.of(*frame.R @ known[1])
    wrenches = [Wrench(names[0], start, chosen.of(*frame.R @ known[0]), couple, names[1])]
    turned = np.array(chosen.of(*(entry for row in frame.R for entry in row))).reshape(3, 3)
    for h, hinge, _ in other_joints(lesson, cut):
        own = hinge.place_on_child if hinge.child == cut else hinge.place_on_parent
        point = chosen.of(*frame.point(sub(own, hanging.joints[cut].place_on_child)))
        joint = rf"\mathrm{{{hinge.joint.name}}}"
        force = turned @ np.array(_exerted(lesson, cut, h, x, chosen)[:3])
        key = tuple(round(value, 9) + 0.0 for value in point)
        named.setdefault(key, []).append(rf"{S}_{{{joint}}}, {O}_{{{number},{joint}}}")
        wrenches.append(Wrench(rf"{F}_{{{number},{joint}}}^{{*R}}", point, [float(value) for value in force]))
    letters = [Lettered(", ".join(texts), at) for at, texts in named.items()]
    said = {"body": lesson.scene.bodies[cut].name, "number": str(number)}
    svg = picture(
        lesson.scene, chosen.q, chosen.parameters, labels=(), wrenches=wrenches, prefix="loop-", titles=lesson.titles,
        letters=letters,
    )  # fmt: skip
    shown = Picture(svg, lesson.say("letters.caption", **said), lesson.text("letters.caption", **said), "loop")
    return Step("letters:figure", lesson.say("letters.figure"), (shown,), lesson.say("letters.figure.reason"))
