"""A run through contacts as the page of a lesson plays it, whose script follows no events.

row     t, q, qd, qdd, error of the energy balance;  of each contact with a plane: where it touches, the force on
        what touches there, the plane's normal, all in the ground frame, and the number of its mode
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from symdyn.dynamics.outputs import Touch
from symdyn.frozen import dataclass
from symdyn.scene import Scene
from symdyn.scene.values import PlaneContact

if TYPE_CHECKING:
    from symdyn.simulation import Trajectory

MOST, DIGITS = 250, 6
"""Rows and digits of a page."""


@dataclass(frozen=True)
class Played:
    """A run that is played."""

    scene: Scene  # with its contacts
    rows: tuple[tuple[float, ...], ...] = ()  # see above; none where nothing runs
    frictions: tuple[tuple[float, ...], ...] = ()  # coefficients at rest and of sliding, of each contact with a plane


def played(
    scene: Scene, touches: Sequence[tuple[Touch, Sequence[float]]], values: Mapping[str, float], run: Trajectory | None
) -> Played:
    """Return a run of a scene at values of its parameters, as a page plays it; `touches` have their frictions."""
    if run is None:
        return Played(scene)
    import numpy as np  # scenes without contacts need none

    from symdyn.draw import Stage, pushes

    some = np.arange(0, len(run.t), -(-len(run.t) // MOST))
    columns = [run.t[:, None], run.q, run.qd, run.qdd, run["energy_error"][:, None]]
    found, frictions = Stage(scene, run.q[some], values).places, list[tuple[float, ...]]()
    for touch, friction in touches:
        if not isinstance(touch.law, PlaneContact):
            continue
        name, size = touch.law.name, len(touch.tangents)
        words = ("normal", *(("friction_along", "friction_across") if size > 1 else ("friction",) * size))
        forces = np.stack([run[f"{word}_{name}"] for word in words], axis=1)
        spots, ways = zip(*(pushes(touch.law.closed, found, k) for k in range(len(some))), strict=True)
        along = np.array(ways)[:, [0, *touch.ways[:size]]]
        told = np.zeros((len(run.t), 10))
        told[some] = np.column_stack(
            [np.array(spots), np.einsum("nk,nki->ni", forces[some], along), along[:, 0], run[f"mode_{name}"][some]]
        )
        columns.append(told)
        frictions.append(tuple(friction))
    rows = np.column_stack(columns)[some] + 0.0
    return Played(scene, tuple(tuple(float(f"{x:.{DIGITS}g}") for x in row) for row in rows), tuple(frictions))
