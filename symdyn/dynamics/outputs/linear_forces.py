"""The parameters that a scene's driving forces are linear in, as symbols: what columns of regressors stand for.

    τ = Y(q, q̇, q̈) π + r           r: what depends on none of π

Parameters that forces are not linear in, such as a spring's free length, keep their values. Where two of them multiply
each other, the first is a column and the other one keeps its value.

Reference: Atkeson, An and Hollerbach, Estimation of inertial parameters of manipulator loads and links (1986).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from symdyn.dynamics.mechanism.tree import body_inertia
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr, gradient, reachable, substitute
from symdyn.scene import with_force_parameters
from symdyn.spatial import Inertia


@dataclass(frozen=True)
class Linear:
    """A scene whose linear parameters are symbols.

    Attributes:
        workspace: of that scene.
        columns: names of the parameters that are columns.
        known: what the other symbols stand for.
        declared: values of the columns' parameters as the scene declares them.
        requesting: the workspace whose scene it is, with values.
    """

    workspace: Workspace
    columns: tuple[str, ...]
    known: dict[Expr, Expr]
    declared: tuple[Expr, ...]
    requesting: Workspace

    @classmethod
    def of(cls, w: Workspace) -> Linear:
        """Return the linear parameters of a workspace's scene, found once."""
        found: Linear = w.once(linear)
        return found

    def parameters(self) -> list[Expr]:
        """Return π, what the columns of the regressor are to be multiplied by, on the graph that was asked."""
        return substitute(self.declared, {}, self.requesting.graph)

    def named(self) -> tuple[tuple[str, Expr], ...]:
        """Return name and value of every column."""
        return tuple(zip(self.columns, self.parameters(), strict=True))

    def remainder(self, of: Callable[[Workspace], Sequence[Expr]] | None = None) -> list[Expr]:
        """Return r, the driving forces where all of π is zero, shape (n,), N m or N; or what else is linear in π."""
        there = self.workspace
        nothing = {there.graph.symbol(name): there.graph.zero for name in self.columns}
        return substitute(substitute((of or driving)(there), {**self.known, **nothing}), {}, self.requesting.graph)

    def slopes(self, entries: Sequence[Expr]) -> list[list[Expr]]:
        """Return the derivatives of entries by the columns, a row an entry."""
        symbols = [self.workspace.graph.symbol(name) for name in self.columns]
        rows = [gradient(entry, symbols) for entry in entries]
        flat = iter(substitute([one for row in rows for one in row], self.known))
        return [[next(flat) for _ in symbols] for _ in rows]


def linear(w: Workspace) -> Linear:
    """Return the scene's linear parameters."""
    scene = w.scene
    opened = with_force_parameters(scene)
    there = Workspace(opened, w.closing)
    own = [p.name for p in scene.parameters if p.name in {q.name for q in opened.parameters}]
    added = [p for p in opened.parameters if p.name not in own]
    values = {p.name: p.value.express(there.graph) for p in added if p.value is not None}
    ten = {p.name for p in added if p.value is None}
    symbols = {name: there.graph.symbol(name) for name in (*(p.name for p in added), *own)}
    kept: list[str] = []
    for name, slopes in _slopes(driving(there), symbols):
        met = {str(node.value) for node in reachable(slopes) if node in symbols.values()}
        if not met & {name, *kept} and (name in ten or any(not slope.is_zero for slope in slopes)):
            kept.append(name)  # all ten of a body, whether they are felt or not
    known = {symbols[name]: value for name, value in values.items() if name not in kept}
    declared = [entry for body in scene.bodies for entry in _declared(body_inertia(body, there.graph))]
    declared += [values.get(name, symbols[name]) for name in kept if name not in ten]
    return Linear(there, tuple(kept), known, tuple(declared), w)


def _declared(body: Inertia) -> tuple[Expr, ...]:
    """Return the ten of a body about its frame, in the order of `INERTIAL`."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.I
    return (body.m, *body.h, xx, yy, zz, xy, xz, yz)


def _slopes(forces: Sequence[Expr], symbols: dict[str, Expr]) -> list[tuple[str, list[Expr]]]:
    rows = [gradient(force, list(symbols.values())) for force in forces]
    return [(name, [row[k] for row in rows]) for k, name in enumerate(symbols)]


def driving(w: Workspace) -> list[Expr]:
    """Return the driving forces by recursion, shape (n,); N m or N."""
    return w.forces(list(w.state.qdd))


def lagrange_driving(w: Workspace) -> list[Expr]:
    """Return the driving forces by Lagrange's equations, shape (n,); N m or N."""
    return w.energy.driving_forces()


def columns(w: Workspace) -> tuple[str, ...]:
    """Return a label for each parameter that is a column of the regressor."""
    return Linear.of(w).columns
