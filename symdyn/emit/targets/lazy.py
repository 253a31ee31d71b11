"""What `symdyn.load` compiles: C with entries that are all called alike, and one extension module over them.

The module knows no scene: it makes NumPy's generalized ufuncs of addresses, and is compiled once. A scene's own code
is plain C, which compilers read in a tenth of the time that the headers of Python and NumPy take.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from symdyn.emit.code.real import REALS
from symdyn.emit.code.short_sines import ShortSines
from symdyn.emit.render import render, verbatim
from symdyn.emit.targets.c.c99 import ROWS, C
from symdyn.emit.targets.ufunc import TAGS, docstring
from symdyn.errors import EmitError
from symdyn.graph import growing
from symdyn.program import Program, shared

TEMPLATES = ("runtime.c.jinja", "operands.c.jinja", "loops.c.jinja", "state.c.jinja", "named.c.jinja")
"""What the extension module's source is made of."""

OPERANDS, RANK = 32, 8
"""Most operands of a function, its result included, and most dimensions of one."""


@dataclass(frozen=True)
class Entry:
    """A function in C, and how it is called.

    Attributes:
        name: of the function.
        symbol: what takes places of operands, and first a number of states where there are many.
        shapes: of its operands, and of its result.
        params: which operand all states have in common; -1 for none.
        doc: what `help` says.
    """

    name: str
    symbol: str
    shapes: tuple[tuple[int, ...], ...]
    params: int
    doc: str

    @property
    def signature(self) -> str:
        """As NumPy writes it."""
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
    """A program as C.

    Attributes:
        files: by name, the one to compile first.
        entries: what is called there; what has an empty operand has none.
        RUNTIME: the extension module over all of them.
    """

    RUNTIME: ClassVar[Runtime] = Runtime("symdyn_ufuncs")

    files: Mapping[str, str]
    entries: tuple[Entry, ...]
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
