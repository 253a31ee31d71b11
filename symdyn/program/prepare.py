"""Binding times as code: what depends on parameters alone is computed once, by a function of its own.

A function f(x, p) of states x and parameters p is cut at the frontier between what p alone decides and the rest:

    f(x, p) = h(x, P(p))        P: prepare(params) -> prepared, one for all functions of a program

P holds each node that depends on parameters alone and is used by a node that does not, or is an entry of f itself.
Nodes are unique on their graph, so functions share what they have in common; a sign is written where it is used and not
kept, so that P never holds both a and -a; a parameter is in P where h needs it as it stands. No operation of h has all
its operands in P. What is computed, and in which order, does not change, so that both ways give the same rounding.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from symdyn.dynamics import Argument, Function
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, Op, reachable, substitute
from symdyn.program.assemble import assemble
from symdyn.program.routine import Program


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
