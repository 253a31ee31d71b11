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

References: Hairer, Lubich and Wanner, Geometric Numerical Integration (2006), IV.4; Posa, Kuindersma and Tedrake,
Optimization and stabilization of trajectories for constrained dynamical systems, ICRA (2016).
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.arguments import check_arguments
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import ArgumentError, SimulateError, choice, listed, quoted
from symdyn.frozen import dataclass, field
from symdyn.rounding import in_digits
from symdyn.scene import Scene
from symdyn.shown import Shown
from symdyn.transcription.grid import ROWWISE, Grid, Method, Places, Slopes, sliced
from symdyn.transcription.local import PLACES, Local, Source
from symdyn.transcription.phases import Phase
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from symdyn.transcription.solution import Solution


@dataclass(frozen=True, eq=False)
class Collocation(Shown):
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
            (parameters,), "T" (phases,), or (0,) where it is given, "impulse" (phases - 1, all rows).
        row: of each kind of equation, where it stands in g: "balance" (S, nv + m), "defects" (N, R, nq + ns + nv),
            "held" (N + 1, …), "path" (N + 1, paths); of phases see `contact_entries`.
        size, rows: number of unknowns and of equations.
        duration: the time of the end, s; of a free one the middle of its bounds.
        lower, upper: bounds of z, shape (size,).
        rows_lower, rows_upper: bounds of g, shape (rows,).
        guess: z of a straight way from the start to the end, shape (size,).
        source: the functions of one place, and the graph that they were written on.
        notes: what a user should know: how loops closed at the start, where slopes are one-sided, one line each.
        schedule: the phases; one alone without contacts.
        law: what is asked where each but the first begins, α, β and ζ of each row, shape (phases - 1, …).
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
    schedule: tuple[Phase, ...] = ()
    law: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)

    def __repr__(self) -> str:
        unknown, (given, left) = ", ".join([*self.drives, *self.free]) or "none", self.ends
        end = f"\n    at the end {listed(given)}" if given else ""
        end += f"; not given: {listed(left)}" if left else ""
        unknown += "".join(f"; {one}" for one in self.notes if one.startswith("no cost"))
        span = f"{len(self.grid.widths)} intervals of {self.duration:g} s in all; {self.size} unknowns"
        return f"<Collocation of {self.scene.name}: {span}, {self.rows} equations; unknown: {unknown}{end}>"

    @property
    def ends(self) -> tuple[list[str], list[str]]:
        """States that are given at the end, with their values, and where some are, those that are not."""
        scene, node = self.scene, self.grid.node[-1]
        names = {"q": scene.coordinates, "s": [one.name for one in scene.states], "u": scene.velocities}
        ends = {name: k for kind, some in names.items() for name, k in zip(some, self.place[kind][node], strict=True)}
        free = [name for name, k in ends.items() if self.lower[k] != self.upper[k]]
        given = [f"{name} = {in_digits(self.lower[k], 6)}" for name, k in ends.items() if name not in free]
        return given, free if given else []

    @property
    def locals(self) -> Mapping[str, Local]:
        """The functions of one place, by name."""
        return self.source.locals

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
                None computes them for up to 18 velocities.
            starts: how many searches: the first from the guess, the others from motions drawn about it.
            seed: of these.
            options: of IPOPT, such as max_iter=500 or tol=1e-9; see its documentation.

        Raises:
            SimulateError: CasADi is not installed, the guess has another shape or no value, or an equation between
                unknowns that are given does not hold; starts or a seed that are none.
        """
        check_arguments(Collocation.solve, {"guess": guess, "exact": exact}, SimulateError)
        from symdyn.transcription.ipopt import solve

        found = solve(self, guess, exact, starts, seed, options)
        if not found.success:
            told = f"{self.scene.name}: no solution was found: {found.status}; it misses bounds or equations by"
            warnings.warn(f"{told} {found.violation:.2g}", RuntimeWarning, stacklevel=3)
        return found

    # Values

    def residual(self, z: Array) -> Array:
        """Return g(z), shape (rows,)."""
        self._check(z)
        g = np.empty(self.rows, np.result_type(z, np.float64))
        at = {"stage": self.at(z, "stage"), **self.elsewhere(z)}
        between, sums = self.between
        defects = self._part(g, self.row["defects"])
        rates = (sums @ self.rates(at["stage"])).reshape(defects.shape)
        defects[:] = (between @ z).reshape(defects.shape) - self.lasting(z, self.interval_phases, 2) * rates
        if "pull" in self.locals:
            defects[:, -1] -= self.locals["pull"].value(self.grid.behind(at["node"]))
        for name in ROWWISE:
            if name in self.locals:
                self._part(g, self.row[name])[:] = self.locals[name].value(at[PLACES[name]])
        if len(self.law):
            kept, joints = z[self.state[:, : self.row["stays"].shape[1]]], self.grid.joints
            g[self.row["stays"]] = kept[joints] - kept[joints - 1]
            g[self.row["time"]] = self.time(z)
        return g

    def elsewhere(self, z: Array) -> dict[str, dict[str, Array]]:
        """Return the unknowns at all nodes, and where phases meet, where a function asks for them."""
        return {where: self.at(z, where) for where in self._elsewhere}

    @cached_property
    def _elsewhere(self) -> tuple[str, ...]:
        asked = {PLACES[name] for name in self.locals}
        return tuple(where for where in ("node", "joint") if where in asked)

    @cached_property
    def between(self) -> tuple[csr_array, csr_array]:
        """What defects are without slacks: (y_i - y_0) as a matrix on z, and Σ A_ij f_j, over T, as one on rates f.

        Rates are q̇, ṡ and u̇ of all stages, one stage after the other, shape (S (nq + ns + nv),).
        """
        from scipy.sparse import csr_array

        grid, shape, y = self.grid, self.row["defects"].shape, self.state
        index = np.arange(self.row["defects"].size).reshape(shape)
        start = np.broadcast_to(y[self.grid.starts, None], shape)
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

    @cached_property
    def interval_phases(self) -> Places:
        """The phase of every interval, shape (N,)."""
        return self.grid.phase[self.grid.starts]

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
        return {"stage": sliced(grid.stage), "node": sliced(grid.node), "joint": grid.joints, "end": grid.node[-1:]}

    def jacobian_values(self, z: Array) -> Array:
        """Return the entries of ∂g/∂z at (`jacobian_rows`, `jacobian_columns`), shape (nonzeros,)."""
        self._check(z)
        return self._slopes.values(z)

    def jacobian(self, z: Array) -> csr_array:
        """Return ∂g/∂z as a sparse matrix, shape (rows, size)."""
        from scipy.sparse import csr_array

        places = (self.jacobian_rows, self.jacobian_columns)
        return csr_array((self.jacobian_values(z), places), shape=(self.rows, self.size))

    def objective(self, z: Array) -> float:
        """Return f(z): the integral of the running cost by the method's own rule, and the cost of the end."""
        self._check(z)
        total: Any = 0.0
        if "running" in self.locals:
            values = self.locals["running"].value(self.at(z, "stage"))[:, 0]
            total = self.weights(z) @ values
        if "final" in self.locals:
            total = total + self.locals["final"].value(self.at(z, "end"))[0, 0]
        return total  # type: ignore[no-any-return]

    def gradient(self, z: Array) -> Array:
        """Return ∂f/∂z, shape (size,)."""
        self._check(z)
        found = np.zeros(self.size)
        T = self.place["T"]
        for name, weights in (("running", self.weights(z)), ("final", np.ones(1))):
            if name not in self.locals:
                continue
            local, at = self.locals[name], self.at(z, PLACES[name])
            columns, known, chain = self.wires[name]
            slopes = local.slopes(at) * chain * weights[:, None]
            found += np.bincount(columns[known], slopes[known], self.size)
            if name == "running" and len(T):
                np.add.at(found, T[self.stage_phases], self.grid.quadrature * local.value(at)[:, 0])
        return found

    def time(self, z: Array) -> float:
        """Return the time of the end, s."""
        takes = self.durations(z)
        return takes.sum() if len(self.law) else takes[0]  # type: ignore[no-any-return]

    def durations(self, z: Array) -> Array:
        """Return how long each phase takes, s, shape (phases,)."""
        self._check(z)
        T = self.place["T"]
        return z[T] if len(T) else self._known

    @cached_property
    def _known(self) -> Array:
        return np.array([one.span[0] for one in self.schedule])

    def lasting(self, z: Array, phases: Places, axes: int = 0) -> Any:
        """Return how long phases take, s, with so many axes of one behind; one number of a problem with one."""
        takes = self.durations(z)
        return takes[phases].reshape(-1, *[1] * axes) if len(self.law) else takes[0]

    def weights(self, z: Array) -> Array:
        """Return the weight of every stage in an integral, s, shape (S,)."""
        return np.asarray(self.lasting(z, self.stage_phases) * self.grid.quadrature)

    @cached_property
    def stage_phases(self) -> Places:
        """The phase of every stage, shape (S,)."""
        return self.grid.phase[self.grid.stage]

    def times(self, z: Array) -> Array:
        """Return the time of every point, s, shape (P,)."""
        takes = self.durations(z)
        if not len(self.law):
            return np.asarray(takes[0] * self.grid.share)
        began = np.concatenate([[0.0], np.cumsum(takes)[:-1]])
        return began[self.grid.phase] + takes[self.grid.phase] * self.grid.share

    def parameters(self, z: Array) -> dict[str, float]:
        """Return the values of the parameters that are unknowns."""
        self._check(z)
        return dict(zip(self.free, z[self.place["free"]].tolist(), strict=True))

    # Pattern

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
        found = np.isfinite(self.rows_lower) | np.isfinite(self.rows_upper)
        found[found] = np.isin(np.flatnonzero(found), self.jacobian_rows[~self.given[self.jacobian_columns]])
        return found

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
        if kind not in place and kind not in (TIME, "before"):
            raise ArgumentError(f"kind {kind!r} is not known; {choice(kind, (*place, TIME))}")
        count = place["u" if kind == "before" else kind].shape[-1] if kind != TIME else 1
        if not 0 <= k < count:
            raise ArgumentError(f"k = {quoted(k)}: there are {count} of {kind}, counted from 0")
        if getattr(points, "dtype", np.dtype(float)).kind not in "iu" or np.any(np.abs(points) >= len(place["q"])):
            raise ArgumentError(f"points = {quoted(points)}: give places of points, as points('node') does")
        if kind == TIME:
            return place["T"] if len(place["T"]) else np.array([-1])
        if kind == "free":
            return place["free"][k : k + 1]
        if kind == "slack":
            found: Places = np.full(len(self.grid.node), -1)
            found[self.grid.ends] = place["slack"][:, k]
            return found
        if kind == "before":
            kind, points = "u", points - 1
        return place[kind][points if kind in ("q", "s", "u") else slice(None), k]

    def points(self, where: str) -> Places:
        """Return the points of all stages or nodes, those where further phases begin, or the end.

        Raises:
            ArgumentError: `where` is neither "stage", "node", "joint" nor "end".
        """
        self._check_where(where)
        grid = self.grid
        return {"stage": grid.stage, "node": grid.node, "joint": grid.joints, "end": grid.node[-1:]}[where]

    # Unknowns at places

    def at(self, z: Array, where: str) -> dict[str, Array]:
        """Return the unknowns at all stages or nodes, where further phases begin, or at the end, by kind.

        Raises:
            ArgumentError: `where` is neither "stage", "node", "joint" nor "end".
        """
        self._check(z)
        self._check_where(where)
        place, points = self.place, self._slices[where]
        found = {kind: self._part(z, place[kind])[points] for kind in ("q", "s", "u")}
        if where == "stage":
            found |= {kind: self._part(z, place[kind]) for kind in ("a", "multiplier", "contact", "force")}
        if where == "node":
            found["slack"] = np.zeros((len(self.grid.node), place["slack"].shape[1]), z.dtype)
            found["slack"][self.grid.ends] = z[place["slack"]]
        if where == "joint":
            before = self._part(z, place["u"])[self.grid.joints - 1]
            found |= {"before": before, "impulse": z[place["impulse"]], "law": self.law}
        found["free"] = z[place["free"]]
        found[TIME] = self.times(z)[points]
        if self.source.written.contacts.touches:
            found["mode"] = self.modes[self.grid.phase[points]]
        return found

    @cached_property
    def modes(self) -> Array:
        """What contacts do in each phase, three numbers of each contact, see `contact_entries`."""
        contacts = self.source.written.contacts
        return np.array([one.numbers(contacts) for one in self.schedule])

    def _check(self, z: Array) -> None:
        """Raise ArgumentError for what are no unknowns."""
        if getattr(z, "shape", None) != (self.size,) or z.dtype.kind not in "fiuc":
            raise ArgumentError(f"z = {quoted(z)}: give an array of shape ({self.size},), such as guess")

    def _check_where(self, where: str) -> None:
        if not isinstance(where, str) or where not in self._slices:
            raise ArgumentError(f"where = {quoted(where)}: give {', '.join(self._slices)}")
