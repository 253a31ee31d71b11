"""Lagrange's derivation of a scene, taken apart where students go wrong: one course is right, altered ones are not.

    r = o_1 + (o_2 - o_1) + ... + arm         a mass, by the hinges that carry it
    K = ½ m Σ v_a·v_b + ½ ω·I ω               own square, cross terms, square of what carries it, spin
    d/dt ∂L/∂q̇ - ∂L/∂q = τ + Q

Quantities go by the keys of documents: "K:2", "v2:2", "P:", "L:", "dL:/dq1_dot", "d/dt dL:/dq1_dot", "dL:/dq1",
"tau:1", "k_z:1,2".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Union

from symdyn.algebra import Form
from symdyn.dynamics import rotor_energy
from symdyn.dynamics.mechanism import (
    State,
    body_placements,
    elastic_energy,
    generalized_forces,
    quaternions,
    vector,
)
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, substitute, tangents
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Joint
from symdyn.spatial import Transform, Vec, cross, dot, scale, sub
from symdyn.teach.lesson import Mass, masses
from symdyn.teach.student.differences import Splitter
from symdyn.unlocked import cached_property

Number = Union[int, Fraction]


@dataclass(frozen=True)
class Parts:
    """One mass in parts.

    Attributes:
        tag: of the mass.
        m: kg.
        base: where the last hinge that carries it stands, and `arm`, the way from there; ground frame, m.
        arm: see base.
        spin: ½ ω·I ω, with the work of an offset.
        relative: of `arm` and spin, with no rates but those of the last hinge and beyond: velocity of the arm, m/s, and spin, J.
        lone: K with no rates but those of the last joint, of the last two, …, J, of all but the first; then with the
            rate of the last hinge alone about its axle.
        rigid: whether it has a moment of inertia.
        axes: ½ I ω² by axis of the body, of those about which it turns, if these are principal ones.
        parallel: ½ m v² of the centre of mass as it turns about the hinge, J, or about the frame that `spin` is about.
    """

    tag: str
    m: Expr
    base: Vec
    arm: Vec
    spin: Expr
    relative: tuple[Vec, Expr]
    lone: tuple[Expr, ...]
    rigid: bool
    axes: tuple[Expr, ...]
    parallel: Expr


@dataclass(frozen=True)
class Energies:
    """Energies by what has them: v² and K by mass, P by mass ("E" for springs), Q beside the drives."""

    square: Mapping[str, Expr]
    K: Mapping[str, Expr]
    P: Mapping[str, Expr]
    Q: tuple[Expr, ...]


class Course:
    """Lagrange's derivation of one scene on one graph."""

    def __init__(self, scene: Scene) -> None:
        """Take the scene apart; raises DerivationError where rates are not those of coordinates."""
        if quaternions(scene) or len(scene.coordinates) != len(scene.velocities):
            raise DerivationError(f"{scene.name}: rates are not those of coordinates")
        self.scene, self.graph = scene, Graph()
        for parameter in scene.parameters:
            self.graph.symbol(parameter.name)
        self.state: State = State.of(scene, self.graph)
        self.placed = body_placements(scene, self.graph)
        self.gravity = vector(scene.gravity, self.graph)
        self.joints = {joint.child: joint for joint in scene.joints}
        self.slope: Callable[[Expr, Expr], Expr] = cache(lambda x, by: self.rates([x], {by: self.graph.one})[0])
        self.moved: dict[frozenset[tuple[Expr, Expr]], dict[Expr, Expr | None]] = {}
        self.exchanged: dict[frozenset[tuple[Expr, Expr]], dict[Expr, Expr]] = {}
        self.still = (self.graph.zero,) * len(scene.velocities)
        self.steps = cache(self._steps)  # quantities with the same energies ask for the same

    @cached_property
    def terms(self) -> Callable[[Expr], list[Form]]:
        """Return what takes a formula apart, see `Splitter`."""
        own = [self.value(f"tau:{i + 1}", self.right) for i in range(self.state.n)]
        return cache(Splitter([node for node in own if node is not None], self.scene, self.state))

    @cached_property
    def loads(self) -> tuple[Expr, ...]:
        """Return what acts beside the drives but for what flows of matter carry, which is no friction."""
        kept = tuple(one for one in self.scene.elements if not hasattr(one, "flux"))
        return tuple(generalized_forces(replace(self.scene, elements=kept), self.graph))

    @cached_property
    def beside(self) -> Mapping[str, tuple[Expr, ...]]:
        """Return `loads` by rule: "force" is what acts without rates as well, "friction" what goes by these."""
        try:
            given = tuple(self.put(x, dict.fromkeys(self.state.qd, self.graph.zero)) for x in self.loads)
        except ZeroDivisionError:  # by the direction of a rate
            given = self.still
        return {"force": given, "friction": tuple(x - y for x, y in zip(self.loads, given, strict=True))}

    @cached_property
    def parts(self) -> list[Parts]:
        """Return every mass in parts."""
        return [self._parts(mass) for mass in masses(self.scene, self.graph, self.placed)]

    def _parts(self, mass: Mass) -> Parts:
        hinge = self._hinge(self.joints.get(mass.body.name))
        base: Vec = (self.graph.zero,) * 3
        rates = dict(self.state.velocity)
        alone = dict(rates)
        if hinge is not None:
            base = self._foot(hinge).p
            beyond, joint = [*hinge.coordinates], self.joints[mass.body.name]
            while joint != hinge:
                beyond, joint = [*beyond, *joint.coordinates], self.joints[joint.parent]
            alone = {q: u if str(q.value) in beyond else self.graph.zero for q, u in rates.items()}
        arm = sub(mass.place, base)
        spin, still = (self._spin(mass, seeds) for seeds in (rates, alone))
        joint, last, lone = self.joints.get(mass.body.name), set[str](), list[Expr]()
        while joint is not None:
            if joint.moves:
                last |= set(joint.coordinates)
                own = {q: u if str(q.value) in last else self.graph.zero for q, u in rates.items()}
                v = self._rate(mass.place, own)
                lone.append(mass.m * dot(v, v) / 2 + self._spin(mass, own))
            joint = self.joints.get(joint.parent)
        lone = lone[:-1]
        if hinge is not None and len(hinge.coordinates) == 1 and mass.h is None:
            unit = {q: self.graph.constant(int(not u.is_zero)) for q, u in alone.items()}
            w, axle = (self._turning(mass, seeds) for seeds in (rates, unit))
            w = sub(w, scale(dot(axle, w) - self.graph.total(alone.values()), axle))
            v = self._rate(mass.place, rates)
            lone.append((mass.m * dot(v, v) + dot(w, mass.inertia @ w)) / 2)
        w, principal = self._turning(mass, rates), all(mass.inertia[j][k].is_zero for j in range(3) for k in range(j))
        axes = tuple(mass.inertia[k][k] * w[k] * w[k] / 2 for k in range(3) if principal)
        v = self._rate(arm if mass.h is None or mass.m.is_zero else scale(1 / mass.m, mass.h), rates)
        relative = self._rate(arm, alone), still
        parallel = mass.m * dot(v, v) / 2
        return Parts(mass.tag, mass.m, base, arm, spin, relative, tuple(lone), mass.spins, axes, parallel)

    def _hinge(self, joint: Joint | None) -> Joint | None:
        """Return the nearest joint that turns a body, at it or on the ground's side of it."""
        while joint is not None and not (joint.moves and JOINTS[joint.type].velocities(joint)[0] == "rad"):
            joint = self.joints.get(joint.parent)
        return joint

    def _foot(self, joint: Joint) -> Transform:
        return self.placed[joint.parent] @ joint.origin.transform(self.graph)

    def _turning(self, mass: Mass, seeds: Mapping[Expr, Expr]) -> Vec:
        """Return the angular velocity of a body, in its frame."""
        R = self.placed[mass.body.name].R
        dR = [self.rates(row, seeds) for row in R]
        x, y, z = (self.graph.total(R[k][a] * dR[k][b] for k in range(3)) for a, b in ((2, 1), (0, 2), (1, 0)))
        return x, y, z

    def _spin(self, mass: Mass, seeds: Mapping[Expr, Expr]) -> Expr:
        w = self._turning(mass, seeds)
        spin = dot(w, mass.inertia @ w) / 2
        if mass.h is not None:
            spin = spin + dot(self._rate(mass.place, seeds), cross(self.placed[mass.body.name].R @ w, mass.h))
        return spin

    @cached_property
    def right(self) -> Energies:
        """Return the energies as they are."""
        square, K, P = {}, {}, {}
        for part, mass in zip(self.parts, masses(self.scene, self.graph, self.placed), strict=True):
            square[part.tag] = self.squared(part)
            K[part.tag] = self.kinetic(part)
            P[part.tag] = self.weight(part) if mass.h is None else self.weight(part) - dot(self.gravity, mass.h)
        for joint in self.scene.joints:
            if joint.moves:
                K[f"rotor {joint.name}"] = rotor_energy(joint, self.state.velocity, self.graph)
        P["E"] = elastic_energy(self.scene, self.graph)
        return Energies(square, K, P, tuple(generalized_forces(self.scene, self.graph)))

    def rates(self, nodes: Sequence[Expr], seeds: Mapping[Expr, Expr]) -> list[Expr]:
        """Return rates along a direction, which are kept, see `tangents`."""
        return tangents(nodes, seeds, known=self.moved.setdefault(frozenset(seeds.items()), {}))

    def put(self, node: Expr, values: Mapping[Expr, Expr]) -> Expr:
        """Return a node with others for some, which are kept, see `substitute`."""
        return substitute([node], values, known=self.exchanged.setdefault(frozenset(values.items()), {}))[0]

    def _rate(self, v: Vec, seeds: Mapping[Expr, Expr]) -> Vec:
        x, y, z = self.rates(v, seeds)
        return x, y, z

    # Parts put together, right or with factors of their own

    def velocities(self, part: Parts) -> tuple[Vec, Vec]:
        """Return the velocities of base and arm."""
        return self._rate(part.base, self.state.velocity), self._rate(part.arm, self.state.velocity)

    def squared(self, part: Parts, base: Number = 1, cross: Number = 1, own: Number = 1) -> Expr:
        """Return v², each of its parts times a number."""
        u, v = self.velocities(part)
        number = self.graph.constant
        return number(base) * dot(u, u) + number(2 * cross) * dot(u, v) + number(own) * dot(v, v)

    def kinetic(self, part: Parts, base: Number = 1, cross: Number = 1, own: Number = 1, spin: Number = 1) -> Expr:
        """Return K of a mass, each of its parts times a number."""
        return part.m * self.squared(part, base, cross, own) / 2 + self.graph.constant(spin) * part.spin

    def weight(self, part: Parts, base: Number = 1, arm: Number = 1) -> Expr:
        """Return P of a mass, heights of hinge and arm times a number."""
        g, number = self.gravity, self.graph.constant
        return -(part.m * (number(base) * dot(g, part.base) + number(arm) * dot(g, part.arm)))

    # What follows from energies

    def value(self, key: str, e: Energies) -> Expr | None:
        """Return what a quantity is worth with these energies; None for one that this course does not come to."""
        kind, _, of = key.partition(":")
        graph, state = self.graph, self.state
        if kind == "v2":
            return e.square.get(of)
        if kind in ("K", "P") and of:
            return (e.K if kind == "K" else e.P).get(of)
        total, K, P = graph.total, e.K.values(), e.P.values()  # slopes are those of single masses, which are known
        if key in ("K:", "P:", "L:"):
            return {"K:": total(K), "P:": total(P), "L:": total(K) - total(P)}[key]
        if key.startswith(("dL:/d", "d/dt dL:/d")):
            by = {str(x.value): x for x in (*state.q, *state.qd)}.get(key.partition(":/d")[2])
            if by is None:
                return None
            slope = total(self.slope(x, by) for x in K) - total(self.slope(x, by) for x in P)
            return self.rates([slope], state.acceleration)[0] if kind == "d/dt dL" else slope
        if kind == "tau":
            i = int(of) - 1
            kinetic = total(self.balance(i, x, graph.zero, self.still) for x in K)
            return kinetic + total(self.slope(x, state.q[i]) for x in P) - e.Q[i]
        indices = [int(x) - 1 for x in of.split(",") if x.isdigit()]
        if not kind.startswith("k_") or not indices:
            return None
        if kind in ("k_G", "k_E"):
            return self.coefficient(kind, indices, graph.zero, e.P)
        return total(self.coefficient(kind, indices, x, e.P) for x in K)

    def _steps(self, i: int, K: Expr, P: Expr) -> tuple[Expr, Expr, Expr, Expr]:
        """Return Σ M q̈, Ṁ q̇, ∂K/∂q_i and ∂P/∂q_i."""
        state = self.state
        p = self.slope(K, state.qd[i])
        still = dict.fromkeys(state.q, self.graph.zero)
        inertial = self.rates([p], {**still, **dict(zip(state.qd, state.qdd, strict=True))})[0]
        product = self.rates([p], {**dict.fromkeys(state.qd, self.graph.zero), **state.velocity})[0]
        return inertial, product, self.slope(K, state.q[i]), self.slope(P, state.q[i])

    def balance(self, i: int, K: Expr, P: Expr, Q: Sequence[Expr]) -> Expr:
        """Return what drive i is."""
        inertial, product, kinetic, potential = self.steps(i, K, P)
        return inertial + product - kinetic + potential - Q[i]

    def coefficient(self, kind: str, at: Sequence[int], K: Expr, P: Mapping[str, Expr]) -> Expr:
        """Return a coefficient of an equation, with its own sign."""
        state, i = self.state, at[0]
        if kind in ("k_G", "k_E"):
            total = self.graph.total(node for key, node in P.items() if (key == "E") == (kind == "k_E"))
            return self.slope(total, state.q[i])
        if kind == "k_z":
            return self.slope(self.slope(K, state.qd[i]), state.qd[at[1]])
        _, product, kinetic, _ = self.steps(i, K, self.graph.zero)
        first, second = [at[1], at[1]] if kind == "k_D" else list(at[1:3])
        found = self.slope(self.slope(product - kinetic, state.qd[first]), state.qd[second])
        return found / 2 if kind == "k_D" else found

    def with_part(self, of: Mapping[str, tuple[Expr | None, Expr | None, Expr | None]]) -> Energies:
        """Return the energies with v², K and P of some masses replaced, None for those that stay."""
        e = self.right
        square, K, P = dict(e.square), dict(e.K), dict(e.P)
        for tag, nodes in of.items():
            for table, node in zip((square, K, P), nodes, strict=True):
                if node is not None:
                    table[tag] = node
        return replace(e, square=square, K=K, P=P)

    def replaced(self, e: Energies, values: Mapping[Expr, Expr]) -> Energies:
        """Return energies with other symbols."""

        def of(table: Mapping[str, Expr]) -> dict[str, Expr]:
            return {tag: self.put(node, values) for tag, node in table.items()}

        return replace(e, square=of(e.square), K=of(e.K), P=of(e.P))

    def ancestors(self, joint: Joint) -> list[Joint]:
        """Return the joints on the ground's side of one that turn in it or against it, the nearest first."""
        found = []
        while joint.parent != Scene.GROUND:
            joint = self.joints[joint.parent]
            found.append(joint)
        return [one for one in found if one.moves and JOINTS[one.type].velocities(one)[0] == "rad"]


def acting(scene: Scene, i: int) -> Form | None:
    """Return a drive with the loads beside it, which a letter of its own would hide; None for a drive alone."""
    graph = Graph()
    loads = generalized_forces(scene, graph)[i]
    drive = scene.drives[i]
    return None if loads.is_zero else Form.of((graph.symbol(drive) if drive else graph.zero) + loads)
