"""Second derivatives: the Hessian of σ f(z) + λᵀ g(z), for solvers that take Newton's steps.

    Φ        w · (entries of a local function), a number for every place; w are multipliers, and weights of defects
    bends    ∂²Φ/∂x_i∂x_j that are not zero, j <= i, at every place: again one compiled function for all

Between places the defects are linear in everything but the time of the end, T: what an interval's length multiplies
gives the column of T.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.graph import gradient, tangents
from symdyn.simulation import compiled_entries
from symdyn.transcription.grid import Places
from symdyn.transcription.local import appearing, argument_of, inputs_of, symbols_of
from symdyn.transcription.source import Source
from symdyn.transcription.transcribed import PLACES, Collocation

WEIGHTS = "weights"

Pair = tuple[tuple[str, int], tuple[str, int]]


@dataclass(frozen=True)
class Bends:
    """Second derivatives of a local function, weighed.

    Attributes:
        pairs: the two unknowns of each, by kind and place in it.
        value: function of the unknowns by kind and of weights, shape (count, size), to (count, pairs).
    """

    pairs: tuple[Pair, ...]
    value: Callable[[Mapping[str, Array], Array], Array]


@dataclass(frozen=True, eq=False)
class Lagrangian:
    """The Hessian of a problem's Lagrangian, upper triangle.

    Attributes:
        problem: whose it is.
        rows, columns: of its entries, shape (nonzeros,), column by column; none occurs twice, rows <= columns.
    """

    problem: Collocation
    rows: Places
    columns: Places
    bends: Mapping[str, Bends] = field(repr=False)
    wires: Mapping[str, tuple[NDArray[np.bool_], Array]] = field(repr=False)
    merged: Places = field(repr=False)

    def __reduce__(self) -> tuple[Callable[[Collocation], Lagrangian], tuple[Collocation]]:
        """Return how it is made again."""
        return lagrangian, (self.problem,)

    def values(self, z: Array, sigma: float, multipliers: Array) -> Array:
        """Return the entries at z, shape (nonzeros,)."""
        parts = np.concatenate([np.ravel(part) for part in _parts(self, z, sigma, multipliers)])
        found: Array = np.bincount(self.merged, parts, len(self.rows)).astype(np.float64)
        return found


def lagrangian(problem: Collocation) -> Lagrangian:
    """Return the Hessian of a problem's Lagrangian as a function, compiled."""
    bends = _compiled(problem.source)
    wires: dict[str, tuple[NDArray[np.bool_], Array]] = {}
    places: list[tuple[Places, Places]] = []
    for name, one in bends.items():
        points = problem.points(PLACES[name])
        sides = [np.empty((len(points), len(one.pairs)), dtype=np.int64) for _ in range(2)]
        chain = np.ones(sides[0].shape)
        for k, pair in enumerate(one.pairs):
            for side, (kind, place) in zip(sides, pair, strict=True):
                side[:, k] = problem.column(kind, place, points)
                chain[:, k] *= problem.grid.share[points] if kind == TIME else 1.0
        known = (sides[0] >= 0) & (sides[1] >= 0)
        wires[name] = known, chain
        places.append((sides[0][known], sides[1][known]))
    T = problem.place["T"]
    if len(T):
        places += [(T[:1], columns.ravel()) for columns in _beside_time(problem)]
    pairs = [np.broadcast_arrays(*pair) for pair in places]
    first, second = (np.concatenate([pair[k].ravel() for pair in pairs] or [T]) for k in (0, 1))
    keys = np.maximum(first, second) * problem.size + np.minimum(first, second)
    unique, merged = np.unique(keys, return_inverse=True)
    columns, rows = np.divmod(unique, problem.size)
    return Lagrangian(problem, rows, columns, bends, wires, merged.ravel())


def _beside_time(problem: Collocation) -> list[Places]:
    """Return the unknowns that the length of an interval multiplies: at rates, accelerations and the running cost."""
    found = [problem.wires["rates"][0], problem.place["a"]]
    if "running" in problem.locals:
        columns, known, _ = problem.wires["running"]
        found.append(columns[known])
    return found


def _parts(of: Lagrangian, z: Array, sigma: float, multipliers: Array) -> list[Array]:
    problem, grid = of.problem, of.problem.grid
    by_row = {kind: multipliers[row] for kind, row in problem.row.items()}
    defects, nq = by_row["defects"], problem.place["q"].shape[1]
    shares = -(problem.between[1].T @ defects.ravel()).reshape(len(grid.stage), -1)  # of what T multiplies
    T = problem.time(z)
    weights = {
        "balance": by_row["balance"],
        "rates": T * shares[:, :nq],
        "held": by_row["held"],
        "path": by_row["path"],
        "pull": np.concatenate([np.zeros((1, defects.shape[2])), -defects[:, -1]]),
        "running": sigma * T * grid.quadrature[:, None],
        "final": np.full((1, 1), sigma),
    }
    at = {where: problem.at(z, where) for where in ("stage", "node", "end")}
    found = []
    for name, one in of.bends.items():
        known, chain = of.wires[name]
        found.append((one.value(at[PLACES[name]], weights[name]) * chain)[known])
    if len(problem.place["T"]):
        rates = problem.locals["rates"]
        found.append(rates.slopes(at["stage"]) * shares[:, [i for i, _, _ in rates.pattern]])
        found.append(shares[:, nq:])
        if "running" in problem.locals:
            columns, known, chain = problem.wires["running"]
            slopes = sigma * grid.quadrature[:, None] * problem.locals["running"].slopes(at["stage"]) * chain
            found.append(np.where(columns == problem.place["T"][0], 2.0, 1.0)[known] * slopes[known])
    return found


@lru_cache(maxsize=16)
def _compiled(source: Source) -> dict[str, Bends]:
    """Return the second derivatives of the local functions that are not linear."""
    w, written = source.workspace, source.written
    parts, pairs, takes = {}, {}, {}
    for name, entries in written.entries.items():
        if not entries:
            continue
        inputs = inputs_of(written, entries)
        symbols = [symbol for _, _, symbol in inputs]
        weights = argument_of(WEIGHTS, symbols_of(w, WEIGHTS, len(entries)))
        total = w.graph.total(x * y for x, y in zip(weights.symbols, entries, strict=True))
        slopes = gradient(total, symbols)
        bent = {
            (i, j): value
            for j, x in enumerate(symbols)
            for i, value in enumerate(tangents(slopes[j:], {x: w.graph.one}), start=j)
            if not value.is_zero
        }
        if not bent:
            continue
        pairs[name] = tuple((inputs[i][:2], inputs[j][:2]) for i, j in bent)
        seen = appearing(bent.values())
        takes[name] = [kind for kind, those in written.kinds.items() if kind == "q" or not seen.isdisjoint(those)]
        known = [argument_of(kind, written.kinds[kind]) for kind in takes[name]]
        parts[f"{name}_bends"] = list(bent.values()), [*known, weights]
    calls = compiled_entries(w, parts)

    def caller(name: str) -> Callable[[Mapping[str, Array], Array], Array]:
        call, kinds = calls[f"{name}_bends"], takes[name]
        return lambda at, weights: np.asarray(call(*(at[kind] for kind in kinds), weights), dtype=np.float64)

    return {name: Bends(pairs[name], caller(name)) for name in pairs}
