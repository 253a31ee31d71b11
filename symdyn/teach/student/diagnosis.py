"""Which rule a wrong answer forgets: it is looked up by value among the mistakes of its quantity, then proved."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite

from symdyn.algebra import Form
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, substitute
from symdyn.scene import Scene
from symdyn.teach.student.course import Course
from symdyn.teach.student.mistakes import FREE, MOST, Mistake, mistakes
from symdyn.teach.student.points import NONE, SCALED, Points, points_of
from symdyn.unlocked import cached_property

CLOSE = 1e-9


class Diagnosis:
    """The mistakes of one scene, made when they are asked for; `others` are its multipliers, with their units."""

    def __init__(self, scene: Scene, others: Mapping[str, str] = NONE) -> None:
        self.scene, self.others = scene, others
        self.known: dict[str, list[Mistake]] = {}

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
        return points_of(self.scene, self.others)

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
        for one, row in zip(known, rows, strict=True):
            for first in (0, 2):
                pairs = list(zip(mine[first : first + 2], row[first : first + 2], strict=True))
                if pairs and all(_close(a, b) for a, b in pairs) and (free or equal(form, self._form(one.node, first))):
                    return one
        at = [0, SCALED]
        nodes = [form.express(self._graph), right.express(self._graph)]
        values, own = (list(row) for row in zip(*self.points.values(nodes, at), strict=True))
        return None if self.points.fits(values, own) else Mistake("dimension", nodes[0])

    def balance(self, i: int, form: Form) -> Mistake | None:
        """Return the mistake that an equation is, times any factor that is free of rates; None for none."""
        known = self.of(f"tau:{i + 1}")
        if self.course is None or not known:
            return None
        drive = self.drive(i)
        nodes = [form.express(self._graph), *(one.node - drive for one in known)]
        mine, *rows = (list(row) for row in zip(*self.points.values(nodes, self.points.pairs), strict=True))
        for one, row in zip(known, rows, strict=True):
            for first in (0, 4):
                held = [
                    mine[j] * row[j] != 0 and _close(mine[j] * row[j + 1], mine[j + 1] * row[j])
                    for j in (first, first + 2)
                    if j < len(mine)
                ]
                if held and all(held):
                    return one
        return None

    def drive(self, i: int) -> Expr:
        """Return what drives a joint, zero for none."""
        assert self.course is not None, "mistakes are those of a course"
        name, graph = self.scene.drives[i], self.course.graph
        return graph.symbol(name) if name else graph.zero

    @property
    def _graph(self) -> Graph:
        assert self.course is not None, "mistakes are those of a course"
        return self.course.graph

    def _form(self, node: Expr, bound: int) -> Form:
        """Return a node as a form, with the scene's numbers of parameters or without."""
        if bound:
            graph = node.graph
            values = {
                graph.symbol(p.name): p.value.express(graph) for p in self.scene.parameters if p.value is not None
            }
            node = substitute([node], values)[0]
        return Form.of(node)


def _close(a: float, b: float) -> bool:
    return isfinite(a) and isfinite(b) and abs(a - b) <= CLOSE * max(abs(a), abs(b), 1e-12)
