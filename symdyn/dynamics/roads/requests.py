"""What is asked for: a row of the table of outputs, and the body or point that it is about, as in "jacobian:tool"."""

from __future__ import annotations

from symdyn.dynamics.mechanism.tree import build_tree
from symdyn.dynamics.roads.output import TREE_NAME, Output, Unasked
from symdyn.dynamics.roads.outputs import OUTPUTS
from symdyn.errors import DerivationError
from symdyn.graph import Graph
from symdyn.scene import Scene


def row_of(request: str, scene: Scene | None = None) -> tuple[Output, str]:
    """Return the row of the table, of closed scenes where the scene is one, and the place that a request names.

    Raises:
        DerivationError: there is no such output, or the scene cannot have it.
    """
    name, _, place = request.partition(":")
    if request in OUTPUTS:
        name, place = request, ""
    row = OUTPUTS.get(name)
    if row is None and (asked := name.removeprefix(TREE_NAME)) in OUTPUTS:
        raise DerivationError(f"{name} is what {asked} is called where loops close a scene; ask for {asked}")
    if row is None:
        raise DerivationError(f"there is no output {name!r}; there are {', '.join(OUTPUTS)}")
    if row.place and not place:
        raise DerivationError(f"{name} needs a {row.place}; write {name}:NAME")
    if place and not row.place:
        raise DerivationError(f"{name} is about the whole scene; write {name}")
    if scene is None:
        return row, place
    if row.loops_only and not scene.is_closed:
        raise DerivationError(f"{name} is about closed loops and rows, of which {scene.name} has none")
    if row.in_loops == "refuse" and scene.is_closed:
        raise DerivationError(f"{name} is about trees; loops or rows close {scene.name}")
    return row.where_closed if scene.is_closed else row, place


def roads_of(request: str, scene: Scene | None = None) -> tuple[str, ...]:
    """Return the names of the derivations of an output, for a scene only those that it has.

    Raises:
        DerivationError: there is no such output.
    """
    found = row_of(request, scene)[0].roads
    if scene is None or not any(road.trees_only for road in found.values()):
        return tuple(found)
    tree = build_tree(scene, Graph())
    plain = not any(joint.motion for joint in scene.joints) and not tree.coupled and not tree.balls
    return tuple(name for name, road in found.items() if plain or not road.trees_only)


def expected(scene: Scene, by: Unasked = Unasked.WRITTEN) -> list[str]:
    """Return the outputs of the whole scene that one of its kind has unasked."""
    return [name for name, row in OUTPUTS.items() if not row.place and row.unasked <= by and row.exists_in(scene)]


def of_place(name: str, by: Unasked = Unasked.WRITTEN) -> list[str]:
    """Return the outputs of a body or point that are wanted unasked."""
    return [f"{output}:{name}" for output, row in OUTPUTS.items() if row.place and row.unasked <= by]
