"""Contacts at natural states, in numbers: laws with inequalities, of which no proof knows, each by two roads.

States are where one contact touches, and where all of them do (two corners at once, feet that hold the same), each
struck, grazed and at rest. There are compared

    impulses of all cases with those of Lemke's pivots; without friction with Gauss' principle of least constraint,
        min |x|  with  F x ≥ h,    D = F F,  h = -(1 + e) n u⁻,  by Lawson and Hanson's method of least distance
    kinetic energy before and behind with what impulses take, -Λ·(v⁻ + v⁺)/2
    accelerations of what sticks with those of the mechanism whose rows are constraints
    derivatives of a run across an impact, by saltation matrices, with differences of runs

and from its start the scene runs for a second: its laws are kept at every row, and energy is balanced.

References: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 6 and 8; Lawson and
Hanson, Solving Least Squares Problems (1974), chapter 23.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.outputs import lacks_modes, unilaterals_of, with_modes
from symdyn.errors import SimulateError, SymdynError
from symdyn.frozen import dataclass, field, replace
from symdyn.scene import Scene
from symdyn.scene.values import Contact, Unilateral
from symdyn.simulation.equations.complementarity import FEW, FREE, STICK, Case, Laws, least
from symdyn.simulation.equations.contact_modes import NEAR, STRIKES, Contacts, Numbers
from symdyn.simulation.equations.settling import part
from symdyn.simulation.equations.system import Projection, StateEquations
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.forward import Control, ready, simulate
from symdyn.simulation.initial import Start
from symdyn.simulation.prescribed.forces import Forces
from symdyn.simulation.problem import Problem
from symdyn.simulation.variations import sensitivity

SAME, CLOSE = 1e-8, 1e-6
"""A difference of two roads, over the largest number of it, that is one of rounding; and one of differences of runs."""

STEPS, SOON, WIDTH = 8, 0.01, 1e-4
"""Of Newton's method to where gaps are zero; before an impact, s; and of differences of runs."""

PIVOTS, GAUSS = "impact: all cases = Lemke's pivots", "impact without friction = Gauss' principle"
LAWS = "impact: laws of contact and friction"
ENERGY = "impact: kinetic energy lost = what impulses take, never below 0"
STUCK, SLOPES = "sticking contacts = the mechanism with their rows", "saltation matrix = differences of runs"
ROWS, BALANCE = "run of 1 s: laws of contact at every row", "run of 1 s: balance of energy"

STRUCK = "struck"

Looked = dict[str, dict[str, bool]]
"""Whether a claim holds, place by place."""


@dataclass(frozen=True)
class _Place:
    """A state: where it is, in words, what touches there, velocities alone, and all contacts in numbers."""

    where: str
    touching: tuple[int, ...]
    x: Array
    u: Array
    n: Numbers


@dataclass(frozen=True)
class _Checks:
    scene: Scene
    system: StateEquations
    contacts: Contacts
    begin: Array
    rng: np.random.Generator
    found: Looked = field(default_factory=dict)
    lacking: dict[str, str] = field(default_factory=dict)

    def tell(self, claim: str, where: str, missed: float, size: float = 0.0, allowed: float = SAME) -> None:
        self.found.setdefault(claim, {})[where] = bool(missed <= allowed * (1.0 + abs(size)))

    def with_velocities(self, x: Array, u: Array) -> Array:
        nq = self.system.nq
        return np.concatenate([x[:nq], u, x[nq + len(u) :]])

    def numbers(self, x: Array) -> Numbers:
        return self.contacts.numbers(self.system.evaluate("contacts", 0.0, x), self.system.nv)

    def places(self) -> Iterator[_Place]:
        """Yield states at which something touches."""
        normals = {k: n for k, (n, _) in enumerate(self.contacts.rows) if n is not None}
        wanted = {f"where {self.contacts.name(k)} touches": [k] for k in normals}
        for where, some in (wanted | {"where all touch": [*normals]}).items() if len(normals) > 1 else wanted.items():
            x, found = self._touched(some, [normals[k] for k in some])
            touching = tuple(k for k in normals if abs(found.gaps[k]) <= NEAR and found.able[k])
            if not {*some} <= {*touching} or not np.isfinite(found.W).all():
                continue
            rows = [normals[k] for k in touching]
            D, C, pushed = found.laws.D[np.ix_(rows, rows)], found.C[rows], self._pushed(x)
            grazing = pushed - C.T @ least(D, found.W[rows] @ pushed)
            struck = grazing - C.T @ least(D, np.ones(len(rows)))
            for how, u in ((STRUCK, struck), ("grazed", grazing), ("at rest", 0 * pushed)):
                y = self.with_velocities(x, u)
                yield _Place(f"{where}, {how}", touching, y, u, self.numbers(y))

    def _touched(self, some: list[int], rows: list[int]) -> tuple[Array, Numbers]:
        x = self.with_velocities(self.contacts.with_mode(self.begin, []), np.zeros(self.system.nv))
        closing, still = Projection(self.system, 1e-12), np.zeros(self.system.nu - self.system.nv)
        for _ in range(STEPS):
            found = self.numbers(x)
            step = -found.C[rows].T @ least(found.laws.D[np.ix_(rows, rows)], found.gaps[some])
            x[: self.system.nq] += self.system.calls["moved"](x[: self.system.nq], np.append(step, still))
            x = closing.projected(x)
        return x, self.numbers(x)

    def _pushed(self, x: Array) -> Array:
        """Return velocities that loops allow and prescribed motions do not know, shape (nv,), 1 at most."""
        q, u, _ = self.system.parts(x)
        none, rates = np.zeros(self.system.given_size), self.system.calls["rates"]
        some = np.append(self.rng.uniform(-1, 1, self.system.nv), none[self.system.nv :])
        found = (rates(q, u, some, 0.0) - rates(q, u, none, 0.0))[self.system.nq :][: self.system.nv]
        return np.asarray(found / np.abs(found).max(initial=1e-300))

    # What is compared there

    def impact(self, at: _Place) -> None:
        """Compare the impulses of an impact by all roads that there are."""
        laws, rows = part(at.n.laws, at.touching)
        laws = replace(laws, static=laws.friction)
        C, v, k = at.n.C[rows], at.n.W[rows] @ at.u, len(at.touching)
        normals = [n for n in laws.normals if n is not None]
        target, size = np.zeros(len(v)), float(np.abs(at.u).max())
        target[normals] = -laws.restitution * v[normals]
        if k <= FEW and max(map(len, laws.tangents)) < 2:
            options = [(FREE, *laws.slips(i)) for i in range(k)]
            pivots = laws.by_pivots(v, [0.0] * k, np.zeros(k), target)
            cases = [one for _, one in laws.solutions(v, options, None, target)]
            apart = [] if pivots is None else [float(np.abs(C.T @ (one - pivots)).max()) for one in cases]
            self.tell(PIVOTS, at.where, min(apart, default=np.inf), size)
        smooth = replace(laws, friction=0 * laws.friction, static=0 * laws.static).impact(v, [False] * k)
        gauss = _least_distance(laws.D[np.ix_(normals, normals)], target[normals] - v[normals])
        self.tell(GAUSS, at.where, float(np.abs(C.T @ smooth - C[normals].T @ gauss).max()), size)
        by_poisson = [self.contacts.laws[i] == "poisson" for i in at.touching]
        try:
            impulses = laws.impact(v, by_poisson)
        except ArithmeticError:
            self.tell(LAWS, at.where, np.inf)
            return
        after, u = v + laws.D @ impulses, at.u + C.T @ impulses
        self.tell(LAWS, at.where, _missed(laws, impulses, after, after - target, all(by_poisson)), size)
        lost = -float(impulses @ (v + after)) / 2
        if not self.scene.prescribed_velocities:  # what moves as it is told takes and gives energy, too
            states = at.x, self.with_velocities(at.x, u)
            before, then = (float(np.sum(self.system.evaluate("kinetic", 0.0, y))) for y in states)
            never = -lost if all(by_poisson) and np.ptp(laws.restitution) == 0 else 0.0
            self.tell(ENERGY, at.where, max(abs(before - then - lost), never), before)

    def stuck(self, at: _Place) -> None:
        """Compare accelerations of what sticks with those of the mechanism that has rows of constraints there."""
        laws = {one.name: one for one in unilaterals_of(self.scene)}
        rows = [row for k in at.touching if (row := laws[self.contacts.name(k)].closed) is not None]
        if self.scene.is_constrained or len(rows) < len(at.touching) or at.where.endswith(STRUCK):
            return
        rough = [bool(self.contacts.rows[k][1]) for k in at.touching]
        held = [
            replace(row, components=("normal",)) if isinstance(row, Contact) and not rubs else row
            for row, rubs in zip(rows, rough, strict=True)
        ]
        cases = [(k, Case(True, STICK if rubs else "")) for k, rubs in zip(at.touching, rough, strict=True)]
        own, nq, nv = with_modes(self.scene), self.system.nq, self.system.nv
        others = (one for one in own.elements if not isinstance(one, Unilateral))
        closed = replace(own, elements=(*others, *held), states=self.scene.states)
        kept = [n for k in at.touching for n in (self.contacts.rows[k][0], *self.contacts.rows[k][1]) if n is not None]
        u = at.u - at.n.C[kept].T @ least(at.n.laws.D[np.ix_(kept, kept)], at.n.W[kept] @ at.u)
        y = self.with_velocities(self.contacts.with_mode(at.x, cases), u)
        try:
            other = state_equations(closed, Forces(), (), y[:nq])
            with np.errstate(all="ignore"):
                by_rows = other.rates(0.0, np.append(y[: nq + other.nu], np.zeros(int(other.works))))[nq : nq + nv]
        except SymdynError as fault:
            self.lacking[STUCK] = str(fault)
            return
        by_mode = self.system.rates(0.0, y)[nq : nq + nv]
        self.tell(STUCK, at.where, float(np.abs(by_mode - by_rows).max()), float(np.abs(by_rows).max()))

    def slopes(self, at: _Place) -> None:
        """Compare a derivative of a run across an impact with differences of fourth order."""
        nq, nv = self.system.nq, self.system.nv
        q = at.x[:nq] - SOON * self.system.calls["moved"](at.x[:nq], at.x[nq : nq + self.system.nu])
        way = np.cos(1.0 + np.arange(2 * nv))

        def ended(step: float) -> Array:
            start = Start(q + step * way[:nv], at.u + step * way[nv:])
            run = simulate(Problem(self.scene, start=start), until=2 * SOON, rtol=1e-13)
            if [one.what for one in run.impacts if one.t > 0.0][:1] != [STRIKES]:
                raise SimulateError("from shortly before an impact on, something else happens")
            return np.append(run.q[-1], run.qd[-1])

        try:
            if self.scene.is_constrained or nq != nv or self.scene.states or self.scene.prescribed_velocities:
                raise SimulateError("differences are not taken of loops, quaternions, states or prescribed motions")
            far, near = (ended(k * WIDTH) - ended(-k * WIDTH) for k in (2, 1))
            found = sensitivity(Problem(self.scene, start=Start(q, at.u)), until=2 * SOON, parameters=(), rtol=1e-12)
        except SymdynError as fault:
            self.lacking[SLOPES] = str(fault)
            return
        by_runs = (8 * near - far) / (12 * WIDTH)
        missed = float(np.abs(found.matrix @ way - by_runs).max())
        self.tell(SLOPES, at.where, missed, float(np.abs(by_runs).max()), CLOSE)

    def run(self) -> None:
        """Look at a run of one second from the start."""
        run = simulate(self.scene, until=1.0)
        kept = [x for name, x in run.monitors.items() if name.startswith(("contact_laws", "penetration"))]
        self.tell(ROWS, "the start", max(kept, default=0.0))
        energies = [float(np.ptp(run[f"{name}_energy"])) for name in ("kinetic", "potential")]
        self.tell(BALANCE, "the start", float(np.abs(run["energy_error"]).max()), max(energies), CLOSE)
        if run.t[-1] < 1.0:
            self.lacking["run of 1 s, all of it"] = f"it ends at t = {run.t[-1]:.9g} s"


def _least_distance(D: Array, h: Array) -> Array:
    """Return Λ ≥ 0 of the least ½ Λ D Λ with D Λ ≥ h."""
    from scipy.optimize import nnls  # late: it takes long to load

    if h.max() <= 0.0:
        return np.zeros(len(h))
    values, vectors = np.linalg.eigh(D)
    E, f = np.vstack([vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T, h]), np.eye(len(h) + 1)[-1]
    y, _ = nnls(E, f)
    return np.asarray(y / (f - E @ y)[-1])


def _missed(laws: Laws, impulses: Array, after: Array, xi: Array, poisson: bool) -> float:
    """Return by how much impulses miss Signorini's and Coulomb's laws; by Poisson's law that of all phases at once."""
    off = [0.0]
    for n, along, mu in zip(laws.normals, laws.tangents, laws.friction.tolist(), strict=True):
        assert n is not None, "it strikes"
        force, slip = impulses[list(along)], after[list(along)]
        off += [-impulses[n], -after[n], float(np.linalg.norm(force)) - mu * impulses[n]]
        if not poisson:
            rubs = float(np.linalg.norm(slip)) * force + mu * impulses[n] * slip
            off += [-xi[n], abs(xi[n] * impulses[n]), *np.abs(rubs)]
    return float(max(off))


def contact_checks(scene: Scene, seed: int) -> tuple[Looked, dict[str, str]]:
    """Return what was looked at of a scene's contacts, and what was not, with the reason; nothing of one without.

    Raises:
        SimulateError: it has parameters without a value, or no run begins at its start.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    if not lacks_modes(scene):
        return {}, {}
    problem = Problem(scene)
    system, x = ready(problem, problem.driving, (), problem.initial, 1.0, Control())
    assert system.contacts is not None, "there are contacts"
    checks = _Checks(scene, system, system.contacts, x, np.random.default_rng(seed))
    for at in checks.places():
        checks.impact(at)
        checks.stuck(at)
        if at.where.endswith(STRUCK) and len(at.touching) == 1:
            checks.slopes(at)
    checks.run()
    return checks.found, {claim: why for claim, why in checks.lacking.items() if claim not in checks.found}
