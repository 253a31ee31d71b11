"""The GPU target: kernels for CUDA and for OpenCL, in double or float, one state a thread.

    <scene>.cu    __global__ void <scene>_<function>(size_t n, const real *q, ..., const real *params, real *out)
    <scene>.cl    __kernel void <scene>_<function>(ulong n, __global const real *q, ..., __global real *out)

Both hold the same lines. They differ in how a kernel is opened, how it finds its state, and how sine and cosine are
taken together. Entry i of state k is x[i * n + k], in `out` likewise, so that neighbouring threads read neighbouring
numbers. params, or what was prepared from it, is one set for all states, x[i]. It stands behind a pointer like all
arguments, so that another set needs no other symbol; all threads of a warp read one number at a time, which caches hand
to all of them.

The order of a kernel's lines keeps few values alive, and what does not fit into registers is in shared memory
(`gpu_budget.py`). A value is read right before its first use, a result is written as soon as it is known, and sine and
cosine of one angle are taken by one call. Place p of thread t in a block of B threads is at p * B + t, so that no two
threads of a warp want the same bank.

Beside the kernels stand an example for CUDA and one for OpenCL, which call every kernel and compare with expected
values, and launchers: for each kernel an `extern "C"` function that hosts call, behind the kernels' own text.
"""

from __future__ import annotations

import itertools
from collections.abc import Container, Mapping, Sequence
from fractions import Fraction
from functools import partial
from weakref import finalize

from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.spelling import (
    OPERATORS,
    SINGLE,
    TABLE,
    Printer,
    Real,
    Spelling,
    call,
    digits,
    find_real,
    operands,
    standing,
)
from symdyn.emit.code.target import Draft, FunctionText, Sources, Target, compose
from symdyn.emit.code.worked_example import Called, worked_example
from symdyn.emit.render import in_comment, render
from symdyn.emit.targets.gpu_budget import BLOCKS, MANY, SIZES, SPARE, Budget, Line, Plan, Task, budget
from symdyn.frozen import dataclass, replace
from symdyn.graph import ELEMENTARY, Expr, Op
from symdyn.program import Program, Routine, shared

WAITING = "waiting"
"""Where values wait."""

AGAIN = "symdyn_again(n)"
"""The number of states, of which a compiler does not know that it is the same one as before."""

BACK = "_back"
"""What is put behind the name of a value when it is back, with how often it was."""


@dataclass(frozen=True)
class LineText:
    """One line of a kernel."""

    target: str  # the name that is given a value, or the place that is written to
    code: str  # the value; of a sine and cosine, the angle
    cosine: str = ""  # what the cosine is called where the line takes both, and `target` is the sine; else ""
    stored: bool = False  # whether it writes to a place in memory


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


FUNCTIONS: Mapping[Op, str] = {op: op.name.lower() for op in (*ELEMENTARY, Op.ATAN2, Op.POW)} | {Op.ABS: "fabs"}
"""As OpenCL calls them for every type, and CUDA for doubles."""

SIGN_HELPER, SELECT_HELPER = "symdyn_sign_of_{}", "symdyn_select_of_{}"
"""Functions of our own, one a type: OpenCL's sign makes 0 of what is not a number, and CUDA has none."""


def _spellings(suffix: str, real: Real) -> Mapping[Op, Spelling]:
    """Return the table of one language and type: sin or sinf."""
    calls = {op: call(f"{name}{suffix}", op.arity) for op, name in FUNCTIONS.items()}
    own = {Op.SIGN: call(SIGN_HELPER.format(real.name)), Op.SELECT: call(SELECT_HELPER.format(real.name), 3)}
    return {**OPERATORS, **calls, **own, Op.TABLE: TABLE}


def _literal(real: Real, value: Fraction) -> str:
    return f"{digits(value, real)}{real.suffix}"


def _write(draft: Draft) -> dict[str, str]:
    """Return both spellings of the kernels."""
    program, real = draft.program, draft.real
    values = {
        "about": draft.about,
        "stem": draft.stem,
        "real": real.name,
        "suffix": real.suffix,
        "most": BLOCKS[0],
        "waiting": WAITING,
        "size": SIZES[real.name],
        "common": Program.PREPARED if program.is_prepared else Program.PARAMS,
        "prepared": program.is_prepared,
        "uses_sign": any(Op.SIGN in function.operations for function in draft.page.functions),
        "uses_select": any(Op.SELECT in function.operations for function in draft.page.functions),
    }
    files, runs = {}, budgets(program, real)
    named = {one: f"{draft.stem}_{name}_{real.name}" for one, name in draft.printer.tables.items()}
    for ending, spelled in ((".cu", draft.printer), (".cl", Printer(_spellings("", real), partial(_literal, real)))):
        printer = replace(spelled, tables=named)
        values["page"] = page = compose(program, printer, draft.page.command, draft.page.first, GPU.keywords)
        values["kernels"] = made = kernels(program, page.functions, runs, printer)
        values["many"] = any(kernel.again for kernel in made)
        values["divided"] = next((kernel for kernel in made if len(kernel.parts) > 1), None)
        values["zero"], values["one"] = _literal(real, Fraction(0)), _literal(real, Fraction(1))
        files[f"{draft.stem}{ending}"] = render(f"gpu/kernels{ending}.jinja", values)
    return files


STATES = 1000
"""As many as fill several blocks, the last of them in part."""


@dataclass(frozen=True)
class Launched:
    """One kernel of the example."""

    call: Called  # its name, what it is given, what must come out
    single: bool  # whether it runs for one state, since what the others have in common is all that it takes
    kept: bool  # whether other kernels read what comes out
    block: int  # threads of a block
    parts: int  # rows of blocks
    required: bool  # whether a group must have so many


def files_beside(sources: Sources) -> dict[str, str]:
    """Return an example for each spelling, which knows what must come out."""
    opening, real = stem(sources.program.scene.name), find_real(sources.real)
    made = worked_example(sources, real.suffix)
    runs = dict(zip(sources.functions, budgets(sources.program, real), strict=True))
    values = {
        "stem": opening,
        "real": real.name,
        "dtype": real.dtype,
        "suffix": real.suffix,
        "states": STATES,
        "given": [(one, _plain(one.name) in (Program.PARAMS, Program.PREPARED)) for one in made.given],
        "launched": [_launched(call, runs[call.name]) for call in made.called],
        "left_out": made.left_out,
    }
    return {f"{opening}_main{ending}": render(f"gpu/main{ending}.jinja", values) for ending in (".cu", ".py")}


GPU = Target(
    name="gpu",
    title="GPU",
    text="kernels for CUDA and OpenCL, one state a thread",
    reals=SINGLE,
    files={"{stem}.cu": str, "{stem}.cl": str},
    keywords=frozenset(),  # every kernel begins with the name of the scene
    printer=lambda real: Printer(_spellings(real.suffix, real), partial(_literal, real)),
    comment=in_comment,
    write=_write,
    beside=files_beside,
)


def _launched(call: Called, room: Budget) -> Launched:
    names = [_plain(name) for name in call.arguments]
    common = {Program.PARAMS, Program.PREPARED}.intersection(names)
    single = bool(common) and not shared(names)
    return Launched(call, single, call.name == Program.PREPARE, room.block, len(room.plans), required=room.places > 0)


def _plain(name: str) -> str:
    """Return an argument's name without the length that tells two of one name apart."""
    head, _, tail = name.rpartition("_")
    return head if head and tail.isdigit() else name


END = "_launch"
"""How the name of a launcher ends, behind the name of its kernel."""


def launchers(sources: Sources) -> dict[str, str]:
    """Return the kernels of sources of target "gpu" with a launcher each, for CUDA, as one file by its name."""
    name = stem(sources.program.scene.name)
    listed = [
        {
            "name": f"{name}_{spelled}",
            "arguments": len(routine.function.arguments),
            "block": room.block,
            "parts": len(room.plans),
        }
        for spelled, routine, room in zip(
            sources.functions, sources.program.routines, budgets(sources.program, find_real(sources.real)), strict=True
        )
    ]
    values = {"real": sources.real, "kernels": listed, "end": END}
    text = f"{sources.texts[f'{name}.cu']}\n{render('gpu/launchers.cu.jinja', values)}"
    return {f"{name}.cu": text}
