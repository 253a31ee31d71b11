"""Which terms of a wrong answer differ, by what `symdyn.teach.student.evidence` knows of the right one.

    mine / factor = Σ t_k + e        e = c t_k        c = -1: lost, -2: turned, other numbers: a wrong factor
                                     e = (n a / b - 1) t_k    a stands for b in it: a symbol, a rate, a sine
                                     e = c t_k + d t_l        two terms at once

The factor of an equation is what makes the coefficient of an acceleration, of a drive or of a parameter that of the
scene. A page does the same with the same numbers: `templates/teach/terms.js`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, permutations, product
from math import cos, isfinite, pi, prod, sin

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array, Form, Pi, Power, Sum
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op
from symdyn.scene import SceneUnits
from symdyn.teach.student.course import Course
from symdyn.teach.student.evidence import ALIKE, CLOSE, PAIRED, Column, Evidence, linear, moved
from symdyn.teach.student.mistakes import PLAIN, STATES
from symdyn.teach.student.motions import Motions, at_points
from symdyn.teach.student.wrong_energies import ratios
from symdyn.unlocked import cached_property

FACTOR, SCALED, UNTIED = 1.5, 0.05, 0.1
"""Prices: of a wrong factor, of an equation times a factor, of multipliers in it or their absence."""
BOTH, WRITTEN = (-1.0, -2.0, 1.0, -0.5), 60
"""How a term is changed beside one in which something else stands: lost, turned, doubled, halved; terms as written."""
ROUND = tuple((n * pi) ** k for n in (1, 2) for k in (-2, -1, 1, 2))
"""Factors of a constant that stands with another power."""
WHOLE = ((-1.0, "turned"), (0.5, "factor"), (2.0, "factor"))
"""What all of a quantity is taken times where nothing else tells, and what it was then."""


@dataclass(frozen=True)
class Atom:
    """What a factor of a term may be: function ("", "sin", "cos", "sin^2", "cos^2"), of what, unit, and values."""

    function: str
    of: str
    unit: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Atoms:
    """Atoms, two and two; `ratios`: names that are one of gears, by order of the alphabet."""

    every: tuple[Atom, ...]
    ratios: frozenset[tuple[str, ...]] = frozenset()

    @cached_property
    def pairs(self) -> list[tuple[Atom, Atom, int]]:
        """Return what a term may be times: a/b, and with the last number 1 or -1 both, or one over both."""
        apart = [(a, b) for a, b in permutations(self.every, 2) if (a.function, a.of) != (b.function, b.of)]
        every = set(apart)
        both = [pair for pair in combinations(self.every[1:], 2) if pair in every]
        return [*((a, b, 0) for a, b in apart), *((a, b, power) for a, b in both for power in (1, -1))]

    @cached_property
    def quotients(self) -> tuple[Array, Array, NDArray[np.intp]]:
        """Return one over what a term may be times, by pair and point, sorted by x2/x1; these slopes, and the pairs."""
        values = {one: np.array(one.values) for one in self.every}
        with np.errstate(divide="ignore", invalid="ignore"):  # where a factor vanishes at a point it explains nothing
            pairs = [values[b] / values[a] if not p else (values[a] * values[b]) ** -p for a, b, p in self.pairs]
            slopes = np.array([one[1] / one[0] for one in pairs])
        order = np.argsort(slopes)
        return np.array(pairs)[order], slopes[order], order


@dataclass(frozen=True, order=True)
class Found:
    """What differs, the simplest first: price, terms by number, rules; `sure` where terms are lost or turned."""

    price: float
    terms: tuple[int, ...]
    rules: tuple[str, ...]
    sure: bool = False


def explained(evidence: Evidence, atoms: Atoms, node: Expr) -> Found | None:
    """Return what differs in a wrong answer, by its value at points; None where that cannot be told."""
    (mine,) = at_points([node], evidence.points)
    scaled = [(price, [x * y for x, y in zip(mine, by, strict=True)]) for price, by in _scales(evidence, node)]
    told: list[Found] = []
    for deep in (False, True):  # two terms at once only where no single one tells
        ways = () if told else scaled
        found = ((more, _search(evidence, atoms, row, deep)) for more, row in ways)
        told += [replace(one, price=one.price + more) for more, one in found if one]
    for times, rule in () if told or evidence.handles else WHOLE:
        one = _search(evidence, atoms, [times * x for x in mine], deep=False)
        told += [replace(one, price=one.price + 1, rules=(rule, *one.rules))] if one else []
    return min(told, key=lambda one: one.price) if told else None


def _scales(evidence: Evidence, node: Expr) -> Iterator[tuple[float, Sequence[float]]]:
    """Yield what an answer is times where it is the scene's, by point, with a price."""
    points = evidence.points
    if not evidence.handles:
        yield 0.0, [1.0] * len(points)
    for handle in evidence.handles:
        each = [[moved(p, by, n) for p, by in zip(points, handle.steps, strict=True)] for n in (0, 1, 2)]
        rows = list(zip(*(at_points([node], some)[0] for some in each), strict=True))
        slopes, of = linear(rows), handle.parameter
        of_all = zip(rows, points, slopes, strict=True) if of and slopes else ()
        if slopes and not (of and all(abs(x - p[of] * a) <= CLOSE * abs(x) for (x, *_), p, a in of_all)):
            by = [b / a for a, b in zip(slopes, handle.right, strict=True)]
            price = 0.0 if all(abs(abs(x) - 1) < CLOSE for x in by) else SCALED
            yield price + UNTIED * (evidence.how == "rows"), by
    yield from ((SCALED, by) for by in evidence.common)


def surplus(evidence: Evidence, form: Form, node: Expr) -> int:
    """Return how many terms, as they are written, an answer is right without: one, or all of no term's values; or 0."""
    terms = np.array(at_points([x.express(node.graph) for x in written_out(form)], evidence.points))
    fine, half, found = [one for one in evidence.columns if one.form is not None], len(evidence.points) // 2, []
    for _, by in _scales(evidence, node) if np.isfinite(terms).all() else ():
        own = terms * np.array(by)
        lone = [row for row in own if all(_share(row, x.values, np.abs(row).max()) is None for x in fine)]
        rows = np.array([own.sum(axis=0) - np.array(evidence.right), *own, sum(lone, np.zeros_like(own[0]))])
        left, *some = rows[:, half:] - rows[:, :half] if evidence.free else rows
        most = np.abs(left).max()
        same = [most > CLOSE * np.abs(own).max() and np.abs(left - row).max() <= ALIKE * most for row in some]
        found += [n for n, held in ((1, any(same[:-1])), (len(lone), same[-1])) if held]
    return min(found, default=0)


def written_out(form: Form) -> list[Form]:
    """Return the terms of a formula as it is written, multiplied out; where these are too many as they are."""
    if isinstance(form, Sum):
        found = [x for one in form.terms for x in written_out(one)]
        return found if len(found) <= WRITTEN else [form]
    factors = [form.base] * form.exponent if isinstance(form, Power) and form.exponent > 1 else form.factors
    each = [written_out(x) for x in factors] if len(factors) > 1 else []
    return [Form.product(x) for x in product(*each)] if 1 < prod(map(len, each)) <= WRITTEN else [form]


def _search(evidence: Evidence, atoms: Atoms, mine: Sequence[float], deep: bool) -> Found | None:
    """Return the fewest columns that account for a difference; `deep`: one is lost or turned, another replaced."""
    e, columns = [a - b for a, b in zip(mine, evidence.right, strict=True)], evidence.every
    lone, size = len(evidence.columns), max(*map(abs, mine), *(abs(x) for one in columns for x in one.values))
    if not isfinite(size) or max(map(abs, e)) <= CLOSE * size:
        return None
    half = len(e) // 2

    def change(row: Sequence[float]) -> list[float]:
        return [row[half + k] - row[k] for k in range(half)] if evidence.free else list(row)

    values = [one.values for one in columns]
    rows, left = list(map(change, values)), change(e)
    angles = any(one.function for one in atoms.every)

    def states(k: int, c: float) -> tuple[str, ...]:
        square = angles and columns[k].kind.startswith("spring") and abs(c + 2) < ALIKE
        if square and any(abs(x + 2 * t) > CLOSE * size for x, t in zip(e, values[k], strict=True)):
            return ("trig",)  # sin² q for cos² q: all but turned, by a constant that is free
        return _states(columns[k], c)

    singles = [
        (_price(c) + 0.2 * (k >= lone), k, told)
        for k, row in enumerate(rows)
        if (c := _share(left, row, size)) is not None and (told := states(k, c))
    ]
    if singles:
        return _of_one(columns, [one for one in singles if one[1] < lone] or singles, evidence.tied)
    fine = [k for k, one in enumerate(columns[:lone]) if one.form is not None]
    some, alike = fine or range(lone), range(lone, len(columns))
    found = [
        Found(2 + p + 0.3 * (k >= lone), (k,), rules)
        for k in (*some, *alike)
        for p, rules in _replaced(columns[k], e, atoms)
    ]
    for j, k in combinations(some, 2) if len(some) <= PAIRED else ():  # the same in both
        both = replace(columns[k], values=tuple(a + b for a, b in zip(values[j], values[k], strict=True)))
        found += [Found(2.5 + p, (j, k), rules) for p, rules in _replaced(both, e, atoms)]
    for j, k, *shares in _shares(np.array(left), np.array(rows), size):
        at = list(zip((j, k), shares, strict=True))
        first, second = (_states(columns[n], c) for n, c in at)
        price = sum(_price(c) + 0.1 * (columns[n].form is None) + 0.2 * (n >= lone) for n, c in at)
        if first and second and not evidence.overlap(j, k, shares[0] * shares[1] < 0):
            found.append(Found(0.25 + price, (j, k), (*first, *second), all(_price(c) < FACTOR for _, c in at)))
    if not evidence.free:
        found += _extra(evidence, fine, e, size, atoms, deep)
    for j in () if found or evidence.tied or not deep or len(fine) > PAIRED else fine:
        for c in BOTH:
            rest = [x - c * t for x, t in zip(e, values[j], strict=True)]
            rules = _states(columns[j], c)
            for k in fine:
                by = _replaced(columns[k], rest, atoms) if k != j else ()
                found += [Found(3.5 + price, (j, k), (*rules, *told)) for price, told in by]
            if not evidence.free:
                more = _extra(evidence, fine, rest, size, atoms, deep)
                found += [Found(1.5 + one.price, (j,), (*rules, *one.rules)) for one in more]
    return min(found) if found else None


def _extra(
    evidence: Evidence, fine: Sequence[int], e: Sequence[float], size: float, atoms: Atoms, deep: bool
) -> list[Found]:
    """Return what is too much: a term of another equation, or a term of this one with another symbol in it."""
    told = [
        Found(2.0 + (price - 1) / 4, (), ("extra",))
        for one in evidence.beside
        if (c := _share(e, one.values, size)) is not None and (price := _price(c - 1))
    ]
    of = [*(evidence.columns[k] for k in fine), *(() if deep else evidence.beside)]
    return told or [Found(2.6 + price, (), ("extra",)) for one in of for price, rules in _times(one, e, atoms) if rules]


def _of_one(columns: Sequence[Column], singles: Sequence[tuple[float, int, tuple[str, ...]]], tied: bool) -> Found:
    """Return what one column tells that accounts for a difference: a term, and what one rule makes."""
    fine, whole = (sorted(x for x in singles if (columns[x[1]].form is None) == is_whole) for is_whole in (False, True))
    price = min(singles)[0]
    if tied:
        fine, whole = ([one for one in some if one[0] == price] for some in (fine, whole))
    if len(fine) > 1 and fine[0][0] == fine[1][0]:  # none is known to be the one
        fine = []
    rules = [rule for _, _, told in (*fine[:1], *whole[:1]) for rule in told] or ["termfactor"]
    special = [rule for rule in rules if rule not in ("term", "termgravity")]
    return Found(price, tuple(k for _, k, _ in fine[:1]), tuple(special or rules), True)


def _states(column: Column, c: float) -> tuple[str, ...]:
    """Return the rules that a column tells with a coefficient 1 + c."""
    plain = PLAIN if column.form is not None else ("", "", "")
    lost, turned, scaled = (own or other for own, other in zip(STATES[column.kind], plain, strict=True))
    turns = column.form is not None and any(isinstance(x, Pi) for x in column.form.walk())
    scaled += " power" * (turns and any(abs(1 + c - x) < CLOSE * x for x in ROUND))
    if abs(c + 2) < ALIKE:  # some say no sign
        told: tuple[str, ...] = (turned, "termsign" if turned in ("spring", "friction", "force") else "")
    else:
        alike = [STATES[kind][0] for kind in column.also]
        told = (lost, *alike) if abs(c + 1) < ALIKE else (turned, scaled) if c < -1 else (scaled,)
    return tuple(" ".join(told).split()) if turned or c > -1 - ALIKE else ()


def _price(c: float) -> float:
    """Return what a coefficient 1 + c costs: least if a term is lost, then if it is turned."""
    return 1.0 if abs(c + 1) < ALIKE else 1.1 if abs(c + 2) < ALIKE else FACTOR


def _share(e: Sequence[float], row: Sequence[float], size: float) -> float | None:
    """Return c of e = c row, None where that does not hold."""
    square = sum(x * x for x in row)
    if square <= (CLOSE * size) ** 2:
        return None
    c = sum(a * b for a, b in zip(e, row, strict=True)) / square
    return c if all(abs(a - c * b) <= CLOSE * size for a, b in zip(e, row, strict=True)) else None


def _shares(e: Array, rows: Array, size: float) -> list[tuple[int, int, float, float]]:
    """Return pairs of rows by number, with their shares in e, where these are all of it and the rows are not one."""
    j, k = np.triu_indices(len(rows), 1)
    squares, with_e = rows @ rows.T, rows @ e
    aa, ab, bb, ea, eb = squares[j, j], squares[j, k], squares[k, k], with_e[j], with_e[k]
    det = aa * bb - ab * ab
    with np.errstate(divide="ignore", invalid="ignore"):
        c, d = (ea * bb - eb * ab) / det, (eb * aa - ea * ab) / det
        off = np.abs(e - c[:, None] * rows[j] - d[:, None] * rows[k]).max(axis=1)
    held = np.flatnonzero((det > 1e-9 * aa * bb) & (off <= CLOSE * size))
    return [(int(j[n]), int(k[n]), float(c[n]), float(d[n])) for n in held]


def _replaced(column: Column, e: Sequence[float], atoms: Atoms) -> list[tuple[float, tuple[str, ...]]]:
    """Return what stands for something else in a term, t n a/b in place of t, with a price."""
    return _times(column, [x + d for x, d in zip(column.values, e, strict=True)], atoms)


def _times(column: Column, mine: Sequence[float], atoms: Atoms) -> list[tuple[float, tuple[str, ...]]]:
    """Return what a term is times where it is worth this: rules, with a price."""
    t = column.values
    if any(x == 0 or abs(y) <= 1e-9 * abs(x) for x, y in zip(t, mine, strict=True)):
        return []
    ratio = np.array([y / x for x, y in zip(t, mine, strict=True)])
    turned = STATES[column.kind][1] or "termsign"
    found = []
    quotients, slopes, k = atoms.quotients
    slope = ratio[0] / ratio[1]  # of all pairs most fail at the second point
    few = slice(*np.searchsorted(slopes, sorted((slope * (1 - 2 * CLOSE), slope * (1 + 2 * CLOSE)))))
    n = quotients[few] * ratio
    held = (np.abs(n - n[:, :1]) <= CLOSE * np.abs(n[:, :1])).all(axis=1) & np.isfinite(n).all(axis=1)
    k, n = k[few][held], n[held]
    for (a, b, both), by in zip((atoms.pairs[x] for x in k), map(float, n[:, 0]), strict=True):
        beside = [rule for rule, told in ((turned, by < 0), ("termfactor", abs(abs(by) - 1) > 1e-6)) if told]
        if len(beside) == 2:  # a chance
            continue
        price = 0.1 * bool(a.of and b.of) + 0.2 * len(beside) + 0.15 * bool(both)
        rules = _exchanged(a, b, both, column.squared)
        if rules == ("index",) and tuple(sorted((a.of, b.of))) in atoms.ratios:
            rules = ("ratio",)
        if column.form is None and rules == ("index",):  # the ratio of a condition, of several terms
            rules, beside = ("termfactor",), beside[: by < 0]
        found.append((price, (*rules, *beside)))
    return found


def _exchanged(a: Atom, b: Atom, both: int, squared: Sequence[str]) -> tuple[str, ...]:
    """Return the rules that tell a in place of b, or both too much or too little."""
    units = {a.unit, b.unit} - {"1", "rad", "rad^2"}
    if both or not (a.of and b.of):
        alone = a.function or b.function
        if alone and not both:
            return ("power",) if alone in squared or alone.endswith("^2") else ("trig",)
        return ("power", "dimension") if units else ("power",)
    if a.function == b.function != "":
        return ("absolute",)
    if a.function or b.function:
        return ("trig",) if (a.function and b.function) or not units else ("dimension",)
    return ("index",) if a.unit == b.unit else ("index", "dimension")


def _totals(course: Course, angles: Sequence[str]) -> list[dict[str, int]]:
    """Return sums of three angles and more: of a path of joints, with a parameter or without."""
    found: list[dict[str, int]] = []
    given = [x for x in angles if x not in course.scene.coordinates]
    for joint in course.scene.moving:
        path = [q for one in (joint, *course.ancestors(joint)) for q in one.coordinates if q in angles]
        for k in range(2, len(path) + 1):
            total = dict.fromkeys(path[:k], 1)
            found += [*([total] if k > 2 else []), *(total | {x: sign} for x in given for sign in (1, -1))]
    return found


def atoms_of(course: Course, motions: Motions) -> Atoms:
    """Return what factors of terms may be: parameters, rates, coordinates, their squares, sines and cosines.

    Where rows tie motions together a rate may be a multiple of another one, and a coordinate of a sine: none is known.
    """
    scene, units = course.scene, SceneUnits(course.scene)
    named = [(p.name, units.inferred.get(p.name, p.unit) or "1") for p in scene.parameters]
    moving = [
        *((name, f"{unit}/s") for name, unit in zip(scene.velocities, units.velocities, strict=True)),
        *zip(scene.coordinates, units.coordinates, strict=True),
        *((drive, unit) for _, drive, unit in units.each_drive()),
    ]
    angles = [name for name, unit in (*named, *zip(scene.coordinates, units.coordinates, strict=True)) if unit == "rad"]
    sums = [{x: 1} for x in angles] + [{x: 2} for x in angles]
    sums += [{a: 1, b: sign} for a, b in combinations(angles, 2) for sign in (1, -1)]
    sums += [x for x in _totals(course, angles) if x not in sums]
    found = [Atom("", "", "1", (1.0,) * len(motions.along))]
    for name, unit in named if scene.is_constrained else (*named, *moving):
        row = tuple(point[name] for point in motions.along)
        square = tuple(x * x for x in row)
        found += [Atom("", name, unit, row), Atom("", name, unit if unit == "1" else f"{unit}^2", square)]
    for function, of in (("sin", sin), ("cos", cos)):
        for angle in sums:
            row = tuple(of(sum(n * point[x] for x, n in angle.items())) for point in motions.along)
            name = " ".join(f"{x}{n}" for x, n in angle.items())
            found.append(Atom(function, name, "1", row))
            if list(angle.values()) == [1]:
                found.append(Atom(f"{function}^2", name, "1", tuple(x * x for x in row)))
    gears = (sorted(str(x.value) for x in {*one, *one.values()} if x.op is Op.SYMBOL) for _, one, _ in ratios(course))
    return Atoms(tuple(found), frozenset(tuple(names) for names in gears))
