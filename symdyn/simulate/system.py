"""Equations of motion as a first-order system: ẋ = f(t, x), compiled, and what is told about its states.

    x        q (nq), u (nv), and W where anything but gravity, springs and loops does work: Ẇ is its power
    q̇        H(q) u
    u̇        forward dynamics, of the closed mechanism where loops close it

The accelerations of a closed mechanism exist on its manifold only: near a change point, where G_d is nearly singular,
a state that misses it by e is off by e / σ² in u̇. The stages of a Runge-Kutta step miss it by far more than its result
does. So a state is brought back before it is looked at, q_d by Newton steps -G_d⁻¹ r, u_d from u_i, both compiled.

Where G_d is nearly singular and G is not, it is the choice of independent velocities that fails, as the height of a
pendulum does at its lowest point. There the state is brought back by the shortest steps, -G⁺ r, and u̇ is solved for
together with λ:

    M u̇ - Gᵀ λ = τ - h
    G u̇        = -γ

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
from symdyn.dynamics.derive import arguments, derive_one
from symdyn.dynamics.equations import Equations, Function
from symdyn.dynamics.loops.closed import solve_dependent
from symdyn.dynamics.loops.linear import LinearLoops, followers, forward_dynamics, linear_loops
from symdyn.dynamics.outputs import OUTPUTS
from symdyn.dynamics.state import quaternions
from symdyn.dynamics.workspace import Workspace
from symdyn.errors import SimulateError
from symdyn.graph import Expr, substitute
from symdyn.program import Program, cheapest, lower
from symdyn.scene import Quantity, Scene, express
from symdyn.simulate.conserved import conserved
from symdyn.simulate.ends import ends
from symdyn.simulate.forces import Forces
from symdyn.simulate.reading import TIME, parameter_values

Array = npt.NDArray[np.float64]

EVERYTHING = ("q", "qd", "tau", TIME)

CORRECTIONS = 2
"""Newton steps before a closed mechanism's accelerations; they converge quadratically."""

FARTHEST = 0.05
"""Newton steps that are longer, rad or m, are not taken: the state is where G_d has no inverse."""

LARGEST = 30.0
"""Entries of ∂u/∂u_i, those of G_d⁻¹ G_i, beyond which G_d may be nearly singular."""

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
        ends: what is said where the equations end; such places are the last entries of "events".
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
            if self._ill_chosen(q):
                return self._together(q, u, t)
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

    def _ill_chosen(self, q: Array) -> bool:
        """Tell whether G_d is nearly singular at q, and G is not."""
        if not self.dependent or not np.abs(self.calls["reach"](q)).max(initial=0.0) > LARGEST:
            return False
        G = self.jacobian(0.0, q)
        chosen, all_rows = (np.linalg.svd(part, compute_uv=False)[-1] for part in (G[:, list(self.dependent)], G))
        return bool(all_rows > BETTER * chosen)

    def _together(self, q: Array, u: Array, t: float) -> Array:
        """Return ẋ of one state by all rows of G at once."""
        n, tau = self.nv, self.tables(t)
        for _ in range(CORRECTIONS):
            step = np.linalg.lstsq(self.jacobian(0.0, q), self.calls["constraint_residual"](q))[0]
            q = q - self.calls["movement"](q, step)
        G = self.jacobian(0.0, q)
        u = u - np.linalg.lstsq(G, G @ u)[0]
        saddle = np.zeros((n + len(G), n + len(G)))
        saddle[:n, :n] = self.calls["mass"](q, u, tau, t).reshape(n, n)
        saddle[:n, n:], saddle[n:, :n] = -G.T, G
        solved = np.linalg.solve(saddle, self.calls["rest"](q, u, tau, t))[:n]
        power = [self.calls["power"](q, u, tau, t).sum()] if self.works else []
        return np.concatenate([self.calls["movement"](q, u), solved, power])

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
    ]
    last = ends(scene, w.graph)
    if events or last:
        looked_for = [*(express(event, w.graph) for event in events), *(formula for formula, _ in last)]
        functions.append(function_of(w, "events", looked_for))
    if momenta:
        functions.append(function_of(w, "momenta", [p for _, p in momenta]))
    rows, filled = 0, ()  # type: int, tuple[int, ...]
    if scene.loops or scene.rows:
        G = cheapest(w, "constraint_jacobian")
        rows = G.shape[0]
        filled = tuple(k for k, entry in enumerate(G.entries) if not entry.is_zero)
        functions += [cheapest(w, "constraint_residual"), _row_rates(w, G), *_corrections(w, linear)]
        if not linear:
            functions.append(function_of(w, "slopes", [G.entries[k] for k in filled], ("q",)))
    apart = _apart(w, tau) if (scene.loops or scene.rows) and not linear else []
    program = lower(Equations(scene, w.graph, tuple(f for f in (*functions, *apart) if f.entries)))
    calls, compiled = load_program(program, lean=True)
    dependent = tuple(w.closed.closure.partition.dependent) if apart else ()
    return System(
        scene, forces, tuple(events), program, calls, compiled, not power.is_zero, tuple(name for name, _ in momenta),
        linear is not None, dependent, rows, filled, tuple(words for _, words in last),
    )  # fmt: skip


def drive(w: Workspace, forces: Forces, k: int) -> Expr:
    """Return the driving force of a velocity: its formula, or the argument that a table fills."""
    return w.state.tau[k] if k in forces.tables else express(forces.formula(k), w.graph)


def _row_rates(w: Workspace, G: Function) -> Function:
    """Return G u, what the rows make of the velocities."""
    rows, n = G.shape
    terms = [[G.entries[r * n + k] * w.state.qd[k] for k in range(n)] for r in range(rows)]
    return function_of(w, "row_rates", [w.graph.total(row) for row in terms], ("q", "qd"))


def _corrections(w: Workspace, linear: LinearLoops | None) -> list[Function]:
    """Return what brings a state of a closed mechanism back: Newton's step, its way in q, and fitting velocities."""
    zero, u = w.graph.zero, w.state.qd
    if linear:
        values = followers(w, linear)
        step = {k: values[w.state.q[k]] - w.state.q[k] for k in linear.dependent}
        fitted = {k: values[u[k]] for k in linear.dependent}
    else:
        rows, partition = w.closed.recursive, w.closed.closure.partition
        G = w.closed.G(rows)
        step = solve_dependent(G, partition, [-r for r in w.closed.residual(rows)]) if G else {}
        moved = [-w.graph.total(row[k] * u[k] for k in partition.independent) for row in G]
        fitted = solve_dependent(G, partition, moved) if G else {}
    return [
        function_of(w, "correction", [step.get(k, zero) for k in range(w.state.n)], ("q", "qd")),
        function_of(w, "movement", w.state.rates, ("q", "qd")),
        function_of(w, "fitted", [fitted.get(k, x) for k, x in enumerate(u)], ("q", "qd")),
    ]


def _apart(w: Workspace, tau: Sequence[Expr]) -> list[Function]:
    """Return ∂u/∂u_i, M, and [τ - h; -γ]; nothing where forces are no matter, or a motion is prescribed."""
    reach = [x for row in w.closed.reduction.T for x in row.values() if x is not w.graph.one]
    if not reach or not w.closed.reduction.independent or _moved(w.scene):
        return []
    rows, still = w.closed.recursive, [w.graph.zero] * w.state.n
    place = dict(zip(w.state.tau, tau, strict=True))
    rest = [drive - force for drive, force in zip(w.state.tau, w.forces(still), strict=True)]
    return [
        function_of(w, "reach", reach, ("q",)),
        function_of(w, "mass", [entry for row in w.composite_mass for entry in row]),
        function_of(w, "rest", [*substitute(rest, place), *(-x for x in w.closed.gamma(rows))]),
    ]


def _moved(scene: Scene) -> bool:
    return OUTPUTS["drive_forces"].exists(scene)


def function_of(w: Workspace, name: str, entries: Sequence[Expr], takes: Sequence[str] = EVERYTHING) -> Function:
    """Return entries as a function of everything, or of what it takes."""
    return Function(
        name=name,
        text=name,
        arguments=arguments(w, takes),
        result="out",
        shape=(len(entries),),
        entries=tuple(entries),
        units="",
        formulation="",
    )
