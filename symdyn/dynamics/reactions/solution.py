"""The solution of (5.18) in numbers: sizes of all unknowns, and the reactions that they are.

A x + b = 0 is solved at one place after the other and over any algebra, with pivots that the numbers there choose. So
no choice is made beforehand that could fail at another place, and what one place leaves undetermined is seen there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from symdyn.algebra.elimination import eliminate
from symdyn.dynamics.reactions.dalembert import Equilibrium
from symdyn.dynamics.reactions.freedoms import drives
from symdyn.dynamics.reactions.hinges import nothing, plus, times
from symdyn.dynamics.reactions.members import placements
from symdyn.dynamics.reactions.recursion import as_row, as_rows
from symdyn.errors import DerivationError
from symdyn.graph import Algebra, Expr, evaluate
from symdyn.scene.joints import Wrench

Rows = list[dict[int, Expr]]


def equations(system: Equilibrium) -> Rows:
    """Return the rows of A x = -b, entries by column, what is zero left out; -b is the column behind the unknowns."""
    size = len(system.kept)
    rows: Rows = [{} for _ in range(system.equations)]
    for (j, u), (force, moment) in system.blocks.items():
        entries = (*force, *moment)
        for k, component in enumerate(system.kept):
            if not entries[component].is_zero:
                rows[size * j + k][u] = entries[component]
    for row, right in zip(rows, system.right(), strict=True):
        row[len(system.unknowns)] = -right
    return rows


def wrench_rows(system: Equilibrium, R: Sequence[Expr], axes: str = "body") -> Rows:
    """Return rows which say that the unknowns are the reactions R of a tree's joints and those of loops.

    Args:
        system: from `equilibrium`.
        R: as of the output `reactions`, row by row.
        axes: those of R.
    """
    hanging, last = system.hanging, len(system.unknowns)
    shown = (*hanging.joints, *hanging.loops)
    placed = placements(hanging.joints) if axes == "ground" else []
    still = [hinge.on_child(wrench) for hinge, wrench in zip(shown, elements(system), strict=False)]
    known = as_rows(hanging, still, axes)
    rows = [{last: r - own} for r, own in zip(R, known, strict=True)]
    for u, unknown in enumerate(system.unknowns):
        for h, wrench in unknown.acts:
            if h < len(shown):
                entries = as_row(shown[h], shown[h].on_child(wrench), axes, placed)
                for k, entry in enumerate(entries):
                    if not entry.is_zero:
                        before = rows[6 * h + k].get(u)
                        rows[6 * h + k][u] = entry if before is None else before + entry
    return rows


def elements(system: Equilibrium) -> list[Wrench]:
    """Return what the joints' own elements, and drives that are known, exert in every joint, axes of joint frames."""
    hanging = system.hanging
    total = [nothing(hanging.graph)] * len(hanging.hinges)
    for h, (hinge, forces) in enumerate(zip(hanging.joints, system.own, strict=True)):
        for force, D in zip(forces, drives(hinge, hanging.samples), strict=True):
            total[h] = plus(total[h], times(force, D))
    return total


def transmitted(system: Equilibrium, x: Sequence[Expr]) -> list[Wrench]:
    """Return the whole wrench through every joint, axes of its joint frame, about P: reactions, drives, elements."""
    total = elements(system)
    for unknown, size in zip(system.unknowns, x, strict=True):
        for h, wrench in unknown.acts:
            total[h] = plus(total[h], times(size, wrench))
    return total


def solved_at(
    system: Equilibrium, algebra: Algebra[Any], values: Mapping[Expr, Any], weigh: Callable[[Any], Any] = abs
) -> list[Any]:
    """Return x with A x + b = 0 at one place, shape (unknowns,).

    Args:
        system: from `equilibrium`.
        algebra: what to compute with.
        values: of all symbols.
        weigh: the size of a number, 0 where it cannot be told from zero.

    Raises:
        DerivationError: the equations do not determine x there.
    """
    rows = equations(system)
    found = iter(evaluate([entry for row in rows for entry in row.values()], algebra, dict(values)))
    zero = evaluate([system.hanging.graph.zero], algebra, {})[0]
    done = eliminate([{c: next(found) for c in row} for row in rows], len(system.unknowns), algebra, zero, weigh)
    if done.free:
        raise DerivationError(undetermined(system, len(system.unknowns) - len(done.free)))
    return done.x


def undetermined(system: Equilibrium, rank: int) -> str:
    """Return why a system has no unique solution, and what would work."""
    return (
        f"{system.hanging.scene.name}: reactions: {system.equations} equations of equilibrium determine {rank} of the "
        f"{len(system.unknowns)} unknowns ({system.reactions} reactions, {system.drives} drives): the mechanism has "
        "too many drives, or is overconstrained; make drives passive, take joints with more freedoms, or ask "
        "symdyn.dynamics.reactions_at for the least reactions at one position, with those "
        "flagged that are not unique"
    )
