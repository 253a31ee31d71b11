"""The C++ target: one header of C++17, templates over the type of a number, without allocation and without libraries.

    auto tau = <scene>::inverse_dynamics(q, qd, qdd, params)         std::array<T, n>, lengths checked by types
    <scene>::raw::inverse_dynamics(q, qd, qdd, params, out)          addresses, as in C

T is double, float, or any type with + - * / and comparison, a constructor from double, and sin, cos, ... of its own
beside it, where argument-dependent lookup finds them: dual numbers, intervals, packs of states. Results come back by
value, which costs no copy. Where Eigen is included, fixed vectors and maps of it are taken, too.

With option "batch" <scene>::raw has functions over many states, as C has them: templates for packs of states, which are
plain arrays; -O3 makes vectors of them. Entry i of state k is q[i * n + k] for `_batch`, q[k * length + i] for `_rows`.

Functions of several angles take sines and cosines of doubles and floats by our own routine, that of the C target's
batches; long ones are cut into parts, as they are in C.
"""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.emit.code.identifiers import names_of_c, stem
from symdyn.emit.code.operators import OPERATORS, Printer, Spelling, call
from symdyn.emit.code.real import digits
from symdyn.emit.code.target import BATCH, Draft, FunctionText, Sources, Target
from symdyn.emit.render import in_comment, render
from symdyn.emit.targets.c.cuts import FEW, CutText, cuts
from symdyn.emit.targets.c.writer import CHAINS, sincos_values
from symdyn.graph import Op
from symdyn.program import Program

BY_LOOKUP = {
    Op.SIN: "sin",
    Op.COS: "cos",
    Op.SQRT: "sqrt",
    Op.EXP: "exp",
    Op.LOG: "log",
    Op.TANH: "tanh",
    Op.ABS: "abs",
    Op.ATAN2: "atan2",
}
"""Functions of <cmath>, or those beside the type of a number."""

SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(name) for op, name in BY_LOOKUP.items()},
    Op.EXP: call("own::exp_of"),
    Op.SIGN: call("own::sign_of"),
    Op.ATAN2: call("atan2", 2),
}

LANES = 32
"""States in a pack: whole vectors of doubles and floats, and few enough for the nearest cache."""

KEYWORDS = """alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t
class co_await co_return co_yield compl concept const const_cast consteval constexpr constinit continue decltype default
delete do double dynamic_cast else enum explicit export extern false final float for friend goto if import inline int
long module mutable namespace new noexcept not not_eq nullptr operator or or_eq override private protected public
register reinterpret_cast requires return short signed sizeof static static_assert static_cast struct switch template
this thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor
xor_eq Eigen HUGE_VAL INFINITY NAN NULL T linux own raw std unix"""
"""Reserved words, macros of compilers and of the headers, and what the header itself calls by its name."""


def namespace(name: str) -> str:
    """Return the namespace of the header `<name>.hpp`, which no header of C calls anything by."""
    return f"{name}_" if name in CPP.keywords else name


def _write(draft: Draft) -> dict[str, str]:
    """Return the header."""
    codes = cuts(draft.program, draft.page, draft.printer, few=FEW)
    batch = draft.option == BATCH
    operations = {op for function in draft.page.functions for op in function.operations}
    values = {
        "page": draft.page,
        "about": draft.about,
        "stem": draft.stem,
        "space": namespace(draft.stem),
        "codes": codes,
        "uses_sign": Op.SIGN in operations,
        "uses_exp": Op.EXP in operations,
        "batch": batch,
        "widths": [_lanes(text, many) for text, many in zip(draft.page.functions, codes, strict=True)],
        "lanes": LANES,
        "common": Program.PREPARED if draft.program.is_prepared else Program.PARAMS,
        "cut": any(many and many.parts for many in codes),
        "sincos": batch or any(many and many.sincos for many in codes),
        "chains": CHAINS,
        "reals": [{"real": real, **sincos_values(real)} for real in ("double", "float")],
        "lookups": {op.name: name for op, name in BY_LOOKUP.items()},
    }
    return {f"{draft.stem}.hpp": render("cpp/header.hpp.jinja", values)}


def _lanes(text: FunctionText, many: CutText | None) -> int:
    """Return how many states of a function run side by side; 0 for a long one, whose parts would compile for long."""
    return 0 if many and many.parts else LANES


def _beside(sources: Sources) -> dict[str, str]:
    """Return an example that knows what must come out."""
    from symdyn.emit.code.worked_example import example_text

    space = namespace(stem(sources.program.scene.name))
    return example_text(sources, "cpp/main.cpp.jinja", ".cpp", space=space)


CPP = Target(
    name="cpp",
    title="C++",
    text="one header of C++17 with templates: double, float, dual numbers; Eigen where it is included",
    reals=("double",),
    options={BATCH: "functions over many states too, fit for vector code"},
    files={"{stem}.hpp": str},
    first=0,
    keywords=frozenset(KEYWORDS.split()) | names_of_c(),
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: Printer(SPELLINGS, lambda value: f"T({digits(value, real)})"),
    comment=in_comment,
    write=_write,
    beside=_beside,
    shortens=(),
    loops=False,
)
