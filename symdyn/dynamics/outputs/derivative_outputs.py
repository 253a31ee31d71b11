"""Derivatives of outputs along their arguments: rows of OUTPUTS that a scene has when it is asked for them.

`tangent_space` has the legend. A way to J that is better than differentiation of a graph is a row of JACOBIANS; all
that is asked of J has it then. Where a function has a kink, in words: behind the text of its derivatives, which are
one-sided there or none.

Named parameters are differentiated by, too: those without a value, and those that have one, which is put in afterwards.
A parameter whose value is zero takes what it multiplies out of the derivation, and so does a formula of parameters that
is zero, such as a mass a - b: their slopes are not zero for that. So the scene is derived once more with these
parameters open. What `bind` has set to zero stands in no formula any more; no derivative by it exists.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

from symdyn.arguments import argument
from symdyn.dynamics.mechanism.linear_solve import RowSolve
from symdyn.dynamics.mechanism.state import INPUTS, STATES, TIME
from symdyn.dynamics.outputs import held_outputs, recursive_derivatives
from symdyn.dynamics.outputs.output import Constrained, Formulation, Output, Size, by_loop
from symdyn.dynamics.outputs.result_labels import Axis
from symdyn.dynamics.outputs.tangent_space import COLUMNS, FREE, SWEEPS, TangentSpace
from symdyn.dynamics.outputs.tree_formulations import forward_loop
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.derivative_sweeps import rnea_derivatives_loop
from symdyn.dynamics.recursive.table_loops import aba_derivatives_loop
from symdyn.errors import DerivationError, listed
from symdyn.graph import Expr, Op, reachable, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import vanishes


def _with_letters(scene: Scene) -> list[Quantity]:
    """Return what a scene says that names something, values of parameters aside."""
    return [one for one in Quantity.inside(replace(scene, parameters=())) if one.symbols]


def _gone(scene: Scene) -> tuple[str, ...]:
    """Return the parameters that are zero and stand in no formula: in those they stood in, zero was put in."""
    named = {name for one in _with_letters(scene) for name in one.symbols}
    return tuple(p.name for p in scene.parameters if p.name not in named and p.value is not None and p.value.is_zero)


def parameters_of(w: Workspace, only: str = "") -> tuple[str, ...]:
    """Return the parameters that columns stand for.

    Raises:
        DerivationError: the one that was asked for is none, or zero and gone; or there is none at all.
    """
    scene = w.declared
    there = tuple(p.name for p in scene.parameters)
    if only in (one.name for one in scene.given):  # held in the same way
        return (only,)
    without = _gone(scene)
    if only in without:
        raise DerivationError(
            f"{scene.name}: {only} is zero and stands in no formula any more, so that nothing can be differentiated by "
            "it; give it another value, or none"
        )
    if only and only not in there:
        known = f"there are {listed(there)}" if there else "it has none"
        raise DerivationError(
            f"{scene.name}: {only} is neither an argument (q, qd, qdd, tau, t, inputs, states) nor a parameter of "
            f"the scene; {known}"
        )
    found = (only,) if only else tuple(name for name in there if name not in without)
    if not found:
        others = argument("symbolic", "all", "symdyn.scene.with_symbols")
        raise DerivationError(
            f"{scene.name} has no named parameter to differentiate by; name one in [parameters], or all by {others}"
        )
    return found


def parameters_left_out(w: Workspace, only: str) -> str:
    """Return what the text says of parameters that have no column."""
    without = () if only else _gone(w.declared)
    return f"; without {listed(without)}, zero and in no formula any more" if without else ""


def _opened(w: Workspace) -> Workspace:
    """Return a workspace in which every parameter stands in its formulas: the same one where no zero hides one."""
    scene = w.declared
    values = {p.name: p.value for p in scene.parameters if p.value is not None}
    hidden = {
        p
        for one in _with_letters(scene)
        if values.keys() >= set(one.symbols) and vanishes(one, values)
        for p in one.symbols
    }
    hidden |= {name for one in _with_letters(scene) for name in one.symbols if name in values and values[name].is_zero}
    if not hidden:
        return w
    free = tuple(replace(p, value=None) if p.name in hidden else p for p in scene.parameters)
    known = tuple((p.name, float(values[p.name])) for p in scene.parameters if p.name in hidden)
    closing = replace(w.closing, parameters=(*w.closing.parameters, *known))
    return Workspace(replace(scene, parameters=free), closing)


def slopes_by_parameters(
    w: Workspace,
    only: str,
    space: TangentSpace,
    formulation: str,
    sweep: Callable[..., list[Expr]],
    entries_of: Callable[[Workspace], Sequence[Expr]],
) -> list[Expr]:
    """Return ∂f/∂p row by row, on the graph of the workspace; all else moves in a tangent space."""
    there: Workspace = w.once(_opened)
    symbols = [there.graph.symbol(name) for name in parameters_of(w, only)]
    entries = entries_of(there)
    found = sweep(entries, [space.by_parameter(there, formulation, one) for one in symbols])
    return found if there is w else substitute(found, {}, w.graph)


MOST = 6
"""Names that are told of one kink."""


def kinks(entries: Sequence[Expr], varied: Collection[Expr]) -> str:
    """Return what the text of derivatives says of signs, absolute values, roots and angles; "" without such."""
    moving = set(varied)
    below = _below(entries, moving)
    jumps = [node.args[0] for node in below if node.op in (Op.SIGN, Op.ABS)]
    chosen = [guard for node in below if node.op in (Op.SELECT, Op.TABLE) for guard in node.guards]
    roots = [node.args[0] for node in below if node.op is Op.SQRT]
    angles = [node for node in below if node.op is Op.ATAN2]
    words = []
    if jumps:
        words.append(
            f"one-sided where a sign or an absolute value turns over, of {_names(jumps, moving)}: there a sign is "
            "taken for constant, an absolute value for flat"
        )
    if chosen:
        words.append(f"one-sided where a choice turns over, of {_names(chosen, moving)}: there it is that of below")
    if roots:
        words.append(f"no number (NaN) where a root vanishes, of {_names(roots, moving)}")
    if angles:
        words.append(f"no number (NaN) where both sides of an atan2 vanish, of {_names(angles, moving)}")
    return "".join(f"; {one}" for one in words)


def _below(entries: Sequence[Expr], varied: Collection[Expr]) -> list[Expr]:
    """Return the nodes that vary."""
    found: dict[Expr, None] = {}
    for node in reachable(entries):
        if node in varied or any(arg in found for arg in node.args):
            found[node] = None
    return list(found)


def _names(of: Iterable[Expr], varied: Collection[Expr]) -> str:
    groups = dict.fromkeys(tuple(sorted(str(x.value) for x in reachable([node]) if x in varied)) for node in of)
    return listed([" and ".join(group) if len(group) < 3 else f"({', '.join(group[:MOST])})" for group in groups], MOST)


ALONE = {TIME: "time", INPUTS: "inputs", STATES: "states"}
SPELLED = {STATES: "states"}
"""What derivatives by an argument are asked for as, where that is not its name."""

BESIDE = tuple(ALONE)
"""Those that no row names: an output has them where its entries do; and what they are called."""


def entries_of(w: Workspace, row: Output, *place: str) -> Sequence[Expr]:
    """Return the entries of an output by the formulation that its row prefers."""
    row = row.constrained if w.scene.is_constrained else row
    return w.once(row.formulations[row.preferred(w)].derive, *place)


JACOBIANS: dict[str, dict[str, tuple[Callable[..., list[Expr]], Callable[..., RowSolve | None] | None]]] = {
    "inverse_dynamics": {"recursive": (recursive_derivatives.inverse_derivatives, None)},
    held_outputs.HELD_DYNAMICS: {"implicit": (held_outputs.held_derivatives, held_outputs.held_solve)},
    "forward_dynamics": {"recursive": (recursive_derivatives.forward_derivatives, recursive_derivatives.forward_solve)},
}
"""Formulations of J of an output beside differentiation, by both names, and what J is solved from, if it is.

Each takes the workspace and the arguments along which J is wanted, some of the output's in their order.
"""

LOOPS: dict[str, dict[str, Formulation]] = {
    "inverse_dynamics": {"rnea_derivatives_loop": by_loop(rnea_derivatives_loop)},
    "forward_dynamics": {
        "aba_derivatives_loop": Formulation(
            partial(forward_loop, compute=aba_derivatives_loop), up_to=0, loop=aba_derivatives_loop
        )
    },
}
"""Formulations of the whole of J that go over a table of joints, by both names."""

SIZES: dict[str, Size] = {"inverse_dynamics": Size((0, 37)), "forward_dynamics": Size((0, 45), 1.5)}
"""What a block of J takes in the formulations of JACOBIANS."""

EACH = 0.5
"""What a column of J takes by differentiation, in parts of the output."""


# Rows of the table


def differentiable(row: Output) -> tuple[str, ...]:
    """Return the arguments of an output along which it can be differentiated, in their order, `moved` ones last."""
    return tuple(name for name in (*row.arguments, *row.moved) if name in COLUMNS)


def rows_of(row: Output) -> Axis:
    """Return what the entries of an output stand for, row by row."""
    return lambda w: tuple(" ".join(one) for one in product(*(axis(w) for axis in row.axes)))


def derived(row: Output, varied: Sequence[str], **changes: object) -> Output:
    """Return a row that is asked of another one, differentiated along arguments: what all such rows have in common."""

    def remark(w: Workspace, *place: str) -> str:
        kinked = kinks(entries_of(w, row, *place), [x for one in FREE.seeds(w, "", varied) for x in one])
        chosen = row.unique is not None and not all(row.unique(w))
        return kinked + ("; of one choice among many where an entry is statically indeterminate" if chosen else "")

    common = replace(
        row,
        when_constrained="refuse" if isinstance(row.when_constrained, Constrained) else row.when_constrained,
        default_in="request",
        prefer=None,
        compared=None,
        unique=None,
        solves=(),
        cubic=False,
        remark=remark,
    )
    return replace(common, **changes)  # type: ignore[arg-type]


def jacobian_row(
    row: Output,
    space: TangentSpace,
    along: Sequence[str],
    how: str,
    formulations: Mapping[str, Formulation],
    **changes: object,
) -> Output:
    """Return the row of J of an output along arguments, `how` it moves in words."""
    return derived(
        row,
        along,
        text=f"derivatives {space.jacobian(row.result, along)}{how} of {row.text}",
        result=f"d{row.result}",
        axes=(rows_of(row), lambda w: space.labels(w, along)),
        units=f"{row.units}, per unit of what moves",
        formulations=formulations,
        **changes,
    )


def parameter_row(
    row: Output, only: str, how: str, formulations: Mapping[str, Formulation], **changes: object
) -> Output:
    """Return the row of ∂f/∂p of an output, of all named parameters or of one, `how` all else moves in words."""
    common: dict[str, object] = {
        "remark": lambda w, *_: parameters_left_out(w, only),
        "size": row.size.times(EACH) if only else row.size.columns(EACH),
    }
    return derived(
        row,
        (),
        text=f"derivatives by {only or 'the named parameters'}{how} of {row.text}",
        result=f"d{row.result}",
        axes=(rows_of(row), lambda w: parameters_of(w, only)),
        units=f"{row.units}, per unit of the parameter",
        formulations=formulations,
        **common | changes,
    )


# What is asked of every output


def derivatives(name: str, row: Output, only: str = "") -> Output:
    """Return the row of J for a row of the table; of one argument's block alone if it is named."""
    along = (only,) if only else differentiable(row)
    if only not in (*row.arguments, "", *BESIDE) or not along:
        taken = ", ".join(row.arguments) or "nothing"
        raise DerivationError(f"{name} takes {taken}; it has no derivatives by {only or 'that'}")
    way = f", by {ALONE[only]} alone" if only in ALONE else ", along the directions of the velocities" * ("q" in along)
    by_hand = {
        formulation: Formulation(partial(jacobian, along=along), solve=solve and partial(solve, along=along))
        for formulation, (jacobian, solve) in JACOBIANS.get(name, {}).items()
        if only not in BESIDE
    }
    by_sweeps = {
        formulation: Formulation(
            partial(lambda sweep, w, *place: sweep(entries_of(w, row, *place), FREE.seeds(w, "", along)), sweep)
        )
        for formulation, sweep in SWEEPS.items()
    }
    over = {} if only else LOOPS.get(name, {})
    size = SIZES.get(name, row.size.columns(EACH)).times(len(along))
    return jacobian_row(row, FREE, along, f"{way}, all else held,", {**by_hand, **by_sweeps, **over}, size=size)


def by_parameters(name: str, row: Output, only: str = "") -> Output:
    """Return the row of ∂f/∂p for a row of the table: of all named parameters, or of one."""

    def slopes(sweep: Callable[..., list[Expr]], w: Workspace, *place: str) -> list[Expr]:
        return slopes_by_parameters(w, only, FREE, "", sweep, lambda there: entries_of(there, row, *place))

    formulations = {way: Formulation(partial(slopes, sweep)) for way, sweep in SWEEPS.items()}
    return parameter_row(row, only, ", all else held,", formulations)
