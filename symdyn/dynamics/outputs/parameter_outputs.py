"""Derivatives by named parameters: those without a value, and those that have one, which is put in afterwards.

A parameter whose value is zero takes what it multiplies out of the derivation, and so does a formula of parameters that
is zero, such as a mass a - b: their slopes are not zero for that. So the scene is derived once more with these
parameters open. What `bind` has set to zero stands in no formula any more; nobody can differentiate by it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from symdyn.dynamics.outputs.tangent_space import TangentSpace
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, evaluate, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import FormulaError, listed, substituted


def formulas(scene: Scene) -> list[Quantity]:
    """Return what a scene says that names something, values of parameters aside."""
    return [one for one in Quantity.inside(replace(scene, parameters=())) if one.symbols]


def gone(scene: Scene) -> tuple[str, ...]:
    """Return the parameters that are zero and stand in no formula: in those they stood in, zero was put in."""
    named = {name for one in formulas(scene) for name in one.symbols}
    return tuple(p.name for p in scene.parameters if p.name not in named and p.value is not None and _is_zero(p.value))


def _is_zero(value: Quantity) -> bool:
    try:
        return value.express(Graph()).is_zero
    except ZeroDivisionError:  # told where it is computed with
        return False


def names(w: Workspace, only: str = "") -> tuple[str, ...]:
    """Return the parameters that columns stand for.

    Raises:
        DerivationError: the one that was asked for is none, or zero and gone; or there is none at all.
    """
    scene = w.declared
    there = tuple(p.name for p in scene.parameters)
    if only in (one.name for one in scene.inputs):  # held in the same way
        return (only,)
    without = gone(scene)
    if only in without:
        raise DerivationError(
            f"{scene.name}: {only} is zero and stands in no formula any more, so that nothing can be differentiated by "
            "it; give it another value, or none"
        )
    if only and only not in there:
        known = f"there are {listed(there)}" if there else "it has none"
        raise DerivationError(
            f"{scene.name}: {only} is neither an argument (q, qd, qdd, tau, t, inputs) nor a parameter of the "
            f"scene; {known}"
        )
    found = (only,) if only else tuple(name for name in there if name not in without)
    if not found:
        raise DerivationError(
            f"{scene.name} has no named parameter to differentiate by; name one in [parameters], or all by --symbolic"
        )
    return found


def left_out(w: Workspace, only: str) -> str:
    """Return what the text says of parameters that have no column."""
    without = () if only else gone(w.declared)
    return f"; without {listed(without)}, zero and in no formula any more" if without else ""


def opened(w: Workspace) -> Workspace:
    """Return a workspace in which every parameter stands in its formulas: the same one where no zero hides one."""
    scene = w.declared
    values = {p.name: p.value for p in scene.parameters if p.value is not None}
    hidden = {
        p
        for one in formulas(scene)
        if values.keys() >= set(one.symbols) and _vanishes(one, values)
        for p in one.symbols
    }
    hidden |= {name for one in formulas(scene) for name in one.symbols if name in values and _is_zero(values[name])}
    if not hidden:
        return w
    free = tuple(replace(p, value=None) if p.name in hidden else p for p in scene.parameters)
    known = tuple((p.name, _number(values[p.name])) for p in scene.parameters if p.name in hidden)
    closing = replace(w.closing, parameters=(*w.closing.parameters, *known))
    return Workspace(replace(scene, parameters=free), closing)


def _number(value: Quantity) -> float:
    from symdyn.algebra import Floats

    return float(evaluate([value.express(Graph())], Floats(), {})[0])


def _vanishes(formula: Quantity, values: dict[str, Quantity]) -> bool:
    try:
        return _is_zero(substituted(formula, values))
    except FormulaError:  # told where it is computed with
        return False


def slopes(
    w: Workspace,
    only: str,
    space: TangentSpace,
    formulation: str,
    sweep: Callable[..., list[Expr]],
    entries_of: Callable[[Workspace], Sequence[Expr]],
) -> list[Expr]:
    """Return ∂f/∂p row by row, on the graph of the workspace; all else moves in a tangent space."""
    there: Workspace = w.once(opened)
    symbols = [there.graph.symbol(name) for name in names(w, only)]
    entries = entries_of(there)
    found = sweep(entries, [space.by_parameter(there, formulation, one) for one in symbols])
    return found if there is w else substitute(found, {}, w.graph)
