"""Running derived functions on numbers of any kind."""

from __future__ import annotations

import random
from collections.abc import Container, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

from symdyn.dynamics import Equations, Workspace, derive_one, formulations_of
from symdyn.dynamics.reactions.dalembert import Equilibrium
from symdyn.dynamics.reactions.free_bodies import as_rows
from symdyn.graph import Algebra, Expr, evaluate
from symdyn.scene import Scene
from symdyn.verify.equality import Claim, eliminate


@lru_cache(maxsize=64)
def workspace(one: Scene) -> Workspace:
    """Return the workspace of a scene, one for all tests: what one has derived the next ones find."""
    return Workspace(one)


def agreements(w: Workspace, requests: Iterable[str], slow: Container[tuple[str, str]] = ()) -> list[Claim]:
    """Return that all formulations of outputs find the same, but for pairs of these that take too long."""
    claims = []
    for request in requests:
        formulations = [
            formulation for formulation in formulations_of(request, w.scene) if (request, formulation) not in slow
        ]
        first, *others = (derive_one(w, request, formulation) for formulation in formulations)
        claims += [Claim(request, first.formulation, o.formulation, first.entries, o.entries) for o in others]
    return claims


def call(equations: Equations, name: str, algebra: Algebra[Any], **arguments: Sequence[Any]) -> list[Any]:
    """Return the entries of a derived function, row by row.

    Args:
        equations: from `derive`.
        name: of the function.
        algebra: what to compute with.
        arguments: q, qd, qdd, tau, params; each a sequence of values of the algebra. More than needed is fine.
    """
    function = equations[name]
    values = dict(settings(equations, algebra))
    for argument in function.arguments:
        values.update(zip(argument.symbols, arguments[argument.name], strict=True))
    return evaluate(function.entries, algebra, values)


def solved_reactions(scene: Scene, axes: str, algebra: Algebra[Any], **arguments: Sequence[Any]) -> list[Any]:
    """Return reactions from the whole system (5.18), row by row, with pivots that the numbers choose.

    Args:
        scene: a mechanism whose reactions are unique, but for what goes across the planes of its loops.
        axes: as of `reactions`.
        algebra: what to compute with.
        arguments: q, qd, qdd, params.
    """
    w = Workspace(scene)
    system = Equilibrium.of(w.hanging)
    known = {p.name: p.value.express(w.graph) for p in scene.parameters if p.value is not None}
    values = {w.graph.symbol(name): evaluate([node], algebra, {})[0] for name, node in known.items()}
    for symbols, name in ((w.state.q, "q"), (w.state.qd, "qd"), (w.state.qdd, "qdd")):
        values.update(zip(symbols, arguments[name], strict=True))
    free = [w.graph.symbol(parameter.name) for parameter in scene.free_parameters]
    values.update(zip(free, arguments.get("params", ()), strict=True))
    sizes = [w.graph.symbol(f"x[{k}]") for k in range(len(system.unknowns))]
    values.update(zip(sizes, solved_at(system, algebra, values), strict=True))
    whole = system.elements()  # axes of joint frames
    for unknown, size in zip(system.unknowns, sizes, strict=True):
        for h, wrench in unknown.acts:
            whole[h] = whole[h] + wrench.scaled(size)
    shown = (*w.hanging.joints, *w.hanging.loops)
    wrenches = [hinge.on_child(one) for hinge, one in zip(shown, whole, strict=False)]
    return evaluate(as_rows(w.hanging, wrenches, axes), algebra, values)


def solved_at(system: Equilibrium, algebra: Algebra[Any], values: Mapping[Expr, Any]) -> list[Any]:
    """Return x with A x + b = 0 of (5.18) at one place, shape (unknowns,), which the equations determine there."""
    rows = system.rows()
    found = iter(evaluate([entry for row in rows for entry in row.values()], algebra, dict(values)))
    zero = evaluate([system.hanging.graph.zero], algebra, {})[0]
    done = eliminate([{c: next(found) for c in row} for row in rows], len(system.unknowns), algebra, zero, abs)
    assert not done.free, "the equations determine all unknowns"
    return done.x


def settings(equations: Equations, algebra: Algebra[Any]) -> dict[Any, Any]:
    """Return the values of the parameters that have one."""
    graph = equations.graph
    known = {p.name: p.value.express(graph) for p in equations.scene.parameters if p.value is not None}
    return {graph.symbol(name): evaluate([node], algebra, {})[0] for name, node in known.items()}


def matrix(entries: Sequence[Any], columns: int) -> list[list[Any]]:
    """Return entries as rows."""
    return [list(entries[k : k + columns]) for k in range(0, len(entries), columns)]


def random_fractions(rng: random.Random, n: int, reach: int = 2) -> list[Fraction]:
    """Return n rationals in -reach .. reach, none of them zero."""
    return [Fraction(rng.choice((-1, 1)) * rng.randint(1, 1000 * reach), 1000) for _ in range(n)]
