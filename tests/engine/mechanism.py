"""A declared mechanism in motion: where its bodies are, how they move, and what acts on them. Ground axes throughout.

q, u, du     coordinates, velocities and their rates; bodies have twists (velocity of the origin, angular velocity)
T            placement of a body; J and P those of a joint frame and of the moved joint frame
D            (6, 6n): twist of a child relative to a parent at a point, from the twists of all bodies
S            (6, r): the same for unit rates of the joint, which are its own: a joint that follows has rates too
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from .jets import Jet, apply, cross, jet, number, stack, value
from .joints import coordinates, forces, inverse, motion, placed, pose, residual, tilde, unit, velocities_of, wrenches

Array = np.ndarray

FLAT = 1e-9
"""Sine of the angle between a wheel's axis and the normal of its plane below which it touches nowhere."""


@dataclass(frozen=True)
class Contact:
    """What forbids relative velocities of two bodies: a joint that closes a loop, a wheel or a blade; or a rope.

    Attributes:
        point: where its wrenches act. wrenches: (force, moment) on the child. residual: what vanishes in position.
        frames: rotations of the joint frame and of the child, for the axes of reactions.
        parts: the straight parts of a rope, each as one; together they forbid what the rope does.
    """

    name: str
    parent: str
    child: str
    point: Jet
    wrenches: Sequence[tuple[Jet, Jet]]
    residual: Sequence[Jet]
    frames: tuple[Array, Array]
    parts: Sequence[Contact] = ()

    @property
    def acting(self) -> Array:
        """The wrenches in numbers, a row each."""
        return np.array([np.concatenate([F.x, N.x]) for F, N in self.wrenches]).reshape(-1, 6)


KINDS = {
    "spring",
    "damper",
    "friction",
    "load",
    "flow",
    "formula",
    "knife_edge",
    "rolling",
    "rope",
    "elastic",
    "damping",
}
"""Elements whose laws are written below."""

MEET = 1e-9
"""m and N within which points meet and forces are none."""


class NoDirection(Exception):  # noqa: N818  nothing is wrong with the mechanism
    """The ends of a spring or damper meet, so that its force has no direction, or a wheel lies flat on its plane."""


class Mechanism:
    """A scene with a number for every parameter."""

    def __init__(self, scene: Any, values: Mapping[str, float] | None = None) -> None:
        """`values` are those of parameters, in place of what the scene gives."""
        self.scene, self.values = scene, dict(values or {})
        if strange := sorted({one.kind for one in scene.elements} - KINDS):
            raise LookupError(f"the reference has no law for {', '.join(strange)}; write one, and its name in KINDS")
        for one in scene.parameters:
            if one.name not in self.values:
                self.values[one.name] = number(one.value, self.values)
        self.bodies = [body.name for body in scene.bodies]
        self.gravity = np.array([number(x, self.values) for x in scene.gravity])
        self.inertia = {body.name: self._inertia(body) for body in scene.bodies}
        self.names = list(scene.velocities)
        self.frames = {
            j.name: (pose(j.origin, self.values), pose(j.tip, self.values)) for j in (*scene.joints, *scene.loops)
        }
        self.own: list[list[tuple[int, float]]] = []  # of every own rate: velocities and how often
        self.first: dict[str, int] = {}  # own rates of a joint begin here
        for joint in scene.joints:
            self.first[joint.name] = len(self.own)
            if joint.coupling is not None:
                led = joint.coupling.ratios
                self.own.append([(self.names.index(f"{q}_dot"), number(x, self.values)) for q, x in led])
            else:
                self.own += [[(self.names.index(name), 1.0)] for name in joint.rates]

    def _inertia(self, body: Any) -> tuple[float, Array, Array]:
        """Return mass, first moment and inertia about the body frame's origin, particles included."""
        m = number(body.mass, self.values)
        h = self.vector(body.first_moment) if body.first_moment is not None else m * self.vector(body.com)
        xx, yy, zz, xy, xz, yz = (number(x, self.values) for x in body.inertia)
        about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if body.about == "com" and m:
            about = about - tilde(h) @ tilde(h) / m
        for particle in body.particles:
            mass, at = number(particle.mass, self.values), self.vector(particle.at)
            m, h, about = m + mass, h + mass * at, about - mass * tilde(at) @ tilde(at)
        return m, h, about

    def vector(self, declared: Any) -> Array:
        """Return a declared vector that does not move."""
        return np.array([number(x, self.values) for x in declared])

    def own_rates(self, joint: Any) -> range:
        """Return the places of a joint's own rates."""
        count = 1 if joint.coupling is not None else len(joint.rates)
        return range(self.first[joint.name], self.first[joint.name] + count)

    def at(self, q: Any, u: Any = None, du: Any = None, t: float = 0.0) -> State:
        """Return the mechanism in motion."""
        n = len(self.names)
        zeros = np.zeros(n)
        return State(self, np.asarray(q, float), *(zeros if x is None else np.asarray(x, float) for x in (u, du)), t)


class State:
    """A mechanism at one instant."""

    def __init__(self, m: Mechanism, q: Array, u: Array, du: Array, t: float) -> None:
        """Place every body, from the ground outwards."""
        self.m, self.q, self.u, self.du, self.t = m, q, u, du, t
        self.known: dict[str, Any] = {**m.values, "t": Jet(t, 1.0)}
        self.T: dict[str, Jet] = {"ground": placed()}
        self.J: dict[str, Jet] = {}
        self.P: dict[str, Jet] = {}
        rates: list[Array] = []
        i = k = 0
        moving: dict[str, Jet] = {}
        for joint in m.scene.moving:
            nq, nv = len(joint.coordinates), velocities_of(joint)
            moving[joint.name] = coordinates(joint, q[i : i + nq], u[k : k + nv], du[k : k + nv])
            self.known |= {name: moving[joint.name][j] for j, name in enumerate(joint.coordinates)}
            self.known |= {name: Jet(u[k + j], du[k + j]) for j, name in enumerate(joint.rates)}
            rates.append(moving[joint.name].v)
            i, k = i + nq, k + nv
        self.moving, self.rates = moving, np.concatenate(rates)
        for joint in m.scene.joints:
            if joint.coupling is not None:
                moving[joint.name] = stack([self.position(joint)])
            X = motion(joint, moving.get(joint.name, Jet(np.zeros(0))), m.values)
            self.J[joint.name] = self.T[joint.parent] @ m.frames[joint.name][0]
            self.P[joint.name] = self.J[joint.name] @ X
            self.T[joint.child] = self.P[joint.name] @ m.frames[joint.name][1]

    def position(self, joint: Any) -> Jet:
        """Return the position of a joint with one freedom."""
        if joint.coupling is None:
            return self.known[joint.coordinates[0]]
        led = (value(ratio, self.m.values) * self.known[q] for q, ratio in joint.coupling.ratios)
        return sum(led, value(joint.coupling.offset, self.m.values))

    def own(self, velocities: Array) -> Array:
        """Return own rates of joints from velocities."""
        return np.array([sum(velocities[k] * x for k, x in terms) for terms in self.m.own])

    # Twists

    def twist(self, body: str) -> tuple[Jet, Jet]:
        """Return velocity of the origin and angular velocity, with their rates."""
        T = self.T[body]
        R = T[:3, :3]
        spin = R.rate @ Jet(R.x, R.v).T
        omega = stack([spin[2, 1], spin[0, 2], spin[1, 0]])
        return T[:3, 3].rate, omega

    def twists(self) -> tuple[Array, Array]:
        """Return the twists of all bodies and their rates, each (6n,)."""
        pairs = [self.twist(body) for body in self.m.bodies]
        return tuple(np.concatenate([getattr(x, part) for pair in pairs for x in pair]) for part in ("x", "v"))  # type: ignore[return-value]

    @cached_property
    def tree(self) -> tuple[Array, Array, Array]:
        """Return D of every joint of the tree, (6n, 6n), S of all own rates, (6n, r), and these for unit u, (r, nv)."""
        joints = self.m.scene.joints
        D = np.vstack([self.D(j.parent, j.child, self.P[j.name].x[:3, 3]) for j in joints])
        S = np.zeros((6 * len(joints), len(self.m.own)))
        for k, joint in enumerate(joints):
            S[6 * k : 6 * k + 6, list(self.m.own_rates(joint))] = self.S(joint)
        return D, S, np.array([self.own(one) for one in np.eye(len(self.u))]).T.reshape(-1, len(self.u))

    @cached_property
    def columns(self) -> Array:
        """The twists of all bodies for unit velocities, (6n, nv)."""
        D, S, own = self.tree
        return np.linalg.solve(D, S @ own)

    def velocity(self, body: str, point: Jet) -> Jet:
        """Return the velocity of the body's material point that is at a place, and its rate as the place moves."""
        if body == "ground":
            return Jet(np.zeros(3))
        v, omega = self.twist(body)
        return v + cross(omega, Jet(point.x, point.v) - self.T[body][:3, 3])

    def spin(self, body: str) -> Jet:
        """Return the angular velocity."""
        return Jet(np.zeros(3)) if body == "ground" else self.twist(body)[1]

    def D(self, parent: str, child: str, point: Array) -> Array:
        """Return the matrix of the relative twist at a point."""
        D = np.zeros((6, 6 * len(self.m.bodies)))
        for body, sign in ((child, 1), (parent, -1)):
            if body != "ground":
                k = 6 * self.m.bodies.index(body)
                D[:, k : k + 6] += sign * np.eye(6)
                D[:3, k + 3 : k + 6] -= sign * tilde(point - self.T[body].x[:3, 3])
        return D

    def S(self, joint: Any) -> Array:
        """Return the twists of a joint's unit rates, at the origin of the moved joint frame."""
        q, R = self.moving.get(joint.name, Jet(np.zeros(0))).x, self.J[joint.name].x[:3, :3]
        columns = []
        for one in np.eye(len(self.m.own_rates(joint))):
            at = coordinates(joint, q, one, 0 * one) if joint.coupling is None else Jet(q, one)
            X = motion(joint, at, self.m.values)
            spin = X.v[:3, :3] @ X.x[:3, :3].T
            columns.append(np.concatenate([R @ X.v[:3, 3], R @ [spin[2, 1], spin[0, 2], spin[1, 0]]]))
        return np.array(columns).T.reshape(6, -1)

    # Contacts

    def contacts(self) -> list[Contact]:
        """Return loops, then wheels and blades, in declared order."""
        return [self.loop(joint) for joint in self.m.scene.loops] + [
            {"rolling": self.wheel, "knife_edge": self.blade, "rope": self.rope}[row.kind](row)
            for row in self.m.scene.constraints
            if row.kind != "formula"
        ]

    def loop(self, joint: Any) -> Contact:
        """Return a joint that closes a loop."""
        origin, tip = self.m.frames[joint.name]
        J, P = self.T[joint.parent] @ origin, self.T[joint.child] @ inverse(tip)
        X, R = inverse(J) @ P, J[:3, :3]
        along = [(R @ F, R @ N) for F, N in wrenches(joint, X, self.m.values)]
        frames = (R.x, self.T[joint.child].x[:3, :3])
        return Contact(
            joint.name, joint.parent, joint.child, P[:3, 3], along, residual(joint, X, self.m.values), frames
        )

    def blade(self, row: Any) -> Contact:
        """Return a knife edge: its point has no velocity along the axis, across the blade."""
        T, body = self.T[row.place.body], row.plane.body
        a, p = T[:3, :3] @ unit(row.axis), self.point(row.place)
        return Contact(row.name, body, row.place.body, p, forces(a), [], (self.T[body].x[:3, :3], T.x[:3, :3]))

    def rope(self, row: Any) -> Contact:
        """Return a rope through points: its tension draws neighbours together, and its length is kept."""
        parts, gap = [], jet(number(row.length, self.m.values))
        for a, b, way, length in self.straight(row):
            gap, frames = gap - length, (self.T[a.body].x[:3, :3], self.T[b.body].x[:3, :3])
            parts.append(Contact(row.name, a.body, b.body, self.point(b), forces(-(way / length)), [], frames))
        return replace(parts[0], residual=[gap], parts=parts)

    def straight(self, rope: Any) -> Iterator[tuple[Any, Any, Jet, Jet]]:
        """Yield neighbours of a rope, or of a spring between points, the way from one to the other, and its length."""
        for a, b in pairwise(rope.ends):
            if a.turn or b.turn:
                raise LookupError("the reference knows no rope around a wheel")
            way = self.point(b) - self.point(a)
            if not np.any(way.x):
                raise NoDirection(rope.name)
            yield a, b, way, apply("SQRT", way @ way)

    def wheel(self, row: Any) -> Contact:
        """Return a wheel, or a ball (no axis), that rolls on a plane of the ground or of another body.

        The height of its lowest point over the plane is a matter of position where "normal" is among its components.
        """
        body, T, r = row.plane.body, self.T[row.place.body], value(row.radius, self.m.values)
        O, n = self.point(row.place), self.T[body][:3, :3] @ unit(row.plane.normal)  # noqa: E741  the wheel's centre
        height = n @ (O - self.point(row.plane))
        if row.axis is None:
            x = cross(n, jet(np.eye(3)[np.argmin(abs(n.x))]))
            x, C, height = x / apply("SQRT", x @ x), O - r * n, height - r
        else:
            a = T[:3, :3] @ unit(row.axis)
            x = cross(a, n)
            if np.linalg.norm(x.x) < FLAT:
                raise NoDirection(row.name)
            w = apply("SQRT", x @ x)
            x, C, height = x / w, O - r * ((n - (n @ a) * a) / w), height - r * w
        ways = {"along": x, "across": cross(n, x), "normal": n}
        frames, above = (self.T[body].x[:3, :3], T.x[:3, :3]), [height] if "normal" in row.components else []
        return Contact(row.name, body, row.place.body, C, forces(*(ways[one] for one in row.components)), above, frames)

    def point(self, place: Any) -> Jet:
        """Return where a declared place is."""
        T = self.T[place.body]
        return T[:3, :3] @ self.m.vector(place.at) + T[:3, 3]

    def forbidden(self, contacts: Sequence[Contact]) -> tuple[Array, Array]:
        """Return the rows of contacts on the twists of all bodies, and the rates of their velocities."""
        rows, rates = [np.zeros((0, 6 * len(self.m.bodies)))], []
        for whole in contacts:
            each, bias = [], np.zeros(len(whole.wrenches))
            for one in whole.parts or [whole]:
                v = self.velocity(one.child, one.point) - self.velocity(one.parent, one.point)
                omega = self.spin(one.child) - self.spin(one.parent)
                bias = bias + [float((Jet(F.x, F.v) @ v + Jet(N.x, N.v) @ omega).v) for F, N in one.wrenches]
                each.append(one.acting @ self.D(one.parent, one.child, one.point.x))
            rates += list(bias)
            rows.append(sum(each))
        return np.vstack(rows), np.array(rates)

    def formulas(self) -> tuple[Array, Array]:
        """Return coefficients (m, nv) and biases of the rows that are formulas."""
        rows = [row for row in self.m.scene.constraints if row.kind == "formula"]
        units = [{**self.known, **dict(zip(self.m.names, one, strict=True))} for one in np.eye(len(self.u))]
        a = np.array([[number(row.formula, known) for known in units] for row in rows]).reshape(len(rows), len(units))
        return a, np.array([float(value(row.formula, self.known).v) for row in rows])

    # What acts

    def inertias(self) -> tuple[Array, Array]:
        """Return the (6n, 6n) matrix M and the (6n,) products of velocities b: M ν̇ + b is what acts."""
        n = len(self.m.bodies)
        M, b = np.zeros((6 * n, 6 * n)), np.zeros(6 * n)
        for k, body in enumerate(self.m.bodies):
            (m, h, about), R = self.m.inertia[body], self.T[body].x[:3, :3]
            omega, h, about = self.twist(body)[1].x, R @ h, R @ about @ R.T
            i = slice(6 * k, 6 * k + 6)
            M[i, i] = np.block([[m * np.eye(3), -tilde(h)], [tilde(h), about]])
            b[i] = np.concatenate([np.cross(omega, np.cross(omega, h)), np.cross(omega, about @ omega)])
        return M, b

    def weights(self) -> Array:
        """Return the wrenches of gravity, (6n,)."""
        parts = []
        for body in self.m.bodies:
            (m, h, _), R = self.m.inertia[body], self.T[body].x[:3, :3]
            parts += [m * self.m.gravity, np.cross(R @ h, self.m.gravity)]
        return np.concatenate(parts)

    def rotors(self) -> tuple[Array, Array]:
        """Return what rotors add to the mass matrix of own rates, (r, r), and to forces along them at u̇ = 0, (r,).

        A joint's rotor resists its own rate, a ball's its angular velocity relative to the parent.
        """
        n = len(self.m.own)
        matrix, forces = np.zeros((n, n)), np.zeros(n)
        for joint in self.m.scene.joints:
            own, a = list(self.m.own_rates(joint)), number(joint.armature, self.m.values)
            spins, bent = np.eye(len(own)), np.zeros(len(own))
            if joint.type == "spherical":
                R = motion(joint, self.moving[joint.name], self.m.values)[:3, :3]
                turned = (R.rate @ Jet(R.x, R.v).T).v
                spins = self.S(joint)[3:]
                bent = self.J[joint.name].x[:3, :3] @ [turned[2, 1], turned[0, 2], turned[1, 0]]
            matrix[np.ix_(own, own)] = a * spins.T @ spins
            forces[own] = a * spins.T @ bent
        return matrix, forces

    def pulls(self) -> tuple[Array, Array]:
        """Return what springs exert on bodies, (6n,), and at joints along their own rates."""
        return self._elements(("spring", "elastic"), self.tension)

    def drags(self) -> tuple[Array, Array]:
        """Return what dampers, friction, declared forces and loads exert, as `pulls` does."""
        bodies, joints = self._elements(("damper", "damping"), self.resistance)
        for load in self.m.scene.loads:
            if load.kind == "flow":
                bodies += self.flow(load)
                continue
            R = self.T[load.place.body].x[:3, :3] if load.frame == "body" else np.eye(3)
            F, C = (R @ [number(x, self.known) for x in part] for part in (load.force, load.couple))
            bodies += self.D("ground", load.place.body, self.point(load.place).x).T @ np.concatenate([F, C])
        own = self.own(self.u)
        for joint in self.m.scene.joints:
            for k, i in enumerate(self.m.own_rates(joint)):
                joints[i] += number(joint.forces[k], self.known) if joint.forces else 0.0
                joints[i] -= number(joint.damping, self.m.values) * own[i] + self.friction(joint, own[i])
        return bodies, joints

    def flow(self, one: Any) -> Array:
        """Return what matter does that leaves or arrives, (6n,): μ (u + 2 ω × ρ), and -μ ρ × (ω × ρ) - J' ω about P."""
        body = next(body for body in self.m.scene.bodies if body.name == one.place.body)
        R, omega = self.T[body.name].x[:3, :3], self.twist(body.name)[1].x
        P = (
            self.T[body.name][:3, :3] @ self.m.vector(body.com if one.spread else one.place.at)
            + self.T[body.name][:3, 3]
        )
        rho = P.x - (R @ self.m.vector(body.com) + self.T[body.name].x[:3, 3])
        mu, u = number(one.flux, self.known), np.array([number(x, self.known) for x in one.velocity])
        u = R @ u if one.frame == "body" else u - self.velocity(body.name, P).x
        xx, yy, zz, xy, xz, yz = (number(x, self.known) for x in one.spun)
        spun = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T @ omega
        F, N = mu * (u + 2 * np.cross(omega, rho)), -mu * np.cross(rho, np.cross(omega, rho)) - spun
        return self.D("ground", body.name, P.x).T @ np.concatenate([F, N])

    def _elements(self, kinds: tuple[str, str], law: Any) -> tuple[Array, Array]:
        bodies, joints = np.zeros(6 * len(self.m.bodies)), np.zeros(len(self.m.own))
        for one in (strut for strut in self.m.scene.struts if strut.kind in kinds):
            if one.joint:
                joint = next(joint for joint in self.m.scene.joints if joint.name == one.joint)
                joints[self.m.first[joint.name]] -= law(one, self.position(joint))
                continue
            parts = list(self.straight(one))
            size = law(one, sum((length for *_, length in parts), jet(0.0)))
            for a, b, way, length in parts:
                if length.x < MEET and abs(size) > MEET:  # rounding decides where it pulls
                    raise NoDirection(one.name)
                for end, sign in ((a, 1), (b, -1)):
                    if end.body != "ground":
                        force = sign * size * way.x / length.x
                        bodies += self.D("ground", end.body, self.point(end).x)[:3].T @ force
        return bodies, joints

    def tension(self, spring: Any, length: Jet) -> float:
        """Return preload + k1 x + k2 x² + …"""
        x = float(length.x) - number(spring.free, self.m.values)
        terms = [number(k, self.m.values) * x**i for i, k in enumerate(spring.stiffness, 1)]
        return number(spring.preload, self.m.values) + sum(terms)

    def stored(self, spring: Any) -> float:
        """Return the energy of a spring."""
        if spring.joint:
            way = self.position(next(joint for joint in self.m.scene.joints if joint.name == spring.joint)).x
        else:
            way = sum(np.linalg.norm(self.point(b).x - self.point(a).x) for a, b in pairwise(spring.ends))
        x = float(way) - number(spring.free, self.m.values)
        terms = [number(k, self.m.values) * x ** (i + 1) / (i + 1) for i, k in enumerate(spring.stiffness, 1)]
        return number(spring.preload, self.m.values) * x + sum(terms)

    def resistance(self, damper: Any, length: Jet) -> float:
        """Return c1 v + c3 v³ + …"""
        return sum(number(c, self.m.values) * float(length.v) ** (2 * i + 1) for i, c in enumerate(damper.damping))

    def friction(self, joint: Any, rate: float) -> float:
        """Return dry friction: Coulomb's and Stribeck's, with a sign that may be smooth."""
        if joint.dry is None:
            return 0.0
        size, smoothing = number(joint.dry.coulomb, self.m.values), number(joint.dry.smoothing, self.m.values)
        if joint.dry.static is not None:
            slow = rate / number(joint.dry.stribeck, self.m.values)
            size += (number(joint.dry.static, self.m.values) - size) * math.exp(-(slow**2))
        return size * (math.tanh(rate / smoothing) if smoothing else np.sign(rate))
