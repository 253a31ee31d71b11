"""From a scene to its equations: the function `derive`.

What a scene has without being asked: outputs that fit it, exist and are not too large.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import prod
from typing import ClassVar

from symdyn.arguments import argument, checked
from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.dynamics.mechanism.linear_solve import Singular, moves_no_mass
from symdyn.dynamics.mechanism.state import INPUTS, STATES, TIME, has_motion, letters_of, refuse_ideal_friction
from symdyn.dynamics.outputs.constrained_derivatives import RESIDUAL, UNPROJECTED
from symdyn.dynamics.outputs.contact_rows import unilaterals_of
from symdyn.dynamics.outputs.named_functions import DRIVES, MODES, Equations, Function, arguments
from symdyn.dynamics.outputs.output import DefaultIn, Output
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.requests import (
    STATE_MATRICES,
    WORDS,
    expected,
    looped,
    name_in_code,
    of_place,
    request_of,
    row_of,
    too_large,
)
from symdyn.dynamics.outputs.result_labels import flagged_entries
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.table_loops import TableLoop
from symdyn.errors import ArgumentError, DerivationError, choice, listed
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, growing, reachable
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.scene.forces import elastic

TREE_TEXT = "; of the spanning tree, as if nothing closed it"
"""What the name and the text of an output say, where loops close a scene and it is what the tree alone would have."""


@growing()
@checked(ArgumentError)
def derive(
    scene: SceneLike,
    outputs: Sequence[str] | None = None,
    formulation: str | None = None,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> Equations:
    """Return the equations of motion of a scene, only the outputs asked for.

    >>> import symdyn
    >>> equations = symdyn.dynamics.derive(symdyn.example("cart_pole"), ["mass_matrix", "pose:tip"])
    >>> equations
    <Equations of cart_pole: mass_matrix(q), pose_tip(q)>
    >>> equations["mass_matrix"].shape, equations["pose:tip"].units
    ((2, 2), '1 and m')

    Args:
        scene: the mechanism.
        outputs: names from `OUTPUTS`; a kinematic one with the body or point it is about, as in "jacobian:tool"; or
            names in code, such as "jacobian_tool". None takes the dynamics that a scene of its kind has.
        formulation: which derivation, a key of the output's `formulations`; None takes the one that code is generated
            from.
        closing: what to choose about closed loops, see `LoopChoices`.

    Raises:
        DerivationError: an unknown output, formulation, body or point, or equations that do not exist.
    """
    scene = scene_of(scene)
    workspace = Workspace(scene, closing)
    wanted = expected(scene) if outputs is None else outputs
    functions = [derive_one(workspace, request, formulation) for request in wanted]
    return Equations(scene, workspace.graph, tuple(functions), closing)


@growing()
def loop_alone(workspace: Workspace, request: str, formulation: str | None = None) -> Function | None:
    """Return an output as a loop with its table alone, no entry derived: by the formulation asked for, or by count.

    None where it is no loop.
    """
    request = request_of(request, workspace.scene)
    row, place = row_of(request, workspace.scene)
    loop = looped(workspace, request, formulation)
    return _named(workspace, request, row, place, loop, ()) if loop else None


@growing()
def derive_one(workspace: Workspace, request: str, formulation: str | None = None) -> Function:
    """Return one output as a function on the workspace's graph, derived once; see `derive`."""
    request = request_of(request, workspace.scene)
    row, place = row_of(request, workspace.scene)
    try:
        name = formulation or row.preferred(workspace)
        if (request, name) not in workspace.derived:
            refuse_large(workspace, request)
            workspace.derived[request, name] = _derived(workspace, request, row, place, name)
        return workspace.derived[request, name]
    except Singular as fault:
        if workspace.scene.is_constrained:  # a reduced matrix, whose rows are no velocities
            raise
        raise DerivationError(moves_no_mass(workspace.scene, fault.velocity)) from fault


def refuse_large(workspace: Workspace, request: str) -> None:
    """Raise DerivationError where an output is too large to be written as lines."""
    if fault := too_large(workspace, request):
        raise DerivationError(fault)


def _derived(workspace: Workspace, request: str, row: Output, place: str, formulation: str) -> Function:
    scene = workspace.scene
    if formulation not in row.formulations:
        raise DerivationError(f"{request} has no formulation {formulation!r}; {choice(formulation, row.formulations)}")
    if DRIVES in row.arguments:
        refuse_ideal_friction(scene)
    entries = workspace.once(row.formulations[formulation].derive, *([place] if row.place else []))
    made = _named(workspace, request, row, place, formulation, entries)
    assert prod(made.shape) == len(entries), f"{request} by {formulation}: {len(entries)} entries for {made.labels}"
    return made


def _named(
    workspace: Workspace, request: str, row: Output, place: str, formulation: str, entries: Sequence[Expr]
) -> Function:
    """Return entries, or none of a loop, with all that is said of them."""
    made = _called(workspace, request, row, place, over_time(workspace, entries))
    unique = row.unique(workspace) if row.unique else ()
    loop = TableLoop(formulation, workspace.joint_table) if row.formulations[formulation].loop else None
    remark = row.remark if loop is None else None  # a table holds nothing that a remark would be about
    text = made.text + (remark(workspace, *([place] if row.place else [])) if remark else "")
    text += _chosen(workspace, row) + _loose(made.labels, unique)
    opens = DRIVES in row.arguments and MODES[0] not in row.arguments and workspace.scene.unilaterals
    text += "; all contacts open" if opens else ""
    solve = row.formulations[formulation].solve
    rows = solve(workspace) if solve else None
    return replace(
        made, text=text, entries=tuple(entries), formulation=formulation, unique=unique, loop=loop, solve=rows
    )


def _called(workspace: Workspace, request: str, row: Output, place: str, timed: tuple[str, ...] = ()) -> Function:
    """Return how an output is called, as a function without entries; `timed` are arguments that its row has not."""
    scene = workspace.scene
    tree = row.when_constrained == "tree" and scene.is_constrained
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

    It is a loop over a table where code would be one by default. None where derivations say what the arguments are: of
    closed scenes, and of what depends on time or inputs.

    Raises:
        DerivationError: an unknown output, body or point, or equations that do not exist.
    """
    if loop := loop_alone(workspace, request):
        return loop
    scene = workspace.scene
    request = request_of(request, scene)
    row, place = row_of(request, scene)
    if scene.is_constrained or scene.loads or scene.given or has_motion(scene):
        return None
    refuse_large(workspace, request)
    return derive_one(workspace, request) if row.may_fail != "never" else _called(workspace, request, row, place)


def _loose(labels: Sequence[Sequence[str]], unique: Sequence[bool]) -> str:
    """Return which entries are not unique, behind the text of an output that has such."""
    if all(unique):
        return ""
    rows, columns = labels
    loose = flagged_entries(rows, columns, [not one for one in unique])
    return f"; not unique, statically indeterminate: {loose}"


def _chosen(workspace: Workspace, row: Output) -> str:
    """Return what the user chose about loops, behind the text of an output that it changes."""
    if not workspace.scene.is_constrained:
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
    """Return the names of the arguments that entries take beside those of their row: time, inputs, and states."""
    named = {kind: tuple(one.name for one in letters_of(workspace.scene, kind)) for kind in (INPUTS, STATES)}
    symbols = {TIME: (TIME,), **named}
    there = {name: argument for argument, names in symbols.items() for name in names if workspace.graph.names(name)}
    if not there:
        return ()
    found = {there.get(str(node.value)) for node in reachable(entries) if node.op is Op.SYMBOL}
    return tuple(argument for argument in symbols if argument in found)


LARGE = 12
"""Velocities up to which outputs that grow with their cube are wanted by default."""


@dataclass(frozen=True)
class Requested:
    """What a scene of its kind has by default and that is not too large, and why others are left out.

    Whether all of it exists derivations tell.
    """

    workspace: Workspace
    outputs: tuple[str, ...]
    left_out: tuple[str, ...]

    LARGEST: ClassVar[int] = 200
    """Velocities up to which square matrices, and Jacobians of many points, are wanted by default."""

    @classmethod
    def of(cls, workspace: Workspace, by: DefaultIn = "generate") -> Requested:
        """Return what is wanted by who writes; who proves wants the last body's too, and what no one writes.

        Raises:
            DerivationError: the independent coordinates that were chosen are none.
        """
        scene, n = workspace.scene, workspace.state.n
        if workspace.closing.independent:
            _ = workspace.loops.decisions  # a wrong choice is a mistake, not an output that the scene lacks
        wanted = [*expected(scene), *(one for point in scene.points for one in of_place(point.name))]
        left_out, ask = [], f"ask with {argument('functions')}"
        if n > LARGE:
            wanted = [name for name in wanted if not row_of(name)[0].cubic]
            cubic = ", ".join(name for name, row in OUTPUTS.items() if row.cubic)
            left_out.append(f"{cubic} are left out for more than {LARGE} coordinates; {ask}")
        large = {name: fault for name in wanted if (fault := too_large(workspace, name))}
        wanted = [name for name in wanted if name not in large]
        left_out += large.values()
        if n > cls.LARGEST:
            square = _square(workspace, wanted)
            wanted = [name for name in wanted if name not in square]
            left_out.append(f"{listed(square, 6)}: left out, since their entries grow with the square of {n}; {ask}")
        if by == "verify":
            wanted += of_place(scene.bodies[-1].name, by)
            wanted += [name for name in expected(scene, by) if row_of(name)[0].default_in == by]
            wanted += [one for law in unilaterals_of(scene)[-1:] for one in of_place(law.name, by, ("contact",))]
        return cls(workspace, tuple(wanted), tuple(left_out))

    @property
    def on_request(self) -> list[str]:
        """The outputs of the whole scene that no one has by default, and how derivatives of all are asked for."""
        scene = self.workspace.scene
        alone = [STATE_MATRICES, *((RESIDUAL, f"NAME{UNPROJECTED}") if scene.is_constrained else ())]
        return [*(name for name in expected(scene, "request") if name not in expected(scene)), *alone, *WORDS]

    @growing()
    def available(self) -> tuple[tuple[str, ...], list[str]]:
        """Return the outputs that exist, derived where that tells, and why all others are left out."""
        found, faults = self.there(lambda w, name: row_of(name)[0].may_fail == "never" or derive_one(w, name))
        return found, [*self.left_out, *faults]

    def there(self, derive: Callable[[Workspace, str], object]) -> tuple[tuple[str, ...], list[str]]:
        """Return the outputs that can be derived, and what is told of others.

        Raises:
            DerivationError: an output cannot be derived that no scene lacks.
        """
        found, faults = [], []
        for name in self.outputs:
            may_fail = row_of(name)[0].may_fail
            try:
                derive(self.workspace, name)
            except DerivationError as fault:
                if may_fail == "never":
                    raise
                if may_fail == "reported" and str(fault) not in faults:
                    faults.append(str(fault))
            else:
                found.append(name)
        return tuple(found), faults


def available(
    scene: Scene,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs that a user expects of a scene without asking, and why others are left out.

    These are its dynamics, and the kinematics of its declared points. Left out is what does not exist (forward
    dynamics where the mass matrix is singular) and what is too large to be wanted by default.
    """
    return Requested.of(Workspace(scene, closing)).available()


def _square(workspace: Workspace, requested: Sequence[str]) -> list[str]:
    """Return the outputs with more entries than a square matrix of `Requested.LARGEST` rows; of points, all together.

    What a scene may lack is a vector; what it has rows for is not known before.
    """
    rows = {name: row_of(name)[0] for name in requested}
    sure = {name: row for name, row in rows.items() if row.may_fail == "never"}
    sizes = {name: prod(max(1, len(axis(workspace))) for axis in row.axes) for name, row in sure.items()}
    of_points = [name for name, row in sure.items() if row.place]
    if sum(sizes[name] for name in of_points) <= Requested.LARGEST**2:
        of_points = []
    return [name for name, size in sizes.items() if size > Requested.LARGEST**2 or name in of_points]
