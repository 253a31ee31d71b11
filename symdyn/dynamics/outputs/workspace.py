"""What several outputs of one derivation share, computed when first asked for."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from symdyn.dynamics.loops.loop_workspace import LoopWorkspace
from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.dynamics.mechanism.centroidal import mass
from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.mechanism.kane import Kane
from symdyn.dynamics.mechanism.kinematics import Christoffel, Directions, centre_of_mass, directions
from symdyn.dynamics.mechanism.lagrange import Energies
from symdyn.dynamics.mechanism.linear_solve import vanishes
from symdyn.dynamics.mechanism.state import (
    INPUTS,
    STATES,
    Prescribed,
    State,
    generalized_forces,
    prescribed,
    symbols_of,
)
from symdyn.dynamics.mechanism.tree import Tree, build_tree
from symdyn.dynamics.recursive.crba import crba, crba_in_runs
from symdyn.dynamics.recursive.joint_table import JointTable, joint_table
from symdyn.dynamics.recursive.reduced_tree import (
    ReducedTree,
    in_unrotated_axes,
    potential_energy,
    reframe,
    regroup,
    resting,
    unrotated_tips,
)
from symdyn.dynamics.recursive.tree_dynamics import rnea
from symdyn.dynamics.recursive.wrenches import Elastic, body_wrenches, elastic, joint_forces
from symdyn.graph import Expr, Graph, tangents
from symdyn.scene import Scene, without_hidden_zeros
from symdyn.spatial import Vec, Wrench
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.dynamics.outputs.named_functions import Function
    from symdyn.dynamics.reactions.free_bodies import FreeBodies

Matrix = list[list[Expr]]
T = TypeVar("T")


class Workspace:
    """One scene on one graph."""

    def __init__(self, scene: Scene, closing: LoopChoices = LoopChoices(), regrouped: bool = True) -> None:  # noqa: B008
        """Start with an empty graph; `closing` is what the user chooses about closed loops.

        Recursions run over base parameters, or over the inertias as declared where they are not `regrouped`.
        """
        self.regrouped = regrouped
        self.declared = scene
        scene = without_hidden_zeros(scene)
        self.scene = scene
        self.closing = closing
        self.graph = Graph()
        self.state: State = State.of(scene, self.graph)
        self.zeros: list[Expr] = [self.graph.zero] * self.state.n
        self.derived: dict[tuple[str, str], Function] = {}  # by request and formulation, as `derive_one` finds them
        self._found: dict[tuple[Any, ...], Any] = {}

    def once(self, derive: Callable[..., T], *asked: Hashable) -> T:
        """Return what a derivation gives for the workspace, and for what is asked of it; each runs once.

        Formulations may share what they are made of in this way, and rows their formulations. No formulation reads what
        another formulation of the same output found: that they agree would prove nothing.
        """
        if (derive, *asked) not in self._found:
            self._found[derive, *asked] = derive(self, *asked)
        found: T = self._found[derive, *asked]
        return found

    @cached_property
    def directions(self) -> Directions:
        return directions(self.scene, self.graph)

    @property
    def inputs(self) -> tuple[Expr, ...]:
        return symbols_of(self.scene, self.graph, INPUTS)

    @property
    def states(self) -> tuple[Expr, ...]:
        """Symbols of the states of one's own."""
        return symbols_of(self.scene, self.graph, STATES)

    @cached_property
    def state_rates(self) -> list[Expr]:
        """Rates of the states of one's own."""
        return [one.rate.express(self.graph) for one in self.scene.states]

    def by_states(self, functions: Sequence[Expr]) -> list[Expr]:
        """Return the rates of functions by states of one's own alone: Ṁ u of momenta where these are masses."""
        return tangents(functions, dict(zip(self.states, self.state_rates, strict=True)))

    @cached_property
    def prescribed(self) -> Prescribed:
        return prescribed(self.scene, self.graph)

    @cached_property
    def loops(self) -> LoopWorkspace:
        """Rows of the loops, and what is decided about them."""
        return LoopWorkspace(self)

    @property
    def mass(self) -> Expr:
        """Mass of all that moves, kg; DerivationError where nothing that moves has one."""
        return mass(self.scene, self.tree)

    def centre_of_mass(self, body: str) -> Vec:
        """Return the centre of mass of a body in its own frame, m; DerivationError where it has no mass."""
        return centre_of_mass(self.scene, body, self.graph)

    # Lagrange formulation

    @cached_property
    def Q(self) -> list[Expr]:
        """Generalized forces beside drives, gravity and springs, by virtual work, shape (n,)."""
        return generalized_forces(self.scene, self.graph)

    @cached_property
    def energy(self) -> Energies:
        """K and P from positions."""
        return Energies.of(self.scene, self.graph)

    @cached_property
    def cyclic(self) -> tuple[int, ...]:
        """Rates of coordinates without drive or force, on which no energy depends, proved: their momenta stay."""
        free = [k for k in self.scene.passive_velocities if self.state.qd[k] in self.state.rates]
        slopes = self.directions.slopes(self.energy.K - self.energy.P) if free else []
        lost = self.by_states(self.energy.momenta()) if free else []
        return tuple(k for k in free if all(map(vanishes, (slopes[k], self.Q[k], lost[k]))))

    @cached_property
    def kane(self) -> Kane:
        """Kane's equations, from velocities of points."""
        return Kane.of(self.scene, self.graph)

    @cached_property
    def lagrange_mass(self) -> Matrix:
        """M as the Hessian of K, shape (n, n)."""
        return self.energy.mass_matrix()

    @cached_property
    def lagrange_christoffel(self) -> Christoffel:
        """Christoffel symbols of that M."""
        return self.directions.christoffel(self.lagrange_mass)

    # Recursive formulation

    @cached_property
    def tree(self) -> Tree:
        """The kinematic tree as declared."""
        return build_tree(self.scene, self.graph)

    @cached_property
    def reduced(self) -> ReducedTree:
        """The same tree in frames of the generator's choice, with base parameters: what the recursions run over."""
        framed = reframe(self.tree)
        return resting(regroup(framed) if self.regrouped else framed)

    @cached_property
    def recursion_tree(self) -> ReducedTree:
        """The reduced tree that RNEA and ABA run over: its leaf bodies in axes that do not turn with their joints."""
        return unrotated_tips(self.reduced)

    @cached_property
    def joint_table(self) -> JointTable:
        """The reduced tree as rows of numbers, of a scene that lacks nothing of `joint_table.lacking`."""
        return joint_table(self.reduced, self.state.q)

    @cached_property
    def whole(self) -> ReducedTree:
        """The reduced tree, but for the inertia of spherical and free joints, as derivatives of recursions need it."""
        blocks = any(len(block) > 1 for block in self.tree.block)
        return resting(regroup(reframe(self.tree), blocks=False)) if blocks else self.reduced

    @cached_property
    def hanging(self) -> FreeBodies:
        """The declared bodies and joints, nothing merged or regrouped, for reactions."""
        from symdyn.dynamics.reactions.free_bodies import FreeBodies  # with NumPy, which printing can do without

        closed = self.scene.is_constrained
        return FreeBodies(self.scene, self.tree, self.state, self.loops.decisions if closed else None)

    @cached_property
    def elastic(self) -> Elastic:
        """What springs do, along the tree."""
        return elastic(self.scene, self.tree, self.reduced)

    @cached_property
    def pushes(self) -> list[Expr]:
        """What struts without energy, friction and declared forces exert, along the tree, shape (n,)."""
        return joint_forces(self.scene, self.tree, self.reduced)

    @cached_property
    def loads(self) -> list[Wrench]:
        """Wrenches of the loads on the bodies, along the tree."""
        return body_wrenches(self.scene, self.tree, self.reduced)

    @cached_property
    def unrotated_loads(self) -> list[Wrench]:
        """The same in the axes of the unrotated tree."""
        return in_unrotated_axes(self.reduced, self.loads)

    @cached_property
    def composite_mass(self) -> Matrix:
        """M by the composite-rigid-body algorithm, shape (n, n): plain or along runs, what costs less."""
        variants = crba(self.reduced), crba_in_runs(self.reduced)
        zero = self.graph.zero
        return min(variants, key=lambda M: cost([x for row in M for x in row if x is not zero], self.state.q))

    @cached_property
    def composite_christoffel(self) -> Christoffel:
        """Christoffel symbols of that M."""
        return self.directions.christoffel(self.composite_mass)

    @cached_property
    def gravity_forces(self) -> list[Expr]:
        """Return g(q), shape (n,), by recursion."""
        return rnea(self.recursion_tree, self.zeros, self.zeros)

    @cached_property
    def momentum(self) -> list[Expr]:
        """Return p = M q̇, shape (n,): inverse dynamics at q̈ = q̇, without velocity and gravity."""
        return rnea(self.recursion_tree.without_gravity, self.zeros, self.state.qd)

    def energies_by_momentum(self) -> tuple[Expr, Expr]:
        """Return K and P by recursion, J."""
        K = self.graph.dot(self.momentum, self.state.qd) / 2
        return K, potential_energy(self.reduced) + self.elastic.energy

    def velocity_forces(self, qd: list[Expr], qdd: list[Expr] | None = None) -> list[Expr]:
        """Return c(q, q̇) at the given velocities, shape (n,); M q̈ + c where accelerations are given too."""
        return rnea(self.recursion_tree.without_gravity, qd, self.zeros if qdd is None else qdd)

    def forces(self, qdd: list[Expr]) -> list[Expr]:
        """Return M(q) q̈ + c + g + k_E - Q, shape (n,): what the drives must exert, by recursion; see `rnea`."""
        motion = rnea(self.recursion_tree, self.state.qd, qdd, self.unrotated_loads)
        rest = zip(motion, self.elastic.forces, self.pushes, strict=True)
        return [force + pull - push for force, pull, push in rest]
