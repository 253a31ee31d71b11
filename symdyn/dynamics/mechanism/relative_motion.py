"""Motion of one frame relative to another, along the tree."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from symdyn.dynamics.mechanism.tree import Tree
from symdyn.frozen import dataclass
from symdyn.graph import Expr
from symdyn.spatial import Transform, Vec, add, cross, dot, neg, scale, sub, zero_vector

Twist = tuple[Vec, Vec]  # angular, linear


@dataclass(frozen=True)
class Relative:
    """Motion of the child relative to J, axes of J: its twist at P by unit velocity, and (α, that of P) at u̇ = 0."""

    X: Transform
    columns: dict[int, Twist]
    acceleration: Twist

    def twist(self, u: Sequence[Expr]) -> Twist:
        """Return (ω, Ṗ)."""
        graph = self.X.p[0].graph
        omega, v = zero_vector(graph), zero_vector(graph)
        for k, (z, s) in self.columns.items():
            omega, v = add(omega, scale(u[k], z)), add(v, scale(u[k], s))
        return omega, v


Seat = tuple[str, Transform]  # a body, and a frame in it


def relative_motion(
    tree: Tree, parent: Seat, child: Seat, speeds: Callable[[], tuple[list[Expr], list[Expr]]]
) -> Relative:
    """Return the motion of the child relative to J: inwards to the lowest common ancestor, then outwards.

    J is the parent's frame, and P the origin of the child's. `speeds` are the rate of every elementary joint, and the
    part of its acceleration that is quadratic in velocities.
    """
    graph = tree.graph
    (body, on_parent), (other, on_child) = parent, child
    i, at_parent = tree.home[body]
    j, at_child = tree.home[other]
    last = at_child @ on_child
    inner, outer = tree.paths(i, j)
    rate, accelerated = speeds()
    T = (at_parent @ on_parent).inverse()  # pose of the current frame in J
    still = zero_vector(graph)
    omega, alpha = still, still  # of the current body
    a = still  # acceleration of its origin
    axes: list[tuple[int, Vec, Vec]] = []  # elementary joint, its axis z, s
    steps = [T.p]  # from J to the first origin, from there to the next, ..., to P
    for b in inner:  # to the common ancestor: the joint backwards
        z, s = (neg(T.R @ part) for part in tree.S[b])
        axes.append((b, z, s))
        omega, alpha, a = _moved(omega, alpha, a, z, s, rate[b], accelerated[b])
        step = tree.T[b].inverse()
        steps.append(T.R @ step.p)
        a = add(a, _swing(omega, alpha, steps[-1]))
        T = T @ step
    for b in outer:
        steps.append(T.R @ tree.T[b].p)
        a = add(a, _swing(omega, alpha, steps[-1]))
        T = T @ tree.T[b]
        z, s = (T.R @ part for part in tree.S[b])
        axes.append((b, z, s))
        omega, alpha, a = _moved(omega, alpha, a, z, s, rate[b], accelerated[b])
    steps.append(T.R @ last.p)
    a = add(a, _swing(omega, alpha, steps[-1]))
    # a joint inwards is about the origin at which its step begins, one outwards about that at which it ends
    levers = [still]
    for d in reversed(steps[1:]):
        levers.append(add(levers[-1], d))
    levers.reverse()  # from the k-th origin to P
    columns: dict[int, Twist] = {}
    for place_of, (b, z, s) in enumerate(axes):
        lever = levers[place_of] if place_of < len(inner) else levers[place_of + 1]
        linear = add(s, cross(z, lever))
        for k, x in tree.A[b]:
            so_far = columns.get(k, (still, still))
            columns[k] = (add(so_far[0], scale(x, z)), add(so_far[1], scale(x, linear)))
    X = Transform(T.R @ last.R, add(steps[0], levers[0]))
    return Relative(X, dict(sorted(columns.items())), (alpha, a))


def _swing(omega: Vec, alpha: Vec, d: Vec) -> Vec:
    """Return α × d + ω × (ω × d), the last as (ω·d) ω - ω² d: one product less for planar motion."""
    turned = sub(scale(dot(omega, d), omega), scale(dot(omega, omega), d))
    return add(cross(alpha, d), turned)


def _moved(omega: Vec, alpha: Vec, a: Vec, z: Vec, s: Vec, rate: Expr, accelerated: Expr) -> tuple[Vec, Vec, Vec]:
    """Return ω, α, a of the successor of an elementary joint about or along an axis through the origin."""
    slide, spin = scale(rate, s), scale(rate, z)
    a = add(a, add(scale(2, cross(omega, slide)), scale(accelerated, s)))
    alpha = add(alpha, add(cross(omega, spin), scale(accelerated, z)))
    return add(omega, spin), alpha, a
