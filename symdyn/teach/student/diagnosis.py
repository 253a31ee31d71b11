"""Which rule a wrong answer forgets: it is found by value among the mistakes of its quantity, then proved.

Points at which answers are compared by value are the same in every run and in both checkers:

    0 … 5      drawn       6 … 9      constants of 0 … 3 at another position
    10 … 12    those of 0 … 2, parameters and position, with other rates, accelerations and drives
    13         the first, with lengths, masses and times in other units, where the scene says its units
    14 … 17    parameters as declared: with all else of 0, 1, 10 and 11; only where the scene has such
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import isfinite
from types import MappingProxyType

import numpy as np

from symdyn.algebra import Form
from symdyn.dynamics.mechanism import TIME, prescribed
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, reachable, substitute
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Unit, UnitError, acceleration_name
from symdyn.teach.student.course import Course
from symdyn.teach.student.evidence import Evidence, common, evidence_of
from symdyn.teach.student.grammar import Names
from symdyn.teach.student.mistakes import (
    ALL_OF_IT,
    FREE,
    KEPT,
    MOST,
    OF_RATES,
    SUITS,
    SWAPPED,
    VAGUE,
    Mistake,
    mistakes,
)
from symdyn.teach.student.motions import Motions, at_points, constants, in_reach, motions_of, numbers
from symdyn.teach.student.parts import Atoms, atoms_of, explained, surplus
from symdyn.unlocked import cached_property

DRAWN, TWINS, MOVERS = 6, 4, 3
SCALED = DRAWN + TWINS + MOVERS
BOUND = SCALED + 1
SCALES = (1.7, 1.3, 0.6)
"""How much larger numbers of kg, m and s become."""
STEP, TELLS = 1e-3, 1e-5
"""How far a parameter is moved, and what part of that a value moves by at least, if it tells that one is there."""
NONE: Mapping[str, str] = MappingProxyType({})
Signs = Mapping[str, Sequence[int]]


@dataclass(frozen=True)
class Points:
    """Values of every symbol of a scene, point by point."""

    at: tuple[Mapping[str, float], ...]
    scaled: bool

    def near(self, one: Expr, other: Expr, enough: float) -> bool:
        """Whether a value is another one to a part of that, for the parameters of the scene."""
        rows = self.values([one, other])[BOUND:]
        return bool(rows) and all(abs(mine - x) <= enough * abs(x) for mine, x in rows)

    def marks(self, free: bool = False) -> list[int]:
        """Return the points that mark a value, two and two; where it goes to and from, if a constant is free."""
        return [DRAWN, 0, DRAWN + 1, 1] if free else [0, 1, *range(BOUND, len(self.at))[:2]]

    @property
    def pairs(self) -> list[int]:
        """Return the points that mark what vanishes, times a factor that is free of rates: two and two."""
        first = DRAWN + TWINS
        bound = BOUND
        return [0, first, 1, first + 1, *([bound, bound + 2, bound + 1, bound + 3] if len(self.at) > bound else [])]

    def marked(self, nodes: Sequence[Expr], free: bool = False) -> list[list[float]]:
        """Return what marks each of some nodes."""
        columns = [list(row) for row in zip(*self.values(nodes, self.marks(free)), strict=True)]
        return [[x[0] - x[1], x[2] - x[3]] if free else x for x in columns]

    def united(self, right: Sequence[float]) -> bool:
        """Whether a value has a unit that can be found, from the first point and the scaled one."""
        return self.scaled and 0 not in right and _is_product(right[1] / right[0])

    def fits(self, mine: Sequence[float], right: Sequence[float]) -> bool:
        """Whether a value changes as the right one when units do, or none can tell."""
        off = abs(mine[1] * right[0] - right[1] * mine[0])
        return not self.united(right) or not off > 1e-7 * abs(right[1] * mine[0])  # nan: a symbol of no known unit

    def values(self, nodes: Sequence[Expr], at: Sequence[int] | None = None) -> list[list[float]]:
        """Return the values of nodes, point by point; nan where there is none."""
        points = self.at if at is None else [self.at[k] for k in at]
        return list(map(list, zip(*at_points(nodes, points), strict=True)))


def _is_product(ratio: float) -> bool:
    """Whether a number is a product of small powers of the scales: what has a unit is."""
    span = range(-4, 5)
    return any(abs(_scale((a, b, c)) / ratio - 1) < 1e-9 for a in span for b in span for c in span)


def points_of(scene: Scene, others: Mapping[str, str] = NONE, senses: Sequence[int] = (1,)) -> Points:
    """Return the points of a scene: `others` are symbols beside it, with their units, `senses` the signs of rates."""
    signs = dict.fromkeys(scene.velocities, senses)
    names = Names(scene, tuple(others))
    every = [name for name in dict.fromkeys(names.symbols.values()) if name not in names.formulas]
    resting = {*(p.name for p in scene.parameters), *scene.coordinates}
    drawn = [in_reach(scene, {name: _drawn(name, k, signs) for name in every}) for k in range(DRAWN)]
    twins = [in_reach(scene, _mixed(point, k, constants(scene), signs)) for k, point in enumerate(drawn[:TWINS])]
    movers = [_mixed(point, k, resting, signs) for k, point in enumerate(drawn[:MOVERS])]
    values = {p.name: p.value.known_at({}) for p in scene.parameters if p.value is not None and p.name in every}
    bound = {name: float(value) for name, value in values.items() if value is not None}
    scales = _scales(scene, others)
    declared = [{**point, **bound} for point in (*drawn[:2], *movers[:2])] if bound else []
    given = prescribed(scene, Graph())
    rates = (scene.coordinates, scene.velocities, tuple(map(acceleration_name, scene.velocities)))
    moved = [one[k] for one in rates for k in given.place], [*given.position, *given.velocity, *given.acceleration]

    def moving(point: Mapping[str, float]) -> dict[str, float]:
        return {**point, **dict(zip(moved[0], numbers(moved[1], point), strict=True))}

    others_at = [moving(point) for point in (*drawn, *twins, *movers)]
    scaled = {name: value * scales.get(name, 1.0) for name, value in others_at[0].items()}
    return Points((*others_at, scaled, *map(moving, declared)), bool(scales))


def _scales(scene: Scene, others: Mapping[str, str]) -> dict[str, float]:
    """Return what the value of each symbol is times in other units; none if a unit is not known, nan for one without.

    The unit of a multiplier is not known where the row is the user's: what it stands in has no unit that can be found.
    """
    found: dict[str, float] = {}
    units, second = SceneUnits(scene), SCALES[2]
    told = units.inferred
    for parameter in scene.parameters:
        powers = powers_of(told[parameter.name])
        if powers is None:
            return {}
        found[parameter.name] = _scale(powers)
    for velocity, unit in zip(scene.velocities, units.velocities, strict=True):
        found[velocity] = _scale(powers_of(unit)) / second
        found[acceleration_name(velocity)] = found[velocity] / second
    for coordinate, unit in zip(scene.coordinates, units.coordinates, strict=True):
        found[coordinate] = _scale(powers_of(unit))
    for _, drive, unit in units.each_drive():
        found[drive] = _scale(powers_of(unit))
    found[TIME] = second
    return found | {name: _scale(powers_of(unit)) if unit else float("nan") for name, unit in others.items()}


def _scale(powers: Sequence[int] | None) -> float:
    kg, m, s = powers or (0, 0, 0)
    return float(SCALES[0] ** kg * SCALES[1] ** m * SCALES[2] ** s)


def powers_of(unit: str) -> tuple[int, int, int] | None:
    """Return the powers of kg, m and s in a unit such as "N m s/rad", None where it is not of these alone."""
    try:
        kg, m, s, *others = Unit.read(unit).dimension.exponents
    except UnitError:
        return None
    return None if any(others) else (int(kg), int(m), int(s))


def _mixed(point: Mapping[str, float], k: int, kept: set[str], signs: Signs) -> dict[str, float]:
    """Return a point with other values of all but those that are kept."""
    return {name: value if name in kept else _drawn(name, DRAWN + k, signs) for name, value in point.items()}


def _drawn(name: str, k: int, signs: Signs) -> float:
    """Return the value of a symbol at a point: between 1/4 and 2, times one of its signs if it has such."""
    rng = random.Random(f"{k}:{name}")
    return round(rng.uniform(0.25, 2.0), 6) * rng.choice(signs.get(name, (1,)))


CLOSE = 1e-9


class Diagnosis:
    """The mistakes of one scene, made when they are asked for; `others` are its multipliers, with their units."""

    def __init__(self, scene: Scene, others: Mapping[str, str] = NONE) -> None:
        self.scene, self.others = scene, others
        self.known: dict[str, list[Mistake]] = {}
        self.apart: dict[str, list[Evidence]] = {}

    @cached_property
    def course(self) -> Course | None:
        """Return the course of the scene, None where there is none."""
        try:
            return Course(self.scene)
        except DerivationError:
            return None

    @cached_property
    def points(self) -> Points:
        """Return the points of the scene."""
        return points_of(self.scene, self.others, self.motions.senses if self.motions else (1,))

    @cached_property
    def motions(self) -> Motions | None:
        """Return the points on the motions of the scene, None where none are drawn."""
        return motions_of(self.scene, self.course)

    def of(self, key: str, right: Form | None = None, most: int = MOST) -> list[Mistake]:
        """Return the mistakes of a quantity, at most so many; `right` is it where the course does not say."""
        if self.course is None:
            return []
        if key not in self.known:
            node = self.course.value(key, self.course.right)
            if node is None and right is not None:
                node = right.express(self.course.graph)
            self.known[key] = [] if node is None else mistakes(self.course, key, node, most)
        return self.known[key]

    def value(self, key: str, form: Form, right: Form, equal: Callable[[Form, Form], bool]) -> Mistake | None:
        """Return the mistake that a wrong value of a quantity is, None for none."""
        known = self.of(key, right)
        if not known:
            return None
        free = key.startswith(FREE)
        mine, *rows = self.points.marked([form.express(self._graph), *(one.node for one in known)], free)
        by_value = free or bool(prescribed(self.scene, self._graph).place)  # a prescribed motion may be put in
        of = None if key.startswith("tau:") else right
        lettered = bool(self.letters(key, of)) and self.seen(key, of) <= set(form.symbols)
        for one, row in zip(known, rows, strict=True):
            for first in (0,) if lettered else (0, 2):  # what is wrong in letters is not excused by numbers
                pairs = list(zip(mine[first : first + 2], row[first : first + 2], strict=True))
                held = bool(pairs) and all(_close(a, b) for a, b in pairs)
                if held and (by_value or equal(form, self._form(one.node, form if first else None))):
                    return one
        nodes = [form.express(self._graph), right.express(self._graph)]
        values, own = (list(row) for row in zip(*self.points.values(nodes, [0, SCALED]), strict=True))
        fits = key.startswith("tau:") or self.points.fits(values, own)  # terms of equations: see `mixed`
        return None if fits else Mistake("dimension", nodes[0])

    def number(self, key: str, right: Form, typed: Expr, enough: float) -> str:
        """Return the rule that a wrong answer forgets where a number is one, right to a part of itself; "" for none."""
        if not any(x.op is Op.SYMBOL for x in reachable([typed])):
            return next((one.rule for one in self.of(key, right) if self.points.near(typed, one.node, enough)), "")
        found = self.value(key, Form.of(typed), right, lambda *_: True)
        return found.rule if found else ""

    def balance(self, i: int, form: Form) -> Mistake | None:
        """Return the mistake that an equation is, times any factor that is free of rates; None for none."""
        known = self.of(f"tau:{i + 1}")
        if self.course is None or not known:
            return None
        drive = self.drive(i)
        nodes = [form.express(self._graph), *(one.node - drive for one in known)]
        mine, *rows = (list(row) for row in zip(*self.points.values(nodes, self.points.pairs), strict=True))
        lettered = self.seen(f"tau:{i + 1}") <= set(form.symbols)  # what is wrong in letters is not excused by numbers
        for first in (0,) if lettered else (0, 4):
            for one, row in zip(known, rows, strict=True):
                if _alike(mine, row, first):
                    return one
        return None

    def mixed(self, i: int, form: Form) -> Mistake | None:
        """Return the mistake of an equation whose terms differ in units, or in the law of friction alone; else None.

        What has numbers of the scene in place of its parameters has no units that can be told.
        """
        node = form.express(Graph())
        if self.has_unit(i) and self.named(i) <= set(form.symbols):
            (first,), (other,) = self.points.values([node], [0, SCALED])
            if isfinite(other) and first * other != 0 and not self.points.united([first, other]):
                return Mistake("dimension", node)
        names, left = self.law(i) if self.evidence(f"tau:{i + 1}") else ([], [])
        return Mistake("law", node) if names and _alike(self._without(names, node), left, 0) else None

    def law(self, i: int) -> tuple[list[str], list[float]]:
        """Return the coefficients of friction, and an equation without it at four of `pairs`; none if none."""
        if self.course is None or self.scene.is_constrained or self.course.beside["friction"][i].is_zero:
            return [], []
        e, beside, total = self.course.right, self.course.beside, self._graph.total
        given = [x + y - z for x, y, z in zip(beside["force"], e.Q, self.course.loads, strict=True)]
        left = self.course.balance(i, total(e.K.values()), total(e.P.values()), given) - self.drive(i)
        own, whole, acts = set(reachable(beside["friction"])), self._without([], left), beside["friction"][i]
        every = [p.name for p in self.scene.parameters if self._graph.symbol(p.name) in own]
        every = [x for x in every if all(map(_close, self._without([x], left), whole))]
        names = [x for x in every if all(map(isfinite, self._without([x], acts)))]
        return (names, whole) if max(map(abs, self._without(names, acts))) <= CLOSE else ([], [])

    def _without(self, names: Sequence[str], node: Expr) -> list[float]:
        """Return the values of a node with some parameters zero, at four of `pairs`."""
        points = [{**self.points.at[k], **dict.fromkeys(names, 0.0)} for k in self.points.pairs[:4]]
        return at_points([node], points)[0]

    def has_unit(self, i: int) -> bool:
        """Whether the equation of a joint has a unit that can be found: it has none where gravity is a number."""
        node = None if self.course is None else self.course.value(f"tau:{i + 1}", self.course.right)
        return node is not None and self.points.united([x for (x,) in self.points.values([node], [0, SCALED])])

    def named(self, i: int) -> set[str]:
        """Return the parameters that the equation of a joint has, but those that all of it can be divided by."""
        assert self.course is not None, "equations are those of a course"
        node = self.course.value(f"tau:{i + 1}", self.course.right)
        held = {str(x.value) for x in reachable([node]) if x.op is Op.SYMBOL} if node is not None else set()
        held &= {p.name for p in self.scene.parameters}
        with suppress(DerivationError):
            return held if self.scene.drives[i] or node is None else held - set(common(self.course.terms(node), held))
        return held

    def moving(self, letters: set[str], forms: Sequence[Form]) -> Motions | None:
        """Return the motions that formulas are compared on: with the scene's values where a letter is left out."""
        known, said = self.motions, {name for form in forms for name in form.symbols}
        if known is None or not letters or not letters <= said:
            return known
        return replace(known, groups=known.groups[:1])  # l for l² is not right where l is 1 m

    def letters(self, key: str, right: Form | None = None) -> set[str]:
        """Return the parameters of a result; of an equation where units of its terms can be told."""
        if right is not None:
            return {p.name for p in self.scene.parameters} & set(right.symbols)
        told = self.course is not None and self.points.scaled
        return self.named(int(key.partition(":")[2]) - 1) if told else set()

    def seen(self, key: str, right: Form | None = None) -> set[str]:
        """Return those of `letters` that tell where parameters have the scene's values: 1e-9 beside 1 does not."""
        letters, group = self.letters(key, right), self.motions.groups[-1] if self.motions else None
        if self.course is None or group is None or not group.declared:
            return letters
        left = key.replace("solved:", "tau:")
        node = self.course.value(left, self.course.right) if right is None else right.express(Graph())
        if node is None:
            return letters
        # without a drive an equation is zero on the motions
        broken = group.on if right is not None else group.off[int(key.partition(":")[2]) - 1]
        (values,), (whole,) = (np.array(at_points([node], points)) for points in (group.on, broken))
        moved = {x: np.array(at_points([node], [{**p, x: p[x] * (1 + STEP)} for p in group.on])[0]) for x in letters}
        size = STEP * TELLS * np.abs(whole).max()
        return {x for x, row in moved.items() if not np.abs(row - values).max() <= size}

    def evidence(self, key: str) -> list[Evidence]:
        """Return what tells the terms of a quantity apart, in each way to write it; none where nothing does."""
        if key not in self.apart:
            known = self.course is not None and self.motions is not None
            self.apart[key] = evidence_of(self.course, self.motions, key) if known else []  # type: ignore[arg-type]
        return self.apart[key]

    @cached_property
    def atoms(self) -> Atoms:
        """Return what factors of a term may be."""
        assert self.course is not None, "terms are those of a course"
        assert self.motions is not None, "terms are told apart on motions"
        return atoms_of(self.course, self.motions)

    def told_apart(self, key: str, form: Form, found: Mistake | None) -> Mistake | None:
        """Return what terms of a wrong answer tell, with the mistake that was found if it suits; else that mistake."""
        every, names = self.evidence(key), set(form.symbols)
        if key.startswith(FREE) and names and names <= {p.name for p in self.scene.parameters}:
            return None  # a constant, which is free: nothing is known of what its writer forgot
        if not every:
            return found
        node = form.express(self._graph)
        tied = bool(set(form.symbols) & set(self.others))
        free = () if found and found.rule in KEPT else every
        over = [surplus(one, form, node) for one in free if (one.how == "rows") == tied]
        if found and found.rule in ALL_OF_IT and 1 not in over:
            return found
        ways = [
            (one, told)
            for one in every
            if (one.how == "rows" or not tied) and (told := explained(one, self.atoms, node))
            if tied or one.how != "rows" or (told.sure and "untied" in told.rules)
        ]
        loose = any(one.how == "rows" and not tied for one, _ in ways)
        evidence, told = min(ways, key=lambda way: way[1].price, default=(every[0], None))
        if 1 in over and not (told and told.sure and set(KEPT) & set(told.rules)):
            return Mistake("extra", node, more=("dimension",) if found and found.rule == "dimension" else ())
        unlike = found is not None and told is not None and not told.sure and found.rule not in told.rules
        swapped = told is not None and told.rules in SWAPPED and found is not None and found.rule == "index"
        if told is None or (unlike and "absolute" not in told.rules and not swapped):
            return found or (Mistake("extra", node) if any(over) else None)
        if found and found.rule in OF_RATES and told.rules == ("relative",):  # rates that are lost turn nothing
            return found
        rules = list(dict.fromkeys((*told.rules, *(["untied"] if loose and told.sure else []))))
        kinds = [evidence.every[k].kind for k in told.terms]
        suits = set(rules) <= {*VAGUE, "coupling"} and any(found and found.rule in SUITS.get(x, ()) for x in kinds)
        if found and (unlike or suits) and (found.rule, rules) != ("cross", ["termsign"]):  # a sign is all
            rules.insert(0, found.rule)
        if found and found.rule == rules[0] and "prescribed" not in rules:  # with its mass
            return replace(found, more=tuple(x for x in rules[1:] if x != found.other))
        return Mistake(rules[0], node, more=tuple(rules[1:]))

    def drive(self, i: int) -> Expr:
        """Return what drives a joint, zero for none."""
        assert self.course is not None, "mistakes are those of a course"
        name, graph = self.scene.drives[i], self.course.graph
        return graph.symbol(name) if name else graph.zero

    @property
    def _graph(self) -> Graph:
        assert self.course is not None, "mistakes are those of a course"
        return self.course.graph

    def _form(self, node: Expr, typed: Form | None) -> Form:
        """Return a node as a form; with numbers for those parameters that `typed`, if it is given, leaves out."""
        graph, letters = node.graph, typed.symbols if typed else ()
        known = (p for p in self.scene.parameters if typed and p.value is not None and p.name not in letters)
        return Form.of(substitute([node], {graph.symbol(p.name): p.value.express(graph) for p in known})[0])  # type: ignore[union-attr]


def _alike(mine: Sequence[float], right: Sequence[float], first: int) -> bool:
    """Whether what vanishes is another one times a factor, by its values at `pairs` from that one on."""
    at = [j for j in (first, first + 2) if j < len(mine)]
    held = (mine[j] * right[j] != 0 and _close(mine[j] * right[j + 1], mine[j + 1] * right[j]) for j in at)
    return bool(at) and all(held)


def _close(a: float, b: float) -> bool:
    return isfinite(a) and isfinite(b) and abs(a - b) <= CLOSE * max(abs(a), abs(b), 1e-12)
