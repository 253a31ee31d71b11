"""Derivatives along one direction, of one weighted sum, and of second order: rows of OUTPUTS, when they are asked for.

`directional_formulations` has the formulations, and the legend.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from symdyn.dynamics.outputs import implicit
from symdyn.dynamics.outputs.derivative_outputs import EACH, derived, differentiable, rows_of
from symdyn.dynamics.outputs.directional_formulations import (
    HESSIAN,
    TENSOR,
    Way,
    hessian,
    hessian_by_columns,
    hessian_vector,
    hessian_vector_backwards,
    jvp,
    jvp_of_rows,
    tensor,
    vjp,
    vjp_of_columns,
)
from symdyn.dynamics.outputs.named_functions import WEIGHTS
from symdyn.dynamics.outputs.output import Formulation, Output
from symdyn.dynamics.outputs.result_labels import Axis
from symdyn.dynamics.outputs.tangent_space import FREE, SWEEPS, TangentSpace
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr


def _decided(rule: Callable[..., list[Expr]]) -> Way:
    """Return the way that the equations of motion have to derivatives of what they decide."""

    def way(w: Workspace, row: Output, along: Sequence[str]) -> list[Expr]:
        return rule(implicit.motion, implicit.accelerations, FREE, along, w)

    return way


JVPS: dict[str, dict[str, Way]] = {"forward_dynamics": {"solved": _decided(implicit.jvp)}}
"""Ways to J d of an output beside a sweep, by its name and theirs."""

VJPS: dict[str, dict[str, Way]] = {"forward_dynamics": {"solved": _decided(implicit.vjp)}}
"""Ways to wᵀ J of an output beside a sweep, by its name and theirs."""


def _slopes(name: str) -> dict[str, Way]:
    """Return the ways to wᵀ J that do not go by J."""
    return {**VJPS.get(name, {}), "reverse": vjp}


def _formulations(name: str, row: Output, ways: Mapping[str, Way]) -> dict[str, Formulation]:
    """Return ways along all arguments of an output."""
    along = differentiable(row)
    if not along:
        raise DerivationError(f"{name} takes {', '.join(row.arguments) or 'nothing'}; it has no derivatives by that")

    def formulation(way: Way) -> Formulation:
        return Formulation(lambda w, *place: way(w, row, along, *place))

    return {one: formulation(way) for one, way in ways.items()}


def _row(name: str, row: Output, text: str, ways: Mapping[str, Way], **changes: object) -> Output:
    """Return a row of derivatives along all arguments of an output; {d} in its text is J, block by block."""
    formulations, along = _formulations(name, row, ways), differentiable(row)
    text = f"{text.format(d=FREE.jacobian(row.result, along), f=row.result)}, of {row.text}"
    return derived(row, along, text=text, formulations=formulations, **changes)


def _given(row: Output, *more: str) -> tuple[str, ...]:
    """Return the arguments of an output and more, weights left out where it is one number."""
    return (*row.arguments, *(name for name in more if name != WEIGHTS or row.axes))


def _directions(row: Output, space: TangentSpace = FREE) -> tuple[str, ...]:
    return tuple(space.amounts_of[name] for name in differentiable(row))


def _columns(row: Output, space: TangentSpace = FREE) -> Axis:
    return lambda w: space.labels(w, differentiable(row))


def jvp_row(row: Output, space: TangentSpace, how: str, ways: Mapping[str, Formulation], **changes: object) -> Output:
    """Return the row of J d of an output along all its arguments, `how` they move in words."""
    return derived(
        row,
        differentiable(row),
        text=f"derivative {space.jacobian(row.result, differentiable(row))} d along one direction d{how} of {row.text}",
        formulations=ways,
        arguments=_given(row, *_directions(row, space)),
        result=f"d{row.result}",
        units=f"{row.units}, per unit of the direction",
        size=row.size.times(2.2),
        **changes,
    )


def vjp_row(row: Output, space: TangentSpace, how: str, ways: Mapping[str, Formulation], **changes: object) -> Output:
    """Return the row of wᵀ J of an output along all its arguments, `how` they move in words."""
    J = space.jacobian(row.result, differentiable(row))
    return derived(
        row,
        differentiable(row),
        text=f"derivatives{' weights^T' if row.axes else ''} {J}{how} of {row.text}",
        formulations=ways,
        arguments=_given(row, WEIGHTS),
        weighs=rows_of(row),
        axes=(_columns(row, space),),
        result="slopes",
        units=f"{row.units}{_times(row)}, per unit of what moves",
        size=row.size.times(2),
        **changes,
    )


def _jvp_row(name: str, row: Output) -> Output:
    ways = {**JVPS.get(name, {}), "forward": jvp, "rows": jvp_of_rows}
    return jvp_row(row, FREE, " of its arguments,", _formulations(name, row, ways))


def _vjp_row(name: str, row: Output) -> Output:
    ways = {**_slopes(name), "columns": vjp_of_columns}
    return vjp_row(row, FREE, f"{_sum(row)},", _formulations(name, row, ways))


ORDER = "row k, column j: X_j X_k, not symmetric where quaternions turn"


def _sum(row: Output) -> str:
    return " of the sum of all entries, each with its weight" if row.axes else ""


def _times(row: Output) -> str:
    return ", times weights" if row.axes else ""


def _hessian_row(name: str, row: Output) -> Output:
    ways = _slopes(name)
    return _row(
        name,
        row,
        f"second derivatives along the directions of {{d}}{_sum(row)}; {ORDER}",
        {
            **{f"{way} over {of}": partial(hessian, way, ways[of]) for of in ways for way in ("reverse", "forward")},
            "columns": hessian_by_columns,
        },
        arguments=_given(row, WEIGHTS),
        weighs=rows_of(row),
        axes=(_columns(row), _columns(row)),
        result="H",
        units=f"{row.units}{_times(row)}, per units of what moves",
        size=row.size.columns(1.5),
    )


def _hessian_vector_row(name: str, row: Output) -> Output:
    return _row(
        name,
        row,
        f"second derivatives along the directions of {{d}}{_sum(row)}; {ORDER}; times one direction d",
        {
            **{f"forward over {way}": partial(hessian_vector, first) for way, first in _slopes(name).items()},
            "reverse over forward": hessian_vector_backwards,
        },
        arguments=_given(row, WEIGHTS, *_directions(row)),
        weighs=rows_of(row),
        axes=(_columns(row),),
        result="Hd",
        units=f"{row.units}{_times(row)}, per units of what moves",
        size=row.size.times(5),
    )


def _tensor_row(name: str, row: Output) -> Output:
    return _row(
        name,
        row,
        "second derivatives along the directions of {d}; entry i, k, j: X_j X_k {f}_i, not symmetric where quaternions "
        "turn",
        {way: partial(tensor, way, name) for way in SWEEPS},
        axes=(rows_of(row), _columns(row), _columns(row)),
        result=f"dd{row.result}",
        units=f"{row.units}, per units of what moves",
        size=row.size.columns(EACH).columns(EACH).times(len(differentiable(row)) ** 2),
    )


ALONG_ONE: dict[str, Callable[[str, Output], Output]] = {
    "_jvp": _jvp_row,
    "_vjp": _vjp_row,
    f"{HESSIAN}_vector": _hessian_vector_row,
    HESSIAN: _hessian_row,
    TENSOR: _tensor_row,
}
"""What can be asked of every output, by what is written behind its name."""
