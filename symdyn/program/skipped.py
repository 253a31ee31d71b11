"""The skip report: what a scene does not need, what was merged, and how many operations each of these saves.

A step is measured by counting with the step off and on, everything else alike: the same formulations, the other steps
on, and no passes but where the step is one. Only work that depends on the state is counted. What can't be switched off,
since nobody would know what to put in its place, is listed without a number.

    scene        massless bodies, gravity, parallel axes, a plane, zeros of inertias, bound parameters; without a
                 number, fixed and locked joints
    recursion    regrouped inertias
    choice       the formulation that an output prefers for such a scene, in place of the first one
    program      each pass in its turn
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from symdyn.dynamics import Equations, Workspace, angle_groups, derive_one, formulations_of
from symdyn.dynamics.outputs import Counts
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Graph, reachable
from symdyn.program.lower import lower
from symdyn.program.passes import DEFAULT
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Body, Pose

SLANTING = (Quantity.number(Fraction(7, 2)), Quantity.number(Fraction(5, 3)), Quantity.number(-9))

ODD = Quantity.number(Fraction(31, 37))
TILT = (("Rx", Quantity.number(Fraction(2, 7))), ("Ry", Quantity.number(Fraction(3, 11))))

Savings = dict[str, Counts]


@dataclass(frozen=True)
class Skipped:
    """One thing that was left out or merged.

    Attributes:
        step: short name.
        why: what it is in this scene, one line.
        saved: operations by function, those alone that save any; None where it can't be measured.
    """

    step: str
    why: str
    saved: Mapping[str, Counts] | None = None


def skipped(equations: Equations, requests: Sequence[str]) -> tuple[Skipped, ...]:
    """Return the skip report of equations from `formulate`, and of what they were asked for by, in the same order."""
    scene = equations.scene
    chosen = {request: f.formulation for request, f in zip(requests, equations.functions, strict=True)}
    on = _counts(equations)
    report = [*_dead(Workspace(scene, equations.closing), chosen), *_structure(scene)]
    for step, why, other in _other_scenes(scene):
        report.append(Skipped(step, why, _saved(on, Workspace(other, equations.closing), chosen)))
    report.append(
        Skipped(
            "regrouped inertias",
            "what a joint cannot feel of a body belongs to the body before it",
            _saved(on, Workspace(scene, regrouped=False), chosen),
        )
    )
    first = {request: formulations_of(request, scene)[0] for request in requests}
    changed = {request: formulation for request, formulation in first.items() if formulation != chosen[request]}
    if changed:
        why = ", ".join(
            f"{request} by {chosen[request]} instead of {formulation}" for request, formulation in changed.items()
        )
        report.append(Skipped("formulation", why, _saved(on, Workspace(scene, equations.closing), first)))
    for k, name in enumerate(DEFAULT, start=1):
        after = _counts(equations, DEFAULT[:k])
        saved = _positive({function: on[function] - after[function] for function in on})
        report.append(Skipped(name, f"pass {k} of {len(DEFAULT)} over the program", saved))
        on = after
    return tuple(report)


def _dead(workspace: Workspace, chosen: Mapping[str, str]) -> Iterator[Skipped]:
    """Return what the chosen formulations derive on the way and no function needs; other formulations do not count."""
    functions = [derive_one(workspace, request, formulation) for request, formulation in chosen.items()]
    alive = set(reachable([entry for function in functions for entry in function.entries]))
    dead = sum(Counts.counts_alone(node.op) and node not in alive for node in workspace.graph.nodes)
    if dead:
        yield Skipped("dead operations", f"{dead} that the chosen formulations derive on the way and no function needs")


def _structure(scene: Scene) -> Iterator[Skipped]:
    """Return what has no place in the equations from the start."""
    locked = [joint.name for joint in scene.joints if joint.locked]
    fixed = [joint.child for joint in scene.joints if not joint.moves and not joint.locked]
    if locked:
        yield Skipped("locked joints", _listed("no coordinate", locked))
    if fixed:
        yield Skipped("fixed bodies", _listed("merged with what carries them", fixed))


def _other_scenes(scene: Scene) -> Iterator[tuple[str, str, Scene]]:
    """Return the scenes without a simplification that this one has: its name, what it is, the other scene."""
    if all(component.is_zero for component in scene.gravity):
        yield "no gravity", "against gravity in a general direction", scene.with_gravity(SLANTING)
    bound = [parameter.name for parameter in scene.parameters if parameter.value is not None]
    if bound:
        free = tuple(replace(parameter, value=None) for parameter in scene.parameters)
        yield "bound parameters", _listed("folded into constants", bound), replace(scene, parameters=free)
    massless = [body.name for body in scene.bodies if _is_massless(body)]
    if massless:
        heavy = tuple(_filled(replace(body, mass=ODD)) if _is_massless(body) else body for body in scene.bodies)
        yield "massless bodies", _listed("no momentum", massless), replace(scene, bodies=heavy)
    for group in angle_groups(scene, Graph()):
        names = [str(atom.value) for atom in group.atoms]
        step = "planar scene" if len(names) == len(scene.coordinates) else "parallel axes"
        yield step, _listed("no turn from one to the other but about themselves", names), _tilted(scene, names[1:])
    full = tuple(_filled(body) for body in scene.bodies)
    zeros = [body.name for body, other in zip(scene.bodies, full, strict=True) if body != other]
    if zeros:
        why = _listed("zero entries in inertia or centre of mass", zeros)
        yield "symmetric inertias", why, replace(scene, bodies=full)


def _tilted(scene: Scene, coordinates: Sequence[str]) -> Scene:
    """Return the scene with the frames of some joints at odd angles to those before them."""
    joints = tuple(
        replace(joint, origin=Pose((*joint.origin.steps, *TILT))) if joint.coordinate in coordinates else joint
        for joint in scene.joints
    )
    return replace(scene, joints=joints)


def _filled(body: Body) -> Body:
    """Return a rigid body without zeros in inertia and centre of mass, which no symmetry makes equal to others."""
    if body.mass == Quantity.ZERO:
        return body
    odd = (Quantity.number(Fraction(k, 1009)) for k in (3, 5, 7, 11, 13, 17, 19, 23, 29))

    def fill(entries: tuple[Quantity, ...]) -> tuple[Quantity, ...]:
        return tuple(other if entry.is_zero else entry for entry, other in zip(entries, odd, strict=False))

    place = {key: fill(vector) for key in ("com", "first_moment") if (vector := getattr(body, key)) is not None}
    return replace(body, inertia=fill(body.inertia), **place)  # type: ignore[arg-type]


def _saved(on: Savings, other: Workspace, chosen: Mapping[str, str]) -> Savings | None:
    """Return what the scene takes less than another workspace by the same formulations, None without such equations."""
    try:
        functions = tuple(derive_one(other, request, formulation) for request, formulation in chosen.items())
        without = _counts(Equations(other.scene, other.graph, functions))
    except DerivationError:
        return None
    return _positive({function: without[function] - counts for function, counts in on.items()})


def _positive(savings: Savings) -> Savings:
    return {function: counts for function, counts in savings.items() if counts != Counts()}


def _counts(equations: Equations, passes: Sequence[str] = ()) -> Savings:
    """Return the state-dependent operations of every function."""
    return {routine.function.name: routine.state_counts for routine in lower(equations, passes).routines}


def _is_massless(body: Body) -> bool:
    return body.mass.is_zero and not body.particles and all(entry.is_zero for entry in body.inertia)


def _listed(what: str, names: Sequence[str]) -> str:
    shown = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
    return f"{what}: {shown}"
