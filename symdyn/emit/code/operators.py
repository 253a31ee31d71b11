"""How an operation is written in a language with infix operators, and a printer that gets the parentheses right.

A spelling says how tightly its result binds and how tightly each operand must bind to stand there bare. Right operands
of + and * must bind tighter than the operator itself, so the text is evaluated in the order of the graph.

What stands in the text of a line: names of values, and operations that have no name of their own.

Names in generated code: legal where they stand, and never taken already.

Graphs as Python for SymPy, which importing takes longer than writing a lesson.
"""

from __future__ import annotations

import keyword
import re
import sys
from collections import Counter
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from symdyn.algebra import NAMES
from symdyn.errors import EmitError
from symdyn.graph import Expr, Op
from symdyn.program import identifier
from symdyn.resources import folder
from symdyn.scene.values import RESERVED

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


C_HEADERS = """alloca assert complex ctype endian errno features fenv float inttypes iso646 limits locale math pthread
sched setjmp signal stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string strings syslimits
tgmath threads time uchar unistd wchar wctype"""
"""Headers of C, and those that they open, without .h."""

MATLAB = """case catch classdef elseif end endfor endfunction endif endparfor endswitch endwhile function otherwise
parfor persistent spmd until unwind_protect"""
"""Words that no package of MATLAB or Octave can have, and no name of C or Python has yet."""

DEVICES = re.compile(r"(con|prn|aux|nul|(com|lpt)\d)\Z", re.IGNORECASE)


def stem(scene: str) -> str:
    """Return the file name of a scene without its ending, which also opens the names of its C functions.

    A scene called numpy or math would hide the module or header that its own code needs, sin the function; a package
    of MATLAB is not called end, and Windows writes no file called CON.c; each gets an underscore.
    """
    name = identifier(scene) or "scene"
    if not name[0].isalpha():
        name = f"m{name}"
    module = name == "numpy" or keyword.iskeyword(name) or name in sys.stdlib_module_names
    words = (*C_HEADERS.split(), *MATLAB.split(), *RESERVED)
    return f"{name}_" if module or name in words or is_device(name) else name


@cache
def names_of_c() -> frozenset[str]:
    """Return what headers of C and POSIX call theirs outside of functions: functions, types, constants, macros.

    `python -m tests.names_of_headers` made the list.
    """
    lines = (folder("templates") / "c" / "names_of_headers.txt").read_text(encoding="utf-8").splitlines()
    return frozenset(name for line in lines if not line.startswith("#") for name in line.split())


def page_stem(scene: str) -> str:
    """Return the file name of a scene's pages without ending; that of a device of Windows gets an underscore."""
    return f"{scene}_" if is_device(scene) else scene


def is_device(name: str) -> bool:
    """Tell whether Windows takes a file of this name, with any ending, for a device."""
    return DEVICES.match(name) is not None


def function_names(names: Sequence[str], keywords: Collection[str] = (), begin: str = "") -> list[str]:
    """Return legal names for functions, in order; one of the target's keywords gets an underscore.

    Args:
        names: what they were asked for as.
        keywords: of the target.
        begin: what stands in front of every name in C; one that headers have, such as sem_wait, gets one, too.

    Raises:
        EmitError: two of them become one.
    """
    legal: dict[str, str] = {}
    taken = names_of_c() if begin else frozenset[str]()
    for name in names:
        plain = identifier(name)
        plain = f"{plain}_" if plain in keywords or f"{begin}{plain}" in taken else plain
        if plain in legal:
            raise EmitError(f"functions {legal[plain]} and {name} would both be called {plain}; rename one of them")
        legal[plain] = name
    return list(legal)


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
