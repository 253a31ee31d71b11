"""Steps: equations to first order next to a stable and an unstable rest, frequencies by formula, shapes in numbers.

Formulas are of places that are known exactly, and hold for all values of the parameters; numbers of all places.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.algebra import Array, Form, Number, Ratios, Symbol
from symdyn.draw import Stage, swing
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, gradient, substitute
from symdyn.linear import Equilibrium
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.afterwards.closed import eigenvalues
from symdyn.teach.derivations.afterwards.equilibria import Rests
from symdyn.teach.derivations.lagrange.velocities import length
from symdyn.teach.document import Block, Formula, Letter, Matrix, Picture, Step, Words
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.shown_state import Chosen

MOST_FREEDOMS = 3
"""Of formulas and pictures; numbers are told of more."""

LONGEST = 40
"""Terms and factors of a formula that is shown."""

ANGLE, PART = 0.35, 0.15
"""The largest displacement in a picture: of an angle, rad, and of a length over the extent of the mechanism."""

TAGS = {"stable": "s", "unstable": "u"}

Modes = Sequence[tuple[float, Array]]
"""ω² and shapes, the number of each in print its place."""


def near_rest_steps(lesson: Lesson, rests: Rests, chosen: Chosen) -> list[Step]:
    """Return, of a stable and of an unstable place, equations to first order, frequencies and shapes."""
    steps: list[Step] = []
    for kind in TAGS:
        place = next((one for one in rests.places if one.kind == kind), None)
        if place is not None and place.near.of(place.near.moved).moves:
            reason = Words(()) if steps else lesson.say("near.reason")
            claim = lesson.say(f"near.{kind}", where=Words(tuple(rests.where(place))))
            blocks = _blocks(lesson, rests, place, chosen)
            steps.append(Step(f"near:{kind}", claim, blocks, reason, show=("angles", "weights", "forces")))
    return steps


def _blocks(lesson: Lesson, rests: Rests, place: Equilibrium, chosen: Chosen) -> tuple[Block, ...]:
    moved, blocks = place.near.moved, list[Block]()
    near, modes = place.near.of(moved), place.near.of(moved).modes
    idle = [named(q) for k, q in enumerate(lesson.state.q) if k not in moved]
    if idle:
        blocks.append(lesson.say("near.massless", names=together(idle)))
    if place.exact is not None and len(moved) <= MOST_FREEDOMS:
        blocks += _formulas(lesson, rests, place, modes, chosen)
    if near.symmetric:
        blocks += _modes(lesson, place, modes, chosen)
        if any(square < 0 for square, _ in modes):
            blocks.append(lesson.say("near.negative"))
    if np.abs(near.D).max() > 0 or not near.symmetric:
        values = [*(mode.value for mode in near.spectrum.modes), *([0j] if near.spectrum.zeros else [])]
        told = eigenvalues(lesson, sorted(values, key=lambda x: (-x.real, x.imag)))
        blocks.append(lesson.say("near.damped" if near.symmetric else "near.turned", values=told))
    return tuple(blocks)


# Formulas


def _formulas(lesson: Lesson, rests: Rests, place: Equilibrium, modes: Modes, chosen: Chosen) -> list[Block]:
    """Return inertia and stiffness, and the frequencies that have a short formula."""
    state, moved, tag = lesson.state, place.near.moved, TAGS[place.kind]
    n, names = len(moved), [str(k + 1) for k in moved]
    exact = {q: place.exact[str(q.value)].express(lesson.graph) for q in rests.q} if place.exact else {}
    M = [gradient(lesson.momenta[k], [state.qd[j] for j in moved]) for k in moved]
    K = [gradient(rests.forces[k], [state.q[j] for j in moved]) for k in moved]
    matrices = [[substitute(row, exact) for row in rows] for rows in (M, K)]
    shown = [[_short(lesson, x) for row in matrix for x in row] for matrix in matrices]
    if max(length(x) for forms in shown for x in forms) > LONGEST:
        return []
    blocks: list[Block] = [lesson.say("near.drop")]
    for letter, matrix, forms in zip("AC", matrices, shown, strict=True):
        keys = [f"near:{tag}:{letter}:{i},{j}" for i in names for j in names]
        entries = [x for row in matrix for x in row]
        for key, node in zip(keys, entries, strict=True):
            lesson.name(key, letter, tag, *([] if n == 1 else key.rpartition(":")[2].split(",")), node=node)
        if n == 1:
            blocks.append(Formula(keys[0], forms[0]))
        else:
            whole = lesson.called(f"near:{tag}:{letter}", Letter(letter, (tag,)))
            blocks.append(Matrix(whole.name, tuple(forms), tuple(keys), width=n))
    return [*blocks, *_frequencies(lesson, matrices, modes, tag, chosen)]


def _short(lesson: Lesson, node: Expr) -> Form:
    """Return a node in the ring of the lesson, or as a quotient where a spring is none of the ring's."""
    try:
        return lesson.short(node)
    except (DerivationError, KeyError):
        return Ratios.form_of(node)


def _frequencies(
    lesson: Lesson, matrices: Sequence[Sequence[Sequence[Expr]]], modes: Modes, tag: str, chosen: Chosen
) -> list[Block]:
    """Return ω² by the factors of det(C - ω² A) = 0 that are of first and second degree in ω², numbered as shapes."""
    n, flat = len(matrices[0]), [x for matrix in matrices for row in matrix for x in row]
    try:
        field = Ratios(flat)
        known = evaluate(flat, field, field.values())
        rows = [known[k : k + n] for k in range(0, len(known), n)]
        found = field.factors(field.characteristic(field.solved(rows[:n], rows[n:])))
    except (ZeroDivisionError, OverflowError):
        return []
    shown: dict[int, list[Block]] = {}
    left = dict(enumerate((square for square, _ in modes), 1))
    for monic, times in found:
        forms = [field.form(x) for x in monic[1:]]
        roots = np.roots([1.0, *chosen.of(*(x.express(lesson.graph) for x in forms))]).real
        count, *_ = sorted(_taken(left, float(root)) for root in np.repeat(roots, times))
        key, index = f"near:{tag}:omega:{count}", (tag, str(count)) if len(found) > 1 else (tag,)
        if monic[-1].is_zero or len(monic) > 3 or max(map(length, forms)) > LONGEST:
            continue
        if len(monic) == 2:
            square = forms[0].negative
            lesson.name(key, "omega", *index, node=square.express(lesson.graph), power=2)
            shown[count] = [Formula(key, square)]
        else:
            sum_, product = forms[0].negative, forms[1]
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


# Numbers


def _modes(lesson: Lesson, place: Equilibrium, modes: Modes, chosen: Chosen) -> list[Block]:
    """Return the table of frequencies and shapes, and a picture of every shape that swings; of one freedom a line."""
    rows: list[list[str | Form | Words]] = []
    moved = place.near.moved
    for k, (square, shape) in enumerate(modes, 1):
        root = abs(square) ** 0.5
        kind = "swing" if square > 0 else "leave" if square < 0 else "drift"
        time = f"{lesson.about(2 * np.pi / root if square > 0 else 1 / root)} s" if square else ""
        told = lesson.text(f"near.mode.{kind}", rate=lesson.equals(root), time=time)
        rows.append([str(k), told, *(lesson.written(float(x)) for x in shape)])
    if len(rows) == 1:
        return [lesson.say("near.one", told=str(rows[0][1]))]
    heads: list[str | Symbol] = ["near.mode", "near.mode.kind", *(named(lesson.state.q[k]) for k in moved)]
    blocks: list[Block] = [lesson.say("near.modes"), lesson.table(heads, rows)]
    for k, (square, shape) in enumerate(modes, 1):
        if square > 0 and place.kind == "stable" and len(moved) <= MOST_FREEDOMS:
            whole = np.zeros(len(place.q))
            whole[list(moved)] = shape
            blocks.append(_picture(lesson, chosen, place.q, whole, k))
    return blocks


def _picture(lesson: Lesson, chosen: Chosen, rest: Array, shape: Array, number: int) -> Picture:
    """Return the picture of one shape about a place of rest; q and shape have shape (nq,)."""
    scene, values = lesson.scene, chosen.parameters
    length = Stage(scene, rest[None], values).places.reach
    units = SceneUnits(scene).coordinates
    limits = np.array([ANGLE if unit == "rad" else PART * length for unit in units])
    away = shape / float((np.abs(shape) / limits).max())
    title = lesson.text("near.shape.alt", number=str(number), scene=scene.name)
    stage = Stage(scene, np.stack([rest + away, rest, rest - away]), values)
    text = swing(stage, title, lesson.text("near.ghosts"), f"mode{number}-", lesson.titles)
    return Picture(text, lesson.say("near.shape", number=str(number)), title, f"mode{number}")
