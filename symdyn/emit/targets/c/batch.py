"""What the templates of batch code are given: the stages of every function as finished text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod

from symdyn.emit.code.operators import Printer
from symdyn.emit.code.real import Real
from symdyn.emit.code.source_text import ArgumentText, FunctionText, Page
from symdyn.emit.targets.c.cuts import by_address, handed_on, length_of, parts_of, up_to_rows, writer_of
from symdyn.emit.targets.c.gathered import LANES, gathered
from symdyn.emit.targets.c.plan import SineCosine
from symdyn.emit.targets.c.row_solve import RowSolveText
from symdyn.emit.targets.c.sincos import LANES_AT_ONCE
from symdyn.emit.targets.c.stages import LONGEST, longest_loop
from symdyn.emit.targets.c.writer import LANED, PassText, ScalarStage
from symdyn.errors import EmitError
from symdyn.program import Program, Routine, shared

FEWEST = 32
"""States in the block of a long function, even if it leaves the nearest cache: fewer are slower."""

CACHE = 32 * 1024
"""Bytes that a block and its states should not exceed: the nearest cache."""

STACK = 512 * 1024
"""Bytes of stack that a block may take; functions that need more halve it, and at last run state by state."""

VECTOR = 16
"""States in the smallest block: one vector of floats, two of doubles."""

ALIAS = 2048
"""Columns a multiple of so many bytes apart compete for few places of a cache."""

FEW = 3
"""Angles of one state from which they are taken together."""


@dataclass(frozen=True)
class BatchText:
    """One function over many states.

    Attributes:
        function: the same for one state.
        states: arguments that differ from state to state, with the row of a block where each starts.
        length: entries of these arguments.
        size: entries of the result.
        lanes: states of a block; 0 where the function is too large for blocks, or runs once in a while.
        together: states whose columns are copied at once, some blocks of them.
        reach: how far rows of a block's result are apart, while it waits to be copied.
        held: how many of these rows there are.
        zeros: whether the last of them holds zeros.
        places: of each entry of the result, the row that it is; () where every entry has its own.
        direct: whether a block may write where the result has to go.
        rows: rows of work space.
        passes: the loops.
        calls: statements of the block function, in running order.
        kept: rows of work space of the scalar function.
        scalar: stages of the scalar function; () leaves it as it is without batch code.
        results: entries of the result, as these stages name them.
        parts: functions of their own that a long scalar function is cut into; () for a short one.
        cleared: whether these leave out entries that are zero.
        aliased: columns of a multiple of so many states stand ALIAS bytes apart; 0 where that does no harm.
        single: at most so many states are not worth a block.
        columns, later, block, row, state: what is handed on: where block k starts among columns, and the one j states
            later, in a block of our own, where state k stands among rows, in a state of our own.
        sincos: whether it takes sines and cosines by a routine of our own.
        solve: what follows the parts in a loop over rows; None where they are all there is.
    """

    function: FunctionText
    states: tuple[tuple[ArgumentText, int], ...]
    length: int
    size: int
    lanes: int
    together: int
    reach: int
    held: int
    zeros: bool
    places: tuple[int, ...]
    direct: bool
    rows: int
    passes: tuple[PassText, ...]
    calls: tuple[str, ...]
    kept: int
    scalar: tuple[ScalarStage, ...]
    results: tuple[str, ...]
    parts: tuple[PassText, ...]
    cleared: bool
    aliased: int
    single: int
    columns: str
    later: str
    block: str
    row: str
    state: str
    sincos: bool
    solve: RowSolveText | None


def batches(program: Program, page: Page, printer: Printer, real: Real, lockstep: bool) -> tuple[BatchText | None, ...]:
    """Return the batch code of every function of the page, None for one that is a loop over a table.

    Where sines and cosines are taken in `lockstep`, neighbouring rows of angles are handed over together.

    Raises:
        EmitError: a function is called as the batch code of another one will be.
    """
    _check_names([function.name for function in page.functions])
    return tuple(
        None if text.loop else _batch(routine, text, program, printer, 4 if real.suffix else 8, lockstep)
        for routine, text in zip(program.routines, page.functions, strict=True)
    )


def _check_names(names: Sequence[str]) -> None:
    for name in names:
        for ending in ("_batch", "_rows"):
            if name + ending in names:
                raise EmitError(f"function {name}{ending} would be called as batch code of {name} is; rename it")


def _batch(
    routine: Routine, text: FunctionText, program: Program, printer: Printer, width: int, lockstep: bool
) -> BatchText:
    single = writer = writer_of(routine, text, program, printer, LONGEST, length_of(routine) > LONGEST)
    longest = longest_loop(text.shape, length_of(routine), writer.plan.loads)
    if longest != LONGEST and length_of(routine) > min(longest, LONGEST):
        writer = writer_of(routine, text, program, printer, longest, length_of(routine) > longest)
    made = writer.plan
    states, length = [], 0
    names = [argument.name for argument in text.arguments]
    common = shared(names)
    for argument in text.arguments:
        if argument.name != common:
            states.append((argument, length))
            length += argument.length
    size = prod(text.shape)
    # in prepare blocks would not pay, and loops over so many arrays compile slowly
    once = not common and Program.PARAMS in names
    result = gathered(routine, program, width)
    several = writer.several() if lockstep else ()
    rows = max(made.rows, 2 * len(several) + min(len(several), LANES_AT_ONCE))
    lanes = _lanes((length + result.rows) * width, rows * width) if size and not once else 0
    together = result.states(lanes, width, STACK - lanes * (length + rows) * width)
    passes: list[PassText] = []
    calls: list[str] = []
    if several and lanes:
        calls.append(f"sincos_rows({len(several)}, {lanes}, stride, {writer.row(several[0])}, w);")
    for stage in made.stages[len(several) :] if lanes else ():
        if isinstance(stage, SineCosine):
            calls.append(f"sincos_row({lanes}, {writer.row(stage)}, w[{stage.sine[1]}], w[{stage.cosine[1]}]);")
        else:
            passes.append(writer.loop(stage, len(passes) + 1, LANED, result.written))
            work = "w" if rows else "0"
            calls.append(f"{text.name}_pass{len(passes)}(stride, reach, {handed_on(text, {})}{work}, out);")
    before = up_to_rows(routine, printer, True)
    single = before.writer if before else single
    parts = before.parts if before else parts_of(single, cleared=True)
    if parts:
        scalar = single.scalar_calls(by_address(text), together=True)
    else:
        angles = sum(isinstance(stage, SineCosine) for stage in single.plan.stages)
        scalar = single.scalar() if angles >= FEW else ()
    rowwise = lanes > 0 and any(isinstance(stage, SineCosine) for stage in made.stages)
    return BatchText(
        function=text,
        states=tuple(states),
        length=length,
        size=size,
        lanes=lanes,
        together=together,
        reach=result.reach(together, width),
        held=result.rows,
        zeros=result.zeros,
        places=result.places,
        direct=result.direct,
        rows=rows,
        passes=tuple(passes),
        calls=tuple(calls),
        kept=single.plan.rows,
        scalar=scalar,
        parts=parts,
        cleared=any(map(single.zero, range(len(single.routine.function.entries)))),
        results=() if parts else tuple(single.entry(place) for place in range(size)),
        aliased=ALIAS // width if result.wide else 0,
        single=lanes // 8,
        columns=handed_on(text, {a.name: f"{a.name} + k" for a, _ in states}),
        later=handed_on(text, {a.name: f"{a.name} + k + j" for a, _ in states}),
        block=handed_on(text, {a.name: f"b + {row * lanes}" for a, row in states}),
        row=handed_on(text, {a.name: f"{a.name}[k]" if a.scalar else f"{a.name} + k * {a.length}" for a, _ in states}),
        state=handed_on(text, {a.name: f"b[{row}]" if a.scalar else f"b + {row}" for a, row in states}),
        sincos=bool(scalar) or rowwise,
        solve=before.solve if before else None,
    )


def _lanes(copied: int, work: int) -> int:
    """Return how many states a block has; 0 where even the smallest block would take too much stack.

    `copied` bytes of a state and its result stand in the block and where they come from, `work` in work space.
    """
    lanes = LANES
    while lanes > FEWEST and lanes * (2 * copied + work) > CACHE:
        lanes //= 2
    while lanes > VECTOR and lanes * (copied + work) > STACK:
        lanes //= 2
    return lanes if lanes * (copied + work) <= STACK else 0
