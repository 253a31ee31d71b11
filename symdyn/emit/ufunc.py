"""The ufunc target: a Python extension module of NumPy generalized ufuncs over the C target, in double and in float.

Core dimensions are frozen, `(7),(7),(7)->(7)`, so that NumPy itself refuses a wrong length, broadcasts, casts, takes
`out=` and lets go of the interpreter's lock. The C is that of target "c", under names of its own for each real type.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from symdyn.emit.c import emit_c, spellings
from symdyn.emit.names import stem
from symdyn.emit.page import FunctionText, Page, compose
from symdyn.emit.real import REALS, Real, digits
from symdyn.emit.render import render
from symdyn.emit.spelling import Printer
from symdyn.errors import EmitError
from symdyn.program import Program
from symdyn.program.assemble import shared

TAGS: Mapping[str, str] = {"float": "f32", "double": "f64"}
"""In the order in which NumPy tries them: the first type that all operands fit is taken."""

CODES: Mapping[str, str] = {"float": "NPY_FLOAT", "double": "NPY_DOUBLE"}


@dataclass(frozen=True)
class _Ufunc:
    """What the template needs of one function.

    Attributes:
        name, arguments, shape: as in `FunctionText`.
        size: entries of the result.
        signature: as NumPy reads it.
        params: place of what all states of a batch have in common among the arguments, -1 without.
        doc: lines of a C string literal.
    """

    name: str
    arguments: tuple[object, ...]
    shape: tuple[int, ...]
    size: int
    signature: str
    params: int
    doc: tuple[str, ...]


@dataclass(frozen=True)
class _Loop:
    """What the template needs of one real type: its names, and the functions that have an entry for rows."""

    name: str
    tag: str
    code: str
    stem: str
    loop: str
    rows: tuple[str, ...]


def module_name(scene: str) -> str:
    """Return the name of the extension module of a scene."""
    return f"{stem(scene)}_ufunc"


def emit_ufunc(
    program: Program, real: Real, command: str, lean: bool = False, doubles: bool = False
) -> tuple[tuple[str, str], ...]:
    """Return the extension module's source, then the C that it calls, by name.

    Args:
        program: what to compute.
        real: double.
        command: for the header.
        lean: whether to leave out float and the entries for rows, which take compilers most of their time.
        doubles: whether to leave out float alone.

    Raises:
        EmitError: a real type other than double is asked for; the module has loops for both.
    """
    if real.name != "double":
        raise EmitError(f"real type {real.name!r}: target ufunc has float and double in one module; leave it out")
    page = compose(program, Printer(spellings(real), lambda value: digits(value, real)), command)
    usable = tuple(f for f in page.functions if 0 not in (*f.shape, *(a.length for a in f.arguments)))
    files: dict[str, str] = {}
    loops = []
    for name, tag in TAGS.items():
        if (lean or doubles) and name != real.name:
            continue
        try:
            code = emit_c(_renamed(program, tag), REALS[name], command, batch=not lean)
        except EmitError:
            if name == "double":
                raise
            continue  # a constant is too large for float: NumPy then casts to double
        files |= dict(code)
        loops.append(_loop(name, tag, stem(program.scene.name), usable, "".join(text for _, text in code)))
    values = {
        "about": render("common/about.txt.jinja", {"page": page}).rstrip("\n"),
        "module": module_name(program.scene.name),
        "functions": tuple(_ufunc(page, function) for function in usable),
        "left_out": tuple(function.name for function in page.functions if function not in usable),
        "reals": loops,
        "operands": 1 + max((len(function.arguments) for function in usable), default=0),
        "rank": max((1, *(len(function.shape) for function in usable))),
    }
    return ((f"{module_name(program.scene.name)}.c", render("ufunc/module.c.jinja", values)), *files.items())


def _renamed(program: Program, tag: str) -> Program:
    """Return the program under a scene name that carries the real type."""
    return replace(program, scene=replace(program.scene, name=f"{stem(program.scene.name)}_{tag}"))


def _loop(real: str, tag: str, opening: str, functions: tuple[FunctionText, ...], code: str) -> _Loop:
    name = stem(f"{opening}_{tag}")
    rows = tuple(f.name for f in functions if f"void {name}_{f.name}_rows(" in code)
    return _Loop(real, tag, CODES[real], name, f"walk_{tag}", rows)


def _ufunc(page: Page, function: FunctionText) -> _Ufunc:
    names = [argument.name for argument in function.arguments]
    common = shared(names)
    inputs = ",".join(f"({argument.core})" for argument in function.arguments)
    return _Ufunc(
        name=function.name,
        arguments=function.arguments,
        shape=function.shape,
        size=len(function.outputs),
        signature=f"{inputs}->({','.join(map(str, function.shape))})",
        params=names.index(common) if common else -1,
        doc=tuple(_literal(line) for line in docstring(page, function).splitlines(keepends=True)),
    )


def docstring(page: Page, function: FunctionText) -> str:
    """Return what `help` says about one function: arguments by name with shapes and units, the result, the cost."""
    return render("ufunc/doc.txt.jinja", {"page": page, "function": function}).strip("\n")


def _literal(line: str) -> str:
    """Return one line of text as a C string literal; bytes outside of ASCII are spelled in octal."""
    escaped = "".join(_escape(byte) for byte in line.encode())
    return f'"{escaped}"'


def _escape(byte: int) -> str:
    if byte == ord("\n"):
        return "\\n"
    plain = 32 <= byte < 127 and byte not in b'"\\?'
    return chr(byte) if plain else f"\\{byte:03o}"
