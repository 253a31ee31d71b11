"""Requests: the name of a row of the table of outputs, and a body or point that it is about: "jacobian:tool".

A function has a name in code beside it, "jacobian_tool", or "tree_mass_matrix" where loops close a scene; whoever asks
may say either.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.mechanism.kinematics import check_place
from symdyn.dynamics.mechanism.tree import build_tree
from symdyn.dynamics.outputs.closed_derivatives import CLOSED
from symdyn.dynamics.outputs.operators import MANY, WORDS, of_another, of_closed, words
from symdyn.dynamics.outputs.output import TREE_NAME, DefaultIn, Output
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.state_matrices import STATE_MATRICES, state_matrices
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.joint_table import lacking
from symdyn.dynamics.recursive.table_loops import TABLE_LOOPS
from symdyn.errors import DerivationError, quoted
from symdyn.graph import Graph
from symdyn.scene import Scene

KINDS = {"body": "body", "point": "body or point"}
"""What the place of an output may be the name of, by its row's `place`; names of [outputs] are looked for there."""


def row_of(request: str, scene: Scene | None = None) -> tuple[Output, str]:
    """Return the row of the table, of closed scenes where the scene is one, and the place that a request names.

    Raises:
        DerivationError: there is no such output, or the scene cannot have it.
    """
    if not isinstance(request, str):
        raise DerivationError(f"output {quoted(request)} is no name; give text, such as mass_matrix")
    try:
        return _row(request, scene)
    except DerivationError:
        other = request if scene is None else request_of(request, scene)
        if other == request:
            raise
        return _row(other, scene)


def name_in_code(row: Output, request: str, scene: Scene) -> str:
    """Return what the function of a request is called in code."""
    return (TREE_NAME if row.when_constrained == "tree" and scene.is_closed else "") + request.replace(":", "_")


def request_of(name: str, scene: Scene) -> str:
    """Return the request of a function that is asked for by its name in code; what is none stays as it is."""
    if not isinstance(name, str):
        return name
    places = [one.name for one in scene.bodies] + [one.name for one in scene.points]
    places += [one.name for one in scene.outputs]
    places += [place for _, colon, place in (one.partition(":") for one in OUTPUTS) if colon]
    plain = (name, *([name.removeprefix(TREE_NAME)] if scene.is_closed else []))
    tried = [name, *plain[1:], *(f"{one.removesuffix(f'_{at}')}:{at}" for one in plain for at in places
                                 if one.endswith(f"_{at}"))]  # fmt: skip
    for request in dict.fromkeys(tried):
        try:
            row, _ = _row(request, scene)
        except DerivationError:
            continue
        if name in (request, name_in_code(row, request, scene)):
            return request
    return name


def expected(scene: Scene, by: DefaultIn = "generate") -> list[str]:
    """Return the outputs of the whole scene that one of its kind has by default."""
    return [name for name, row in OUTPUTS.items() if not row.place and row.is_default_in(by) and row.exists_in(scene)]


def of_place(name: str, by: DefaultIn = "generate") -> list[str]:
    """Return the outputs of a body or point that are wanted by default."""
    return [f"{one}:{name}" for one, row in OUTPUTS.items() if row.place in ("body", "point") and row.is_default_in(by)]


def _row(request: str, scene: Scene | None) -> tuple[Output, str]:
    """Return the same of a request alone."""
    name, _, place = request.partition(":")
    closed = scene is not None and scene.is_closed
    there = {one.removesuffix(f":{place}"): row for one, row in OUTPUTS.items() if place and one.endswith(f":{place}")}
    if row := there.get(name) or of_another(name, there):  # one of the whole scene, such as "reactions:ground"
        place = ""
    row = row or OUTPUTS.get(name) or _of_state(name, closed) or of_another(name, MANY) or CLOSED.get(name)
    asked = name.removeprefix(TREE_NAME)
    if row is None and asked in OUTPUTS and OUTPUTS[asked].when_constrained == "tree":
        raise DerivationError(f"{name} is what {asked} is called where loops close a scene; ask for {asked}")
    if row is None:
        raise DerivationError(f"there is no output {name!r}; {_those_there(name, closed)}")
    if row.place and not place:
        article = "an" if row.place == "output" else "a"
        raise DerivationError(f"{name} needs {article} {row.place}; write {name}:NAME")
    if place and not row.place:
        axes = [one.partition(":") for one in OUTPUTS if ":" in one]
        there_is = [name, *(f"{name}:{one}" for of, _, one in axes if name.startswith(of))]
        raise DerivationError(f"{name} is about the whole scene; write {' or '.join(there_is)}")
    if scene is None:
        return row, place
    if row.when_constrained == "only" and not scene.is_closed:
        raise DerivationError(f"{name} is about closed loops and rows, of which {scene.name} has none")
    if row.when_constrained == "refuse" and scene.is_closed:
        raise DerivationError(f"{name} is about trees; loops or rows close {scene.name}")
    if row.place in KINDS:
        check_place(scene, place, KINDS[row.place])
    return row.constrained if scene.is_closed else row, place


def _those_there(name: str, closed: bool) -> str:
    """Return what can be asked for in place of what there is not: of the output whose name it begins with, if any."""
    of = max((one for one in MANY if name.startswith(f"{one}_")), key=len, default="")
    if of:
        return f"of {of} there are {', '.join(words(of, closed))}"
    derived = f"derivatives of each, such as inverse_dynamics_derivatives: {', '.join(WORDS)}"
    return f"there are {', '.join((*OUTPUTS, *(CLOSED if closed else ()), STATE_MATRICES))}; and {derived}"


def _of_state(name: str, closed: bool) -> Output | None:
    """Return the row of state matrices, or one that closed scenes have in place of what operators make of another."""
    return state_matrices(closed) if name == STATE_MATRICES else of_closed(name) if closed else None


def formulations_of(request: str, scene: Scene | None = None) -> tuple[str, ...]:
    """Return the names of the derivations of an output, for a scene only those that it has.

    Raises:
        DerivationError: there is no such output.
    """
    found = row_of(request, scene)[0].formulations
    if scene is None or not any(formulation.trees_only or formulation.loop for formulation in found.values()):
        return tuple(found)
    tree = build_tree(scene, Graph())
    plain = not any(joint.motion for joint in scene.joints) and not tree.coupled and not tree.balls
    held = not lacking(scene)
    return tuple(
        n
        for n, formulation in found.items()
        if (plain or not formulation.trees_only) and (held or not formulation.loop)
    )


def formulations_lacking(request: str, scene: Scene) -> dict[str, str]:
    """Return the derivations that an output has of other scenes and not of this one, each with the reason.

    Raises:
        DerivationError: there is no such output.
    """
    request = request_of(request, scene)
    there, own = formulations_of(request, scene), row_of(request, scene)[0].formulations
    closed, shared = (
        "it is of trees, and loops or rows close the scene",
        "it knows no motion that joints share or are led",
    )
    lacks = lacking(scene)
    return {
        name: closed if name not in own else lacks if formulation.loop else shared
        for name, formulation in row_of(request)[0].formulations.items()
        if name not in there
    }


def known_formulation(scene: Scene, outputs: Sequence[str], formulation: str | None) -> None:
    """Raise DerivationError where a formulation is asked for that no output has."""
    known = (
        dict.fromkeys(one for request in outputs for one in formulations_of(request, scene))
        if formulation is not None
        else {}
    )
    if formulation is not None and formulation not in known:
        loop = any(
            formulation in OUTPUTS[name].formulations and OUTPUTS[name].formulations[formulation].loop
            for name in outputs
            if name in OUTPUTS
        )
        why = lacking(scene) if loop else ""
        raise DerivationError(
            f"no output that was asked for has the formulation {formulation!r}{why and f' ({why})'}; "
            f"there are {', '.join(known)}"
        )


def looped(workspace: Workspace, request: str, formulation: str | None) -> str:
    """Return the formulation by which an output is a loop over a table: the one asked for, or by count; "" for none."""
    formulations = row_of(request, workspace.scene)[0].formulations
    loops = [name for name, one in formulations.items() if one.loop]
    if not loops or (formulation is None and all(workspace.state.n < TABLE_LOOPS[name].fewest for name in loops)):
        return ""
    there = formulations_of(request, workspace.scene)
    if formulation in there:
        return formulation if formulations[formulation].loop else ""
    return next(
        (name for name in there if formulations[name].loop and workspace.state.n >= TABLE_LOOPS[name].fewest), ""
    )


def kept_in_lines(scene: Scene, outputs: Sequence[str]) -> str:
    """Return why large functions that might be loops over a table are lines, "" where there are none."""
    rows = {name: OUTPUTS[name] for name in outputs if name in OUTPUTS}
    fewest = {
        name: TABLE_LOOPS[formulation].fewest
        for name, row in rows.items()
        for formulation in row.formulations
        if row.formulations[formulation].loop
    }
    might = [name for name, joints in fewest.items() if len(scene.velocities) >= joints]
    if not might:
        return ""
    why = lacking(scene)
    return f"{scene.name}: {', '.join(might)} in lines, not as a loop over a table: {why}" if why else ""
