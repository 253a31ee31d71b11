"""Programs from functions on a graph: which nodes become lines, which names they get, and what is prepared beforehand.

A node gets a name when it is used more than once, when it is a sine or cosine, or when the line it would stand in grows
too wide to read. Everything else is printed inside the line that uses it. Naming changes no operation and no order.
Lines stand in the order of the derivation, which goes from body to body. Depth first by need was measured too, for
inverse and forward dynamics of 6 and 7 axes: as many values alive at once, and code up to 4 % slower.

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
from dataclasses import replace
from fractions import Fraction
from itertools import count

from symdyn.algebra import constants
from symdyn.dynamics import Argument, Function
from symdyn.dynamics.outputs import Counts
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, Op, reachable, substitute
from symdyn.program.routine import Program, Routine, RoutineStep
from symdyn.scene import Scene

NEG, SYMBOL = Op.NEG, Op.SYMBOL  # see `Op`

Constants = Mapping[Expr, Fraction]

WIDEST = 100
"""Characters that an expression may take, estimated, before a part of it gets a name and a line of its own."""

NAME, OPERATOR, CALL = 5, 3, 12
"""Estimated characters of a name, of an operator with its spaces, of a function with its parentheses."""

ANGULAR = (Op.SIN, Op.COS)
"""Operations that always get a name."""


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
    """Return one function as named steps."""
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
    uses = _uses(function, needed)
    named: set[Expr] = set()
    width: dict[Expr, int] = {}
    for node in needed:
        if node.op is SYMBOL:
            width[node] = NAME
            continue
        here = _shortened(node, width, named, known)
        if node.op in ANGULAR or (uses[node] > 1 and node.op is not NEG):
            named.add(node)
        width[node] = NAME if node in named else here
    return [node for node in needed if node in named]


def _uses(function: Function, needed: list[Expr]) -> dict[Expr, int]:
    """Return how many lines use each node; a sign is written wherever it is used, so its operand is used there."""
    uses = dict.fromkeys(needed, 0)
    for entry in function.entries:
        if entry in uses:
            uses[entry] += 1
    for node in reversed(needed):
        more = uses[node] if node.op is NEG else 1
        for arg in node.args:
            if arg in uses:
                uses[arg] += more
    return uses


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
    """Return the steps with their names."""
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
