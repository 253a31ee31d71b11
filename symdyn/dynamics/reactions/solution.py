"""(5.18) row by row, and the reactions that its unknowns are: A x = -b, T x = R - R⁰.

Nothing is solved here. Who solves does it in numbers, at one place after the other, with pivots that the numbers there
choose: no choice is made beforehand that could fail at another place.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.reactions.dalembert import Equilibrium
from symdyn.dynamics.reactions.freedoms import drives
from symdyn.dynamics.reactions.hinges import nothing, plus, times
from symdyn.dynamics.reactions.members import placements
from symdyn.dynamics.reactions.recursion import as_row, as_rows
from symdyn.graph import Expr
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
