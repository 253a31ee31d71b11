"""Functions on double-doubles in C: loops over a block of states, as `plan` cuts a routine, and what calls them.

Every number takes two places of an array, its high and its low part one after the other, so a function looks like one
of twice as many doubles. All states go through a block of `DD_LANES` columns: copies there and back cost nothing
beside the arithmetic. Without batch code a block is one state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from symdyn.emit.code.operators import Printer
from symdyn.emit.code.real import REALS
from symdyn.emit.code.source_text import ArgumentText, FunctionText, Line
from symdyn.emit.code.target import Draft
from symdyn.emit.render import render
from symdyn.emit.targets.c.double_double import printer as printer_of, sincos_numbers
from symdyn.emit.targets.c.file_scope import checked, lone_header
from symdyn.emit.targets.c.plan import Pass, Plan, SineCosine, plan
from symdyn.graph import Expr, Op
from symdyn.program import Program, Routine, RoutineStep, shared

DD_LANES = REALS["dd"].lanes
"""States in a block."""

LONGEST = 600
"""Operations up to which a routine is one loop; each becomes about ten of doubles."""


@dataclass(frozen=True)
class Stage:
    """A loop, or a row of angles.

    Attributes:
        number: from 1.
        before: what is the same for all states.
        lines: the body of the loop; a target with a subscript is an assignment, else a new name.
        call: what is called in place of a loop; "" for a loop.
    """

    number: int
    before: tuple[Line, ...] = ()
    lines: tuple[Line, ...] = ()
    call: str = ""


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
        """Return one stage as text."""
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
        """Return the line that gives a step its name."""
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
