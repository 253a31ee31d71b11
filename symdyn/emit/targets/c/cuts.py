"""Functions of one state in parts, and what else is asked of a routine before its stages are printed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symdyn.emit.code.operators import Printer
from symdyn.emit.code.source_text import FunctionText, Page
from symdyn.emit.targets.c.plan import Pass, SineCosine, plan
from symdyn.emit.targets.c.row_solve import RowSolveText, fits, row_solve_text
from symdyn.emit.targets.c.stages import LONGEST
from symdyn.emit.targets.c.writer import SINGLE, PassText, ScalarStage, Writer
from symdyn.program import Program, Routine, RowLoop

SPLIT = 2
"""Scalar functions of more loops are cut into parts, too: compilers take more than linear time."""


@dataclass(frozen=True)
class CutText:
    """One function of a file without batch code, in stages; the attributes are those of `BatchText`."""

    size: int
    kept: int
    scalar: tuple[ScalarStage, ...]
    parts: tuple[PassText, ...]
    results: tuple[str, ...] = ()
    sincos: bool = False
    cleared: bool = False
    solve: RowSolveText | None = None


def cuts(
    program: Program,
    page: Page,
    printer: Printer,
    few: int | None = None,
    address: str = "&{}",
    solving: bool = False,
) -> tuple[CutText | None, ...]:
    """Return every function of the page in stages, None for one that stays as it is.

    Long ones are cut into parts. Where one state has `few` angles or more, they are taken together, else one by one.
    `address` is how a part is handed a number. Where `solving`, what is solved in rows is cut up to them.
    """
    return tuple(
        _cut(routine, text, program, printer, few, address, solving)
        for routine, text in zip(program.routines, page.functions, strict=True)
    )


def _cut(
    routine: Routine,
    text: FunctionText,
    program: Program,
    printer: Printer,
    few: int | None,
    address: str,
    solving: bool,
) -> CutText | None:
    together, long = few is not None, length_of(routine) > LONGEST
    if text.loop or not (long or together):
        return None
    rows = up_to_rows(routine, printer, together) if solving else None
    writer = rows.writer if rows else writer_of(routine, text, program, printer, LONGEST, together and long)
    parts = rows.parts if rows else parts_of(writer, cleared=few is None)
    angles = sum(isinstance(stage, SineCosine) for stage in writer.plan.stages)
    size = len(writer.routine.function.entries)
    if parts:
        calls = writer.scalar_calls(by_address(text, address), together)
        cleared = any(map(writer.zero, range(size)))
        sines = together and angles > 0
        return CutText(size, writer.plan.rows, calls, parts, (), sines, cleared, rows.solve if rows else None)
    if few is not None and angles >= few:
        results = tuple(writer.entry(place) for place in range(size))
        return CutText(size, 0, writer.scalar(), (), results, sincos=True)
    return None


def length_of(routine: Routine) -> int:
    """Return how many products and sums a routine has."""
    return routine.counts.multiplications + routine.counts.additions


@dataclass(frozen=True)
class UpToRows:
    """The parts before a loop over rows, and the loop."""

    writer: Writer
    parts: tuple[PassText, ...]
    solve: RowSolveText


def up_to_rows(routine: Routine, printer: Printer, short: bool) -> UpToRows | None:
    """Return a function in parts up to a loop over rows; None where it has none, or nothing to be cut before it.

    As to `short` see `plan`.
    """
    rows = RowLoop.of(routine.function)
    if rows is None or not fits(rows):
        return None
    (before,) = rows.program.routines
    writer = writer_of(before, None, rows.program, printer, LONGEST, short and length_of(before) > LONGEST)
    parts = parts_of(writer, cleared=True)
    return UpToRows(writer, parts, row_solve_text(rows)) if parts else None


def writer_of(
    routine: Routine, text: FunctionText | None, program: Program, printer: Printer, longest: int, short: bool
) -> Writer:
    """Return what prints one routine, in passes of at most `longest` operations; as to `short` see `plan`.

    `text` is what has been printed of it already.
    """
    places = {symbol: (a.name, i) for a in routine.function.arguments for i, symbol in enumerate(a.symbols)}
    made = plan(routine, program.constants, short, longest)
    if text and len(made.names) == len(routine.inputs) + len(routine.steps):  # no name was added
        printed = {line.target: line.code for line in text.steps}
    else:
        lines = ((name, node) for node, name in made.names.items() if node not in places)
        printed = {name: printer.definition(node, made.names, program.constants) for name, node in lines}
    return Writer(routine, program, printer, made, places, printed)


def parts_of(writer: Writer, cleared: bool) -> tuple[PassText, ...]:
    """Return the parts of a scalar function, () for a short one; where the result is `cleared` they write no zeros."""
    loops = [stage for stage in writer.plan.stages if isinstance(stage, Pass)]
    if not writer.routine.function.entries or sum(stage.plain for stage in loops) <= SPLIT:
        return ()
    entries = range(len(writer.routine.function.entries))
    written = {place: place for place in entries if not (cleared and writer.zero(place))}
    return tuple(writer.loop(stage, number, SINGLE, written) for number, stage in enumerate(loops, 1))


def handed_on(function: FunctionText, places: Mapping[str, str]) -> str:
    """Return what a call is given before its last argument; what all states have in common as it is."""
    return "".join(f"{places.get(argument.name, argument.name)}, " for argument in function.arguments)


def by_address(function: FunctionText, address: str = "&{}") -> str:
    """Return what a scalar function hands on to its parts, which take single numbers by address."""
    return handed_on(function, {name: address.format(name) for name in function.scalars})
