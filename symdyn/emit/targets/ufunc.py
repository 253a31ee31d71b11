"""The ufunc target: a Python extension module of NumPy generalized ufuncs over the C target, in double and in float.

Core dimensions are frozen, `(7),(7),(7)->(7)`, so that NumPy itself refuses a wrong length, broadcasts, casts, takes
`out=` and lets go of the interpreter's lock. The C is that of target "c", under names of its own for each real type.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symdyn.emit.code.real import REALS
from symdyn.emit.code.source_text import FunctionText, Page
from symdyn.emit.code.target import Contents, Draft, Target, alone
from symdyn.emit.render import render
from symdyn.emit.targets.c.c99 import ROWS, C
from symdyn.errors import EmitError
from symdyn.program import shared

TAGS: Mapping[str, str] = {"float": "f32", "double": "f64"}
"""In the order in which NumPy tries them: the first type that all operands fit is taken."""

CODES: Mapping[str, str] = {"float": "NPY_FLOAT", "double": "NPY_DOUBLE"}

MODULE = "_ufunc"
"""What the extension module adds to the name of the scene."""

DOUBLES = "doubles"
"""Option: without float."""


def _write(draft: Draft) -> dict[str, Contents]:
    """Return the extension module's source, then the C that it calls."""
    page = draft.page
    usable = tuple(f for f in page.functions if 0 not in (*f.shape, *(a.length for a in f.arguments)))
    files: dict[str, Contents] = {}
    loops = []
    for name, tag in TAGS.items():
        if draft.option == DOUBLES and name != draft.real.name:
            continue
        renamed = replace(draft.program, scene=replace(draft.program.scene, name=f"{draft.stem}_{tag}"))
        try:
            sines = draft.sines if name == draft.real.name else None  # float is no nearer than they
            code = C.draft(renamed, REALS[name], page.command, ROWS, sines)
        except EmitError:
            if name == draft.real.name:
                raise
            continue  # a constant is too large for float: NumPy then casts to double
        files |= C.write(code)
        loops.append({"name": name, "tag": tag, "code": CODES[name], "stem": code.stem, "loop": f"walk_{tag}"})
    values = {
        "about": draft.about,
        "module": f"{draft.stem}{MODULE}",
        "functions": tuple(_ufunc(page, function) for function in usable),
        "left_out": tuple(function.name for function in page.functions if function not in usable),
        "reals": loops,
        "operands": 1 + max((len(function.arguments) for function in usable), default=0),
        "rank": max((1, *(len(function.shape) for function in usable))),
    }
    return {f"{draft.stem}{MODULE}.c": render("ufunc/module.c.jinja", values), **files}


def _ufunc(page: Page, function: FunctionText) -> dict[str, object]:
    """Return what the template needs of a function: "params" is the place of what all states have in common, or -1."""
    names = [argument.name for argument in function.arguments]
    common = shared(names)
    inputs = ",".join(f"({argument.core})" for argument in function.arguments)
    return {
        "name": function.name,
        "arguments": function.arguments,
        "shape": function.shape,
        "size": len(function.outputs),
        "signature": f"{inputs}->({','.join(map(str, function.shape))})",
        "params": names.index(common) if common else -1,
        "doc": [_literal(line) for line in docstring(page, function).splitlines(keepends=True)],
    }


def docstring(page: Page, function: FunctionText) -> str:
    """Return what `help` says about one function: arguments by name with shapes and units, the result, the cost."""
    return render("ufunc/doc.txt.jinja", {"page": page, "function": function, "ufunc": True}).strip("\n")


def _literal(line: str) -> str:
    """Return one line of text as a C string literal; bytes outside of ASCII are spelled in octal."""
    escaped = "".join(_escape(byte) for byte in line.encode())
    return f'"{escaped}"'


def _escape(byte: int) -> str:
    if byte == ord("\n"):
        return "\\n"
    plain = 32 <= byte < 127 and byte not in b'"\\?'
    return chr(byte) if plain else f"\\{byte:03o}"


UFUNC = Target(
    name="ufunc",
    title="ufunc",
    text="C for a Python extension of NumPy ufuncs, double and float in one, which says how to build it",
    reals=(C.reals[0],),
    options={DOUBLES: "double alone, compiled in half the time"},
    files={
        f"{{stem}}{MODULE}.c": str,
        **{name.replace("{stem}", f"{{stem}}_{tag}"): kind for tag in TAGS.values() for name, kind in C.files.items()},
    },
    first=C.first,
    keywords=C.keywords,
    lacks={},
    functions=None,
    tunes=False,
    printer=C.printer,
    comment=C.comment,
    write=_write,
    beside=alone,
    shortens=("", DOUBLES),
    loops=True,
)
