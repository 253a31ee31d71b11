"""Equations of the coordinates along paths of points and frames, at one time.

    A u = b          rows of laws of coordinates and of loops (following.py), and of paths (point_path.py)
    A u̇ = c          c = ḃ - Ȧ u
    r                residuals of loops and paths
    σ                the smallest singular value of A, dimensionless, over the largest

Where A leaves freedoms the velocities are the shortest, u = A⁺ b, integrated; their derivative is exact as well:

    u̇ = A⁺ c + (1 - A⁺ A) Ȧᵀ A⁺ᵀ u

Reference: Whitney, Resolved motion rate control of manipulators and human prostheses, IEEE Trans. Man-Machine Systems
10 (1969) 47; Golub and Pereyra, The differentiation of pseudo-inverses, SIAM J. Numer. Anal. 10 (1973) 413, eq. (4.12).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.errors import DerivationError, SimulateError
from symdyn.frozen import dataclass
from symdyn.simulation.following import CLOSED, NEGLIGIBLE, Following, integrated, shortest
from symdyn.simulation.prescribed.point_path import Approach, PathRequest, PointPath

AGREED = 1e-7
"""Largest difference of both sides of A u = b, over the size of the velocities."""

STEPS, HALVINGS, WIDEST = 60, 12, 0.5


@dataclass(frozen=True)
class PathPlace:
    """Where a path is: q (nq,), u (nv,), u̇ (nv,), the dimensionless A of what is loose, and σ over its usual size."""

    t: float
    q: Array
    u: Array
    a: Array
    A: Array
    clear: float


class PathEquations:
    """The equations of the module's legend."""

    def __init__(
        self,
        following: Following,
        paths: Sequence[PointPath | Approach],
        rates: Callable[[Array, Array], dict[str, Array]],
    ) -> None:
        """Take laws and loops, paths, and what gives the rates of their matrices by name where they are needed."""
        self.following, self.paths, self.rates = following, tuple(paths), rates
        self.numbers, self.functions = following.numbers, following.functions
        self._asked: tuple[float, list[tuple[PointPath | Approach, PathRequest]]] = np.nan, []

    # Equations

    def requested(self, t: float) -> list[tuple[PointPath | Approach, PathRequest]]:
        """Return what every path asks for at a time."""
        if self._asked[0] != t:
            self._asked = t, [(path, path.at(t)) for path in self.paths]
        return self._asked[1]

    def matrix(self, t: float, q: Array, holding: bool = False) -> Array:
        """Return A, of position-level rows only on request."""
        own = self.following.matrix(q)
        if holding and len(self.following.holding):
            own = own[np.concatenate([np.ones(len(own) - len(self.following.holding), bool), self.following.holding])]
        still = self.following.still
        return np.vstack(
            [own, *(one.S @ self.functions(f"jacobian:{p.name}", q, still) for p, one in self.requested(t))]
        )

    def missed(self, t: float, q: Array) -> Array:
        """Return the residuals of loops and paths."""
        still = self.following.still
        found = [self.functions("constraint_residual", q, still)]
        for path, asked in self.requested(t):
            T = self.functions(f"pose:{path.name}", q, still)
            known = np.isfinite(T).all()
            found.append(asked.residual(T[:, :3], T[:, 3]) if known else np.full(path.rows, np.nan))
        return np.concatenate(found)

    def velocities(self, t: float, q: Array, A: Array) -> Array:
        """Return u.

        Raises:
            SimulateError: what laws and paths ask for contradicts each other.
        """
        b = self.first(t)
        if not np.isfinite(A).all():
            raise SimulateError(f"path: t = {t:g} s: {self.names} has no finite velocity there")
        u = self._solved(A, b)
        if float(np.abs(A @ u - b).max(initial=0.0)) > AGREED * max(1.0, float(np.abs(u).max(initial=0.0))):
            raise SimulateError(
                f"path: t = {t:g} s: {self.names} cannot move there as the path does; let it go where it can"
            )
        return u

    def accelerations(self, t: float, q: Array, u: Array, A: Array) -> Array:
        a = self._solved(A, self.second(t, q, u))
        if self.left:  # what least velocities take besides
            few = A[:, self.loose]
            inverse = np.linalg.pinv(few, rcond=NEGLIGIBLE)
            way = self._rate(t, q, u)[:, self.loose].T @ (inverse.T @ u[self.loose])
            a[self.loose] += way - inverse @ (few @ way)
        return a

    def first(self, t: float) -> Array:
        """Return b."""
        return np.concatenate([self.following.first(t), *(one.b for _, one in self.requested(t))])

    def second(self, t: float, q: Array, u: Array) -> Array:
        """Return c."""
        found = [self.following.second(t, q, u)]
        for path, asked in self.requested(t):
            twist = self.functions(f"jacobian:{path.name}", q, u) @ u
            bias = self.functions(f"jdot_qdot:{path.name}", q, u)
            found.append(asked.rate_of_b - asked.rate_of_S @ twist - asked.S @ bias)
        return np.concatenate(found)

    def _rate(self, t: float, q: Array, u: Array) -> Array:
        rates = self.rates(q, u)
        following = self.following
        found = [rates["kinematics"][[following.places[k] for k in following.moving]]]
        found += [np.zeros((len(following.quasi), len(u))), rates["constraint_jacobian"]]
        for path, asked in self.requested(t):
            J = self.functions(f"jacobian:{path.name}", q, u)
            found.append(asked.rate_of_S @ J + asked.S @ rates[f"jacobian:{path.name}"])
        return np.vstack(found)

    def _solved(self, A: Array, b: Array) -> Array:
        """Return the shortest x with A x = b, what laws say as it is; what no row knows rests."""
        x = self.following.solved(A, b)
        x[self.idle] = 0.0
        return x

    @property
    def names(self) -> str:
        return ", ".join(path.name for path in self.paths)

    # What kind of equations they are

    def looked_at(self, t: float, q: Array) -> None:
        """Decide at places around q what is loose, how large rows and σ are, and how many freedoms are left."""
        near = [one for one in self._places_around(q) if np.isfinite(self.matrix(t, one)).all()]
        every, loose = [self.matrix(t, one) for one in near], self.following.loose
        if not every:
            raise SimulateError(
                f"path: t = {t:g} s: no finite motion of {self.names} at the start; give another ({argument('start')})"
            )
        sizes = np.max([np.abs(A).max(axis=0, initial=0.0) for A in every], axis=0)
        self.idle = np.array([k for k in loose if sizes[k] <= NEGLIGIBLE], dtype=int)
        self.loose = np.array([k for k in loose if sizes[k] > NEGLIGIBLE], dtype=int)
        turns = set(self.numbers.angular_velocities)
        slides = [i for i, k in enumerate(self.loose) if k not in turns]
        levers = [A[len(A) - sum(p.rows for p in self.paths) :, sorted(turns)] for A in every]
        self.length = max((float(np.abs(one).max(initial=0.0)) for one in levers), default=0.0) or 1.0
        self.columns = np.ones(len(self.loose))
        self.columns[slides] = self.length
        rows = np.max([np.abs(A[:, self.loose] * self.columns).max(axis=1, initial=0.0) for A in every], axis=0)
        self.row_sizes = np.where(rows > NEGLIGIBLE * rows.max(initial=1.0), rows, 1.0)
        self.usual, self.rank = 1.0, 0
        values = [self._values(A) for A in every]
        self.rank = max((int(np.sum(one > 1e-8 * one.max(initial=1e-6))) for one in values), default=0)
        self.usual = max((one[self.rank - 1] / one[0] for one in values), default=1.0) if self.rank else 1.0
        self.left = len(self.loose) - self.rank
        held = max(int(np.linalg.matrix_rank(self.matrix(t, one, True)[:, self.loose], tol=1e-8)) for one in near)
        self.integrating = self.left > 0 or held < self.rank

    def _places_around(self, q: Array) -> Iterator[Array]:
        """Yield q and, if loops close there, places not far from it."""
        yield q
        turns = self.numbers.angular_velocities
        for seed in range(3):
            way = np.random.default_rng(seed).uniform(-0.4, 0.4, self.numbers.state.n)
            way[[k for k in range(len(way)) if k not in turns]] *= 0.1
            moved = self.retract(q, way)
            try:
                if len(self.following.holding):
                    moved = self.numbers.newton(moved, ())
                    if not self.numbers.is_closed(moved):
                        continue
                yield moved
            except DerivationError:  # a formula has no value there
                continue

    def scaled(self, A: Array) -> Array:
        """Return the columns of A that are loose, dimensionless."""
        return np.asarray(A[:, self.loose] * self.columns / self.row_sizes[:, None])

    def _values(self, A: Array) -> Array:
        return np.asarray(np.linalg.svd(self.scaled(A), compute_uv=False)) if len(self.loose) else np.zeros(0)

    # Places

    def retract(self, q: Array, step: Array) -> Array:
        """Return q after a step along the velocities."""
        return self.numbers.normalised(q + self.functions("kinematics", q, self.following.still) @ step)

    def placed(self, t: float, q: Array) -> Array | None:
        """Return the position next to a guess that keeps laws, loops and paths; None where there is none near by."""
        q = q.copy()
        q[self.following.places] = self.following.at(t)[0]
        r = self.missed(t, q)
        for _ in range(STEPS):
            size = float(np.abs(r).max(initial=0.0))
            if size <= 1e-15 * max(1.0, float(np.abs(q).max(initial=0.0))) or not np.isfinite(size):
                break
            A = self.matrix(t, q)
            if not np.isfinite(A).all():
                return None
            step = np.zeros(A.shape[1])
            step[self.loose] = self.columns * shortest(
                self.scaled(A)[len(A) - len(r) :], -r / self.row_sizes[len(A) - len(r) :]
            )
            factor = min(1.0, WIDEST / float(np.abs(step[self.loose] / self.columns).max(initial=WIDEST)))
            for _ in range(HALVINGS):
                tried = self.retract(q, factor * step)
                tried[self.following.places] = q[self.following.places]
                left = self.missed(t, tried)
                if float(left @ left) < float(r @ r):
                    break
                factor /= 2
            else:
                break
            q, r = tried, left
        off = float(np.abs(r).max(initial=0.0))
        return q if off <= CLOSED * max(1.0, float(np.abs(q).max(initial=0.0))) else None

    def place(self, t: float, q: Array) -> PathPlace:
        """Return what a position on the path at t belongs to; SimulateError where it has no velocities."""
        A = self.matrix(t, q)
        u = self.velocities(t, q, A)
        return PathPlace(t, q, u, self.accelerations(t, q, u, A), self.scaled(A), self.clear(A))

    def clear(self, A: Array) -> float:
        """Return σ over its usual size."""
        values = self._values(A)
        return float(values[self.rank - 1] / values[0] / self.usual) if self.rank and values[0] > 0 else 1.0

    # How far away

    def nearest(self, t: float, q: Array) -> tuple[Array, float]:
        """Return a place next to q that misses the path at t least, and its largest residual; the loops are closed."""
        weights = np.ones(len(self.missed(t, q)))
        paths = sum(path.rows for path in self.paths)
        weights[: len(weights) - paths] = 1e4
        q = q.copy()
        q[self.following.places] = self.following.at(t)[0]
        r, damping = weights * self.missed(t, q), 1e-3
        for _ in range(200):
            A = self.matrix(t, q)
            A = weights[:, None] * A[len(A) - len(r) :, self.loose] * self.columns
            if not (np.isfinite(A).all() and np.isfinite(r).all()):
                break
            slope = A.T @ r
            if float(np.abs(slope).max(initial=0.0)) < 1e-13:
                break
            step = np.zeros(self.numbers.state.n)
            damped = np.vstack([A, np.sqrt(damping) * np.eye(len(self.loose))])
            step[self.loose] = self.columns * shortest(damped, np.concatenate([-r, np.zeros(len(self.loose))]))
            tried = self.retract(q, step)
            tried[self.following.places] = q[self.following.places]
            left = weights * self.missed(t, tried)
            if float(left @ left) < float(r @ r):
                q, r, damping = tried, left, max(1e-12, damping / 5)
            else:
                damping *= 5
                if damping > 1e8:
                    break
        return q, float(np.abs(r / weights).max(initial=0.0))

    # Least velocities

    def integrated(self, t: Array, first: PathPlace) -> Iterator[Array]:
        """Yield positions at times by integration of the least velocities; errors as of `integrated`."""

        def rates(now: float, at: Array) -> Array:
            here = at.copy()
            here[self.following.places] = self.following.at(now)[0]
            A = self.matrix(now, here)
            return np.asarray(self.functions("kinematics", here, self.following.still) @ self.velocities(now, here, A))

        told = "path: t = {:.6g} s: the velocities have no finite value there"
        return integrated(rates, t, first.q, 1e-13, told)
