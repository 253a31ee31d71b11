"""A function as a kernel: one state a thread, in an order in which few values wait, and those in shared memory.

Entry i of state k is x[i * n + k], so that neighbouring threads read neighbouring numbers; what all states have in
common, the parameters or what was prepared from them, is x[i]. A value is read right before its first use, a result is
written as soon as it is known, and sine and cosine of one angle are taken by one call. Place p of thread t in a block
of B threads is at p * B + t, so that no two threads of a warp want the same bank.
"""

from __future__ import annotations

import itertools
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from weakref import finalize

from symdyn.emit.code.operands import operands, standing
from symdyn.emit.code.operators import Printer
from symdyn.emit.code.real import Real
from symdyn.emit.code.source_text import FunctionText
from symdyn.emit.targets.gpu.resource_budget import MANY, SPARE, Budget, Task, budget
from symdyn.emit.targets.gpu.spill import Line, Plan
from symdyn.graph import Expr, Op
from symdyn.program import Program, Routine, shared

WAITING = "waiting"
"""Where values wait."""

AGAIN = "symdyn_again(n)"
"""The number of states, of which a compiler does not know that it is the same one as before."""

BACK = "_back"
"""What is put behind the name of a value when it is back, with how often it was."""


@dataclass(frozen=True)
class LineText:
    """One line of a kernel.

    Attributes:
        target: the name that is given a value, or the place that is written to.
        code: the value; of a sine and cosine, the angle.
        cosine: what the cosine is called where the line takes both, and `target` is the sine; else "".
        stored: whether it writes to a place in memory.
    """

    target: str
    code: str
    cosine: str = ""
    stored: bool = False


@dataclass(frozen=True)
class KernelText:
    """One function as a kernel.

    Attributes:
        function: its head, as all targets have it.
        common: the argument that all states have in common; "" for none.
        block: threads of a block at most.
        places: of values of a thread that wait in shared memory.
        again: whether addresses are computed again each time, so that none is held.
        parts: the lines of each part, which computes its share of the results by itself, in running order.
    """

    function: FunctionText
    common: str
    block: int
    places: int
    again: bool
    parts: tuple[tuple[LineText, ...], ...]


@dataclass(frozen=True)
class _Line:
    """A step, both sines of an angle, or an entry of the result at a `place`; what it makes, reads and needs."""

    node: Expr
    makes: tuple[Expr, ...]
    reads: tuple[Expr, ...]
    spare: int
    operations: int
    place: int = -1


BUDGETS: dict[tuple[int, str], tuple[Budget, ...]] = {}
"""What was found for a program and a type, as long as the program is there: launchers and examples ask again."""


def budgets(program: Program, real: Real) -> tuple[Budget, ...]:
    """Return how the kernel of every function of a program runs."""
    key = (id(program), real.name)
    if key not in BUDGETS:
        BUDGETS[key] = tuple(_room(program, routine, real) for routine in program.routines)
        finalize(program, BUDGETS.pop, key, None)
    return BUDGETS[key]


def kernels(
    program: Program, functions: Sequence[FunctionText], budgets: Sequence[Budget], printer: Printer
) -> tuple[KernelText, ...]:
    """Return every function of a program as a kernel that runs as its room says, in a printer's language."""
    return tuple(
        _kernel(program, routine, text, one, printer)
        for routine, text, one in zip(program.routines, functions, budgets, strict=True)
    )


def _room(program: Program, routine: Routine, real: Real) -> Budget:
    lines, shape = _lines(program, routine), routine.function.shape
    columns: list[list[int]] = [[] for _ in range((shape or (1,))[-1])]
    for number, line in enumerate(lines):
        if not line.makes:
            columns[line.place % len(columns)].append(number)
    plain = [Line(line.makes, line.reads, line.spare) for line in lines]
    weights = [line.operations for line in lines]
    return budget(Task(plain, weights, columns, max(len(program.scene.velocities), 1), real))


def _kernel(program: Program, routine: Routine, text: FunctionText, budget: Budget, printer: Printer) -> KernelText:
    common = shared([argument.name for argument in routine.function.arguments])
    again = len(routine.function.entries) > MANY
    page = _Page(program, routine, _lines(program, routine), printer, common, AGAIN if again else "n", budget.block)
    return KernelText(text, common, budget.block, budget.places, again, tuple(page.part(one) for one in budget.plans))


@dataclass(frozen=True)
class _Page:
    """What all parts of a kernel are written with; `count` is the number of states, `block` that of threads."""

    program: Program
    routine: Routine
    lines: tuple[_Line, ...]
    printer: Printer
    common: str
    count: str
    block: int

    def part(self, plan: Plan) -> tuple[LineText, ...]:
        """Return what runs by a plan, with names of its own."""
        places = {symbol: (a.name, i) for a in self.routine.function.arguments for i, symbol in enumerate(a.symbols)}
        names = self.routine.names
        taken = set(names.values())
        found: list[LineText] = []
        for move in plan.moves:
            if move.line >= 0:
                found.append(self._text(self.lines[move.line], names))
                continue
            value = move.value
            assert isinstance(value, Expr)
            waiting = f"{WAITING}[{move.place} * {self.block}]"
            if move.kept:
                found.append(LineText(waiting, names[value], stored=True))
            elif move.place >= 0:
                names[value] = _fresh(names[value], taken)
                found.append(LineText(names[value], waiting))
            else:
                name, place = places[value]
                column = f"{place}" if name == self.common else f"{place} * {self.count} + k"
                found.append(LineText(names[value], f"{name}[{column}]"))
        return tuple(found)

    def _text(self, line: _Line, names: Mapping[Expr, str]) -> LineText:
        """Return a line in the printer's language, values by the names that they have now."""
        known, code = self.program.constants, self.printer.code
        if not line.makes:
            return LineText(f"out[{line.place} * {self.count} + k]", code(line.node, names, known), stored=True)
        first, *cosine = line.makes
        if cosine:
            return LineText(names[first], code(line.node, names, known), names[cosine[0]])
        return LineText(names[first], self.printer.definition(line.node, names, known))


def _fresh(name: str, taken: set[str]) -> str:
    """Return a name for a value that is back: x7_back1, then x7_back2, but none that is taken."""
    head = name.partition(BACK)[0]
    name = next(one for one in (f"{head}{BACK}{k}" for k in itertools.count(1)) if one not in taken)
    taken.add(name)
    return name


def _lines(program: Program, routine: Routine) -> tuple[_Line, ...]:
    """Return the lines of a routine in the order of the derivation, then its entries."""
    named, known = routine.names, program.constants
    cosines = {step.node.args[0]: step.node for step in routine.steps if step.node.op is Op.COS}
    sines = {step.node.args[0] for step in routine.steps if step.node.op is Op.SIN}
    lines: list[_Line] = []
    for step in routine.steps:
        node, angle = step.node, step.node.args[0]
        needs = _needs(node.args, named, known, node.op)
        if node.op is Op.SIN and angle in cosines:
            lines.append(_Line(angle, (node, cosines[angle]), *needs))
        elif node.op is not Op.COS or angle not in sines:  # else its sine has the line
            lines.append(_Line(node, (node,), *needs))
    for place, entry in enumerate(routine.function.entries):
        lines.append(_Line(entry, (), *_needs((entry,), named, known), place))
    return tuple(lines)


def _needs(
    nodes: Sequence[Expr], named: Container[Expr], known: Container[Expr], *operations: Op
) -> tuple[tuple[Expr, ...], int, int]:
    """Return the named nodes in the text of `nodes`, what `SPARE` says of it, and how many operations stand there."""
    alone = [*operations, *(node.op for node in standing(nodes, named, known) if node not in named)]
    return operands(nodes, named, known), max((SPARE.get(op, 0) for op in alone), default=0), len(alone)
