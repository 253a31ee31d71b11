"""A target: all that is known of one language, or one way to be called; what its writer is given, and what it makes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.operators import Printer
from symdyn.emit.code.real import Real, ShortSines
from symdyn.emit.code.source_text import Page, compose
from symdyn.emit.render import render
from symdyn.errors import EmitError
from symdyn.graph import Op
from symdyn.program import Program
from symdyn.scene import Scene

Contents = str | bytes

BATCH = "batch"
"""The option for functions over many states."""


def alone(sources: Sources) -> dict[str, str]:
    """Return nothing, of a target whose files stand alone."""
    return {}


@dataclass(frozen=True)
class Draft:
    """A program on its way into files.

    Attributes:
        program: what to compute.
        real: type of all numbers.
        option: which of the target's options was chosen; "" for none.
        printer: of the target, for this type.
        page: every function as text.
        stem: how the names of the files begin.
        about: what the files say of themselves, as a comment.
        sines: how rows of sines are taken where they are shorter than the type allows; None for full accuracy.
    """

    program: Program
    real: Real
    option: str
    printer: Printer
    page: Page
    stem: str
    about: str
    sines: ShortSines | None = None


@dataclass(frozen=True)
class Target:
    """What programs are written in.

    Attributes:
        name: key in `TARGETS`.
        title: what reports call it.
        text: what is written, for those who choose.
        reals: real types that it is written in.
        options: what can be asked of it, one at a time, by name: what that does.
        files: what its files may be called, with their type, text or bytes: {stem} stands for `Draft.stem`, {function}
            for any of the functions; a folder stands before a stroke.
        first: index of the first entry of an array.
        keywords: what no function may be called there.
        lacks: operations that the language cannot hold: why, and what would work.
        functions: the requests that its files are made of, of a scene, no more and no fewer; None: any that are named.
        tunes: whether parameters with a value stay free, and that value is what they have until somebody sets them.
        printer: writes expressions, by real type.
        comment: text as lines of a comment, which nothing in it can end.
        write: contents by file name; the file to compile or to import first.
        beside: what a user wants beside the files and they do not need, by name: an example, what builds it.
        shortens: options at which rows of sines are taken by C of our own, of which there is shorter for less accuracy.
        loops: whether functions with a table become loops over it; else all are lines.
    """

    name: str
    title: str
    text: str
    reals: tuple[str, ...]
    options: Mapping[str, str]
    files: Mapping[str, type[Contents]]
    first: int
    keywords: frozenset[str]
    lacks: Mapping[Op, str]
    functions: Callable[[Scene], tuple[str, ...]] | None
    tunes: bool
    printer: Callable[[Real], Printer]
    comment: Callable[[str], str]
    write: Callable[[Draft], Mapping[str, Contents]]
    beside: Callable[[Sources], Mapping[str, str]]
    shortens: tuple[str, ...]
    loops: bool

    def draft(
        self, program: Program, real: Real, command: str, option: str = "", sines: ShortSines | None = None
    ) -> Draft:
        """Return a program as this target's text, not laid out yet; `command` is what the header says to run again.

        Raises:
            EmitError: functions that it is not made of, an operation that the language lacks, two functions of one
                name, a constant too large for the type.
        """
        self._refuse(program, real)
        printer = self.printer(real)
        page = compose(program, printer, command, self.first, self.keywords, self.loops_in(real))
        about = render("common/about.txt.jinja", {"page": page, "sines": sines}).rstrip("\n")
        return Draft(program, real, option, printer, page, stem(program.scene.name), self.comment(about), sines)

    def loops_in(self, real: Real) -> bool:
        """Tell whether functions with a table become loops over it, with numbers of a type."""
        return self.loops and real.parts == 1

    def _refuse(self, program: Program, real: Real) -> None:
        """Raise EmitError for functions that it is not made of, and for what the language or the type lacks."""
        wanted = self.functions(program.scene) if self.functions else ()
        there = [one.function.request or one.function.name for one in program.routines]
        if wanted and {*wanted} != {*there} - {Program.PREPARE}:
            raise EmitError(
                f"target {self.name} ({self.text}) is made of {', '.join(wanted)}, here are {', '.join(there)}; "
                "leave --functions out"
            )
        lacking = [(f"target {self.name} ({self.text})", self.lacks), (f"real type {real.name}", real.lacks)]
        for what, op, why in ((what, op, why) for what, lacks in lacking for op, why in lacks.items()):
            needed = [routine.function.name for routine in program.routines if op in routine.operations]
            if needed:
                raise EmitError(f"{what} lacks {op.name.lower()}, which {', '.join(needed)} needs: {why}")


@dataclass(frozen=True)
class Sources(Mapping[str, Contents]):
    """Generated files by name.

    Attributes:
        program: what they compute.
        target: a key of `TARGETS`.
        real: a key of `REALS`, such as "double".
        option: which of the target's options was chosen; "" for none.
        functions: what the program's functions are called there, in order.
        files: pairs of file name and contents, the file to compile or to import first.
        accuracy: a key of `SHORT_SINES`, "" for that of the type.
    """

    program: Program
    target: str
    real: str
    option: str
    functions: tuple[str, ...]
    files: tuple[tuple[str, Contents], ...]
    accuracy: str = ""

    def __getitem__(self, name: str) -> Contents:
        """Return the contents of one file."""
        return dict(self.files)[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the file names."""
        return (name for name, _ in self.files)

    def __len__(self) -> int:
        """Return the number of files."""
        return len(self.files)

    @property
    def stem(self) -> str:
        """How the names of the files begin, and in C those of the functions."""
        return stem(self.program.scene.name)

    @property
    def batch(self) -> bool:
        """Whether there are functions over many states."""
        return self.option == BATCH

    @property
    def texts(self) -> dict[str, str]:
        """The files that are text."""
        return {name: contents for name, contents in self.files if isinstance(contents, str)}
