"""The text of files against their program: what was read must be the same functions, constants rounded correctly.

A file beside those that were proved may be one that a tool takes in place of its own: a module called numpy, `math.h`,
`cos.m`. What stands in the folder of a module is imported before the package of that name, a folder that a compiler is
given is searched before its own, and a function of MATLAB's path or of a private folder hides a builtin.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from hashlib import sha256
from pathlib import Path, PurePath

from symdyn.algebra import Redraw
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, Piecewise, Scalar, reachable
from symdyn.program import Program, Routine, RowLoop, in_lines
from symdyn.verdict import Verdict
from symdyn.verify.written.field import Everywhere, Operation, everywhere
from symdyn.verify.written.reading import (
    ExpectedFunction,
    Read,
    ReadLanguage,
    Text,
    TextReading,
    Unread,
    fixed_text,
    letters,
    nearest,
    parse,
)

NO_CLAIM = ""
"""The verdict on a file that has just been written and holds no function: it is fixed text, compared with nothing."""

Contents = str | bytes


@dataclass(frozen=True)
class Written:
    """What is known of one file.

    Attributes:
        target: what it was written for.
        option: of the target, "" for none.
        file: its name.
        sha256: of its bytes, in hexadecimal.
        functions: what it calls those that were read and proved.
        verdict: one of `symdyn.verdict`; NOT_SHOWN where the file says what has no meaning here, or is not there;
            NO_CLAIM where it is but fixed text, and no other file is there to compare it with.
        where: of what differs, the function, the entry and the line, or why nothing could be compared; "" where all is
            as it must be.
        compared: bytes of fixed text, which are those of a fresh file.
    """

    target: str
    option: str
    file: str
    sha256: str
    functions: tuple[str, ...]
    verdict: str
    where: str
    compared: int

    @property
    def passed(self) -> bool:
        return self.verdict in (*Verdict.HOLD, NO_CLAIM)


@dataclass(frozen=True)
class Computed:
    """What code computes: values of its entries, or of its table, at all points, and its operations at the first."""

    values: tuple[tuple[int, ...], ...]
    operations: frozenset[Operation]


class Verbatim(Graph):
    """A graph without identities, since numbers of a computer have few; minus a constant alone is a constant.

    x / x is not 1 where x is zero, and (a + b) - b is not a: whatever a file says is an operation, though algebra has
    none.
    """

    def add(self, a: Expr, b: Expr) -> Expr:
        return self.node(Op.ADD, a, b)

    def sub(self, a: Expr, b: Expr) -> Expr:
        return self.node(Op.SUB, a, b)

    def mul(self, a: Expr, b: Expr) -> Expr:
        return self.node(Op.MUL, a, b)

    def div(self, a: Expr, b: Expr) -> Expr:
        """Return a / b; a zero below is found where values are taken."""
        return self.node(Op.DIV, a, b)

    def neg(self, a: Expr) -> Expr:
        return super().neg(a) if a.op is Op.CONSTANT else self.node(Op.NEG, a)

    def function(self, op: Op, *args: Scalar) -> Expr:
        return self.node(op, *map(self.lift, args))


def verbatim(
    outputs: Sequence[Expr], replaced: Mapping[Expr, Expr], graph: Verbatim, number: Callable[[Fraction], Fraction]
) -> list[Expr]:
    """Return nodes of another graph with all their operations, leaves `replaced` or as they are, tables rounded."""
    found = dict(replaced)
    for node in reachable(outputs, found):
        if node in found:
            continue
        if node.op is Op.SYMBOL:
            found[node] = graph.symbol(str(node.value))
        elif node.op is Op.CONSTANT:
            found[node] = graph.lift(node.value)  # type: ignore[arg-type]  # a fraction
        elif isinstance(node.value, Piecewise):
            found[node] = graph.lookup(node.value.printed(number), found[node.args[0]])
        else:
            found[node] = graph.node(node.op, *(found[one] for one in node.args))
    return [found[node] for node in outputs]


@dataclass(frozen=True)
class Printed:
    """A program as it is printed: every constant is the nearest number of the type.

    Attributes:
        program: what is printed.
        real: the type.
        graph: of its entries, and of what is read of files: what stands in several of them is one node.
        places: points of fields.
        computed: of each function, what its lines compute, and what its rows do where it may be solved so: constants
            that lines fold are rounded after it.
    """

    program: Program
    real: str
    graph: Verbatim
    places: Everywhere
    computed: tuple[tuple[Computed, ...], ...]

    def expected(self, names: Sequence[str]) -> tuple[ExpectedFunction, ...]:
        """Return the functions that files must hold, called `names`; entries of arguments are symbols of the graph."""
        graph, found = self.graph, []
        for name, routine in zip(names, self.program.routines, strict=True):
            given = routine.function.arguments
            arguments = {one.name: tuple(graph.symbol(str(symbol.value)) for symbol in one.symbols) for one in given}
            scalars = frozenset(one.name for one in given if one.scalar)
            loop = routine.function.loop is not None
            found.append(ExpectedFunction(name, arguments, scalars, routine.function.shape, loop))
        return tuple(found)


def printed(program: Program, real: str, seed: int = 1, loops: bool = False, tables: bool = False) -> Printed:
    """Return a program as it is printed with numbers of a type, `loops` as their tables, else all of it in lines.

    `tables` of numbers are looked up there, else made of other operations.

    Raises:
        Redraw: no point was found at which every function is defined.
    """
    program = program if loops else in_lines(program)
    program = program if tables else program.without_tables
    graph = Verbatim()
    rounded = {node: graph.constant(nearest(value, real)) for node, value in program.constants.items()}
    read = [
        [graph.constant(nearest(value, real)) for value in one.function.loop.table.in_order(program.scene)]
        if one.function.loop
        else verbatim(one.function.entries, rounded, graph, partial(nearest, real=real))
        for one in program.routines
    ]
    ways = [[some, *_in_rows(one, real, graph)] for some, one in zip(read, program.routines, strict=True)]
    places = everywhere([entry for all_ways in ways for some in all_ways for entry in some], seed)
    computed = [
        tuple(Computed(tuple(places.values(some)), places.operations(some)) for some in all_ways) for all_ways in ways
    ]
    return Printed(program, real, graph, places, tuple(computed))


def _in_rows(routine: Routine, real: str, graph: Verbatim) -> list[list[Expr]]:
    """Return the entries of a function that is solved in rows; none of any other."""
    rows = None if routine.function.loop else RowLoop.of(routine.function)
    if rows is None:  # or it goes over a table, and that is all that is printed
        return []
    rounded = {node: graph.constant(nearest(value, real)) for node, value in rows.program.constants.items()}
    return [rows.composed(verbatim(rows.entries, rounded, graph, partial(nearest, real=real)))]


@dataclass(frozen=True)
class Files:
    """The files of one target."""

    target: str  # of `READERS`
    option: str  # of the target, "" for none
    stem: str  # how their names begin
    functions: tuple[str, ...]  # what the program's functions are called there, in order
    contents: Mapping[str, Contents]  # by file name


def prove_texts(
    program: Printed, files: Files, languages: Mapping[str, ReadLanguage], fresh: Mapping[str, Contents] | None = None
) -> tuple[Written, ...]:
    """Return what is known of the files of one target.

    Args:
        program: what they must compute.
        files: what was found.
        languages: what they are read as, by the ends of their names; the others are fixed text.
        fresh: contents of files made now, whose fixed text theirs must be; None where the files are these.

    Raises:
        MissingProgram: a grammar is not installed.
    """
    found, seen = [], set()
    for name, contents in files.contents.items():
        source = _bytes(contents)
        language = languages.get(PurePath(name).suffix)
        about = partial(Written, files.target, files.option, name, sha256(source).hexdigest())
        try:
            reading, fixed = read_text(program, files, source, language)
        except Unread as fault:
            found.append(about((), Verdict.NOT_SHOWN, str(fault), 0))
            continue
        seen |= {one.function for one in reading.functions}
        where = next(filter(None, (_difference(program, files, one) for one in reading.functions)), "")
        if not where and fresh is not None:
            where = _fixed_difference(program, files, fixed, fresh.get(name), language)
        functions = tuple(one.name for one in reading.functions)
        compared = sum(len(one.entries) for one in reading.functions) + (0 if fresh is None else len(fixed))
        said = Verdict.of(compared, bool(where), proved=True) if compared or where else NO_CLAIM
        found.append(about(() if where else functions, said, where, len(fixed)))
    for name in fresh or ():
        if name not in files.contents:
            found.append(
                Written(files.target, files.option, name, "", (), Verdict.NOT_SHOWN, "there is no such file", 0)
            )
    missing = [name for name in files.functions if name not in seen]
    if missing and found and all(one.passed for one in found):
        found[0] = replace(
            found[0], functions=(), verdict=Verdict.DIFFERENT, where=f"no function {missing[0]} was found"
        )
    return tuple(found)


def unshown(files: Files, fresh: Mapping[str, Contents], why: str) -> tuple[Written, ...]:
    """Return that nothing of files could be compared with those that are made now."""
    hashes = {name: sha256(_bytes(contents)).hexdigest() for name, contents in files.contents.items()}
    names = dict.fromkeys((*hashes, *fresh))
    return tuple(
        Written(files.target, files.option, name, hashes.get(name, ""), (), Verdict.NOT_SHOWN, why, 0) for name in names
    )


def _bytes(contents: Contents) -> bytes:
    return contents.encode() if isinstance(contents, str) else contents


def read_text(
    program: Printed, files: Files, source: bytes, language: ReadLanguage | None
) -> tuple[TextReading, bytes]:
    """Return what is read of a file, and its fixed text.

    Raises:
        Unread: it says what has no meaning.
    """
    if language is None:
        return TextReading((), ()), source
    letters(source)
    root = parse(language.grammar, language.plain(source))
    text = Text(root, source, files.stem, program.real, program.expected(files.functions), program.graph)
    try:
        reading = language.read(text)
    except RecursionError:
        raise Unread(1, "nests its expressions too deeply") from None
    except (IndexError, KeyError, ValueError):  # a tree of a form that no file of ours has
        raise Unread(1, "is built as nothing that is read here") from None
    for cut in reading.cuts:
        letters(source, cut)
    return reading, fixed_text(source, root, reading.cuts, language.comments)


def _difference(program: Printed, files: Files, read: Read) -> str:
    """Return where a function of a file is another one than that of the program, "" if nowhere."""
    ways = program.computed[files.functions.index(read.function)]
    first = f"{read.name}, line {min(read.lines, default=0)}"
    if len(read.entries) != len(ways[0].values):
        return f"{first}: is a table of {len(read.entries)} numbers"
    try:
        values = program.places.values(read.entries)
    except Redraw:
        return f"{first}: divides by zero"
    apart = [[k for k, pair in enumerate(zip(values, way.values, strict=True)) if pair[0] != pair[1]] for way in ways]
    if all(apart):
        place = min(apart, key=len)[0]
        return f"{read.name}, entry {place}, line {read.lines[place]}: is another function"
    operations = program.places.operations(read.entries)
    if all(other or operations != way.operations for other, way in zip(apart, ways, strict=True)):
        return f"{first}: is the same function by other operations"
    return ""


def _fixed_difference(
    program: Printed, files: Files, fixed: bytes, fresh: Contents | None, language: ReadLanguage | None
) -> str:
    """Return where fixed text is not that of a fresh file, "" if nowhere."""
    if fresh is None:
        return "no such file is made for these functions"
    _, expected = read_text(program, files, _bytes(fresh), language)
    if fixed == expected:
        return ""
    mine, theirs = fixed.splitlines(), expected.splitlines()
    line = next((k for k, (a, b) in enumerate(zip(mine, theirs, strict=False)) if a != b), min(len(mine), len(theirs)))
    return f"fixed text: {(mine[line] if line < len(mine) else b'the end').decode('utf-8', 'replace').strip()!r}"


INCLUDED = re.compile(r"^\s*#\s*include\s*[<\"]([^>\"\n]+)", re.MULTILINE)
IMPORTED = re.compile(r"^\s*(?:import|from)\s+(\w+)", re.MULTILINE)
CALLED = re.compile(r"\b([A-Za-z]\w*)\(")
VARIABLE = re.compile(r"^\s*([A-Za-z]\w*)\s*(?:\([^()\n]*\))?\s*=", re.MULTILINE)
SIGNATURE = re.compile(r"^function .*$", re.MULTILINE)
COMMENT = re.compile(r"%.*$", re.MULTILINE)

OF_C = (".c", ".h", ".hpp", ".cu", ".cl")
OF_PYTHON = (".py", ".pyc", ".so", ".pyd")
OF_MATLAB = (".m", ".p", ".oct", ".mlx")


def hiding_files(folder: Path, written: Sequence[Written], beside: Iterable[str]) -> tuple[Written, ...]:
    """Return the verdicts on files of a folder, of those `beside`, that hide what a proved one asks for."""
    there = {one.file: folder / one.file for one in written if (folder / one.file).is_file()}
    texts = {name: path.read_bytes().decode("utf-8", "replace") for name, path in there.items()}
    found = []
    for name, by in taken_first(texts, beside).items():
        file = next(one for one in written if one.file == by)
        told = f"{by} asks for something of this name, and would be given this file"
        contents = sha256((folder / name).read_bytes()).hexdigest()
        found.append(Written(file.target, file.option, name, contents, (), Verdict.DIFFERENT, told, 0))
    return tuple(found)


def taken_first(files: Mapping[str, str], beside: Iterable[str]) -> dict[str, str]:
    """Return which of the names `beside` a tool takes for what a file asks for, each with the name of that file.

    Args:
        files: what was read, text by name; names have slashes.
        beside: names of the other files of the folder.
    """
    found: dict[str, str] = {}
    for name in beside:
        path = PurePath(name)
        for file, text in files.items():
            ending = PurePath(file).suffix
            included = ending in OF_C and any(name == one or name.endswith(f"/{one}") for one in INCLUDED.findall(text))
            module = path.parts[0].partition(".")[0]
            imported = ending == ".py" and path.suffix in OF_PYTHON and module in IMPORTED.findall(text)
            like_matlab = path.suffix in OF_MATLAB or path.suffix.startswith(".mex")
            called = ending == ".m" and like_matlab and path.stem in _functions(text)
            if included or imported or called:
                found.setdefault(name, file)
    return found


def _functions(text: str) -> set[str]:
    """Return what a MATLAB file calls that is no variable of its own."""
    code = COMMENT.sub("", text)
    own = {*VARIABLE.findall(code), *re.findall(r"\w+", " ".join(SIGNATURE.findall(code)))}
    return {*CALLED.findall(code)} - own
