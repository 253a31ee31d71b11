"""Derivatives of outputs along their arguments: rows of OUTPUTS that a scene has when it is asked for them.

    f        an output of q, u, and u̇ or τ
    X_k f    its derivative along velocity k: d/dε f(q ∘ exp(ε X_k), u, ·) at ε = 0, all other arguments held
    J        [X f | ∂f/∂u | …], a column for every direction of every argument, in their order

Coordinates have as many columns as there are velocities: plain partial derivatives where velocities are rates of
coordinates, else along the axes of the moved frame (v, then ω). Derivatives of second order do not commute there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product

from symdyn.dynamics.roads import result_labels as labels
from symdyn.dynamics.roads.output import Output, Road, Unasked
from symdyn.dynamics.roads.result_labels import Axis
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.graph import Expr, gradient, tangents
from symdyn.scene import acceleration_name


def _label(w: Workspace, k: int) -> str:
    """Return the coordinate whose rate velocity k is, or the velocity along which a quaternion moves."""
    rates = [q for q, rate in zip(w.scene.coordinates, w.state.rates, strict=True) if rate is w.state.qd[k]]
    return rates[0] if rates else f"along {w.scene.velocities[k]}"


COLUMNS: dict[str, Axis] = {
    "q": lambda w: tuple(_label(w, k) for k in range(w.state.n)),
    "qd": labels.velocities,
    "qdd": lambda w: tuple(map(acceleration_name, w.scene.velocities)),
    "tau": lambda w: tuple(f"force on {name}" for name in w.scene.velocities),
}
"""Arguments that an output is differentiated along, and what the columns stand for."""


def directions_of(w: Workspace, argument: str) -> list[dict[Expr, Expr]]:
    """Return the directions of one argument: how fast each symbol of it moves along each, shape (nv,)."""
    if argument == "q":
        return list(w.directions.along)
    symbols = {"qd": w.state.qd, "qdd": w.state.qdd, "tau": w.state.tau}[argument]
    return [{one: w.graph.one} for one in symbols]


def forward(w: Workspace, entries: Sequence[Expr], arguments: Sequence[str]) -> list[Expr]:
    """Return J row by row, a sweep for each column."""
    columns = [tangents(entries, seeds) for name in arguments for seeds in directions_of(w, name)]
    return [column[i] for i in range(len(entries)) for column in columns]


def reverse(w: Workspace, entries: Sequence[Expr], arguments: Sequence[str]) -> list[Expr]:
    """Return J row by row, a sweep for each row."""
    seeds = [one for name in arguments for one in directions_of(w, name)]
    inputs = list(dict.fromkeys(symbol for one in seeds for symbol in one))
    found = []
    for entry in entries:
        partial = dict(zip(inputs, gradient(entry, inputs), strict=True))
        found += [w.graph.total(h * partial[x] for x, h in one.items()) for one in seeds]
    return found


def derivatives(row: Output) -> Output:
    """Return the row of J for a row of the table."""
    along = [name for name in row.arguments if name in COLUMNS]

    def columns(w: Workspace) -> tuple[str, ...]:
        return tuple(label for name in along for label in COLUMNS[name](w))

    def rows(w: Workspace) -> tuple[str, ...]:
        return tuple(" ".join(one) for one in product(*(axis(w) for axis in row.axes)))

    def entries(w: Workspace, place: tuple[str, ...]) -> Sequence[Expr]:
        found: Sequence[Expr] = w.once(row.roads[row.preferred(w)].derive, *place)
        return found

    blocks = " | ".join(f"d{row.result}/d{name}" for name in along)
    return replace(
        row,
        text=f"derivatives [{blocks}] along the directions of the velocities, all else held, of {row.text}",
        result=f"d{row.result}",
        axes=(rows, columns),
        units=f"{row.units}, per unit of what moves",
        in_loops="refuse" if row.own else row.in_loops,
        own=None,
        roads={
            "forward": Road(lambda w, *place: forward(w, entries(w, place), along)),
            "reverse": Road(lambda w, *place: reverse(w, entries(w, place), along)),
        },
        unasked=Unasked.NEVER,
        prefer=None,
        compared=None,
        unique=None,
        solves=(),
        multiplies=None,
    )


OPERATORS: dict[str, Callable[[Output], Output]] = {"_derivatives": derivatives}
"""What can be asked of every output, by what is written behind its name, as in "inverse_dynamics_derivatives"."""
