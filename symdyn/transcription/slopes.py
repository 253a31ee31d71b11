"""The Jacobian of a problem's equations: its pattern, and its entries.

An entry is a sum of parts. Those that are the same at every z, as all of the defects of a tree whose time is given, are
computed once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.transcription.grid import Places
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.transcription.transcribed import Collocation


@dataclass(frozen=True, eq=False)
class Slopes:
    """∂g/∂z of a problem."""

    problem: Collocation

    @property
    def rows(self) -> Places:
        """Rows of the entries, ascending, shape (nonzeros,)."""
        return self._entries[0]

    @property
    def columns(self) -> Places:
        """Their columns, ascending in each row; none occurs twice."""
        return self._entries[1]

    def values(self, z: Array) -> Array:
        """Return the entries at z, shape (nonzeros,)."""
        found = self._steady.copy()
        parts, entries = np.concatenate([np.ravel(part) for part in self._parts(z, False)]), self._entries[3]
        if self._alone:
            found[entries] = parts
        else:
            found += np.bincount(entries, parts, len(found))
        return found

    @cached_property
    def _entries(self) -> tuple[Places, Places, Places, Places]:
        """Rows and columns of the entries, and the entry that each steady and each other part belongs to."""
        keys = []
        for steady in (True, False):
            pairs = [np.broadcast_arrays(*pair) for pair in self._places(steady)]
            keys.append(np.concatenate([(rows * self.problem.size + columns).ravel() for rows, columns in pairs]))
        unique, inverse = np.unique(np.concatenate(keys), return_inverse=True)
        steady_ones, others = np.split(inverse.ravel(), [len(keys[0])])
        return *np.divmod(unique, self.problem.size), steady_ones, others

    @cached_property
    def _steady(self) -> Array:
        """What steady parts give every entry, shape (nonzeros,)."""
        parts = np.concatenate([np.ravel(part) for part in self._parts(self.problem.guess, True)])
        found: Array = np.bincount(self._entries[2], parts, len(self.rows)).astype(np.float64)
        return found

    @cached_property
    def _alone(self) -> bool:
        """Whether every other part is an entry of its own."""
        _, _, steady, others = self._entries
        return len(np.unique(others)) == len(others) and not np.isin(others, steady).any()

    def _places(self, steady: bool) -> list[tuple[Places, Places]]:
        """Return rows and columns of the parts of one kind, in the order of `_parts`."""
        p = self.problem
        grid, defects, place = p.grid, p.row["defects"], p.place
        y, nq = np.concatenate([place["q"], place["u"]], axis=1), place["q"].shape[1]
        found: list[tuple[Places, Places]] = []
        if steady:
            found += [(defects, y[grid.target]), (defects, np.broadcast_to(y[grid.node[:-1], None], defects.shape))]
        for r, j in p.used:
            if steady == self._steady_rates:
                entries = [i for i, _, _ in p.locals["rates"].pattern]
                found.append((defects[:, r, entries], p.wires["rates"][0][grid.of[:, j]]))
            if steady == self._timed:
                found.append((defects[:, r, nq:], place["a"][grid.of[:, j]]))
        if steady:
            return found
        if not self._timed:
            found.append((defects, place["T"]))
        if "pull" in p.locals:
            entries = [i for i, _, _ in p.locals["pull"].pattern]
            found.append((defects[:, -1, entries], p.wires["pull"][0][1:]))
        for name in self._rowwise:
            columns, known, _ = p.wires[name]
            rows = p.row[name][:, [i for i, _, _ in p.locals[name].pattern]]
            found.append((rows[known], columns[known]))
        return found

    def _parts(self, z: Array, steady: bool) -> list[Array]:
        """Return the parts of one kind, each an array."""
        p = self.problem
        grid, shape = p.grid, p.row["defects"].shape
        found: list[Array] = [np.ones(shape), np.full(shape, -1.0)] if steady else []
        stages = p.at(z, "stage")
        if not (self._timed and self._steady_rates) or steady:
            h, slopes = p.time(z) * grid.widths[:, None], p.locals["rates"].slopes(stages)
            for r, j in p.used:
                scale = -h * grid.weights[r, j]
                if steady == self._steady_rates:
                    found.append(scale * slopes[grid.of[:, j]])
                if steady == self._timed:
                    found.append(np.broadcast_to(scale, (len(h), p.place["a"].shape[1])))
        if steady:
            return found
        nodes = p.at_nodes(z)
        if not self._timed:
            found.append(-(p.between[1] @ p.rates(stages)))
        if "pull" in p.locals:
            found.append(-p.locals["pull"].slopes(p.behind(nodes)))
        for name in self._rowwise:
            values = p.locals[name].slopes(stages if name == "balance" else nodes)
            _, known, chain = p.wires[name]
            found.append(values if name in self._plain else (values * chain)[known])
        return found

    @cached_property
    def _timed(self) -> bool:
        """Whether the time of the end is given."""
        return not len(self.problem.place["T"])

    @cached_property
    def _steady_rates(self) -> bool:
        """Whether q̇ has the same slopes everywhere, and intervals the same length."""
        return self._timed and self.problem.locals["rates"].linear

    @cached_property
    def _plain(self) -> set[str]:
        """Functions whose slopes are entries as they are: by unknowns alone, and none by time."""
        return {name for name, (_, known, chain) in self.problem.wires.items() if known.all() and np.all(chain == 1.0)}

    @cached_property
    def _rowwise(self) -> list[str]:
        """Functions whose entries are equations as they are."""
        return [name for name in ("balance", "held", "path") if name in self.problem.locals]
