"""Programs: a program is a tuple of routines, a routine is a tuple of named steps.

A step gives a name to a node; every node between two names is printed inside the line that uses it. The nodes stay
what they were, exact expressions on one graph, so a program runs over any algebra: `evaluate(program.outputs, …)`.
A pass is a function `Program -> Program` and ends with `checked`.

A node gets a name when it is used more than once, when it is a sine or cosine, or when the line it would stand in grows
too wide to read. Naming changes no operation and no order. Lines stand in the order of the derivation, which goes from
body to body. Depth first by need was measured too, for inverse and forward dynamics of 6 and 7 axes: as many values
alive at once, and code up to 4 % slower.

    q_1, qd_2    entries of an argument        p_m1    a free parameter by its name
    s1, c2_3     sin q1, cos(q2 + q3)          sa1     sine of any other angle
    x1, x2 ...   what is left

A function f(x, p) of states x and parameters p is cut at the frontier between what p alone decides and the rest:

    f(x, p) = h(x, P(p))        P: prepare(params) -> prepared, one for all functions of a program

P holds each node that depends on parameters alone and is used by a node that does not, or is an entry of f itself.
Nodes are unique on their graph, so functions share what they have in common. A sign is written where it is used, so
that P never holds both a and -a. A parameter is in P where h needs it as it stands. No operation of h has all its
operands in P. The operations and their order do not change, so that both forms give the same rounding.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import count
from typing import ClassVar

from symdyn.algebra import constants
from symdyn.arguments import check_arguments
from symdyn.dynamics import Argument, Function
from symdyn.dynamics.outputs import Counts
from symdyn.errors import DerivationError, UnknownNameError, choice, listed
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, Piecewise, reachable, substitute
from symdyn.program.passes import use_counts
from symdyn.scene import Scene
from symdyn.shown import Shown


@dataclass(frozen=True)
class RoutineStep:
    """One line of a routine: `name` stands for `node` from here on."""

    name: str
    node: Expr


@dataclass(frozen=True)
class Routine:
    """One function as straight-line code."""

    function: Function  # what it computes; its entries are nodes of the program's graph
    inputs: tuple[RoutineStep, ...]  # names of the argument entries that are needed, in calling order
    steps: tuple[RoutineStep, ...]  # named intermediate results, each after all it needs
    unused: tuple[str, ...]  # names of the arguments of which no entry is needed
    binding: Mapping[str, Counts]  # operations of one call by binding time, as `Counts.by_binding` gives them
    operations: frozenset[Op]  # which there are

    @property
    def counts(self) -> Counts:
        return sum(self.binding.values(), Counts())

    @property
    def prepare(self) -> Counts:
        """Operations on parameters alone, the same at every call."""
        return self.binding["params"]

    @property
    def state_counts(self) -> Counts:
        """Operations that depend on the state."""
        return self.counts - self.prepare

    @property
    def names(self) -> dict[Expr, str]:
        return {step.node: step.name for step in self.inputs + self.steps}


@dataclass(frozen=True)
class Program(Shown):
    """The routines of a scene on one graph of their own.

    Attributes:
        scene: the mechanism; its parameters with values are constants here.
        graph: of this program alone; all entries are nodes of it.
        routines: in the order of the equations.
        constants: value of every node without symbols, exact where it is rational, else to 50 digits or more.
        PARAMS, PREPARED: what the arguments are called: free parameters, and what depends on them alone.
        PREPARE: what the function is called that computes these.
    """

    scene: Scene
    graph: Graph
    routines: tuple[Routine, ...]
    constants: Mapping[Expr, Fraction]

    PARAMS: ClassVar[str] = "params"
    PREPARED: ClassVar[str] = "prepared"
    PREPARE: ClassVar[str] = "prepare"

    def __repr__(self) -> str:
        return f"<Program of {self.scene.name}: {listed(one.function.name for one in self.routines)}>"

    def __contains__(self, name: object) -> bool:
        """Tell whether there is a routine called `name`, or asked for by it."""
        return any(name in (routine.function.name, routine.function.request) for routine in self.routines)

    def __getitem__(self, name: str) -> Routine:
        """Return the routine called `name`, or asked for by it; UnknownNameError if there is none."""
        check_arguments(Program.__getitem__, locals(), UnknownNameError)
        for routine in self.routines:
            if name in (routine.function.name, routine.function.request):
                return routine
        raise UnknownNameError(f"no routine {name}; {choice(name, (r.function.name for r in self.routines))}")

    @property
    def outputs(self) -> tuple[Expr, ...]:
        """Entries of all routines, one routine after the other."""
        return tuple(entry for routine in self.routines for entry in routine.function.entries)

    @property
    def is_prepared(self) -> bool:
        """Whether work on parameters alone is in a function of its own, of whose result the others are functions."""
        return any(
            argument.name == Program.PREPARED for routine in self.routines for argument in routine.function.arguments
        )

    @property
    def without_tables(self) -> Program:
        """The program with other operations for every table of numbers."""
        if not any(Op.TABLE in routine.operations for routine in self.routines):
            return self
        graph, found = Graph(), []
        for function in (routine.function for routine in self.routines):
            symbols = [
                tuple(graph.symbol(str(one.value)) for one in argument.symbols) for argument in function.arguments
            ]
            given = zip(function.arguments, symbols, strict=True)
            arguments = tuple(replace(argument, symbols=some) for argument, some in given)
            entries = tuple(Piecewise.all_opened(function.entries, graph))
            found.append(replace(function, arguments=arguments, entries=entries, solve=None))
        return assemble(self.scene, graph, tuple(found)).checked()

    def checked(self) -> Program:
        """Return it after asserting what every pass must keep: names are unique and defined before they are used."""
        for routine in self.routines:
            where = routine.function.name
            names = [step.name for step in routine.inputs + routine.steps]
            assert len(set(names)) == len(names), f"{where}: a name is given twice"
            size = 1
            for length in routine.function.shape:
                size *= length
            there = size if not routine.function.is_loop_alone else 0
            shape = routine.function.shape
            assert len(routine.function.entries) == there, f"{where}: shape {shape} and entries disagree"
            defined = {*self.constants, *(step.node for step in routine.inputs)}
            for step in routine.steps:
                late = _undefined(step.node, defined)
                assert not late, f"{where}: {step.name} needs {late}, which come later or are no arguments"
                defined.add(step.node)
            for entry in routine.function.entries:
                missing = _undefined(entry, defined)
                assert not missing, f"{where} needs {missing}, which are none of its arguments"
        return self


def _undefined(node: Expr, defined: set[Expr]) -> list[Expr]:
    """Return the symbols below `node` that are reached without passing a defined node."""
    found, stack, seen = [], [node], set()
    while stack:
        here = stack.pop()
        if here in defined or here in seen:
            continue
        seen.add(here)
        if here.op is Op.SYMBOL:
            found.append(here)
        stack += here.args
    return found


NEG, SYMBOL = Op.NEG, Op.SYMBOL  # see `Op`

Constants = Mapping[Expr, Fraction]

WIDEST = 100
"""Characters that an expression may take, estimated, before a part of it gets a name and a line of its own."""

NAME, OPERATOR, CALL = 5, 3, 12
"""Estimated characters of a name, of an operator with its spaces, of a function with its parentheses."""

ANGULAR = (Op.SIN, Op.COS)
"""Operations that always get a name, of their angle."""


def shared(arguments: Sequence[str]) -> str:
    """Return which of a function's arguments all states of a batch have in common, "" if there is none.

    These are the parameters, or what was prepared from them. Where there is no state beside them each set of them is
    a state of its own.
    """
    return next((name for name in arguments if name in (Program.PARAMS, Program.PREPARED) and len(arguments) > 1), "")


def assemble(scene: Scene, graph: Graph, functions: tuple[Function, ...]) -> Program:
    """Return the program whose routines compute `functions`, whose nodes are all on `graph`."""
    known = constants([entry for function in functions for entry in function.entries])
    routines = tuple(_routine(function, known) for function in functions)
    return Program(scene, graph, routines, known)


def _routine(function: Function, known: Constants) -> Routine:
    if function.is_loop_alone:
        return Routine(function, (), (), (), Counts.by_binding(function), frozenset())
    needed = [node for node in reachable(function.entries) if node not in known]
    symbols = {node for node in needed if node.op is SYMBOL}
    lines = _lines(function, needed, known)
    return Routine(
        function=function,
        inputs=tuple(
            RoutineStep(_input_name(argument, place), symbol)
            for argument in function.arguments
            for place, symbol in enumerate(argument.symbols)
            if symbol in symbols
        ),
        steps=_named(lines, function),
        unused=tuple(a.name for a in function.arguments if symbols.isdisjoint(a.symbols)),
        binding=Counts.by_binding(function),
        operations=frozenset(node.op for node in needed),
    )


def _input_name(argument: Argument, place: int) -> str:
    """Return the local name of an argument's entry; the underscore keeps it apart from every other name."""
    if argument.name == Program.PARAMS:
        return f"p_{identifier(str(argument.symbols[place].value))}"
    return f"{argument.name}_{place + 1}"


def identifier(text: str) -> str:
    """Return `text` in letters, digits and underscores, as every target allows them; α becomes u03b1."""
    return "".join(c if c.isascii() and c.isalnum() else "_" if c.isascii() else f"u{ord(c):04x}" for c in text)


# Which nodes are lines


def _lines(function: Function, needed: list[Expr], known: Constants) -> list[Expr]:
    """Return the nodes that get a name, arguments first."""
    uses = use_counts(function.entries, needed)
    named: set[Expr] = set()
    width: dict[Expr, int] = {}
    for node in needed:
        if node.op is SYMBOL:
            width[node] = NAME
            continue
        here = _shortened(node, width, named, known)
        if node.op in ANGULAR or node.op is Op.TABLE or (uses[node] > 1 and node.op is not NEG):
            named.add(node)
        width[node] = NAME if node in named else here
    return [node for node in needed if node in named]


def _shortened(node: Expr, width: dict[Expr, int], named: set[Expr], known: Constants) -> int:
    """Name operands of `node`, the widest first, until it fits a line; return how wide it is then."""
    while (here := _width(node, width, known)) > WIDEST:
        widest = max((arg for arg in node.args if arg in width), key=lambda arg: width[arg])
        inner = widest.args[0] if widest.op is NEG else widest
        named.add(inner)
        width[inner] = NAME
        width[widest] = NAME
    return here


def _width(node: Expr, width: Mapping[Expr, int], known: Constants) -> int:
    """Return about how many characters `node` takes when it is printed in full."""
    parts = sum([_digits(known[arg]) if arg in known else width[arg] for arg in node.args])
    return parts + (CALL if node.op.is_function else OPERATOR)


def _digits(value: Fraction) -> int:
    """Return about how many characters a constant takes; a double never takes more than 24."""
    return min(24, 3 + (value.numerator.bit_length() + value.denominator.bit_length()) // 3)


# Which names they get


def _named(lines: list[Expr], function: Function) -> tuple[RoutineStep, ...]:
    joints = {symbol: i for a in function.arguments if a.name == "q" for i, symbol in enumerate(a.symbols, 1)}
    angles: dict[Expr, str] = {}
    others = count(1)
    steps: list[RoutineStep] = []
    plain = 0
    for node in lines:
        if node.op in ANGULAR:
            angle = node.args[0]
            if angle not in angles:
                angles[angle] = _angle_label(angle, joints) or f"a{next(others)}"
            steps.append(RoutineStep(("s" if node.op is Op.SIN else "c") + angles[angle], node))
        else:
            plain += 1
            steps.append(RoutineStep(f"x{plain}", node))
    return tuple(steps)


def _angle_label(angle: Expr, joints: Mapping[Expr, int]) -> str:
    """Return 2_3 for q2 + q3, "" for any other angle; the graph has one form of each sum."""
    form = angle.linear_form()
    plain = form.turns == form.constant == 0 and all(node in joints and factor == 1 for node, factor in form.terms)
    if plain and form.terms:
        return "_".join(str(number) for number in sorted(joints[node] for node, _ in form.terms))
    return ""


def prepare(program: Program) -> Program:
    """Return the program with work on parameters alone in a function `prepare`, the first one.

    Its result, `prepared` of shape (K,), is the last argument of all other functions in place of `params`. A program
    whose functions have no free parameters stays as it is.

    Raises:
        DerivationError: a function is called `prepare` already.
    """
    functions = [routine.function for routine in program.routines]
    params = next((a for function in functions for a in function.arguments if a.name == Program.PARAMS), None)
    if params is None:
        return program
    if any(function.name == Program.PREPARE for function in functions):
        raise DerivationError(f"{program.scene.name}: a function is called {Program.PREPARE} already; rename it")
    frontier = dict.fromkeys(node for function in functions for node in _frontier(function))
    kept = sorted(frontier, key=lambda node: node.index)
    graph = Graph()
    symbols = [graph.symbol(f"{Program.PREPARED}[{place}]") for place in range(len(kept))]
    first = Function(
        name=Program.PREPARE,
        text=f"values that depend on parameters alone, the argument {Program.PREPARED} of all other functions",
        arguments=(replace(params, symbols=tuple(graph.symbol(str(one.value)) for one in params.symbols)),),
        result=Program.PREPARED,
        shape=(len(kept),),
        entries=tuple(substitute(kept, {}, graph)),
        units="",
        formulation="hoisted",
    )
    text = f"result of {Program.PREPARE}({Program.PARAMS}), from {_sources(kept, params)}"
    prepared = Argument(Program.PREPARED, tuple(symbols), text, ())
    values = dict(zip(kept, symbols, strict=True))
    rest = tuple(
        replace(
            function,
            arguments=tuple(
                prepared
                if argument.name == Program.PARAMS
                else replace(argument, symbols=tuple(graph.symbol(str(one.value)) for one in argument.symbols))
                for argument in function.arguments
            ),
            entries=tuple(substitute(function.entries, values, graph)),
            solve=None,
        )
        for function in functions
    )
    return assemble(program.scene, graph, (first, *rest)).checked()


def _frontier(function: Function) -> Iterable[Expr]:
    """Return the nodes that `function` needs of what depends on parameters alone."""
    parameters = {symbol for a in function.arguments if a.name == Program.PARAMS for symbol in a.symbols}
    early: set[Expr] = set()
    late: set[Expr] = set()
    for node in reachable(function.entries):
        if node in parameters or (node.op is not Op.SYMBOL and not late.intersection(node.args)):
            if node in parameters or early.intersection(node.args):
                early.add(node)
        else:
            late.add(node)
            yield from (_unsigned(arg) for arg in node.args if arg in early)
    yield from (_unsigned(entry) for entry in function.entries if entry in early)


def _unsigned(node: Expr) -> Expr:
    return node.args[0] if node.op is Op.NEG else node


def _sources(kept: Iterable[Expr], params: Argument) -> str:
    """Return the names of the parameters behind `kept`, in their order."""
    needed = {node.value for node in reachable(kept)}
    return ", ".join(str(one.value) for one in params.symbols if one.value in needed) or "none of them"
