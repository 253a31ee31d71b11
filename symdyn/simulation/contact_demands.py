"""What contacts would need in the world: normal forces that push, and friction enough not to slip.

    N, F     multipliers of a contact along the normal, and in the plane

The equations take contacts as two-sided and without slip; both are looked at in what they give.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from symdyn.scene import Row
from symdyn.scene.forces import touches
from symdyn.simulation.equations.opened import numbers_at
from symdyn.simulation.equations.state_equations import StateEquations
from symdyn.simulation.multipliers import multipliers

Array = npt.NDArray[np.float64]

NOTHING = 1e-9
"""Forces over the largest that are rounding."""


@dataclass(frozen=True)
class Needed:
    """What a contact needs over a motion.

    Attributes:
        row: of the scene.
        normal: N, shape (N,); it pulls where it is negative.
        friction: |F| / N at least, where the contact pushes; 0 elsewhere, shape (N,).
    """

    row: Row
    normal: Array
    friction: Array


def needed(
    system: StateEquations, t: Array, q: Array, u: Array, a: Array, tau: Array
) -> tuple[list[Needed], list[str]]:
    """Return what contacts that hold a height need over a motion, and what is to be said of it.

    Args:
        system: the mechanism.
        t: times, s, shape (N,).
        q: positions, shape (N, nq).
        u: velocities, shape (N, nv).
        a: their rates, shape (N, nv).
        tau: driving forces, those of prescribed motions included, shape (N, nv).
    """
    contacts = [row for row in system.scene.rows if touches(row)]
    if not contacts:
        return [], []
    labels, decisions = numbers_at(system.scene).constraints.labels, system.decisions
    owners = {k: (label.owner, label.number) for k, label in enumerate(labels) if not label.loop}
    places = {owners[k]: place for place, k in enumerate(decisions.kept) if k in owners}
    shared = {owners[k] for k in decisions.loose if k in owners}
    sizes = multipliers(system.scene, decisions, t, q, u, a, tau)
    found, notes = [], []
    for row in contacts:
        mine = {row.components[number]: k for (name, number), k in places.items() if name == row.name}
        if "normal" not in mine or any((row.name, number) in shared for number in range(len(row.components))):
            notes.append(f"contact {row.name}: its forces are not unique, so that nothing is told of them")
            continue
        normal = sizes[:, mine["normal"]]
        plane = np.hypot(
            *(sizes[:, mine[way]] if way in mine else np.zeros_like(normal) for way in ("along", "across"))
        )
        size = float(np.abs(sizes).max(initial=0.0))
        pushes = normal > NOTHING * size
        one = Needed(row, normal, np.where(pushes, plane / np.where(pushes, normal, 1.0), 0.0))
        found.append(one)
        notes += _told(one, t, size)
    return found, notes


def _told(one: Needed, t: Array, size: float) -> list[str]:
    """Return whether a contact would pull, and the friction that it needs."""
    notes, where = [], f"contact {one.row.name}"
    pulls = np.flatnonzero(one.normal < -NOTHING * size)
    if len(pulls):
        worst = int(one.normal.argmin())
        notes.append(
            f"{where}: its normal force would pull at t = {t[pulls[0]]:.6g} s, by up to {-one.normal[worst]:.3g} N at "
            f"t = {t[worst]:.6g} s; {one.row.place.body if one.row.place else ''} would lift off there, which this "
            "model does not know"
        )
    if float(one.friction.max(initial=0.0)) > NOTHING:
        k = int(one.friction.argmax())
        notes.append(f"{where}: not to slip takes a friction coefficient of {one.friction[k]:.3g} at t = {t[k]:.6g} s")
    return notes
