"""From a scene to its equations: the door of this room."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.equations import Argument, Equations, Function
from symdyn.dynamics.outputs import OUTPUTS, Output
from symdyn.dynamics.tree import build_tree
from symdyn.dynamics.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph
from symdyn.scene import JOINTS, Scene

DYNAMICS: tuple[str, ...] = tuple(name for name, row in OUTPUTS.items() if not row.place)
"""Outputs of the whole scene; kinematic ones are asked for by name, as in "pose:tool"."""

KINEMATICS = ("pose", "jacobian", "jdot_qdot")

CUBIC = ("coriolis_matrix", "k_C", "k_D")
"""Outputs that grow with the cube of the number of coordinates."""

LARGE = 12

TREES_ONLY = ("aba",)
"""Roads that know no velocity that several moves share: of joints that follow another one, of screws and cams."""


def derive(scene: Scene, outputs: Sequence[str] = DYNAMICS, road: str | None = None) -> Equations:
    """Return the equations of motion of a scene, only the outputs asked for.

    Args:
        scene: the mechanism.
        outputs: names from `OUTPUTS`; a kinematic one with the body or point it is about, as in "jacobian:tool".
        road: which derivation, a key of the output's `roads`; None takes the one that code is generated from.

    Raises:
        DerivationError: an unknown output, road, body or point, or equations that do not exist.
    """
    workspace = Workspace(scene)
    functions = [derive_one(workspace, request, road) for request in outputs]
    return Equations(scene, workspace.graph, tuple(functions))


def available(scene: Scene) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs that a user expects of a scene without asking, and why others are left out.

    These are its dynamics, and the kinematics of its declared points. Left out is what does not exist (forward
    dynamics where the mass matrix is singular) and what is too large to be wanted unasked.
    """
    n = len(scene.velocities)
    wanted = [*DYNAMICS, *(f"{name}:{point.name}" for point in scene.points for name in KINEMATICS)]
    left_out = []
    if n > LARGE:
        wanted = [name for name in wanted if name not in CUBIC]
        left_out.append(f"{', '.join(CUBIC)} are left out for more than {LARGE} coordinates; ask with --functions")
    try:
        derive(scene, ("forward_dynamics",))
    except DerivationError as fault:
        wanted.remove("forward_dynamics")
        left_out.append(str(fault))
    return tuple(wanted), left_out


def roads(request: str, scene: Scene | None = None) -> tuple[str, ...]:
    """Return the names of the derivations of an output, for a scene only those that it has.

    Raises:
        DerivationError: there is no such output.
    """
    found = tuple(_row(request)[0].roads)
    if scene is None or not set(found).intersection(TREES_ONLY) or not build_tree(scene, Graph()).coupled:
        return found
    return tuple(road for road in found if road not in TREES_ONLY)


def derive_one(workspace: Workspace, request: str, road: str | None = None) -> Function:
    """Return one output as a function on the workspace's graph; see `derive`."""
    row, place = _row(request)
    name = road or row.preferred(workspace)
    if name not in row.roads:
        raise DerivationError(f"{request} has no road {name!r}; there are {', '.join(row.roads)}")
    entries = row.roads[name](workspace, place) if row.place else row.roads[name](workspace)
    n = workspace.state.n
    return Function(
        name=request.replace(":", "_"),
        text=row.text.format(name=place),
        arguments=arguments(workspace, row.arguments),
        result=row.result,
        shape=row.shape(n),
        entries=tuple(entries),
        units=row.units,
        formulation=name,
        request=request,
    )


def _row(request: str) -> tuple[Output, str]:
    """Return the row of the table and the place that a request names."""
    name, _, place = request.partition(":")
    row = OUTPUTS.get(name)
    if row is None:
        raise DerivationError(f"there is no output {name!r}; there are {', '.join(OUTPUTS)}")
    if row.place and not place:
        raise DerivationError(f"{name} needs a {row.place}; write {name}:NAME")
    if place and not row.place:
        raise DerivationError(f"{name} is about the whole scene; write {name}")
    return row, place


ARGUMENTS: dict[str, tuple[str, dict[str, str]]] = {  # text, unit by unit of the coordinate
    "q": ("joint positions", {"rad": "rad", "m": "m", "1": "1"}),
    "qd": ("joint velocities", {"rad": "rad/s", "m": "m/s"}),
    "qdd": ("joint accelerations", {"rad": "rad/s^2", "m": "m/s^2"}),
    "tau": ("driving forces, positive accelerates the joint", {"rad": "N m", "m": "N"}),
}


def arguments(workspace: Workspace, names: Sequence[str]) -> tuple[Argument, ...]:
    """Return arguments in calling order, the free parameters last if the scene has any."""
    scene, state = workspace.scene, workspace.state
    symbols: dict[str, tuple[Expr, ...]] = {"q": state.q, "qd": state.qd, "qdd": state.qdd, "tau": state.tau}
    units = [unit for joint in scene.moving for unit in JOINTS[joint.type].coordinates(joint)]
    speeds = [unit for joint in scene.moving for unit in JOINTS[joint.type].velocities(joint)]
    result = []
    for name in names:
        text, spelled = ARGUMENTS[name]
        kinds = units if name == "q" else speeds
        result.append(Argument(name, symbols[name], text, tuple(spelled[kind] for kind in kinds)))
    free = scene.free_parameters
    if free:
        nodes = tuple(workspace.graph.symbol(parameter.name) for parameter in free)
        text = "free parameters: " + ", ".join(parameter.name for parameter in free)
        result.append(Argument("params", nodes, text, tuple(parameter.unit for parameter in free)))
    return tuple(result)
