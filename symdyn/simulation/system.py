"""Equations of motion as a first-order system: ẋ = f(t, x), compiled, and what is told about its states.

    x        q (nq), u (nv), and W where anything but gravity, springs and loops does work: Ẇ is its power
    q̇        H(q) u
    u̇        forward dynamics, of the closed mechanism where loops close it

The accelerations of a closed mechanism exist on its manifold only: near a change point, where G_d is nearly singular,
a state that misses it by e is off by e / σ² in u̇. The stages of a Runge-Kutta step miss it by far more than its result
does. So a state is brought back before it is looked at, q_d by Newton steps -G_d⁻¹ r, u_d from u_i, both compiled.

Where G_d is nearly singular and G is not, it is the choice of independent velocities that fails, as the height of a
pendulum does at its lowest point. There the state is brought back by the shortest steps, -G⁺ r, and u̇ is solved for
together with multipliers, see `closed`.

All of it is one program: the formulas of the driving forces and of the events stand on the graph of the equations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.build.load import load_program
from symdyn.dynamics.derive import derive_one
from symdyn.dynamics.equations import Equations, Function
from symdyn.dynamics.loops.linear import followers, forward_dynamics, linear_loops
from symdyn.dynamics.outputs import OUTPUTS
from symdyn.dynamics.state import quaternions
from symdyn.dynamics.workspace import Workspace
from symdyn.errors import SimulateError
from symdyn.graph import substitute
from symdyn.program import Program, cheapest, lower
from symdyn.scene import Quantity, Scene, express
from symdyn.simulation.closed import corrections, reach, row_rates, together
from symdyn.simulation.conserved import conserved
from symdyn.simulation.ends import ends
from symdyn.simulation.forces import Forces
from symdyn.simulation.functions import drive, function_of, points
from symdyn.simulation.limits import limits_of
from symdyn.simulation.reading import TIME, parameter_values

Array = npt.NDArray[np.float64]

CORRECTIONS = 2
"""Newton steps before a closed mechanism's accelerations; they converge quadratically."""

FARTHEST = 0.05
"""Newton steps that are longer, rad or m, are not taken: the state is where G_d has no inverse."""

LARGEST = 30.0
"""Entries of ∂u/∂u_i, those of G_d⁻¹ G_i, beyond which G_d may be nearly singular."""

NEAR = 0.03
"""Smallest singular value of G over the largest, below which a change point is near."""

BETTER = 3.0
"""How many times as far from singular as G_d all of G has to be for the choice to be at fault."""


@dataclass(frozen=True)
class System:
    """A scene under forces, ready to be integrated.

    Attributes:
        scene: the mechanism.
        forces: what drives it.
        events: formulas whose zeros are looked for.
        program: its functions: "rates" and what is told about a state.
        calls: the functions by name, each of (q, qd, tau, t) or fewer, batches too.
        compiled: whether they are C.
        works: whether W is the last entry of x.
        momenta: names of the momenta that are conserved.
        dependent: the velocities that loops leave no choice, in the choice that was made; () if no other one may help.
        linear: whether the loops hold dependent coordinates in proportion, so that nothing is divided by what vanishes.
        rows: number of rows that hold velocities.
        filled: places of the entries of G that are not zero, row by row; where `linear`, G is not asked for.
        ends: what is said where the equations end; such places are entries of "events" behind those asked for.
        limits: what is said of the limits of joints, whose passages are the last entries of "events".
    """

    scene: Scene
    forces: Forces
    events: tuple[Quantity, ...]
    program: Program
    calls: Mapping[str, Callable[..., Any]] = field(repr=False)
    compiled: bool
    works: bool
    momenta: tuple[str, ...]
    linear: bool = False
    dependent: tuple[int, ...] = ()
    rows: int = 0
    filled: tuple[int, ...] = ()
    ends: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    _by_rows: Callable[[], Function | None] = field(default=lambda: None, repr=False)

    @cached_property
    def nq(self) -> int:
        """Number of coordinates."""
        return len(self.scene.coordinates)

    @cached_property
    def nv(self) -> int:
        """Number of velocities."""
        return len(self.scene.velocities)

    @cached_property
    def closed(self) -> bool:
        """Whether there are rows to hold; loops whose rows are all redundant have none."""
        return self.rows > 0

    @cached_property
    def quaternions(self) -> tuple[slice, ...]:
        """Where the quaternions stand in q."""
        names = list(self.scene.coordinates)
        firsts = [names.index(group[0]) for group in quaternions(self.scene)]
        return tuple(slice(first, first + 4) for first in firsts)

    @cached_property
    def _nothing(self) -> Array:
        return np.zeros(self.nv)

    @cached_property
    def _takes(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the arguments of every function."""
        return {r.function.name: tuple(a.name for a in r.function.arguments) for r in self.program.routines}

    def rates(self, t: float, x: Array) -> Array:
        """Return ẋ of one state, shape (nx,)."""
        q, u = x[: self.nq], x[self.nq : self.nq + self.nv]
        if self.closed and not self.linear:
            if self.ill_chosen(q):
                return self._at_once(q, u, t)
            q, u = self.on_manifold(q, u)
        found: Array = self._rates(q, u, self.tables(t), t)
        return found

    def on_manifold(self, q: Array, u: Array) -> tuple[Array, Array]:
        """Return a state of a closed mechanism with its loops closed, the independent coordinates as they are."""
        for _ in range(CORRECTIONS):
            step = self.calls["correction"](q, u)
            size = np.abs(step).max(initial=0.0)
            if not size <= FARTHEST:
                break
            q = q + self.calls["movement"](q, step)
        fitted = self.calls["fitted"](q, u)
        off = np.abs(fitted - u).max(initial=0.0)
        return q, fitted if off <= FARTHEST * max(1.0, np.abs(u).max(initial=0.0)) else u

    def ill_chosen(self, q: Array) -> bool:
        """Tell whether G_d is nearly singular at a position of a closed mechanism, and G is not."""
        if not self.dependent or not np.abs(self.calls["reach"](q)).max(initial=0.0) > LARGEST:
            return False
        G = self.jacobian(0.0, q)
        chosen, all_rows = (np.linalg.svd(part, compute_uv=False)[-1] for part in (G[:, list(self.dependent)], G))
        return bool(all_rows > BETTER * chosen)

    def changes(self, q: Array) -> bool:
        """Tell whether a position of a closed mechanism is near a change point, where G loses rank."""
        if not self.dependent:
            return False
        values = np.linalg.svd(self.jacobian(0.0, q), compute_uv=False)
        return bool(values[-1] < NEAR * values[0])

    def _at_once(self, q: Array, u: Array, t: float) -> Array:
        """Return ẋ of one state by all rows of G at once."""
        for _ in range(CORRECTIONS):
            step = np.linalg.lstsq(self.jacobian(0.0, q), self.calls["constraint_residual"](q))[0]
            q = q - self.calls["movement"](q, step)
        G = self.jacobian(0.0, q)
        u = u - np.linalg.lstsq(G, G @ u)[0]
        found: Array = self._together(q, u, self.tables(t), t)
        return found

    @cached_property
    def together(self) -> Program | None:
        """The rates of a closed mechanism by all rows at once; None where they do not exist."""
        function = self._by_rows()
        return None if function is None else lower(Equations(self.scene, function.entries[0].graph, (function,)))

    @cached_property
    def _together(self) -> Callable[..., Array]:
        return self._rates if self.together is None else load_program(self.together, lean=True)[0]["together"]

    @cached_property
    def slope(self) -> Callable[[float, Array], Array]:
        """∂f/∂x of one state as a function of t and x, shape (nx, nx); compiled when it is first asked for."""
        from symdyn.simulation.slopes import slopes

        return slopes(self)

    @cached_property
    def _rates(self) -> Callable[..., Array]:
        return self.calls["rates"]

    def tables(self, t: npt.ArrayLike) -> Array:
        """Return what tables say about driving forces at times (...), shape (..., nv); zeros without tables."""
        return self.forces.tabulated(np.asarray(t, dtype=np.float64), self.nv) if self.forces.tables else self._nothing

    def tell(self, name: str, t: npt.ArrayLike, x: Array) -> Array:
        """Return a function of the program at states x, shape (..., nx), and times (...)."""
        times = np.asarray(t, dtype=np.float64)
        known = {"q": x[..., : self.nq], "qd": x[..., self.nq : self.nq + self.nv], TIME: times}
        known["tau"] = self.tables(times)
        found = np.asarray(self.calls[name](*(known[argument] for argument in self._takes[name])), dtype=np.float64)
        if name == "rates" and self.dependent and x.ndim == 2:
            reach = np.abs(self.calls["reach"](known["q"])).reshape(len(x), -1).max(axis=1, initial=0.0)
            for k in np.flatnonzero(~(reach <= LARGEST)):
                found[k] = self.rates(float(times[k]), x[k])
        return found

    def jacobian(self, t: npt.ArrayLike, x: Array) -> Array:
        """Return G at states x, shape (..., rows, nv)."""
        G = np.zeros((*x.shape[:-1], self.rows * self.nv))
        G[..., self.filled] = self.tell("slopes", t, x)
        return G.reshape(*x.shape[:-1], self.rows, self.nv)


def build_system(scene: Scene, forces: Forces = Forces(), events: Sequence[Quantity] = ()) -> System:  # noqa: B008
    """Return the system of a scene under forces.

    Args:
        scene: the mechanism, its parameters bound.
        forces: driving forces.
        events: formulas in t, coordinates, velocities and parameters.

    Raises:
        SimulateError: a parameter has no value, or nothing moves.
        DerivationError: there is no forward dynamics, or the loops cannot be closed.
    """
    parameter_values(scene)
    if not scene.velocities:
        raise SimulateError(f"{scene.name}: nothing moves: no joint has a coordinate")
    w = Workspace(scene)
    tau = [drive(w, forces, k) for k in range(w.state.n)]
    place = dict(zip(w.state.tau, tau, strict=True))
    linear = linear_loops(w) if scene.loops else None
    solved = forward_dynamics(w, linear) if linear else cheapest(w, "forward_dynamics").entries
    accelerations = substitute(solved, place)
    drives = list(substitute(derive_one(w, "drive_forces").entries, place)) if _moved(scene) else tau
    powers = [w.graph.total(f * u for f, u in zip(some, w.state.qd, strict=True)) for some in (drives, w.Q)]
    power = powers[0] + powers[1]
    momenta = conserved(w, accelerations, bool(forces.tables))
    rates = substitute(w.state.rates, followers(w, linear)) if linear else w.state.rates
    functions = [
        function_of(w, "rates", [*rates, *accelerations, *([] if power.is_zero else [power])]),
        function_of(w, "drives", drives),
        function_of(w, "power", powers),
        function_of(w, "kinetic", cheapest(w, "kinetic_energy").entries),
        function_of(w, "potential", cheapest(w, "potential_energy").entries),
        points(w),
    ]
    last, limits = ends(scene, w.graph), limits_of(scene, w.graph, drives)
    if events or last or limits:
        looked_for = [express(event, w.graph) for event in events]
        looked_for += [*(formula for formula, _ in last), *(limit.beyond for limit in limits)]
        functions.append(function_of(w, "events", looked_for))
    if momenta:
        functions.append(function_of(w, "momenta", [p for _, p in momenta]))
    rows, filled, dependent = 0, (), ()  # type: int, tuple[int, ...], tuple[int, ...]
    if scene.is_closed:
        G = cheapest(w, "constraint_jacobian")
        rows = G.shape[0]
        filled = tuple(k for k, entry in enumerate(G.entries) if not entry.is_zero)
        functions += [cheapest(w, "constraint_residual"), row_rates(w, G), *corrections(w, linear)]
        if not linear:
            functions.append(function_of(w, "slopes", [G.entries[k] for k in filled], ("q",)))
            functions.append(function_of(w, "reach", reach(w), ("q",)))
            dependent = tuple(w.closed.closure.partition.dependent) if functions[-1].entries else ()
    program = lower(Equations(scene, w.graph, tuple(f for f in functions if f.entries)))
    calls, compiled = load_program(program, lean=True)
    return System(
        scene, forces, tuple(events), program, calls, compiled, not power.is_zero, tuple(name for name, _ in momenta),
        linear is not None, dependent, rows, filled, tuple(words for _, words in last),
        tuple(limit.words for limit in limits), lambda: together(w, tau, power),
    )  # fmt: skip


def _moved(scene: Scene) -> bool:
    return OUTPUTS["drive_forces"].exists(scene)
