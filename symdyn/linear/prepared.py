"""The linear system at a state, A, B, C, D, from functions that are derived once for all values of parameters.

Derivatives along all directions are reduced to independent positions and velocities in numbers:

    N_h, N   δξ of all directions from the p independent ones; δu of all velocities from the m independent ones
    S        δu of the dependent velocities where positions move: G δu + X(G u) δξ = 0
    ad_u     (ad_u δξ)_l = γ^l_ji u_j δξ_i, of brackets [X_j, X_i] = γ^l_ji X_l

    δξ̇ = δu - ad_u δξ
    [M  -Pᵀ] [δu̇]     [X e δξ + ∂e/∂u δu + ∂e/∂w δw - δτ]
    [G   0 ] [δλ]  = -[X c δξ + ∂c/∂u δu                ]

The first equation varies a motion with its position, d/dt δ = δ d/dt, where directions do not commute. It stays the
same where positions depend on each other: the constraints hold for the varied motion too.

References: Bloch, Krishnaprasad, Marsden and Ratiu, The Euler-Poincaré equations and double bracket dissipation (1996),
section 2, for variations on a group; Negrut and Ortiz, A practical approach for the linearization of the constrained
multibody dynamics equations, J. Comput. Nonlinear Dynam. 1 (2006), for constraints.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import SympyExpression, argument
from symdyn.dynamics import LoopChoices
from symdyn.dynamics.loops import pivots
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import COLUMNS
from symdyn.errors import LinearizeError, NoValueError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, reachable
from symdyn.linear.contact_mode import Mode
from symdyn.linear.linearization import Linearization, Point
from symdyn.linear.variations import Outputs, Variations, read_outputs, variations
from symdyn.linear.weights import Axis
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Faults, force_unit, split_commas
from symdyn.simulation import Forces, Problem, opened, valueless

RANK = 1e-7
"""Singular values of rows of unit length, over the largest, below which rows depend on each other at a place."""

MASS = 1e-12
"""Eigenvalues of the reduced mass matrix with unit diagonal that are zero."""

CANCELLED = 1e-12
"""What is left of a force's slope, over it, where the mechanism's own cancels it: that of a weight compensated; and of
an output's own, where accelerations cancel each other, as of a body that only a spring ties to what is driven."""

WELL = 0.02
"""How well a choice of independent velocities has to determine the others, by singular values, to be kept."""


@dataclass(frozen=True)
class LinearPoint:
    """A state and what its accelerations are.

    Attributes:
        point: with accelerations and multipliers.
        values: of all symbols there.
        M, G: mass matrix of the tree, independent rows, those of contacts and of prescribed motions.
        P: generalized forces by a unit of each multiplier, shape (nu, rows): Gᵀ but for friction of what slips.
        holding: of G, which are position-level rows.
        H: q̇ = H u.
        sizes: of the velocities, 1/√M_kk, shape (nu,), to compare what is of different units.
    """

    point: Point
    values: Mapping[Expr, float]
    M: Array
    G: Array
    P: Array
    holding: Array
    H: Array
    sizes: Array


def place(v: Variations, parameters: Mapping[str, float], t: float, q: Array, u: Array, given: Array) -> LinearPoint:
    """Return what happens at a state, forces and inputs beside those of formulas `given`, shape (nv + inputs,).

    Raises:
        LinearizeError: loops or rows lose rank there, or a motion moves no mass.
        NoValueError: something has no value there.
    """
    scene, state = v.w.scene, v.w.state
    values = symbols_at(v, parameters, t, q, u, given)
    found = v.motion.at(values)
    n = state.n
    M, G, h = found["M"], found["G"], found["h"].copy()
    h[:n] -= given[:n]
    diagonal = np.abs(np.diag(M))
    sizes = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    free = _free(scene.name, G * sizes) * sizes[:, None]
    reduced = free.T @ M @ free
    if len(reduced) and np.linalg.eigvalsh(reduced)[0] <= MASS * max(1.0, float(np.abs(reduced).max())):
        k = int(np.abs(free @ np.linalg.eigh(reduced)[1][:, 0]).argmax())
        raise LinearizeError(
            f"{scene.name}: the mass matrix is singular there, a motion with {scene.first_order[k]} moves no mass; "
            "give another place, or a mass or an inertia"
        )
    a, multipliers = _solved(M, found["P"], G, h[:, None], found["b"][:, None])
    point = Point(t, q, u, a[:, 0], found["push"][:n] + given[:n], multipliers[:, 0], found["inputs"])
    values |= dict(zip(v.a, a[:, 0].tolist(), strict=True))
    values |= dict(zip(v.multipliers, multipliers[:, 0].tolist(), strict=True))
    return LinearPoint(point, values, M, G, found["P"], np.array(v.holding, dtype=bool), found["H"], sizes)


def symbols_at(
    v: Variations, parameters: Mapping[str, float], t: float, q: Array, u: Array, given: Array
) -> dict[Expr, float]:
    """Return values of all symbols at a state, forces and inputs beside formulas `given`; accelerations are zero."""
    graph, state = v.w.graph, v.w.state
    values: dict[Expr, float] = {graph.symbol(name): x for name, x in parameters.items()}
    values |= dict(zip(state.q, q.tolist(), strict=True)) | dict(zip(v.u, u.tolist(), strict=True))
    values |= dict.fromkeys([*v.a, *v.multipliers], 0.0)
    acting = (*state.tau, *map(graph.symbol, v.inputs))
    return values | dict(zip(acting, given.tolist(), strict=True)) | {graph.symbol(TIME): t}


def _free(name: str, G: Array) -> Array:
    """Return the velocities that rows allow, orthonormal, one a column."""
    if not len(G):
        return np.eye(G.shape[1])
    lengths = np.linalg.norm(G, axis=1, keepdims=True)
    _, values, rows = np.linalg.svd(G / np.where(lengths > 0, lengths, 1.0))
    if values[-1] <= RANK * values[0]:
        raise LinearizeError(
            f"{name}: a singular place: the rows of its loops depend on each other there, branches of motion meet, "
            "and there is no one linear motion; give another place"
        )
    return np.asarray(rows[len(G) :].T)


def _solved(M: Array, P: Array, G: Array, e: Array, c: Array) -> tuple[Array, Array]:
    """Return x and λ of M x - P λ = -e, G x = -c, a column each."""
    n, rows = len(M), len(G)
    K = np.block([[M, -P], [G, np.zeros((rows, rows))]])
    found = np.linalg.solve(K, -np.vstack([e, c]))
    return found[:n], found[n:]


@dataclass(frozen=True)
class Choice:
    """Independent positions and velocities by number of the velocity, and N_h (nv, p) and N (nv, m)."""

    positions: tuple[int, ...]
    velocities: tuple[int, ...]
    N_h: Array
    N: Array


def chosen(here: LinearPoint, requested: Sequence[int], n: int) -> Choice:
    """Return which positions and velocities are independent: velocities as wanted if they do, all of them positions.

    Of the nu velocities and states n are velocities; all states are independent.
    """
    dependent = [k for k in range(n) if k not in requested]
    scaled = here.G * here.sizes
    velocities = _dependent(scaled, dependent)
    return independent(here, _dependent(scaled[here.holding], velocities), velocities, n)


def independent(here: LinearPoint, positions: Sequence[int], velocities: Sequence[int], n: int) -> Choice:
    """Return what follows from dependent positions and velocities; states, behind the first n, have no positions."""
    free = tuple(k for k in range(n) if k not in positions)
    N_h, N = _followed(here.G[here.holding], positions)[:, : len(free)], _followed(here.G, velocities)
    return Choice(free, tuple(k for k in range(len(here.M)) if k not in velocities), N_h, N)


def _dependent(G: Array, requested: Sequence[int]) -> list[int]:
    """Return as many velocities as there are rows that these determine, those wanted if they do it well."""
    if not len(G):
        return []
    if len(requested) == len(G):
        here, best = (np.linalg.svd(part, compute_uv=False) for part in (G[:, list(requested)], G))
        if here[-1] >= WELL * best[-1]:
            return sorted(requested)
    others = list(reversed(range(G.shape[1])))
    return sorted(pivots(G.T, [list(requested), others] if requested else [others], len(G))[0])


def _followed(G: Array, dependent: Sequence[int]) -> Array:
    """Return all velocities in terms of the independent ones, shape (nv, those)."""
    n = G.shape[1]
    independent = [k for k in range(n) if k not in dependent]
    found = np.eye(n)[:, independent]
    if len(G):
        found[list(dependent)] = -np.linalg.solve(G[:, list(dependent)], G[:, independent])
    return found


@dataclass(frozen=True)
class Matrices:
    """A, B, C, D at a place; δq and δξ by position, δu by state; y there."""

    A: Array
    B: Array
    C: Array
    D: Array
    moves: Array
    directions: Array
    rates: Array
    y: Array


def matrices(v: Variations, here: LinearPoint, choice: Choice, drives: Sequence[int]) -> Matrices:
    """Return the linear system at a place, inputs being `drives` and then those of the scene."""
    n, p, inputs = len(here.M), len(choice.positions), len(drives) + len(v.inputs)
    slopes, seen = v.slopes.at(here.values), v.outputs.at(here.values)
    e, c, s = slopes["e"], slopes["c"], slopes["s"]
    e = np.where(np.abs(e) <= CANCELLED * np.abs(slopes["p"]), 0.0, e)
    states = p + len(choice.velocities)
    driven, own = np.zeros((len(v.w.state.tau), states + inputs)), np.zeros((len(v.inputs), states + inputs))
    for column, k in enumerate(drives):
        driven[k, states + column] = 1.0
    own[:, states + len(drives) :] = np.eye(len(v.inputs))
    moves, rates = np.zeros((n, states + inputs)), np.zeros((n, states + inputs))  # δξ and δu by (x, w)
    moves[:, :p], rates[:, p:states] = choice.N_h, choice.N

    def tie(found: Array, free: Sequence[int], G: Array, missed: Array) -> None:
        dependent = [k for k in range(len(driven)) if k not in free]
        if dependent:
            found[dependent] -= np.linalg.solve(G[:, dependent], missed)

    tie(moves, choice.positions, here.G[here.holding], (slopes["r"] @ own)[here.holding])
    tie(rates, choice.velocities, here.G, s @ np.vstack([moves, own]))
    moved = np.vstack([moves, rates])
    acting = e[:, 3 * n :] @ own
    acting[: len(driven)] -= driven
    a, multipliers = _solved(here.M, here.P, here.G, e[:, : 2 * n] @ moved + acting, c @ np.vstack([moved, own]))
    upper = rates - _turning(v, here.point.u) @ moves
    whole = np.vstack([upper[list(choice.positions)], a[list(choice.velocities)]])
    A, B = whole[:, :states], whole[:, states:]
    stack = np.vstack([moved, a, multipliers, driven, own])
    y = seen["y_"] @ stack
    y = np.where(np.abs(y) <= CANCELLED * (np.abs(seen["y_"]) @ np.abs(stack)), 0.0, y)
    parts = (A, B, y[:, :states], y[:, states:], here.H @ choice.N_h, choice.N_h, rates[:, :states], seen["y"])
    return Matrices(*(part + 0.0 for part in parts))  # -0 is 0


def _turning(v: Variations, u: Array) -> Array:
    found = np.zeros((len(u), len(u)))
    for (j, i), terms in v.w.directions.brackets.items():
        for k, value in terms:
            found[k, i] += value * u[j]
    return found


HELD = 1e-8
"""How far a contact may be from its plane, m or rad, or move against it, and still be closed."""

CORNER = 1e-12
"""What a sign is of, as far as it is zero."""


Looked: TypeAlias = str | Sequence[str | SympyExpression]
Asked: TypeAlias = tuple[Problem, Looked, Sequence[str], Mode]


@dataclass(frozen=True)
class Prepared:
    """What is linearised: a scene at its values under forces, and what is looked at; the functions are derived.

    It pickles: the other process derives them from what was `asked` of `prepared`.
    """

    scene: Scene
    forces: Forces
    outputs: Outputs
    functions: Variations
    independent: tuple[int, ...]
    asked: Asked

    def __reduce__(self) -> tuple[Callable[..., Prepared], tuple[object, ...]]:
        return _again, (self.asked, self.scene, self.forces)

    @property
    def drives(self) -> list[int]:
        """Velocities whose drives are inputs; a prescribed motion finds its own."""
        led = self.functions.w.prescribed.place
        return [k for k, drive in enumerate(self.scene.drives) if drive and k not in led]

    @property
    def timed(self) -> bool:
        """Whether time itself acts: in formulas of forces and loads, tables, and prescribed accelerations."""
        v = self.functions
        return bool(self.forces.tables) or v.w.graph.symbol(TIME) in v.motion.order

    def place(self, q: Array, u: Array, t: float = 0.0, given: Array | None = None) -> LinearPoint:
        """Return what happens at a state; forces, then inputs, are `given` in place of what tables say."""
        values = opened(self.scene).values
        size = len(self.scene.velocities) + len(self.scene.inputs)
        tables = self.forces.tabulated(np.asarray(t), size) if given is None else given
        try:
            with np.errstate(all="ignore"):
                return place(self.functions, values, t, q, u, tables)
        except NoValueError as fault:
            raise LinearizeError(self._valueless(fault, t, q, u)) from None

    def _valueless(self, fault: NoValueError, t: float, q: Array, u: Array) -> str:
        parts = (str(fault), valueless(self.scene, self.forces, t, q, u))
        return f"{self.scene.name}: {'; '.join(filter(None, parts))}"

    def kinematics(self, q: Array, t: float = 0.0) -> tuple[Array, Array]:
        """Return the rows that hold velocities, those of prescribed motions last, shape (rows, nv), and H: q̇ = H u."""
        v, still = self.functions, np.zeros(len(self.scene.first_order))
        nothing = np.zeros(len(self.scene.velocities) + len(self.scene.inputs))
        found = v.motion.at(symbols_at(v, opened(self.scene).values, t, q, still, nothing))
        return found["G"], found["H"]

    def at(
        self,
        q: Array,
        u: Array,
        t: float = 0.0,
        notes: Sequence[str] = (),
        given: Array | None = None,
        like: Linearization | None = None,
    ) -> Linearization:
        """Return the linear system at a state, of the same states as another one is; errors as of `linearize`."""
        v, scene = self.functions, self.scene
        here = self.place(q, u, t, given)
        pulling = self._in_mode(here)
        try:
            choice = chosen(here, self.independent, v.w.state.n) if like is None else self._like(here, like)
            with np.errstate(all="ignore"):  # what has no finite value is told below
                found = matrices(v, here, choice, self.drives)
        except NoValueError as fault:
            raise LinearizeError(self._valueless(fault, t, q, u)) from None
        except np.linalg.LinAlgError:
            raise LinearizeError(f"{scene.name}: independent states do not determine the others there") from None
        for matrix in (found.A, found.B, found.C, found.D):
            if not np.isfinite(matrix).all():
                raise LinearizeError(
                    f"{scene.name}: a derivative has no finite value there; give another place, or other values"
                )
        units, labels, told = SceneUnits(scene).velocities, COLUMNS["q"](v.w), SceneUnits(scene).inferred
        shown = scene.shown_unit
        speeds = (*(shown(f"{unit}/s") for unit in units), *(told[one.name] for one in scene.states))
        states = Axis(
            (*(labels[k] for k in choice.positions), *(scene.first_order[k] for k in choice.velocities)),
            (*(shown(units[k]) for k in choice.positions), *(speeds[k] for k in choice.velocities)),
        )
        inputs = Axis(
            (*(str(scene.drives[k]) for k in self.drives), *v.inputs),
            (*(shown(force_unit(units[k])) for k in self.drives), *(told[one.name] for one in scene.inputs)),
        )
        return Linearization(
            found.A, found.B, found.C, found.D, states, inputs, Axis(self.outputs.names, self.outputs.units), None,
            scene.name, scene, replace(here.point, outputs=found.y), len(choice.positions), found.moves,
            found.directions[: len(units)], found.rates[: len(units)], notes=(*notes, *pulling, *self._corners(here)),
            feeding=self._feeding(here, given), prepared=self,
        )  # fmt: skip

    def _in_mode(self, here: LinearPoint) -> list[str]:
        """Return which contacts pull there; LinearizeError where one that is closed is apart, or moves apart."""
        contacts, found = self.functions.contacts, self.functions.motion.at(here.values)
        for k, name in contacts.items():
            if max(abs(float(found["r"][k])), abs(float(found["s"][k]))) > HELD:
                apart = f"its gap is {found['r'][k]:.3g}, and velocities along its row {found['s'][k]:.3g}"
                raise LinearizeError(
                    f"{self.scene.name}: {name} is not held at this point: {apart}; give another start"
                )
        pulls = {name: here.point.multipliers[k] for k, name in sorted(contacts.items(), reverse=True)}
        return [f"{name} pulls there, {x:.6g} N: its mode ends at once" for name, x in pulls.items() if x < -HELD]

    def _feeding(self, here: LinearPoint, given: Array | None) -> tuple[float, ...]:
        """Return the forces at a place, those `given` apart, if formulas of them depend on the state."""
        state, formulas = {*self.scene.coordinates, *self.scene.first_order}, self.forces.formulas
        n = len(self.scene.velocities)
        led = [k for k in formulas if k < n and not self.scene.drives[k]]
        if not led and not any(state.intersection(one.symbols) for one in formulas.values()):
            return ()
        found = np.concatenate([here.point.tau, here.point.inputs])
        return tuple((found - (0.0 if given is None else given)).tolist())

    def _corners(self, here: LinearPoint) -> list[str]:
        """Return what is said of signs and absolute values that turn over at a place."""
        corners = self.functions.corners
        (_, nodes), values = corners.parts["of"], corners.at(here.values)["of"]
        known = {*self.scene.coordinates, *self.scene.first_order}
        turned = (node for node, x in zip(nodes, values.tolist(), strict=True) if abs(x) <= CORNER)
        names = dict.fromkeys(
            str(one.value) for node in turned for one in reachable([node]) if one.op is Op.SYMBOL and one.value in known
        )
        if not names:
            return []
        return [
            f"one-sided: a sign or an absolute value of {', '.join(names)} turns over here; A takes signs for constant "
            "and absolute values for flat, which dry friction at rest is not"
        ]

    def _like(self, here: LinearPoint, other: Linearization) -> Choice:
        names, labels = self.scene.velocities, COLUMNS["q"](self.functions.w)
        p = other.positions
        positions = [k for k, name in enumerate(labels) if name not in other.states.names[:p]]
        velocities = [k for k, name in enumerate(names) if name not in other.states.names[p:]]
        return independent(here, positions, velocities, len(names))


def prepared(
    problem: Problem, outputs: Looked = (), independent: str | Sequence[str] = (), mode: Mode = ()
) -> Prepared:
    """Return what is linearised, derived once for all values of parameters; arguments and errors as of `linearize`."""
    independent = tuple(split_commas(independent) if isinstance(independent, str) else independent)
    scene, faults = problem.scene, Faults("")
    found = opened(scene)
    if not scene.velocities:
        raise LinearizeError(f"{scene.name}: nothing moves: no joint has a coordinate")
    if independent and not scene.is_constrained:
        why = "it has no loops and no rows, all its coordinates are independent"
        why = "states of a mode are those that determine the others best" if mode else why
        raise LinearizeError(f"{scene.name}: {argument('independent')}: {why}; leave {argument('independent')} out")
    forces = problem.driving
    forces.check_differentiable(faults)
    faults.close(LinearizeError)
    looked = read_outputs(scene, outputs)
    closing = LoopChoices(tuple(independent), parameters=found.closing.parameters)
    if not scene.is_constrained:
        closing = LoopChoices()  # nothing is decided in numbers, and one derivation serves all values
    usual = {k: one.value for k, one in enumerate(scene.inputs, len(scene.velocities)) if k not in forces.outside}
    v = variations(found.scene, closing, tuple((usual | dict(forces.formulas)).items()), looked.formulas, mode)
    every = range(len(scene.velocities))
    wanted = v.w.loops.decisions.partition.independent if scene.is_constrained else every
    kept, asked = tuple(k for k in wanted if k not in v.w.prescribed.place), (problem, outputs, independent, mode)
    return Prepared(scene, forces, looked, v, kept, asked)


def _again(asked: Asked, scene: Scene, forces: Forces) -> Prepared:
    return replace(prepared(*asked), scene=scene, forces=forces)
