"""From equations to a program: bind what has a value, fold what is constant, run the passes, name what is used.

The program gets a graph of its own. What is bound there simplifies at birth, and the equations are left as they were.

A function whose result is solved in rows is lines up to right sides and factors, and steps over rows after them.
Entries of it are lines like any other's; a target that has a loop over rows asks for the lines before it, and for its
steps in places of what the lines compute:

    r    a row of one pitch for each of the result: columns of the solution, then all others, each part filled up to
         whole vectors with zeros; more rows; then factors

These lines are lowered when they are first asked for; whoever prints all entries never pays for them.

Of the derivations of an output the one that was asked for becomes code, else the one that its row prefers. From so many
joints on as `TABLE_LOOPS` says what can be a loop over a table is one in the languages that have it, beside the lines
by the preferred formulation, and these need not be derived at all. A formulation that is asked for is taken at any
number of joints.

Closed forms with sums of angles are no formulation: they trade multiplications for sines, and a rounded sum of angles
has lost digits that the product form keeps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import ClassVar
from weakref import WeakKeyDictionary

from symdyn.algebra import constants, is_simple
from symdyn.arguments import checked
from symdyn.dynamics import (
    Argument,
    Equations,
    Function,
    LoopChoices,
    PairRuns,
    Velocities,
    Workspace,
    derive_one,
    formulations_of,
    known_formulation,
    loop_alone,
)
from symdyn.dynamics.mechanism import RowSolve
from symdyn.dynamics.outputs import Counts
from symdyn.errors import ArgumentError, DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, growing, reachable, substitute
from symdyn.program.passes import DEFAULT, optimise
from symdyn.program.routine import Program, assemble
from symdyn.scene import Scene

Functions = tuple[Function, ...]


@growing()
@checked(ArgumentError)
def lower(equations: Equations, passes: Sequence[str] = DEFAULT) -> Program:
    """Return the program of `equations`: pruned, parameters with values bound, constants folded, operations saved.

    >>> import symdyn
    >>> from symdyn.emit import emit
    >>> program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.example("cart_pole"), ["mass_matrix"]))
    >>> program
    <Program of cart_pole: mass_matrix>
    >>> list(emit(program, "c").texts)
    ['cart_pole.c', 'cart_pole.h']

    Args:
        equations: named functions on one graph.
        passes: keys of `PASSES`; () leaves the operations as they were derived.

    Raises:
        DerivationError: a constant is not a finite real number, such as 1/m with m = 0 bound, or an unknown pass.
    """
    functions = _fold(_bind(equations))
    if passes := tuple(passes):
        # one that says the same under another name, as k_z does, takes no passes
        done: dict[tuple[Expr, ...], Function] = {}
        for function in functions:
            if function.entries not in done:
                done[function.entries] = optimise(function, passes)
        functions = _fold(
            _gather(tuple(replace(function, entries=done[function.entries].entries) for function in functions))
        )
    graph, functions = _at_home(functions, equations.graph)
    return assemble(equations.scene, graph, functions).checked()


@growing()
def count_derived(equations: Equations) -> list[dict[str, Counts]]:
    """Return the operations of every function by binding time, as it was derived: no pass has saved any."""
    return [Counts.by_binding(function) for function in _bind(equations)]


def entries_of(functions: Functions) -> list[Expr]:
    """Return the entries of all functions, one function after the other."""
    return [entry for function in functions for entry in function.entries]


def _bind(equations: Equations) -> Functions:
    """Return the functions with the values of parameters in their place; as they are if there are none."""
    scene, functions, graph = equations.scene, equations.functions, Graph()
    values = {parameter.name: parameter.value for parameter in scene.parameters if parameter.value is not None}
    bound: dict[Expr, Expr] = {}
    for node in reachable(entries_of(functions)) if values else ():
        if node.op is Op.SYMBOL and node.value in values:
            bound[node] = values[str(node.value)].express(graph)
    if not bound:
        return functions
    try:
        return _rebuild(functions, bound, graph)
    except ZeroDivisionError as fault:
        names = ", ".join(function.name for function in functions if _divides_by_zero(function, bound))
        raise DerivationError(
            f"{scene.name}: with its parameters' values {names} would divide by zero: a mass matrix is singular then, "
            "or a formula has no value; give another value, or none to keep the parameter free"
        ) from fault


def _divides_by_zero(function: Function, bound: Mapping[Expr, Expr]) -> bool:
    graph = Graph()
    try:
        substitute(function.entries, {node: substitute([value], {}, graph)[0] for node, value in bound.items()}, graph)
    except ZeroDivisionError:
        return True
    return False


def _fold(functions: Functions) -> Functions:
    """Return the functions with hidden fractions, zeros above all, in the open, so that their products simplify."""
    known = constants(entries_of(functions))
    hidden = {node: value for node, value in known.items() if node.op is not Op.CONSTANT and is_simple(value)}
    if not hidden:
        return functions
    target = Graph()
    try:
        return _rebuild(functions, {node: target.constant(value) for node, value in hidden.items()}, target)
    except ZeroDivisionError as fault:
        raise DerivationError("the equations divide by a constant that is zero") from fault


def _gather(functions: Functions) -> Functions:
    """Return functions that live on graphs of their own on one new graph; a single one stays where it is."""
    graph = Graph()
    if len(functions) == 1:
        return functions
    return tuple(one for function in functions for one in _rebuild((function,), {}, graph))


def _at_home(functions: Functions, theirs: Graph) -> tuple[Graph, Functions]:
    """Return functions of one graph on a graph of the program, the symbols of their arguments as well."""
    entries = entries_of(functions)
    graph = entries[0].graph if entries else Graph()
    if graph is theirs:
        graph = Graph()
        return graph, _rebuild(functions, {}, graph)
    return graph, tuple(
        replace(function, arguments=tuple(_rebuild_argument(argument, graph) for argument in function.arguments))
        for function in functions
    )


def _rebuild(functions: Functions, values: Mapping[Expr, Expr], graph: Graph) -> Functions:
    entries = iter(substitute(entries_of(functions), values, graph))
    return tuple(
        replace(
            function,
            arguments=tuple(_rebuild_argument(argument, graph) for argument in function.arguments),
            entries=tuple(next(entries) for _ in function.entries),
        )
        for function in functions
    )


def _rebuild_argument(argument: Argument, graph: Graph) -> Argument:
    return replace(argument, symbols=tuple(graph.symbol(str(symbol.value)) for symbol in argument.symbols))


LANES_AT_ONCE = 8
"""Columns of a vector, to whole ones of which rows are filled up with zeros."""

FEWEST, FEWEST_OF_SPARSE, FEWEST_OF_PAIRS, SPARSE = 500, 5000, 8000, 1 / 3
"""Products of a solve from which it is taken in rows, those of sparse rows, entries from which pairs are a loop; rows
multiply zeros too: lines that have a smaller part of their products are faster."""


@dataclass(frozen=True)
class RowStepAt:
    """A step in places of r: where its row begins, its scale, and of each term factor and where its row begins."""

    row: int
    scale: int
    terms: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class RowLoop:
    """Lines before a loop over rows, and its steps.

    Attributes:
        program: of one function, the lines; its entries are r.
        width: columns that a step goes over, whole vectors.
        steps: in order.
        places: where in r each entry of the result is, when all steps are done.
        switched, turned: as of `RowSolve`, by places of r.
    """

    program: Program
    width: int
    steps: tuple[RowStepAt, ...]
    places: tuple[int, ...]
    switched: bool
    turned: tuple[tuple[int, int], ...] | None

    HOW: ClassVar = "solved in rows"

    @staticmethod
    def of(function: Function) -> RowLoop | PairLoop | None:
        """Return that of a function, or its loop over pairs; None where it has lines alone, or few products."""
        solve = function.solve
        few = len(function.entries) < FEWEST_OF_PAIRS
        if isinstance(solve, RowSolve):
            few = solve.products < (FEWEST if solve.products > SPARSE * solve.dense else FEWEST_OF_SPARSE)
        if solve is None or few:
            return None
        if solve not in _FOUND:
            _FOUND[solve] = _lowered(function, solve)
        return _FOUND[solve]

    @property
    def entries(self) -> tuple[Expr, ...]:
        """Entries of r, before the first step."""
        return self.program.routines[0].function.entries

    @property
    def vectors(self) -> int:
        """Vectors that a step goes over."""
        return self.width // LANES_AT_ONCE

    def composed(self, entries: Sequence[Expr]) -> list[Expr]:
        """Return the entries of the result from those of r, on any graph."""
        r = list(entries)
        for step in self.steps:
            for c in range(self.width):
                taken = ((r[factor], r[row + c]) for factor, row in step.terms)
                r[step.row + c] = RowSolve.stepped(r[step.row + c], r[step.scale], taken)
        found = [r[place] for place in self.places]
        return found if self.turned is None else RowSolve.added(found, ((to, r[at]) for to, at in self.turned))


@dataclass(frozen=True)
class PairLoop:
    """Lines before a loop over pairs of velocities, which has the same form for all scenes."""

    program: Program  # of one function, the lines; its entries are the numbers of all velocities
    velocities: Velocities  # whose pairs there are

    HOW: ClassVar = "in runs of pairs"

    @property
    def entries(self) -> tuple[Expr, ...]:
        return self.program.routines[0].function.entries

    def composed(self, entries: Sequence[Expr]) -> list[Expr]:
        """Return the entries of the result from those numbers, on any graph."""
        return PairRuns.composed(self.velocities, entries)


_FOUND: WeakKeyDictionary[RowSolve | PairRuns, RowLoop | PairLoop] = WeakKeyDictionary()


def _lowered(function: Function, solve: RowSolve | PairRuns) -> RowLoop | PairLoop:
    if isinstance(solve, PairRuns):
        return PairLoop(_lines(function, solve.scene, solve.numbers), solve.velocities)
    factors, columns = solve.factors, len(solve.beside[0])
    graph, width = factors[0].graph, _filled(solve.width)
    pitch = width + _filled(columns - solve.width)
    entries = [graph.zero] * (pitch * solve.rows)
    places = tuple(
        pitch * i + (j if j < solve.width else width + j - solve.width)
        for i in range(len(solve.beside))
        for j in range(columns)
    )
    for place, entry in zip(places, chain(*solve.beside), strict=True):
        entries[place] = entry or graph.zero
    for row, side in solve.sides:
        entries[pitch * row : pitch * row + solve.width] = side
    factors = tuple(dict.fromkeys((*factors, *(more for _, more in solve.turned or ()))))
    at = {factor: len(entries) + k for k, factor in enumerate(factors)}
    turned = None if solve.turned is None else tuple((to, at[more]) for to, more in solve.turned)
    steps = (
        RowStepAt(pitch * one.row, at[one.scale], tuple((at[factor], pitch * row) for factor, row in one.terms))
        for one in solve.steps
    )
    return RowLoop(
        _lines(function, solve.scene, (*entries, *factors)), width, tuple(steps), places, solve.switched, turned
    )


def _lines(function: Function, scene: Scene, entries: tuple[Expr, ...]) -> Program:
    """Return the program of what is before a loop."""
    graph = entries[0].graph
    given = [replace(a, symbols=tuple(graph.symbol(str(x.value)) for x in a.symbols)) for a in function.arguments]
    lines = replace(function, arguments=tuple(given), shape=(len(entries),), entries=entries, solve=None)
    return lower(Equations(scene, graph, (lines,)))


def _filled(columns: int) -> int:
    return -(-columns // LANES_AT_ONCE) * LANES_AT_ONCE


@growing()
def formulate(
    scene: Scene,
    outputs: Sequence[str],
    formulation: str | None = None,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
    lines: bool = True,
) -> Equations:
    """Return the equations of a scene, each output by the formulation that becomes code.

    Args:
        scene: the mechanism.
        outputs: as for `derive`.
        formulation: take this derivation wherever a function has it; None takes the one that is preferred for each.
        closing: what to choose about closed loops.
        lines: whether loops over tables are derived in lines as well; `emit` does it where it has to. Beside functions
            that are no loops they always are.

    Raises:
        DerivationError: an unknown output, body or point, equations that do not exist, a formulation that no output
            has.
    """
    workspace = Workspace(scene, closing)
    if closing.independent:
        _ = workspace.loops.decisions
    return Equations(scene, workspace.graph, choose(workspace, outputs, formulation, lines), closing)


def choose(
    workspace: Workspace, outputs: Sequence[str], formulation: str | None = None, lines: bool = True
) -> tuple[Function, ...]:
    """Return the outputs on the workspace's graph; see `formulate`."""
    known_formulation(workspace.scene, outputs, formulation)
    lines = lines or not all(loop_alone(workspace, request, formulation) for request in outputs)
    return tuple(choose_one(workspace, request, formulation, lines) for request in outputs)


@growing()
def choose_one(workspace: Workspace, request: str, formulation: str | None = None, lines: bool = True) -> Function:
    """Return one output by the formulation that was asked for, if it has that, else by the one that its row prefers.

    Without `lines` a loop over a table is not derived in lines as well, where it need not be.
    """
    alone = loop_alone(workspace, request, formulation)
    if alone and not lines and not (alone.loop and alone.loop.may_fail(workspace.scene)):
        return alone
    if formulation in formulations_of(request, workspace.scene):
        return derive_one(workspace, request, formulation)
    found = derive_one(workspace, request)
    return replace(found, loop=alone.loop) if alone else found


def in_lines(program: Program, rows: bool = False) -> Program:
    """Return the program without loops, but for those over `rows`; functions without entries are derived now."""
    functions = [routine.function for routine in program.routines]
    if any(function.is_loop_alone for function in functions):
        program = lower(formulate(program.scene, [function.request for function in functions]))
    elif not any(function.loop or function.solve for function in functions):
        return program
    bare = (replace(one.function, loop=None, solve=one.function.solve if rows else None) for one in program.routines)
    plain = (replace(one, function=function) for one, function in zip(program.routines, bare, strict=True))
    return replace(program, routines=tuple(plain))
