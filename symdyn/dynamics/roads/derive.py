"""From a scene to its equations: the door of this room, and what a scene has without being asked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import prod

from symdyn.arguments import check_arguments
from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.dynamics.mechanism.ldl import Singular, moves_no_mass
from symdyn.dynamics.mechanism.loads import refuse_ideal_friction
from symdyn.dynamics.mechanism.prescribed import INPUTS, TIME, has_motion
from symdyn.dynamics.recursive.table_loops import TableLoop
from symdyn.dynamics.roads.closed_derivatives import RESIDUAL, UNPROJECTED
from symdyn.dynamics.roads.named_functions import DRIVES, Equations, Function, arguments
from symdyn.dynamics.roads.operators import WORDS
from symdyn.dynamics.roads.output import Output, Unasked
from symdyn.dynamics.roads.outputs import OUTPUTS
from symdyn.dynamics.roads.requests import name_in_code, request_of, row_of
from symdyn.dynamics.roads.result_labels import told
from symdyn.dynamics.roads.state_matrices import STATE_MATRICES
from symdyn.dynamics.roads.too_large import too_large
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, growing, reachable
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.scene.forces import elastic
from symdyn.scene.values import listed

TREE_TEXT = "; of the spanning tree, as if nothing closed it"
"""What the name and the text of an output say, where loops close a scene and it is what the tree alone would have."""

LARGE = 12
"""Velocities up to which outputs that grow with their cube are wanted unasked."""

LARGEST = 200
"""Velocities up to which square matrices, and Jacobians of many points, are wanted unasked."""

ASK = "ask with --functions"


@growing()
def derive(
    scene: SceneLike,
    outputs: Sequence[str] | None = None,
    road: str | None = None,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> Equations:
    """Return the equations of motion of a scene, only the outputs asked for.

    >>> import symdyn
    >>> equations = symdyn.derive(symdyn.example("cart_pole"), ["mass_matrix", "pose:tip"])
    >>> equations
    <Equations of cart_pole: mass_matrix(q), pose_tip(q)>
    >>> equations["mass_matrix"].shape, equations["pose:tip"].units
    ((2, 2), '1 and m')

    Args:
        scene: the mechanism.
        outputs: names from `OUTPUTS`; a kinematic one with the body or point it is about, as in "jacobian:tool"; or
            names in code, such as "jacobian_tool". None takes the dynamics that a scene of its kind has.
        road: which derivation, a key of the output's `roads`; None takes the one that code is generated from.
        closing: what to choose about closed loops, see `LoopChoices`.

    Raises:
        DerivationError: an unknown output, road, body or point, or equations that do not exist.
    """
    check_arguments(derive, locals())
    scene = scene_of(scene)
    workspace = Workspace(scene, closing)
    wanted = expected(scene) if outputs is None else outputs
    functions = [derive_one(workspace, request, road) for request in wanted]
    return Equations(scene, workspace.graph, tuple(functions), closing)


@growing()
def loop_alone(workspace: Workspace, request: str, road: str) -> Function:
    """Return an output by a road that is a loop with its table alone: no entry is derived."""
    request = request_of(request, workspace.scene)
    row, place = row_of(request, workspace.scene)
    assert row.roads[road].loop, f"{road} is no loop"
    return _named(workspace, request, row, place, road, ())


@growing()
def derive_one(workspace: Workspace, request: str, road: str | None = None) -> Function:
    """Return one output as a function on the workspace's graph, derived once; see `derive`."""
    request = request_of(request, workspace.scene)
    row, place = row_of(request, workspace.scene)
    try:
        name = road or row.preferred(workspace)
        if (request, name) not in workspace.derived:
            refuse_large(workspace, request)
            workspace.derived[request, name] = _derived(workspace, request, row, place, name)
        return workspace.derived[request, name]
    except Singular as fault:
        if workspace.scene.is_closed:  # a reduced matrix, whose rows are no velocities
            raise
        raise DerivationError(moves_no_mass(workspace.scene, fault.velocity)) from fault


def refuse_large(workspace: Workspace, request: str) -> None:
    """Raise DerivationError where an output is too large to be written as lines."""
    if fault := too_large(workspace, request):
        raise DerivationError(fault)


def _derived(workspace: Workspace, request: str, row: Output, place: str, road: str) -> Function:
    scene = workspace.scene
    if road not in row.roads:
        raise DerivationError(f"{request} has no road {road!r}; there are {', '.join(row.roads)}")
    if DRIVES in row.arguments:
        refuse_ideal_friction(scene)
    entries = workspace.once(row.roads[road].derive, *([place] if row.place else []))
    made = _named(workspace, request, row, place, road, entries)
    assert prod(made.shape) == len(entries), f"{request} by {road}: {len(entries)} entries for {made.labels}"
    return made


def _named(workspace: Workspace, request: str, row: Output, place: str, road: str, entries: Sequence[Expr]) -> Function:
    """Return entries, or none of a loop, with all that is said of them."""
    made = _called(workspace, request, row, place, over_time(workspace, entries))
    unique = row.unique(workspace) if row.unique else ()
    text = made.text + (row.remark(workspace, *([place] if row.place else [])) if row.remark else "")
    text += _chosen(workspace, row) + _loose(made.labels, unique)
    loop = TableLoop(road, workspace.joint_table) if row.roads[road].loop else None
    solve = row.roads[road].solve
    rows = solve(workspace) if solve else None
    return replace(made, text=text, entries=tuple(entries), formulation=road, unique=unique, loop=loop, solve=rows)


def _called(workspace: Workspace, request: str, row: Output, place: str, timed: tuple[str, ...] = ()) -> Function:
    """Return how an output is called, as a function without entries; `timed` are arguments that its row has not."""
    scene = workspace.scene
    tree = row.in_loops == "tree" and scene.is_closed
    labels = tuple(axis(workspace) for axis in row.axes)
    return Function(
        name=name_in_code(row, request, scene),
        text=row.text.format(name=place, **_terms(scene)) + (TREE_TEXT if tree else ""),
        arguments=arguments(workspace, (*row.arguments, *timed), row.weighs(workspace) if row.weighs else ()),
        result=row.result,
        shape=tuple(map(len, labels)),
        entries=(),
        units=row.units,
        formulation="",
        request=request,
        labels=labels,
    )


@growing()
def called(workspace: Workspace, request: str) -> Function | None:
    """Return how an output is called, as a function without entries, derived only where it may not exist.

    None where derivations say what the arguments are: of loops, and of what depends on time or inputs.

    Raises:
        DerivationError: an unknown output, body or point, or equations that do not exist.
    """
    scene = workspace.scene
    request = request_of(request, scene)
    row, place = row_of(request, scene)
    if scene.is_closed or scene.loads or scene.inputs or has_motion(scene):
        return None
    refuse_large(workspace, request)
    return derive_one(workspace, request) if row.lacks != "never" else _called(workspace, request, row, place)


def _loose(labels: Sequence[Sequence[str]], unique: Sequence[bool]) -> str:
    """Return which entries are not unique, behind the text of an output that has such."""
    if all(unique):
        return ""
    rows, columns = labels
    loose = told(rows, columns, [not one for one in unique])
    return f"; not unique, for rigid bodies do not tell them: {loose}"


def _chosen(workspace: Workspace, row: Output) -> str:
    """Return what the user chose about loops, behind the text of an output that it changes."""
    if not workspace.scene.is_closed:
        return ""
    chosen = {choice: getattr(workspace.closing, choice) for choice in row.depends}
    words = replace(LoopChoices(), **chosen).words
    return f"; {words}" if words else ""


def _terms(scene: Scene) -> dict[str, str]:
    """Return what springs and prescribed motions add to the texts of outputs."""
    springs = elastic(scene)
    return {
        "pulls": " + k_E(q)" if springs else "",
        "less_pulls": " - k_E(q)" if springs else "",
        "stored": " and in springs" if springs else "",
        "motion": "; where a motion is prescribed its acceleration, whatever tau" if has_motion(scene) else "",
        "undriven": "zero where it is passive" if any(scene.drives) else "no joint has a drive, so at independent ones",
    }


def over_time(workspace: Workspace, entries: Sequence[Expr]) -> tuple[str, ...]:
    """Return the names of the arguments that entries take beside those of their row: time, and inputs."""
    symbols = {TIME: (TIME,), INPUTS: tuple(one.name for one in workspace.scene.inputs)}
    there = {name: argument for argument, names in symbols.items() for name in names if workspace.graph.names(name)}
    if not there:
        return ()
    found = {there.get(str(node.value)) for node in reachable(entries) if node.op is Op.SYMBOL}
    return tuple(argument for argument in symbols if argument in found)


def expected(scene: Scene, by: Unasked = Unasked.WRITTEN) -> list[str]:
    """Return the outputs of the whole scene that one of its kind has unasked."""
    return [name for name, row in OUTPUTS.items() if not row.place and row.unasked <= by and row.exists_in(scene)]


def on_request(scene: Scene) -> list[str]:
    """Return the outputs of the whole scene that no one has unasked, and how derivatives of all are asked for."""
    alone = [STATE_MATRICES, *((RESIDUAL, f"NAME{UNPROJECTED}") if scene.is_closed else ())]
    return [*(name for name in expected(scene, Unasked.NEVER) if name not in expected(scene)), *alone, *WORDS]


def of_place(name: str, by: Unasked = Unasked.WRITTEN) -> list[str]:
    """Return the outputs of a body or point that are wanted unasked."""
    return [f"{one}:{name}" for one, row in OUTPUTS.items() if row.place in ("body", "point") and row.unasked <= by]


def available(
    scene: Scene,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs of `available_on` for a scene."""
    return available_on(Workspace(scene, closing))


@growing()
def available_on(workspace: Workspace) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs that a user expects of a scene without asking, and why others are left out.

    These are its dynamics, and the kinematics of its declared points. Left out is what does not exist (forward
    dynamics where the mass matrix is singular) and what is too large to be wanted unasked.
    """
    wanted, left_out = wanted_on(workspace)
    found, faults = there(workspace, wanted, lambda w, name: row_of(name)[0].lacks == "never" or derive_one(w, name))
    return found, left_out + faults


def wanted_on(workspace: Workspace) -> tuple[list[str], list[str]]:
    """Return the outputs that a scene of its kind has and that are not too large, and why others are left out.

    Raises:
        DerivationError: the independent coordinates that were chosen are none.
    """
    scene, n = workspace.scene, workspace.state.n
    if workspace.closing.independent:
        _ = workspace.loops.decisions  # a wrong choice is a mistake, not an output that the scene lacks
    wanted = [*expected(scene), *(one for point in scene.points for one in of_place(point.name))]
    left_out = []
    if n > LARGE:
        wanted = [name for name in wanted if not row_of(name)[0].cubic]
        cubic = ", ".join(name for name, row in OUTPUTS.items() if row.cubic)
        left_out.append(f"{cubic} are left out for more than {LARGE} coordinates; {ASK}")
    large = {name: fault for name in wanted if (fault := too_large(workspace, name))}
    wanted = [name for name in wanted if name not in large]
    left_out += large.values()
    if n > LARGEST:
        square = _square(workspace, wanted)
        wanted = [name for name in wanted if name not in square]
        left_out.append(f"{listed(square, 6)}: left out, since their entries grow with the square of {n}; {ASK}")
    return wanted, left_out


def _square(workspace: Workspace, wanted: Sequence[str]) -> list[str]:
    """Return the outputs that have more entries than a square matrix of `LARGEST` rows; of points, all together.

    What a scene may lack is a vector; what it has rows for is not known before.
    """
    rows = {name: row_of(name)[0] for name in wanted}
    sure = {name: row for name, row in rows.items() if row.lacks == "never"}
    sizes = {name: prod(max(1, len(axis(workspace))) for axis in row.axes) for name, row in sure.items()}
    of_points = [name for name, row in sure.items() if row.place]
    if sum(sizes[name] for name in of_points) <= LARGEST**2:
        of_points = []
    return [name for name, size in sizes.items() if size > LARGEST**2 or name in of_points]


def there(
    workspace: Workspace, wanted: Sequence[str], derive: Callable[[Workspace, str], object]
) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs that can be derived, and what is told of others.

    Raises:
        DerivationError: an output cannot be derived that no scene lacks.
    """
    found, faults = [], []
    for name in wanted:
        lacks = row_of(name)[0].lacks
        try:
            derive(workspace, name)
        except DerivationError as fault:
            if lacks == "never":
                raise
            if lacks == "told" and str(fault) not in faults:
                faults.append(str(fault))
        else:
            found.append(name)
    return tuple(found), faults
