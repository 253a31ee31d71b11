"""What students get when they forget a rule: typical wrong results, each with the rule, from the scene's own equations.

Three tables make them: energies of a course in which one part of one mass (or of all) is treated wrongly, steps from
energies to equations of which one is left out, and terms of the right formula that are lost, turned or misread. Both
checkers look a wrong answer up among them: the shell exactly, the page by values.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

from symdyn.algebra import Floats
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.teach.student.course import Course
from symdyn.teach.student.wrong_energies import wrong_energies
from symdyn.teach.student.wrong_steps import divided, wrong_steps
from symdyn.teach.student.wrong_terms import wrong_terms

RULES = (
    "half", "steiner", "inertia", "arm", "cross", "carried", "relative", "absolute", "height", "trig", "gravity",
    "weightless", "energies", "index", "product", "slope", "chain", "convention", "friction", "coupling", "body",
    "factor", "variable", "undifferentiated", "undivided", "squared", "clockwise", "velocities", "spring", "turned",
    "term", "termsign", "termfactor", "direction", "dimension", "nothing", "multiplier",
)  # fmt: skip
"""Rules by name; what each says stands in the languages' table of answers under `mistake.` and the name."""

VAGUE = ("term", "termsign", "termfactor", "turned")
"""Rules that say less than another one of the same result."""

FREE = ("P:", "L:")
"""What keys of quantities begin with that hold a constant which is free."""

MOST = 600
"""Wrong results of one quantity."""


@dataclass(frozen=True)
class Mistake:
    """A wrong result and the rule of RULES that was forgotten on the way.

    Attributes:
        rule: which.
        node: its value.
        of: the mass that it was forgotten for, "" for no single one.
        other: another rule that gives the same when it is forgotten, "" for none.
    """

    rule: str
    node: Expr
    of: str = ""
    other: str = ""


def mistakes(course: Course, key: str, right: Expr | None = None, most: int = MOST) -> list[Mistake]:
    """Return the typical wrong results of a quantity, no two of the same value, none of the right one.

    Args:
        course: of the scene.
        key: of the quantity, as documents have it.
        right: its value, on the graph of the course; None asks the course.
        most: how many, the likely ones first.
    """
    right = course.value(key, course.right) if right is None else right
    if right is None:
        return []
    probe = _Probe(course)
    free = key.startswith(FREE)
    own = probe(right, free)
    found: dict[tuple[float, ...], Mistake] = {}
    for mistake in islice(_all(course, key, right), 2 * most):  # many of them give the same
        mark = probe(mistake.node, free)
        if mark is None or mark == own:
            continue
        first = found.get(mark)
        if first is None:
            found[mark] = mistake
            if len(found) == most:
                break
        elif not first.other and mistake.rule not in (first.rule, *VAGUE):
            found[mark] = replace(first, other=mistake.rule)
    return list(found.values())


class _Probe:
    """Values at two points as a mark, of what is free by a constant its changes; None where there is none."""

    def __init__(self, course: Course) -> None:
        self.points: tuple[dict[str, float], ...] = ({}, {}, {}, {})
        self.fixed = {p.name for p in course.scene.parameters}

    def __call__(self, node: Expr, free: bool = False) -> tuple[float, ...] | None:
        symbols = [x for x in reachable([node]) if x.op is Op.SYMBOL]
        values = []
        for k, point in enumerate(self.points if free else self.points[:2]):
            for x in symbols:
                name = str(x.value)
                seed = f"{k % 2 if name in self.fixed else k}:{name}:mistakes"
                point.setdefault(name, random.Random(seed).uniform(0.25, 2.0))
            try:
                values.append(evaluate([node], Floats(), {x: point[str(x.value)] for x in symbols})[0])
            except (ArithmeticError, ValueError):
                return None
        marks = [values[k + 2] - values[k] for k in range(2)] if free else values
        return tuple(float(f"{value:.9g}") + 0.0 for value in marks)


def _all(course: Course, key: str, right: Expr) -> Iterator[Mistake]:
    if course.value(key, course.right) is not None:
        for rule, node in wrong_steps(course, key):
            yield Mistake(rule, node)
        for rule, of, energies in wrong_energies(course):
            if (value := course.value(key, energies)) is not None:
                yield Mistake(rule, value, of)
        for rule, node in divided(course, key):
            yield Mistake(rule, node)
    for rule, node in wrong_terms(course, key, right):
        yield Mistake(rule, node)
