"""What a computed motion is looked at for: how well it keeps the laws of mechanics, and what contacts would need.

The balance is K + P - W less its value at the start, where W is the work of drives, damping, friction and loads,
integrated along; P holds gravity and springs. The equations take contacts as two-sided and without slip: whether they
push, and which friction keeps them from slipping, is told of the multipliers N along the normal and F in the plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.scene.forces import FORCES
from symdyn.scene.values import Contact
from symdyn.simulation.equations.parametrised import opened
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.reaction_columns import multipliers
from symdyn.simulation.trajectory import Trajectory


def observe(system: StateEquations, t: Array, x: Array) -> tuple[dict[str, Array], dict[str, float]]:
    """Return columns of energies, powers and residuals at states x, shape (N, nx), and the largest violations."""
    K, P = (np.broadcast_to(system.evaluate(name, t, x).reshape(-1), t.shape) for name in ("kinetic", "potential"))
    columns = {"kinetic_energy": K, "potential_energy": P}
    W = x[:, -1] if system.works else np.zeros_like(t)
    if system.works:
        power = system.evaluate("power", t, x)
        columns |= {"drive_power": power[..., 0], "other_power": power[..., 1], "work": W}
    columns["energy_error"] = (K + P - W) - (K[0] + P[0] - W[0])
    monitors = {"energy": _largest(columns["energy_error"]), "energy_scale": _largest(np.abs(K) + np.abs(P - P[0]))}
    if system.closed:
        for name, told in (("loop_error", "constraint_residual"), ("loop_rate_error", "row_rates")):
            columns[name] = np.abs(system.evaluate(told, t, x)).max(axis=-1, initial=0.0)
        monitors |= {"loops": _largest(columns["loop_error"]), "loop_rates": _largest(columns["loop_rate_error"])}
    if system.quaternions:
        lengths = [np.abs(np.einsum("ni,ni->n", x[:, part], x[:, part]) - 1.0) for part in system.quaternions]
        monitors["quaternions"] = max(_largest(one) for one in lengths)
    if system.momenta:
        places = [system.reported.index(k) for k in system.conserved]
        values = system.evaluate("momenta", t, x).reshape(len(t), -1)[:, places]
        columns |= {name: values[:, k] for k, name in enumerate(system.momenta)}
        monitors["momenta"] = _largest(values - values[0])
    return columns, monitors


def _largest(values: Array) -> float:
    return float(np.max(np.abs(values), initial=0.0))


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

    row: Contact
    normal: Array
    friction: Array


def needed(system: StateEquations, motion: Trajectory) -> tuple[list[Needed], list[str]]:
    """Return what contacts that hold a height need over a motion, and what is to be said of it."""
    contacts = [row for row in system.scene.contacts if FORCES[row.kind].closes(row)]
    if not contacts:
        return [], []
    labels, decisions = opened(system.scene).numbers().constraints.labels, system.decisions
    owners = {k: (label.owner, label.number) for k, label in enumerate(labels) if not label.loop}
    places = {owners[k]: place for place, k in enumerate(decisions.kept) if k in owners}
    shared = {owners[k] for k in decisions.loose if k in owners}
    sizes = multipliers(motion, decisions)
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
        notes += _told(one, motion.t, size)
    return found, notes


def _told(one: Needed, t: Array, size: float) -> list[str]:
    """Return whether a contact would pull, and the friction that it needs."""
    notes, where = [], f"contact {one.row.name}"
    pulls = np.flatnonzero(one.normal < -NOTHING * size)
    if len(pulls):
        worst = int(one.normal.argmin())
        notes.append(
            f"{where}: its normal force would pull at t = {t[pulls[0]]:.6g} s, by up to {-one.normal[worst]:.3g} N at "
            f"t = {t[worst]:.6g} s; {one.row.place.body} would lift off there, which this "
            "model does not know"
        )
    if float(one.friction.max(initial=0.0)) > NOTHING:
        k = int(one.friction.argmax())
        notes.append(f"{where}: not to slip takes a friction coefficient of {one.friction[k]:.3g} at t = {t[k]:.6g} s")
    return notes
