"""Expressions of a workspace as functions of a program: of the state, or of a direction beside it."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.mechanism.placements import body_placements
from symdyn.dynamics.mechanism.state import placement
from symdyn.dynamics.roads.equations import Argument, Function, arguments
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene, express
from symdyn.simulation.prescribed.forces import Forces
from symdyn.simulation.prescribed.formulas_in_time import TIME

EVERYTHING = ("q", "qd", "tau", TIME)


def function_of(w: Workspace, name: str, entries: Sequence[Expr], takes: Sequence[str] = EVERYTHING) -> Function:
    """Return entries as a function of everything, or of what it takes."""
    return plain(name, entries, arguments(w, takes))


def points(w: Workspace) -> Function:
    """Return where the declared points of a scene are, ground axes, m, three entries each."""
    placed = body_placements(w.scene, w.graph) if w.scene.points else {}
    places = [placed[one.body] @ placement(one.at, w.graph) for one in w.scene.points]
    return function_of(w, "points", [x for place in places for x in place.p], ("q",))


def point_names(scene: Scene) -> list[str]:
    """Return the names of the columns of `points`."""
    return [f"point_{one.name}_{axis}" for one in scene.points for axis in "xyz"]


def plain(name: str, entries: Sequence[Expr], takes: Sequence[Argument]) -> Function:
    """Return entries as a function of its arguments."""
    return Function(name, name, tuple(takes), "out", (len(entries),), tuple(entries), units="", formulation="")


def argument(graph: Graph, name: str, count: int) -> Argument:
    """Return an argument of so many numbers, such as a direction."""
    return Argument(name, tuple(graph.symbol(f"{name}[{k}]") for k in range(count)), name, ())


def drive(w: Workspace, forces: Forces, k: int) -> Expr:
    """Return the driving force of a velocity: its formula, or the argument that a table fills."""
    return w.state.tau[k] if k in forces.tables else express(forces.formula(k), w.graph)
