"""One row of the table of outputs, with its formulations: all that is true of an output stands here.

How many operations an output takes, about: told from its row and the scene's tree alone, before anything is derived.

    d_k      velocities from the ground to velocity k, itself included; of a chain of n joints 1, 2, ... n
    size     s Σ_k (c_1 + 2 c_2 d_k + 3 c_3 d_k² + ...) + 3 e Σ_k d_k², of a chain about s (c_1 n + c_2 n² + ...) + e n³

The constants are those of joints with full inertias that turn every way, s = 1. Simpler joints take less, all outputs
about as many times less as inverse dynamics, whose count says how simple they are. What is solved with a full matrix is
not simpler for that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import fsum, inf
from typing import Literal, get_args

from symdyn.dynamics.mechanism.linear_solve import RowSolve
from symdyn.dynamics.outputs.result_labels import Axis
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.pair_runs import PairRuns
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr
from symdyn.scene import Scene

PLENTY = 2_000_000
"""Operations that are written as lines at most: some 4 GB and minutes of derivation and compiling."""


@dataclass(frozen=True)
class Size:
    """About how many operations an output takes."""

    constants: tuple[float, ...]  # c_1, c_2, ... of the legend, weighed operations as `Counts.cost` has them
    solved: float = 0.0  # e of the legend

    def times(self, factor: float) -> Size:
        """Return the size of so many of them."""
        return Size(tuple(factor * c for c in self.constants), factor * self.solved)

    def columns(self, factor: float) -> Size:
        """Return the size of a column for each velocity, each so many times as large as this, which solves nothing."""
        return Size((0.0, *self.times(factor).constants))

    def of(self, depths: Sequence[int], simple: float = 1.0) -> float:
        """Return the operations for a tree by its depths, shape (nv,), and s."""
        derived = fsum((k + 1) * c * float(d) ** k for k, c in enumerate(self.constants) for d in depths)
        return simple * derived + 3 * self.solved * fsum(float(d) ** 2 for d in depths)


LINEAR = Size((250.0,))
"""That of what goes through the tree once."""

INVERSE = Size((200.0,))
"""That of inverse dynamics, by which the simplicity of joints is measured."""


def depths_of(scene: Scene) -> list[int]:
    """Return d_k of every velocity, in the order of velocities, shape (nv,)."""
    depth: dict[str, int] = {}
    found = []
    for joint in scene.joints:
        below = depth.get(joint.parent, 0) + len(joint.rates)
        depth[joint.child] = below
        found += [below] * len(joint.rates)
    return found


FORCES = "N m (revolute) or N (prismatic)"
"""Unit of forces that do work on velocities."""

TREE_NAME = "tree_"
"""In front of the name of what is the spanning tree's alone, where loops or rows close a scene."""

DefaultIn = Literal["overview", "load", "generate", "verify", "request"]
"""Who takes an output that is not named: a first look at a scene and all behind it; who loads the functions of a scene;
who writes, counts or measures them, too large to be loaded; who proves them, and then of the last body; no one."""


@dataclass(frozen=True)
class Formulation:
    """One derivation of an output.

    Attributes:
        derive: takes the workspace, and the body or point of an output of one; returns the entries, row by row.
        trees_only: knows no prescribed motion and no velocity of several elementary joints, as of screws and cams.
        up_to: coordinates up to which it pays to measure it beside others; beyond, its formulas are longer.
        loop: what computes the entries for a table of joints and the arguments, where it goes over one, as code can in
            a loop; None otherwise. Only scenes that a table holds have it.
        solve: what the entries come from at last, by steps in rows or by runs of pairs, which code may take in a loop;
            None otherwise.
    """

    derive: Callable[..., Sequence[Expr]]
    trees_only: bool = False
    up_to: float = inf
    loop: Callable[..., Sequence[Expr]] | None = None
    solve: Callable[[Workspace], RowSolve | PairRuns | None] | None = None


def by_loop(compute: Callable[..., Sequence[Expr]]) -> Formulation:
    """Return a formulation that goes over the table of joints of a scene, at the motion of its state."""
    return Formulation(lambda w: compute(w.joint_table, *w.state.motion), up_to=0, loop=compute)


def by_lagrange(derive: Callable[..., Sequence[Expr]]) -> Formulation:
    """Return a formulation that goes by Lagrange's equations, which grow fast."""
    return Formulation(derive, up_to=4)


def by_differentiation(derive: Callable[..., Sequence[Expr]]) -> Formulation:
    """Return a formulation that differentiates placements in the ground frame, which grows fast."""
    return Formulation(derive, up_to=8)


@dataclass(frozen=True)
class Constrained:
    """What a row says of scenes with loops or rows alone, "" where the text is the same; the rest is as of trees."""

    formulations: dict[str, Formulation]
    text: str = ""
    solves: tuple[str, ...] = ()


WhenConstrained = Literal["same", "tree", "refuse", "only"]
"""What an output is where loops or rows close a scene: a function of the full state as anywhere, what the spanning tree
alone would have, nothing; a function of the full state that trees do not have."""


@dataclass(frozen=True)
class Output:
    """One row of the table.

    Attributes:
        text: what it computes, one line; in braces what `derive` fills in.
        arguments: names of its arguments, keys of `ARGUMENTS`.
        result: short name of the result.
        axes: what its rows stand for, then its columns; () for a scalar.
        units: unit of the result, one line.
        moved: what it takes where a scene has such, along which derivatives go too, behind those of `arguments`.
        when_constrained: what it is where loops or rows close a scene, or what its row says there.
        formulations: derivations by name; the first is the one that code is generated from, unless `prefer` says
            otherwise.
        place: "" for a whole-scene output, "body", "point", "output" or "rope" where a name must be given.
        exists: which of those that may have it have it without being asked.
        default_in: who takes it then.
        may_fail: whether a scene may lack it after all, for its mass matrix is singular or its loops cannot be closed;
            "silently" where most do, and nothing is reported.
        cubic: whether its formulas grow with the cube of the number of coordinates.
        depends: which choices about closed loops its formulas depend on, attributes of `LoopChoices`.
        prefer: which formulation takes fewest operations for a mechanism, where that depends on it.
        compared: what of the result formulations agree on, where it is one choice among many: in words, and from its
            entries.
        unique: which entries of the result rigid bodies determine, row by row, () for all; None where all always are.
        solves: outputs M, h and, where loops close, G, γ: the linear equations that it solves, if it solves such.
        weighs: what the entries of its argument `weights` stand for, if it has that.
        remark: what else its text says of a scene; takes what formulations take.
        size: about how many operations it takes.
    """

    text: str
    arguments: tuple[str, ...]
    result: str
    axes: tuple[Axis, ...]
    units: str
    when_constrained: WhenConstrained | Constrained
    formulations: dict[str, Formulation]
    place: Literal["", "body", "point", "output", "rope", "contact"] = ""
    exists: Callable[[Scene], bool] = lambda scene: True
    default_in: DefaultIn = "load"
    may_fail: Literal["never", "reported", "silently"] = "never"
    cubic: bool = False
    depends: tuple[str, ...] = ()
    prefer: Callable[[Workspace], str] | None = None
    compared: tuple[str, Callable[[Workspace, Sequence[Expr]], Sequence[Expr]]] | None = None
    unique: Callable[[Workspace], tuple[bool, ...]] | None = None
    solves: tuple[str, ...] = ()
    weighs: Axis | None = None
    remark: Callable[..., str] | None = None
    size: Size = LINEAR
    moved: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a row that does not say what it is where loops close."""
        there, known = self.when_constrained, get_args(WhenConstrained)
        assert isinstance(there, Constrained) or there in known, (
            f"{self.result}: when constrained it is none of {known}"
        )

    def exists_in(self, scene: Scene) -> bool:
        """Tell whether a scene has it without being asked, if it may not fail."""
        return self.when_constrained != ("refuse" if scene.is_constrained else "only") and self.exists(scene)

    def is_default_in(self, who: DefaultIn) -> bool:
        """Return whether it is taken somewhere without being named."""
        order = get_args(DefaultIn)
        return order.index(self.default_in) <= order.index(who)

    @property
    def constrained(self) -> Output:
        """The row of scenes with loops or rows."""
        there = self.when_constrained
        if not isinstance(there, Constrained):
            return self
        return replace(
            self,
            text=there.text or self.text,
            when_constrained="same",
            formulations=there.formulations,
            prefer=None,
            solves=there.solves,
        )

    def preferred(self, workspace: Workspace) -> str:
        """Return the name of the formulation that code is generated from."""
        return workspace.once(self.prefer) if self.prefer else next(iter(self.formulations))

    @property
    def is_large(self) -> bool:
        """Whether it is written by default, but loaded only when it is asked for."""
        return self.default_in == "generate"
