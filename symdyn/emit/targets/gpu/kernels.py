"""A function as a kernel: one state a thread, its lines in an order in which few values wait in registers.

Entry i of state k is x[i * n + k], so that neighbouring threads read neighbouring numbers; what all states have in
common, the parameters or what was prepared from them, is x[i]. A value is read right before its first use, a result is
written as soon as it is known, and sine and cosine of one angle are taken by one call.
"""

from __future__ import annotations

from collections.abc import Container, Hashable, Mapping, Sequence
from dataclasses import dataclass

from symdyn.emit.code.operators import Printer
from symdyn.emit.code.source_text import FunctionText
from symdyn.graph import Expr, Op
from symdyn.program import Program, Routine, Step
from symdyn.program.assemble import shared
from symdyn.program.schedule import most_alive, schedule, schedule_backwards


@dataclass(frozen=True)
class KernelLine:
    """One line of a kernel.

    Attributes:
        target: the name that is given a value, or the place that is written to.
        code: the value; of a sine and cosine, the angle.
        cosine: what the cosine is called where the line takes both, and `target` is the sine; else "".
        stored: whether it writes an entry of the result.
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
        lines: in running order.
    """

    function: FunctionText
    common: str
    lines: tuple[KernelLine, ...]


def kernels(program: Program, functions: Sequence[FunctionText], printer: Printer) -> tuple[KernelText, ...]:
    """Return every function of a program as a kernel, in a printer's language."""
    return tuple(
        _kernel(routine, text, program, printer) for routine, text in zip(program.routines, functions, strict=True)
    )


def _kernel(routine: Routine, text: FunctionText, program: Program, printer: Printer) -> KernelText:
    named = routine.names
    common = shared([argument.name for argument in routine.function.arguments])
    reads = {step.node: step for step in routine.inputs}
    places = {symbol: (a.name, i) for a in routine.function.arguments for i, symbol in enumerate(a.symbols)}
    pairs = _pairs(routine.steps)
    lines: list[tuple[Hashable, tuple[Expr, ...], KernelLine]] = []
    for step in routine.steps:
        angle = step.node.args[0] if step.node in pairs else None
        if angle is not None and step.node.op is Op.SIN:
            line = KernelLine(step.name, printer.code(angle, named, program.constants), pairs[step.node])
        elif angle is None:
            line = KernelLine(step.name, printer.definition(step.node, named, program.constants))
        else:
            continue  # its sine has the line
        lines.append((_value(step.node, pairs), _needs(step.node.args, named, program.constants), line))
    for place, entry in enumerate(routine.function.entries):
        code = printer.code(entry, named, program.constants)
        lines.append(
            (None, _needs((entry,), named, program.constants), KernelLine(f"out[{place} * n + k]", code, stored=True))
        )
    known: set[Expr] = set()
    ordered: list[KernelLine] = []
    wanted = [(made, list(dict.fromkeys(_value(node, pairs) for node in needs))) for made, needs, _ in lines]
    orders = (range(len(wanted)), schedule(wanted), schedule_backwards(wanted))
    for number in min(orders, key=lambda order: most_alive(wanted, order)):
        _, needs, line = lines[number]
        for node in needs:
            if node in reads and node not in known:
                known.add(node)
                name, place = places[node]
                code = f"{name}[{place}]" if name == common else f"{name}[{place} * n + k]"
                ordered.append(KernelLine(reads[node].name, code))
        ordered.append(line)
    return KernelText(text, common, tuple(ordered))


def _pairs(steps: Sequence[Step]) -> dict[Expr, str]:
    """Return the name of the cosine for every sine and cosine of an angle of which both are taken."""
    cosines = {step.node.args[0]: step.name for step in steps if step.node.op is Op.COS}
    sines = {step.node.args[0] for step in steps if step.node.op is Op.SIN}
    angular = (step.node for step in steps if step.node.op in (Op.SIN, Op.COS))
    return {node: cosines[node.args[0]] for node in angular if node.args[0] in sines and node.args[0] in cosines}


def _value(node: Expr, pairs: Mapping[Expr, str]) -> Hashable:
    """Return what is made by the line that makes `node`: of a pair, both at once."""
    return ("sincos", node.args[0]) if node in pairs else node


def _needs(nodes: Sequence[Expr], named: Mapping[Expr, str], known: Container[Expr]) -> tuple[Expr, ...]:
    """Return the named nodes that stand in the text of `nodes`, once each, in order."""
    found: dict[Expr, None] = {}
    stack = list(nodes)[::-1]
    while stack:
        node = stack.pop()
        if node in named:
            found[node] = None
        elif node not in known:
            stack += node.args[::-1]
    return tuple(found)
