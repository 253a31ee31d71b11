"""Quantities as text that a formula reader takes back: `parse(spell(x)) == x` for whatever `parse` returned."""

from __future__ import annotations

from fractions import Fraction
from numbers import Rational

from symdyn.graph import Op
from symdyn.scene.values.quantity import Quantity

_SUM, _PRODUCT, _SIGN, _POWER, _ATOM = range(5)


def spell(quantity: Quantity | Rational) -> str:
    """Return a formula as text, with no bracket too many.

    A number is a decimal where that is exact and short, else p/q.

    >>> from symdyn.scene import parse
    >>> spell(parse("0.5*(pi) + 1/3 - (a*(b))"))
    'pi/2 + 1/3 - a*b'
    """
    return _spell(quantity)[0] if isinstance(quantity, Quantity) else _decimal(Fraction(quantity))


def _decimal(value: Fraction) -> str:
    """Return a decimal where it is exact and short, else p/q."""
    digits = next((k for k in range(20) if 10**k % value.denominator == 0), None)
    if digits is None:
        return str(value)
    text = str(abs(value.numerator) * 10**digits // value.denominator).rjust(digits + 1, "0")
    text = f"{text[:-digits]}.{text[-digits:]}" if digits else text
    return f"-{text}" if value < 0 else text


def _spell(q: Quantity) -> tuple[str, int]:
    if isinstance(q.value, Fraction):
        text = _decimal(q.value)
        return text, _PRODUCT if "/" in text else _SIGN if q.value < 0 else _ATOM
    if q.op is Op.SYMBOL:
        return str(q.value), _ATOM
    if q.op is Op.PI:
        return "pi", _ATOM
    if q.op is Op.NEG:
        return f"-{_at_least(q.args[0], _PRODUCT)}", _SIGN
    if q.op in (Op.ADD, Op.SUB):
        left, right = _at_least(q.args[0], _SUM), _at_least(q.args[1], _PRODUCT)
        return f"{left} {'+' if q.op is Op.ADD else '-'} {right}", _SUM
    if q.op is Op.MUL:
        return _product(q.args[0], q.args[1])
    if q.op is Op.DIV:
        return f"{_at_least(q.args[0], _PRODUCT)}/{_at_least(q.args[1], _POWER)}", _PRODUCT
    return f"{q.op.name.lower()}({', '.join(spell(arg) for arg in q.args)})", _ATOM


def _product(a: Quantity, b: Quantity) -> tuple[str, int]:
    factor = a.value
    if a == b:
        return f"{_at_least(a, _ATOM)}**2", _POWER
    if not isinstance(factor, Fraction):
        return f"{_at_least(a, _PRODUCT)}*{_at_least(b, _POWER)}", _PRODUCT
    rest = _at_least(b, _PRODUCT)
    if "/" not in _decimal(factor) and factor.denominator not in (2, 4, 8):
        return f"{_decimal(factor)}*{rest}", _PRODUCT
    front = {1: "", -1: "-"}.get(factor.numerator, f"{factor.numerator}*")
    return f"{front}{rest}/{factor.denominator}", _PRODUCT


def _at_least(q: Quantity, level: int) -> str:
    text, own = _spell(q)
    return text if own >= level else f"({text})"
