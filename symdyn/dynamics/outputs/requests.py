"""Requests: the name of a row of the table of outputs, and a body or point that it is about: "jacobian:tool".

A function has a name in code beside it, "jacobian_tool", or "tree_mass_matrix" where loops close a scene; whoever asks
may say either.

The state equation next to any motion, δẋ = A δx + B δτ, as an output: symbols where the scene has such.

    δξ       displacements along the independent positions; all directions of the velocities where nothing closes
    δv       deviations of the independent velocities, all of them where nothing closes
    A        δξ̇ = δu - ad_u δξ with δu = S δξ + T δv, then δv̇ by the derivatives of forward dynamics
    ad_u     Σ_ij γ^l_ij δξ_i u_j is what -ad_u adds to δξ̇_l, of brackets [X_i, X_j] = γ^l_ij X_l

From d/dt (δξ_i X_i f) = δ(u_j X_j f) for every f. A's block of positions is 0 where velocities are rates of coordinates
and all positions independent of the others' rates; where something turns or rolls it is not.

Reference: Bloch, Krishnaprasad, Marsden and Ratiu, The Euler-Poincaré equations and double bracket dissipation (1996),
section 2.

Requests that are too large to be written as lines are refused before they are begun. What can be asked of every output
are rows made of its row, by what is written behind its name; closed scenes have their own along their manifold.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.mechanism.kinematics import check_place
from symdyn.dynamics.mechanism.state import INPUTS, STATES, TIME
from symdyn.dynamics.outputs.constrained_derivatives import ALONG_MANIFOLD, CLOSED, MOTION_RESIDUAL, RESIDUAL, SOLVED
from symdyn.dynamics.outputs.derivative_outputs import BESIDE, SPELLED, by_parameters, derivatives, differentiable
from symdyn.dynamics.outputs.directional_outputs import ALONG_ONE, HESSIAN, PACKED_TENSOR
from symdyn.dynamics.outputs.frame_outputs import IN_FRAMES, MOVING
from symdyn.dynamics.outputs.output import INVERSE, PLENTY, TREE_NAME, DefaultIn, Output, depths_of
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.second_derivatives import PACKED
from symdyn.dynamics.outputs.tangent_space import COLUMNS, independent_positions, independent_velocities, manifold_of
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.joint_table import lacking, tree_alone
from symdyn.dynamics.recursive.table_loops import TABLE_LOOPS
from symdyn.errors import DerivationError, choice, hint, listed, nearest, quoted
from symdyn.graph import Expr
from symdyn.scene import Scene

BY = "_by_"
"""Behind the name of an output, before that of an argument or a parameter."""

MOTION = ("q", "qd", "qdd", "tau", TIME)
"""What is an argument behind `BY`, though a parameter may be called so: NAME_by_parameters has its column."""


def _by(name: str, row: Output, only: str) -> Output:
    """Return the row of derivatives by an argument; by a parameter where that has the name and no argument has."""
    argument = only in row.arguments or only in (*MOTION, INPUTS, STATES)
    return derivatives(name, row, only) if argument else by_parameters(name, row, only)


OPERATORS: dict[str, Callable[[str, Output], Output]] = {
    **ALONG_ONE,
    "_derivatives": derivatives,
    **{f"{BY}{SPELLED.get(one, one)}": partial(_by, only=one) for one in COLUMNS},
    f"{BY}parameters": by_parameters,
}
"""What can be asked of every output, by what is written behind its name, as in "inverse_dynamics_derivatives"."""

WORDS = tuple(f"NAME{one}" for one in (*OPERATORS, f"{BY}PARAMETER"))
"""The same in words, of an output called NAME."""

MANY: dict[str, Output] = {**OUTPUTS, RESIDUAL: MOTION_RESIDUAL}
"""Rows of which many others can be asked for, by a word behind their name."""


def words(of: str, closed: bool) -> list[str]:
    """Return what can be asked of an output, of closed scenes or of others."""
    if not closed or of not in ALONG_MANIFOLD:
        # those of arguments that it does not take are left out
        row = MANY[of]
        along = differentiable(row)
        taken = [
            f"{BY}{SPELLED.get(one, one)}" for one in (*along, *(BESIDE if along else ()), "parameters", "PARAMETER")
        ]
        return [
            f"{of}{one}" for one in (*(OPERATORS if along else ()), f"{BY}PARAMETER") if BY not in one or one in taken
        ] + [f"{of}{PACKED_TENSOR}"] * (f"{of}{PACKED_TENSOR}" in PACKED)
    by = (f"{of}{BY}parameters", f"{of}{BY}PARAMETER") if of in SOLVED else ()
    return [*(one for one in CLOSED if one.startswith(f"{of}_")), *by]


def of_another(name: str, outputs: Mapping[str, Output]) -> Output | None:
    """Return the row of what is asked of one of the outputs, such as "inverse_dynamics_derivatives"; None for no such.

    Raises:
        DerivationError: the output has no such derivatives.
    """
    for suffix, operator in OPERATORS.items():
        if name.endswith(suffix) and (row := outputs.get(of := name.removesuffix(suffix))):
            return operator(of, row)
    of, _, parameter = name.partition(BY)
    return by_parameters(of, outputs[of], parameter) if of in outputs and parameter.isidentifier() else None


def of_closed(name: str) -> Output | None:
    """Return the row that closed scenes have for what is asked; None where there is no other than that of all scenes.

    Raises:
        DerivationError: closed scenes have no such derivatives of what changes along their manifold.
    """
    if name in CLOSED:
        return CLOSED[name]
    output, by, parameter = name.partition(BY)
    if by and output in SOLVED and parameter not in MOTION:
        return ALONG_MANIFOLD[output].by_parameters("" if parameter == "parameters" else parameter)
    of = next((one for one in ALONG_MANIFOLD if name.startswith(f"{one}_") and of_another(name, OUTPUTS)), None)
    if of is None:
        return None
    raise DerivationError(
        f"where loops or rows close a scene there is no {name}; there are {', '.join(words(of, True))}"
    )


STATE_MATRICES = "state_matrices"


def _assembled(formulation: str, derive: Callable[[Workspace], Sequence[Expr]], w: Workspace) -> list[Expr]:
    """Return [A | B] row by row, from the derivatives of forward dynamics."""
    w.scene.refuse_states(STATE_MATRICES, DerivationError)  # state_rates has derivatives by all states
    graph, u, manifold = w.graph, w.state.qd, manifold_of(w, formulation)
    places, speeds = manifold.position_partition.independent, manifold.partition.independent
    slopes, following, moving = manifold.position_tangents, manifold.by_position, manifold.by_velocity
    accelerations = w.once(derive)
    width = len(places) + len(speeds) + w.state.n
    found = []
    for k in places:
        turned = [(i, j, x) for (i, j), terms in w.directions.brackets.items() for m, x in terms if m == k]
        found += [
            graph.total([seeds.get(u[k], graph.zero), *(xi[i] * u[j] * x for i, j, x in turned if i in xi)])
            for xi, seeds in zip(slopes, following, strict=True)
        ]
        found += [seeds.get(u[k], graph.zero) for seeds in moving]
        found += [graph.zero] * w.state.n
    return found + [entry for k in speeds for entry in accelerations[k * width : (k + 1) * width]]


def _state(w: Workspace) -> tuple[str, ...]:
    if w.scene.is_constrained:
        return (*independent_positions(w), *independent_velocities(w))
    return (*COLUMNS["q"](w), *w.scene.velocities)


def state_matrices(closed: bool) -> Output:
    """Return the row of [A | B], of scenes that loops or rows close or of others."""
    forward = OUTPUTS["forward_dynamics"]
    row = CLOSED["forward_dynamics_derivatives"] if closed else derivatives("forward_dynamics", forward)
    which = "independent " if closed else ""
    return Output(
        f"[A | B] of dx/dt = A x + B tau for small deviations from any motion; x are {which}positions, along the "
        f"directions of the velocities, and {which}velocities",
        row.arguments,
        "AB",
        (lambda w: tuple(f"rate of {name}" for name in _state(w)), lambda w: (*_state(w), *COLUMNS["tau"](w))),
        "rate of the row's entry of x, per unit of the column's",
        "same",
        {
            name: replace(formulation, derive=partial(_assembled, name, formulation.derive))
            for name, formulation in row.formulations.items()
        },
        default_in="request",
        may_fail="reported",
        depends=row.depends,
        prefer=row.prefer,
        remark=row.remark,
        size=row.size,
    )


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
    return (TREE_NAME if row.when_constrained == "tree" and scene.is_constrained else "") + request.replace(":", "_")


def request_of(name: str, scene: Scene) -> str:
    """Return the request of a function that is asked for by its name in code; what is none stays as it is."""
    if not isinstance(name, str):
        return name
    places = [*_places(scene), *(one.name for one in scene.outputs), *(one.name for one in scene.ropes)]
    places += [place for _, colon, place in (one.partition(":") for one in OUTPUTS) if colon]
    places += [f"{place}:{frame}" for place in places for frame in IN_FRAMES]
    plain = (name, *([name.removeprefix(TREE_NAME)] if scene.is_constrained else []))
    ends = {at: f"_{at.replace(':', '_')}" for at in places}
    tried = [name, *plain[1:], *(f"{one.removesuffix(end)}:{at}" for one in plain for at, end in ends.items()
                                 if one.endswith(end))]  # fmt: skip
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


def of_place(name: str, by: DefaultIn = "generate", kinds: tuple[str, ...] = ("body", "point")) -> list[str]:
    """Return the outputs of a body or point, or of another kind of place, that are wanted by default."""
    return [f"{one}:{name}" for one, row in OUTPUTS.items() if row.place in kinds and row.is_default_in(by)]


def _places(scene: Scene) -> list[str]:
    return [*(one.name for one in scene.bodies), *(one.name for one in scene.points)]


def _row(request: str, scene: Scene | None) -> tuple[Output, str]:
    """Return the same of a request alone."""
    name, _, place = request.partition(":")
    place, in_frame, frame = place.partition(":")
    closed = scene is not None and scene.is_constrained
    there = {one.removesuffix(f":{place}"): row for one, row in OUTPUTS.items() if place and one.endswith(f":{place}")}
    if row := there.get(name) or of_another(name, there):  # one of the whole scene, such as "reactions:ground"
        place = ""
    row = row or OUTPUTS.get(name, PACKED.get(name)) or _of_state(name, closed) or of_another(name, MANY)
    row = row or CLOSED.get(name)
    asked = name.removeprefix(TREE_NAME)
    if row is None and asked in OUTPUTS and OUTPUTS[asked].when_constrained == "tree":
        raise DerivationError(f"{name} is what {asked} is called where loops close a scene; ask for {asked}")
    if row and in_frame:
        rows = IN_FRAMES.get(frame, MOVING)
        row = rows.get(name) or of_another(name, rows)
        if row is None:
            such = ", ".join(f"{one}:NAME" for one in MOVING)
            raise DerivationError(f"{name} is in no frame that can be chosen; {such} and their derivatives are")
        if frame not in IN_FRAMES:
            raise DerivationError(f"{name}: there is no frame {frame!r}; {choice(frame, IN_FRAMES)}")
    if row is None:
        raise DerivationError(f"there is no output {name!r}; {_those_there(name, closed)}")
    if row.place and not place:
        article = "an" if row.place == "output" else "a"
        there_are = _places(scene) if scene is not None and row.place in KINDS else []
        such_as = f", such as {name}:{there_are[-1]}" if there_are else ""
        raise DerivationError(f"{name} needs {article} {row.place}; write {name}:NAME{such_as}")
    if place and not row.place:
        axes = [one.partition(":") for one in OUTPUTS if ":" in one]
        there_is = [name, *(f"{name}:{one}" for of, _, one in axes if name.startswith(of))]
        raise DerivationError(f"{name} is about the whole scene; write {' or '.join(there_is)}")
    if scene is None:
        return row, place
    if row.when_constrained == "only" and not scene.is_constrained:
        raise DerivationError(f"{name} is about closed loops and rows, of which {scene.name} has none")
    if row.when_constrained == "refuse" and scene.is_constrained:
        raise DerivationError(f"{request} is about trees; loops or rows close {scene.name}")
    if row.place in KINDS:
        check_place(scene, place, KINDS[row.place])
    if in_frame and (other := f"{place}_{frame}") in _places(scene):
        raise DerivationError(
            f"{scene.name}: {request} would be called in code what {name}:{other} is; give {other} another name"
        )
    return row.constrained if scene.is_constrained else row, place


def _those_there(name: str, closed: bool) -> str:
    """Return what can be asked for in place of what there is not: of the output whose name it begins with, if any."""
    of = max((one for one in MANY if name.startswith(f"{one}_")), key=len, default="")
    if of and (near := nearest(name, [one for one in OUTPUTS if one.startswith(f"{of}_")])):
        return f"did you mean {near}?"
    if of:
        return f"of {of} there are {', '.join(words(of, closed))}"
    there = (*OUTPUTS, *(CLOSED if closed else ()), STATE_MATRICES)
    what = next((end for word in WORDS if name.endswith(end := word.removeprefix("NAME"))), "")
    asked = name.removesuffix(what)
    begun = (one for one in there if one.startswith(f"{asked}_") and not hint("names", asked))
    if near := next(begun, None) or nearest(asked, there):
        at = ":NAME" if near in OUTPUTS and OUTPUTS[near].place else ""
        return f"did you mean {near}{what}{at}?"
    derived = f"derivatives of each, such as inverse_dynamics_derivatives: {', '.join(WORDS)}"
    return f"there are {listed(there, 40)}; and {derived}"


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
    tree = tree_alone(scene)
    plain = not any(joint.motion for joint in scene.joints) and not tree.coupled and not tree.spherical_rotors
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


def known_formulation(
    scene: Scene, outputs: Sequence[str], formulation: str | None, others: Iterable[str] = ()
) -> None:
    """Raise DerivationError where a formulation is asked for that no output has; it names these, and others."""
    known = (
        dict.fromkeys(one for request in outputs for one in formulations_of(request, scene))
        if formulation is not None
        else {}
    )
    if formulation is not None and formulation not in known:
        loop = any(
            name == formulation and one.loop
            for request in outputs
            for name, one in row_of(request_of(request, scene))[0].formulations.items()
        )
        why = lacking(scene) if loop else ""
        raise DerivationError(
            f"no output that was asked for has the formulation {formulation!r}{why and f' ({why})'}; "
            f"{choice(formulation, [*known, *others])}"
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
    rows = {name: row_of(request_of(name, scene))[0] for name in outputs}
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


def too_large(workspace: Workspace, request: str) -> str:
    """Return why an output that the scene has is not written as lines, with its size and what to ask for instead.

    "" where it is; inverse dynamics is derived for that only where the size by rows alone is too large.
    """
    if expected_size(workspace, request) <= PLENTY:
        return ""
    simple = workspace.once(simplicity)
    size = expected_size(workspace, request, simple)
    if size <= PLENTY:
        return ""
    ways = [other for other in _instead(workspace, request) if expected_size(workspace, other, simple) <= PLENTY]
    ask = f"ask for {' or '.join(ways)}" if ways else "ask for fewer functions"
    ask += ", or take arrays of symdyn.runtime.second_derivatives" * (request == f"forward_dynamics{PACKED_TENSOR}")
    return (
        f"{workspace.scene.name}: {request} would take some {float(f'{size:.1e}'):,.0f} operations, and {PLENTY:,} are "
        f"the most that are written as lines; {ask}; inverse and forward dynamics and derivatives of them are loops "
        "in C at any length"
    )


def expected_size(workspace: Workspace, request: str, simple: float = 1.0) -> float:
    """Return about how many operations a request takes, weighed; `simple` is 1 where joints turn every way."""
    return row_of(request, workspace.scene)[0].size.of(workspace.once(_depths), simple)


def _depths(workspace: Workspace) -> list[int]:
    return depths_of(workspace.scene)


def simplicity(workspace: Workspace) -> float:
    """Return how many times as large inverse dynamics is as that of joints that turn every way."""
    w = workspace
    entries = w.once(OUTPUTS["inverse_dynamics"].formulations["rnea"].derive)
    return cost(entries, {*w.state.q, *w.state.qd, *w.state.qdd}) / INVERSE.of(w.once(_depths))


def _instead(workspace: Workspace, request: str) -> list[str]:
    """Return what says the same in parts, or along one direction."""
    name, colon, place = request.partition(":")
    if name in PACKED:
        return [f"{name.removesuffix(PACKED_TENSOR)}{word}" for word in (f"{HESSIAN}_vector", HESSIAN)]
    suffix = next((one for one in OPERATORS if name.endswith(one)), "")
    base = name.removesuffix(suffix)
    row = row_of(f"{base}{colon}{place}", workspace.scene)[0]
    words = [*(f"{BY}{one}" for one in differentiable(row)), "_jvp", "_vjp"] if suffix else []
    return [f"{base}{word}{colon}{place}" for word in words if word != suffix]
