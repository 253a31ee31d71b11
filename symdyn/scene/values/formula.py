"""Formulas in text: a whitelist over Python's own syntax tree. Nothing is evaluated, nothing is looked up.

    numbers     12  0.35  1e-3  1/3          exact: the digits as written
    names       m1  pi                       pi is the constant
    operators   + - * / ** ( )               an integer power is multiplied out, up to 64
    functions   sin cos tan sqrt exp log tanh abs sign atan2 deg asin acos atan sinh cosh max min
    selection   if(x > 0, a, b)              < <= > >= and or not; if(c, a, b) is a where c > 0
    tables      table("damper", v)           of the scene, or of a file beside it: table("curve.csv", x)
    degrees     90 deg   45/2 deg            the same as deg(90): times pi/180
    a value     500 mm   1/3 kN/m   3 rpm    a number and a unit, and nothing else: in SI, exactly (see `unit`)

Behind a number, `deg` is the factor of formulas, so that `30 deg*t` is 30*deg times t and no degree-tonne; it is a unit
where it stands alone, and in rates: deg/s, deg/ms, deg/min, and deg/s^2 and deg/s^3.

Both values of a selection are computed, so that each needs one wherever the formula is taken.

`parse` ends quickly on any text: length, depth and the number of nodes are bounded, and so are the digits of numbers.
"""

from __future__ import annotations

import ast
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import reduce
from numbers import Integral
from operator import index
from typing import Any, SupportsIndex

from symdyn.arguments import is_sympy
from symdyn.errors import quoted
from symdyn.graph import Graph, Op
from symdyn.scene.values import folding
from symdyn.scene.values.folding import COMPARISONS, COMPOSED, CONSTANTS, EXTREMES, UNARY_FUNCTIONS, instead_of
from symdyn.scene.values.grammar import CLOCK, FORMULA_NAMES, foreign_sign, meant
from symdyn.scene.values.quantity import FormulaError, Quantity, spell
from symdyn.scene.values.unit import Unit, UnitError, in_si

__all__ = ["FormulaError", "parse", "quantity"]

LONGEST_NUMBER = 1000
LONGEST_TEXT = 10_000
DEEPEST = 150
MOST_NODES = 2_000
LARGEST_EXPONENT = 400

BINARY: Mapping[type[ast.operator], Callable[[Quantity, Quantity], Quantity]] = {
    ast.Add: folding.add,
    ast.Sub: folding.sub,
    ast.Mult: folding.mul,
    ast.Div: folding.div,
}

HINTS: Mapping[type[ast.AST], str] = {
    ast.FloorDiv: "// is not known; write /",
    ast.Compare: "a comparison is not a number; write if({}, 1, 0)",
    ast.IfExp: "a choice is a function; write if(x > y, a, b)",
    ast.BoolOp: "a condition is not a number; write if({}, 1, 0)",
    ast.Attribute: "a dot may stand inside a number only",
    ast.Tuple: "a comma may stand between arguments only, as in atan2(y, x); write decimals with a point",
}

_WITH_UNIT = r"\d [^\W\d_]"
_CUT = re.compile(r" ?[-+*/] ?")
MOST_CUTS = 20
"""Places of a text where a unit is tried to end, and a formula to begin."""

TABLE_KEYS = ("value", "unit")
"""Of a number as a table."""

AS_TABLE = 'write a number and a unit such as { value = 500, unit = "mm" }'
"""What is said of a table that is none."""

_DEGREES = re.compile(r"(?<=[\w.)])[ ]+deg\b(?![ ]*\()")
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE]([+-]?\d+))?\Z"
_VALUE = re.compile(
    r"(?P<sign>[+-]?)[ ]?(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(?:[ ]?/[ ]?(?P<below>[0-9]+))?"
    r"(?:[ ]?(?P<unit>[^\W\d_].*|[°%].*)|[ ](?P<other>1[ ]?/.*|\([^\W\d_][^()]*\)[ ]?(?:\^|\*\*).*))"
)
_FACTOR = r"(?:deg|°)[ ]?(?!(?:/[ ]?(?:s|ms|min)(?:[ ]?(?:\^|\*\*)[ ]?[23]|[²³])?[ ]?)+\Z)[*/·⋅×]"
_SUM = r"[^eE^*(][+-]|[,=]|[a-z]\("
_FOREIGN = re.compile(r"[^A-Za-z0-9_+\-*/()., <>=]|(?<![<>])=")

_QUOTED = re.compile(r"\btable ?\( ?([\"'])[A-Za-z0-9_./ -]{1,200}\1")
_IF = re.compile(r"\bif(?= ?\()")
IF = "if_"
"""What `if` is called in the text that Python's grammar reads, where it is no name."""


def quantity(value: object) -> Quantity:
    """Return what a user wrote as an exact quantity.

    Args:
        value: an int, Fraction, Decimal, float (its shortest digits count: 0.1 is 1/10), formula text, a quantity, an
            expression of SymPy, or a table `{"value": 500, "unit": "mm"}`.

    Raises:
        FormulaError: it is none of these, or not finite.
    """
    if isinstance(value, Quantity):
        return value
    if isinstance(value, str):
        return parse(value)
    if type(value) is int or isinstance(value, Fraction):
        return folding.constant(Fraction(value))
    if isinstance(value, float):
        value = Decimal(float.__repr__(value))
    if isinstance(value, Decimal):
        if not value.is_finite():
            raise FormulaError(f"{value} is not a finite number; give one such as 9.81")
        return folding.constant(_exact(str(value).removeprefix("-")) * (-1 if value.is_signed() else 1))
    if isinstance(value, SupportsIndex) and isinstance(value, Integral) and not isinstance(value, bool):  # of NumPy
        return folding.constant(Fraction(index(value)))
    if is_sympy(value):
        return parse(formula_text(value))
    if isinstance(value, Mapping) and "value" in value:
        return _of_table(value)
    raise FormulaError(f'is {_kind(value)}; give a number or a formula such as "m1*h1**2/12"')


def formula_text(value: object) -> str:
    """Return what a user wrote as text; of SymPy q(t) is q, its rates are q_dot and q_ddot.

    >>> import sympy
    >>> k, x = sympy.Symbol("k"), sympy.Function("x")(sympy.Symbol("t"))
    >>> formula_text(-k * x.diff() / 2 + abs(x))
    '-k*x_dot/2 + abs(x)'

    Raises:
        FormulaError: a function of SymPy that formulas do not know.
    """
    if isinstance(value, str) or not is_sympy(value):
        return spell(value) if isinstance(value, Quantity) else str(value)
    from sympy.core.function import AppliedUndef
    from sympy.printing.str import StrPrinter

    class Printer(StrPrinter):  # type: ignore[misc]
        def _print_Symbol(self, one: Any) -> str:
            if not one.name.isidentifier():
                raise FormulaError(f"the symbol {quoted(one.name)} is no name; give letters, digits and _")
            return str(one.name)

        def _print_Function(self, one: Any) -> str:
            if isinstance(one, AppliedUndef) and [str(x) for x in one.args] == [CLOCK]:
                return str(one.func.__name__)
            return str(super()._print_Function(one))

        def _print_Derivative(self, one: Any) -> str:
            if not isinstance(one.expr, AppliedUndef) or [str(x) for x in one.variables] not in ([CLOCK], [CLOCK] * 2):
                raise FormulaError(f"{quoted(one)} is no rate of a coordinate; do it first, by .doit()")
            return f"{self._print(one.expr)}_{'d' * len(one.variables)}ot"

        def _print_Abs(self, one: Any) -> str:
            return f"abs({self._print(one.args[0])})"

        def _print_Exp1(self, one: Any) -> str:
            return "exp(1)"

        def _print_Float(self, one: Any) -> str:
            return repr(float(one)) if one == float(one) else str(super()._print_Float(one))

        def _print_Max(self, one: Any) -> str:
            return f"{type(one).__name__.lower()}({', '.join(map(self._print, one.args))})"

        _print_Min = _print_Max

        def _print_Piecewise(self, one: Any) -> str:
            *parts, (last, rest) = one.args
            if rest != True:  # noqa: E712 of SymPy
                raise FormulaError(f"{quoted(one)} needs a last value, for True")
            chosen = [f"if({self._print(test)}, {self._print(value)}, " for value, test in parts]
            return f"{''.join(chosen)}{self._print(last)}{')' * len(chosen)}"

    return str(Printer({"order": "lex"}).doprint(value))


def _of_table(table: Mapping[str, object]) -> Quantity:
    """Return the number of a table `{ value = 500, unit = "mm" }` in SI."""
    for key in table:
        if key not in TABLE_KEYS:
            raise FormulaError(f"has an unknown key {quoted(str(key))}; {AS_TABLE}")
    inner, said = table["value"], table.get("unit", "")
    if isinstance(inner, Mapping) or not isinstance(said, str):
        raise FormulaError(f"is no number with its unit; {AS_TABLE}")
    found = quantity(inner)
    if not said:
        return found
    unit = Unit.read(said)
    if found.symbols:
        raise FormulaError("is a formula of symbols, which is in SI; leave the unit out")
    if found.unit:
        if reason := Unit.read(found.unit).misfit(unit):
            raise UnitError(reason)
        return found
    return replace(in_si(found, unit), unit=unit.text)


def parse(text: str) -> Quantity:
    """Return the formula in `text` as an exact quantity.

    Raises:
        FormulaError: the text is no formula of the grammar above, divides by zero, or exceeds its bounds.
    """
    if not isinstance(text, str):
        raise FormulaError(f'{quoted(text)} is no text; give a formula as text, such as "3*x"')
    if len(text) > LONGEST_TEXT:
        raise FormulaError(f"is a formula of {len(text)} characters; {LONGEST_TEXT} are allowed")
    try:
        plain = " ".join(text.split())
        found = _VALUE.fullmatch(plain)
        return _formula(plain) if found is None else _value(found, plain)
    except FormulaError as error:
        shown = text if len(text) <= 80 else text[:77] + "..."
        what = "value" if isinstance(error, UnitError) else "formula"
        raise FormulaError(f'"{shown}" is not a usable {what}: {error}') from None


class _BrokenError(FormulaError):
    """Text that is not even built as a formula."""


def _formula(text: str) -> Quantity:
    if foreign := _FOREIGN.search(_QUOTED.sub("", text)):
        raise _BrokenError(foreign_sign(foreign.group(), text, _reads))
    return _Reader(_IF.sub(IF, _DEGREES.sub("*deg", text))).read()


def _reads(text: str) -> bool:
    try:
        return bool(_formula(text))
    except FormulaError:
        return False


def _value(match: re.Match[str], text: str) -> Quantity:
    """Return a number with a unit in SI, and a formula that begins like one, such as 90 deg/2."""
    if match["unit"] and re.match(_FACTOR, match["unit"]):
        return _formula(f"{text[: match.start('unit')].rstrip()} {match['unit']}")
    try:
        unit = Unit.read(match["unit"] or match["other"])
    except UnitError as error:
        try:
            return _formula(text)
        except _BrokenError as broken:
            begin = max(match.span("unit")[0], match.span("other")[0])
            symbols = " " not in text or re.match(r"\w{1,2} is no unit", str(error))
            product = meant(text.replace("^", "**"), _reads) if symbols else ""
            told = str(error).partition("; there are")[0] if product else str(error)
            alone = UnitError(told + product.replace("; write", " or write" if told.endswith("?") else "; write"))
            raise (_letters_beside(text, begin, error) or (broken if re.search(_SUM, text) else alone)) from None
    size = folding.div(folding.constant(_exact(match["number"])), folding.constant(_exact(match["below"] or "1")))
    value = in_si(folding.neg(size) if match["sign"] == "-" else size, unit)
    return replace(value, unit=unit.text, tight=f" {match['unit'] or ''}" not in text)


def _letters_beside(text: str, begin: int, error: UnitError) -> UnitError | None:
    """Return what is said of a number with a unit inside a formula, such as 3 m*l; None of another text.

    Args:
        text: which neither is a value nor a formula.
        begin: where its unit begins.
        error: what is wrong with the whole as a unit.
    """
    for cut in [*_CUT.finditer(text, begin)][-MOST_CUTS:][::-1]:
        value, rest = text[: cut.start()], text[cut.end() :]
        found = _VALUE.fullmatch(value)
        if found is None:
            continue
        try:
            _formula(rest)
            unit = Unit.read(found["unit"] or found["other"])
        except FormulaError:
            continue
        if unit.text:
            typing = f" ({error})" if rest.isidentifier() and len(rest) > 1 else ""
            letters = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", text).replace("^", "**")
            return UnitError(
                f'a unit stands behind a number alone; name the number, such as a = "{value}" in parameters, '
                f"and write a{cut.group()}{rest}{typing}{f'; of symbols alone write {letters}' * _reads(letters)}"
            )
    return None


class _Reader:
    """One walk over one syntax tree; `budget` is what is left of the nodes that the formula may grow to."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.budget = MOST_NODES

    def read(self) -> Quantity:
        if not self.text:
            raise FormulaError("it is empty; give a number or a formula")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                tree = ast.parse(self.text, mode="eval")
        except SyntaxError as error:
            where = (f"at character {error.offset}" if error.offset else "at its end") + meant(self.text, _reads)
            raise _BrokenError(
                f"it breaks off {where}; check brackets and operators; a unit stands behind a number alone, as in 5 mm"
                + (': name the number, such as a = "5 mm" in parameters' if re.search(_WITH_UNIT, self.text) else "")
            ) from None
        except (ValueError, MemoryError, RecursionError):
            raise FormulaError("it nests too deep; name a part of it as a parameter") from None
        return self.visit(tree.body, 0)

    def visit(self, node: ast.expr, depth: int) -> Quantity:
        if depth > DEEPEST:
            raise FormulaError(f"it nests deeper than {DEEPEST} levels; use fewer terms or brackets")
        if isinstance(node, ast.Constant):
            return self.literal(node)
        if isinstance(node, ast.Name):
            return self.name(node.id)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.UAdd, ast.USub)):
            inner = self.visit(node.operand, depth + 1)
            return folding.neg(inner) if isinstance(node.op, ast.USub) else inner
        if isinstance(node, ast.BinOp):
            return self.binary(node, depth)
        if isinstance(node, ast.Call):
            return self.call(node, depth)
        told = HINTS.get(type(node), "only numbers, names, + - * / **, brackets and functions are known")
        raise FormulaError(told.format(ast.unparse(node)))

    def literal(self, node: ast.Constant) -> Quantity:
        digits = self.text[node.col_offset : node.end_col_offset]
        if not re.match(_NUMBER, digits):
            raise FormulaError(f"{digits} is not a decimal number; write one such as 12, 0.35 or 1e-3")
        return folding.constant(_exact(digits))

    def name(self, name: str) -> Quantity:
        if name in CONSTANTS:
            return CONSTANTS[name]
        if name in FORMULA_NAMES:
            raise FormulaError(f"the function {name} needs an argument; write {name}(x)")
        if name.lower() in ("inf", "infinity", "nan"):
            raise FormulaError(f"{name} is not a finite number")
        return Quantity.symbol(name)

    def binary(self, node: ast.BinOp, depth: int) -> Quantity:
        left, right = self.visit(node.left, depth + 1), self.visit(node.right, depth + 1)
        if isinstance(node.op, ast.Pow):
            self.spend(left, min(int(abs(folding.fraction(right) or Fraction(1))), Graph.LARGEST_POWER))
            return folding.power(left, right)
        if type(node.op) not in BINARY:
            raise FormulaError(HINTS.get(type(node.op), "the operators are + - * / **"))
        return BINARY[type(node.op)](left, right)

    def call(self, node: ast.Call, depth: int) -> Quantity:
        if not isinstance(node.func, ast.Name):
            meant = f"{node.func.attr}(x) alone" if isinstance(node.func, ast.Attribute) else "* for a product"
            raise FormulaError(f"a bracket follows something that is no function; write {meant}")
        name = node.func.id
        if name == IF:
            return self.selection(node, depth)
        if name == "table":
            return self.table(node, depth)
        if name not in UNARY_FUNCTIONS and name not in COMPOSED and name not in EXTREMES:
            of_time = [ast.unparse(one) for one in node.args] == [CLOCK]
            raise FormulaError(f"the function {name} is not known; {instead_of(name, of_time)}")
        wanted, many = COMPOSED[name].arguments if name in COMPOSED else 1, name in EXTREMES
        if node.keywords or (len(node.args) < 2 if many else len(node.args) != wanted):
            raise FormulaError(f"{name} takes {'2 or more' if many else wanted} argument{'s' * (many or wanted > 1)}")
        args = [self.visit(arg, depth + 1) for arg in node.args]
        if name in COMPOSED:
            self.spend(args[0], COMPOSED[name].times)
            return COMPOSED[name].make(*args)
        if many:
            self.spend(max(args, key=_size), 2 ** (len(args) + 1))
            return reduce(EXTREMES[name], args)
        return folding.function(UNARY_FUNCTIONS[name], args[0])

    def table(self, node: ast.Call, depth: int) -> Quantity:
        """Return what reads a table of numbers, by its name until all of a scene is known."""
        first, *rest = node.args or [node]
        if not (isinstance(first, ast.Constant) and isinstance(first.value, str)) or not 1 <= len(rest) <= 2:
            raise FormulaError('table takes a name or file in quotes and 1 or 2 arguments, as in table("curve.csv", x)')
        return Quantity(Op.SELECT, tuple(self.visit(one, depth + 1) for one in rest), first.value)

    def selection(self, node: ast.Call, depth: int) -> Quantity:
        if node.keywords or len(node.args) != Op.SELECT.arity:
            raise FormulaError("if takes a condition and 2 values, such as if(x > 0, a, b)")
        a, b = (self.visit(one, depth + 1) for one in node.args[1:])
        return self.chosen(node.args[0], a, b, depth + 1)

    def chosen(self, test: ast.expr, a: Quantity, b: Quantity, depth: int) -> Quantity:
        """Return a where a condition holds, b elsewhere; a number holds where it is positive."""
        if depth > DEEPEST:
            raise FormulaError(f"it nests deeper than {DEEPEST} levels; use fewer terms or brackets")
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            return self.chosen(test.operand, b, a, depth + 1)
        if isinstance(test, ast.BoolOp):
            both = isinstance(test.op, ast.And)
            for part in reversed(test.values):
                self.spend(b if both else a, 1)
                found = self.chosen(part, a, b, depth + 1)
                a, b = (found, b) if both else (a, found)
            return a if both else b
        if not isinstance(test, ast.Compare):
            return folding.select(self.visit(test, depth), a, b)
        sides = [self.visit(one, depth + 1) for one in (test.left, *test.comparators)]
        for x, how, y in reversed([*zip(sides, test.ops, sides[1:], strict=False)]):
            if type(how) not in COMPARISONS:
                raise FormulaError("a condition compares by < <= > >= only")
            self.spend(b, 1)
            a = COMPARISONS[type(how)](x, y, a, b)
        return a

    def spend(self, part: Quantity, times: int) -> None:
        """Pay for a part that is repeated; without it, a tower of powers would grow without bound."""
        self.budget -= times * _size(part)
        if self.budget < 0:
            raise FormulaError("its powers multiply out to too many terms; name a part of it as a parameter")


def split_commas(text: str) -> list[str]:
    """Return the parts between the commas that stand in no bracket, as that of atan2(y, x) does.

    >>> split_commas("phi=atan2(1, 2), Q=[1, 2]")
    ['phi=atan2(1, 2)', 'Q=[1, 2]']
    """
    parts, depth, last = [], 0, 0
    for place, letter in enumerate(text):
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth <= 0:
            parts.append(text[last:place])
            last = place + 1
    return [part.strip() for part in (*parts, text[last:])] if text.strip() else []


def _size(part: Quantity) -> int:
    return 1 + sum(_size(arg) for arg in part.args)


def _exact(digits: str) -> Fraction:
    if len(digits) > LONGEST_NUMBER:
        raise FormulaError(f"{digits[:20]}... has {len(digits)} digits; {LONGEST_NUMBER} are allowed")
    exponent = re.search(r"[eE]([+-]?\d+)$", digits)
    if exponent and (len(exponent[1]) > 6 or abs(int(exponent[1])) > LARGEST_EXPONENT):
        raise FormulaError(f"{digits} is beyond what a double can hold; the exponent may be {LARGEST_EXPONENT} at most")
    return Fraction(digits)


def _kind(value: object) -> str:
    kinds: dict[type, str] = {bool: "true or false", list: "a list", tuple: "a list", dict: "a table"}
    return "nothing" if value is None else kinds.get(type(value), f"a {type(value).__name__}")
