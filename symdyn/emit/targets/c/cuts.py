"""Functions of one state in parts, and what else is asked of a routine before its stages are printed.

Templates of batch code are given the stages of every function, and the loop over rows of one that solves, as finished
text.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import chain
from math import isqrt, prod

from symdyn.emit.code.spelling import Printer, Real
from symdyn.emit.code.target import ArgumentText, FunctionText, Page
from symdyn.emit.targets.c.pair_runs import PairRunsText, pair_runs_text
from symdyn.emit.targets.c.plan import LONGEST, Pass, SineCosine, longest_loop, plan
from symdyn.emit.targets.c.writer import LANED, LANES, LANES_AT_ONCE, SINGLE, PassText, ScalarStage, Writer, gathered
from symdyn.errors import EmitError
from symdyn.frozen import dataclass
from symdyn.program import Program, Routine, RowLoop, shared

LARGEST = 1 << 16
"""Numbers of tables, which are short ones, are smaller."""

UNDER_WAY = 8
"""Vectors of a row that are computed side by side, at most: their sums stay in registers."""


@dataclass(frozen=True)
class RowSolveText:
    """A loop over rows.

    Attributes:
        size: entries of what lines leave for it.
        table: how many columns of a row it goes over, then of every step row, scale, how many terms, and factor and row
            of each.
        vectors: how many of a row are computed side by side, as long as there are so many; one by one at last.
        copies: (to, from, count) of entries that stand side by side in the result and where it is found.
        switched: whether terms whose factors are zero are left out.
        turned: of rows plus the same, turned: how many, then places of that and of what is added there; () elsewhere.
    """

    size: int
    table: tuple[int, ...]
    vectors: tuple[int, ...]
    copies: tuple[tuple[int, int, int], ...]
    switched: bool = False
    turned: tuple[int, ...] = ()
    each: int = 0


def row_solve_text(rows: RowLoop) -> RowSolveText:
    """Return the loop over rows."""
    table = [rows.width] + [
        number
        for step in rows.steps
        for number in (step.row, step.scale, len(step.terms), *(one for term in step.terms for one in term))
    ]
    copies: list[list[int]] = []
    for to, place in enumerate(rows.places if rows.turned is None else ()):
        if copies and place == copies[-1][1] + copies[-1][2]:
            copies[-1][2] += 1
        else:
            copies.append([to, place, 1])
    told = tuple((to, place, count) for to, place, count in copies)
    shares = -(-rows.vectors // UNDER_WAY)
    largest = -(-rows.vectors // shares)  # shares as equal as may be
    sizes = tuple(sorted({largest, rows.vectors - largest * (shares - 1), 1}, reverse=True))
    turned = () if rows.turned is None else (isqrt(len(rows.places)), *chain(*rows.turned))
    return RowSolveText(len(rows.entries), tuple(table), sizes, told, rows.switched, turned)


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
    solve: RowSolveText | PairRunsText | None = None


def cuts(
    program: Program, page: Page, printer: Printer, few: int | None = None, address: str = "&{}", solving: bool = False
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
    solve: RowSolveText | PairRunsText


def up_to_rows(routine: Routine, printer: Printer, short: bool) -> UpToRows | None:
    """Return a function in parts up to a loop over rows; None where it has none, or nothing to be cut before it.

    As to `short` see `plan`.
    """
    rows = RowLoop.of(routine.function)
    if rows is None or len(rows.entries) >= LARGEST:  # which no table holds
        return None
    (before,) = rows.program.routines
    writer = writer_of(before, None, rows.program, printer, LONGEST, short and length_of(before) > LONGEST)
    parts = parts_of(writer, cleared=True)
    if not parts:
        return None
    return UpToRows(writer, parts, row_solve_text(rows) if isinstance(rows, RowLoop) else pair_runs_text(rows, printer))


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
    solve: RowSolveText | PairRunsText | None


def batches(program: Program, page: Page, printer: Printer, real: Real, lockstep: bool) -> tuple[BatchText | None, ...]:
    """Return the batch code of every function of the page, None for one that is a loop over a table.

    Where sines and cosines are taken in `lockstep`, neighbouring rows of angles are handed over together.

    Raises:
        EmitError: a function is called as the batch code of another one will be.
    """
    names = [function.name for function in page.functions]
    for name in names:
        for ending in ("_batch", "_rows"):
            if name + ending in names:
                raise EmitError(f"function {name}{ending} would be called as batch code of {name} is; rename it")
    return tuple(
        None if text.loop else _batch(routine, text, program, printer, 4 if real.suffix else 8, lockstep)
        for routine, text in zip(program.routines, page.functions, strict=True)
    )


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
