"""Functions over many states in Rust: loops over the states of a block, as C has them, with lengths in types."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

from symdyn.emit.code.operators import Printer
from symdyn.emit.code.source_text import FunctionText, Page
from symdyn.emit.targets.c.batch import STACK
from symdyn.emit.targets.c.cuts import length_of, writer_of
from symdyn.emit.targets.c.plan import SineCosine
from symdyn.emit.targets.c.stages import LONGEST, LONGEST_LOOP, WIDEST_LOOP
from symdyn.emit.targets.c.writer import Layout, PassText
from symdyn.errors import EmitError
from symdyn.program import Program, Routine, shared

LANES = 64
"""States of a block, as in C."""

LANED = Layout("{}[{}][k]", "{}[{}][k]", "w[{}][k]", ())
"""An entry of an argument or of the result, and a row of work space, are arrays over the states."""


@dataclass(frozen=True)
class Turn:
    """Sines and cosines of one row: where the angles stand, and the rows that they go to."""

    angle: str
    sine: int
    cosine: int


@dataclass(frozen=True)
class RustBlock:
    """One function over the states of a block.

    Attributes:
        lanes: how many there are; 0 where states are taken one at a time.
        rows: of work space.
        stages: loops, and sines and cosines between them, in running order.
        common: the argument that all states share; "" for none.
    """

    lanes: int
    rows: int
    stages: tuple[PassText | Turn, ...]
    common: str


def blocks(program: Program, page: Page, printer: Printer, bytes_each: int) -> tuple[RustBlock, ...]:
    """Return every function of the page as a block.

    Raises:
        EmitError: a function is called as the batch code of another one will be.
    """
    names = [function.name for function in page.functions]
    taken = next((name for name in names if f"{name}_rows" in names), "")
    if taken:
        raise EmitError(f"function {taken}_rows would be called as batch code of {taken} is; rename it")
    return tuple(
        _block(routine, text, program, printer, bytes_each)
        for routine, text in zip(program.routines, page.functions, strict=True)
    )


def _block(routine: Routine, text: FunctionText, program: Program, printer: Printer, bytes_each: int) -> RustBlock:
    names = [argument.name for argument in text.arguments]
    common, size = shared(names), prod(text.shape)
    # vectors stay whole where C cuts them (`LONGEST_OF_VECTOR`): rustc's loops ran 0.89 times as fast in pieces
    longest = LONGEST_LOOP if size <= WIDEST_LOOP else LONGEST
    writer = writer_of(routine, text, program, printer, longest, length_of(routine) > longest)
    held = writer.plan.rows + size + sum(argument.length for argument in text.arguments)
    once = not common and Program.PARAMS in names
    if not size or once or held * LANES * bytes_each > STACK:
        return RustBlock(0, 0, (), common)
    stages: list[PassText | Turn] = []
    for number, stage in enumerate(writer.plan.stages):
        if isinstance(stage, SineCosine):
            place = f"w[{stage.row}]" if stage.row is not None else "{}[{}]".format(*writer.places[stage.angle.node])
            stages.append(Turn(place, stage.sine[1], stage.cosine[1]))
        else:
            stages.append(writer.loop(stage, number, LANED))
    return RustBlock(LANES, writer.plan.rows, tuple(stages), common)
