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

from symdyn.emit.code.operators import Printer
from symdyn.emit.code.real import Real
from symdyn.emit.code.source_text import FunctionText
from symdyn.emit.targets.gpu.room import MANY, SPARE, Room, room
from symdyn.graph import Expr, Op
from symdyn.program import Program, Routine
from symdyn.program.assemble import shared
from symdyn.program.waiting import Line

WAITING = "waiting"
"""Where values wait."""

AGAIN = "again(n)"
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
        lines: in running order.
    """

    function: FunctionText
    common: str
    block: int
    places: int
    again: bool
    lines: tuple[LineText, ...]


@dataclass(frozen=True)
class _Line:
    """A step, both sines of an angle, or an entry of the result at a `place`; what it makes, reads and needs."""

    node: Expr
    makes: tuple[Expr, ...]
    reads: tuple[Expr, ...]
    spare: int
    place: int = -1


def rooms(program: Program, real: Real) -> tuple[Room, ...]:
    """Return how the kernel of every function of a program runs."""
    return tuple(_room(program, routine, real) for routine in program.routines)


def kernels(
    program: Program, functions: Sequence[FunctionText], rooms: Sequence[Room], printer: Printer
) -> tuple[KernelText, ...]:
    """Return every function of a program as a kernel that runs as its room says, in a printer's language."""
    return tuple(
        _kernel(program, routine, text, one, printer)
        for routine, text, one in zip(program.routines, functions, rooms, strict=True)
    )


def _room(program: Program, routine: Routine, real: Real) -> Room:
    lines, shape = _lines(program, routine), routine.function.shape
    joints = max(len(program.scene.velocities), 1)
    groups: list[list[int]] = [[] for _ in range(joints)]
    for number, line in enumerate(lines):
        if not line.makes:
            groups[line.place % (shape or (1,))[-1] % joints].append(number)
    return room([Line(line.makes, line.reads, line.spare) for line in lines], groups[::-1], real)


def _kernel(program: Program, routine: Routine, text: FunctionText, room: Room, printer: Printer) -> KernelText:
    lines, names = _lines(program, routine), routine.names
    common = shared([argument.name for argument in routine.function.arguments])
    places = {symbol: (a.name, i) for a in routine.function.arguments for i, symbol in enumerate(a.symbols)}
    taken = set(names.values())
    again = len(routine.function.entries) > MANY
    count = AGAIN if again else "n"
    found: list[LineText] = []
    for move in room.plan.moves:
        if move.line >= 0:
            found.append(_text(lines[move.line], names, count, program, printer))
            continue
        value = move.value
        assert isinstance(value, Expr)
        waiting = f"{WAITING}[{move.place} * {room.block}]"
        if move.kept:
            found.append(LineText(waiting, names[value], stored=True))
        elif move.place >= 0:
            names[value] = _fresh(names[value], taken)
            found.append(LineText(names[value], waiting))
        else:
            name, place = places[value]
            found.append(
                LineText(names[value], f"{name}[{place}]" if name == common else f"{name}[{place} * {count} + k]")
            )
    return KernelText(text, common, room.block, room.plan.places, again, tuple(found))


def _text(line: _Line, names: Mapping[Expr, str], count: str, program: Program, printer: Printer) -> LineText:
    """Return a line in a printer's language, values by the names that they have now."""
    if not line.makes:
        return LineText(
            f"out[{line.place} * {count} + k]", printer.code(line.node, names, program.constants), stored=True
        )
    first, *cosine = line.makes
    if cosine:
        return LineText(names[first], printer.code(line.node, names, program.constants), names[cosine[0]])
    return LineText(names[first], printer.definition(line.node, names, program.constants))


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
) -> tuple[tuple[Expr, ...], int]:
    """Return the named nodes that stand in the text of `nodes`, once each, in order, and what `SPARE` says of it."""
    found: dict[Expr, None] = {}
    spare = [SPARE.get(op, 0) for op in operations]
    stack = list(nodes)[::-1]
    while stack:
        node = stack.pop()
        if node in named:
            found[node] = None
        elif node not in known:
            spare.append(SPARE.get(node.op, 0))
            stack += node.args[::-1]
    return tuple(found), max(spare, default=0)
