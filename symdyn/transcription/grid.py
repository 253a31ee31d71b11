"""The grid of a collocation problem: methods, places of unknowns in a vector z and of equations in g, and ∂g/∂z.

    node     an end of an interval, N + 1 of them
    stage    a place where the dynamics holds
    point    a node or a stage, P of them, in the order of time

    z = [q, s, u of all points | a, λ, τ of all stages | slacks of all nodes but the first | p | T]
    g = [balance of all stages | defects of q, s and u of each interval | held of all nodes | path of all nodes]

Entries of the Jacobian ∂g/∂z are sums of parts. Parts that are the same at every z, as all of the defects of a tree
whose time is given, are computed once.

Methods of collocation are Runge-Kutta methods whose stages are the places where the dynamics holds:

    c        stages within an interval, 0 … 1
    A, b     stage i: y_i = y_0 + h Σ A_ij f_j; end: y_1 = y_0 + h Σ b_j f_j
    order    p, with which a smooth solution's error falls: h^p

A first stage at 0 and a last one at 1 are the interval's ends, and its neighbours have them too. Simpson's rule and the
cubic through the ends, (y_0 + y_1) / 2 + h (f_0 - f_1) / 8 in the middle, are A and b of Lobatto IIIA with three
stages: Hermite-Simpson collocation, in its separated form, where the middle is an unknown.

References: Hargraves and Paris, Direct trajectory optimization using nonlinear programming and collocation, J. Guidance
10 (1987) 338; Betts, Practical Methods for Optimal Control (2010), sections 4.5 and 4.6; Kelly, An introduction to
trajectory optimization, SIAM Review 59 (2017) 849, sections 3 and 4; Hairer and Wanner, Solving Ordinary Differential
Equations II (1996), tables IV.5.1 (Gauss), IV.5.7 (Lobatto IIIA).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from operator import index
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.frozen import dataclass
from symdyn.scene.values import Faults, Parameter
from symdyn.simulation.prescribed import read_number
from symdyn.transcription.local import PLACES
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.transcription.transcribed import Collocation


Row = tuple[Fraction, ...]


@dataclass(frozen=True)
class Method:
    """A method of collocation.

    Attributes:
        text: what it is.
        c, b: shape (s,).
        A: shape (s, s).
        order: p.
    """

    text: str
    c: Row
    A: tuple[Row, ...]
    b: Row
    order: int

    @property
    def starts(self) -> bool:
        """Whether the first stage is the interval's start."""
        return self.c[0] == 0

    @property
    def ends(self) -> bool:
        """Whether the last stage is the interval's end."""
        return self.c[-1] == 1

    @property
    def inner(self) -> range:
        """The stages between the ends."""
        return range(int(self.starts), len(self.c) - int(self.ends))


def _row(text: str) -> Row:
    return tuple(map(Fraction, text.split()))


def _method(text: str, order: int, c: str, A: Sequence[str], b: str) -> Method:
    return Method(text, _row(c), tuple(map(_row, A)), _row(b), order)


METHODS: dict[str, Method] = {
    "trapezoidal": _method(
        "the trapezoidal rule, Lobatto IIIA with two stages", 2, "0 1", ("0 0", "1/2 1/2"), "1/2 1/2"
    ),
    "hermite_simpson": _method(
        "Hermite-Simpson, separated; Lobatto IIIA with three stages",
        4,
        "0 1/2 1",
        ("0 0 0", "5/24 1/3 -1/24", "1/6 2/3 1/6"),
        "1/6 2/3 1/6",
    ),
    "implicit_midpoint": _method("the implicit midpoint rule, Gauss with one stage", 2, "1/2", ("1/2",), "1"),
}
"""By the name that `symdyn.collocation` takes."""


Places = NDArray[np.int64]
"""Indices."""

ROWWISE = ("balance", "held", "path", "cone", "open", "momentum", "law", "touch", "struck")
"""Functions whose entries are equations as they are."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Points, nodes and stages of a mesh, and how they hang together."""

    widths: Array  # h_n / T of every interval, shape (N,)
    share: Array  # t / T of every point, within its phase, shape (P,)
    node: Places  # points that are nodes, shape (N + phases,)
    stage: Places  # points that are stages, shape (S,)
    of: Places  # of[n, j] is the stage, among the stages, that stage j of interval n is; shape (N, s)
    target: Places  # target[n, r] is the point that defect r of interval n ends at, the end last; shape (N, R)
    weights: Array  # weights[r, j] of stage j in defect r, shape (R, s)
    quadrature: Array  # weight of every stage in an integral, over T; shape (S,)
    phase: Places  # the phase of every point, shape (P,)
    starts: Places  # points where intervals begin, shape (N,)
    ends: Places  # of the nodes those that end intervals, shape (N,)

    @cached_property
    def joints(self) -> Places:
        """Points where phases behind the first begin, shape (phases - 1,); the point before each ends a phase."""
        return np.flatnonzero(np.diff(self.phase)) + 1

    def behind(self, nodes: Mapping[str, Array]) -> dict[str, Array]:
        """Return what holds at the ends of intervals."""
        return {kind: x if kind == "free" else x[self.ends] for kind, x in nodes.items()}


def grid(method: Method, meshes: Sequence[Array]) -> Grid:
    """Return the grid of a method over phases, one behind the other, each a mesh of rising shares of time, 0 … 1."""
    each = [_phase(method, mesh) for mesh in meshes]

    def before(name: str) -> Places:
        return np.cumsum([0, *(len(getattr(one, name)) for one in each[:-1])])

    def joined(name: str, offsets: Sequence[int] | Places) -> Any:
        return np.concatenate([getattr(one, name) + at for one, at in zip(each, offsets, strict=True)])

    none, points, stages, nodes = [0] * len(each), before("share"), before("stage"), before("node")
    return Grid(
        joined("widths", none), joined("share", none), joined("node", points), joined("stage", points),
        joined("of", stages), joined("target", points), each[0].weights, joined("quadrature", none),
        joined("phase", range(len(each))), joined("starts", points), joined("ends", nodes),
    )  # fmt: skip


def _phase(method: Method, mesh: Array) -> Grid:
    count, inner, s = len(mesh) - 1, list(method.inner), len(method.c)
    step = len(inner) + 1
    widths = np.diff(mesh)
    node = step * np.arange(count + 1)
    between = node[:-1, None] + 1 + np.arange(len(inner))
    places = {i: between[:, k] for k, i in enumerate(inner)}
    places |= {0: node[:-1]} if method.starts else {}
    places |= {s - 1: node[1:]} if method.ends else {}
    at = np.stack([places[j] for j in range(s)], axis=1)
    stage = np.unique(at)
    of = np.searchsorted(stage, at)
    c, b = (np.array([float(x) for x in row]) for row in (method.c, method.b))
    share = np.empty(step * count + 1)
    share[node] = mesh
    share[between] = mesh[:-1, None] + widths[:, None] * c[inner]
    A = np.array([[float(x) for x in row] for row in method.A])
    quadrature = np.zeros(len(stage))
    np.add.at(quadrature, of, widths[:, None] * b)
    target = np.concatenate([between, node[1:, None]], axis=1)
    weights, phase = np.vstack([A[inner], b]), np.zeros(len(share), dtype=np.int64)
    return Grid(widths, share, node, stage, of, target, weights, quadrature, phase, node[:-1], 1 + np.arange(count))


def numbered(shapes: Mapping[str, tuple[int, ...]]) -> tuple[dict[str, Places], int]:
    """Return the places of parts that stand one behind the other, each of its shape, and how many there are."""
    found: dict[str, Places] = {}
    first = 0
    for name, shape in shapes.items():
        size = int(np.prod(shape))
        found[name] = np.arange(first, first + size).reshape(shape)
        first += size
    return found, first


def sliced(places: Places) -> slice | Places:
    """Return places that are equally far apart as a slice, which views and does not copy; others as they are."""
    steps = np.diff(places)
    if len(places) < 2 or np.any(steps != steps[0]):
        return places
    return slice(int(places[0]), int(places[-1]) + 1, int(steps[0]))


MOST = 100_000
"""Intervals that are more than anybody solves."""


def read_mesh(intervals: Any, faults: Faults) -> Array:
    """Return where intervals end, shares of time, shape (N + 1,)."""
    words = "are a number of them, or rising shares of time from 0 to 1, such as [0, 0.25, 1]"
    try:
        count = index(intervals)
    except TypeError:
        count = -1
    if 1 <= count <= MOST:
        return np.linspace(0.0, 1.0, count + 1)
    try:
        mesh = np.asarray(intervals, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        mesh = np.zeros(0)
    if mesh.ndim == 1 and 2 <= len(mesh) <= MOST and mesh[0] == 0 and mesh[-1] == 1 and np.all(np.diff(mesh) > 0):
        return mesh
    faults.add("", f"intervals = {intervals}: they {words}; {MOST} are the most")
    return np.linspace(0.0, 1.0, 2)


def read_span(until: Any, faults: Faults, where: str = "", word: str = "until") -> tuple[float, float]:
    """Return the smallest and the largest time of the end."""
    try:
        pair = (until, until) if np.ndim(until) == 0 else until
        if isinstance(until, str) and not any(map(str.isdigit, until)):
            raise ValueError
        least, most = (read_number(one, {}, word, faults, Parameter(word, unit="s")) or 0.0 for one in pair)
    except (TypeError, ValueError):
        least, most = 0.0, 0.0
    if not 0 < least <= most < np.inf:
        told = "is no time after the start; give a positive one, or a smaller and a larger"
        free = f'; an end that is free is between two, {word}=(3, 20), and cost="1" makes it the soonest'
        faults.add(where, f"{word} = {until!s:.60} {told}{free * isinstance(until, str)}")
        return 1.0, 1.0
    return least, most


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
        return np.asarray(np.bincount(self._entries[2], parts, len(self.rows)).astype(np.float64))

    @cached_property
    def _alone(self) -> bool:
        """Whether every other part is an entry of its own."""
        _, _, steady, others = self._entries
        return len(np.unique(others)) == len(others) and not np.isin(others, steady).any()

    def _places(self, steady: bool) -> list[tuple[Places, Places]]:
        """Return rows and columns of the parts of one kind, in the order of `_parts`."""
        p = self.problem
        grid, defects, place, y = p.grid, p.row["defects"], p.place, p.state
        found: list[tuple[Places, Places]] = []
        if steady:
            found += [(defects, y[grid.target]), (defects, np.broadcast_to(y[grid.starts, None], defects.shape))]
            kept = y[:, : p.row["stays"].shape[1]]
            found += [(p.row["stays"], kept[grid.joints]), (p.row["stays"], kept[grid.joints - 1])]
            found.append((p.row["time"][:, None], np.broadcast_to(place["T"], (len(p.row["time"]), len(place["T"])))))
        for r, j in p.used:
            if steady == self._steady_rates:
                entries = [i for i, _, _ in p.locals["rates"].pattern]
                columns, known, _ = p.wires["rates"]
                at = known[grid.of[:, j]]
                found.append((defects[:, r, entries][at], columns[grid.of[:, j]][at]))
            if steady == self._timed:
                found.append((defects[:, r, -place["a"].shape[1] :], place["a"][grid.of[:, j]]))
        if steady:
            return found
        if not self._timed:
            found.append((defects, place["T"][p.interval_phases][:, None, None]))
        if "pull" in p.locals:
            entries = [i for i, _, _ in p.locals["pull"].pattern]
            found.append((defects[:, -1, entries], p.wires["pull"][0][grid.ends]))
        for name in self._rowwise:
            columns, known, _ = p.wires[name]
            rows = p.row[name][:, [i for i, _, _ in p.locals[name].pattern]]
            found.append((rows[known], columns[known]))
        return found

    def _parts(self, z: Array, steady: bool) -> list[Array]:
        """Return the parts of one kind, each an array."""
        p = self.problem
        grid, shape = p.grid, p.row["defects"].shape
        found: list[Array] = []
        if steady:
            stays = p.row["stays"].shape
            found = [np.ones(shape), np.full(shape, -1.0), np.ones(stays), np.full(stays, -1.0)]
            found.append(np.ones((len(p.row["time"]), len(p.place["T"]))))
        stages = p.at(z, "stage")
        if not (self._timed and self._steady_rates) or steady:
            _, known, chain = p.wires["rates"]
            h, slopes = (
                (p.lasting(z, p.interval_phases) * grid.widths)[:, None],
                p.locals["rates"].slopes(stages) * chain,
            )
            for r, j in p.used:
                scale = -h * grid.weights[r, j]
                if steady == self._steady_rates:
                    found.append((scale * slopes[grid.of[:, j]])[known[grid.of[:, j]]])
                if steady == self._timed:
                    found.append(np.broadcast_to(scale, (len(h), p.place["a"].shape[1])))
        if steady:
            return found
        at = {"stage": stages, **p.elsewhere(z)}
        if not self._timed:
            found.append(-(p.between[1] @ p.rates(stages)))
        if "pull" in p.locals:
            found.append(-p.locals["pull"].slopes(p.grid.behind(at["node"])))
        for name in self._rowwise:
            values = p.locals[name].slopes(at[PLACES[name]])
            _, known, chain = p.wires[name]
            found.append(values if name in self._plain else (values * chain)[known])
        return found

    @cached_property
    def _timed(self) -> bool:
        """Whether the time of the end is given."""
        return not len(self.problem.place["T"])

    @cached_property
    def _steady_rates(self) -> bool:
        """Whether q̇ and ṡ have the same slopes everywhere, and intervals the same length."""
        return self._timed and self.problem.locals["rates"].linear

    @cached_property
    def _plain(self) -> set[str]:
        """Functions whose slopes are entries as they are: by unknowns alone, and none by time."""
        return {name for name, (_, known, chain) in self.problem.wires.items() if known.all() and np.all(chain == 1.0)}

    @cached_property
    def _rowwise(self) -> list[str]:
        """Those that the problem has."""
        return [name for name in ROWWISE if name in self.problem.locals]
