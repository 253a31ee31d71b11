"""What solvers of nonlinear programs ask of a problem: values, bounds, slopes with their pattern."""

from __future__ import annotations

import warnings
from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.arguments import check_arguments
from symdyn.errors import SimulateError
from symdyn.scene import Scene
from symdyn.shown import Shown
from symdyn.transcription.grid import Places
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from symdyn.transcription.solution import Solution
    from symdyn.transcription.transcribed import Collocation


class NonlinearProgram(Shown):
    """A problem in numbers, z with bounds and equations g with bounds; kinds of it say the rest."""

    scene: Scene
    size: int
    rows: int
    lower: Array
    upper: Array
    rows_lower: Array
    rows_upper: Array
    guess: Array
    notes: tuple[str, ...]

    @property
    @abstractmethod
    def jacobian_rows(self) -> Places:
        """Rows of the entries of ∂g/∂z that are not always zero, ascending, shape (nonzeros,)."""

    @property
    @abstractmethod
    def jacobian_columns(self) -> Places:
        """Their columns, ascending in each row; none occurs twice."""

    @abstractmethod
    def residual(self, z: Array) -> Array:
        """Return g(z), shape (rows,)."""

    @abstractmethod
    def jacobian_values(self, z: Array) -> Array:
        """Return the entries of ∂g/∂z at (`jacobian_rows`, `jacobian_columns`), shape (nonzeros,)."""

    @abstractmethod
    def objective(self, z: Array) -> float:
        """Return f(z)."""

    @abstractmethod
    def gradient(self, z: Array) -> Array:
        """Return ∂f/∂z, shape (size,)."""

    @property
    @abstractmethod
    def parts(self) -> tuple[Collocation, ...]:
        """The problem of each phase; one without phases is its own."""

    @abstractmethod
    def time(self, z: Array) -> float:
        """Return the time of the end, s."""

    def parameters(self, z: Array) -> dict[str, float]:
        """Return the values of the parameters that are unknowns."""
        first, part = self.parts[0], self.split(z)[0]
        return dict(zip(first.free, part[first.place["free"]].tolist(), strict=True))

    def split(self, z: Array) -> list[Array]:
        """Return the unknowns of each part."""
        return np.split(z, np.cumsum([one.size for one in self.parts]))[:-1]

    def coordinates(self, z: Array) -> Array:
        """Return q at all points, one behind the other."""
        return np.concatenate([x[one.place["q"]].ravel() for one, x in zip(self.parts, self.split(z), strict=True)])

    def solve(
        self,
        guess: Sequence[float] | Array | None = None,
        exact: bool | None = None,
        starts: int = 1,
        seed: int = 0,
        **options: Any,
    ) -> Solution:
        """Return what IPOPT finds: of several starts the best optimum, the others beside it (`Solution.optima`).

        What it finds is a local optimum, among neighbouring motions: `starts=8` looks for others, and tells how many
        there are and what each costs.

        Args:
            guess: z to start from, shape (size,); None takes the problem's own.
            exact: whether to compute second derivatives, else IPOPT gathers them on the way, in its limited memory;
                None computes them for up to 8 velocities.
            starts: how many searches: the first from the guess, the others from motions drawn about it.
            seed: of these.
            options: of IPOPT, such as max_iter=500 or tol=1e-9; see its documentation.

        Raises:
            SimulateError: CasADi is not installed, the guess has another shape or no value, or an equation between
                unknowns that are given does not hold; starts or a seed that are none.
        """
        check_arguments(NonlinearProgram.solve, {"guess": guess, "exact": exact}, SimulateError)
        from symdyn.transcription.ipopt import solve

        found = solve(self, guess, exact, starts, seed, options)
        if not found.success:
            told = f"{self.scene.name}: no solution was found: {found.status}; it misses bounds or equations by"
            warnings.warn(f"{told} {found.violation:.2g}", RuntimeWarning, stacklevel=3)
        return found

    def jacobian(self, z: Array) -> csr_array:
        """Return ∂g/∂z as a sparse matrix, shape (rows, size)."""
        from scipy.sparse import csr_array

        places = (self.jacobian_rows, self.jacobian_columns)
        return csr_array((self.jacobian_values(z), places), shape=(self.rows, self.size))

    @cached_property
    def given(self) -> NDArray[np.bool_]:
        """Whether each unknown is given: its bounds are equal, shape (size,)."""
        return np.equal(self.lower, self.upper)

    @cached_property
    def binding(self) -> NDArray[np.bool_]:
        """Whether each equation has an unknown in it that is not given, shape (rows,).

        One that has none holds already, as loops do at a start that closes them; solvers are better without it, and
        without one that has no bounds.
        """
        found = np.zeros(self.rows, dtype=bool)
        found[self.jacobian_rows[~self.given[self.jacobian_columns]]] = True
        found &= np.isfinite(self.rows_lower) | np.isfinite(self.rows_upper)
        return found

