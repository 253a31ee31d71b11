"""(5.18) row by row, and the reactions that its unknowns are: A x = -b, T x = R - R⁰.

Nothing is solved here. Who solves does it in numbers, at one place after the other, with pivots that the numbers there
choose: no choice is made beforehand that could fail at another place.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.reactions.dalembert import Equilibrium
from symdyn.dynamics.reactions.freedoms import drives
from symdyn.dynamics.reactions.hinges import Hinge, nothing, plus, times
from symdyn.graph import Expr
from symdyn.spatial import Wrench

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


def wrench_rows(system: Equilibrium, R: Sequence[Expr]) -> Rows:
    """Return rows which say that the unknowns are the reactions R of a tree's joints and those of loops.

    Args:
        system: from `equilibrium`.
        R: as of the output `reactions`, row by row.
    """
    hanging, last = system.hanging, len(system.unknowns)
    shown = (*hanging.joints, *hanging.loops)
    known = [x for hinge, wrench in zip(shown, elements(system), strict=False) for x in _entries(hinge, wrench)]
    rows = [{last: r - own} for r, own in zip(R, known, strict=True)]
    for u, unknown in enumerate(system.unknowns):
        for h, wrench in unknown.acts:
            if h < len(shown):
                for k, entry in enumerate(_entries(shown[h], wrench)):
                    if not entry.is_zero:
                        before = rows[6 * h + k].get(u)
                        rows[6 * h + k][u] = entry if before is None else before + entry
    return rows


def _entries(hinge: Hinge, wrench: Wrench) -> tuple[Expr, ...]:
    """Return [force; moment] on the child, its axes, for a wrench in axes of the joint frame."""
    force, moment = hinge.on_child(wrench)
    return (*force, *moment)


def elements(system: Equilibrium) -> list[Wrench]:
    """Return what the joints' own elements, and drives that are known, exert in every joint, axes of joint frames."""
    hanging = system.hanging
    total = [nothing(hanging.graph)] * len(hanging.hinges)
    for h, (hinge, forces) in enumerate(zip(hanging.joints, system.own, strict=True)):
        for force, D in zip(forces, drives(hinge, hanging.samples), strict=True):
            total[h] = plus(total[h], times(force, D))
    return total
