"""Contacts at natural states, in numbers: laws with inequalities, of which no proof knows, each by two roads.

States are where one contact touches, and where all of them do (two corners at once, feet that hold the same), each
struck, grazed and at rest. There are compared

    impulses of all cases with those of Lemke's pivots; without friction with Gauss' principle of least constraint,
        min |x|  with  F x ≥ h,    D = F F,  h = -(1 + e) n u⁻,  by Lawson and Hanson's method of least distance
    the formula of one impact with its numbers; energy before and behind with what impulses take, -Λ·(v⁻ + v⁺)/2
    accelerations of what sticks with those of the mechanism whose rows are constraints
    derivatives of a run across an impact, by saltation matrices, with differences of runs

and from its start the scene runs for a second: its laws are kept at every row, and energy is balanced.

References: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 6 and 8; Lawson and
Hanson, Solving Least Squares Problems (1974), chapter 23.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.outputs import lacks_modes, unilaterals_of, with_modes
from symdyn.errors import DerivationError, SimulateError, SymdynError
from symdyn.graph import evaluate
from symdyn.scene import Scene
from symdyn.scene.values import Contact, Element, Unilateral
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

STRUCK = "struck"

FORMULA, PIVOTS, GAUSS = "impact: formula of one contact = its numbers", "impact: all cases = Lemke's pivots", (
    "impact without friction = Gauss' principle"
)  # fmt: skip
LAWS, ENERGY = "impact: laws of contact and friction", "impact: kinetic energy lost = what impulses take, never below 0"
STUCK, SLOPES = "sticking contacts = the mechanism with their rows", "saltation matrix = differences of runs"
ROWS, BALANCE = "run of 1 s: laws of contact at every row", "run of 1 s: balance of energy"


class ContactCheck(NamedTuple):
    """A claim, where it was looked at, and where it does not hold."""

    claim: str
    places: tuple[str, ...]
    wrong: tuple[str, ...]


@dataclass(frozen=True)
class _Place:
    """A state: where it is, in words, what touches there, all contacts in numbers, and velocities."""

    where: str
    touching: tuple[int, ...]
    x: Array
    n: Numbers

    @property
    def struck(self) -> tuple[Laws, list[int]]:
        """Return what touches, at an impact: friction is that of what slips."""
        some, rows = part(self.n.laws, self.touching)
        return replace(some, static=some.friction), rows


@dataclass(frozen=True)
class _Checks:
    scene: Scene
    system: StateEquations
    contacts: Contacts
    begin: Array
    rng: np.random.Generator
    found: dict[str, tuple[list[str], list[str]]] = field(default_factory=dict)
    lacking: dict[str, str] = field(default_factory=dict)

    def tell(self, claim: str, where: str, missed: float, allowed: float = SAME) -> None:
        places, wrong = self.found.setdefault(claim, ([], []))
        places.append(where)
        if not missed <= allowed:
            wrong.append(where)

    @property
    def closing(self) -> Projection:
        return Projection(self.system, 1e-12)

    def numbers(self, x: Array) -> Numbers:
        return self.contacts.numbers(self.system.evaluate("contacts", 0.0, x), self.system.nv)

    def places(self) -> Iterator[_Place]:
        """Yield states at which something touches."""
        closing = [k for k, (n, _) in enumerate(self.contacts.rows) if n is not None]
        wanted = {f"where {self.contacts.name(k)} touches": [k] for k in closing}
        wanted |= {"where all touch": closing} if len(closing) > 1 else {}
        for where, some in wanted.items():
            x, found = self._touched(some)
            touching = tuple(k for k in closing if abs(found.gaps[k]) <= NEAR and found.able[k])
            if not {*some} <= {*touching} or not np.isfinite(found.W).all():
                continue
            nq, nv = self.system.nq, self.system.nv
            rows = [n for k in touching if (n := self.contacts.rows[k][0]) is not None]
            D, W, C = found.laws.D[np.ix_(rows, rows)], found.W[rows], found.C[rows]
            u = self._pushed(x)
            grazing = u - C.T @ least(D, W @ u)
            for how, speed in ((STRUCK, grazing - C.T @ least(D, np.ones(len(rows)))), ("grazed", grazing),
                               ("at rest", 0 * u)):  # fmt: skip
                y = x.copy()
                y[nq : nq + nv] = speed
                yield _Place(f"{where}, {how}", touching, y, self.numbers(y))

    def _touched(self, some: list[int]) -> tuple[Array, Numbers]:
        x, rows = self.contacts.with_mode(self.begin, []), [self.contacts.rows[k][0] for k in some]
        x[self.system.nq : self.system.nq + self.system.nv] = 0.0
        found = self.numbers(x)
        for _ in range(STEPS):
            C, D = found.C[rows], found.laws.D[np.ix_(rows, rows)]  # type: ignore[arg-type]  # all have an n
            step = np.append(-C.T @ least(D, found.gaps[some]), np.zeros(self.system.nu - self.system.nv))
            x[: self.system.nq] += self.system.calls["moved"](x[: self.system.nq], step)
            x = self.closing.projected(x)
            found = self.numbers(x)
        return x, found

    def _pushed(self, x: Array) -> Array:
        """Return velocities that loops allow and prescribed motions do not know, shape (nv,), 1 at most."""
        q, u, _ = self.system.parts(x)
        none, some = np.zeros(self.system.given_size), self.rng.uniform(-1, 1, self.system.given_size)
        some[self.system.nv :] = 0.0
        found = self.system.calls["rates"](q, u, some, 0.0) - self.system.calls["rates"](q, u, none, 0.0)
        found = found[self.system.nq : self.system.nq + self.system.nv]
        return np.asarray(found / np.abs(found).max(initial=1e-300))

    # What is compared there

    def impact(self, at: _Place) -> None:
        """Compare the impulses of an impact by all roads that there are."""
        laws, rows = at.struck
        u, C, W = at.x[self.system.nq : self.system.nq + self.system.nv], at.n.C[rows], at.n.W[rows]
        v, k = W @ u, len(at.touching)
        normals = [n for n in laws.normals if n is not None]
        target = np.zeros(len(v))
        target[normals] = -laws.restitution * v[normals]
        size = 1.0 + float(np.abs(u).max())
        if k <= FEW and max(map(len, laws.tangents)) < 2:
            options = [(FREE, *laws.slips(i)) for i in range(k)]
            cases = [one for _, one in laws.solutions(v, options, None, target)]
            pivots = laws.by_pivots(v, [0.0] * k, np.zeros(k), target)
            apart = [float(np.abs(C.T @ (one - pivots)).max()) for one in cases] if pivots is not None else []
            self.tell(PIVOTS, at.where, min(apart, default=np.inf) / size)
        smooth = replace(laws, friction=0 * laws.friction, static=0 * laws.static)
        away = u + C.T @ smooth.impact(v, [False] * k)
        gauss = u + C[normals].T @ _least_distance(laws.D[np.ix_(normals, normals)], target[normals] - v[normals])
        self.tell(GAUSS, at.where, float(np.abs(away - gauss).max()) / size)
        by_poisson = [self.contacts.laws[i] == "poisson" for i in at.touching]
        try:
            impulses = laws.impact(v, by_poisson)
        except ArithmeticError:
            self.tell(LAWS, at.where, np.inf)
            return
        after = v + laws.D @ impulses
        self.tell(LAWS, at.where, _missed(laws, impulses, after, after - target, all(by_poisson)) / size)
        behind = at.x.copy()
        behind[self.system.nq : self.system.nq + self.system.nv] = u + C.T @ impulses
        before, then = (float(np.sum(self.system.evaluate("kinetic", 0.0, y))) for y in (at.x, behind))
        lost = -float(impulses @ (v + after)) / 2
        allowed = all(by_poisson) and np.ptp(laws.restitution) == 0
        if not self.scene.prescribed_velocities:  # what moves as it is told takes and gives energy, too
            off = max(abs(before - then - lost), -lost if allowed else 0.0)
            self.tell(ENERGY, at.where, off / (1.0 + abs(before)))
        if k == 1 and len(laws.tangents[0]) < 2 and at.where.endswith(STRUCK):  # grazing may do this or that
            self._formula(at, u + C.T @ impulses, size)

    def _formula(self, at: _Place, after: Array, size: float) -> None:
        w, system = Workspace(self.scene), self.system
        try:
            entries = derive_one(w, f"impact:{self.contacts.name(at.touching[0])}").entries[: system.nv]
        except DerivationError:  # loops close the scene, or nothing moves along its normal
            return
        state = zip((*w.state.q, *w.state.qd), at.x[: system.nq + system.nv].tolist(), strict=True)
        given = {w.graph.symbol(name): value for name, value in self.system.opened.values.items()}
        own = dict(zip(w.states, at.x[system.nq + system.nv :].tolist(), strict=False))
        found = np.array(evaluate(entries, Floats(), {**given, **w.scene.at_time(w.graph), **own, **dict(state)}))
        self.tell(FORMULA, at.where, float(np.abs(found - after).max()) / size)

    def _rows(self, k: int) -> list[int]:
        n, along = self.contacts.rows[k]
        return [*([] if n is None else [n]), *along]

    def stuck(self, at: _Place) -> None:
        """Compare accelerations of what sticks with those of the mechanism that has rows of constraints there."""
        laws = {one.name: one for one in unilaterals_of(self.scene)}
        rows = [laws[self.contacts.name(k)].closed for k in at.touching]
        if self.scene.is_constrained or not all(rows) or at.where.endswith(STRUCK):
            return
        cases, held = list[tuple[int, Case]](), list[Element]()
        for k, row in zip(at.touching, rows, strict=True):
            rough = bool(self.contacts.rows[k][1])
            cases.append((k, Case(True, STICK if rough else "")))
            assert row is not None, "it is a contact with a plane, or a rope"
            smooth = isinstance(row, Contact) and not rough
            held.append(replace(row, components=("normal",)) if smooth else row)  # type: ignore[call-arg]
        own = with_modes(self.scene)
        others = (one for one in own.elements if not isinstance(one, Unilateral))
        names = {one.name for one in self.scene.states}
        closed = replace(own, elements=(*others, *held), states=tuple(x for x in own.states if x.name in names))
        nq, nv = self.system.nq, self.system.nv
        with np.errstate(all="ignore"):
            try:
                other = state_equations(closed, Forces(), (), at.x[:nq])
            except SymdynError:
                return
            y, kept = self.contacts.with_mode(at.x, cases), [n for k in at.touching for n in self._rows(k)]
            y[nq : nq + nv] -= at.n.C[kept].T @ least(at.n.laws.D[np.ix_(kept, kept)], at.n.W[kept] @ y[nq : nq + nv])
            x = np.append(y[: nq + other.nu], np.zeros(int(other.works)))
            by_rows, by_mode = other.rates(0.0, x)[nq : nq + nv], self.system.rates(0.0, y)[nq : nq + nv]
        if np.isfinite(by_rows).all():
            self.tell(STUCK, at.where, float(np.abs(by_mode - by_rows).max()) / (1.0 + float(np.abs(by_rows).max())))

    def slopes(self, at: _Place) -> None:
        """Compare a derivative of a run across an impact with differences of fourth order."""
        nq, nv = self.system.nq, self.system.nv
        u = at.x[nq : nq + nv]
        q = at.x[:nq] - SOON * self.system.calls["moved"](at.x[:nq], at.x[nq : nq + self.system.nu])
        way = np.cos(1.0 + np.arange(2 * nv))

        def ended(step: float) -> Array:
            start = Start(q + step * way[:nv], u + step * way[nv:])
            run = simulate(Problem(self.scene, start=start), until=2 * SOON, rtol=1e-13)
            if [one.what for one in run.impacts if one.t > 0.0][:1] != [STRIKES]:
                raise SimulateError("from shortly before an impact on, something else happens")
            return np.append(run.q[-1], run.qd[-1])

        try:
            if self.scene.is_constrained or nq != nv or self.scene.states or self.scene.prescribed_velocities:
                raise SimulateError("loops, quaternions, states or prescribed motions")
            far, near = (ended(k * WIDTH) - ended(-k * WIDTH) for k in (2, 1))
            found = sensitivity(Problem(self.scene, start=Start(q, u)), until=2 * SOON, parameters=(), rtol=1e-12)
        except (SymdynError, ArithmeticError) as fault:
            self.lacking[SLOPES] = str(fault)
            return
        names = (*self.scene.coordinates, *self.scene.velocities)
        by_runs, free = (8 * near - far) / (12 * WIDTH), [names.index(name) for name in found.columns]
        missed = float(np.abs(found.matrix @ way[free] - by_runs).max())
        self.tell(SLOPES, at.where, missed / (1.0 + float(np.abs(by_runs).max())), CLOSE)

    def run(self) -> None:
        """Look at a run of one second from the start."""
        run = simulate(self.scene, until=1.0)
        kept = [x for name, x in run.monitors.items() if name.startswith(("contact_laws", "penetration"))]
        self.tell(ROWS, "the start", max(kept, default=0.0))
        if run.t[-1] < 1.0:
            self.lacking["run of 1 s, all of it"] = f"it ends at t = {run.t[-1]:.9g} s"
        energies = [float(np.ptp(run[name])) for name in ("kinetic", "potential") if name in run.columns]
        self.tell(BALANCE, "the start", float(np.abs(run["energy_error"]).max()) / (1.0 + sum(energies)), CLOSE)


def _least_distance(D: Array, h: Array) -> Array:
    """Return Λ ≥ 0 of the least ½ Λ D Λ with D Λ ≥ h."""
    from scipy.optimize import nnls  # late: it takes long to load

    values, vectors = np.linalg.eigh(D)
    F = vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
    if h.max() <= 0.0:
        return np.zeros(len(h))
    E, f = np.vstack([F, h]), np.append(np.zeros(len(h)), 1.0)
    y, _ = nnls(E, f)
    return np.asarray(y / (f - E @ y)[-1])


def _missed(laws: Laws, impulses: Array, after: Array, xi: Array, poisson: bool) -> float:
    """Return by how much impulses miss Signorini's and Coulomb's laws; by Poisson's law that of all phases at once."""
    off = [0.0]
    for k, (n, along) in enumerate(zip(laws.normals, laws.tangents, strict=True)):
        assert n is not None, "it strikes"
        force, size = impulses[list(along)], float(np.linalg.norm(impulses[list(along)]))
        off += [-impulses[n], -after[n], size - laws.friction[k] * impulses[n]]
        slip = after[list(along)]
        speed = float(np.linalg.norm(slip))
        if not poisson:
            off += [-xi[n], abs(xi[n] * impulses[n]), *np.abs(speed * force + laws.friction[k] * impulses[n] * slip)]
    return float(max(off))


def contact_checks(scene: Scene, seed: int) -> tuple[list[ContactCheck], dict[str, str]]:
    """Return what was looked at of a scene's contacts, and what was not, with the reason; nothing of one without.

    Raises:
        SimulateError: it has parameters without a value, or no run begins at its start.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    if not lacks_modes(scene):
        return [], {}
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
    found = [ContactCheck(claim, tuple(places), tuple(wrong)) for claim, (places, wrong) in checks.found.items()]
    return found, {claim: why for claim, why in checks.lacking.items() if claim not in checks.found}
