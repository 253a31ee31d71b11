"""What closes loops: reactions of the tree eliminated from (5.18) leave an equation for each velocity without a drive.

    W_l      wrench l of a joint that closes a loop, or of a contact, axes of its joint frame J, about P
    G_lk     its power for unit velocity k: W_l · (twist of the child relative to J)
    Gᵀ λ = f    in the velocities without a drive, f what they feel from the tree alone

The unknowns λ are those of the constraint rows that are kept, so that they are the multipliers of forward dynamics. All
velocities without a drive take part in finding them: what tells λ more than once (the idle spin of a rod between two
balls, all of a disc that rolls) does so in the sum of squares, which no position spoils that does not spoil λ itself.

A loop whose bodies move in one plane relative to each other cannot say what goes across the plane: there are three
equations a body. Its joint is taken to transmit what lies in the plane as far as it can, and the tree's joints the
rest: such a joint's wrench has its part across the plane taken off where that leaves a wrench which the joint can
exert. A rod, or a plane that leans, can exert nothing else than its one wrench, and does so whole.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops.constraint_rows import recursive
from symdyn.dynamics.loops.partition import Partition, blocks
from symdyn.dynamics.mechanism.tree import has_symbols
from symdyn.dynamics.reactions.joint_frames import PLACES, JointFrames, Twist
from symdyn.errors import DerivationError, listed
from symdyn.frozen import dataclass
from symdyn.graph import Expr
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES, without_place
from symdyn.scene.joints import JOINTS, unit
from symdyn.spatial import Mat, Vec, Wrench, dot, scale, sub

if TYPE_CHECKING:
    from symdyn.dynamics.reactions.free_bodies import FreeBodies

FLAT = 1e-9  # how far a twist may leave a plane, relative to the largest


@dataclass(frozen=True)
class ClosureEquation:
    """One unknown that closes a loop, or keeps a row of the scene.

    Attributes:
        owner: name of the loop or row.
        acts: number of the loop, contact or straight part of a rope, and W at unit size; of a rope one for each part,
            none for a formula, which acts on the velocities alone.
        G: its row of G, shape (nv,).
    """

    owner: str
    acts: tuple[tuple[int, Wrench], ...]
    G: tuple[Expr, ...]

    def __add__(self, other: ClosureEquation) -> ClosureEquation:
        """Return one unknown for two parts of a rope."""
        G = tuple(a + b for a, b in zip(self.G, other.G, strict=True))
        return ClosureEquation(self.owner, self.acts + other.acts, G)


def why_no_reactions(scene: Scene) -> str:
    """Return why a scene has no reactions: nothing tells where the force of a constraint acts; "" where it has them.

    Whatever bodies it acts on, the motion is the same; which joints feel it, a slide across it or the rail beneath it
    included, is not. So none of the scene's reactions is known.
    """
    rows = [f"constraints.{name}" for name in without_place(scene)]
    if not rows:
        return ""
    formulas = "is a formula in rates" if len(rows) == 1 else "are formulas in rates"
    return (
        f"{scene.name}: there are no reactions: {', '.join(rows)} {formulas}, and where the constraint force acts is "
        'not given; write type = "rolling" or "knife_edge", which name what touches, and where, or acts_in = "joints" '
        "where it acts in the joints of those rates, as in belts, gears and servos"
    )


def unknown_forces(scene: Scene) -> str:
    """Return why reactions of a run do not know the forces of its contacts, "" where they do."""
    every = [one for one in scene.unilaterals if FORCES[one.kind].section != "joints"]
    placeless = [one.name for one in every if one.closed is None]
    if placeless:
        return f"they do not know where the forces of {listed(placeless)} act, a formula; leave it out"
    if every and scene.is_constrained:
        names = listed(one.name for one in every)
        return f"beside loops and constraints they do not know the forces of contacts, {names}; leave them out"
    return ""


def refuse_without_place(scene: Scene) -> None:
    """Refuse reactions that depend on where the force of a row acts; DerivationError where nothing says where."""
    if why := why_no_reactions(scene):
        raise DerivationError(why)


def ties(hanging: FreeBodies) -> list[ClosureEquation]:
    """Return the unknowns of the constraint rows that are kept, in their order."""
    every = all_ties(hanging)
    return [every[k] for k in hanging.decisions.independent_rows] if hanging.decisions else every


def all_ties(hanging: FreeBodies, whole: bool = False) -> list[ClosureEquation]:
    """Return the unknowns of all loops and constraints, in the order of G; `whole` with what goes across planes."""
    found: dict[tuple[bool, str], list[ClosureEquation]] = {}  # by whether it is a loop, and its name
    zero, every = hanging.graph.zero, range(hanging.state.n)
    for number, loop in enumerate(hanging.cuts):
        name, twists = loop.joint.name, hanging.relative_twists(loop)
        wrenches = loop.wrenches if whole or hanging.of_rope(loop) else taken_wrenches(hanging, loop, twists)
        rows = [(W, tuple(W.power(twists[k]) if k in twists else zero for k in every)) for W in wrenches]
        each = [ClosureEquation(name, ((number, wrench),), row) for wrench, row in rows]
        key = number < len(hanging.loops), name
        found[key] = [found[key][0] + each[0]] if key in found else each  # of a rope
    found |= {(False, one.owner): [one] for one in rows_of(hanging)}
    loops, others = hanging.scene.loops, hanging.scene.constraints
    names = [*((True, one.name) for one in loops), *((False, one.name) for one in others)]
    return [one for name in names for one in found[name]]


def rows_of(hanging: FreeBodies) -> list[ClosureEquation]:
    """Return the unknowns of constraints that are formulas: forces on the velocities, whatever exerts them."""
    if all(FORCES[row.kind].formula(row) is None for row in hanging.scene.constraints):
        return []
    every = recursive(hanging.scene, hanging.tree, hanging.state)
    pairs = zip(every.labels, every.G, strict=True)
    return [ClosureEquation(label.owner, (), G) for label, G in pairs if label.wrench is None]


def sizes(hanging: FreeBodies, unknown: Sequence[ClosureEquation], forces: Sequence[Expr]) -> list[Expr]:
    """Return λ with Gᵀ λ = forces in the velocities without a drive, block by block.

    The forces are what drives and loops must exert together, M u̇ + h of the tree, shape (nv,). Where the equations are
    more than the unknowns, the motion is one that the drives can give if they agree.

    Raises:
        DerivationError: these velocities do not determine λ.
    """
    decisions = hanging.decisions
    if decisions is not None and decisions.actuated is None:
        raise DerivationError(
            f"{hanging.scene.name}: reactions are not unique: {decisions.fault}; or ask for forward_reactions, with "
            "drives given"
        )
    among = hanging.scene.passive_velocities
    uses = [[k for k in among if not one.G[k].is_zero] for one in unknown]
    partition = Partition((), tuple(among), tuple(blocks(uses)))
    return partition.solve_transposed([one.G for one in unknown], forces)


# Planes


def taken_wrenches(hanging: FreeBodies, loop: JointFrames, twists: dict[int, Twist]) -> tuple[Wrench, ...]:
    """Return what a closing joint's wrenches are taken to be: without what goes across the plane, where they can."""
    normal = plane(hanging, loop, twists)
    if normal is None or not loop.wrenches:
        return loop.wrenches
    flat = flattened(loop.wrenches, normal)
    given = len(loop.wrenches)  # which are independent
    return tuple(
        lying if all(_rank(hanging, [*loop.wrenches, lying], seed) == given for seed in PLACES) else whole
        for whole, lying in zip(loop.wrenches, flat, strict=True)
    )


def _rank(hanging: FreeBodies, wrenches: Sequence[Wrench], seed: int) -> int:
    numbers = hanging.samples.at([x for force, moment in wrenches for x in (*force, *moment)], seed)
    return int(np.linalg.matrix_rank(numbers.reshape(-1, 6), tol=FLAT))


def flattened(wrenches: Sequence[Wrench], normal: Vec) -> list[Wrench]:
    """Return wrenches without what goes across a plane."""
    return [Wrench(sub(f, scale(dot(f, normal), normal)), scale(dot(m, normal), normal)) for f, m in wrenches]


def plane(hanging: FreeBodies, loop: JointFrames, twists: dict[int, Twist]) -> Vec | None:
    """Return the normal of the plane that a loop moves in, axes of J; None in space."""
    entries = [x for v, omega in twists.values() for x in (*v, *omega)]
    numbers = [hanging.samples.at(entries, seed).reshape(-1, 2, 3) for seed in PLACES]
    for normal in _normals(hanging, loop, twists):
        n = hanging.samples.at(normal, PLACES[0])
        if all(_flat(twist, n) for at in numbers for twist in at):
            return normal
    return None


def _normals(hanging: FreeBodies, loop: JointFrames, twists: dict[int, Twist]) -> Iterator[Vec]:
    """Yield what is tried: the joint's own axis, those of J, and axes of other joints that stand still in J."""
    kind = JOINTS.get(loop.joint.type)  # a contact has none
    if kind and kind.has_axis:
        yield unit(loop.joint.axis, hanging.graph)
    yield from Mat.identity(hanging.graph)[::-1]
    for _, omega in twists.values():
        if not any(map(has_symbols, omega)) and not all(x.is_zero for x in omega):
            yield omega


def _flat(twist: Array, n: Array) -> bool:
    (v, omega), size = twist, max(1.0, float(np.abs(twist).max()))
    return abs(float(v @ n)) < FLAT * size and float(np.abs(np.cross(n, omega)).max()) < FLAT * size


def independent_in_plane(hanging: FreeBodies, wrenches: Sequence[Wrench], normal: Vec) -> list[int]:
    """Return which wrenches are independent in a plane, of those that depend on each other the first."""
    flat = flattened(wrenches, normal)
    kept: list[int] = []
    for k in range(len(wrenches)):
        if _rank(hanging, [flat[i] for i in (*kept, k)], PLACES[0]) > len(kept):
            kept.append(k)
    return kept
