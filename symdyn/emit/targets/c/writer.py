"""The stages of a plan as lines of C, for a block of states or for a single one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby

from symdyn.emit.code.operators import Printer
from symdyn.emit.code.source_text import Line
from symdyn.emit.targets.c.plan import Pass, Plan, SineCosine
from symdyn.graph import Expr, Op
from symdyn.program import Program, Routine, RoutineStep, identifier

GROUP = 8
"""Angles of one state are taken together in groups of so many."""


@dataclass(frozen=True)
class PassText:
    """One loop.

    Attributes:
        number: from 1.
        vector: whether it must become vector code.
        unused: what it is handed and does not read.
        before: what is uniform, ahead of the loop.
        lines: the body of the loop.
        names: targets of lines that are new variables; other lines go to work space and to the result.
    """

    number: int
    vector: bool
    unused: tuple[str, ...]
    before: tuple[Line, ...]
    lines: tuple[Line, ...]
    names: frozenset[str]


@dataclass(frozen=True)
class ScalarStage:
    """A piece of the scalar function: lines, or angles whose sines and cosines are taken together, or a call.

    Attributes:
        number: tells the arrays of angles apart.
        lines: assignments.
        angles: where the angles are, padded with zeros to whole groups; () for lines.
        count: how many there are without the padding.
        results: what becomes of sines and cosines; without `angles`, all there is to it.
        call: of a part that stands in a function of its own; "" for none.
    """

    number: int
    lines: tuple[Line, ...] = ()
    angles: tuple[str, ...] = ()
    results: tuple[Line, ...] = ()
    call: str = ""
    count: int = 0


@dataclass(frozen=True)
class Layout:
    """How a place in memory is written: entries of arguments and of the result, rows of work space."""

    entry: str
    result: str
    row: str
    common: tuple[str, ...]


LANED = Layout("{}[{} * stride + k]", "{}[{} * reach + k]", "w[{}][k]", ("stride", "reach"))
SINGLE = Layout("{}[{}]", "{}[{}]", "w[{}]", ())


@dataclass(frozen=True)
class Writer:
    """Prints the stages of one routine; `printed` holds what stands for each name."""

    routine: Routine
    program: Program
    printer: Printer
    plan: Plan
    places: Mapping[Expr, tuple[str, int]]
    printed: Mapping[str, str]

    def row(self, stage: SineCosine) -> str:
        """Return where the angles of a stage stand."""
        if stage.row is not None:
            return f"w[{stage.row}]"
        argument, place = self.places[stage.angle.node]
        return f"{argument} + {place} * stride"

    def several(self) -> tuple[SineCosine, ...]:
        """Return the stages at the beginning that take neighbouring entries of one argument to the first rows, in turn.

        One alone is none.
        """
        found: list[SineCosine] = []
        for stage in self.plan.stages:
            if not isinstance(stage, SineCosine) or stage.row is not None:
                break
            argument, place = self.places[stage.angle.node]
            before = (argument, place - 1)
            first = 2 * len(found)
            if (found and self.places[found[-1].angle.node] != before) or stage.rows != (first, first + 1):
                break
            found.append(stage)
        return tuple(found) if len(found) > 1 else ()

    def loop(self, stage: Pass, number: int, layout: Layout, written: Mapping[int, int] | None = None) -> PassText:
        """Return one pass as text, for the states of a block or for a single one.

        Of the entries of the result those of `written` alone are written, to its places; None for all to their own.
        """
        places = {
            place: place if written is None else written[place]
            for place in stage.outputs
            if written is None or place in written
        }
        read = {self.places[step.node][0] for step in (*stage.inputs, *stage.uniform) if step.node.op is Op.SYMBOL}
        read |= {"stride"} if stage.inputs else set()
        read |= {"reach"} if places else set()
        read |= {"w"} if stage.loads or stage.stores else set()
        read |= {"out"} if places else set()
        handed = (*layout.common, *(argument.name for argument in self.routine.function.arguments), "w", "out")
        loads = {step.node: row for step, row in stage.loads}
        stores = {step.node: row for step, row in stage.stores}
        lines: list[Line] = []
        for line in stage.order:
            if isinstance(line, int):
                if line in places:
                    lines.append(Line(layout.result.format("out", places[line]), self.entry(line)))
            elif line.node in loads:
                lines.append(Line(line.name, layout.row.format(loads[line.node])))
            elif line.node.op is Op.SYMBOL:
                lines.append(Line(line.name, layout.entry.format(*self.places[line.node])))
            else:
                lines.append(self._define(line))
            if isinstance(line, RoutineStep) and line.node in stores:
                lines.append(Line(layout.row.format(stores[line.node]), line.name))
        return PassText(
            number=number,
            vector=stage.plain,
            unused=tuple(name for name in handed if name not in read),
            before=tuple(self._define(step) for step in stage.uniform),
            lines=tuple(lines),
            names=frozenset(line.name for line in stage.order if isinstance(line, RoutineStep)),
        )

    def scalar(self) -> tuple[ScalarStage, ...]:
        """Return the stages of the scalar function; neighbouring angles are taken together."""
        pending = [Line(step.name, self._given(step)) for step in self.routine.inputs]
        known = {line.target for line in pending}
        stages: list[ScalarStage] = []
        for group in self._grouped():
            if isinstance(group, Pass):
                for step in (*group.uniform, *group.steps):
                    if step.name not in known:
                        known.add(step.name)
                        pending.append(self._define(step))
            else:
                stages.append(ScalarStage(len(stages), tuple(pending)))
                pending = []
                angles = [stage.angle.name for stage in group]
                stages.append(self._angles(len(stages), group, angles, lambda step, _: step.name))
        return (*stages, ScalarStage(len(stages), tuple(pending)))

    def scalar_calls(self, handed: str, together: bool) -> tuple[ScalarStage, ...]:
        """Return the stages of a scalar function that is cut into parts; angles are taken `together` or one by one."""
        name = identifier(self.routine.function.name)
        stages: list[ScalarStage] = []
        parts = 0
        for group in self._grouped():
            if isinstance(group, Pass):
                parts += 1
                stages.append(ScalarStage(len(stages), call=f"{name}_part{parts}({handed}w, r);"))
            else:
                angles = [
                    SINGLE.row.format(stage.row) if stage.row is not None else self._given(stage.angle)
                    for stage in group
                ]
                if together:
                    stages.append(self._angles(len(stages), group, angles, lambda _, row: SINGLE.row.format(row)))
                else:
                    stages.append(ScalarStage(len(stages), results=self._one_by_one(group, angles)))
        return tuple(stages)

    def _given(self, step: RoutineStep) -> str:
        """Return an entry of an argument of the scalar function, which takes single numbers by value."""
        name, place = self.places[step.node]
        scalars = [argument.name for argument in self.routine.function.arguments if argument.scalar]
        return name if name in scalars else SINGLE.entry.format(name, place)

    def _grouped(self) -> Iterator[Pass | list[SineCosine]]:
        """Iterate over the stages, neighbouring sines and cosines together."""
        for is_pass, group in groupby(self.plan.stages, lambda stage: isinstance(stage, Pass)):
            if is_pass:
                yield from (stage for stage in group if isinstance(stage, Pass))
            else:
                yield [stage for stage in group if isinstance(stage, SineCosine)]

    def _angles(
        self, number: int, group: list[SineCosine], angles: list[str], target: Callable[[RoutineStep, int], str]
    ) -> ScalarStage:
        """Return the stage that takes sines and cosines of `angles`; `target` says where one of them goes."""
        results = [
            Line(target(step, row), f"{kind}{number}[{place}]")
            for place, stage in enumerate(group)
            for (step, row), kind in ((stage.sine, "sine"), (stage.cosine, "cosine"))
            if step is not None
        ]
        padding = ["0"] * (-len(angles) % GROUP)
        return ScalarStage(number, angles=(*angles, *padding), results=tuple(results), count=len(angles))

    def _one_by_one(self, group: list[SineCosine], angles: list[str]) -> tuple[Line, ...]:
        """Return what a stage of angles computes by the functions of the C library."""
        return tuple(
            Line(SINGLE.row.format(row), self.printer.spellings[step.node.op].pattern.format(angle))
            for stage, angle in zip(group, angles, strict=True)
            for step, row in (stage.sine, stage.cosine)
            if step is not None
        )

    def _define(self, step: RoutineStep) -> Line:
        """Return the line that gives a step its name."""
        if step.node.op is Op.SYMBOL:
            return Line(step.name, SINGLE.entry.format(*self.places[step.node]))
        return Line(step.name, self.printed[step.name])

    def zero(self, place: int) -> bool:
        """Return whether an entry of the result is zero whatever the state."""
        return self.program.constants.get(self.routine.function.entries[place]) == 0

    def entry(self, place: int) -> str:
        """Return one entry of the result."""
        entry = self.routine.function.entries[place]
        return self.printer.code(entry, self.plan.names, self.program.constants)
