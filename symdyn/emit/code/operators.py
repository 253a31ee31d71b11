"""How an operation is written in a language with infix operators, and a printer that gets the parentheses right.

A spelling says how tightly its result binds and how tightly each operand must bind to stand there bare. Right operands
of + and * must bind tighter than the operator itself, so the text is evaluated in the order of the graph.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

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
