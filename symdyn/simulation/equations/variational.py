"""The flow of a system next to a motion: its rates differentiated along directions, and against covectors.

    x = (q, u, s)   ẋ = f(t, x, p)      p named parameters

    along      δẋ = ∂f/∂x δx + ∂f/∂p δp              tangents of the graph, one direction a call, or a batch
    against    (λᵀ ∂f/∂x, λᵀ ∂f/∂p)                  the gradient of λᵀ f, one covector a call, or a batch
    held       δ(r, G u) of position-level rows, and of all rows
    turned     H(q) v
    led        δ(position, velocity) of prescribed motions, by δp
    jump       δ(g, R) of an event at which something jumps, by δx, δp and δt

Of a closed mechanism f takes all rows at once, with multipliers. The manifold r = 0, G u = 0 is kept by its flow, so
that what is tangent to it stays so, and no choice of independent velocities can fail on the way. Where that f does not
exist, as masses leave something open without the rows, and where loops hold coordinates in proportion, it is that of
the chosen velocities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import Function, Workspace
from symdyn.dynamics.mechanism import TIME, prescribed
from symdyn.dynamics.outputs import with_modes
from symdyn.errors import SimulateError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, gradient, reachable, substitute, tangents
from symdyn.scene import Scene, with_values
from symdyn.simulation.equations.compiled_routines import Calls, Compiled, argument, compiled, plain
from symdyn.simulation.equations.contact_modes import STRIKES
from symdyn.simulation.equations.events import saltation
from symdyn.simulation.equations.linear_feedback import state_names
from symdyn.simulation.equations.settling import impact_beside
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.prescribed.forces import Forces, force_names

ALONG, AGAINST = "along", "against"
"""The two sweeps: which of them is written, and compiled."""


WIDTH = 1e-3
"""Of differences of impacts, in units of the scene."""

FAILS = 1e-9
"""Smallest singular value of G_d over the largest of G with which independent velocities determine the others."""


@dataclass(frozen=True)
class Flow:
    """The flow of a system at values, and one sweep over it.

    Attributes:
        system: the mechanism under its forces.
        parameters: names of p.
        calls: the functions of the module's legend.
        width: of the differences that impacts are differentiated by, in units of the scene.
    """

    system: StateEquations
    parameters: tuple[str, ...]
    calls: Calls
    width: float = WIDTH

    @classmethod
    def of(cls, scene: Scene, forces: Forces, q: Array, parameters: Sequence[str], smooth: bool = False) -> Flow:
        """Return the flow of a scene under forces, from q on; `smooth` looks whether tangents see it all.

        Raises:
            SimulateError: of a smooth one, forces jump, or a parameter is none of the equations.
            DerivationError: there is no forward dynamics, or loops cannot be closed.
        """
        return (smooth_flow if smooth else flow)(state_equations(scene, forces, (), q), parameters)

    @property
    def size(self) -> int:
        return self.system.nq + self.system.nu

    def rates(self, t: float, x: Array) -> Array:
        """Return f, shape (nx,)."""
        q, u = self._parts(x)
        found: Array = self._whole(q, u, self.system.given(t, q, u), t)
        return found[: self.size]

    @property
    def _whole(self) -> Callable[..., Array]:
        return self.system._together if _by_rows(self.system) else self.system._rates

    def along(self, t: float, x: Array, ways: Array, changes: Array) -> Array:
        """Return δẋ, shape (k, nx), of δx, shape (k, nx), and δp, shape (k, np)."""
        q, u = self._parts(x)
        dq, du = (np.ascontiguousarray(part) for part in self._parts(ways))
        found: Array = self.calls[ALONG](q, u, self.system.given(t, q, u), t, dq, du, changes)
        return found

    def both(self, t: float, x: Array, given: Array, ways: Array, changes: Array) -> tuple[Array, Array]:
        """Return f and δẋ, shapes (nx,) and (k, nx), under driving forces and inputs that are given as numbers."""
        q, u = self._parts(x)
        dq, du = (np.ascontiguousarray(part) for part in self._parts(ways))
        rates: Array = self._whole(q, u, given, t)
        return rates[: self.size], self.calls[ALONG](q, u, given, t, dq, du, changes)

    def against(self, t: float, x: Array, covectors: Array) -> tuple[Array, Array]:
        """Return λᵀ ∂f/∂x, shape (k, nx), and λᵀ ∂f/∂p, shape (k, np), of λ, shape (k, nx)."""
        q, u = self._parts(x)
        found: Array = self.calls[AGAINST](q, u, self.system.given(t, q, u), t, covectors)
        return found[:, : self.size], found[:, self.size :]

    def tangent(self, t: float, x: Array, way: Array, change: Array) -> Array:
        """Return δẋ, shape (nx,), of δx, shape (nx,), and δp, shape (at least 1,), by the sweep that there is."""
        if ALONG in self.calls:
            return np.asarray(self.along(t, x, way[None], change[None])[0])
        J, F = self.slopes(t, x)
        return J @ way + F @ change[: len(self.parameters)]

    def slopes(self, t: float, x: Array) -> tuple[Array, Array]:
        """Return ∂f/∂x, shape (nx, nx), and ∂f/∂p, shape (nx, np), by the sweep that there is."""
        n, k = self.size, len(self.parameters)
        if AGAINST in self.calls:
            return self.against(t, x, np.eye(n))
        ways, changes = np.eye(n + k)[:, :n], np.eye(n + k, n + max(1, k))[:, n:]
        found = self.along(t, x, ways, changes).T
        return found[:, :n], found[:, n:]

    def held(self, x: Array, ways: Array, changes: Array) -> Array:
        """Return how residuals, then velocities against rows, change along directions, shape (k, rows)."""
        q, u = self._parts(x)
        dq, du = (np.ascontiguousarray(part) for part in self._parts(ways))
        found: Array = self.calls["held"](q, u, dq, du, changes)
        return found

    def turned(self, q: Array) -> Array:
        """Return H, shape (nq, nv)."""
        found: Array = self.calls["turned"](q, np.eye(self.system.nv))
        return found.T

    def led(self, changes: Array) -> Array:
        """Return how prescribed positions, then velocities, at t = 0 change with δp, shape (k, 2 of them)."""
        found: Array = self.calls["led"](0.0, changes)
        return found

    def through(self, events: Sequence[int], t: float, x: Array, there: bool = False) -> tuple[Array, Array, Array]:
        """Return the state behind events at once, ∂x⁺/∂x⁻, shape (nx, nx), and ∂x⁺/∂p, shape (nx, at least 1).

        Changes are of states at one time, or where `there` is set, of states at the event, whenever that is.

        Raises:
            SimulateError: the guard is only touched there, and the run has no derivative.
        """
        n, np_, system = self.size, max(1, len(self.parameters)), self.system
        after, (q, u) = self._behind(events, t, x), self._parts(x)
        before, later = self.rates(t, x), self.rates(t, after)
        if not there and np.array_equal(self._moving(after), self._moving(x)) and np.allclose(before, later, 1e-12, 0):
            return after, np.eye(n), np.zeros((n, np_))
        every = np.eye(n + np_ + 1)
        dq, du = (np.ascontiguousarray(part) for part in self._parts(every[:, :n]))
        slopes = np.eye(n + 1, n + np_ + 1, -1)
        given = (q, u, system.given(t, q, u), t, dq, du, every[:, n:])
        whole = self.calls["guards"](*given).T if _guarded(system) else np.zeros((0, n + np_ + 1))
        guards = dict(zip([k for k, kind in enumerate(system.kinds) if not kind.update], whole, strict=False))
        for k in events:
            jump = self.calls[f"jump{k}"](*given).T if system.kinds[k].update else guards[k][None]
            rows = [0, *(1 + entry for entry in system.kinds[k].changes)]
            slopes[rows] = jump[rows]
        struck = [one[0] for k in events if (one := system.kinds[k].contact) is not None and one[1] == STRIKES]
        if struck and not np.array_equal(self._moving(after)[system.nq :], self._moving(x)[system.nq :]):
            jumping = slice(1 + system.nq, 1 + system.nq + system.nv)
            slopes[jumping, :n], slopes[jumping, n : n + len(self.parameters)] = self._impact(struck, t, x)
        found = saltation(slopes, before, np.zeros(n) if there else later)
        if found is None:
            contact = system.kinds[events[0]].contact
            text = system.kinds[events[0]].text or "the section"
            text = text if contact is None or system.contacts is None else f"contact {system.contacts.name(contact[0])}"
            raise SimulateError(
                f"{system.scene.name}: {text} is only touched at t = {t:.9g} s: a run has no derivative"
            )
        return after, found[:, :n], found[:, n:]

    def _moving(self, x: Array) -> Array:
        """Return a state without the modes of contacts, which stand last."""
        return x[: self.size - self.system.hidden]

    def _behind(self, events: Sequence[int], t: float, x: Array) -> Array:
        works = np.zeros(int(self.system.works))
        return self.system.behind(events, t, np.append(x, works))[: self.size]

    def _impact(self, struck: Sequence[int], t: float, x: Array) -> tuple[Array, Array]:
        """Return ∂u⁺/∂x⁻ and ∂u⁺/∂p of an impact, shapes (nv, nx) and (nv, np), by differences of fourth order.

        Where no contact slips along two directions velocities behind are linear in those before, and a step is long.
        """
        system, nq, nv, values = self.system, self.system.nq, self.system.nv, self.system.opened.values
        behind = impact_beside(system, t, x, struck)
        assert system.contacts is not None, "something strikes"
        linear, declared = all(many < 2 for _, _, many in system.contacts.touches), system.contacts.declared

        def along(position: Array, velocity: Array) -> Callable[[float], Array]:
            return lambda step: behind(system, _beside(system, x, step * position, step * velocity))

        def by(name: str) -> Callable[[float], Array]:
            assert declared is not None, "the run has begun"
            return lambda step: behind(
                system.at(with_modes(with_values(declared, {name: values[name] + step})), system.forces), x
            )

        none, every = np.zeros(system.nu), np.eye(nv, system.nu)
        by_position = [_slope(along(way, none), self.width) for way in every]
        by_velocity = [_slope(along(none, way), 1.0 if linear else self.width) for way in every]
        by_parameter = [_slope(by(name), self.width * (abs(values[name]) or 1.0)) for name in self.parameters]
        slopes = np.zeros((nv, self.size))
        slopes[:, :nq] = np.transpose(by_position) @ np.linalg.pinv(self.turned(x[:nq]))
        slopes[:, nq : nq + nv] = np.transpose(by_velocity)
        return slopes, np.reshape(by_parameter, (len(self.parameters), nv)).T

    def starting(
        self, x: Array, chosen: tuple[list[int], list[int]] | None = None
    ) -> tuple[Array, Array, tuple[str, ...]]:
        """Return δx and δp of every column, shapes (k, nx) and (k, at least 1), and their names; of what was chosen."""
        system = self.system
        scene, nq, nv, nu, np_ = system.scene, system.nq, system.nv, system.nu, len(self.parameters)
        motion, names = prescribed(scene, Graph()), state_names(scene)
        H = self.turned(x[:nq])
        positions, velocities = chosen or self.independent()
        count = len(positions) + len(velocities) + np_
        moves, rates = np.zeros((count, nv)), np.zeros((count, nu))  # δξ and δu
        changes = np.zeros((count, max(1, np_)))
        for row, k in enumerate(positions):
            moves[row, k] = 1.0
        for row, k in enumerate(velocities, len(positions)):
            rates[row, k] = 1.0
        changes[count - np_ :, :np_] = np.eye(np_)
        if motion.place and np_:
            led = self.led(changes)
            moves[:, motion.place], rates[:, motion.place] = np.split(led, 2, axis=1)
        follows = [[k for k in range(nv) if k not in (*some, *motion.place)] for some in (positions, velocities)]
        if system.rows:
            self._follow(x, H, (moves, rates, changes), follows)
        columns = (*(names[k] for k in positions), *(names[nv + k] for k in velocities), *self.parameters)
        return np.hstack([moves @ H.T, rates]), changes, columns

    def independent(self) -> tuple[list[int], list[int]]:
        """Return the independent positions and velocities; prescribed motions are none."""
        system = self.system
        led = system.scene.prescribed_velocities
        positions = velocities = tuple(range(system.nv))
        if system.decisions.partition is not None:
            w = Workspace(system.opened.scene, system.opened.closing)
            positions, velocities = w.loops.position_level[1].independent, w.loops.decisions.partition.independent
        found = [[k for k in sorted(some) if k not in led] for some in (positions, velocities)]
        return found[0], [*found[1], *range(system.nv, system.nu - system.hidden)]

    def _follow(self, x: Array, H: Array, start: tuple[Array, Array, Array], follows: Sequence[Sequence[int]]) -> None:
        """Let dependent positions and velocities follow, so that δr = 0 and δ(G u) = 0; they are written in place."""
        moves, rates, changes = start
        nv, nu, rows = self.system.nv, self.system.nu, self.system.rows
        none = np.zeros((nv, changes.shape[1]))
        held = self.held(x, np.hstack([H.T, np.zeros((nv, nu))]), none)
        G_h, G = held[:, :-rows].T, self.held(x, np.hstack([0 * H.T, np.eye(nv, nu)]), none)[:, -rows:].T
        for values, matrix, part, own in ((moves, G_h, slice(0, -rows), 0), (rates, G, slice(-rows, None), 1)):
            dependent = list(follows[own])
            if not dependent:
                continue
            sizes = [np.linalg.svd(one, compute_uv=False) for one in (matrix[:, dependent], matrix)]
            if len(sizes[0]) < len(dependent) or sizes[0][-1] < FAILS * sizes[1][0]:
                raise SimulateError(
                    f"{self.system.scene.name}: the independent velocities do not determine the others at this start; "
                    "give another one"
                )
            missed = self.held(x, np.hstack([moves @ H.T, rates]), changes)[:, part]
            values[:, dependent] -= np.linalg.lstsq(matrix[:, dependent], missed.T)[0].T

    def _parts(self, x: Array) -> tuple[Array, Array]:
        nq = self.system.nq
        return x[..., :nq], x[..., nq : self.size]


def _beside(system: StateEquations, x: Array, moved: Array, faster: Array) -> Array:
    y, nq = x.copy(), system.nq
    y[:nq] += system.calls["moved"](x[:nq], moved)
    y[nq : nq + system.nu] += faster
    return y


def _slope(f: Callable[[float], Array], width: float) -> Array:
    """Return f'(0), by differences of fourth order."""
    return np.asarray((8 * (f(width) - f(-width)) - (f(2 * width) - f(-2 * width))) / (12 * width))


def flow(system: StateEquations, parameters: Sequence[str], sweep: str = ALONG) -> Flow:
    """Return the flow of a system with one sweep over it, compiled once for all values."""
    made, key = system.once(_nothing), (tuple(parameters), sweep)
    if key not in made:
        made[key] = _written(system, key[0], sweep)
    return Flow(system, key[0], made[key].at(system.opened.values))


def smooth_flow(system: StateEquations, parameters: Sequence[str] | None, sweep: str = ALONG) -> Flow:
    """Return the flow, of None by all parameters that are free in the equations.

    Raises:
        SimulateError: forces jump, or a parameter is none of the equations.
    """
    check_smooth(system)
    return flow(system, varied(system, parameters), sweep)


def check_smooth(system: StateEquations) -> None:
    """Raise SimulateError where forces jump: the time of a jump depends on the start, which no tangent sees."""
    found = next((one for one in reachable(system.program["rates"].function.entries) if one.jumps), None)
    if found is not None:
        word = "if" if len(found.args) > 1 else "sign"
        raise SimulateError(
            f"{system.scene.name}: a force with {word} jumps, and a run has no derivative by what moves the jump; "
            "write a steep tanh(v/0.01) in place of sign(v), or give the joint friction with smoothing"
        )


def varied(system: StateEquations, requested: Sequence[str] | None) -> tuple[str, ...]:
    """Return the parameters that are varied; SimulateError where one is none of the equations."""
    free = [one.name for one in system.opened.scene.free_parameters]
    if requested is None:
        return tuple(free)
    fixed = [f"{name} = {system.opened.values[name]:g}" for name in requested if name not in free]
    if fixed:
        raise SimulateError(
            f"{system.scene.name}: {', '.join(fixed)} decides which terms the equations have, as zero and right angles "
            "do, so that they cannot be differentiated by it; give a value next to that, such as 1e-9"
        )
    return tuple(requested)


def _nothing(system: StateEquations) -> dict[tuple[tuple[str, ...], str], Compiled]:
    return {}


def _guarded(system: StateEquations) -> bool:
    """Tell whether there are guards that nothing is updated at, but that end a motion, or modes of contacts."""
    return bool(system.events) or system.contacts is not None


def _by_rows(system: StateEquations) -> bool:
    """Tell whether f takes all rows at once."""
    return bool(system.closed and not system.linear and system.contacts is None and system.together)


def _flowing(system: StateEquations) -> Function:
    if _by_rows(system) and system.together is not None:
        return system.together.program["together"].function
    return system.program["rates"].function


def _written(system: StateEquations, parameters: tuple[str, ...], sweep: str) -> Compiled:
    nq, nv, nu, f = system.nq, system.nv, system.nu, _flowing(system)
    graph, entries = f.entries[0].graph, f.entries[: nq + nu]
    w = Workspace(system.opened.scene, system.opened.closing)
    known = {one.name: one for one in f.arguments}
    others = [one for name, one in known.items() if name not in ("q", "qd", "tau", "t")]
    inputs = (*known["q"].symbols, *known["qd"].symbols, *map(graph.symbol, parameters))
    dq, du = argument(graph, "dq", nq), argument(graph, "du", nu)
    dp = argument(graph, "dp", len(parameters)) if parameters else argument(graph, "dp", 1)
    moving = (*dq.symbols, *du.symbols, *dp.symbols[: len(parameters)])
    seeds = dict(zip(inputs, moving, strict=True))
    if sweep == ALONG:
        functions = [plain(ALONG, tangents(entries, seeds), (*f.arguments, dq, du, dp))]
    else:
        covector = argument(graph, "covector", nq + nu)
        total = graph.dot(covector.symbols, entries)
        functions = [plain(AGAINST, gradient(total, inputs), (*f.arguments, covector))]
    v = argument(graph, "v", nv)
    rates = substitute(substitute(w.state.rates, {}, graph), dict(zip(known["qd"].symbols, v.symbols, strict=False)))
    functions.append(plain("turned", rates, (known["q"], *others, v)))
    rows: list[Expr] = []
    if system.rows:
        residual = system.program["constraint_residual"].function.entries
        rows = [*(one for one in residual if not one.is_zero), *system.program["row_rates"].function.entries]
        changing = tangents(substitute(rows, {}, graph), seeds)
        functions.append(plain("held", changing, (known["q"], known["qd"], *others, dq, du, dp)))
    motion = prescribed(w.scene, graph)
    if motion.place:
        by = dict(zip(inputs[nq + nu :], dp.symbols, strict=False))
        told = zip(force_names(w.scene), map(system.forces.formula, range(system.given_size)), strict=True)
        placed = {graph.symbol(name): one.express(graph) for name, one in list(told)[nv:]}
        changing = tangents(substitute((*motion.position, *motion.velocity), placed), by)
        functions.append(plain("led", changing, (known["t"], *others, dp)))
    late = argument(graph, "late", max(1, len(parameters)) + 1)
    later = dict(zip(inputs, (*dq.symbols, *du.symbols, *late.symbols), strict=False))
    later[graph.symbol(TIME)] = late.symbols[-1]
    for k, kind in enumerate(system.kinds):
        if kind.update:
            jump = substitute((kind.guard, *kind.update), {}, graph)
            functions.append(plain(f"jump{k}", tangents(jump, later), (*f.arguments, dq, du, late)))
    if guards := [kind.guard for kind in system.kinds if not kind.update] if _guarded(system) else []:
        changing = tangents(substitute(guards, {}, graph), later)
        functions.append(plain("guards", changing, (*f.arguments, dq, du, late)))
    return compiled(system.opened.scene, graph, functions)
