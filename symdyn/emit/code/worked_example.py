"""Examples beside generated code, for languages with one file that is compiled and run by itself.

They need a state, and what every function must return there. The numbers are those of the equations in 50 digits. Each
comes with how far code may be off, which is a running error analysis of the same equations (`symdyn.algebra.big`):
whatever compiler and library made it, right code passes, and a sign that is wrong does not.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from symdyn.algebra import AllRoundingError, Bounded, Midpoints, RunningErrors
from symdyn.dynamics import Argument, Function
from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.spelling import Real, digits, find_real
from symdyn.emit.code.target import Sources
from symdyn.emit.render import render
from symdyn.frozen import dataclass
from symdyn.graph import Expr, evaluate
from symdyn.program import Program, Sampling

DIGITS = 50
SEED = "example"
NO_VALUE = (ValueError, ZeroDivisionError, OverflowError)
ENOUGH = 6
"""States at which a divisor is all rounding error before no more are drawn: in long chains it is so everywhere."""


@dataclass(frozen=True)
class ExampleInputs:
    """One argument of the example."""

    name: str  # in code
    scalar: bool  # whether it is one number
    values: tuple[str, ...]  # decimal numbers; () for what `prepare` makes there
    length: int  # how many there are


@dataclass(frozen=True)
class Called:
    """One call of the example.

    Attributes:
        name: of the function, without that of the scene.
        arguments: names of what is given, in calling order.
        expected, allowed: what must come out, and how far it may be off; decimal numbers.
    """

    name: str
    arguments: tuple[str, ...]
    expected: tuple[str, ...]
    allowed: tuple[str, ...]


@dataclass(frozen=True)
class WorkedExample:
    """Every function once, at one state."""

    given: tuple[ExampleInputs, ...]
    called: tuple[Called, ...]
    left_out: tuple[str, ...]


def worked_example(sources: Sources, suffix: str = "") -> WorkedExample:
    """Return arguments and calls at the first state drawn where all functions are real, else at that of the most.

    Numbers are the nearest of the type, and end as the language's literals do: on `suffix`.
    """
    program = sources.program
    functions = [routine.function for routine in program.routines]
    arguments = _arguments(functions)
    best: tuple[dict[str, list[Bounded]], dict[Expr, Bounded]] = {}, {}
    rng, unsure = random.Random(SEED), Counter[str]()
    numbers = Midpoints(DIGITS)
    with numbers:
        analysis = find_real(sources.real).rounding(numbers, sources.accuracy)
        tables = {
            one.name: [analysis.constant(x) for x in one.loop.table.numbers(program.scene)]
            for one in functions
            if one.loop
        }
        for draw, drawn in enumerate(Sampling(list(arguments.values()), rng, sources.real)):
            point = {
                symbol: value
                for argument, values in zip(arguments.values(), drawn, strict=True)
                for symbol, value in zip(argument.symbols, values.ravel().tolist(), strict=True)
            }
            results = _results(functions, tables, point, analysis, unsure)
            if len(results) > len(best[0]) or not draw:
                best = results, point
            if all(one.name in best[0] or unsure[one.name] >= ENOUGH for one in functions):
                break
    results, point = best
    names = {one.symbols: name for name, one in arguments.items()}
    given = [
        ExampleInputs(
            name,
            one.scalar,
            _texts([point[x] for x in one.symbols if one.name != Program.PREPARED], sources.real, suffix),
            len(one.symbols),
        )
        for name, one in arguments.items()
    ]
    called, left_out = [], []
    for name, function in zip(sources.functions, functions, strict=True):
        if function.name in results:
            found = results[function.name]
            told = tuple(names[argument.symbols] for argument in function.arguments)
            wanted = _texts([x.value for x in found], sources.real, suffix)
            called.append(Called(name, told, wanted, _allowed(found, sources, suffix)))
        else:
            left_out.append(name)
    return WorkedExample(tuple(given), tuple(called), tuple(left_out))


def _arguments(functions: Sequence[Function]) -> dict[str, Argument]:
    """Return all arguments by their names there: those of one name and several lengths are told apart by these."""
    every = {argument.symbols: argument for function in functions for argument in function.arguments}
    names = [argument.name for argument in every.values()]
    return {one.name if names.count(one.name) == 1 else f"{one.name}_{len(one.symbols)}": one for one in every.values()}


def _results(
    functions: Sequence[Function],
    tables: Mapping[str, Sequence[Bounded]],
    point: Mapping[Expr, Any],
    analysis: RunningErrors,
    unsure: Counter[str],
) -> dict[str, list[Bounded]]:
    """Return the result of every function that is real at a point; what is prepared there is handed on.

    One that is a loop over a table finds it as that does. Where a divisor is all rounding error it is counted.
    """
    values = {symbol: analysis.exact(analysis.numbers.number(value)) for symbol, value in point.items()}
    results: dict[str, list[Bounded]] = {}
    for function in sorted(functions, key=lambda one: one.name != Program.PREPARE):
        try:
            if function.loop:
                given = {one.name: [values[symbol] for symbol in one.symbols] for one in function.arguments}
                results[function.name] = function.loop.values(tables[function.name], given, analysis)
            else:
                results[function.name] = evaluate(function.entries, analysis, values)
        except NO_VALUE as fault:
            unsure[function.name] += isinstance(fault, AllRoundingError)
            continue
        if function.name == Program.PREPARE:
            symbols = next((a.symbols for f in functions for a in f.arguments if a.name == Program.PREPARED), ())
            values |= dict(zip(symbols, results[Program.PREPARE], strict=True))
    return results


def _texts(values: Sequence[Any], real: str, suffix: str) -> tuple[str, ...]:
    """Return numbers as text, the nearest of the type."""
    kind = find_real(real)
    return tuple(f"{digits(_fraction(value), kind)}{suffix}" for value in values)


def _fraction(value: Any) -> Fraction:
    """Return a double, or the middle of a ball, exactly."""
    if isinstance(value, float):
        return Fraction(value)
    mantissa, exponent = (int(part) for part in value.mid().man_exp())
    return mantissa * Fraction(2) ** exponent


def _allowed(boundeds: Sequence[Bounded], sources: Sources, suffix: str) -> tuple[str, ...]:
    """Return how far each entry may be off, rounded up to two digits."""
    real = find_real(sources.real)
    slack = [Real.ALLOWED * float(one.error) + float(abs(one.value)) * real.roundoff for one in boundeds]
    return tuple(f"{1.05 * bound + real.tiniest:.1e}{suffix}" for bound in slack)


def example_text(sources: Sources, template: str, ending: str, suffix: str = "", **values: Any) -> dict[str, str]:
    """Return the example by its name: main, or example where the scene has that name itself."""
    opening, made = stem(sources.program.scene.name), worked_example(sources, suffix)
    shapes = dict(zip(sources.functions, (r.function.shape for r in sources.program.routines), strict=True))
    example = f"{'example' if opening == 'main' else 'main'}{ending}"
    known = {
        "shapes": shapes,
        "stem": opening,
        "example": example,
        "given": made.given,
        "called": made.called,
        "left_out": made.left_out,
        "prepare": Program.PREPARE,
        "suffix": suffix,
    }
    scalars = [one.name for one in made.given if one.scalar]
    return {example: render(template, {**known, "scalars": scalars, **values})}
