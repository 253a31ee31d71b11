"""The search of output error: weighted residuals over all pieces, their Jacobian, and Levenberg-Marquardt over both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import IdentifyError
from symdyn.identification.measured import FEWEST, Measured
from symdyn.identification.shooting import FORGETS, Shooting, ShootingRun

PARTS = (0.125, 0.25, 0.5, 1.0)
"""Of each piece, what a search looks at, one after the other."""

LOOSE = 1e-2
"""Weight of values before, relative, in searches that look at a part: what a part does not tell does not wander off."""

ROUNDS = 4
"""Searches over everything; before each, weights are those of the residuals before."""

SETTLED = 0.02
"""Relative change of weights after which no other search is needed."""

MOST_RUNS = 60
"""Runs that one search takes."""


@dataclass
class Search:
    """Residuals and their Jacobian over the unknowns: parameters over their sizes, then moves of every start."""

    pieces: list[Shooting]
    data: Sequence[Measured]
    columns: list[int]
    parameters: tuple[str, ...]
    sizes: Array
    before: Array
    starts: int
    sigma: Array
    floor: Array
    loose: float = 0.0
    runs: int = 0
    _at: bytes = b""
    _runs: list[ShootingRun | None] = field(default_factory=list)

    def values(self, unknowns: Array) -> dict[str, float]:
        """Return parameters by name."""
        return dict(zip(self.parameters, (unknowns * self._scale)[: len(self.parameters)].tolist(), strict=True))

    @property
    def _scale(self) -> Array:
        return np.concatenate([self.sizes, np.ones(self.starts * len(self.pieces))])

    def moves(self, unknowns: Array, piece: int) -> Array:
        """Return the moves of the start of a piece."""
        first = len(self.parameters) + piece * self.starts
        return unknowns[first : first + self.starts]

    def run(self, unknowns: Array) -> list[ShootingRun | None]:
        """Return the runs of all pieces; the last ones are kept."""
        if self._at != unknowns.tobytes():
            values = self.values(unknowns)
            self._runs = [one.run(values, self.moves(unknowns, k)) for k, one in enumerate(self.pieces)]
            self._at, self.runs = unknowns.tobytes(), self.runs + len(self.pieces)
        return self._runs

    def forget(self) -> None:
        """Forget the last runs: pieces or what weighs have changed."""
        self._at = b""

    def missed(self, unknowns: Array) -> list[Array]:
        """Return simulated less measured by piece, shape (N, m); infinite where there is no run."""
        found: list[Array] = []
        for one, data in zip(self.run(unknowns), self.data, strict=True):
            x = data.x[: len(self.pieces[len(found)].t)]
            found.append(np.full(x.shape, np.inf) if one is None else one.x[:, self.columns] - x)
        return found

    def residuals(self, unknowns: Array) -> Array:
        """Return weighted residuals, and how far parameters are from before."""
        rows = np.concatenate([(one / self.sigma).ravel() for one in self.missed(unknowns)])
        return np.concatenate([rows, self.loose * (unknowns - self.before)])

    def jacobian(self, unknowns: Array) -> Array:
        """Return the derivative of the residuals."""
        n, blocks = len(self.parameters), []
        for k, one in enumerate(self.run(unknowns)):
            assert one is not None, "a search stays where there are runs"
            S = one.S[:, :, self.columns] / self.sigma
            block = np.zeros((S.shape[0] * S.shape[2], len(unknowns)))
            block[:, :n] = S[:, self.starts : self.starts + n].transpose(0, 2, 1).reshape(-1, n) * self.sizes
            first = n + k * self.starts
            block[:, first : first + self.starts] = S[:, : self.starts].transpose(0, 2, 1).reshape(-1, self.starts)
            blocks.append(block)
        return np.vstack([*blocks, self.loose * np.eye(len(unknowns))])


def searched(search: Search, least: Array) -> Array:
    """Return the unknowns that fit all samples best, none below its least value; the search is left at them.

    Raises:
        IdentifyError: there is no run, or the motion forgets its start.
    """
    whole, unknowns = list(search.pieces), search.before
    for part in PARTS:
        counts = [max(min(FEWEST, len(one.t)), round(part * len(one.t))) for one in whole]
        values = search.values(unknowns)
        search.pieces = [
            replace(one, steps=before.steps).until(count).refined(values, search.moves(unknowns, k))
            for k, (one, before, count) in enumerate(zip(whole, search.pieces, counts, strict=True))
        ]
        search.loose = LOOSE if part < 1 else 0.0
        for _ in range(ROUNDS if part == 1 else 1):
            unknowns = _best(search, unknowns, least)
            scatter = np.sqrt(np.mean(np.concatenate(search.missed(unknowns)) ** 2, axis=0))
            before, search.sigma = search.sigma, np.maximum(scatter, search.floor)
            if np.all(np.abs(search.sigma - before) <= SETTLED * before):
                break
    return unknowns


def _best(search: Search, unknowns: Array, least: Array) -> Array:
    """Return what one search finds."""
    from scipy.optimize import least_squares

    search.forget()
    grown = max(piece.grown(run) for piece, run in zip(search.pieces, search.run(unknowns), strict=True))
    if None in search.run(unknowns):
        raise IdentifyError("a run ends before the log does at the values that the search begins with; give other ones")
    if grown > FORGETS:
        raise IdentifyError(
            f"a change of the start grows {grown:.1g} times until the end of a piece: the motion forgets its start, "
            "and no search finds the run again; cut the log into pieces with a start of their own (pieces=4, or more)"
        )
    found = least_squares(
        search.residuals, unknowns, search.jacobian, bounds=(least, np.inf), x_scale="jac", xtol=1e-10, ftol=1e-12,
        gtol=1e-12, max_nfev=MOST_RUNS,
    )  # fmt: skip
    return np.asarray(found.x, dtype=np.float64)
