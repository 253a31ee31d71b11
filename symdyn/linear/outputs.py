"""What is looked at: formulas in what outputs of a scene may name, on the graph of the equations.

Letters are those of `symdyn.scene.values.signals`, parameters, and the outputs that the scene declares.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.outputs import Moving
from symdyn.errors import DerivationError, LinearizeError, SimulateError
from symdyn.graph import Expr, substitute
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import LETTERS, Faults, split_commas
from symdyn.simulation import read_output


@dataclass(frozen=True)
class Outputs:
    """Formulas as the user wrote them, read, and their units, "" where nobody tells."""

    names: tuple[str, ...]
    formulas: tuple[Quantity, ...]
    units: tuple[str, ...]


def read_outputs(scene: Scene, texts: str | Sequence[str]) -> Outputs:
    """Return what is looked at; where nothing is said the outputs of the scene, or else all coordinates.

    Raises:
        SimulateError: with every fault, one line each.
        LinearizeError: names of their own, which the scene declares.
    """
    declared = {one.name: one for one in scene.outputs}
    if isinstance(texts, Mapping):
        raise LinearizeError(
            f"outputs: a name is declared in the scene, [outputs.{next(iter(texts), 'y')}]; give formulas"
        )
    texts = tuple(split_commas(texts) if isinstance(texts, str) else texts) or tuple(declared)
    if not texts:
        units = tuple(scene.shown_unit(unit) for unit in SceneUnits(scene).coordinates)
        return Outputs(scene.coordinates, tuple(map(Quantity.symbol, scene.coordinates)), units)
    faults = Faults("")
    read = [read_output(scene, text, "outputs", faults) for text in texts]
    for text in dict.fromkeys(text for text in texts if texts.count(text) > 1):
        faults.add("outputs", f"{text} is given twice; give it once")
    faults.close(SimulateError)
    found = [one for one in read if one is not None]
    told = [declared[text].unit if text in declared else "" for text in texts]
    known = tuple(one or unit for one, (_, unit) in zip(told, found, strict=True))
    return Outputs(texts, tuple(formula for formula, _ in found), known)


def on_graph(
    w: Workspace, formulas: Sequence[Quantity], multipliers: Sequence[Expr], acting: Mapping[Expr, Expr]
) -> list[Expr]:
    """Return formulas as entries; `acting` tells what driving forces and inputs are.

    Raises:
        LinearizeError: a reaction or a multiplier that there is not.
    """

    def reactions(axes: str) -> list[Expr]:
        name = "forward_reactions" if w.scene.is_closed else "reactions"
        return substitute(derive_one(w, name if axes == LETTERS.axes[0] else f"{name}:{axes}").entries, acting)

    moving = Moving(
        w, lambda: w.state.qdd, lambda: [acting[tau] for tau in w.state.tau], reactions, lambda: multipliers
    )
    try:
        return moving.expressed(formulas, inputs={one: acting[one] for one in w.inputs})
    except DerivationError as fault:
        raise LinearizeError(str(fault)) from None
