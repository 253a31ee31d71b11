"""What implicit methods ask for: the derivative of the rates, or equations with multipliers, F(y, ẏ, t) = 0 of index 1.

Of the rates f the graph is differentiated by the state, ∂f/∂x, once a run has asked for a few differences:

    c, H, fit    a closed mechanism's correction -G_d⁻¹ r, zero where its loops are closed; q̇ = H u; fitted velocities
    δq' = δq + H δc        δu' = δfit(q', u)        δf = δrates(q', u')

f brings a state back to its loops before it looks at it, and so does its derivative. One function takes a state and a
direction (δq, δu); all columns are one call of it, a batch of directions. Its length is thus that of the equations
times three or so, however many columns there are, and no size of a difference has to be guessed: a coordinate that
nothing depends on, as of a shaft that turns freely, has a column of zeros.

The equations with multipliers are a differential-algebraic system:

    y        q, u, s, z of a controller, W the work of forces, Λ, N, P
    λ = Λ̇    multipliers of the rows G, N and N m
    ν = Ṅ    multipliers of the loops' residuals r; ρ = Ṗ those of the lengths of quaternions e

    q̇ = H (u + Gᵀ ν) + e ρ         M u̇ + h = τ + Gᵀ λ         Ẇ = power
    G u = 0         r(q) = 0         e·e = 1

Positions and velocities are both held to their constraints: ν and ρ vanish on the solution, and make room for r = 0
beside G u = 0 (Gear, Gupta and Leimkuhler). Solved for λ, ν and ρ these equations have index 2. They have index 1 for
Λ, N and P, of which only rates occur (Gear), and that is what IDA is made for. Nothing is divided by a pivot that was
chosen beforehand. Rows that hold no position, of wheels that roll, have no ν. A prescribed motion takes the place of
its force balance, u̇ = p̈, and ν does not move it.

References: Gear, Gupta and Leimkuhler, Automatic integration of Euler-Lagrange equations with constraints (1985); Gear,
Differential-algebraic equation index transformations (1988).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.dynamics import Workspace
from symdyn.graph import Expr, substitute, tangents
from symdyn.program import Program
from symdyn.scene.values import acceleration_name
from symdyn.simulation.equations.compiled_routines import Compiled, acting, argument, compiled, plain
from symdyn.simulation.equations.control_loop import differences_of
from symdyn.simulation.equations.system import StateEquations

RELATIVE = 1e-6
"""Size of a difference, over that of the coordinate or 1: where the graph has no value."""


Slope = Callable[[float, Array], Array]

FEW = 20
"""Derivatives of a run that are differences, before exact ones are worth the time to derive and compile them."""


def slopes_in_turn(system: StateEquations) -> Slope:
    """Return the function of (t, x) whose value is ∂f/∂x, for one run: differences first, exact if it is a long one.

    Whether the exact ones are compiled already makes no difference, so that a run repeats itself to the last digit.
    """
    asked, exact = 0, None

    def slope(t: float, x: Array) -> Array:
        nonlocal asked, exact
        asked += 1
        if asked <= FEW:
            return differences(system, t, x, RELATIVE)
        exact = exact or slopes(system)
        return exact(t, x)

    return slope


def slopes(system: StateEquations) -> Slope:
    """Return the function of (t, x) whose value is ∂f/∂x, shape (nx, nx), exact."""
    nq, nv = system.nq, system.nu
    calls = system.once(_along).at(system.opened.values)
    along, brought_back = calls["along"], calls.get("ways")
    n, nz = nq + nv, system.nz
    every_q, every_u = (np.ascontiguousarray(part) for part in np.split(np.eye(n + nz, n), [nq], axis=1))

    def slope(t: float, x: Array) -> Array:
        J = np.zeros((len(x), len(x)))
        q, u, z = system.parts(x)
        if not system.ill_chosen(q):
            forces = []
            if system.loop is not None:  # which is asked at the state that is brought back
                ways = np.eye(n + nz)
                if brought_back is not None:
                    ways[:, :n] = brought_back(q, u, every_q, every_u)
                forces = [ways @ system.loop.slope(t, q, u, z).T]
                if nz:
                    J[n : n + nz, : n + nz] = system.loop.rate_slope(t, q, u, z) @ ways.T
            found = along(q, u, system.given(t, q, u, z), t, every_q, every_u, *forces).T
            J[_mechanism(system, len(x)), : n + nz] = found
            if np.all(np.isfinite(J)):
                return J
        return differences(system, t, x, RELATIVE)

    return slope


def _mechanism(system: StateEquations, size: int) -> npt.NDArray[np.int_]:
    """Return which of so many entries are not states of a controller, which stand behind q and u."""
    n = system.nq + system.nu
    return np.delete(np.arange(size), slice(n, n + system.nz))


def _along(system: StateEquations) -> Compiled:
    """Return the derivative of the rates in a direction (δq, δu), their last arguments, and δτ under a controller."""
    program, nq, nv = system.program, system.nq, system.nu
    rates = program["rates"].function
    q, u = (one.symbols for one in rates.arguments if one.name in ("q", "qd"))
    dq, du = argument(program.graph, "dq", nq), argument(program.graph, "du", nv)
    along = (dq.symbols, du.symbols)
    if system.closed and not system.linear:
        names = ("correction", "movement", "fitted")
        correction, movement, fitted = (program[name].function.entries for name in names)
        step = tangents(correction, dict(zip(q, dq.symbols, strict=True)))
        moved = substitute(movement, dict(zip(u, step, strict=True)))
        ways = tuple(a + b for a, b in zip(dq.symbols, moved, strict=True))
        along = (ways, tuple(tangents(fitted, dict(zip((*q, *u), (*ways, *du.symbols), strict=True)))))
    seeds = dict(zip((*q, *u), (*along[0], *along[1]), strict=True))
    more, others = [], []
    if system.forces.fed:
        more = [argument(program.graph, "dtau", system.given_size)]
        (tau,) = (one.symbols for one in rates.arguments if one.name == "tau")
        seeds |= dict(zip(tau, more[0].symbols, strict=True))
        if along[0] is not dq.symbols:
            here = (one for one in rates.arguments if one.name in ("q", "qd", Program.PARAMS))
            others = [plain("ways", (*along[0], *along[1]), (*here, dq, du))]
    function = plain("along", tangents(rates.entries, seeds), (*rates.arguments, dq, du, *more))
    return compiled(system.opened.scene, program.graph, (function, *others))


def differences(system: StateEquations, t: float, x: Array, relative: float) -> Array:
    """Return ∂f/∂x by central differences of that relative size, (nx, nx); zeros where it is not finite."""
    J = differences_of(lambda y: system.rates(t, y), x, relative)
    return np.where(np.isfinite(J), J, 0.0)


class Implicit:
    """F of a system and its derivatives by the graph.

    Attributes:
        system: the mechanism under its forces.
        size: length of y.
    """

    def __init__(self, system: StateEquations) -> None:
        """Take F, compiled once for all values of parameters, at those of the system."""
        self.system = system
        _, ends = _layout(system)
        self._ends = ends + system.nz
        self.size = int(self._ends[-1])
        self._own = _mechanism(system, self.size)
        self._calls = system.once(_functions).at(system.opened.values)

    def start(self, t: float, x: Array) -> tuple[Array, Array]:
        """Return y and ẏ at a state that keeps its constraints, shape (nx,)."""
        y, rates = np.zeros(self.size), np.zeros(self.size)
        y[: len(x)], rates[: len(x)] = x, self.system.rates(t, x)
        if self.system.rows:
            nq, nv = self.system.nq, self.system.nv
            excess = self.residual(t, y, rates)[nq : nq + nv]  # as the multipliers are zero yet
            push = self.slope(t, y, rates, 1.0)[nq : nq + nv, self._ends[2] : self._ends[3]]  # -Gᵀ
            rates[self._ends[2] : self._ends[3]] = np.linalg.lstsq(push, -excess, rcond=None)[0]
        return y, rates

    def residual(self, t: float, y: Array, rates: Array) -> Array:
        """Return F, shape (size,)."""
        found: Array = rates.copy()
        found[self._own] = self._calls["residual"](*self._state(t, y), np.ascontiguousarray(rates[self._own]))
        if self.system.loop is not None and self.system.nz:
            (n, nz), state = (self.system.nq + self.system.nu, self.system.nz), self.system.parts(y)
            found[n : n + nz] -= self.system.loop.rates(t, *state)
        return found

    def slope(self, t: float, y: Array, rates: Array, c: float) -> Array:
        """Return ∂F/∂y + c ∂F/∂ẏ, shape (size, size)."""
        every, n = np.eye(self.size)[:, self._own], self.system.nq + self.system.nu + self.system.nz
        J, forces = c * np.eye(self.size), []
        if self.system.loop is not None:
            state = self.system.parts(y)
            forces = [np.zeros((self.size, self.system.given_size))]
            forces[0][:n] = self.system.loop.slope(t, *state).T
            if self.system.nz:
                J[n - self.system.nz : n, :n] -= self.system.loop.rate_slope(t, *state)
        J[self._own] = self._calls["along"](*self._state(t, y), rates[self._own], every, c * every, *forces).T
        return J

    def _state(self, t: float, y: Array) -> tuple[Array, Array, Array, float]:
        q, u, z = self.system.parts(y)
        return q, u, self.system.given(t, q, u, z), t


def _layout(system: StateEquations) -> tuple[list[int], Array]:
    """Return the position-level rows, and where each part of y ends."""
    residual = [] if not system.rows else system.program["constraint_residual"].function.entries
    holding = [k for k, entry in enumerate(residual) if not entry.is_zero]
    lengths = (system.nq, system.nu, int(system.works), system.rows, len(holding), len(system.quaternions))
    return holding, np.cumsum(lengths)


def _functions(system: StateEquations) -> Compiled:
    """Return F and its derivative in a direction, written on the graph of the system's program."""
    size = int(_layout(system)[1][-1])
    known = system.program["rates"].function.arguments
    graph = system.program.graph
    rates, way, turn = (argument(graph, name, size) for name in ("rates", "way", "turn"))
    state = {one.name: one.symbols for one in known}
    entries, moving = _entries(system, state, rates.symbols), (*state["q"], *state["qd"])
    ways = dict(zip((*moving, *rates.symbols), (*way.symbols[: len(moving)], *turn.symbols), strict=True))
    more = []
    if system.forces.fed:
        more = [argument(graph, "dtau", system.given_size)]
        ways |= dict(zip(state["tau"], more[0].symbols, strict=True))
    functions = (
        plain("residual", entries, (*known, rates)),
        plain("along", tangents(entries, ways), (*known, rates, way, turn, *more)),
    )
    return compiled(system.opened.scene, graph, functions)


def _entries(system: StateEquations, state: dict[str, tuple[Expr, ...]], rates: Sequence[Expr]) -> list[Expr]:
    """Return the entries of F in terms of q, u, τ, t and ẏ."""
    program, (holding, ends) = system.program, _layout(system)
    graph, w = program.graph, Workspace(system.opened.scene, system.opened.closing)
    cuts = [0, *ends]
    speed, acceleration, work, multipliers, nu, rho = (rates[i:j] for i, j in itertools.pairwise(cuts))
    moving = list(state["qd"])
    balance = w.forces(list(w.state.qdd))
    place = acting(w, system.forces)
    balance = [force - place[tau] for force, tau in zip(substitute(balance, place), w.state.tau, strict=True)]
    for k, given in zip(w.prescribed.place, substitute(w.prescribed.acceleration, place), strict=True):
        balance[k] = w.state.qdd[k] - given
    places = [graph.symbol(acceleration_name(name)) for name in system.scene.velocities]
    balance = substitute(substitute(balance, {}, graph), dict(zip(places, acceleration, strict=False)))
    held: list[Expr] = []
    if system.rows:
        G = np.full(system.rows * system.nv, graph.zero, dtype=object)
        G[list(system.filled)] = program["slopes"].function.entries
        rows = G.reshape(system.rows, system.nv)
        for k in w.prescribed.free:
            balance[k] = balance[k] - graph.total(row[k] * x for row, x in zip(rows, multipliers, strict=True))
            moving[k] = moving[k] + graph.total(rows[r][k] * x for r, x in zip(holding, nu, strict=True))
        residual = program["constraint_residual"].function.entries
        held = [*program["row_rates"].function.entries, *(residual[r] for r in holding)]
    moved = substitute(substitute(w.state.rates, {}, graph), dict(zip(state["qd"], moving, strict=True)))
    found = [one - other for one, other in zip(speed, moved, strict=True)]
    lengths = []
    for part, stretch in zip(system.quaternions, rho, strict=True):
        e = state["q"][part]
        found[part] = [one - x * stretch for one, x in zip(found[part], e, strict=True)]
        lengths.append(graph.total(x * x for x in e) - graph.one)
    own = substitute(substitute(w.state_rates, place), {}, graph)
    balance += [one - other for one, other in zip(acceleration[w.state.n :], own, strict=True)]
    power = [one - graph.total(program["power"].function.entries) for one in work]
    return [*found, *balance, *power, *held, *lengths]
