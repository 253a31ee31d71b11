"""Steps: equations to first order next to a stable and an unstable rest, frequencies by formula, shapes in numbers.

Formulas are of places that are known exactly, and hold for all values of the parameters; numbers of all places.
"""

from __future__ import annotations

import numpy as np

from symdyn.algebra import Form, Number, Ratios, Symbol
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.afterwards.equilibria import RestPlace, Rests
from symdyn.teach.derivations.afterwards.first_order import FirstOrder, first_order
from symdyn.teach.derivations.afterwards.mode_pictures import mode_picture
from symdyn.teach.derivations.lagrange.velocities import length
from symdyn.teach.document import Block, Formula, Letter, Matrix, Step, Words
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.shown_state import Chosen

MOST_FREEDOMS = 3
"""Of formulas and pictures; numbers are told of more."""

LONGEST = 40
"""Terms and factors of a formula that is shown."""

TAGS = {"stable": "s", "unstable": "u"}


def near_rest_steps(lesson: Lesson, rests: Rests, chosen: Chosen) -> list[Step]:
    """Return, of a stable and of an unstable place, equations to first order, frequencies and shapes."""
    steps: list[Step] = []
    for kind in TAGS:
        place = next((one for one in rests.places if one.kind == kind), None)
        near = None if place is None else first_order(lesson, rests, place, chosen)
        if place is not None and near is not None:
            reason = Words(()) if steps else lesson.say("near.reason")
            claim = lesson.say(f"near.{kind}", where=_where(lesson, rests, place))
            blocks = _blocks(lesson, place, near, chosen)
            steps.append(Step(f"near:{kind}", claim, blocks, reason, show=("angles", "weights", "forces")))
    return steps


def _where(lesson: Lesson, rests: Rests, place: RestPlace) -> Words:
    """Return "q1 = 0, q2 = π"."""
    parts: list[str | Form] = []
    for q, x in zip(rests.rest.q, place.shown, strict=True):
        parts += [*([", "] if parts else []), named(q), " ≈ " if isinstance(x, str) else " = ", x]
    return Words(tuple(parts))


def _blocks(lesson: Lesson, place: RestPlace, near: FirstOrder, chosen: Chosen) -> tuple[Block, ...]:
    blocks: list[Block] = []
    idle = [named(q) for k, q in enumerate(lesson.state.q) if k not in near.moved]
    if idle:
        blocks.append(lesson.say("near.massless", names=together(idle)))
    if place.exact is not None and len(near.moved) <= MOST_FREEDOMS:
        blocks += _formulas(lesson, TAGS[place.kind], near, chosen)
    if near.symmetric:
        blocks += _modes(lesson, place, near, chosen)
        if any(square < 0 for square, _ in near.modes):
            blocks.append(lesson.say("near.negative"))
    if np.abs(near.D).max() > 0 or not near.symmetric:
        told = []
        for x in near.eigenvalues:
            real = lesson.written(x.real) if x.real or not x.imag else ""
            told.append(f"{real} ± {lesson.written(x.imag)} i".strip() if x.imag else real)
        blocks.append(lesson.say("near.damped" if near.symmetric else "near.turned", values="; ".join(told)))
    return tuple(blocks)


# Formulas


def _formulas(lesson: Lesson, tag: str, near: FirstOrder, chosen: Chosen) -> list[Block]:
    """Return inertia and stiffness, and the frequencies that have a short formula."""
    n, names = len(near.moved), [str(k + 1) for k in near.moved]
    shown = [[_short(lesson, x) for row in matrix for x in row] for matrix in near.nodes]
    if max(length(x) for forms in shown for x in forms) > LONGEST:
        return []
    blocks: list[Block] = [lesson.say("near.drop")]
    for letter, matrix, forms in zip("AC", near.nodes, shown, strict=True):
        keys = [f"near:{tag}:{letter}:{i},{j}" for i in names for j in names]
        entries = [x for row in matrix for x in row]
        for key, node in zip(keys, entries, strict=True):
            lesson.name(key, letter, tag, *([] if n == 1 else key.rpartition(":")[2].split(",")), node=node)
        if n == 1:
            blocks.append(Formula(keys[0], forms[0]))
        else:
            whole = lesson.called(f"near:{tag}:{letter}", Letter(letter, (tag,)))
            blocks.append(Matrix(whole.name, tuple(forms), tuple(keys), width=n))
    return [*blocks, *_frequencies(lesson, near, tag, chosen)]


def _short(lesson: Lesson, node: Expr) -> Form:
    """Return a node in the ring of the lesson, or as a quotient where a spring is none of the ring's."""
    try:
        return lesson.short(node)
    except (DerivationError, KeyError):
        field = Ratios([node])
        return field.form(evaluate([node], field, field.values())[0])


def _frequencies(lesson: Lesson, near: FirstOrder, tag: str, chosen: Chosen) -> list[Block]:
    """Return ω² by the factors of det(C - ω² A) = 0 that are of first and second degree in ω², numbered as shapes."""
    matrices = near.nodes
    n, flat = len(matrices[0]), [x for matrix in matrices for row in matrix for x in row]
    try:
        field = Ratios(flat)
        known = evaluate(flat, field, field.values())
        rows = [known[k : k + n] for k in range(0, len(known), n)]
        found = field.factors(field.characteristic(field.solved(rows[:n], rows[n:])))
    except (ZeroDivisionError, OverflowError):
        return []
    shown: dict[int, list[Block]] = {}
    left = dict(enumerate((square for square, _ in near.modes), 1))
    for monic, times in found:
        forms = [field.form(x) for x in monic[1:]]
        roots = np.roots([1.0, *chosen.of(*(x.express(lesson.graph) for x in forms))]).real
        count, *_ = sorted(_taken(left, float(root)) for root in np.repeat(roots, times))
        key, index = f"near:{tag}:omega:{count}", (tag, str(count)) if len(found) > 1 else (tag,)
        if monic[-1].is_zero or len(monic) > 3 or max(map(length, forms)) > LONGEST:
            continue
        if len(monic) == 2:
            square = _negated(forms[0])
            lesson.name(key, "omega", *index, node=square.express(lesson.graph), power=2)
            shown[count] = [Formula(key, square)]
        else:
            sum_, product = _negated(forms[0]), forms[1]
            omega = lesson.name(key, "omega", *index, node=None)
            b = lesson.name(f"{key}:b", "b", *index, node=sum_.express(lesson.graph))
            d = lesson.name(f"{key}:d", "d", *index, node=product.express(lesson.graph))
            whole = Form.sum((omega.power(4), Form.product((Number.MINUS_ONE, b, omega.power(2))), d))
            shown[count] = [lesson.say("near.two", equation=whole), Formula(b.name, sum_), Formula(d.name, product)]
    blocks = [block for count in sorted(shown) for block in shown[count]]
    if blocks:
        symbol = lesson.name(f"near:{tag}:omega", "omega", tag, node=None)
        said = "near.frequency" if n == 1 else "near.frequencies"
        blocks.insert(0, lesson.say(said, omega=symbol, square=symbol.power(2)))
    return blocks


def _taken(left: dict[int, float], square: float) -> int:
    """Return the number of the shape whose ω² is nearest, which is taken from those left."""
    count = min(left, key=lambda k: abs(left[k] - square))
    del left[count]
    return count


def _negated(form: Form) -> Form:
    """Return -form, a minus in front of a term taken off."""
    signed = (term.split_sign() for term in form.terms)
    return Form.sum(Form.product((Number.MINUS_ONE, rest)) if sign > 0 else rest for sign, rest in signed)


# Numbers


def _modes(lesson: Lesson, place: RestPlace, near: FirstOrder, chosen: Chosen) -> list[Block]:
    """Return the table of frequencies and shapes, and a picture of every shape that swings; of one freedom a line."""
    rows: list[list[str | Form | Words]] = []
    for k, (square, shape) in enumerate(near.modes, 1):
        root = abs(square) ** 0.5
        kind = "swing" if square > 0 else "leave" if square < 0 else "drift"
        time = f"{lesson.about(2 * np.pi / root if square > 0 else 1 / root)} s" if square else ""
        told = lesson.text(f"near.mode.{kind}", rate=lesson.equals(root), time=time)
        rows.append([str(k), told, *(lesson.written(float(x)) for x in shape)])
    if len(rows) == 1:
        return [lesson.say("near.one", told=str(rows[0][1]))]
    heads: list[str | Symbol] = ["near.mode", "near.mode.kind", *(named(lesson.state.q[k]) for k in near.moved)]
    blocks: list[Block] = [lesson.say("near.modes"), lesson.table(heads, rows)]
    units = SceneUnits(lesson.scene).coordinates
    for k, (square, shape) in enumerate(near.modes, 1):
        if square > 0 and place.kind == "stable" and len(near.moved) <= MOST_FREEDOMS:
            whole = np.zeros(len(near.at))
            whole[list(near.moved)] = shape
            blocks.append(mode_picture(lesson, chosen, near.at, whole, units, k))
    return blocks
