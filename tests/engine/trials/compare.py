"""What symdyn says against what the reference says, output by output.

    given        the motion that inverse dynamics is asked about, one that the mechanism may make
    found        the motion that drives make, of which forward dynamics is asked
    f            forces of the spanning tree, M u̇ + h: what drives, loops and rows together exert on the velocities
    N            motions that loops, wheels and blades leave free: G N = 0

What a motion does not determine is compared as far as it is determined: reactions up to what may be added to them
without moving anything, multipliers as the force Gᵀλ that they make, drives by the work that they do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from ..balance import Solution, balance
from ..jets import Jet, number, value
from ..joints import tilde
from ..mechanism import Array, State
from ..states import free_motions, rows
from .cases import Case, draw
from .code import CENTROIDAL, Code
from .options import choice

TOLERANCE = {"double": 1e-8, "float": 1e-2}
"""Errors over the largest entry that are allowed."""

UNIQUE = 1e-8

NEAR = {"double": 1e-3, "float": 0.1}
"""Smallest singular value over the largest at which forces are compared; below, the digits are lost by right."""


class Truth:
    """What the reference says of one state."""

    def __init__(self, case: Case, k: int) -> None:
        """Draw the drives and the motion that are asked about."""
        self.case, self.m = case, case.mechanism
        self.q, self.u, self.t = case.states[k]
        rng = np.random.default_rng([case.seed, k])
        self.n = len(self.m.names)
        self.closed = self.m.scene.is_constrained
        self.still: State = self.m.at(self.q, self.u, t=self.t)
        known = np.array([k in case.driven or not self.closed for k in range(self.n)])
        self.tau = np.where(known, rng.uniform(-5, 5, self.n), 0.0)
        self.random = rng.uniform(-1, 1, self.n)

    @cached_property
    def free(self) -> list[int]:
        """Velocities that are not locked."""
        return [k for k in range(self.n) if k not in self.case.held]

    @cached_property
    def G(self) -> Array:
        """All rows on the velocities."""
        return rows(self.still)

    @cached_property
    def N(self) -> Array:
        """Motions that are left free, (nv, freedoms)."""
        N = np.zeros((self.n, 0))
        basis = free_motions(self.G[:, self.free])
        N = np.zeros((self.n, basis.shape[1]))
        N[self.free] = basis
        return N

    @cached_property
    def led(self) -> dict[int, Jet]:
        """Prescribed motions by velocity."""
        joints = [joint for joint in self.m.scene.joints if joint.motion is not None]
        clock = {**self.m.values, "t": Jet(self.t, 1.0)}
        return {
            self.m.names.index(j.rates[0]): value(j.motion, clock) for j in joints if j.name not in self.case.locked
        }

    @cached_property
    def found(self) -> Solution:
        """The motion that the drives make."""
        du, tau = np.full(self.n, np.nan), self.tau.copy()
        for k, motion in self.led.items():
            du[k], tau[k] = motion.a, np.nan
        du[list(self.case.held)], tau[list(self.case.held)] = 0.0, np.nan
        return balance(self.still, du, tau)

    @cached_property
    def moves(self) -> bool:
        """Whether that motion is determined."""
        return not self.singular and np.abs(self.found.loose[0]).max(initial=0.0) < UNIQUE and self.found.missed < 1e-8

    @cached_property
    def singular(self) -> bool:
        """Whether the angles of a joint are singular, or rows nearly dependent: too near for the digits there are."""
        S, joints = self.still.tree[1], enumerate(self.m.scene.joints)
        parts = [S[6 * k : 6 * k + 6, list(self.m.own_rates(joint))] for k, joint in joints]
        ratios = [s[-1] / s[0] for one in parts if one.size for s in [np.linalg.svd(one, compute_uv=False)]]
        if self.case.rank:
            s = np.linalg.svd(self.G[:, self.free], compute_uv=False)
            ratios.append(s[self.case.rank - 1] / s[0])
        return min(ratios, default=1.0) < NEAR[self.case.choice["real"]]

    @cached_property
    def possible(self) -> bool:
        """Whether the motion that is given is one that the mechanism makes; rows on singular angles tell nothing."""
        return self.given.missed < 1e-8 and not (self.closed and self.singular)

    @cached_property
    def given(self) -> Solution:
        """The forces of a motion: any in a tree; one with drives for all freedoms, or one that its drives make."""
        held = list(self.case.held)
        if not self.closed:
            du, tau = self.random.copy(), np.full(self.n, np.nan)
            du[held] = 0.0
            return balance(self.still, du, tau)
        du = self.found.du.copy()
        if len(self.case.driven) == self.N.shape[1]:
            du = du + self.N @ self.random[: self.N.shape[1]]
        tau = np.zeros(self.n)
        tau[[*self.case.driven, *held]] = np.nan
        return balance(self.still, du, tau)

    @cached_property
    def armature(self) -> Array:
        """Rotors' part of the mass matrix."""
        own = self.still.tree[2]
        return own.T @ self.still.rotors()[0] @ own

    @cached_property
    def M(self) -> Array:
        """Mass matrix of the spanning tree."""
        return self.still.columns.T @ self.still.inertias()[0] @ self.still.columns + self.armature

    def massless(self, u: list[int]) -> bool:
        """Whether some motion of the spanning tree moves no mass."""
        sizes = np.linalg.eigvalsh(self.M[np.ix_(u, u)]) if u else np.ones(1)
        return bool(sizes[0] < 1e-12 * sizes[-1])

    @cached_property
    def c(self) -> Array:
        """Velocity forces of the spanning tree."""
        M, b = self.still.inertias()
        return self.still.columns.T @ (M @ self.still.twists()[1] + b) + self.still.tree[2].T @ self.still.rotors()[1]

    def on_velocities(self, acting: tuple[Array, Array]) -> Array:
        """Return the force along velocities of wrenches on bodies and forces at joints."""
        return self.still.columns.T @ acting[0] + self.still.tree[2].T @ acting[1]

    @cached_property
    def gravity(self) -> Array:
        """Gravity forces."""
        return -self.still.columns.T @ self.still.weights()

    @cached_property
    def elastic(self) -> Array:
        """Elastic forces."""
        return -self.on_velocities(self.still.pulls())

    def tree_forces(self, du: Array) -> Array:
        """Return f."""
        return self.M @ du + self.c + self.gravity + self.elastic - self.on_velocities(self.still.drags())

    def axes(self, kind: str) -> list[Array]:
        """Return, for every joint and loop, the rotation from the axes of its reaction to the ground."""
        scene, R = self.m.scene, []
        contacts = self.still.contacts()
        for joint in scene.joints:
            J = (
                self.still.P if joint.name in self.locked else self.still.J
            )  # a locked one is a fixed one where it stands
            R.append({"body": self.still.T[joint.child], "joint": J[joint.name]}.get(kind, Jet(np.eye(4))).x[:3, :3])
        for contact in contacts[: len(scene.loops)]:
            R.append({"joint": contact.frames[0], "body": contact.frames[1]}.get(kind, np.eye(3)))
        return R

    @cached_property
    def locked(self) -> list[str]:
        """Joints that cannot move: locked ones, and those that follow them."""
        still = {q for j in self.m.scene.joints if j.name in self.case.locked for q in j.coordinates}
        return [
            j.name
            for j in self.m.scene.joints
            if j.name in self.case.locked or (j.coupling and still.issuperset(j.coupling.coordinates))
        ]

    def turned(self, wrenches: Array, kind: str) -> Array:
        """Return wrenches in axes of a kind."""
        return np.array(
            [np.concatenate([w[:3] @ R, w[3:] @ R]) for w, R in zip(wrenches, self.axes(kind), strict=True)]
        )


Compared = tuple[Truth, Any, Any, float]  # of which state, symdyn's, the reference's, size of what they are made of


class Trial:
    """One case, symdyn beside the reference.

    Attributes:
        worst: largest error of every output, over the largest entry.
    """

    def __init__(self, case: Case) -> None:
        """Make the code."""
        self.case, self.code = case, Code(case)
        self.truths = [Truth(case, k) for k in range(len(case.states))]
        self.tolerance = TOLERANCE[case.choice["real"]]
        self.worst: dict[str, float] = {}

    def complaints(self) -> Iterator[str]:
        """Yield what differs, an output a line."""
        yield from (f"{request} raises {why}" for request, why in self.code.broken.items())
        for request, why in self.code.refused.items():
            if not self.justified(request.partition(":")[0]):
                yield f"{request} is refused: {why}"
        for request in self.code.calls:
            with np.errstate(all="ignore"):
                for truth, got, want, scale in COMPARED[request.partition(":")[0]](self, request):
                    off = np.abs(np.asarray(got) - want).max(initial=0.0)
                    error = off / max(1.0, scale, np.abs(want).max(initial=0.0))
                    self.worst[request] = max(self.worst.get(request, 0.0), error)
                    if not error <= self.tolerance:
                        by = self.code.formulations[request]
                        yield f"{request} ({by}): error {error:.2g}\n{told(truth, got, want)}"
                        break

    def partition_holds(self, truth: Truth) -> bool:
        """Tell whether the rows and velocities that were chosen once still determine the others here."""
        if "velocities" not in self.code.chosen:
            return True
        G = np.asarray(self.called("constraint_jacobian", [truth])[0], float).reshape(-1, len(self.code.u))
        chosen = self.code.chosen["velocities"]
        square = G[:, [i for i, k in enumerate(self.code.u) if self.case.mechanism.names[k] not in chosen]]
        if not square.size:
            return True
        least = float(np.linalg.svd(square, compute_uv=False)[-1])
        return least > NEAR[self.case.choice["real"]] * float(np.linalg.norm(G, 2))

    def justified(self, name: str) -> bool:
        """Tell whether an output may have no code."""
        ideal = any(
            j.dry is not None and not number(j.dry.smoothing, self.case.values)
            for j in self.case.mechanism.scene.joints
        )
        held = self.truths[0].closed and all(truth.singular for truth in self.truths)  # loops hold angles singular
        lost = ideal or not any(truth.moves for truth in self.truths)
        loose = all(len(truth.given.loose[2]) for truth in self.truths)
        return held or {
            "positions": True,  # few loops have a closed form
            "forward_dynamics": lost, "drive_forces": lost, "multipliers": lost, "constraint_forces": lost,
            "hamiltonian": self.truths[0].massless(self.code.u),
            "reactions": loose, "forward_reactions": loose or lost,
            **dict.fromkeys(CENTROIDAL, not centre(self.truths[0])[0]),
        }.get(name, False)  # fmt: skip

    def called(self, request: str, truths: list[Truth], solution: str = "given", **more: Any) -> Array:
        """Return a function at states, with the motion that is given or found."""
        known: dict[str, Any] = {
            "q": [x.q for x in truths], "u": [x.u for x in truths], "t": [x.t for x in truths],
            "du": [getattr(x, solution).du for x in truths], "tau": [x.tau for x in truths],
            "p": [x.M @ x.u for x in truths],
        }  # fmt: skip
        return self.code(request, **known | more)


def told(truth: Truth, got: Any, want: Any) -> str:
    """Return a state and both answers."""
    names = (*truth.m.scene.coordinates, *truth.m.names)
    place = ", ".join(f"{name} = {float(x)!r}" for name, x in zip(names, (*truth.q, *truth.u), strict=True))
    answers = [f"    {who}: {np.asarray(x).round(9).tolist()}" for who, x in (("symdyn   ", got), ("reference", want))]
    return "\n".join([f"    at {place}, t = {truth.t!r}", *answers])


Comparison = Callable[[Trial, str], Iterator[Compared]]


def equal(want: Callable[[Truth], Any], on: str = "") -> Comparison:
    """Compare entry by entry; `on` says of what: "velocities", "pairs" of them, or everything."""

    def compared(trial: Trial, request: str) -> Iterator[Compared]:
        u = trial.code.u
        for truth, got in zip(trial.truths, trial.called(request, trial.truths), strict=True):
            right = np.asarray(want(truth))
            yield truth, got, right[u] if on == "velocities" else right[np.ix_(u, u)] if on == "pairs" else right, 0.0

    return compared


def forces_of(want: Callable[[Truth], Array]) -> Comparison:
    """Compare forces along velocities."""
    return equal(want, "velocities")


def hamiltonian(trial: Trial, request: str) -> Iterator[Compared]:
    """Compare H of momenta, where these say how fast all moves."""
    for truth, got, want, size in equal(lambda x: x.u @ x.M @ x.u / 2 + potential(x))(trial, request):
        if not truth.massless(trial.code.u):
            yield truth, got, want, size


def inverse(trial: Trial, request: str) -> Iterator[Compared]:
    """Compare driving forces where they are unique, else the work that they do on free motions."""
    u, case = trial.code.u, trial.case
    for truth, got in zip(trial.truths, trial.called(request, trial.truths), strict=True):
        size = np.abs(truth.given.wrenches).max(initial=0.0)
        if not truth.possible:
            continue
        unique = np.abs(truth.given.loose[1]).max(axis=0, initial=0.0)[u] < UNIQUE
        if not truth.closed or case.driven:
            yield truth, got[unique], truth.given.tau[u][unique], size
        if truth.closed:
            yield truth, truth.N[u].T @ got, truth.N.T @ truth.tree_forces(truth.given.du), size


def found(want: Callable[[Solution], Array]) -> Comparison:
    """Compare what forward dynamics gives, where it is determined."""

    def compared(trial: Trial, request: str) -> Iterator[Compared]:
        some = [truth for truth in trial.truths if truth.moves and trial.partition_holds(truth)]
        if some:
            for truth, got in zip(some, trial.called(request, some, "found"), strict=True):
                yield truth, got, want(truth.found)[trial.code.u], 0.0

    return compared


def constraint_forces(trial: Trial, request: str) -> Iterator[Compared]:
    """Compare the force that rows exert."""
    some, u = [truth for truth in trial.truths if truth.moves and trial.partition_holds(truth)], trial.code.u
    for truth, got in zip(some, trial.called(request, some, "found") if some else (), strict=True):
        want = truth.tree_forces(truth.found.du) - truth.found.tau
        yield truth, got, want[u], np.abs(truth.found.wrenches).max()


def multipliers(trial: Trial, request: str) -> Iterator[Compared]:
    """Compare the force that multipliers make."""
    some, u = [truth for truth in trial.truths if truth.moves and trial.partition_holds(truth)], trial.code.u
    if some:
        G, sizes = trial.called("constraint_jacobian", some), trial.called(request, some, "found")
        for truth, rows_there, lam in zip(some, G, sizes, strict=True):
            want = truth.tree_forces(truth.found.du) - truth.found.tau
            yield truth, rows_there.T @ lam, want[u], np.abs(truth.found.wrenches).max()


def products(trial: Trial, request: str) -> Iterator[Compared]:
    """Compare C u, or k_D u² + k_C u u, with velocity forces."""
    u, truths = trial.code.u, trial.truths
    if request == "coriolis_matrix":
        found = [C @ truth.u[u] for C, truth in zip(trial.called(request, truths), truths, strict=True)]
    else:
        parts = zip(trial.called("k_D", truths), trial.called("k_C", truths), truths, strict=True)
        n = len(u)
        pairs = [(i, j) for i in range(n) for j in range(i + 1, n)]
        found = []
        for D, C, truth in parts:
            v = truth.u[u]
            found.append(D @ v**2 + C.reshape(n, -1) @ np.array([v[i] * v[j] for i, j in pairs]))
    for truth, got in zip(truths, found, strict=True):
        yield truth, got, truth.c[u], 0.0


def reactions(trial: Trial, request: str) -> Iterator[Compared]:
    """Compare whole wrenches, up to what may be added to them without moving anything."""
    name, _, kind = request.partition(":")
    solution = "found" if name == "forward_reactions" else "given"
    forward = solution == "found"
    some = [x for x in trial.truths if (x.moves and trial.partition_holds(x) if forward else x.possible)]
    if not some:
        return
    scene, told = trial.case.mechanism.scene, trial.code.scene
    names = [joint.name for joint in (*told.joints, *told.loops)]
    order = [names.index(joint.name) for joint in (*scene.joints, *scene.loops)]
    for truth, found in zip(some, trial.called(request, some, solution), strict=True):
        got = found[order]
        one: Solution = getattr(truth, solution)
        want, size = truth.turned(one.wrenches, kind or "body"), np.abs(one.wrenches).max(initial=0.0)
        off = (got - want).ravel()
        B = np.array([truth.turned(w, kind or "body").ravel() for w in one.loose[2]]).reshape(-1, off.size)
        if len(B) and np.isfinite(off).all():
            off = off - B.T @ np.linalg.lstsq(B.T, off, rcond=1e-9)[0]
        yield truth, want + off.reshape(want.shape), want, size


def forbidden(trial: Trial, request: str) -> Iterator[Compared]:
    """Rows forbid what the reference forbids, no more and no less."""
    u = trial.code.u
    for truth, found in zip(trial.truths, trial.called(request, trial.truths), strict=True):
        G = found.reshape(-1, len(u))
        yield truth, G @ truth.N[u], np.zeros((len(G), truth.N.shape[1])), np.abs(G).max(initial=0.0)
        yield truth, len(G), trial.case.rank, 0.0


def bias(trial: Trial, request: str) -> Iterator[Compared]:
    """G u̇ + Ġ u vanishes for motions that are possible."""
    u, truths = trial.code.u, trial.truths
    G, gamma = trial.called("constraint_jacobian", truths), trial.called(request, truths)
    for truth, rows_there, rest in zip(truths, G, gamma, strict=True):
        if truth.possible:
            carried = rows_there.reshape(-1, len(u)) @ truth.given.du[u]
            yield truth, -rest, carried, np.abs(truth.given.du).max()


def velocities(trial: Trial, request: str) -> Iterator[Compared]:
    """Independent velocities give all of them."""
    places = [trial.case.mechanism.names.index(name) for name in trial.code.chosen[request]]
    some = [truth for truth in trial.truths if trial.partition_holds(truth)]
    if some:
        given = [truth.u[places] for truth in some]
        for truth, got in zip(some, trial.called(request, some, ui=given), strict=True):
            yield truth, got, truth.u[trial.code.u], 0.0


def positions(trial: Trial, request: str) -> Iterator[Compared]:
    """The independent coordinate gives a closed position, near the start the one that it comes from."""
    places = [trial.case.mechanism.scene.coordinates.index(name) for name in trial.code.chosen[request]]
    some = trial.truths[:1]
    for truth, got in zip(some, trial.called(request, some, qi=[x.q[places] for x in some]), strict=True):
        yield truth, got, truth.q[trial.code.q], 0.0


def placed(truth: Truth) -> Jet:
    """Return the placement of the last body."""
    return truth.still.T[truth.m.bodies[-1]]


def centre_acceleration(truth: Truth) -> Array:
    """Return the acceleration of the last body's centre of mass in the given motion."""
    body = truth.m.scene.bodies[-1]
    T = truth.m.at(truth.q, truth.u, truth.given.du, truth.t).T[body.name]
    return (T[:3, :3] @ truth.m.vector(body.com) + T[:3, 3]).a


def potential(truth: Truth) -> float:
    """Return P, without springs at joints that are locked, which go."""
    state, locked = truth.still, truth.locked
    total = sum(state.stored(one) for one in truth.m.scene.struts if one.kind == "spring" and one.joint not in locked)
    for body in truth.m.bodies:
        m, h, _ = truth.m.inertia[body]
        T = state.T[body].x
        total -= truth.m.gravity @ (m * T[:3, 3] + T[:3, :3] @ h)
    return total


def closed_form_rows(truth: Truth) -> Array:
    """Return prescribed positions, velocities and accelerations."""
    return np.array([[getattr(one, part) for _, one in sorted(truth.led.items())] for part in ("x", "v", "a")], float)


def moving(truth: Truth) -> list[int]:
    """Return the places of the bodies that move."""
    moves = {"ground": False}
    for joint in truth.m.scene.joints:
        free = bool(joint.rates or joint.coupling) and joint.name not in truth.locked
        moves[joint.child] = moves[joint.parent] or free
    return [k for k, body in enumerate(truth.m.bodies) if moves[body]]


def centre(truth: Truth) -> tuple[float, Array]:
    """Return mass and centre of mass of the bodies that move."""
    m, h = 0.0, np.zeros(3)
    for body in (truth.m.bodies[k] for k in moving(truth)):
        (mass, first, _), T = truth.m.inertia[body], truth.still.T[body].x
        m, h = m + mass, h + mass * T[:3, 3] + T[:3, :3] @ first
    return m, h / m if m else h


def about_centre(truth: Truth, parts: Array) -> Array:
    """Return the sum of momenta, or of wrenches, of the bodies that move, (6n, …): about their centre of mass."""
    total, (_, C) = np.zeros((6, *parts.shape[1:])), centre(truth)
    for k in moving(truth):
        linear, angular = parts[6 * k : 6 * k + 3], parts[6 * k + 3 : 6 * k + 6]
        arm = truth.still.T[truth.m.bodies[k]].x[:3, 3] - C
        total += np.concatenate([linear, angular + np.tensordot(tilde(arm), linear, 1)])
    return total


def momentum_matrix(truth: Truth) -> Array:
    """Return the matrix of momentum about the centre of mass, of all velocities."""
    return about_centre(truth, truth.still.inertias()[0] @ truth.still.columns)


def momentum_bias(truth: Truth) -> Array:
    """Return the rate of momentum that velocities alone make."""
    M, b = truth.still.inertias()
    return about_centre(truth, M @ truth.still.twists()[1] + b)


def columns(want: Callable[[Truth], Array]) -> Comparison:
    """Compare matrices with a column for every velocity."""
    return lambda trial, request: (
        (truth, got, want(truth)[:, trial.code.u], 0.0)
        for truth, got in zip(trial.truths, trial.called(request, trial.truths), strict=True)
    )


COMPARED: Mapping[str, Comparison] = {
    "centre_of_mass": equal(lambda x: centre(x)[1]),
    "centre_of_mass_jacobian": columns(lambda x: momentum_matrix(x)[:3] / centre(x)[0]),
    "centroidal_momentum_matrix": columns(momentum_matrix),
    "centroidal_momentum_bias": equal(momentum_bias),
    "inverse_dynamics": inverse,
    "forward_dynamics": found(lambda one: one.du),
    "drive_forces": found(lambda one: one.tau),
    "mass_matrix": equal(lambda x: x.M, "pairs"),
    "k_z": equal(lambda x: x.M, "pairs"),
    "velocity_forces": forces_of(lambda x: x.c),
    "gravity_forces": forces_of(lambda x: x.gravity),
    "k_G": forces_of(lambda x: x.gravity),
    "elastic_forces": forces_of(lambda x: x.elastic),
    "k_E": forces_of(lambda x: x.elastic),
    "tree_forces": forces_of(lambda x: x.tree_forces(x.given.du)),
    "momentum": forces_of(lambda x: x.M @ x.u),
    "kinetic_energy": equal(lambda x: x.u @ x.M @ x.u / 2),
    "potential_energy": equal(potential),
    "hamiltonian": hamiltonian,
    "gibbs_function": equal(lambda x: x.given.du @ (x.M @ x.given.du / 2 + x.c)),
    "prescribed_motion": equal(closed_form_rows),
    "coriolis_matrix": products,
    "k_C": products,
    "k_D": products,
    "coordinate_rates": lambda trial, request: (
        (truth, got, truth.still.rates[trial.code.q], 0.0)
        for truth, got in zip(trial.truths, trial.called(request, trial.truths), strict=True)
    ),
    "pose": equal(lambda x: placed(x).x[:3, :4]),
    "jacobian": columns(lambda x: x.still.columns[-6:]),
    "jdot_qdot": equal(lambda x: x.still.twists()[1][-6:]),
    "velocity": equal(lambda x: x.still.twists()[0][-6:]),
    "acceleration": equal(lambda x: x.still.columns[-6:] @ x.given.du + x.still.twists()[1][-6:]),
    "com_acceleration": equal(centre_acceleration),
    "constraint_residual": lambda trial, request: (
        (truth, got, np.zeros_like(got), 0.0)
        for truth, got in zip(trial.truths, trial.called(request, trial.truths), strict=True)
    ),
    "constraint_jacobian": forbidden,
    "constraint_bias": bias,
    "constraint_forces": constraint_forces,
    "multipliers": multipliers,
    "velocities": velocities,
    "positions": positions,
    "reactions": reactions,
    "forward_reactions": reactions,
}


def report(seed: int) -> str:
    """Return what differs in a trial, with the scene and how to run it again; "" where nothing does."""
    case = draw(seed, choice(seed))
    found = list(Trial(case).complaints())
    if not found:
        return ""
    values = "".join(f"# {name} = {x!r}\n" for name, x in case.values.items())
    closing = f"# independent: {', '.join(case.independent)}\n" if case.independent else ""
    again = f"# again: cd tests && python -m engine {seed}\n# {case.choice}\n{values}{closing}"
    return "\n".join([again + case.text, *found])
