"""The solution of (5.18): sizes of all unknowns, and the reactions that they are."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.reactions.dalembert import Equilibrium, equilibrium
from symdyn.dynamics.reactions.elimination import eliminate, pivots
from symdyn.dynamics.reactions.freedoms import drives
from symdyn.dynamics.reactions.hanging import Hanging
from symdyn.dynamics.reactions.hinges import nothing, plus, times
from symdyn.dynamics.reactions.recursion import as_rows
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.scene.joints import Wrench
from symdyn.spatial import Mat, apply


def solution(system: Equilibrium) -> list[Expr]:
    """Return x with A x + b = 0 by elimination from the tips, pivots chosen at one position.

    Every body's equations are turned into the axes of its reference joint first: what acts there has constant entries,
    which are pivots at any position.

    Raises:
        DerivationError: A does not determine x.
    """
    A, b = system.matrix(), system.right()
    if len(system.kept) == 6:
        both = [[*row, right] for row, right in zip(A, b, strict=True)]
        for j, hinge in enumerate(system.hanging.joints):
            R = (hinge.X @ hinge.tip).R
            for start in (6 * j, 6 * j + 3):
                both[start : start + 3] = _turned_rows(R, both[start : start + 3])
        A, b = [row[:-1] for row in both], [row[-1] for row in both]
    numbers = system.hanging.samples.at([entry for row in A for entry in row]).reshape(len(A), -1)
    order = pivots(numbers)
    if len(order) < len(system.unknowns):
        raise DerivationError(undetermined(system, len(order)))
    return eliminate(A, [-x for x in b], order)


def _turned_rows(R: Mat, rows: Sequence[Sequence[Expr]]) -> list[list[Expr]]:
    """Return R times three rows."""
    columns = [apply(R, (x, y, z)) for x, y, z in zip(*rows, strict=True)]
    return [[column[k] for column in columns] for k in range(3)]


def undetermined(system: Equilibrium, rank: int) -> str:
    """Return why a system has no unique solution, and what would work."""
    return (
        f"{system.hanging.scene.name}: reactions: {system.equations} equations of equilibrium determine {rank} of the "
        f"{len(system.unknowns)} unknowns ({system.reactions} reactions, {system.drives} drives): the mechanism has "
        "too many drives, or is overconstrained; make drives passive, take joints with more freedoms, or ask "
        "symdyn.dynamics.reactions_at for the least reactions at one position, with those "
        "flagged that are not unique"
    )


def transmitted(system: Equilibrium, x: Sequence[Expr]) -> list[Wrench]:
    """Return the whole wrench through every joint, axes of its joint frame, about P: reactions, drives, elements."""
    hanging = system.hanging
    total = [nothing(hanging.graph)] * len(hanging.hinges)
    for unknown, size in zip(system.unknowns, x, strict=True):
        for h, wrench in unknown.acts:
            total[h] = plus(total[h], times(size, wrench))
    for h, (hinge, forces) in enumerate(zip(hanging.joints, system.own, strict=True)):
        for force, D in zip(forces, drives(hinge, hanging.samples), strict=True):
            total[h] = plus(total[h], times(force, D))
    return total


def solved_reactions(hanging: Hanging, axes: str = "body", tau: Sequence[Expr] | None = None) -> list[Expr]:
    """Return every joint's reaction from the whole system: as `reactions.reactions`, which goes another way."""
    system = equilibrium(hanging, tau=tau)
    pairs = zip((*hanging.joints, *hanging.loops), transmitted(system, solution(system)), strict=False)
    return as_rows(hanging, [hinge.on_child(wrench) for hinge, wrench in pairs], axes)
