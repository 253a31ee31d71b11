"""The noun of this package: an optimal control problem as equations in numbers, with derivatives and their pattern.

    minimise f(z)    with    lower <= z <= upper    and    rows_lower <= g(z) <= rows_upper

    balance     M u̇ + h = τ + Gᵀ λ,  G u̇ + Ġ u = 0                              at every stage
    defects     q_i = q_0 + h Σ A_ij H(q_j) u_j,   u_i = u_0 + h Σ A_ij u̇_j       at every stage inside an interval
                q_1 = q_0 + h Σ b_j H(q_j) u_j + H Gᵀ ν + ρ e,   u_1 = u_0 + h Σ b_j u̇_j + Gᵀ μ
                states of one's own, ṡ = rate(t, q, u, s), as coordinates
    held        r(q) = 0,  G u = 0,  |e| = 1                                      at every end of an interval

Closed mechanisms keep all their coordinates, with multipliers: no partition is chosen, so none can fail on the way, and
λ is told. Rows at the level of accelerations make λ unique at every stage; rows at the levels of positions and
velocities are held at the ends of intervals, where ν and μ make room for them: the step is projected along Gᵀ, which
keeps its order. Wheels that roll have rows without a position, and no ν. A unit quaternion e has ρ for its length.

References: Hairer, Lubich and Wanner, Geometric Numerical Integration (2006), section IV.4, projection; Posa,
Kuindersma and Tedrake, Optimization and stabilization of trajectories for constrained dynamical systems, ICRA (2016),
who hold the three levels in this way too, with Hermite-Simpson collocation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.arguments import check_arguments
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import ArgumentError, choice, quoted
from symdyn.scene import Scene
from symdyn.transcription.grid import ROWWISE, Grid, Method, Places, Slopes, sliced
from symdyn.transcription.local import PLACES, Local, Source
from symdyn.transcription.nonlinear_program import NonlinearProgram
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from scipy.sparse import csr_array

@dataclass(frozen=True, eq=False)
class Collocation(NonlinearProgram):
    """An optimal control problem of a scene, in N intervals.

    Attributes:
        scene: the mechanism.
        method: where the dynamics holds.
        grid: points, nodes and stages.
        free: names of the parameters that are unknowns.
        drives: names of the driving forces, and then of the inputs, that are unknowns.
        driven: their velocities; behind velocities the inputs, as `Forces` counts them.
        place: of each kind of unknown, where it stands in z: "q" (P, nq), "s" (P, ns), "u" (P, nv), "a" (S, nv),
            "multiplier" (S, m), "contact" (S, rows of contacts), "force" (S, drives), "slack" (N, slacks), "free"
            (parameters,), "T" (1,) or (0,) where it is given.
        row: of each kind of equation, where it stands in g: "balance" (S, nv + m), "defects" (N, R, nq + ns + nv),
            "held" (N + 1, …), "path" (N + 1, paths), "cone" (S, …), "open" (N + 1, …).
        size, rows: number of unknowns and of equations.
        duration: the time of the end, s; of a free one the middle of its bounds.
        lower, upper: bounds of z, shape (size,).
        rows_lower, rows_upper: bounds of g, shape (rows,).
        guess: z of a straight way from the start to the end, shape (size,).
        source: the functions of one place, and the graph that they were written on.
        notes: what a user should know: how loops closed at the start, where slopes are one-sided, one line each.
        mode: what contacts do, three numbers of each, see `contact_entries`.
        last: whether the cost of the end is asked for.
    """

    scene: Scene = field(repr=False)
    method: Method = field(repr=False)
    grid: Grid = field(repr=False)
    free: tuple[str, ...]
    drives: tuple[str, ...]
    driven: tuple[int, ...]
    place: Mapping[str, Places] = field(repr=False)
    row: Mapping[str, Places] = field(repr=False)
    size: int
    rows: int
    duration: float
    lower: Array = field(repr=False)
    upper: Array = field(repr=False)
    rows_lower: Array = field(repr=False)
    rows_upper: Array = field(repr=False)
    guess: Array = field(repr=False)
    source: Source = field(repr=False)
    notes: tuple[str, ...] = ()
    mode: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    last: bool = True

    def __repr__(self) -> str:
        unknown = ", ".join([*self.drives, *self.free]) or "none"
        span = f"{len(self.grid.widths)} intervals of {self.duration:g} s in all"
        counts = f"{self.size} unknowns, {self.rows} equations"
        return f"<Collocation of {self.scene.name}: {span}; {counts}; unknown: {unknown}>"

    @property
    def locals(self) -> Mapping[str, Local]:
        """The functions of one place that the motion has, by name."""
        without = ("passage",) if self.last else ("passage", "end")
        return {name: one for name, one in self.source.locals.items() if PLACES[name] not in without}

    @property
    def parts(self) -> tuple[Collocation, ...]:
        """It alone."""
        return (self,)

    # Values

    def residual(self, z: Array) -> Array:
        """Return g(z), shape (rows,)."""
        self._check(z)
        g = np.empty(self.rows, np.result_type(z, np.float64))
        stages, nodes = self.at(z, "stage"), self.at_nodes(z)
        self._part(g, self.row["balance"])[:] = self.locals["balance"].value(stages)
        between, sums = self.between
        defects = self._part(g, self.row["defects"])
        defects[:] = (between @ z - self.time(z) * (sums @ self.rates(stages))).reshape(defects.shape)
        if "pull" in self.locals:
            defects[:, -1] -= self.locals["pull"].value(self.behind(nodes))
        for name in ROWWISE[1:]:
            if name in self.locals:
                at = stages if PLACES[name] == "stage" else nodes
                self._part(g, self.row[name])[:] = self.locals[name].value(at)
        return g

    def at_nodes(self, z: Array) -> dict[str, Array]:
        """Return the unknowns at all nodes, where a function asks for them."""
        return self.at(z, "node") if any(PLACES[name] == "node" for name in self.locals) else {}

    @cached_property
    def between(self) -> tuple[csr_array, csr_array]:
        """What defects are without slacks: (y_i - y_0) as a matrix on z, and Σ A_ij f_j, over T, as one on rates f.

        Rates are q̇, ṡ and u̇ of all stages, one stage after the other, shape (S (nq + ns + nv),).
        """
        from scipy.sparse import csr_array

        grid, shape, y = self.grid, self.row["defects"].shape, self.state
        index = np.arange(self.row["defects"].size).reshape(shape)
        start = np.broadcast_to(y[grid.node[:-1], None], shape)
        columns = np.concatenate([y[grid.target].ravel(), start.ravel()])
        signs = np.repeat([1.0, -1.0], index.size)
        rows = np.concatenate([index.ravel(), index.ravel()])
        places = np.arange(len(grid.stage) * shape[2]).reshape(-1, shape[2])
        parts = [
            np.broadcast_arrays(grid.widths[:, None] * grid.weights[r, j], index[:, r], places[grid.of[:, j]])
            for r, j in self.used
        ]
        weights, at, stages = (np.concatenate([part[k].ravel() for part in parts]) for k in range(3))
        difference = csr_array((signs, (rows, columns)), shape=(index.size, self.size))
        return difference, csr_array((weights, (at, stages)), shape=(index.size, places.size))

    @property
    def state(self) -> Places:
        """Where q, s and u of all points stand in z, shape (P, nq + ns + nv)."""
        return np.concatenate([self.place[kind] for kind in ("q", "s", "u")], axis=1)

    def rates(self, stages: Mapping[str, Array]) -> Array:
        """Return q̇, ṡ and u̇ of all stages, as `between` takes them."""
        if not (isinstance(stages, Mapping) and {"q", "u", "a"} <= {*stages}):
            raise ArgumentError(f"stages = {quoted(stages)}: give what at(z, 'stage') returns")
        return np.concatenate([self.locals["rates"].value(stages), stages["a"]], axis=1).ravel()

    @staticmethod
    def _part(x: Array, places: Places) -> Array:
        """Return what stands at places that follow one another, as a view in their shape."""
        return x[places.flat[0] : places.flat[-1] + 1].reshape(places.shape) if places.size else np.zeros(places.shape)

    @cached_property
    def _slices(self) -> dict[str, Any]:
        """Points and stages of all intervals, without copies where they are equally far apart."""
        grid = self.grid
        return {
            "stage": sliced(grid.stage),
            "node": sliced(grid.node),
            "end": grid.node[-1:],
        }

    def jacobian_values(self, z: Array) -> Array:
        """Return the entries of ∂g/∂z at (`jacobian_rows`, `jacobian_columns`), shape (nonzeros,)."""
        self._check(z)
        return self._slopes.values(z)

    def objective(self, z: Array) -> float:
        """Return f(z): the integral of the running cost by the method's own rule, and the cost of the end."""
        self._check(z)
        total: Any = 0.0
        if "running" in self.locals:
            values = self.locals["running"].value(self.at(z, "stage"))[:, 0]
            total = self.time(z) * (self.grid.quadrature @ values)
        if "final" in self.locals:
            total = total + self.locals["final"].value(self.at(z, "end"))[0, 0]
        return total  # type: ignore[no-any-return]

    def gradient(self, z: Array) -> Array:
        """Return ∂f/∂z, shape (size,)."""
        self._check(z)
        found = np.zeros(self.size)
        T = self.place["T"]
        for name, weights in (("running", self.time(z) * self.grid.quadrature), ("final", np.ones(1))):
            if name not in self.locals:
                continue
            local, at = self.locals[name], self.at(z, PLACES[name])
            columns, known, chain = self.wires[name]
            slopes = local.slopes(at) * chain * weights[:, None]
            found += np.bincount(columns[known], slopes[known], self.size)
            if name == "running" and len(T):
                found[T[0]] += self.grid.quadrature @ local.value(at)[:, 0]
        return found

    def time(self, z: Array) -> float:
        """Return the time of the end, s."""
        self._check(z)
        T = self.place["T"]
        return z[T[0]] if len(T) else self.duration

    # Pattern

    @property
    def jacobian_rows(self) -> Places:
        """Rows of the entries of ∂g/∂z that are not always zero, ascending, shape (nonzeros,)."""
        return self._slopes.rows

    @property
    def jacobian_columns(self) -> Places:
        """Their columns, ascending in each row; none occurs twice."""
        return self._slopes.columns

    @cached_property
    def _slopes(self) -> Slopes:
        return Slopes(self)

    @cached_property
    def used(self) -> list[tuple[int, int]]:
        """Defects and stages whose weight is not zero."""
        return [(int(r), int(j)) for r, j in np.argwhere(self.grid.weights != 0)]

    @cached_property
    def wires(self) -> dict[str, tuple[Places, NDArray[np.bool_], Array]]:
        """Of the slopes of each function, shape (places, nonzeros): columns of z, whether these are unknowns, chain.

        The chain is what slopes are multiplied by: t / T of the place where they are by time, else 1.
        """
        found = {}
        for name, local in self.locals.items():
            points = self.points(PLACES[name])
            columns = np.empty((len(points), len(local.pattern)), dtype=np.int64)
            for column, (_, kind, k) in zip(columns.T, local.pattern, strict=True):
                column[:] = self.column(kind, k, points)
            by_time = np.array([kind == TIME for _, kind, _ in local.pattern], dtype=bool)
            chain = np.where(by_time, self.grid.share[points][:, None], 1.0)
            found[name] = (columns, columns >= 0, chain)
        return found

    def column(self, kind: str, k: int, points: Places) -> Places:
        """Return where an unknown stands in z at some points, -1 where it is known.

        Raises:
            ArgumentError: there is no such kind, or none at that place.
        """
        check_arguments(Collocation.column, locals())
        place = self.place
        if kind not in place and kind != TIME:
            raise ArgumentError(f"kind {kind!r} is not known; {choice(kind, (*place, TIME))}")
        if kind != TIME and not 0 <= k < place[kind].shape[-1]:
            raise ArgumentError(f"k = {quoted(k)}: there are {place[kind].shape[-1]} of {kind}, counted from 0")
        if getattr(points, "dtype", np.dtype(float)).kind not in "iu" or np.any(np.abs(points) >= len(place["q"])):
            raise ArgumentError(f"points = {quoted(points)}: give places of points, as points('node') does")
        if kind == TIME:
            return place["T"] if len(place["T"]) else np.array([-1])
        if kind == "free":
            return place["free"][k : k + 1]
        if kind == "slack":
            return np.concatenate([[-1], place["slack"][:, k]])
        return place[kind][points if kind in ("q", "s", "u") else slice(None), k]

    def points(self, where: str) -> Places:
        """Return the points of all stages or nodes, or the end.

        Raises:
            ArgumentError: `where` is neither "stage", "node" nor "end".
        """
        self._check_where(where)
        return {"stage": self.grid.stage, "node": self.grid.node, "end": self.grid.node[-1:]}[where]

    # Unknowns at places

    def at(self, z: Array, where: str) -> dict[str, Array]:
        """Return the unknowns at all stages or nodes, or at the end, by kind.

        Raises:
            ArgumentError: `where` is neither "stage", "node" nor "end".
        """
        self._check(z)
        self._check_where(where)
        place, points = self.place, self._slices[where]
        found = {kind: self._part(z, place[kind])[points] for kind in ("q", "s", "u")}
        if where == "stage":
            found |= {kind: self._part(z, place[kind]) for kind in ("a", "multiplier", "contact", "force")}
        if where == "node":
            found["slack"] = np.concatenate([np.zeros((1, place["slack"].shape[1])), z[place["slack"]]])
        found |= {"free": z[place["free"]], "mode": self.mode}
        found[TIME] = self.time(z) * self.grid.share[points]
        return found

    def _check(self, z: Array) -> None:
        """Raise ArgumentError for what are no unknowns."""
        if getattr(z, "shape", None) != (self.size,) or z.dtype.kind not in "fiuc":
            raise ArgumentError(f"z = {quoted(z)}: give an array of shape ({self.size},), such as guess")

    def _check_where(self, where: str) -> None:
        if not isinstance(where, str) or where not in self._slices:
            raise ArgumentError(f"where = {quoted(where)}: give {', '.join(self._slices)}")

    @staticmethod
    def behind(nodes: Mapping[str, Array]) -> dict[str, Array]:
        """Return what holds at all nodes but the first."""
        return {kind: x if kind in ("free", "mode") else x[1:] for kind, x in nodes.items()}
