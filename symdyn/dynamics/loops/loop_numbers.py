"""A scene's loops as numbers, for what is decided numerically: assembly, rank, conditioning, the choice of pivots.

    r(q), R      residuals of all loops and their rates R u
    G(q)         constraint rows of loops and contacts, and those that the scene declares
    H(q)         q̇ = H u
    h, w         of contacts: how high the lowest point is, and the sine of the angle between axis and normal

A step δ along the velocities moves q by H δ, quaternions stay of unit length. What must not depend on how orientations
are described (ranks, and what bodies can do) is asked of the mechanism in quaternions. In words a
constraint row is "force along x of loop cut", "moment about (0.6, 0, 0.8)".
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, Union

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array, Floats
from symdyn.dynamics.loops.assembly import EFFORT, Levels, closed_position, doubts, witness
from symdyn.dynamics.loops.constraint_rows import FLAT, ContactGap, contact_gaps, recursive
from symdyn.dynamics.loops.newton import NEGLIGIBLE, missed, newton, open_loop, reversed_loop
from symdyn.dynamics.loops.sparse_rows import Indices
from symdyn.dynamics.mechanism.angles import Angles, angles_of, with_angles, with_quaternions, without_angles
from symdyn.dynamics.mechanism.kinematics import directions
from symdyn.dynamics.mechanism.state import State, quaternions
from symdyn.dynamics.mechanism.tree import build_tree
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, evaluate, operands, reachable, repeated
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.joints import start_of
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.dynamics.loops.assembly import Assembly
    from symdyn.dynamics.loops.loop_decisions import LoopDecisions
    from symdyn.dynamics.loops.partition import LoopChoices

SINGULAR = 1e-6
"""Sine of the angle between axes that are parallel as far as digits go: so many are lost in accelerations, twice."""

AT_LEAST = 100
"""Nodes that could be evaluated while values are handed to and fro."""


LARGE, TIMES = 5000, 20
"""Nodes from which on they are evaluated level by level, and how many times faster that is."""


ValuesAt = Callable[[Mapping[Expr, float]], Union[Array, list[float]]]


def _prepared(entries: Sequence[Expr]) -> tuple[int, ValuesAt]:
    """Return what evaluates entries, and what that takes, in nodes."""
    size = len(reachable(entries))
    if size < LARGE:
        return size, repeated(entries, Floats())
    levels = Levels(entries)
    return levels.size // TIMES, levels.at


@dataclass(frozen=True, eq=False)
class Pattern:
    """A matrix by its entries that are not zero."""

    height: int
    rows: Indices
    columns: Indices
    entries: tuple[Expr, ...]


def jacobian(outputs: Sequence[Expr], directions: Sequence[Mapping[Expr, Expr]]) -> list[dict[int, Expr]]:
    """Return what is not zero of ẏ of every output, by direction: `tangents` along many, of which few move a node.

    Directions are those of symbols.

    >>> graph = Graph()
    >>> x, y = graph.symbol("x"), graph.symbol("y")
    >>> jacobian([x * y, x], [{x: graph.one}, {y: graph.one}])
    [{0: y, 1: x}, {0: 1}]
    """
    moving: dict[Expr, dict[int, Expr]] = {}
    for k, seeds in enumerate(directions):
        for node, rate in seeds.items():
            moving.setdefault(node, {})[k] = rate
    inputs = set(moving)
    for node in reachable(outputs):
        if node in inputs or not any(arg in moving for arg in node.args):
            continue
        rates: dict[int, Expr] = {}
        for arg, partial in operands(node):
            for k, rate in moving.get(arg, {}).items():
                rates[k] = rates[k] + partial * rate if k in rates else partial * rate
        rates = {k: rate for k, rate in rates.items() if not rate.is_zero}
        if rates:
            moving[node] = rates
    return [moving.get(node, {}) for node in outputs]


def pattern(rows: Sequence[Mapping[int, Expr]]) -> Pattern:
    """Return a matrix of rows by column."""
    entries = [(i, k, x) for i, row in enumerate(rows) for k, x in row.items()]
    i, k = (np.array([one[side] for one in entries], dtype=np.intp) for side in (0, 1))
    return Pattern(len(rows), i, k, tuple(x for _, _, x in entries))


class Numbers:
    """Functions of q as numbers, at values of the parameters."""

    def __init__(self, scene: Scene) -> None:
        """Write a scene on a graph of its own, without values of its free parameters."""
        self.scene, self.graph = scene, Graph()
        self.state, self.tree = State.of(scene, self.graph), build_tree(scene, self.graph)
        self.directions = directions(scene, self.graph)
        self.constraints = recursive(scene, self.tree, self.state)
        self.free: dict[str, float] = {}
        # Newton's method asks for the same entries many times
        self._known: dict[tuple[Expr, ...], tuple[int, ValuesAt]] = {}
        self._spent = [0]

    def bound_to(self, free: Mapping[str, float]) -> Numbers:
        """Return the mechanism with values of its free parameters; what was derived and spent is shared."""
        found = copy(self)
        found.free = dict(free)
        for name in ("parameters", "in_quaternions"):
            found.__dict__.pop(name, None)
        if self.in_quaternions is not self:
            found.in_quaternions = self.in_quaternions.bound_to(free)
        return found

    def afresh(self, free: Mapping[str, float]) -> Numbers:
        """Return the same, nothing spent yet."""
        found = self.bound_to(free)
        found._spent = [0]
        if found.in_quaternions is not found:
            found.in_quaternions._spent = found._spent
        return found

    def derive(self) -> None:
        """Derive at once what is derived when it is first asked for, so that those bound to values share it."""
        _ = self._rates, self._kinematic_map, self.angles, self.contact_gaps

    @property
    def effort(self) -> int:
        """What has been spent on values, in nodes of the graph: a measure of time that every machine agrees on."""
        return self._spent[0]

    @cached_property
    def parameters(self) -> dict[Expr, float]:
        values = {self.graph.symbol(name): value for name, value in self.free.items()}
        for parameter in self.scene.parameters:
            if parameter.value is not None:
                (value,) = evaluate([parameter.value.express(self.graph)], Floats(), {})
                values[self.graph.symbol(parameter.name)] = value
        return values

    def value(self, quantity: Quantity) -> float:
        """Return the value of a quantity in parameters; DerivationError where it has none."""
        try:
            return float(evaluate([quantity.express(self.graph)], Floats(), self.parameters)[0])
        except (ArithmeticError, ValueError) as fault:
            raise DerivationError(f"{self.scene.name}: {quantity} has no real value with these parameters") from fault

    def at(self, entries: Sequence[Expr], q: Array, others: Mapping[Expr, float] | None = None) -> Array:
        """Return the values of entries at q, and at values of other symbols; DerivationError where one has none."""
        values = self.parameters | dict(zip(self.state.q, q.tolist(), strict=True)) | dict(others or {})
        wanted = tuple(entries)
        try:
            if wanted not in self._known:
                self._known[wanted] = _prepared(wanted)
            size, values_at = self._known[wanted]
            self._spent[0] += AT_LEAST + size
            return np.array(values_at(values), dtype=np.float64)
        except (ArithmeticError, ValueError) as fault:
            raise DerivationError(f"{self.scene.name}: {self._valueless(wanted, values, q)}") from fault

    def _valueless(self, entries: Sequence[Expr], values: Mapping[Expr, float], q: Array) -> str:
        """Return whose formula has no real value, and where."""
        rows = zip(self.constraints.labels, self.constraints.residual, self.constraints.G, strict=True)
        inside = " (two of its places meet, or one is inside of a wheel)"
        owners = {
            entry: f"{label.words}{inside * label.is_rope}"
            for label, residual, row in rows
            for entry in (residual, *row)
        }
        place = ", ".join(f"{name} = {x:.6g}" for name, x in zip(self.scene.coordinates, q.tolist(), strict=True))

        def without(entry: Expr) -> bool:
            try:
                evaluate([entry], Floats(), values)
            except (ArithmeticError, ValueError):
                return True
            return False

        if entry := next(filter(without, entries), None):
            whose = owners.get(entry) or next((owners[one] for one in owners if without(one)), "a row, or its rate,")
            return f"{whose} has no real value at {place}; give the scene a start where it has one"
        return f"a formula has no real value at {place}; give the scene another start"

    def residual(self, q: Array) -> Array:
        """Return r(q), every loop's, m or 1."""
        return self.at(self.constraints.residual, q)

    @cached_property
    def _rates(self) -> Pattern:
        return pattern(jacobian(self.constraints.residual, self.directions.along))

    @cached_property
    def _rows(self) -> Pattern:
        return pattern([{k: x for k, x in enumerate(row) if not x.is_zero} for row in self.constraints.G])

    @cached_property
    def _kinematic_map(self) -> Pattern:
        rows: dict[Expr, dict[int, Expr]] = {q: {} for q in self.state.q}
        for k, along in enumerate(self.directions.along):
            for q, h in along.items():
                rows[q][k] = h
        return pattern(list(rows.values()))

    def _filled(self, some: Pattern, q: Array, factors: Array | float | None = None) -> Array:
        """Return a matrix of nv columns at q, its entries multiplied by factors."""
        found = np.zeros((some.height, self.state.n))
        entries = self.at(some.entries, q)
        found[some.rows, some.columns] = entries if factors is None else entries * factors
        return found

    def residual_rates(self, q: Array) -> Array:
        """Return R, shape (m, nv)."""
        return self._filled(self._rates, q)

    def jacobian(self, q: Array, length: float | None = None) -> Array:
        """Return G, shape (m, nv); with a length, rows that forbid velocities over it, columns of slides times it."""
        scaled = None if length is None else length**self._lengths
        return self._filled(self._rows, q, scaled)

    def dimensionless(self, q: Array, length: float) -> Array:
        """Return G with rows that forbid velocities divided by a length, and columns of slides multiplied by it."""
        G = self.jacobian(q, length)
        if not np.isfinite(G).all():
            raise DerivationError(
                f"{self.scene.name}: the lengths of its loops and rows are beyond what doubles hold; choose units that "
                "keep them smaller"
            )
        return G

    @cached_property
    def angular_velocities(self) -> list[int]:
        return [k for k, unit in enumerate(SceneUnits(self.scene).velocities) if unit == "rad"]

    @cached_property
    def _forbids_velocity(self) -> npt.NDArray[np.bool_]:
        wrenches = (one.wrench for one in self.constraints.labels)
        return np.array([one is None or not all(x.is_zero for x in one[0]) for one in wrenches], dtype=bool)

    @cached_property
    def _turning(self) -> npt.NDArray[np.bool_]:
        return np.isin(self._rows.columns, self.angular_velocities)

    @cached_property
    def _lengths(self) -> Array:
        """Powers of the length that make the entries of G dimensionless: a row's, and a column's."""
        return np.where(self._turning, 0.0, 1.0) - np.where(self._forbids_velocity[self._rows.rows], 1.0, 0.0)

    @cached_property
    def _offsets(self) -> list[Expr]:
        loops = [pose.transform(self.graph) for loop in self.scene.loops for pose in (loop.origin, loop.tip)]
        return [x for T in (*self.tree.T, *loops) for x in T.p]

    def levers(self, q: Array) -> tuple[Array, Array]:
        """Return the sizes of the levers in G, and of all ways from frame to frame, at q; m."""
        levers = self.at(self._rows.entries, q)[self._turning & self._forbids_velocity[self._rows.rows]]
        return np.abs(levers), np.abs(self.at(self._offsets, q))

    def retract(self, q: Array, step: Array) -> Array:
        """Return q after a step along the velocities, shape (nv,)."""
        H = self._kinematic_map
        moves = np.bincount(H.rows, weights=self.at(H.entries, q) * step[H.columns], minlength=H.height)
        return self.normalised(q + moves)

    @cached_property
    def in_quaternions(self) -> Numbers:
        """The mechanism in quaternions, velocities in their places; itself where it has no angles."""
        scene = without_angles(self.scene)
        if scene is self.scene:
            return self
        found = Numbers(scene)
        found.free, found._spent = self.free, self._spent
        return found

    def to_quaternions(self, q: Array) -> Array:
        """Return q as a position of the mechanism in quaternions."""
        return q if self.in_quaternions is self else with_quaternions(self.scene, self.in_quaternions.scene, q)

    def from_quaternions(self, q: Array, near: Array) -> Array:
        """Return a position of the mechanism in quaternions as one of this, with angles near those of another."""
        return q if self.in_quaternions is self else with_angles(self.scene, self.in_quaternions.scene, q, near)

    @cached_property
    def angles(self) -> tuple[Angles, ...]:
        """The angles that are singular somewhere."""
        return tuple(angles_of(self.scene))

    def clearances(self, q: Array) -> Array:
        """Return how far the angles are from singular: 0 where they are, 1 at most, shape (angles,)."""
        return np.abs(self.at([one.clearance(self.graph) for one in self.angles], q))

    def singular_angles(self, q: Array, everywhere: bool = False) -> str:
        """Return which angles are singular at q and what helps, "" if none are; `everywhere`: wherever loops close."""
        found = zip(self.angles, self.clearances(q).tolist(), strict=True)
        return next((one.singular(float(q[one.middle]), everywhere) for one, clear in found if clear < SINGULAR), "")

    @cached_property
    def contact_gaps(self) -> tuple[ContactGap, ...]:
        return contact_gaps(self.scene, self.graph)

    def lying_flat(self, q: Array) -> str:
        """Return which wheel lies flat at q, so that it has no lowest point, "" if none does."""
        sines = self.at([one.sine for one in self.contact_gaps], q).tolist()
        found = zip(self.contact_gaps, sines, strict=True)
        return next((one.flat for one, sine in found if sine < FLAT), "")

    def start(self) -> Array:
        """Return where the scene says that it starts; zeros, and unit quaternions, where it says nothing."""
        return self.normalised(np.array([self.value(one) for one in start_of(self.scene).position]))

    def normalised(self, q: Array) -> Array:
        """Return q with quaternions of unit length; (1, 0, 0, 0) for one that is zero."""
        q, names = q.astype(np.float64), list(self.scene.coordinates)
        for group in quaternions(self.scene):
            first = names.index(group[0])
            length = np.linalg.norm(q[first : first + 4])
            q[first : first + 4] = q[first : first + 4] / length if length else (1.0, 0.0, 0.0, 0.0)
        return q

    def drawn(self, seed: int) -> Array:
        """Return random coordinates, about one turn or one metre wide; the same seed, the same ones."""
        rng = random.Random(f"{self.scene.name}:{seed}")
        return self.normalised(np.array([rng.uniform(-2.0, 2.0) for _ in self.state.q]))

    def declared_rates(self) -> dict[int, float]:
        """Return the velocities that joints give as `start_rates`, by index; rad/s or m/s."""
        scene = self.scene
        given = {name for joint in scene.joints if joint.start_rates for name in joint.rates}
        values = zip(scene.velocities, start_of(scene).velocity, strict=True)
        return {k: self.value(x) for k, (name, x) in enumerate(values) if name in given}

    def fitting_rates(self, q: Array, rates: Mapping[int, float]) -> Array:
        """Return velocities that constraint rows allow at q, given some by index, rad/s or m/s; see `consistent`."""
        scene, given = self.scene, list(rates)
        u = np.zeros(self.state.n)
        u[given] = list(rates.values())
        free = [k for k in range(self.state.n) if k not in rates]
        G = self.dimensionless(q, 1.0)
        if free and len(G):
            u[free] = np.linalg.lstsq(G[:, free], -G[:, given] @ u[given], rcond=NEGLIGIBLE)[0]
        off = np.abs(G @ u)
        if len(off) and off.max() > 1e-9 * max(1.0, float(np.abs(u).max())):
            owner = self.constraints.labels[int(off.argmax())].owner
            names = ", ".join(f"{scene.velocities[k]} = {value:.6g}" for k, value in rates.items())
            raise DerivationError(
                f"{scene.name}: the initial velocities {names} contradict each other: {owner} is violated by "
                f"{off.max():.3g}; give as many as it has degrees of freedom, and let the others follow"
            )
        return u

    # Closed positions

    def newton(self, q: Array, locked: Sequence[int]) -> Array:
        """Return where Newton's method with line search ends, closed or not; `locked` velocities do not move."""
        return newton(self, q, locked)

    def is_closed(self, q: Array) -> bool:
        """Whether every loop is closed, and the right way round."""
        return open_loop(self, q) is None and reversed_loop(self, q) is None

    def closed_position(self, guess: Array | None = None, locked: Sequence[int] | None = None) -> Assembly:
        """Return a closed position from a guess; errors and what is `locked` as of `assembly.closed_position`."""
        return closed_position(self, guess, locked)

    def witness(self, make: Mapping[str, float]) -> tuple[Numbers, Assembly]:
        """Return the mechanism with values of its free parameters, drawn where none are given, and a closed position.

        Raises:
            DerivationError: the loops never close.
        """
        return witness(make, self)

    def decided(self, closing: LoopChoices) -> tuple[LoopDecisions, Numbers]:
        """Return the decisions about the loops, and the mechanism with values of all parameters.

        Raises:
            DerivationError: the loops cannot be assembled, or what was chosen does not fit.
        """
        from symdyn.dynamics.loops.loop_decisions import loop_decisions_at

        numbers, assembly = self.witness(dict(closing.parameters))
        return loop_decisions_at(numbers, assembly, closing), numbers

    def closed_elsewhere(self, q: Array, given: Sequence[int], locked: Sequence[int], draws: int) -> Array | None:
        """Return the closed position next to q to which random guesses lead, given coordinates as at q; or None."""
        found = list[Array]()
        for seed in range(draws if self.effort < EFFORT else 0):
            drawn = self.drawn(seed)
            drawn[given] = q[given]
            at = self.newton(self.normalised(drawn), locked)
            found += [at] if self.is_closed(at) and not (self.singular_angles(at) or self.lying_flat(at)) else []
        return min(found, key=lambda one: float(np.abs(one - q).max()), default=None)

    def left_open(self, q: Array) -> str:
        """Return which loop a start leaves open most, and by how much."""
        r = np.abs(self.residual(q))
        label = self.constraints.labels[int(r.argmax())]
        return f"the start leaves {label.words} open: {missed(label, self, q, r.max())}"

    def doubts(self, q: Array) -> list[str]:
        """Return which contacts are off their plane at q, and which loops may be mirrored."""
        return doubts(self, q)
