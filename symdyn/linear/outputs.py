"""What is looked at: formulas in what `simulate` has columns of, on the graph of the equations.

Names are coordinates, velocities, accelerations, drives, parameters, time, `point_tip_x`, `reaction_hinge_fx` and
`multiplier_cut_fx_joint`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.dynamics.loops.loop_decisions import loose_rows
from symdyn.dynamics.roads.derive import derive_one
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.errors import LinearizeError
from symdyn.graph import Expr, substitute
from symdyn.scene import Quantity, Scene, acceleration_name, express
from symdyn.scene.units import coordinate_units, drives_with_units, velocity_units
from symdyn.scene.values.names import suggestion
from symdyn.scene.values.quantity import symbol
from symdyn.scene.values.table import Faults
from symdyn.simulation.equations.compiled_routines import point_names, points
from symdyn.simulation.prescribed.formulas_in_time import TIME, close, read_formula
from symdyn.simulation.reaction_columns import multiplier_names, reaction_names

REACTION, MULTIPLIER = "reaction_", "multiplier_"


@dataclass(frozen=True)
class Outputs:
    """Formulas as the user wrote them, read, and their units, "" where nobody tells."""

    names: tuple[str, ...]
    formulas: tuple[Quantity, ...]
    units: tuple[str, ...]


def read_outputs(scene: Scene, texts: Sequence[str]) -> Outputs:
    """Return what is looked at; all coordinates where nothing is said.

    Raises:
        SimulateError: with every fault, one line each.
    """
    if not texts:
        return Outputs(scene.coordinates, tuple(map(symbol, scene.coordinates)), coordinate_units(scene))
    faults, units = Faults(""), _units(scene)
    parameters = [one.name for one in scene.parameters]
    formulas = []
    for text in texts:
        later = _late(text)  # known once it is derived
        formulas.append(read_formula(text, (TIME, *units, *parameters, *later), "outputs", faults))
    for text in dict.fromkeys(text for text in texts if list(texts).count(text) > 1):
        faults.add("outputs", f"{text} is given twice; give it once")
    close(faults)
    found = tuple(one for one in formulas if one is not None)
    return Outputs(tuple(texts), found, tuple(_unit(one, units) for one in found))


def _late(text: str) -> list[str]:
    words = "".join(x if x.isalnum() or x == "_" else " " for x in text).split()
    return [word for word in words if word.startswith((REACTION, MULTIPLIER))]


def _units(scene: Scene) -> dict[str, str]:
    """Return the units of what formulas name."""
    units = velocity_units(scene)
    found = dict(zip(scene.coordinates, coordinate_units(scene), strict=True))
    found |= {name: f"{unit}/s" for name, unit in zip(scene.velocities, units, strict=True)}
    found |= {acceleration_name(name): f"{unit}/s^2" for name, unit in zip(scene.velocities, units, strict=True)}
    found |= {drive: unit for _, drive, unit in drives_with_units(scene)}
    return found | dict.fromkeys(point_names(scene), "m")


def _unit(formula: Quantity, units: dict[str, str]) -> str:
    (name,) = formula.symbols if len(formula.symbols) == 1 else ("",)
    if formula != symbol(name):
        return ""
    if name.startswith((REACTION, MULTIPLIER)):
        component = name.removesuffix("_joint").rpartition("_")[2]
        return "N m" if component.startswith("m") and len(component) == 2 else "N"
    return units.get(name, "")


def on_graph(
    w: Workspace, formulas: Sequence[Quantity], multipliers: Sequence[Expr], push: Sequence[Expr]
) -> list[Expr]:
    """Return formulas as entries; drives are what formulas of forces push, and what is given beside.

    Raises:
        LinearizeError: a reaction or a multiplier that there is not.
    """
    graph, state = w.graph, w.state
    acting = {tau: tau + more for tau, more in zip(state.tau, push, strict=True)}
    found = {graph.symbol(drive): acting[tau] for drive, tau in zip(w.scene.drives, state.tau, strict=True) if drive}
    named = [name for one in formulas for name in one.symbols]
    if w.scene.points:
        found |= {graph.symbol(n): x for n, x in zip(point_names(w.scene), points(w).entries, strict=True)}
    late: dict[str, Expr] = {}
    if any(name.startswith(REACTION) for name in named):
        function = derive_one(w, "forward_reactions" if w.scene.is_closed else "reactions")
        late |= zip(reaction_names(function), substitute(function.entries, acting), strict=True)
    if any(name.startswith(MULTIPLIER) for name in named) and w.scene.is_closed:
        decisions, numbers = w.loops.decisions, w.loops.numbers
        names = multiplier_names(w.scene, decisions, numbers, loose_rows(numbers, decisions.assembly))
        late |= zip(names, multipliers, strict=False)  # those of prescribed motions follow
    for name in named:
        if name.startswith((REACTION, MULTIPLIER)) and name not in late:
            raise LinearizeError(f"outputs: {name} is not known; {suggestion(name, late)}")
    found |= {graph.symbol(name): x for name, x in late.items()}
    return substitute([express(one, graph) for one in formulas], found)
