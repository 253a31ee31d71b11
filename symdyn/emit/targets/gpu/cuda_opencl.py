"""The GPU target: kernels for CUDA and for OpenCL, in double or float, one state a thread.

    <scene>.cu    __global__ void <scene>_<function>(size_t n, const real *q, ..., const real *params, real *out)
    <scene>.cl    __kernel void <scene>_<function>(ulong n, __global const real *q, ..., __global real *out)

Both hold the same lines; they differ in how a kernel is opened, how it finds its state, and how sine and cosine are
taken together. Entry i of state k is x[i * n + k], in `out` likewise; params, or what was prepared from it, is one set
for all states, behind a pointer as everything else, so that another set needs no other symbol: all threads of a warp
read one number at a time, which caches hand to all of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import partial

from symdyn.emit.code.operators import OPERATORS, Printer, Spelling, call
from symdyn.emit.code.real import SINGLE, Real, digits
from symdyn.emit.code.source_text import compose
from symdyn.emit.code.target import Draft, Sources, Target
from symdyn.emit.escape import in_comment
from symdyn.emit.render import render
from symdyn.emit.targets.gpu.kernels import WAITING, budgets, kernels
from symdyn.emit.targets.gpu.resource_budget import BLOCKS, SIZES
from symdyn.graph import Op
from symdyn.program import Program

FUNCTIONS: Mapping[Op, str] = {
    Op.SIN: "sin",
    Op.COS: "cos",
    Op.SQRT: "sqrt",
    Op.EXP: "exp",
    Op.LOG: "log",
    Op.TANH: "tanh",
    Op.ABS: "fabs",
    Op.ATAN2: "atan2",
}
"""As OpenCL calls them for every type, and CUDA for doubles."""

SIGN_HELPER = "symdyn_sign_of_{}"
"""A function of our own, one a type: OpenCL's sign makes 0 of what is not a number, and CUDA has none."""


def _spellings(suffix: str, real: Real) -> Mapping[Op, Spelling]:
    """Return the table of one language and type: sin or sinf."""
    calls = {op: call(f"{name}{suffix}", op.arity) for op, name in FUNCTIONS.items()}
    return {**OPERATORS, **calls, Op.SIGN: call(SIGN_HELPER.format(real.name))}


def _literal(real: Real, value: Fraction) -> str:
    return f"{digits(value, real)}{real.suffix}"


def _cuda(real: Real) -> Printer:
    return Printer(_spellings(real.suffix, real), partial(_literal, real))


def _opencl(real: Real) -> Printer:
    return Printer(_spellings("", real), partial(_literal, real))


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
    }
    files, runs = {}, budgets(program, real)
    for ending, printer in ((".cu", draft.printer), (".cl", _opencl(real))):
        page = compose(program, printer, draft.page.command, draft.page.first, GPU.keywords)
        values["kernels"] = made = kernels(program, page.functions, runs, printer)
        values["many"] = any(kernel.again for kernel in made)
        values["divided"] = next((kernel for kernel in made if len(kernel.parts) > 1), None)
        values["zero"], values["one"] = _literal(real, Fraction(0)), _literal(real, Fraction(1))
        files[f"{draft.stem}{ending}"] = render(f"gpu/kernels{ending}.jinja", values)
    return files


def _beside(sources: Sources) -> dict[str, str]:
    """Return an example for each spelling, which knows what must come out."""
    from symdyn.emit.targets.gpu.example import files_beside

    return files_beside(sources)


GPU = Target(
    name="gpu",
    title="GPU",
    text="kernels for CUDA and OpenCL, one state a thread",
    reals=SINGLE,
    options={},
    files={"{stem}.cu": str, "{stem}.cl": str},
    first=0,
    keywords=frozenset(),  # every kernel begins with the name of the scene
    lacks={},
    functions=None,
    tunes=False,
    printer=_cuda,
    comment=in_comment,
    write=_write,
    beside=_beside,
    shortens=(),
    loops=False,
)
