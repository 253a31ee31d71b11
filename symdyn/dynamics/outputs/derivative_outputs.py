"""Derivatives of outputs along their arguments: rows of OUTPUTS that a scene has when it is asked for them.

    f        an output of q, u, and u̇ or τ
    X_k f    its derivative along velocity k: d/dε f(q ∘ exp(ε X_k), u, ·) at ε = 0, all other arguments held
    J        [X f | ∂f/∂u | …], a column for every direction of every argument, in their order

Coordinates have as many columns as there are velocities: plain partial derivatives where velocities are rates of
coordinates, else along the axes of the moved frame (v, then ω). Derivatives of second order do not commute there.

A way to J that is better than differentiation of a graph is a row of JACOBIANS; all that is asked of J has it then.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

from symdyn.dynamics.mechanism.prescribed import INPUTS, TIME, inputs_of
from symdyn.dynamics.mechanism.row_solve import RowSolve
from symdyn.dynamics.outputs import parameter_outputs as parameters, recursive_derivatives, result_labels as labels
from symdyn.dynamics.outputs.kinks import kinks
from symdyn.dynamics.outputs.named_functions import MULTIPLIERS, independent_symbols, multiplier_symbols
from symdyn.dynamics.outputs.output import Constrained, Formulation, Output
from symdyn.dynamics.outputs.result_labels import Axis
from symdyn.dynamics.outputs.size import Size
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Slopes, gradient, operands, tangents
from symdyn.scene.values import acceleration_name

Direction = dict[Expr, Expr]
"""How fast each symbol moves along it."""


def _label(w: Workspace, k: int) -> str:
    """Return the coordinate whose rate velocity k is, or the velocity along which a quaternion moves."""
    rates = [q for q, rate in zip(w.scene.coordinates, w.state.rates, strict=True) if rate is w.state.qd[k]]
    return rates[0] if rates else f"along {w.scene.velocities[k]}"


def declared_inputs(w: Workspace) -> tuple[str, ...]:
    """Return the names of the inputs; DerivationError where there are none."""
    if not w.scene.inputs:
        raise DerivationError(f"{w.scene.name} has no inputs to differentiate by; declare one, such as [inputs.u]")
    return tuple(one.name for one in w.scene.inputs)


COLUMNS: dict[str, Axis] = {
    "q": lambda w: tuple(_label(w, k) for k in range(w.state.n)),
    "qd": labels.velocities,
    "qdd": lambda w: tuple(map(acceleration_name, w.scene.velocities)),
    "tau": lambda w: tuple(f"force on {name}" for name in w.scene.velocities),
    "qi": lambda w: tuple(str(one.value) for one in independent_symbols(w, "qi")),
    "ui": lambda w: tuple(str(one.value) for one in independent_symbols(w, "ui")),
    MULTIPLIERS: lambda w: tuple(f"multiplier of {name}" for name in labels.kept_rows(w)),
    TIME: labels.fixed(TIME),
    INPUTS: declared_inputs,
}
"""Arguments that an output is differentiated along, and what the columns stand for."""


ALONE = {TIME: "time", INPUTS: "inputs"}
BESIDE = tuple(ALONE)
"""Those that no row names: an output has them where its entries do; and what they are called."""


def directions_of(w: Workspace, argument: str) -> list[Direction]:
    """Return the directions of one argument: how fast each symbol of it moves along each, as many as it has columns."""
    if argument == "q":
        return list(w.directions.along)
    if argument in ("qi", "ui"):
        symbols = independent_symbols(w, argument)
    elif argument == MULTIPLIERS:
        symbols = multiplier_symbols(w)
    elif argument == TIME:
        symbols = (w.graph.symbol(TIME),)
    elif argument == INPUTS:
        symbols = inputs_of(w.scene, w.graph)
    else:
        symbols = {"qd": w.state.qd, "qdd": w.state.qdd, "tau": w.state.tau}[argument]
    return [{one: w.graph.one} for one in symbols]


# Differentiation of a graph


def forward(entries: Sequence[Expr], directions: Sequence[Direction], slopes: Slopes = operands) -> list[Expr]:
    """Return the derivatives of entries along directions, row by row, a sweep for each column."""
    columns = [tangents(entries, seeds, slopes) for seeds in directions]
    return [column[i] for i in range(len(entries)) for column in columns]


def reverse(entries: Sequence[Expr], directions: Sequence[Direction], slopes: Slopes = operands) -> list[Expr]:
    """Return the derivatives of entries along directions, row by row, a sweep for each row."""
    inputs = list(dict.fromkeys(symbol for one in directions for symbol in one))
    found = []
    for entry in entries:
        partials = dict(zip(inputs, gradient(entry, inputs, slopes), strict=True))
        found += [entry.graph.total(h * partials[x] for x, h in one.items()) for one in directions]
    return found


SWEEPS = {"forward": forward, "reverse": reverse}


def entries_of(w: Workspace, row: Output, *place: str) -> Sequence[Expr]:
    """Return the entries of an output by the formulation that its row prefers."""
    row = row.constrained if w.scene.is_closed else row
    found: Sequence[Expr] = w.once(row.formulations[row.preferred(w)].derive, *place)
    return found


def along_all(w: Workspace, arguments: Sequence[str]) -> list[Direction]:
    """Return the directions of several arguments, in their order."""
    return [one for name in arguments for one in directions_of(w, name)]


JACOBIANS: dict[str, dict[str, Callable[[Workspace, Sequence[str]], Sequence[Expr]]]] = {
    "inverse_dynamics": {"recursive": recursive_derivatives.inverse_derivatives},
    "forward_dynamics": {"recursive": recursive_derivatives.forward_derivatives},
}
"""Formulations of J of an output beside differentiation, by both names: each takes the arguments along which J is
wanted, some of the output's in their order, and returns J row by row."""

SOLVES: dict[tuple[str, str], Callable[[Workspace, Sequence[str]], RowSolve | None]] = {
    ("forward_dynamics", "recursive"): recursive_derivatives.forward_solve,
}
"""What J is solved from, by the names of an output and of a formulation of J."""


SIZES: dict[str, Size] = {"inverse_dynamics": Size((0, 37)), "forward_dynamics": Size((0, 45), 1.5)}
"""What a block of J takes in the formulations of JACOBIANS."""

EACH = 0.5
"""What a column of J takes by differentiation, in parts of the output."""


def _along(along: tuple[str, ...], jacobian: Callable[[Workspace, Sequence[str]], Any], w: Workspace) -> Any:
    return jacobian(w, along)


def _solve(
    along: tuple[str, ...], solve: Callable[[Workspace, Sequence[str]], RowSolve | None] | None
) -> Callable[[Workspace], RowSolve | None] | None:
    return partial(_along, along, solve) if solve else None


# Rows of the table


def differentiable(row: Output) -> tuple[str, ...]:
    """Return the arguments of an output along which it can be differentiated, in their order."""
    return tuple(name for name in row.arguments if name in COLUMNS)


def rows_of(row: Output) -> Axis:
    """Return what the entries of an output stand for, row by row."""
    return lambda w: tuple(" ".join(one) for one in product(*(axis(w) for axis in row.axes)))


def derived(row: Output, varied: Sequence[str], **changes: object) -> Output:
    """Return a row that is asked of another one, differentiated along arguments: what all such rows have in common."""

    def remark(w: Workspace, *place: str) -> str:
        told = kinks(entries_of(w, row, *place), [x for one in along_all(w, varied) for x in one])
        chosen = row.unique is not None and not all(row.unique(w))
        return told + ("; of one choice among many where rigid bodies do not tell an entry" if chosen else "")

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


def derivatives(name: str, row: Output, only: str = "") -> Output:
    """Return the row of J for a row of the table; of one argument's block alone if it is named."""
    along = (only,) if only else differentiable(row)
    if only not in (*row.arguments, "", *BESIDE) or not along:
        taken = ", ".join(row.arguments) or "nothing"
        raise DerivationError(f"{name} takes {taken}; it has no derivatives by {only or 'that'}")
    blocks = " | ".join(f"d{row.result}/d{one}" for one in along)
    way = f", by {ALONE[only]} alone" if only in ALONE else ", along the directions of the velocities" * ("q" in along)
    by_hand = {
        formulation: Formulation(partial(_along, along, jacobian), solve=_solve(along, SOLVES.get((name, formulation))))
        for formulation, jacobian in JACOBIANS.get(name, {}).items()
        if only not in BESIDE
    }
    by_sweeps = {
        formulation: Formulation(
            partial(lambda sweep, w, *place: sweep(entries_of(w, row, *place), along_all(w, along)), sweep)
        )
        for formulation, sweep in SWEEPS.items()
    }
    return derived(
        row,
        along,
        text=f"derivatives [{blocks}]{way}, all else held, of {row.text}",
        result=f"d{row.result}",
        axes=(rows_of(row), lambda w: tuple(label for one in along for label in COLUMNS[one](w))),
        units=f"{row.units}, per unit of what moves",
        formulations={**by_hand, **by_sweeps},
        size=SIZES.get(name, row.size.columns(EACH)).times(len(along)),
    )


def by_parameters(name: str, row: Output, only: str = "") -> Output:
    """Return the row of ∂f/∂p for a row of the table: of all named parameters, or of one."""
    formulations = {
        way: Formulation(
            partial(lambda sweep, w, *place: parameters.slopes(w, sweep, entries_of, row, place, only), sweep)
        )
        for way, sweep in SWEEPS.items()
    }
    return derived(
        row,
        (),
        text=f"derivatives by {only or 'the named parameters'}, all else held, of {row.text}",
        result=f"d{row.result}",
        axes=(rows_of(row), lambda w: parameters.names(w, only)),
        units=f"{row.units}, per unit of the parameter",
        formulations=formulations,
        remark=lambda w, *_: parameters.left_out(w, only),
        size=row.size.times(EACH) if only else row.size.columns(EACH),
    )
