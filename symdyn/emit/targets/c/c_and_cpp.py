"""The targets C and C++, without allocation.

C is C99 that needs libm alone; one function an output, in double or float.

    void <scene>_<function>(const real *q, ..., const real *params, real *out)                    one state
    void <scene>_<function>_batch(size_t n, const real *q, ..., const real *params, real *out)    structure of arrays
    void <scene>_<function>_rows(size_t n, const real *q, ..., const real *params, real *out)     array of structures

The last two come with option "batch". `ROWS`, for targets that call nothing else, leaves `_batch` out, a fifth of what
compilers take. Entry i of state k is q[i * n + k] for `_batch` and q[k * length + i] for `_rows`, in `out` likewise.
params, or what was prepared from it, is one set for all states, and `out` overlaps no argument. Both run blocks of
states through loops that compilers vectorise, and take sines and cosines by a routine of their own. The scalar function
then does the same where it needs several.

A long function calls parts of itself, since compilers take more than linear time for it. With option "header-only" all
of it is one header. Beside the code stand an example, which calls every function and compares with expected values, and
a CMake file that builds it.

C++ is one header of C++17, templates over the type of a number, without libraries.

    auto tau = <scene>::inverse_dynamics(q, qd, qdd, params)         std::array<T, n>, lengths checked by types
    <scene>::raw::inverse_dynamics(q, qd, qdd, params, out)          addresses, as in C

T is double, float, or any type with + - * / and comparison, a constructor from double, and sin, cos, ... of its own
beside it, where argument-dependent lookup finds them: dual numbers, intervals, packs of states. Results come back by
value, which costs no copy. Where Eigen is included, vectors and maps of it are taken, too.

With option "batch" <scene>::raw has functions over many states, as C has them: templates for packs of states, which are
plain arrays; -O3 makes vectors of them. Functions of several angles take sines and cosines of doubles and floats by our
own routine, that of C's batches; long ones are cut into parts, as they are in C.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from symdyn.arguments import argument
from symdyn.dynamics.outputs import CLOSED_AT_ONCE
from symdyn.emit.code.identifiers import checked, lone_header, names_of_c, stem
from symdyn.emit.code.spelling import OPERATORS, REALS, TABLE, Printer, Real, Spelling, call, digits, find_real
from symdyn.emit.code.target import BATCH, Draft, Sources, Target
from symdyn.emit.code.worked_example import example_text
from symdyn.emit.render import in_comment, render
from symdyn.emit.targets.c import double_double
from symdyn.emit.targets.c.cuts import FEW, batches, cuts
from symdyn.emit.targets.c.loops import loop_text
from symdyn.emit.targets.c.stack import STACK, allowance, stack_of
from symdyn.emit.targets.c.writer import ATAN2_HELPER, CHAINS, LANES, LINE, sincos_values
from symdyn.errors import EmitError
from symdyn.graph import ELEMENTARY, Op
from symdyn.program import Program


def _spellings(real: Real) -> Mapping[Op, Spelling]:
    """Return the table of C for one real type: sin or sinf."""
    return {
        **OPERATORS,
        Op.SIN: call(f"sin{real.suffix}"),
        Op.COS: call(f"cos{real.suffix}"),
        Op.SQRT: call(f"sqrt{real.suffix}"),
        Op.EXP: call(EXP_HELPER),
        Op.LOG: call(f"log{real.suffix}"),
        Op.TANH: call(f"tanh{real.suffix}"),
        Op.ABS: call(f"fabs{real.suffix}"),
        Op.SIGN: call(SIGN_HELPER),
        Op.ATAN2: call("atan2f" if real.suffix else ATAN2_HELPER, 2),
        Op.POW: call(f"pow{real.suffix}", 2),
        Op.SELECT: call(SELECT_HELPER, 3),
        Op.TABLE: TABLE,
    }


HEADER_ONLY = "header-only"

ROWS = "rows"
"""What other targets ask for in place of "batch": many states in rows alone."""

SIGN_HELPER, EXP_HELPER, SELECT_HELPER = "sign_of", "exp_of", "select_of"
"""Functions of our own in the source file, written there when they are called."""

FLAT = {"double": -708, "float": -87}
"""Exponents below which an exponential would be denormal, and raise underflow: it is zero there."""


def _printer(real: Real) -> Printer:
    if real.parts == 2:
        return double_double.printer_of(real)
    return Printer(_spellings(real), lambda value: f"{digits(value, real)}{real.suffix}")


def _write_c(draft: Draft) -> dict[str, str]:
    """Return source and header, or the header that is all of it."""
    program, page, printer, real = draft.program, draft.page, draft.printer, draft.real
    batch = draft.option in (BATCH, ROWS)
    if real.parts == 2:
        if allowance(draft.option) is not None:
            raise EmitError(f"functions of double-doubles keep their arrays on the stack; leave {argument(STACK)} out")
        return double_double.write(draft, batch, draft.option == HEADER_ONLY)
    operations = {op for function in page.functions for op in function.operations}
    width = 4 if real.suffix else 8
    values: dict[str, Any] = {
        "page": page,
        "about": draft.about,
        "stem": draft.stem,
        "real": real.name,
        "zero": printer.literal(Fraction(0)),
        "one": printer.literal(Fraction(1)),
        "uses_sign": Op.SIGN in operations,
        "uses_exp": Op.EXP in operations,
        "uses_atan2": Op.ATAN2 in operations and not real.suffix,
        "flat": printer.literal(Fraction(FLAT[real.name])),
        "suffix": real.suffix,
        "lanes": LANES,
        "side": LINE // width,
        "common": Program.PREPARED if program.is_prepared else Program.PARAMS,
        "batch": batch,
        "ways": ("batch", "rows") if draft.option == BATCH else ("rows",),
        "lone": draft.option == HEADER_ONLY,
    }
    wide = real.name == "double" and draft.sines is None
    codes = batches(program, page, printer, real, wide) if batch else cuts(program, page, printer, solving=True)
    values["codes"] = [
        loop_text(text.loop, [one.name for one in text.arguments], program.scene, printer, width) if text.loop else code
        for text, code in zip(page.functions, codes, strict=True)
    ]
    most = allowance(draft.option)
    values["stacks"] = [
        stack_of(f"{draft.stem}: {text.name}", code, width, batch, most)
        for text, code in zip(page.functions, values["codes"], strict=True)
    ]
    values |= {"spaced": any(stack.work for stack in values["stacks"]), "line": LINE}
    values["loops"] = any(function.loop for function in page.functions)
    values["cut"] = values["loops"] or any(many and many.parts for many in values["codes"])
    values["columns"] = batch and not all(function.loop for function in page.functions)
    lined = [many for many, text in zip(values["codes"], page.functions, strict=True) if not text.loop]
    solves = [many.solve for many in lined if many and many.solve]
    values["solves"] = not all(one.each for one in solves)
    values["paired"] = any(one.each for one in solves) or any(
        function.loop and function.loop.goes_through_pairs for function in page.functions
    )
    values["spread"] = batch and any(many.places for many in lined)
    values["drained"] = batch and not all(many.places for many in lined)
    values["sincos"] = any(many and many.sincos for many in values["codes"])
    values["rowed"] = any("sincos_rows" in call for many in lined if batch for call in many.calls)
    values |= sincos_values(real.name, draft.sines) if values["sincos"] else {}
    public = [f"{draft.stem}_{function.name}" for function in page.functions]
    if draft.option == HEADER_ONLY:
        heads = ["math", *["stdint"] * values["loops"], *["string"] * values["cut"]]
        values |= {"headers": heads, "manners": "c/manners.h.jinja"}
        body = render("c/functions.c.jinja", values).strip("\n")
        return {f"{draft.stem}.h": lone_header(body, public, values)}
    return {
        f"{draft.stem}.c": checked(render("c/source.c.jinja", values), public),
        f"{draft.stem}.h": render("c/header.h.jinja", values),
    }


def _beside_c(sources: Sources) -> dict[str, str]:
    """Return an example that knows what must come out, what builds it by CMake, and laws of contacts."""
    files = files_beside(sources, sources.option == HEADER_ONLY, sources.option == BATCH)
    return {**files, **_contact_laws(sources)}


FORCED = "contact_bias", "delassus"
"""The requests that forces of contacts are made of."""

PIVOTS = 500
"""Pivots at most, as in runs."""


def _contact_laws(sources: Sources) -> dict[str, str]:
    """Return a header with forces of contacts by Lemke's pivots, where what they are made of is there."""
    every = {one.function.request: one.function for one in sources.program.routines}
    if not {*FORCED} <= {*every}:
        return {}
    made, opening, rows = [every[one] for one in FORCED], stem(sources.program.scene.name), dict[str, list[int]]()
    for place, label in enumerate(made[0].labels[0]):  # "normal of NAME" is the first one
        rows.setdefault(label.partition(" of ")[2], []).append(place)
    turned, refused = [name for name, some in rows.items() if len(some) > 2], ""
    if sources.real != "double":
        refused = f"contact forces take doubles, and these functions are of {sources.real}: generate without --real"
    elif allowance(sources.option) is not None:
        refused = "contact forces have their work space on the stack: generate without --stack"
    elif turned:
        refused = (
            f"contacts.{turned[0]} can slip along two directions, Lemke's pivots know one: leave its friction out,"
        )
        refused += " or declare a mechanism that moves in a plane; simulate has both directions"
    m, n = len(made[0].labels[0]), 4 * min(CLOSED_AT_ONCE, len(rows))
    values = {
        "stem": opening,
        "refused": refused,
        "contacts": [(name, *[*some, -1][:2]) for name, some in rows.items()],
        "m": m,
        "size": m * m,
        "rows": n,
        "columns": 2 * n + 2,
        "stack": 8 * (n * (2 * n + 3) + m * (m + 3) + len(rows) + 72) + 12 * n,
        "pivots": PIVOTS,
        "most": CLOSED_AT_ONCE,
        "arguments": list({one.name: one for function in made for one in function.arguments}.values()),
        "taken": {function.request: [one.name for one in function.arguments] for function in made},
    }
    return {f"{opening}_contacts.h": render("c/contacts.h.jinja", values)}


C = Target(
    name="c",
    title="C",
    text="C99",
    reals=tuple(REALS),
    options={
        BATCH: "functions over many states too, fit for vector code",
        HEADER_ONLY: "one header with all of it, static inline, for C and C++",
        STACK: "at most SIZE bytes of arrays on the stack, such as 16k, or 0 for the fewest; a function that needs "
        "more takes work space",
    },
    files={"{stem}.c": str, "{stem}.h": str},
    keywords=frozenset(),  # every function begins with the name of the scene
    printer=_printer,
    comment=in_comment,
    write=_write_c,
    beside=_beside_c,
    shortens=(BATCH,),
    loops=True,
)


BUILD = "CMakeLists.txt"


def files_beside(sources: Sources, lone_header: bool, many: bool) -> dict[str, str]:
    """Return the example and the file for CMake of C sources; both are plain of what a scene says."""
    real, opening = find_real(sources.real), stem(sources.program.scene.name)
    template = "c/main.c.jinja" if real.parts == 1 else "c/dd_main.c.jinja"
    header = sources.texts.get(f"{opening}.h", "")
    spaced = [name for name in sources.functions if f"enum {{ {opening}_{name}_work = " in header]
    example = example_text(sources, template, ".c", suffix=real.suffix, real=real.name, spaced=spaced)
    (name,) = example
    values = {"stem": opening, "example": name, "lone_header": lone_header, "many": many}
    return {**example, BUILD: render("c/CMakeLists.txt.jinja", values)}


BY_LOOKUP = {op: op.name.lower() for op in (*ELEMENTARY, Op.ABS, Op.ATAN2, Op.POW)}
"""Functions of <cmath>, or those beside the type of a number."""

CPP_SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(name, op.arity) for op, name in BY_LOOKUP.items()},
    Op.EXP: call("own::exp_of"),
    Op.SIGN: call("own::sign_of"),
    Op.SELECT: call("own::select_of", 3),
    Op.TABLE: Spelling(f"own::{TABLE.pattern}", TABLE.binds, TABLE.wants),
}

PACK = 32
"""States in a pack: whole vectors of doubles and floats, and few enough for the nearest cache."""

CPP_WORDS = """alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t
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


def _write_cpp(draft: Draft) -> dict[str, str]:
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
        "widths": [0 if many and many.parts else PACK for many in codes],  # parts of a long one compile for long
        "lanes": PACK,
        "common": Program.PREPARED if draft.program.is_prepared else Program.PARAMS,
        "cut": any(many and many.parts for many in codes),
        "sincos": batch or any(many and many.sincos for many in codes),
        "chains": CHAINS,
        "reals": [{"real": real, **sincos_values(real)} for real in ("double", "float")],
        "lookups": {op.name: name for op, name in BY_LOOKUP.items()},
    }
    return {f"{draft.stem}.hpp": render("cpp/header.hpp.jinja", values)}


CPP = Target(
    name="cpp",
    title="C++",
    text="one header of C++17 with templates: double, float, dual numbers; Eigen where it is included",
    options={BATCH: "functions over many states too, fit for vector code"},
    files={"{stem}.hpp": str},
    keywords=frozenset(CPP_WORDS.split()) | names_of_c(),
    printer=lambda real: Printer(CPP_SPELLINGS, lambda value: f"T({digits(value, real)})"),
    comment=in_comment,
    write=_write_cpp,
    beside=lambda sources: example_text(
        sources, "cpp/main.cpp.jinja", ".cpp", space=namespace(stem(sources.program.scene.name))
    ),
)
