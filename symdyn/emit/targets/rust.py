"""The Rust target: a module that needs `core` alone, one function an output, one state a call.

    mod two_link;
    let mut tau = [0.0; 2];
    two_link::inverse_dynamics(&q, &qd, &qdd, &params, &mut tau);

Lengths are in the types. With option "batch", `inverse_dynamics_rows` takes slices of such arrays; loops over the
states of a block become vector code, as in C.

Rust never fuses a product with a sum by itself: sums of products call `fma`, which is one operation where the target
has it. What `core` lacks (square root, exponential, ...) stands in the file where it is called. Sines and cosines are
those of the C target's batches, with the same bits where that computes them itself, below 2^20, and is optimised.

Larger angles are reduced here, too, with 2/π in words of 64 bits. Of m 2^e 2/π only the remainder by 4 counts. Bits of
2/π that make it larger than that by m 2^e alone are skipped, 192 of those that follow are multiplied by m, and 126 bits
of the fraction stay. Doubles come no nearer to a multiple of π/2 than 2^-62, so that 64 bits are right.

Reference: Payne and Hanek, Radian reduction for trigonometric functions, SIGNUM Newsletter 18 (1983).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from functools import cache, partial
from math import prod

from symdyn.emit.code.spelling import ATOM, OPERATORS, SIGN, SINGLE, TABLE, Printer, Spelling, call, digits
from symdyn.emit.code.target import BATCH, Draft, FunctionText, Page, Sources, Target
from symdyn.emit.render import in_comment, render
from symdyn.emit.targets.c.cuts import STACK, cuts, length_of, writer_of
from symdyn.emit.targets.c.plan import LONGEST, LONGEST_LOOP, WIDEST_LOOP, SineCosine
from symdyn.emit.targets.c.writer import Layout, PassText, sincos_values
from symdyn.errors import EmitError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op
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
    """One function over the states of a block."""

    lanes: int  # how many there are; 0 where states are taken one at a time
    rows: int  # of work space
    stages: tuple[PassText | Turn, ...]  # loops, and sines and cosines between them, in running order
    common: str  # the argument that all states share; "" for none


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


FMA = "fma({}, {}, {})"
"""a b + c, which the file defines: rounded once where the machine does that."""


@dataclass(frozen=True)
class FusedPrinter(Printer):
    """Writes a b + c, a b - c and c - a b as a call of `fma`; of two products the right one is fused."""

    def _written(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        if node.op not in (Op.ADD, Op.SUB):
            return super()._written(node, names, constants)
        free = [arg.op is Op.MUL and arg not in names and arg not in constants for arg in node.args]
        if not any(free):
            return super()._written(node, names, constants)
        left, right = node.args
        product, other = (right, left) if free[1] else (left, right)
        a, b = product.args
        bound = {x: self._bound(x, names, constants) for x in (a, b, other)}
        first, last = bound[a][0], bound[other][0]
        if node.op is Op.SUB and free[1]:
            first = _negative(*bound[a])
        elif node.op is Op.SUB:
            last = _negative(*bound[other])
        return FMA.format(first, bound[b][0], last), ATOM


def _negative(text: str, binds: int) -> str:
    """Return the text of the negative: a sign wants an atom, and two signs are none."""
    if binds == SIGN and text.startswith("-"):
        return text[1:]
    return f"-{text}" if binds == ATOM else f"-({text})"


WORDS = 20
"""The first is 0, so that a window may begin before the point; doubles end at 2^1024."""


@cache
def words() -> tuple[str, ...]:
    """Return the words as hexadecimal numbers."""
    import mpmath

    bits = 64 * (WORDS - 1)
    with mpmath.workprec(bits + 64):
        digits = int(mpmath.floor(mpmath.ldexp(2 / mpmath.pi, bits)))
    return tuple(f"0x{digits >> 64 * place & (1 << 64) - 1:016x}" for place in reversed(range(WORDS)))


OWN = {
    Op.SQRT: "sqrt_of",
    Op.EXP: "exp_of",
    Op.LOG: "log_of",
    Op.TANH: "tanh_of",
    Op.ABS: "abs_of",
    Op.SIGN: "sign_of",
    Op.ATAN2: "atan2_of",
    Op.SELECT: "select_of",
}
"""Functions of our own, written there when they are called."""

ALONE = ("sine_of", "cosine_of")
"""Of an angle that no state changes, such as one of parameters: all others are taken together."""

SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    Op.SIN: call(ALONE[0]),
    Op.COS: call(ALONE[1]),
    **{op: call(name, op.arity) for op, name in OWN.items()},
    Op.TABLE: TABLE,
}

PARTS = {
    "ln2": (0.6931471803691238, 1.9082149292705877e-10),
    "quarter_pi": (0.7853981633974483, 3.061616997868383e-17),
    "half_turn": (1.5707963267948966, 6.123233995736766e-17),
    "turn": (3.141592653589793, 1.2246467991473532e-16),
}
"""Numbers in two parts; the first of log 2 has 32 bits, so that multiples of it are exact."""

TYPES = {"double": "f64", "float": "f32"}

KEYWORDS = """Self abstract as async await become box break const continue crate do dyn else enum extern false final fn
for gen if impl in let loop macro match mod move mut override priv pub ref return self static struct super trait true
try type typeof unsafe unsized use virtual where while yield
abs_of atan2_of atan2_of_double cosine_of exp_of exp_of_double far fma fma_double is_large log_of log_of_double near
product select_of sign_of sincos sine_of sqrt_by_digits sqrt_of sqrt_of_double table_of tanh_of tanh_of_double turned"""
"""Reserved words, and what the module itself calls by its name."""


def _write(draft: Draft) -> dict[str, str]:
    codes = cuts(draft.program, draft.page, draft.printer, few=1, address="&[{}]")
    batch = draft.option == BATCH
    operations = {op for function in draft.page.functions for op in function.operations}
    sines, fma = sincos_values(draft.real.name), "fma" if draft.real.name == "double" else "fma_double"
    values = {
        "page": draft.page,
        "about": draft.about,
        "stem": draft.stem,
        "real": TYPES[draft.real.name],
        "codes": codes,
        "batch": batch,
        "blocks": blocks(draft.program, draft.page, draft.printer, 8 if draft.real.bits > 24 else 4) if batch else (),
        "operations": {op.name for op in operations},
        "sincos": any(many and many.sincos for many in codes),
        "alone": (),
        "two_over_pi_words": words(),
        **PARTS,
        **sines,
        **{name: _nested(sines[name].replace("[j]", ""), fma) for name in ("sine", "cosine")},
    }
    text = render("rust/module.rs.jinja", values)
    alone = tuple(name for name in ALONE if f"{name}(" in text)
    if alone:
        text = render("rust/module.rs.jinja", {**values, "alone": alone, "sincos": True})
    return {f"{draft.stem}.rs": text}


def _nested(horner: str, fma: str) -> str:
    """Return c0 + h * (c1 + h * (...)) as fma(h, fma(h, ..., c1), c0)."""
    *low, top = re.findall(r"-?\d[\d.]*(?:e[+-]?\d+)?", horner)
    text = str(top)
    for coefficient in reversed(low):
        text = f"{fma}(h, {text}, {coefficient})"
    return text


def _beside(sources: Sources) -> dict[str, str]:
    """Return an example that knows what must come out."""
    from symdyn.emit.code.worked_example import example_text

    return example_text(sources, "rust/main.rs.jinja", ".rs", real=TYPES[sources.real])


RUST = Target(
    name="rust",
    title="Rust",
    text="a module of Rust that needs core alone, no_std",
    reals=SINGLE,
    options={BATCH: "functions over many states too, as slices of arrays"},
    files={"{stem}.rs": str},
    keywords=frozenset(KEYWORDS.split()),
    lacks={Op.POW: "core has no powers; write x*sqrt(x) for x**1.5, or take another target"},
    printer=lambda real: FusedPrinter(SPELLINGS, partial(digits, real=real)),
    comment=partial(in_comment, prefix="// "),
    write=_write,
    beside=_beside,
)
