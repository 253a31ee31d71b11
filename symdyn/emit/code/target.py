"""A target: all that is known of one language, or one way to be called; what its writer is given, and what it makes.

A template is given every piece of a file as finished text, the same for all targets up to the code itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import prod

from symdyn.arguments import argument
from symdyn.dynamics import Argument, TableLoop
from symdyn.dynamics.outputs import Counts
from symdyn.emit.code.identifiers import function_names, stem
from symdyn.emit.code.spelling import Printer, Real, ShortSines
from symdyn.emit.render import render
from symdyn.errors import EmitError
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Op, Piecewise, reachable
from symdyn.program import Program, Routine, identifier
from symdyn.scene import Scene

NO_SPELLING = "no spelling of it is known; take another target"


@dataclass(frozen=True)
class ArgumentText:
    """One argument: name, length, what it is, units in one phrase; whether it is one number; names of its entries."""

    name: str
    length: int
    text: str
    units: str
    scalar: bool = False
    names: str = ""

    @property
    def core(self) -> str:
        """Its own dimensions, as NumPy's signatures write them: "7", or nothing for one number."""
        return "" if self.scalar else str(self.length)

    @property
    def shape(self) -> str:
        """Shape of a batch of it, as documentation writes it."""
        return "(...)" if self.scalar else f"(..., {self.length})"


@dataclass(frozen=True)
class Line:
    """One assignment: `target` is a name or a subscript."""

    target: str
    code: str


@dataclass(frozen=True)
class FunctionText:
    """One function, ready to be laid out.

    Attributes:
        name, text, result, units, formulation: as in `symdyn.dynamics.outputs.named_functions.Function`.
        arguments: in calling order.
        shape: of the result.
        inputs: (local name, argument, index) of every entry that is read.
        steps: intermediate results.
        outputs: one line an entry of the result, the target being its subscript.
        unused: arguments that are not read.
        counts: operations of one call, in words.
        operations: what is written out, at run time.
        first: index of the first entry of an array.
        loop: the table that a loop goes over in place of lines; None where there are lines.
    """

    name: str
    text: str
    arguments: tuple[ArgumentText, ...]
    result: str
    shape: tuple[int, ...]
    units: str
    formulation: str
    inputs: tuple[tuple[str, str, int], ...]
    steps: tuple[Line, ...]
    outputs: tuple[Line, ...]
    unused: tuple[str, ...]
    counts: str
    operations: frozenset[Op]
    first: int
    loop: TableLoop | None = None

    @property
    def scalars(self) -> tuple[str, ...]:
        """Names of the arguments that are one number."""
        return tuple(argument.name for argument in self.arguments if argument.scalar)

    @property
    def propagation(self) -> str:
        """What a NaN in an argument does, in a sentence; "" where no argument is read."""
        needed = []
        for one in self.arguments:
            places = sorted(place for _, name, place in self.inputs if name == one.name)
            whole = one.scalar or len(places) == one.length
            parts = _ranges(places, self.first)
            needed += [one.name if whole else f"{one.name}[{part}]" for part in parts]
            needed = list(dict.fromkeys(needed))
        if not needed:
            return ""
        listed = " or ".join([", ".join(needed[:-1]), needed[-1]] if len(needed) > 1 else needed)
        return f"A NaN in {listed} makes what depends on it NaN, and raises nothing."


@dataclass(frozen=True)
class TableText:
    """A function that is given by points: its name, and numbers, of which the first so many are knots.

    Then follow rows of so many coefficients, from the constant upwards, one more than knots.
    """

    name: str
    numbers: tuple[str, ...]
    knots: int
    width: int


@dataclass(frozen=True)
class Page:
    """One generated module.

    Attributes:
        scene: its name as the user wrote it.
        command: what made the file, for its header.
        functions: in the order of the program.
        arguments: every argument of any function, once.
        parameters: (name, unit, description) of the free parameters, in the order of `params`.
        first: index of the first entry of an array.
        tables: what is looked up.
    """

    scene: str
    command: str
    functions: tuple[FunctionText, ...]
    arguments: tuple[ArgumentText, ...]
    parameters: tuple[tuple[str, str, str], ...]
    first: int
    tables: tuple[TableText, ...]

    @property
    def operations(self) -> frozenset[str]:
        """Names of all that is written out, at run time."""
        return frozenset(op.name for function in self.functions for op in function.operations)


def compose(
    program: Program, printer: Printer, command: str, first: int, keywords: frozenset[str], loops: bool = False
) -> Page:
    """Return the page of `program` with its code in the printer's language; as to the rest see `Target`."""
    names = function_names([one.function.name for one in program.routines], keywords, f"{stem(program.scene.name)}_")
    functions = tuple(
        _loop(routine, routine.function.loop, name, first)
        if loops and routine.function.loop
        else _function(program, routine, name, printer, first)
        for routine, name in zip(program.routines, names, strict=True)
    )
    arguments = {argument.name: argument for function in functions for argument in function.arguments}
    params = [one for routine in program.routines for one in routine.function.arguments if one.name == Program.PARAMS]
    free = [str(symbol.value) for symbol in params[0].symbols] if params else []
    there = {parameter.name: parameter for parameter in program.scene.parameters}
    parameters = tuple((there[name].name, there[name].unit, there[name].text) for name in free)
    tables = tuple(
        TableText(name, tuple(map(printer.literal, one.numbers)), len(one.knots), len(one.rows[0]))
        for one, name in printer.tables.items()
    )
    return Page(program.scene.name, command, functions, tuple(arguments.values()), parameters, first, tables)


def _tables(program: Program) -> dict[Piecewise, str]:
    """Return what a program looks up, and what each is called."""
    entries = [entry for routine in program.routines for entry in routine.function.entries]
    values = (node.value for node in (reachable(entries) if entries else ()))
    found = dict.fromkeys(value for value in values if isinstance(value, Piecewise))
    names = (f"{identifier(one.name)}_d{one.order}" if one.order else identifier(one.name) for one in found)
    return {one: f"table_{k}_{name}" for k, (one, name) in enumerate(zip(found, names, strict=True), 1)}


def _function(program: Program, routine: Routine, name: str, printer: Printer, first: int) -> FunctionText:
    function, named = routine.function, routine.names
    places = {symbol: (a.name, i) for a in function.arguments for i, symbol in enumerate(a.symbols, first)}
    return FunctionText(
        name=name,
        text=function.text,
        arguments=tuple(_argument(argument) for argument in function.arguments),
        result=function.result,
        shape=function.shape,
        units=function.units,
        formulation=function.formulation,
        inputs=tuple((step.name, *places[step.node]) for step in routine.inputs),
        steps=tuple(Line(s.name, printer.definition(s.node, named, program.constants)) for s in routine.steps),
        outputs=tuple(
            Line(", ".join(map(str, index)), printer.code(entry, named, program.constants))
            for index, entry in zip(_indices(function.shape, first), function.entries, strict=True)
        ),
        unused=routine.unused,
        counts=str(routine.counts),
        operations=routine.operations,
        first=first,
    )


def _loop(routine: Routine, loop: TableLoop, name: str, first: int) -> FunctionText:
    """Return a function that goes over a table; it reads every entry of every argument."""
    function, joints = routine.function, len(loop.table.rows)
    many = joints >= loop.algorithm.fewest
    why = f"from {loop.algorithm.fewest} joints on {loop.algorithm.why}" if many else "asked for by its formulation"
    return FunctionText(
        name=name,
        text=function.text,
        arguments=tuple(_argument(argument) for argument in function.arguments),
        result=function.result,
        shape=function.shape,
        units=function.units,
        formulation=f"a loop over a table of {joints} joints, not lines: {why}",
        inputs=tuple((f"{a.name}_{k}", a.name, k) for a in function.arguments for k in range(first, first + joints)),
        steps=(),
        outputs=(Line("", ""),) * prod(function.shape),
        unused=(),
        counts=str(Counts.of_loop(loop)),
        operations=frozenset(),
        first=first,
        loop=loop,
    )


def _ranges(places: Sequence[int], first: int) -> list[str]:
    """Return ascending indices as single ones and ranges, such as 0, 3:7; where arrays begin at 1, an end is inside."""
    parts: list[list[int]] = []
    for place in places:
        if parts and place == parts[-1][-1] + 1:
            parts[-1].append(place)
        else:
            parts.append([place])
    return [f"{part[0]}:{part[-1] + 1 - first}" if len(part) > 1 else str(part[0]) for part in parts]


def _argument(argument: Argument) -> ArgumentText:
    """Return one argument as text; equal units are told once."""
    units = argument.units if len(set(argument.units)) > 1 else argument.units[:1]
    phrase = ", ".join(unit or "1" for unit in units)
    return ArgumentText(argument.name, len(argument.symbols), argument.text, phrase, argument.scalar, argument.names)


def _indices(shape: tuple[int, ...], first: int) -> Iterable[tuple[int, ...]]:
    """Return the subscripts of an array, the last one running fastest."""
    indices: list[tuple[int, ...]] = [()]
    for length in shape:
        indices = [(*index, place) for index in indices for place in range(first, first + length)]
    return indices


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
        functions: the requests that its files are made of, of a scene and an option, no more and no fewer; None: any
            that are named.
        tunes: whether parameters with a value stay free, and that value is what they have until somebody sets them.
        printer: writes expressions, by real type.
        comment: text as lines of a comment, which nothing in it can end.
        write: contents by file name; the file to compile or to import first.
        beside: what a user wants beside the files and they do not need, by name: an example, what builds it.
        shortens: options at which rows of sines are taken by C of our own, of which there is shorter for less accuracy.
        loops: whether functions with a table become loops over it, and solves loops over rows; else all are lines.
        rows: whether solves alone are loops over rows.
    """

    name: str
    title: str
    text: str
    files: Mapping[str, type[Contents]]
    printer: Callable[[Real], Printer]
    comment: Callable[[str], str]
    write: Callable[[Draft], Mapping[str, Contents]]
    reals: tuple[str, ...] = ("double",)
    options: Mapping[str, str] = field(default_factory=dict)
    first: int = 0
    keywords: frozenset[str] = frozenset()
    lacks: Mapping[Op, str] = field(default_factory=dict)
    functions: Callable[[Scene, str], tuple[str, ...]] | None = None
    tunes: bool = False
    beside: Callable[[Sources], Mapping[str, str]] = alone
    shortens: tuple[str, ...] = ()
    loops: bool = False
    rows: bool = False

    def draft(
        self, program: Program, real: Real, command: str, option: str = "", sines: ShortSines | None = None
    ) -> Draft:
        """Return a program as this target's text, not laid out yet; `command` is what the header says to run again.

        Raises:
            EmitError: functions that it is not made of, an operation that the language lacks, two functions of one
                name, a constant too large for the type.
        """
        printer, program = self.printer(real), program if self.looks_up(real) else program.without_tables
        self._refuse(program, real, printer, option)
        printer = replace(printer, tables=_tables(program))
        page = compose(program, printer, command, self.first, self.keywords, self.loops_in(real))
        about = render("common/about.txt.jinja", {"page": page, "sines": sines}).rstrip("\n")
        return Draft(program, real, option, printer, page, stem(program.scene.name), self.comment(about), sines)

    def loops_in(self, real: Real) -> bool:
        """Tell whether functions with a table become loops over it, with numbers of a type."""
        return self.loops and real.parts == 1

    def looks_up(self, real: Real) -> bool:
        """Tell whether a table of numbers is looked up in arrays; else it is written as other operations."""
        return Op.TABLE in self.printer(real).spellings

    def _refuse(self, program: Program, real: Real, printer: Printer, option: str) -> None:
        """Raise EmitError for functions that it is not made of, and for what the language or the type lacks."""
        wanted = self.functions(program.scene, option) if self.functions else ()
        there = [one.function.request or one.function.name for one in program.routines]
        if wanted and {*wanted} != {*there} - {Program.PREPARE}:
            raise EmitError(
                f"target {self.name} ({self.text}) is made of {', '.join(wanted)}, here are {', '.join(there)}; "
                f"leave {argument('functions')} out"
            )
        unspelled = [op for op in Op if op not in printer.spellings]
        lacks = {**dict.fromkeys(unspelled, NO_SPELLING), **self.lacks}
        lacking = [(f"target {self.name} ({self.text})", lacks), (f"real type {real.name}", real.lacks)]
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
        return dict(self.files)[name]

    def __iter__(self) -> Iterator[str]:
        return (name for name, _ in self.files)

    def __len__(self) -> int:
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
        return {name: contents for name, contents in self.files if isinstance(contents, str)}
