"""Equations of motion as a first-order system, ẋ = f(t, x), compiled, and the return of a state to its constraints.

    x        q (nq), u (nv), s (ns), and W where anything but gravity, springs and loops does work: Ẇ is its power
    q̇        H(q) u
    s        states of one's own; functions take them behind the velocities, of which they are told together as (u, s)
    u̇        forward dynamics, of the closed mechanism where loops close it
    r, G     residuals and kept constraint equations of the loops and of the scene, compiled

The accelerations of a closed mechanism exist on its manifold only. Near a change point, where G_d is nearly singular, a
state that misses the manifold by e is off by e / σ² in u̇, and the stages of a Runge-Kutta step miss it by far more
than its result does. So a state is brought back before it is evaluated, q_d by Newton steps -G_d⁻¹ r, u_d from u_i,
both compiled.

Where G_d is nearly singular and G is not, only the choice of independent velocities fails, as the height of a pendulum
does at its lowest point. There the state is brought back by the shortest steps, and u̇ is solved for together with
multipliers (`together` of `written.py`).

The shortest steps (`Projection`) give quaternions of unit length, closed loops, and velocities that the constraints
allow; a step δ along the velocities moves q by H δ. Positions come first, by Newton's method, δ = -G⁺ r; then
velocities, u - G⁺ G u. Both converge quadratically, so that a step whose correction is `SMALL` is the last. What has a
prescribed motion is not moved. Where loops hold dependent coordinates in proportion, these follow the independent ones.

Reference: Eich, Convergence results for a coordinate projection method applied to mechanical systems (1993).
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.dynamics import Function
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.dynamics.outputs import WrittenDecisions
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Expr
from symdyn.program import Program
from symdyn.scene import Quantity, Scene
from symdyn.simulation.equations.compiled_routines import Calls, Compiled, Opened, compiled, opened
from symdyn.simulation.equations.contact_modes import Contacts
from symdyn.simulation.equations.control_loop import NOTHING, Loop
from symdyn.simulation.equations.events import EventKind
from symdyn.simulation.equations.monitors import Candidates, Limit
from symdyn.simulation.equations.settling import settled
from symdyn.simulation.prescribed.forces import Forces
from symdyn.unlocked import cached_property

CORRECTIONS = 2
"""Newton steps before a closed mechanism's accelerations; they converge quadratically."""

FARTHEST = 0.05
"""Newton steps that are longer, rad or m, are not taken: the state is where G_d has no inverse."""

LARGEST = 30.0
"""Entries of ∂u/∂u_i, those of G_d⁻¹ G_i, beyond which G_d may be nearly singular."""

NEAR = 0.03
"""Smallest singular value of G over the largest, below which a change point is near."""

RESIDUE = 1e3
"""How many times as large as at its zero a guard may be and still be zero."""

BETTER = 3.0
"""How many times as far from singular as G_d all of G has to be for the choice to be at fault."""


T = TypeVar("T")


@dataclass(frozen=True)
class StateEquations:
    """Equations of a scene under forces at values of its parameters, ready to be integrated.

    Below u is (u, s), shape (nu,), velocities and then states of one's own, but for its first nv where it is said.

    Attributes:
        scene: the mechanism, its parameters bound.
        forces: what drives it.
        opened: the scene with parameters free, and their values.
        decisions: what numbers have decided.
        events: formulas whose zeros are looked for.
        compiled: its functions with parameters free: "rates" and what is told about a state.
        calls: the functions by name at these values, each of (q, qd, tau, t) or fewer, batches too.
        works: whether W is the last entry of x.
        candidates: momenta that may be conserved.
        conserved: which of them are told by "momenta".
        mass: M of a tree, with parameters free, shape (nv nv,).
        dependent: the velocities that loops leave no choice, in the choice that was made; () if no other one may help.
        rows: number of rows that hold velocities.
        filled: places of the entries of G that are not zero, row by row; where `linear`, G is not asked for.
        kinds: of events, whose guards are the entries of "events"; the first are those asked for.
        notes: what a user should know: that numbers have decided otherwise than for values before.
        loop: the controller and the functions that are at work, None where there are none.
    """

    scene: Scene
    forces: Forces
    opened: Opened
    decisions: WrittenDecisions
    events: tuple[Quantity, ...]
    compiled: Compiled = field(repr=False)
    calls: Calls = field(repr=False)
    works: bool
    candidates: Candidates = field(repr=False)
    reported: tuple[int, ...]
    mass: tuple[Expr, ...] = field(repr=False)
    dependent: tuple[int, ...] = ()
    rows: int = 0
    filled: tuple[int, ...] = ()
    kinds: tuple[EventKind, ...] = ()
    notes: tuple[str, ...] = ()
    _by_rows: Callable[[], Function | None] = field(default=lambda: None, repr=False)
    _made: dict[Any, Any] = field(default_factory=dict, repr=False)
    loop: Loop | None = field(default=None, repr=False)
    contacts: Contacts | None = field(default=None, repr=False)

    def at(self, scene: Scene, forces: Forces, notes: tuple[str, ...] = ()) -> StateEquations:
        """Return the same equations at the values of a scene, and under tables of forces, that they were written for.

        Raises:
            DerivationError: something is divided by zero with these values.
        """
        found = opened(scene)
        calls = self.compiled.at(found.values)
        return replace(self, scene=scene, forces=forces, opened=found, calls=calls, notes=notes)

    @property
    def key(self) -> str:
        """A hash of what the equations are made of, values of parameters not among it."""
        parts = (self.opened.scene, *self.forces.form, self.events, self.decisions)
        return hashlib.sha256(repr(parts).encode()).hexdigest()

    def once(self, make: Callable[[StateEquations], T]) -> T:
        """Return what `make` makes of the equations; it is made once for all values, and must not read any."""
        if make not in self._made:
            self._made[make] = make(self)
        found: T = self._made[make]
        return found

    @property
    def program(self) -> Program:
        return self.compiled.program

    @property
    def linear(self) -> bool:
        """Whether the loops hold dependent coordinates in proportion, so that nothing is divided by what vanishes."""
        return self.decisions.linear is not None

    @cached_property
    def conserved(self) -> tuple[int, ...]:
        """Which momenta are conserved at these values, ascending."""
        return self.candidates.conserved(self.opened.values)

    @property
    def limits(self) -> dict[int, Limit]:
        """The limits of joints, by the number of their kind of event."""
        return {k: kind.limit for k, kind in enumerate(self.kinds) if kind.limit is not None}

    @property
    def bends(self) -> tuple[int, ...]:
        """The kinds of events where the equations bend."""
        return tuple(k for k, kind in enumerate(self.kinds) if kind.bends)

    @property
    def jumps(self) -> bool:
        """Whether something is changed at an event."""
        return any(kind.halts for kind in self.kinds)

    def behind(self, events: Iterable[int], t: float, x: Array) -> Array:
        """Return the state behind events of some kinds at once, shape (nx,); each sees the state before."""
        found, happened = x.copy(), list(events)
        for k in happened:
            if changes := list(self.kinds[k].changes):
                found[changes] = self.evaluate(f"update{k}", t, x)[changes]
        if self.works and self.scene.changing:  # matter that goes at once takes its energy along
            ahead, back = (sum(self.evaluate(name, t, y) for name in ("kinetic", "potential")) for y in (x, found))
            found[-1] += np.sum(back - ahead)
        contacts = [one for k in happened if (one := self.kinds[k].contact) is not None]
        return settled(self, t, found, contacts) if contacts else found

    def residue(self, events: Iterable[int], t: float, x: Array) -> dict[int, float]:
        """Return what is zero of the guards of events that happen at a state, and of others with such a guard."""
        values, guards = self.evaluate("events", t, x), {self.kinds[k].guard for k in events}
        return {k: RESIDUE * abs(float(values[k])) for k, kind in enumerate(self.kinds) if kind.guard in guards}

    @property
    def momenta(self) -> tuple[str, ...]:
        """Names of the momenta that are conserved."""
        return tuple(self.candidates.names[k] for k in self.conserved)

    @cached_property
    def nq(self) -> int:
        return len(self.scene.coordinates)

    @cached_property
    def nv(self) -> int:
        return len(self.scene.velocities)

    @cached_property
    def nu(self) -> int:
        """Number of velocities and states of one's own."""
        return self.nv + len(self.scene.states)

    @property
    def hidden(self) -> int:
        """Number of states that are modes of contacts; they stand last."""
        return 0 if self.contacts is None else self.nq + self.nu - self.contacts.place

    @property
    def nz(self) -> int:
        """Number of states of a controller, which stand between (u, s) and W."""
        return 0 if self.loop is None else self.loop.nz

    @cached_property
    def given_size(self) -> int:
        """Number of driving forces and inputs."""
        return self.nv + len(self.scene.inputs)

    @cached_property
    def closed(self) -> bool:
        """Whether there are rows to hold; loops whose rows are all redundant have none."""
        return self.rows > 0

    @property
    def swerves(self) -> bool:
        """Whether motions that miss the loops leave those that close them, the faster the nearer a change point is."""
        return self.closed and not self.linear

    @cached_property
    def quaternions(self) -> tuple[slice, ...]:
        """Where the quaternions stand in q."""
        names = list(self.scene.coordinates)
        firsts = [names.index(group[0]) for group in quaternions(self.scene)]
        return tuple(slice(first, first + 4) for first in firsts)

    @cached_property
    def _nothing(self) -> Array:
        return np.zeros(self.given_size)

    @cached_property
    def _takes(self) -> Mapping[str, tuple[str, ...]]:
        return {r.function.name: tuple(self.compiled.takes(r.function.name)) for r in self.program.routines}

    def rates(self, t: float, x: Array) -> Array:
        """Return ẋ of one state, shape (nx,)."""
        q, u, z = self.parts(x)
        if self.swerves:
            if self.ill_chosen(q):
                return self._at_once(q, u, z, t)
            q, u = self.on_manifold(q, u)
        return self._whole(self._rates(q, u, self.given(t, q, u, z), t), t, q, u, z)

    def parts(self, x: Array) -> tuple[Array, Array, Array]:
        """Return q, u and z of states, shape (..., nx)."""
        n = self.nq + self.nu
        return x[..., : self.nq], x[..., self.nq : n], x[..., n : n + self.nz]

    def _whole(self, rates: Array, t: npt.ArrayLike, q: Array, u: Array, z: Array) -> Array:
        """Return rates of a mechanism with those of its controller among them."""
        if self.loop is None or not self.nz:
            return rates
        n = self.nq + self.nu
        return np.concatenate([rates[..., :n], self.loop.rates(t, q, u, z), rates[..., n:]], axis=-1)

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

    def _at_once(self, q: Array, u: Array, z: Array, t: float) -> Array:
        """Return ẋ of one state by all rows of G at once."""
        still = np.zeros(self.nu - self.nv)
        for _ in range(CORRECTIONS):
            step = np.linalg.lstsq(self.jacobian(0.0, q), self.calls["constraint_residual"](q))[0]
            q = q - self.calls["movement"](q, np.append(step, still))
        G = self.jacobian(0.0, q)
        u = u - np.append(np.linalg.lstsq(G, G @ u[: self.nv])[0], still)
        return self._whole(self._together(q, u, self.given(t, q, u, z), t), t, q, u, z)

    @property
    def together(self) -> Compiled | None:
        """The rates of a closed mechanism by all rows at once, parameters free; None where they do not exist."""
        return self.once(_together)

    @cached_property
    def _together(self) -> Callable[..., Array]:
        return self._rates if self.together is None else self.together.at(self.opened.values)["together"]

    @cached_property
    def _rates(self) -> Callable[..., Array]:
        return self.calls["rates"]

    def given(self, t: npt.ArrayLike, q: Array, u: Array, z: Array = NOTHING) -> Array:
        """Return what tables and a controller give at states, forces and then inputs; zeros without."""
        if not self.forces.outside:
            return self._nothing
        found = self.forces.tabulated(np.asarray(t, dtype=np.float64), self.given_size)
        return found if self.loop is None else found + self.loop(t, q, u, z)

    def evaluate(self, name: str, t: npt.ArrayLike, x: Array) -> Array:
        """Return a function of the program at states x, shape (..., nx), and times (...)."""
        if name not in self._takes:  # without entries, as of a mechanism that stands
            return np.zeros((*x.shape[:-1], 0))
        times = np.asarray(t, dtype=np.float64)
        q, u, z = self.parts(x)
        known = {"q": q, "qd": u, TIME: times}
        if "tau" in self._takes[name]:
            known["tau"] = self.given(times, q, u, z)
        found = np.asarray(self.calls[name](*(known[argument] for argument in self._takes[name])), dtype=np.float64)
        if name == "rates":
            found = self._whole(found, times, q, u, z)
        if name == "rates" and self.dependent and x.ndim == 2:
            reach = np.abs(self.calls["reach"](known["q"])).reshape(len(x), -1).max(axis=1, initial=0.0)
            for k in np.flatnonzero(~(reach <= LARGEST)):
                found[k] = self.rates(float(times[k]), x[k])
        return found

    def jacobian(self, t: npt.ArrayLike, x: Array) -> Array:
        """Return G at states x, shape (..., rows, nv)."""
        G = np.zeros((*x.shape[:-1], self.rows * self.nv))
        G[..., self.filled] = self.evaluate("slopes", t, x)
        return G.reshape(*x.shape[:-1], self.rows, self.nv)


def _together(system: StateEquations) -> Compiled | None:
    function = system._by_rows()
    return None if function is None else compiled(system.opened.scene, function.entries[0].graph, (function,))


STEPS = 8

SMALL = 1e-8
"""What is off by less, of its size, is off by rounding after one step of Newton's."""

NEGLIGIBLE = 1e-9
"""Singular values of G below it, over the largest, are zero: redundant rows, and what a change point loses."""


class Projection:
    """Returns the nearest state that keeps all constraints, None where they are kept well enough.

    Attributes:
        limit: of residuals, of velocities against rows over the fastest one or 1, and of the squared length of
            quaternions less one.
        active: whether there is anything to keep.
    """

    def __init__(self, system: StateEquations, limit: float) -> None:
        self.system, self.limit = system, limit
        held = set(system.scene.prescribed_velocities)
        self._loose = np.array([k for k in range(system.nv) if k not in held], dtype=int)
        self.active = bool(system.quaternions) or system.closed

    def __call__(self, x: Array, slack: float = 1.0) -> Array | None:
        """Return the projected state, shape (nx,), where it has drifted further than `slack` times the limit."""
        if not self.active or self.drift(x) <= slack * self.limit:
            return None
        return self.projected(x)

    def drift(self, x: Array) -> float:
        """Return how far the constraints are missed, velocities over the fastest one or 1."""
        lengths = [abs(float(x[part] @ x[part]) - 1.0) for part in self.system.quaternions]
        off = max(lengths, default=0.0)
        if self.system.closed:
            missed = self.system.evaluate("constraint_residual", 0.0, x), self.system.evaluate("row_rates", 0.0, x)
            fastest = max(1.0, float(np.abs(self.system.parts(x)[1][: self.system.nv]).max(initial=0.0)))
            off = max(off, np.abs(missed[0]).max(initial=0.0), np.abs(missed[1]).max(initial=0.0) / fastest)
        return float(off)

    def projected(self, x: Array) -> Array:
        """Return x moved onto the constraints."""
        x = self._normalised(x)
        if not self.system.closed:
            return x
        nq, nv, nu = self.system.nq, self.system.nv, self.system.nu
        if self.system.linear:  # whatever G is: at a change point it says little
            return np.concatenate([*self.system.on_manifold(x[:nq], x[nq : nq + nu]), x[nq + nu :]])
        for _ in range(STEPS):
            r, G = self._rows(x)
            off = np.abs(r).max(initial=0.0)
            if off <= 0.01 * self.limit:
                break
            step = np.zeros(nu)
            step[self._loose] = -_least(G[:, self._loose], r)
            x = x.copy()
            x[:nq] += self.system.calls["movement"](x[:nq], step)
            x = self._normalised(x)
            if off <= SMALL:
                break
        G = self.system.jacobian(0.0, x)
        for _ in range(2):  # once more for what rounding has left
            u = x[nq : nq + nv]
            missed = G @ u
            x[nq + self._loose] -= _least(G[:, self._loose], missed)
            if np.abs(missed).max(initial=0.0) <= SMALL * max(1.0, np.abs(u).max(initial=0.0)):
                break
        return x

    def _rows(self, x: Array) -> tuple[Array, Array]:
        """Return r, shape (m,), and G, shape (m, nv)."""
        return self.system.evaluate("constraint_residual", 0.0, x), self.system.jacobian(0.0, x)

    def _normalised(self, x: Array) -> Array:
        x = x.copy()
        for part in self.system.quaternions:
            x[part] /= np.linalg.norm(x[part])
        return x


def _least(G: Array, b: Array) -> Array:
    """Return the shortest of all x that come closest to G x = b."""
    return np.asarray(np.linalg.lstsq(G, b, rcond=NEGLIGIBLE)[0], dtype=np.float64)
