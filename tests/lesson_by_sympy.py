"""Lagrange's equations of a tree by SymPy alone, from what a scene declares: a second opinion for lessons.

Nothing is read of `symdyn.dynamics` or `symdyn.teach`: frames are turned and shifted by matrices of SymPy, positions
differentiated by the chain rule, (5.21)-(5.23) carried out on the result. It knows revolute, prismatic, fixed joints,
balls with angles, joints that follow others, rotors, springs at joints and between points.

    R, p      rotation and place of a body's frame in the ground frame      w   R^T dR/dt as a vector, body axes
    q, u, a   coordinates, rates, accelerations                             K, P, L   energies, J
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from symdyn.graph import Op
from symdyn.scene import Scene
from symdyn.scene.values import Body, Joint
from symdyn.scene.values.body import Pose
from symdyn.scene.values.quantity import Quantity

AXES = "xyz"
OPERATIONS = {
    Op.ADD: lambda x, y: x + y,
    Op.SUB: lambda x, y: x - y,
    Op.MUL: lambda x, y: x * y,
    Op.DIV: lambda x, y: x / y,
    Op.NEG: lambda x: -x,
    Op.SIN: sp.sin,
    Op.COS: sp.cos,
    Op.SQRT: sp.sqrt,
}


def number(quantity: Quantity) -> sp.Expr:
    """Return a quantity of a scene in SymPy, numbers exact."""
    if quantity.op is Op.CONSTANT:
        return sp.Rational(quantity.value)
    if quantity.op is Op.SYMBOL:
        return sp.Symbol(str(quantity.value))
    if quantity.op is Op.PI:
        return sp.pi
    return OPERATIONS[quantity.op](*map(number, quantity.args))


def column(vector: Iterable[Quantity]) -> sp.Matrix:
    """Return a vector of quantities as a column."""
    return sp.Matrix([number(x) for x in vector])


def rotation(axis: sp.Matrix, angle: sp.Expr) -> sp.Matrix:
    """Return the matrix of a turn about an axis (Rodrigues)."""
    n = axis / sp.sqrt(axis.dot(axis))
    skew = sp.Matrix([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    return (sp.eye(3) + sp.sin(angle) * skew + (1 - sp.cos(angle)) * skew * skew).expand()


def along(letter: str) -> sp.Matrix:
    """Return the unit vector of an axis."""
    return sp.Matrix([int(letter == axis) for axis in AXES])


def moved(R: sp.Matrix, p: sp.Matrix, pose: Pose) -> tuple[sp.Matrix, sp.Matrix]:
    """Return rotation and place after the steps of a placement."""
    for kind, amount in pose.steps:
        if kind[0] == "T":
            p = p + R * along(kind[1].lower()) * number(amount)
        else:
            R = R * rotation(along(kind[1].lower()), number(amount))
    return R, p


@dataclass(frozen=True)
class Tree:
    """One tree, derived from its declaration."""

    scene: Scene

    # Motion

    @cached_property
    def q(self) -> list[sp.Symbol]:
        """Coordinates; their rates and accelerations have the endings of the scene's."""
        return [sp.Symbol(name) for name in self.scene.coordinates]

    @cached_property
    def u(self) -> list[sp.Symbol]:
        """Rates."""
        return [sp.Symbol(f"{name}_dot") for name in self.scene.coordinates]

    @cached_property
    def a(self) -> list[sp.Symbol]:
        """Accelerations."""
        return [sp.Symbol(f"{name}_ddot") for name in self.scene.coordinates]

    def rate(self, x: sp.Expr) -> sp.Expr:
        """Return dx/dt by the chain rule."""
        terms = [sp.diff(x, s) * t for s, t in zip([*self.q, *self.u], [*self.u, *self.a], strict=True)]
        return sp.Add(*terms)

    def position(self, joint: Joint) -> list[sp.Expr]:
        """Return what a joint moves by: its coordinates, or that of the joint that it follows."""
        if joint.coupling is not None:
            led = (number(ratio) * sp.Symbol(name) for name, ratio in joint.coupling.ratios)
            return [sp.Add(*led) + number(joint.coupling.offset)]
        return [sp.Symbol(name) for name in joint.coordinates]

    @cached_property
    def frames(self) -> Mapping[str, tuple[sp.Matrix, sp.Matrix]]:
        """R and p of every body."""
        found = {Scene.GROUND: (sp.eye(3), sp.zeros(3, 1))}
        for joint in self.scene.joints:
            R, p = moved(*found[joint.parent], joint.origin)
            way = self.position(joint)
            if joint.type == "spherical":
                for letter, angle in zip(dict(joint.shape)["orientation"], way, strict=True):
                    R = R * rotation(along(letter), angle)
            elif joint.type == "prismatic":
                axis = column(joint.axis)
                p = p + R * axis / sp.sqrt(axis.dot(axis)) * way[0]
            elif joint.type != "fixed":
                assert joint.type in ("revolute", "continuous"), f"{joint.type} is not known here"
                R = R * rotation(column(joint.axis), way[0])
            found[joint.child] = moved(R, p, joint.tip)
        return found

    def spin(self, body: str) -> sp.Matrix:
        """Return ω along the axes of a body."""
        R, _ = self.frames[body]
        skew = R.T * R.applyfunc(self.rate)
        return sp.Matrix([skew[2, 1], skew[0, 2], skew[1, 0]])

    # Energies

    def masses(self) -> Iterator[tuple[str, Body, sp.Expr, sp.Matrix, sp.Matrix, sp.Matrix]]:
        """Yield index, body, mass, place of its centre, inertia about that, place that lessons show."""
        for k, body in enumerate(self.scene.bodies, 1):
            R, p = self.frames[body.name]
            m, xx = number(body.mass), [number(x) for x in body.inertia]
            inertia = sp.Matrix([[xx[0], xx[3], xx[4]], [xx[3], xx[1], xx[5]], [xx[4], xx[5], xx[2]]])
            extended = m != 0 or any(xx) or body.first_moment is not None
            count = extended + len(body.particles)
            tags = iter([str(k)] if count == 1 else [f"{k}{letter}" for letter in "abcdefgh"])
            if extended:
                com = column(body.com) if body.com is not None else column(body.first_moment) / m
                if body.about == "frame" and m != 0:
                    inertia = inertia - m * (com.dot(com) * sp.eye(3) - com * com.T)  # Steiner
                shown = p + R * com if body.about == "com" else p
                yield next(tags), body, m, p + R * com, inertia, shown
            for particle in body.particles:
                place = p + R * column(particle.at)
                yield next(tags), body, number(particle.mass), place, sp.zeros(3, 3), place

    @cached_property
    def values(self) -> dict[str, sp.Expr]:
        """What a lesson on Lagrange's formulation names, by its key in `Document.names`."""
        found: dict[str, sp.Expr] = {}
        gravity, K, P = column(self.scene.gravity), sp.Integer(0), sp.Integer(0)
        for tag, body, m, centre, inertia, shown in self.masses():
            w = self.spin(body.name)
            velocity = shown.applyfunc(self.rate)
            for k, axis in enumerate(AXES):
                found |= {f"{axis}:{tag}": shown[k], f"d{axis}:{tag}": velocity[k], f"omega:{tag}{axis}": w[k]}
            v = centre.applyfunc(self.rate)
            spin = (w.T * inertia * w)[0] / 2
            found[f"v2:{tag}"] = velocity.dot(velocity)
            found[f"K:{tag}"] = m * v.dot(v) / 2 + spin
            found[f"P:{tag}"] = -m * gravity.dot(centre)
            for i, u in enumerate(self.u, 1):
                found[f"r2:{tag},{i}"] = sp.diff(found[f"v2:{tag}"], u, 2) / 2
                found[f"I:{tag},{i}"] = sp.diff(found[f"K:{tag}"], u, 2) - m * found[f"r2:{tag},{i}"]
            mixed = m * velocity.dot((self.frames[body.name][0] * w).cross(centre - shown))
            found[f"Kh:{tag}"] = mixed
            found[f"Kw:{tag}"] = found[f"K:{tag}"] - m * found[f"v2:{tag}"] / 2 - mixed
            K, P = K + found[f"K:{tag}"], P + found[f"P:{tag}"]
        for joint in self.scene.joints:
            if joint.moves and number(joint.armature) != 0:
                (way,) = self.position(joint)
                found[f"K:rotor {joint.name}"] = number(joint.armature) * self.rate(way) ** 2 / 2
                K += found[f"K:rotor {joint.name}"]
        if self.scene.struts:
            found["P:E"] = sp.Add(*(self._stored(strut) for strut in self.scene.struts if strut.kind == "spring"))
            P += found["P:E"]
        found |= {"K:": K, "P:": P, "L:": K - P, "E:": K + P, "d/dt E:": self.rate(K + P)}
        return found | self._equations(K, P)

    def _stored(self, spring: object) -> sp.Expr:
        """Return the energy of a spring with one stiffness or several."""
        if spring.joint:
            (way,) = self.position(next(j for j in self.scene.joints if j.name == spring.joint))
        else:
            here, there = (self.frames[end.body][1] + self.frames[end.body][0] * column(end.at) for end in spring.ends)
            way = sp.sqrt((there - here).dot(there - here))
        x = way - number(spring.free)
        powers = [number(spring.preload), *map(number, spring.stiffness)]
        return sp.Add(*(k * x ** (m + 1) / (m + 1) for m, k in enumerate(powers)))

    def _equations(self, K: sp.Expr, P: sp.Expr) -> dict[str, sp.Expr]:
        """Return ∂L/∂q̇, d/dt ∂L/∂q̇, ∂L/∂q, what their difference is, and what multiplies accelerations and rates."""
        found: dict[str, sp.Expr] = {}
        G = -sp.Add(*(m * column(self.scene.gravity).dot(centre) for _, _, m, centre, _, _ in self.masses()))
        L, q, n = K - P, self.q, range(len(self.q))
        M = [[sp.diff(K, v, w) for w in self.u] for v in self.u]  # K = u.M u / 2, whose derivatives (5.21) sorts
        slope = [[[sp.diff(M[i][j], q[k]) for k in n] for j in n] for i in n]
        for i, here in enumerate(map(str, range(1, len(q) + 1))):
            momentum = sp.diff(L, self.u[i])
            rate, force = self.rate(momentum), sp.diff(L, q[i])
            found |= {f"dL:/d{self.u[i]}": momentum, f"d/dt dL:/d{self.u[i]}": rate, f"dL:/d{q[i]}": force}
            found |= {f"tau:{here}": rate - force, f"k_E:{here}": sp.diff(P - G, q[i])}
            found |= dict.fromkeys((f"k_G:{here}", f"MG:{here}"), sp.diff(G, q[i]))
            found[self.scene.drives[i] or f"needed:{here}"] = rate - force - self._other(i)
            for j in n:
                found |= {f"k_z:{here},{j + 1}": M[i][j], f"Mz:{here},{j + 1}": M[i][j] * self.a[j]}
                found[f"J:{here}" if i == j else f"D:{here},{j + 1}"] = M[i][j]
                found[f"k_D:{here},{j + 1}"] = slope[i][j][j] - slope[j][j][i] / 2
                for k in range(j + 1, len(q)):
                    found[f"k_C:{here},{j + 1},{k + 1}"] = slope[i][j][k] + slope[i][k][j] - slope[j][k][i]
        return found

    def _other(self, i: int) -> sp.Expr:
        """Return what acts at coordinate i beside its drive: a force of its joint, linear dampers."""
        joint = next(j for j in self.scene.joints if str(self.q[i]) in j.coordinates)
        dampers = [number(s.damping[0]) for s in self.scene.struts if s.kind == "damper" and s.joint == joint.name]
        force = number(joint.forces[0]) if joint.forces else sp.Integer(0)
        return force - sp.Add(number(joint.damping), *dampers) * self.u[i]


def at(values: Iterable[sp.Expr], point: Mapping[str, float]) -> list[float]:
    """Return expressions in numbers; `point` has a value for every symbol."""
    symbols = [sp.Symbol(name) for name in point]
    found = sp.lambdify(symbols, list(values), modules="math", cse=True)(*point.values())
    return [float(x) for x in found]
