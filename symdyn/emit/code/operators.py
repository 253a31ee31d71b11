"""How an operation is written in a language with infix operators, and a printer that gets the parentheses right.

A spelling says how tightly its result binds and how tightly each operand must bind to stand there bare. Right operands
of + and * must bind tighter than the operator itself, so the text is evaluated in the order of the graph.

In the text of a line stand names of values, and operations that have no name of their own. Graphs are written as Python
for SymPy here, whose import takes longer than writing a lesson.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction

from symdyn.algebra import NAMES
from symdyn.graph import Expr, Op

ANY, SUM, PRODUCT, SIGN, ATOM = range(5)


@dataclass(frozen=True)
class Spelling:
    """One row of a target's table.

    Attributes:
        pattern: text with {} for each operand; for a leaf, for its name or its digits.
        binds: how tightly the result binds.
        wants: least binding of each operand.
    """

    pattern: str
    binds: int = ATOM
    wants: tuple[int, ...] = ()


def call(name: str, operands: int = 1) -> Spelling:
    """Return the spelling of a function call."""
    return Spelling(f"{name}({', '.join(['{}'] * operands)})", ATOM, (ANY,) * operands)


LEAF = Spelling("{}")

OPERATORS: Mapping[Op, Spelling] = {
    Op.CONSTANT: LEAF,
    Op.PI: LEAF,
    Op.SYMBOL: LEAF,
    Op.ADD: Spelling("{} + {}", SUM, (SUM, PRODUCT)),
    Op.SUB: Spelling("{} - {}", SUM, (SUM, PRODUCT)),
    Op.MUL: Spelling("{} * {}", PRODUCT, (PRODUCT, SIGN)),
    Op.DIV: Spelling("{} / {}", PRODUCT, (PRODUCT, SIGN)),
    Op.NEG: Spelling("-{}", SIGN, (ATOM,)),
}
"""What C, Python and most other languages write alike; `--x` never appears, since a sign wants an atom."""


@dataclass(frozen=True)
class Printer:
    """Writes nodes in one language.

    Attributes:
        spellings: a row for every `Op`.
        literal: how a constant is written.
    """

    spellings: Mapping[Op, Spelling]
    literal: Callable[[Fraction], str]

    def code(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> str:
        """Return `node` as text: its name if it has one, else written out down to names and constants."""
        return self._bound(node, names, constants)[0]

    def definition(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> str:
        """Return the right-hand side of the line that gives `node` its name."""
        return self._written(node, names, constants)[0]

    def _bound(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        """Return the text of `node` and how tightly it binds."""
        if node in names:
            return self.spellings[Op.SYMBOL].pattern.format(names[node]), ATOM
        if node in constants:
            digits = self.literal(constants[node])
            return self.spellings[Op.CONSTANT].pattern.format(digits), SIGN if digits.startswith("-") else ATOM
        return self._written(node, names, constants)

    def _written(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        """Return the operation of `node` with its operands, and how tightly it binds."""
        spelling = self.spellings[node.op]
        operands = []
        for arg, wanted in zip(node.args, spelling.wants, strict=True):
            text, binds = self._bound(arg, names, constants)
            operands.append(text if binds >= wanted else f"({text})")
        return spelling.pattern.format(*operands), spelling.binds


def standing(nodes: Iterable[Expr], named: Container[Expr], known: Container[Expr]) -> list[Expr]:
    """Return the nodes that stand in the text of `nodes`, in order, as often as they do; not those that are `known`.

    A `named` node stands for itself, of any other one what it is computed from stands there, too.
    """
    found: list[Expr] = []
    stack = list(nodes)[::-1]
    while stack:
        node = stack.pop()
        if node in named:
            found.append(node)
        elif node not in known:
            found.append(node)
            stack += node.args[::-1]
    return found


def operands(nodes: Iterable[Expr], named: Container[Expr], known: Container[Expr]) -> tuple[Expr, ...]:
    """Return the named nodes that stand in the text of `nodes`, once each, in order."""
    return tuple(dict.fromkeys([node for node in standing(nodes, named, known) if node in named]))


class _Powers(Printer):
    """Writes a product of equal factors as a power."""

    def _written(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        if node.op is not Op.MUL:
            return super()._written(node, names, constants)
        pieces: list[str] = []
        for factor, count in Counter(_factors(node, names)).items():
            text, binds = self._bound(factor, names, constants)
            bare = binds > SIGN if pieces or count > 1 else binds >= PRODUCT
            pieces.append((text if bare else f"({text})") + (f"**{count}" if count > 1 else ""))
        return "*".join(pieces), PRODUCT


def _factors(node: Expr, names: Mapping[Expr, str]) -> Iterator[Expr]:
    if node.op is Op.MUL and node not in names:
        for arg in node.args:
            yield from _factors(arg, names)
    else:
        yield node


SYMPY = _Powers(
    {
        **OPERATORS,
        **{op: call(name, 2 if op is Op.ATAN2 else 1) for op, name in NAMES.items()},
        Op.PI: Spelling("pi"),
        Op.NEG: Spelling("-{}", SIGN, (PRODUCT,)),
    },
    lambda value: str(value) if value.denominator == 1 else f"Rational({value.numerator}, {value.denominator})",
)
"""A product of equal factors is a power, a fraction a `Rational`."""
