"""What a template is given: every piece of a file as finished text, the same for all targets up to the code itself."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from symdyn.dynamics import Argument, TableLoop
from symdyn.dynamics.outputs import Counts
from symdyn.emit.code.identifiers import function_names, stem
from symdyn.emit.code.operators import Printer
from symdyn.graph import Op
from symdyn.program import Program, Routine


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
        for argument in self.arguments:
            places = sorted(place for _, name, place in self.inputs if name == argument.name)
            whole = argument.scalar or len(places) == argument.length
            parts = _ranges(places, self.first)
            needed += [argument.name if whole else f"{argument.name}[{part}]" for part in parts]
            needed = list(dict.fromkeys(needed))
        if not needed:
            return ""
        listed = " or ".join([", ".join(needed[:-1]), needed[-1]] if len(needed) > 1 else needed)
        return f"A NaN in {listed} makes what depends on it NaN, and raises nothing."


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
    """

    scene: str
    command: str
    functions: tuple[FunctionText, ...]
    arguments: tuple[ArgumentText, ...]
    parameters: tuple[tuple[str, str, str], ...]
    first: int


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
    return Page(program.scene.name, command, functions, tuple(arguments.values()), parameters, first)


def _function(program: Program, routine: Routine, name: str, printer: Printer, first: int) -> FunctionText:
    """Return one routine as text."""
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
        outputs=tuple(Line(str(index), "") for (index,) in _indices(function.shape, first)),
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
