"""From a scene to its equations: the door of this room."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

from symdyn.dynamics.equations import Argument, Equations, Function
from symdyn.dynamics.loads import refuse_ideal_friction
from symdyn.dynamics.loops.outputs import CLOSED_ONLY
from symdyn.dynamics.loops.partition import Closing
from symdyn.dynamics.output import Output
from symdyn.dynamics.outputs import OUTPUTS
from symdyn.dynamics.prescribed import TIME
from symdyn.dynamics.reactions.outputs import REACTIONS
from symdyn.dynamics.recursive.ldl import Singular, moves_no_mass
from symdyn.dynamics.tree import build_tree
from symdyn.dynamics.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, Op, growing, reachable
from symdyn.scene import Scene
from symdyn.scene.names import listed
from symdyn.scene.robot_words import coordinates_of_joints
from symdyn.scene.units import coordinate_units, velocity_units

DYNAMICS: tuple[str, ...] = tuple(
    name for name, row in OUTPUTS.items() if not row.place and name not in CLOSED_ONLY and name not in REACTIONS
)
"""Outputs of the whole scene, with or without loops; reactions, and "pose:tool" and its like, are asked for by name."""

KINEMATICS = ("pose", "jacobian", "jdot_qdot")

CUBIC = ("coriolis_matrix", "k_C", "k_D")
"""Outputs that grow with the cube of the number of coordinates."""

LARGE = 12

LARGEST = 200
"""Velocities up to which square matrices, and Jacobians of many points, are wanted unasked."""

ASK = "ask with --functions"

DRIVES = "tau"
"""The argument of what finds a motion."""

UNSURE = ("forward_dynamics", "drive_forces", "inverse_dynamics", *CLOSED_ONLY)
"""Outputs that a scene may lack: its mass matrix is singular, or its loops cannot be closed."""

PARTITIONED = ("inverse_dynamics", "velocities", "positions")
"""Outputs whose formulas depend on the independent coordinates that are chosen."""

STABILISED = ("forward_dynamics", "drive_forces", "multipliers")
"""Outputs whose formulas depend on all that is chosen about loops."""

TREES_ONLY = ("aba",)
"""Roads that know no prescribed motion and no velocity that several moves share, as of screws and cams."""


@growing()
def derive(
    scene: Scene,
    outputs: Sequence[str] | None = None,
    road: str | None = None,
    closing: Closing = Closing(),  # noqa: B008  frozen
) -> Equations:
    """Return the equations of motion of a scene, only the outputs asked for.

    Args:
        scene: the mechanism.
        outputs: names from `OUTPUTS`; a kinematic one with the body or point it is about, as in "jacobian:tool". None
            takes the dynamics that a scene of its kind has.
        road: which derivation, a key of the output's `roads`; None takes the one that code is generated from.
        closing: what to choose about closed loops.

    Raises:
        DerivationError: an unknown output, road, body or point, or equations that do not exist.
    """
    workspace = Workspace(scene, closing)
    wanted = _expected(scene) if outputs is None else outputs
    functions = [derive_one(workspace, request, road) for request in wanted]
    return Equations(scene, workspace.graph, tuple(functions), closing)


def available(
    scene: Scene,
    closing: Closing = Closing(),  # noqa: B008  frozen
) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs of `available_on` for a scene."""
    return available_on(Workspace(scene, closing))


@growing()
def available_on(workspace: Workspace) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs that a user expects of a scene without asking, and why others are left out.

    These are its dynamics, and the kinematics of its declared points. Left out is what does not exist (forward
    dynamics where the mass matrix is singular) and what is too large to be wanted unasked.
    """
    scene, closing, n = workspace.scene, workspace.closing, workspace.state.n
    wanted = _expected(scene)
    wanted += [f"{name}:{point.name}" for point in scene.points for name in KINEMATICS]
    left_out = []
    if n > LARGE:
        wanted = [name for name in wanted if name not in CUBIC]
        left_out.append(f"{', '.join(CUBIC)} are left out for more than {LARGE} coordinates; {ASK}")
    if n > LARGEST:
        large = _square(scene, wanted)
        wanted = [name for name in wanted if name not in large]
        left_out.append(f"{listed(large, 6)}: left out, since their entries grow with the square of {n}; {ASK}")
    if closing.independent:
        workspace.closed.check()  # a wrong choice is a mistake, not an output that the scene lacks
    for name in [one for one in wanted if one in UNSURE]:
        try:
            derive_one(workspace, name)
        except DerivationError as fault:
            wanted.remove(name)
            if name != "positions" and str(fault) not in left_out:  # few loops have a closed form
                left_out.append(str(fault))
    return tuple(wanted), left_out


def _square(scene: Scene, wanted: Sequence[str]) -> list[str]:
    """Return the outputs that have more entries than a square matrix of `LARGEST` rows; of points, all together."""
    n = len(scene.velocities)
    sizes = {name: prod(max(1, length) for length in _row(name, scene)[0].shape(n)) for name in wanted}
    of_points = [name for name in wanted if ":" in name]
    if sum(sizes[name] for name in of_points) <= LARGEST**2:
        of_points = []
    return [name for name in wanted if sizes[name] > LARGEST**2 or name in of_points]


def _expected(scene: Scene) -> list[str]:
    """Return the dynamics that a scene of its kind has."""
    return [name for name in (*DYNAMICS, *CLOSED_ONLY) if OUTPUTS[name].exists(scene)]


def roads(request: str, scene: Scene | None = None) -> tuple[str, ...]:
    """Return the names of the derivations of an output, for a scene only those that it has.

    Raises:
        DerivationError: there is no such output.
    """
    found = tuple(_row(request, scene)[0].roads)
    if scene is None or not set(found).intersection(TREES_ONLY):
        return found
    tree = build_tree(scene, Graph())
    if not any(joint.motion for joint in scene.joints) and not tree.coupled and not tree.balls:
        return found
    return tuple(road for road in found if road not in TREES_ONLY)


def derive_one(workspace: Workspace, request: str, road: str | None = None) -> Function:
    """Return one output as a function on the workspace's graph; see `derive`."""
    try:
        if (request, road) not in workspace.derived:
            workspace.derived[request, road] = _derived(workspace, request, road)
        return workspace.derived[request, road]
    except Singular as fault:
        if workspace.scene.is_closed:  # a reduced matrix, whose rows are no velocities
            raise
        raise DerivationError(moves_no_mass(workspace.scene, fault.velocity)) from fault


def _derived(workspace: Workspace, request: str, road: str | None) -> Function:
    row, place = _row(request, workspace.scene)
    name = road or row.preferred(workspace)
    if name not in row.roads:
        raise DerivationError(f"{request} has no road {name!r}; there are {', '.join(row.roads)}")
    if DRIVES in row.arguments:
        refuse_ideal_friction(workspace.scene)
    entries = row.roads[name](workspace, place) if row.place else row.roads[name](workspace)
    n = workspace.state.n
    unique = row.unique(workspace) if row.unique else ()
    return Function(
        name=request.replace(":", "_"),
        text=row.text.format(name=place, **_terms(workspace.scene))
        + _chosen(workspace, request)
        + _loose(workspace.scene, unique),
        arguments=arguments(workspace, (*row.arguments, *((TIME,) if _takes_time(workspace.graph, entries) else ()))),
        result=row.result,
        shape=_complete(row.shape(n), len(entries)),
        entries=tuple(entries),
        units=row.units,
        formulation=name,
        request=request,
        unique=unique,
    )


def _loose(scene: Scene, unique: Sequence[bool]) -> str:
    """Return which entries are not unique, behind the text of an output that has such."""
    if all(unique):
        return ""
    from symdyn.dynamics.reactions.loose import loose_words  # with NumPy, which printing can do without

    return f"; not unique, for rigid bodies do not tell them: {loose_words(scene, unique)}"


def _chosen(workspace: Workspace, request: str) -> str:
    """Return what the user chose about loops, behind the text of an output that it changes."""
    if not workspace.scene.is_closed or request not in (*PARTITIONED, *STABILISED):
        return ""
    closing = workspace.closing
    words = closing.words if request in STABILISED else Closing(closing.independent).words
    return f"; {words}" if words else ""


def _terms(scene: Scene) -> dict[str, str]:
    """Return what springs and prescribed motions add to the texts of outputs."""
    springs, motion = OUTPUTS["k_E"].exists(scene), OUTPUTS["prescribed_motion"].exists(scene)
    return {
        "pulls": " + k_E(q)" if springs else "",
        "less_pulls": " - k_E(q)" if springs else "",
        "stored": " and in springs" if springs else "",
        "motion": "; where a motion is prescribed its acceleration, whatever tau" if motion else "",
        "undriven": "zero where it is passive" if any(scene.drives) else "no joint has a drive, so at independent ones",
    }


def _takes_time(graph: Graph, entries: Sequence[Expr]) -> bool:
    return graph.names(TIME) and any(node.op is Op.SYMBOL and node.value == TIME for node in reachable(entries))


def _complete(shape: tuple[int, ...], size: int) -> tuple[int, ...]:
    """Return a shape with the length that its one -1 stands for."""
    known = prod(length for length in shape if length >= 0)
    return tuple(length if length >= 0 else size // max(1, known) for length in shape)


def _row(request: str, scene: Scene | None = None) -> tuple[Output, str]:
    """Return the row of the table, of closed scenes where the scene is one, and the place that a request names."""
    name, _, place = request.partition(":")
    if request in OUTPUTS:
        name, place = request, ""
    row = OUTPUTS.get(name)
    if row is None:
        raise DerivationError(f"there is no output {name!r}; there are {', '.join(OUTPUTS)}")
    if row.place and not place:
        raise DerivationError(f"{name} needs a {row.place}; write {name}:NAME")
    if place and not row.place:
        raise DerivationError(f"{name} is about the whole scene; write {name}")
    if scene is not None and scene.is_closed and row.closed is not None:
        row = row.closed
    if scene is not None and name in CLOSED_ONLY and not scene.is_closed:
        raise DerivationError(f"{name} is about closed loops and rows, of which {scene.name} has none")
    return row, place


ARGUMENTS: dict[str, tuple[str, dict[str, str]]] = {  # text, unit by unit of the coordinate
    "q": ("joint positions", {"rad": "rad", "m": "m", "1": "1"}),
    "qd": ("joint velocities", {"rad": "rad/s", "m": "m/s"}),
    "qdd": ("joint accelerations", {"rad": "rad/s^2", "m": "m/s^2"}),
    "tau": ("driving forces, positive accelerates the joint", {"rad": "N m", "m": "N"}),
    TIME: ("time", {"s": "s"}),
    "qi": ("independent joint positions", {"rad": "rad", "m": "m"}),
    "ui": ("independent joint velocities", {"rad": "rad/s", "m": "m/s"}),
}


BODY_AXES = "velocities v and w of free joints and w of balls are along the axes of the moved frame"


def conventions(scene: Scene, name: str) -> str:
    """Return the names of the coordinates or velocities, and what they mean where that is not plain; else ""."""
    plain = len(scene.coordinates) == len(scene.velocities)
    if name == "q":
        told = coordinates_of_joints(scene) or runs(scene.coordinates)
        return told + ("" if plain else "; quaternions are in the order (w, x, y, z)")
    if name == "qd" and not plain:
        return f"{runs(scene.velocities)}; {BODY_AXES}"
    return ""


def runs(names: Sequence[str]) -> str:
    """Return names in order, those that count up told by the first and the last: "x, q1 ... q7"."""
    groups: list[list[str]] = []
    for name in names:
        if groups and _next(groups[-1][-1]) == name:
            groups[-1].append(name)
        else:
            groups.append([name])
    return ", ".join(", ".join(g) if len(g) < 4 else f"{g[0]} ... {g[-1]}" for g in groups)


def _next(name: str) -> str:
    stem = name.rstrip("0123456789")
    digits = name[len(stem) :]
    return f"{stem}{int(digits) + 1}" if digits.isdecimal() else ""


def arguments(workspace: Workspace, names: Sequence[str]) -> tuple[Argument, ...]:
    """Return arguments in calling order: state, time where it is asked for, the free parameters if there are any."""
    scene, state = workspace.scene, workspace.state
    symbols: dict[str, tuple[Expr, ...]] = {"q": state.q, "qd": state.qd, "qdd": state.qdd, "tau": state.tau}
    if TIME in names:  # a graph without the symbol need not be searched for it
        symbols[TIME] = (workspace.graph.symbol(TIME),)
    units = coordinate_units(scene)
    speeds = velocity_units(scene)
    result = []
    for name in names:
        text, spelled = ARGUMENTS[name]
        kinds, nodes = units if name == "q" else ["s"] if name == TIME else speeds, symbols.get(name)
        if nodes is None:  # of the independent velocities, or of the coordinates whose rates they are
            independent = workspace.closed.closure.partition.independent
            whole = state.qd if name == "ui" else workspace.closed.coordinates
            kinds, nodes = [speeds[k] for k in independent], tuple(whole[k] for k in independent)
            text = f"{text}: {', '.join(str(node.value) for node in nodes)}"
        entries = tuple(spelled[kind] for kind in kinds)
        result.append(Argument(name, nodes, text, entries, name == TIME, conventions(scene, name)))
    free = scene.free_parameters
    if free:
        nodes = tuple(workspace.graph.symbol(parameter.name) for parameter in free)
        text = "free parameters: " + ", ".join(parameter.name for parameter in free)
        result.append(Argument("params", nodes, text, tuple(parameter.unit for parameter in free)))
    return tuple(result)
