"""The ufunc target: a Python extension module of NumPy generalized ufuncs over the C target, in double and in float.

Core dimensions are frozen, `(7),(7),(7)->(7)`, so that NumPy itself refuses a wrong length, broadcasts, casts, takes
`out=` and lets go of the interpreter's lock. The C is that of target "c", under names of its own for each real type.

`symdyn.load` compiles C with entries that are all called alike, and one extension module over them. The module knows no
scene: it makes NumPy's generalized ufuncs of addresses, and is compiled once. A scene's own code is plain C, which
compilers read in a tenth of the time that the headers of Python and NumPy take.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from symdyn.emit.code.spelling import REALS, ShortSines
from symdyn.emit.code.target import Contents, Draft, FunctionText, Page, Target
from symdyn.emit.render import render, verbatim
from symdyn.emit.targets.c.c_and_cpp import ROWS, C
from symdyn.errors import EmitError
from symdyn.frozen import dataclass, replace
from symdyn.graph import growing
from symdyn.program import Program, shared

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
    printer=C.printer,
    comment=C.comment,
    write=_write,
    shortens=("", DOUBLES),
    loops=True,
)


TEMPLATES = ("runtime.c.jinja", "operands.c.jinja", "loops.c.jinja", "state.c.jinja", "named.c.jinja")
"""What the extension module's source is made of."""

OPERANDS, RANK = 32, 8
"""Most operands of a function, its result included, and most dimensions of one."""


@dataclass(frozen=True)
class Entry:
    """A function in C, and how it is called."""

    name: str  # of the function
    symbol: str  # what takes places of operands, and first a number of states where there are many
    shapes: tuple[tuple[int, ...], ...]  # of its operands, and of its result
    params: int  # which operand all states have in common; -1 for none
    doc: str  # what `help` says

    @property
    def signature(self) -> str:
        spelled = [f"({','.join(map(str, shape))})" for shape in self.shapes]
        return f"{','.join(spelled[:-1])}->{spelled[-1]}"


@dataclass(frozen=True)
class Runtime:
    """The extension module, under its name."""

    name: str

    @property
    def key(self) -> dict[str, str]:
        """All that its source is made of, which stands for it."""
        return {f"{self.name}.c": f"{OPERANDS} {RANK}", **{one: verbatim(f"ufunc/{one}") for one in TEMPLATES}}

    def source(self) -> dict[str, str]:
        """Return its source by the file's name."""
        reals = [{"name": name, "tag": tag} for name, tag in TAGS.items()]
        values = {"module": self.name, "reals": reals, "operands": OPERANDS, "rank": RANK}
        return {f"{self.name}.c": render("ufunc/runtime.c.jinja", values)}


@dataclass(frozen=True)
class Code:
    """A program as C."""

    RUNTIME: ClassVar[Runtime] = Runtime("symdyn_ufuncs")  # the extension module over all of them

    files: Mapping[str, str]  # by name, the one to compile first
    entries: tuple[Entry, ...]  # what is called there; what has an empty operand has none
    program: Program

    @classmethod
    @growing()
    def of(cls, program: Program, real: str = "double", rows: bool = False, accuracy: str = "") -> Code:
        """Return a program as C with entries for one state, or for rows of them.

        The accuracy, as for `emit`, is that of rows in its type; all others are as accurate as their type allows.

        Raises:
            EmitError: it cannot be written in this type.
        """
        short = ShortSines.find(accuracy)
        sines = short if short and rows and short.real == real else None
        draft = C.draft(program, REALS[real], "symdyn.load", ROWS if rows else "", sines)
        functions, entries = [], []
        for text, routine in zip(draft.page.functions, program.routines, strict=True):
            arguments = routine.function.arguments
            symbol = f"{draft.stem}__{text.name}"  # a name that no scene's function has, whatever the scene is called
            shapes = (*(one.shape for one in arguments), routine.function.shape)
            if any(0 in shape for shape in shapes):
                continue
            names = [one.name for one in arguments]
            common = shared(names)
            params = names.index(common) if common else -1
            entries.append(Entry(routine.function.name, symbol, shapes, params, docstring(draft.page, text)))
            scalars = [one.scalar for one in arguments]
            functions.append({"c": f"{draft.stem}_{text.name}", "symbol": symbol, "scalars": scalars})
        files = {name: text for name, text in C.write(draft).items() if isinstance(text, str)}
        first = next(iter(files))
        calls = render("ufunc/calls.c.jinja", {"functions": functions, "real": real, "rows": rows})
        return cls({**files, first: files[first] + calls}, tuple(entries), program)

    @property
    def fits_float(self) -> bool:
        """Whether the program can be written in float: no constant is too large."""
        tables = (
            one.function.loop.table.in_order(self.program.scene) for one in self.program.routines if one.function.loop
        )
        numbers = (value for some in (self.program.constants.values(), *tables) for value in some)
        if all(abs(value) < 2 ** (REALS["float"].top - 1) for value in numbers):
            return True
        try:
            C.write(C.draft(self.program, REALS["float"], ""))
        except EmitError:
            return False
        return True
