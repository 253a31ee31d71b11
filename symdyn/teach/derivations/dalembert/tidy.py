"""A formula in the order in which a book writes it, whatever order its ring has.

m h cos q q̈        numbers, parameters as the scene declares them, sines, then rates and accelerations
sin(φ - χ)          in every angle the scene's first coordinate is positive: not -sin(χ - φ) beside cos(φ - χ)
r cos φ - x         a sum that would begin with a minus has its other terms first
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from symdyn.algebra import Form, Function, Number, Power, Product, Sum
from symdyn.graph import Op
from symdyn.scene import Scene
from symdyn.scene.values import acceleration_name

CIRCULAR = (Op.SIN, Op.COS)


@dataclass(frozen=True)
class Order:
    """Places of a scene's symbols in a product and in an angle."""

    place: dict[str, int]
    moving: frozenset[str]

    def __call__(self, form: Form) -> Form:
        """Return the same formula in this order."""
        if isinstance(form, Function):
            return self._angle(form.with_parts(map(self, form.parts)))
        parts = [self(part) for part in form.parts]
        if isinstance(form, Power):
            sign, base = parts[0].split_sign()
            turned = base.power(form.exponent)
            return Form.product((Number.MINUS_ONE, turned)) if sign < 0 and form.exponent % 2 else turned
        if isinstance(form, Product):
            return self._product(Form.product(parts))
        if isinstance(form, Sum):
            return _signed(list(Form.sum(parts).terms))
        return form.with_parts(parts)

    def _product(self, form: Form) -> Form:
        if not isinstance(form, Product):
            return form
        return Form.product(sorted(form.factors, key=self._of_factor))

    def _of_factor(self, factor: Form) -> tuple[int, int]:
        used = factor.symbols
        kind = 3 if self.moving.intersection(used) else 2 if _has_function(factor) else 0 if used else -1
        last = len(self.place)
        return kind, self.place.get(used[0], last) if kind == 0 else 0

    def _angle(self, form: Form) -> Form:
        """Return a sine or cosine with the terms of its angle in order."""
        if not isinstance(form, Function) or form.op not in CIRCULAR:
            return form
        last = len(self.place)
        terms = sorted(
            form.args[0].terms,
            key=lambda term: min((self.place.get(x, last) for x in term.symbols), default=-1),
        )
        leading = next((term for term in terms if term.symbols), None)
        if leading is None or leading.split_sign()[0] > 0:
            return Function(form.op, (Form.sum(terms),)) if terms else form
        turned = Function(form.op, (Form.sum(Form.product((Number.MINUS_ONE, term)) for term in terms),))
        return turned if form.op is Op.COS else Form.product((Number.MINUS_ONE, turned))


def order_of(scene: Scene) -> Callable[[Form], Form]:
    """Return what puts formulas of a scene in order."""
    rates = [*scene.velocities, *map(acceleration_name, scene.velocities)]
    names: Sequence[str] = [*(one.name for one in scene.parameters), *scene.coordinates, *rates]
    return Order({name: k for k, name in enumerate(names)}, frozenset(rates))


def _has_function(form: Form) -> bool:
    return isinstance(form, Function) or any(map(_has_function, form.parts))


def _signed(terms: list[Form]) -> Form:
    """Return a sum that begins without a minus where it can: then those with one stand behind the others."""
    if terms[0].split_sign()[0] > 0:
        return Form.sum(terms)
    return Form.sum(sorted(terms, key=lambda term: term.split_sign()[0] < 0))
