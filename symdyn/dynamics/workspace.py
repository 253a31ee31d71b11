"""What several outputs of one derivation share, computed when first asked for."""

from __future__ import annotations

from functools import cached_property

from symdyn.dynamics import lagrange
from symdyn.dynamics.christoffel import Christoffel, christoffel
from symdyn.dynamics.crba import crba
from symdyn.dynamics.lagrange import Energies, energies
from symdyn.dynamics.rnea import rnea
from symdyn.dynamics.state import State, generalized_forces, state_symbols
from symdyn.dynamics.tree import Tree, build_tree
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene

Matrix = list[list[Expr]]


class Workspace:
    """One scene on one graph."""

    def __init__(self, scene: Scene) -> None:
        """Start with an empty graph."""
        self.scene = scene
        self.graph = Graph()
        self.state: State = state_symbols(scene, self.graph)
        self.still: list[Expr] = [self.graph.zero] * self.state.n

    @cached_property
    def Q(self) -> list[Expr]:
        """Declared generalized forces, shape (n,)."""
        return generalized_forces(self.scene, self.graph)

    # Lagrange road

    @cached_property
    def energy(self) -> Energies:
        """K and P from positions."""
        return energies(self.scene, self.graph)

    @cached_property
    def lagrange_mass(self) -> Matrix:
        """M as the Hessian of K, shape (n, n)."""
        return lagrange.mass_matrix(self.energy)

    @cached_property
    def lagrange_christoffel(self) -> Christoffel:
        """Christoffel symbols of that M."""
        return christoffel(self.lagrange_mass, self.state.q)

    # Recursive road

    @cached_property
    def tree(self) -> Tree:
        """The kinematic tree."""
        return build_tree(self.scene, self.graph)

    @cached_property
    def composite_mass(self) -> Matrix:
        """M by the composite-rigid-body algorithm, shape (n, n)."""
        return crba(self.tree)

    @cached_property
    def composite_christoffel(self) -> Christoffel:
        """Christoffel symbols of that M."""
        return christoffel(self.composite_mass, self.state.q)

    def velocity_forces(self, qd: list[Expr]) -> list[Expr]:
        """Return c(q, q̇) at the given velocities, shape (n,)."""
        return rnea(self.tree, qd, self.still, gravity=False)
