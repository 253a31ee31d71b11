"""What is looked at of a scene: what it computes and what it tells, the cheapest first."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

import symdyn
from symdyn.scene import read_text
from symdyn.scene.joints.joint_table import start_of


def _state(scene: symdyn.Scene) -> object:
    return [list(map(repr, numbers)) for numbers in (start_of(scene).position, start_of(scene).velocity)]


def _forces(scene: symdyn.Scene) -> object:
    """Return forces, energies and what ties say at a state without symmetry, where loops need not be closed."""
    ties = ["constraint_residual", "constraint_jacobian", "constraint_bias"]
    poses = [f"pose:{one.name}" for one in scene.points]
    found: list[Any] = [scene.coordinates]
    for name in [
        "kinetic_energy",
        "potential_energy",
        *(ties if scene.is_constrained else ["inverse_dynamics"]),
        *poses,
    ]:
        try:
            found.append(_values(scene, name))
        except symdyn.SymdynError:  # rows in velocities alone have no residual
            found.append(None)
    return found


def _values(scene: symdyn.Scene, name: str) -> object:
    arguments = symdyn.dynamics.derive(scene, [name])[name].arguments
    given = [0.3 + 0.1 * np.arange(max(1, len(one.symbols))) for one in arguments]
    given = [one[0] if argument.scalar else one for one, argument in zip(given, arguments, strict=True)]
    return np.round(symdyn.lambdify(scene, name)(*given), 12).tolist()


def _reactions(scene: symdyn.Scene) -> object:
    """Return the reactions of a scene with formulas in rates; all others are told by their forces."""
    return _values(scene, "reactions") if scene.constraints else None


def _facts(scene: symdyn.Scene) -> object:
    from symdyn.cli.facts import gather
    from symdyn.dynamics import LoopChoices

    return json.dumps(gather(scene, None, LoopChoices())[0])


def _assumed(scene: symdyn.Scene) -> object:
    return {name: symbol.is_positive for name, symbol in symdyn.equations(scene).sympy().symbols.items()}


def _page(scene: symdyn.Scene) -> object:
    return symdyn.equations(scene).latex(document=True)


def _run(scene: symdyn.Scene) -> object:
    """Return how a run ends, with what it says, and units of its columns."""
    notes: list[str] = []
    run = symdyn.simulate(scene, until=1, every=0.25, method="dop853", say=notes.append)
    return [run.stopped, notes, [str(one) for one in run.columns], np.round(run.table()[1], 9).tolist()]


def _spread(scene: symdyn.Scene) -> object:
    from symdyn.scene.values.entry import Faults
    from symdyn.study.first_order import read_spread

    return str(read_spread(scene, (), None, Faults("")))


COMPUTED: dict[str, Callable[[symdyn.Scene], object]] = {
    "start": _state,
    "forces": _forces,
    "reactions": _reactions,
    "run": _run,
}
"""What is computed, the cheapest first."""

TOLD: dict[str, Callable[[symdyn.Scene], object]] = {
    "picture": symdyn.picture,
    "facts": _facts,
    "page": _page,
    "assumptions": _assumed,
    "spread": _spread,
}
"""What is told, likewise."""


def differs(texts: tuple[str, str]) -> str:
    """Return what two scenes say or compute differently, "" where it is nothing."""
    first, second = (replace(read_text(text), source="") for text in texts)
    for name, look in {**COMPUTED, **TOLD}.items():
        told = [_looked(look, scene) for scene in (first, second)]
        if told[0] != told[1]:
            return name
    return ""


def _looked(look: Callable[[symdyn.Scene], object], scene: symdyn.Scene) -> object:
    try:
        return look(scene)
    except symdyn.SymdynError as refused:  # in words, which may differ
        return str(refused)
