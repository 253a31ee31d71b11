"""Double-doubles in C: pairs of doubles whose sum is the number, 106 bits of it; functions on them, for many states.

    a + b  dd_add(a, b)      a b  dd_mul(a, b)      a b, b a double  dd_times(a, b)      1/10  dd_of(0.1, -5.6e-18)

A sum or product that goes into a sum is not brought to normal form before (`_loose`): its low part may be a few units
too large, and the sum is as right as with normal ones. Error bounds, in u² = 2^-106: a product 5, a quotient 15, a
square root 3.2, each of the result, a sum 3 of |a| + |b|; with loose operands up to 16.

A function is loops over a block of states, as `plan` cuts a routine. Every number takes two places of an array, its
high and its low part one after the other, so a function looks like one of twice as many doubles. All states go through
a block of `DD_LANES` columns: copies there and back cost nothing beside the arithmetic. Without batch code a block is
one state.

References: Dekker, A floating-point technique for extending the available precision (1971); Joldes, Muller and Popescu,
Tight and rigorous error bounds for basic building blocks of double-word arithmetic (2017), algorithms 5, 9, 11 and 17;
Lefèvre, Louvet, Muller, Picot and Rideau, Accurate calculation of Euclidean norms using double-word arithmetic (2023),
for the square root.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import factorial, frexp
from typing import Any

from symdyn.emit.code.identifiers import checked, lone_header
from symdyn.emit.code.spelling import LEAF, REALS, Printer, Real, Spelling, call, digits, halves
from symdyn.emit.code.target import ArgumentText, Draft, FunctionText, Line
from symdyn.emit.render import render
from symdyn.emit.targets.c.plan import Pass, Plan, SineCosine, plan
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op
from symdyn.program import Program, Routine, RoutineStep, shared

LOOSE = {Op.ADD: "dd_add_loose", Op.SUB: "dd_sub_loose", Op.MUL: "dd_mul_loose"}
"""What is left as it comes where the next operation does not mind."""

NAMES: Mapping[Op, Spelling] = {
    **dict.fromkeys((Op.CONSTANT, Op.PI, Op.SYMBOL), LEAF),
    Op.ADD: call("dd_add", 2),
    Op.SUB: call("dd_sub", 2),
    Op.MUL: call("dd_mul", 2),
    Op.DIV: call("dd_div", 2),
    Op.NEG: call("dd_neg"),
    Op.SIN: call("dd_sin"),
    Op.COS: call("dd_cos"),
    Op.SQRT: call("dd_sqrt"),
    Op.ABS: call("dd_abs"),
    Op.SIGN: call("dd_sign"),
    **{op: call(f"dd_{op.name.lower()}", op.arity) for op in REALS["dd"].lacks},
}

PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798")
"""To 101 digits, of which the reduction of an angle needs 62."""

CUT, PARTS = 33, 3
"""Bits of the first parts of π/2, so that 20 bits times one of them is exact, and how many such parts there are."""

SINE_TERMS, COSINE_TERMS = 13, 14
"""Last terms of the series: y^27 and y^28."""

SINE_IN_DOUBLE, COSINE_IN_DOUBLE = 8, 9
"""The first terms that doubles hold well enough, y^17 and y^18: they are below 2^-53."""


@dataclass(frozen=True)
class DoubleDoublePrinter(Printer):
    """Writes nodes as calls of the arithmetic; sums and products stay loose where that does no harm."""

    def definition(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> str:
        """Return the right-hand side of the line that gives `node` its name, in normal form."""
        return self._called(node, names, constants, loose=False)

    def _bound(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        return self._text(node, names, constants, ()), self.spellings[Op.NEG].binds

    def _text(
        self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction], loose: tuple[Op, ...]
    ) -> str:
        if node in names:
            return names[node]
        if node in constants:
            return f"dd_of({self.literal(constants[node])})"
        return self._called(node, names, constants, node.op in loose)

    def _called(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction], loose: bool) -> str:
        spelled = f"{LOOSE[node.op]}({{}}, {{}})" if loose else self.spellings[node.op].pattern
        if node.op is Op.MUL:
            for one, other in (node.args, node.args[::-1]):
                if one in constants and not halves(constants[one])[1]:
                    factor = halves(constants[one])[0]
                    word = "dd_scale" if abs(frexp(factor)[0]) == 0.5 else "dd_times_loose" if loose else "dd_times"
                    return f"{word}({self._text(other, names, constants, (Op.MUL,))}, {factor!r})"
        below = (Op.MUL,) if node.op is Op.MUL else tuple(LOOSE) if node.op in LOOSE else ()
        return spelled.format(*(self._text(arg, names, constants, below) for arg in node.args))


def printer_of(real: Real) -> Printer:
    """Return what writes double-doubles in C."""
    return DoubleDoublePrinter(NAMES, lambda value: digits(value, real))


def sincos_numbers() -> Mapping[str, Any]:
    """Return the numbers of sine and cosine: π/2 in parts, and the coefficients of both series in y².

    sin y = y (1 + z S(z)),   cos y = 1 - z/2 + z² C(z),   z = y², |y| ≤ π/4
    """
    sine = [Fraction((-1) ** m, factorial(2 * m + 1)) for m in range(1, SINE_TERMS + 1)]
    cosine = [Fraction((-1) ** m, factorial(2 * m)) for m in range(2, COSINE_TERMS + 1)]
    return {
        "limit_exponent": REALS["dd"].limit_exponent,
        "two_over_pi": repr(float(2 / PI)),
        "half_pi": [f"{part!r}" for part in half_pi()],
        "sine": _series(sine, SINE_IN_DOUBLE - 1),
        "cosine": _series(cosine, COSINE_IN_DOUBLE - 2),
    }


def half_pi() -> list[float]:
    """Return π/2 in parts: three of 33 bits, so that 20 bits times one are exact, and two doubles for the rest."""
    rest, parts = PI / 2, []
    for k in range(PARTS):
        unit = Fraction(2) ** -(CUT * (k + 1) - 1)
        parts.append(float(rest // unit * unit))
        rest -= Fraction(parts[-1])
    return [*parts, *halves(rest)]


def _series(coefficients: list[Fraction], exact: int) -> dict[str, Any]:
    """Return a series: its first `exact` coefficients as pairs, last first, the others by Horner's rule."""
    short = [float(one) for one in coefficients[exact:]]
    text = repr(short[-1])
    for one in short[-2::-1]:
        text = f"{one!r} + z.hi * ({text})"
    return {"short": text, "pairs": [digits(one, REALS["dd"]) for one in coefficients[exact - 1 :: -1]]}


DD_LANES = REALS["dd"].lanes
"""States in a block."""

LONGEST = 600
"""Operations up to which a routine is one loop; each becomes about ten of doubles."""


@dataclass(frozen=True)
class Stage:
    """A loop, or a row of angles."""

    number: int  # from 1
    before: tuple[Line, ...] = ()  # what is the same for all states
    lines: tuple[Line, ...] = ()  # the body of the loop; a target with a subscript is an assignment, else a new name
    call: str = ""  # what is called in place of a loop; "" for a loop


@dataclass(frozen=True)
class DoubleDoubleFunction:
    """One function.

    Attributes:
        text: what is told about it.
        states: arguments that differ from state to state, with the row of a block where each starts.
        common: the argument that all states share; "" for none.
        taken: entries of `states` together.
        size: entries of the result.
        rows: rows of work space.
        stages: in running order.
    """

    text: FunctionText
    states: tuple[tuple[ArgumentText, int], ...]
    common: str
    taken: int
    size: int
    rows: int
    stages: tuple[Stage, ...]

    def stack(self, lanes: int) -> int:
        """Return the bytes of arrays of so many states side by side, of which one may be wanted."""
        return 8 * lanes * (2 * (self.taken + self.size + self.rows) + 3)


def write(draft: Draft, batch: bool, lone: bool) -> dict[str, str]:
    """Return source and header of a program on double-doubles, or the one header that is all of it."""
    functions = [
        _function(routine, text, draft.program, printer_of(draft.real))
        for routine, text in zip(draft.program.routines, draft.page.functions, strict=True)
    ]
    operations = {op for one in functions for op in one.text.operations}
    values: dict[str, Any] = {
        "stem": draft.stem,
        "about": draft.about,
        "functions": functions,
        "batch": batch,
        "lone": lone,
        "lanes": DD_LANES if batch else 1,
        "sincos": bool(operations & {Op.SIN, Op.COS}),
        "common": Program.PREPARED if draft.program.is_prepared else Program.PARAMS,
        **sincos_numbers(),
    }
    public = [f"{draft.stem}_{one.text.name}" for one in functions]
    if lone:
        values |= {"headers": ("math", "stddef", "stdint", "string"), "manners": "c/dd_manners.h.jinja"}
        body = render("c/dd_functions.c.jinja", values).strip("\n")
        return {f"{draft.stem}.h": lone_header(body, public, values)}
    return {
        f"{draft.stem}.c": checked(render("c/dd_source.c.jinja", values), public),
        f"{draft.stem}.h": render("c/dd_header.h.jinja", values),
    }


def _function(routine: Routine, text: FunctionText, program: Program, printer: Printer) -> DoubleDoubleFunction:
    made = plan(routine, program.constants, longest=LONGEST)
    common = shared([argument.name for argument in text.arguments])
    states, rows = [], 0
    for argument in text.arguments:
        if argument.name != common:
            states.append((argument, rows))
            rows += argument.length
    begin = {argument.name: row for argument, row in states}
    writer = _Writer(routine, program, printer, made, begin)
    stages = tuple(writer.stage(stage, number) for number, stage in enumerate(made.stages, 1))
    return DoubleDoubleFunction(text, tuple(states), common, rows, len(routine.function.entries), made.rows, stages)


@dataclass(frozen=True)
class _Writer:
    """Prints the stages of one routine; `begin` says at which row of a block an argument starts."""

    routine: Routine
    program: Program
    printer: Printer
    plan: Plan
    begin: Mapping[str, int]

    def stage(self, stage: Pass | SineCosine, number: int) -> Stage:
        if isinstance(stage, SineCosine):
            angle = _both("w", stage.row) if stage.row is not None else self._input(stage.angle.node, "")
            rows = ", ".join(_both("w", row) for _, row in (stage.sine, stage.cosine))
            return Stage(number, call=f"sincos_row({angle}, {rows});")
        loads = {step.node: row for step, row in stage.loads}
        stores = {step.node: row for step, row in stage.stores}
        lines: list[Line] = []
        for line in stage.order:
            if isinstance(line, int):
                name = f"out_{line + 1}"
                entry = self.routine.function.entries[line]
                lines.append(Line(name, self.printer.code(entry, self.plan.names, self.program.constants)))
                lines += _stored("y", line, name)
            elif line.node in loads:
                lines.append(Line(line.name, f"dd_of({_both('w', loads[line.node], '[k]')})"))
            elif line.node.op is Op.SYMBOL:
                lines.append(Line(line.name, f"dd_of({self._input(line.node, '[k]')})"))
            else:
                lines.append(self._define(line))
            if isinstance(line, RoutineStep) and line.node in stores:
                lines += _stored("w", stores[line.node], line.name)
        return Stage(number, tuple(self._define(step) for step in stage.uniform), tuple(lines))

    def _define(self, step: RoutineStep) -> Line:
        if step.node.op is Op.SYMBOL:
            return Line(step.name, f"dd_of({self._input(step.node, '')})")
        return Line(step.name, self.printer.definition(step.node, self.plan.names, self.program.constants))

    def _input(self, node: Expr, lane: str) -> str:
        """Return both parts of an entry of an argument, or where their rows stand."""
        for argument in self.routine.function.arguments:
            if node in argument.symbols:
                place = argument.symbols.index(node)
                if argument.name in self.begin:
                    return _both("x", self.begin[argument.name] + place, lane)
                return _both(argument.name, place)
        raise AssertionError("every symbol is an argument's")


def _both(array: str, place: int, lane: str = "") -> str:
    return f"{array}[{2 * place}]{lane}, {array}[{2 * place + 1}]{lane}"


def _stored(array: str, place: int, name: str) -> list[Line]:
    return [Line(f"{array}[{2 * place + part}][k]", f"{name}.{half}") for part, half in enumerate(("hi", "lo"))]
