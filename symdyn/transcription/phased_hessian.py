"""Second derivatives of a problem in phases: those of each phase, and of what joins them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from symdyn.algebra import Array
from symdyn.transcription.grid import Places
from symdyn.transcription.phased import Phased
from symdyn.transcription.solution import Bends, Lagrangian, bends_of, lagrangian


@dataclass(frozen=True, eq=False)
class PhasedLagrangian:
    """The Hessian of the Lagrangian, upper triangle, as of `Lagrangian`."""

    problem: Phased
    rows: Places
    columns: Places
    parts: tuple[Lagrangian, ...] = field(repr=False)
    joining: Mapping[str, Bends] = field(repr=False)
    merged: Places = field(repr=False)

    def values(self, z: Array, sigma: float, multipliers: Array) -> Array:
        """Return the entries at z, shape (nonzeros,)."""
        problem, found, at = self.problem, list[Array](), 0
        for one, part in zip(self.parts, problem.split(z), strict=True):
            rows = one.problem.rows
            found.append(one.values(part, sigma, multipliers[at : at + rows]))
            at += rows
        for passage in problem.passages:
            known = passage.at(z)
            found += [bend.value(known, multipliers[None, passage.row[n]])[0] for n, bend in self.joining.items()]
        total: Array = np.bincount(self.merged, np.concatenate(found), len(self.rows)).astype(np.float64)
        return total


def phased_lagrangian(problem: Phased) -> PhasedLagrangian:
    """Return the Hessian of the Lagrangian as a function, compiled."""
    every = bends_of(problem.parts[0].source)
    joining = {name: every[name] for name in problem.joining if name in every}
    parts, at, places = tuple(lagrangian(one) for one in problem.parts), 0, list[tuple[Places, Places]]()
    for one in parts:
        places.append((at + one.rows, at + one.columns))
        at += one.problem.size
    for passage in problem.passages:
        for bend in joining.values():
            sides = [[passage.place[kind][k] for kind, k in one] for one in zip(*bend.pairs, strict=True)]
            places.append((np.array(sides[0]), np.array(sides[1])))
    first, second = (np.concatenate([pair[k] for pair in places]) for k in (0, 1))
    keys = np.maximum(first, second) * problem.size + np.minimum(first, second)
    unique, merged = np.unique(keys, return_inverse=True)
    columns, rows = np.divmod(unique, problem.size)
    return PhasedLagrangian(problem, rows, columns, parts, joining, merged.ravel())
