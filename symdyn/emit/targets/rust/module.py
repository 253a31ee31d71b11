"""The row of the Rust target: a module that needs `core` alone, one function an output, one state a call.

    mod two_link;
    let mut tau = [0.0; 2];
    two_link::inverse_dynamics(&q, &qd, &qdd, &params, &mut tau);

With option "batch", `inverse_dynamics_rows` takes slices of such arrays: blocks of states go through loops that become
vector code.

Lengths are in the types. Sines and cosines are those of the C target's batches, with the same bits where that computes
them itself, below 2^20; larger angles are reduced here, too. What else `core` lacks (square root, exponential, ...)
stands in the file where it is called. Sums of products call `fma`, which is one operation where the target has it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from typing import Any

from symdyn.emit.code.operators import OPERATORS, Spelling, call
from symdyn.emit.code.real import SINGLE, digits
from symdyn.emit.code.target import BATCH, Draft, Sources, Target
from symdyn.emit.escape import in_comment
from symdyn.emit.render import render
from symdyn.emit.targets.c.cuts import cuts
from symdyn.emit.targets.c.sincos import sincos_values
from symdyn.emit.targets.rust.blocks import blocks
from symdyn.emit.targets.rust.fused import FusedPrinter
from symdyn.emit.targets.rust.two_over_pi import words
from symdyn.graph import Op

OWN = {
    Op.SQRT: "sqrt_of",
    Op.EXP: "exp_of",
    Op.LOG: "log_of",
    Op.TANH: "tanh_of",
    Op.ABS: "abs_of",
    Op.SIGN: "sign_of",
    Op.ATAN2: "atan2_of",
}
"""Functions of our own, written there when they are called."""

ALONE = ("sine_of", "cosine_of")
"""Of an angle that no state changes, such as one of parameters: all others are taken together."""

SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    Op.SIN: call(ALONE[0]),
    Op.COS: call(ALONE[1]),
    **{op: call(name) for op, name in OWN.items()},
    Op.ATAN2: call(OWN[Op.ATAN2], 2),
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
product sign_of sincos sine_of sqrt_by_digits sqrt_of sqrt_of_double tanh_of tanh_of_double turned"""
"""Reserved words, and what the module itself calls by its name."""


def _write(draft: Draft) -> dict[str, str]:
    """Return the module."""
    codes = cuts(draft.program, draft.page, draft.printer, few=1, address="&[{}]")
    batch = draft.option == BATCH
    operations = {op for function in draft.page.functions for op in function.operations}
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
        **_fused(sincos_values(draft.real.name), "fma" if draft.real.name == "double" else "fma_double"),
    }
    text = render("rust/module.rs.jinja", values)
    alone = tuple(name for name in ALONE if f"{name}(" in text)
    if alone:
        text = render("rust/module.rs.jinja", {**values, "alone": alone, "sincos": True})
    return {f"{draft.stem}.rs": text}


def _fused(values: Mapping[str, Any], fma: str) -> dict[str, Any]:
    """Return the numbers of sines and cosines with polynomials as calls of `fma`."""
    return {**values, **{name: _nested(values[name].replace("[j]", ""), fma) for name in ("sine", "cosine")}}


def _nested(horner: str, fma: str) -> str:
    """Return c0 + h * (c1 + h * (...)) as fma(h, fma(h, ..., c1), c0)."""
    *low, top = re.findall(r"-?\d[\d.]*(?:e[+-]?\d+)?", horner)
    text = str(top)
    for coefficient in reversed(low):
        text = f"{fma}(h, {text}, {coefficient})"
    return text


def _beside(sources: Sources) -> dict[str, str]:
    """Return an example that knows what must come out."""
    from symdyn.emit.code.example_text import example_text

    return example_text(sources, "rust/main.rs.jinja", ".rs", real=TYPES[sources.real])


RUST = Target(
    name="rust",
    title="Rust",
    text="a module of Rust that needs core alone, no_std",
    reals=SINGLE,
    options={BATCH: "functions over many states too, as slices of arrays"},
    files={"{stem}.rs": str},
    first=0,
    keywords=frozenset(KEYWORDS.split()),
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: FusedPrinter(SPELLINGS, partial(digits, real=real)),
    comment=partial(in_comment, prefix="// "),
    write=_write,
    beside=_beside,
    shortens=(),
    loops=False,
)
