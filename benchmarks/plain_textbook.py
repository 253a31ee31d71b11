"""The textbook's algorithms in NumPy arrays of 3 x 3 matrices, over the frames and inertias that a scene declares.

They share the scene's numbers with symdyn and no algorithm, and run in two kinds of arithmetic: float64, and 50 digits.
There the sines and the scene's numbers are mpmath's, while sums, products and quotients are those of Python's decimal:
rounded as mpmath's are, and several times as fast. Call them in a context of that precision.

    inverse dynamics     Newton and Euler about the centres of mass: Craig, Introduction to Robotics (2005), 6.45-6.53
    M(q)                 composite rigid bodies: Featherstone, Rigid Body Dynamics Algorithms (2008), table 6.2
    forward dynamics     M = Lᵀ D L from the tips, table 6.3, and the bias by inverse dynamics at rest

    i, p        a moving body and its parent; body 0 is the ground
    R, r        placement of frame i in frame p at q, batches first: (N, 3, 3) and (N, 3)
    w, dw, a    angular velocity and acceleration, acceleration of the origin, in frame i; ground has a = -g
    m, c, Ic    mass, centre of mass, inertia about it;   h = m c, I the inertia about the origin
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

import numpy as np

from symdyn.algebra import BigFloats
from symdyn.dynamics import Workspace
from symdyn.graph import evaluate
from symdyn.scene import Scene

Array = np.ndarray[Any, Any]

DIGITS = 50
BIG = BigFloats(DIGITS + 10)


def big_number(x: Any) -> Decimal:
    """Return an mpmath number with all digits that count."""
    return Decimal(BIG.context.nstr(x, DIGITS + 5))


SIN = {"big": np.frompyfunc(lambda x: big_number(BIG.context.sin(float(x))), 1, 1), "double": np.sin}
COS = {"big": np.frompyfunc(lambda x: big_number(BIG.context.cos(float(x))), 1, 1), "double": np.cos}


@dataclass(frozen=True)
class Textbook:
    """A scene's numbers, for one kind of arithmetic.

    Attributes:
        kind: "big" (Decimal) or "double".
        parent: entry 0 is the ground.
        slides: whether joint i is prismatic.
        axis: of joint i in frame i.
        B: constant rotations and shifts of the joint frames in their parents', joints at zero.
        m, c, Ic, h, I: of body i, see the module's legend.
        armature: inertia of the rotors.
        gravity: acceleration of free fall.
    """

    kind: str
    parent: tuple[int, ...]
    slides: tuple[bool, ...]
    axis: list[Array]
    B: list[tuple[Array, Array]]
    m: list[Any]
    c: list[Array]
    Ic: list[Array]
    h: list[Array]
    I: list[Array]  # noqa: E741
    armature: list[Any]
    gravity: Array

    @property
    def moving(self) -> range:
        """The moving bodies, ground first."""
        return range(1, len(self.parent))

    def placements(self, q: Array) -> list[tuple[Array, Array]]:
        """Return R and r of every moving body; entry 0 is unused."""
        s, c = SIN[self.kind](q), COS[self.kind](q)
        found = [self.B[0]]
        for i in self.moving:
            (R, r), u, k = self.B[i], self.axis[i], i - 1
            if self.slides[i]:
                found.append((np.broadcast_to(R, (len(q), 3, 3)), r + np.outer(q[:, k], R @ u)))
                continue
            along = np.outer(u, u)
            turn = along + c[:, k, None, None] * (np.eye(3, dtype=int) - along) + s[:, k, None, None] * tilde(u)
            found.append((R @ turn, np.broadcast_to(r, (len(q), 3))))
        return found

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array, gravity: bool = True) -> Array:
        """Return τ, shape (N, n)."""
        T, still = self.placements(q), np.zeros_like(q[:, :1]) * self.gravity
        w, dw, a = [still], [still], [still - self.gravity * int(gravity)]
        for i in self.moving:
            p, (R, r), u = self.parent[i], T[i], self.axis[i]
            v, dv = qd[:, i - 1 : i] * u, qdd[:, i - 1 : i] * u
            w_p, dw_p = back(R, w[p]), back(R, dw[p])
            a_p = back(R, a[p] + np.cross(dw[p], r) + np.cross(w[p], np.cross(w[p], r)))
            if self.slides[i]:
                w.append(w_p)
                dw.append(dw_p)
                a.append(a_p + 2 * np.cross(w_p, v) + dv)
            else:
                w.append(w_p + v)
                dw.append(dw_p + np.cross(w_p, v) + dv)
                a.append(a_p)
        f, n = [still] * len(T), [still] * len(T)
        for i in self.moving:
            c = self.c[i]
            a_c = a[i] + np.cross(dw[i], c) + np.cross(w[i], np.cross(w[i], c))
            f[i] = self.m[i] * a_c
            n[i] = dw[i] @ self.Ic[i] + np.cross(w[i], w[i] @ self.Ic[i]) + np.cross(c, f[i])
        tau = np.zeros_like(q)
        for i in reversed(self.moving):
            p, (R, r) = self.parent[i], T[i]
            tau[:, i - 1] = (f[i] if self.slides[i] else n[i]) @ self.axis[i] + self.armature[i] * qdd[:, i - 1]
            force = out(R, f[i])
            f[p], n[p] = f[p] + force, n[p] + out(R, n[i]) + np.cross(r, force)
        return tau

    def mass_matrix(self, q: Array) -> Array:
        """Return M, shape (N, n, n)."""
        T, N = self.placements(q), len(q)
        m, h = list(self.m), [np.broadcast_to(x, (N, 3)) for x in self.h]
        I = [np.broadcast_to(x, (N, 3, 3)) for x in self.I]  # noqa: E741
        M = np.zeros((N, q.shape[1], q.shape[1]), q.dtype)
        for i in reversed(self.moving):
            u = self.axis[i] + 0 * h[i]
            f, n = (m[i] * u, np.cross(h[i], u)) if self.slides[i] else (np.cross(u, h[i]), out(I[i], u))
            j = i
            while j:
                M[:, i - 1, j - 1] = M[:, j - 1, i - 1] = (f if self.slides[j] else n) @ self.axis[j]
                R, r = T[j]
                f = out(R, f)
                n, j = out(R, n) + np.cross(r, f), self.parent[j]
            M[:, i - 1, i - 1] += self.armature[i]
            p, (R, r) = self.parent[i], T[i]
            turned, S = out(R, h[i]), tilde(r)
            I[p] = I[p] + R @ I[i] @ np.swapaxes(R, -1, -2) - S @ tilde(turned) - tilde(turned + m[i] * r) @ S
            h[p], m[p] = h[p] + turned + m[i] * r, m[p] + m[i]
        return M

    def forward_dynamics(self, q: Array, qd: Array, tau: Array) -> Array:
        """Return q̈, shape (N, n)."""
        return solve(self.mass_matrix(q), tau - self.inverse_dynamics(q, qd, np.zeros_like(q)))

    def gravity_forces(self, q: Array) -> Array:
        """Return g, shape (N, n)."""
        return self.inverse_dynamics(q, np.zeros_like(q), np.zeros_like(q))

    def velocity_forces(self, q: Array, qd: Array) -> Array:
        """Return c, shape (N, n)."""
        return self.inverse_dynamics(q, qd, np.zeros_like(q), gravity=False)

    def momentum(self, q: Array, qd: Array) -> Array:
        """Return M q̇, shape (N, n)."""
        return out(self.mass_matrix(q), qd)

    def kinetic_energy(self, q: Array, qd: Array) -> Array:
        """Return q̇ᵀ M q̇ / 2, shape (N,)."""
        return np.sum(qd * self.momentum(q, qd), axis=1) / 2

    def reference(self, q: Array, qd: Array, qdd: Array, tau: Array) -> dict[str, Array]:
        """Return all outputs at once."""
        M, c, g = self.mass_matrix(q), self.velocity_forces(q, qd), self.gravity_forces(q)
        p = out(M, qd)
        return {
            "inverse_dynamics": out(M, qdd) + c + g,
            "mass_matrix": M,
            "forward_dynamics": solve(M, tau - c - g),
            "gravity_forces": g,
            "velocity_forces": c,
            "momentum": p,
            "kinetic_energy": np.sum(qd * p, axis=1) / 2,
        }


def solve(M: Array, b: Array) -> Array:
    """Return M⁻¹ b of every state by M = Lᵀ D L."""
    H, x, n = M.copy(), b.copy(), range(b.shape[1])
    for k in reversed(n):
        for i in reversed(range(k)):
            factor = H[:, k, i] / H[:, k, k]
            for j in reversed(range(i + 1)):
                H[:, i, j] -= factor * H[:, k, j]
            H[:, k, i] = factor
    for i in reversed(n):  # Lᵀ y = b
        for j in range(i):
            x[:, j] -= H[:, i, j] * x[:, i]
    for i in n:  # D z = y
        x[:, i] /= H[:, i, i]
    for i in n:  # L x = z
        for j in range(i):
            x[:, i] -= H[:, i, j] * x[:, j]
    return x


def out(R: Array, x: Array) -> Array:
    """Return R x of every state."""
    return (R @ x[..., None])[..., 0]


def back(R: Array, x: Array) -> Array:
    """Return Rᵀ x of every state."""
    return out(np.swapaxes(R, -1, -2), x)


def tilde(x: Array) -> Array:
    """Return the matrix of x ×."""
    zero = 0 * x[..., 0]
    rows = ((zero, -x[..., 2], x[..., 1]), (x[..., 2], zero, -x[..., 0]), (-x[..., 1], x[..., 0], zero))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def textbooks(scene: Scene) -> tuple[Textbook, Textbook]:
    """Return a scene without free parameters in 50 digits, and every number of it rounded to double."""
    tree = Workspace(scene).tree
    parameters = {
        tree.graph.symbol(p.name): evaluate([p.value.express(tree.graph)], BIG, {})[0]
        for p in scene.parameters
        if p.value is not None
    }

    def values(nodes: Sequence[Any], *shape: int) -> Array:
        found = evaluate(nodes, BIG, parameters)
        return np.array([big_number(x) for x in found], dtype=object).reshape(shape)

    def flat(matrix: Sequence[Sequence[Any]]) -> list[Any]:
        return [x for row in matrix for x in row]

    m = [values([body.m], 1)[0] for body in tree.inertia]
    h = [values(body.h, 3) for body in tree.inertia]
    I = [values(flat(body.I), 3, 3) for body in tree.inertia]  # noqa: E741
    c = [x / mass if mass else x for x, mass in zip(h, m, strict=True)]
    Ic = [full + mass * tilde(at) @ tilde(at) for full, mass, at in zip(I, m, c, strict=True)]
    slides = tuple(all(x.is_zero for x in turn) for turn, _ in tree.S)
    big = Textbook(
        kind="big",
        parent=tree.parent,
        slides=slides,
        axis=[values(S[slide], 3) for S, slide in zip(tree.S, slides, strict=True)],
        B=[(values(flat(T.R), 3, 3), values(T.p, 3)) for T in tree.base],
        m=m,
        c=c,
        Ic=Ic,
        h=h,
        I=I,
        armature=list(values(tree.armature, len(tree.parent))),
        gravity=values(tree.gravity, 3),
    )
    rounded: dict[str, Any] = {name: [np.array(x, dtype=float) for x in getattr(big, name)] for name in
                               ("axis", "m", "c", "Ic", "h", "I", "armature")}  # fmt: skip
    B = [(np.array(R, dtype=float), np.array(r, dtype=float)) for R, r in big.B]
    return big, replace(big, kind="double", B=B, gravity=np.array(big.gravity, dtype=float), **rounded)
