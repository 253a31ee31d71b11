"""Which derivation of an output becomes code: the one whose program takes the fewest operations, counted.

Every road of an output is derived, lowered and counted by `Counts.cost`, for the scene at hand with its parameters'
values; of equals the first in the table wins. Two shortcuts keep this quick. A road whose equations cost more than
`HOPELESS` times the cheapest ones is not lowered. And roads that grow fast are tried for few coordinates only, none at
all beyond `LONGEST`, where the table's own rule decides.

A road that is weighed apart is derived on a graph of its own, and on the scene's if it wins: programs are written in
the order in which nodes are born, which what is only weighed must not change.

From so many joints on as `TABLE_LOOPS` says what can be a loop over a table is one in the languages that have it,
beside the lines by the cheapest road, and these need not be derived at all. A road that is asked for is taken at any
number of joints.

Closed forms with sums of angles are no road: they trade multiplications for sines, and a rounded sum of angles has lost
digits that the product form keeps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.dynamics import (
    OUTPUTS,
    TABLE_LOOPS,
    Equations,
    Function,
    LoopChoices,
    TableLoop,
    Workspace,
    derive_one,
    lacking,
    loop_alone,
    roads_of,
    row_of,
)
from symdyn.dynamics.roads import Counts
from symdyn.errors import DerivationError
from symdyn.graph import growing
from symdyn.program.lower import lower
from symdyn.program.pivots import may_vanish
from symdyn.scene import Scene

LONGEST = 16
"""Coordinates up to which roads are compared by counting."""

HOPELESS = 1.5


@growing()
def formulate(
    scene: Scene,
    outputs: Sequence[str],
    road: str | None = None,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
    lines: bool = True,
) -> Equations:
    """Return the equations of a scene, each output by the road that costs least.

    Args:
        scene: the mechanism.
        outputs: as for `derive`.
        road: take this one wherever an output has it; None leaves all to counting.
        closing: what to choose about closed loops.
        lines: whether loops over tables are derived in lines as well; `emit` does it where it has to. Beside functions
            that are no loops they always are.

    Raises:
        DerivationError: an unknown output, body or point, equations that do not exist, a road that no output has.
    """
    workspace = Workspace(scene, closing)
    if closing.independent:
        _ = workspace.loops.decisions
    return Equations(scene, workspace.graph, choose(workspace, outputs, road, lines), closing)


def choose(
    workspace: Workspace, outputs: Sequence[str], road: str | None = None, lines: bool = True
) -> tuple[Function, ...]:
    """Return the outputs on the workspace's graph; see `formulate`."""
    known_road(workspace.scene, outputs, road)
    loops = [looped(workspace, request, road) for request in outputs]
    lines = lines or not all(loops)
    return tuple(_chosen(workspace, *one, road, lines) for one in zip(outputs, loops, strict=True))


def known_road(scene: Scene, outputs: Sequence[str], road: str | None) -> None:
    """Raise DerivationError where a road is asked for that no output has."""
    known = dict.fromkeys(one for request in outputs for one in roads_of(request, scene)) if road is not None else {}
    if road is not None and road not in known:
        loop = any(
            road in OUTPUTS[name].roads and OUTPUTS[name].roads[road].loop for name in outputs if name in OUTPUTS
        )
        why = lacking(scene) if loop else ""
        raise DerivationError(
            f"no output that was asked for has the road {road!r}{why and f' ({why})'}; there are {', '.join(known)}"
        )


def chosen(workspace: Workspace, request: str, road: str | None = None) -> Function:
    """Return an output by the road that was asked for, if it has that, else by the one that costs least, in lines."""
    return _chosen(workspace, request, looped(workspace, request, road), road, lines=True)


def _chosen(workspace: Workspace, request: str, loop: str, road: str | None, lines: bool) -> Function:
    if loop and not lines:
        alone = loop_alone(workspace, request, loop)
        if not (TABLE_LOOPS[loop].divides and may_vanish(workspace.joint_table, workspace.scene)):
            return alone
    if road is not None and road in roads_of(request, workspace.scene):
        return derive_one(workspace, request, road)
    found = cheapest(workspace, request)
    return replace(found, loop=TableLoop(loop, workspace.joint_table)) if loop else found


def looped(workspace: Workspace, request: str, road: str | None) -> str:
    """Return the road by which an output is a loop over a table: the one asked for, or by count; "" for none."""
    roads = row_of(request, workspace.scene)[0].roads
    loops = [name for name, one in roads.items() if one.loop]
    if not loops or (road is None and all(workspace.state.n < TABLE_LOOPS[name].fewest for name in loops)):
        return ""
    there = roads_of(request, workspace.scene)
    if road in there:
        return road if roads[road].loop else ""
    return next((name for name in there if roads[name].loop and workspace.state.n >= TABLE_LOOPS[name].fewest), "")


def kept_in_lines(scene: Scene, outputs: Sequence[str]) -> str:
    """Return why large functions that might be loops over a table are lines, "" where there are none."""
    rows = {name: OUTPUTS[name] for name in outputs if name in OUTPUTS}
    fewest = {
        name: TABLE_LOOPS[road].fewest for name, row in rows.items() for road in row.roads if row.roads[road].loop
    }
    might = [name for name, joints in fewest.items() if len(scene.velocities) >= joints]
    if not might:
        return ""
    why = lacking(scene)
    return f"{scene.name}: {', '.join(might)} in lines, not as a loop over a table: {why}" if why else ""


def cheapest(workspace: Workspace, request: str) -> Function:
    """Return an output by the road that costs least; see `formulate`."""
    names = candidates(workspace, request)
    if len(names) < 2:
        return derive_one(workspace, request, *names)
    row, scene = row_of(request, workspace.scene)[0], workspace.scene
    places = [Workspace(scene, workspace.closing) if row.roads[road].apart else workspace for road in names]
    functions = [derive_one(place, request, road) for place, road in zip(places, names, strict=True)]
    costs = [Counts.of(function).cost for function in functions]
    hopeful = [k for k, cost in enumerate(costs) if cost <= HOPELESS * min(costs)]
    lowered = {k: lower(Equations(scene, places[k].graph, (functions[k],))) for k in hopeful}
    best = min(hopeful, key=lambda k: lowered[k].routines[0].counts.cost)
    return derive_one(workspace, request, names[best])


def candidates(workspace: Workspace, request: str) -> tuple[str, ...]:
    """Return the roads of an output that are worth deriving to compare them, in the table's order."""
    n, row = workspace.state.n, row_of(request, workspace.scene)[0]
    return tuple(name for name in roads_of(request, workspace.scene) if n <= min(LONGEST, row.roads[name].up_to))
