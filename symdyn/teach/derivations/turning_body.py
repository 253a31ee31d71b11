"""Steps on a body that turns by a quaternion: what is conserved, spins about its axes, and how a top precesses.

    ṗ = p-rates less what the equations ask for, along each velocity; R p is the angular momentum in the ground frame

A symmetric body about a fixed point is looked at a second time, by Euler's angles from the vertical to its axis: two of
them are cyclic, and `precession` tells the rest. Of a body without moments each steady spin about an axis of inertia is
perturbed: λ² = D_ij D_ji/(I_i I_j), D the slopes of Euler's equations by the other two components.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import acos

from symdyn.algebra import Form, Ratios, Symbol
from symdyn.dynamics.mechanism import TIME
from symdyn.emit.print import latex_symbols
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, gradient, reachable, substitute, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.joints import start_of
from symdyn.scene.values import Body, Joint, Pose
from symdyn.spatial import Mat
from symdyn.teach.derivations.equation_steps import node_of
from symdyn.teach.derivations.precession import NO_FORM, lowest, precession_steps, shortened
from symdyn.teach.derivations.quaternion_steps import Turning
from symdyn.teach.derivations.reduced import reduced, zero
from symdyn.teach.document import Block, Formula, Letter, Name, Section, Step, Words
from symdyn.teach.lesson import AXES, Lesson, named, together
from symdyn.teach.shown_state import Chosen, choose_state

EULER = ("psi", "theta", "phi")
"""Precession, inclination, spin."""


def turning_sections(lesson: Turning, chosen: Chosen) -> list[Section]:
    """Return what is conserved, and steady motions, of a mechanism that no conditions tie."""
    found = {
        "after.conserved": _conserved(lesson),
        "after.steady": [*_spins(lesson, chosen), *_top(lesson, chosen)],
    }
    return [lesson.section(key, steps) for key, steps in found.items() if steps]


def _free(lesson: Turning, joint: Joint) -> range | None:
    """Return the numbers of the angular velocities of a joint on which no drive, load or friction acts."""
    first = lesson.first(joint) + len(joint.rates) - 3
    own = range(first, first + 3)
    return own if all(lesson.scene.drives[i] is None and lesson.acting[i].is_zero for i in own) else None


@dataclass(frozen=True)
class Kept:
    """What stays of the angular momentum of a joint: along axes of the ground, and of the body, by 0, 1, 2."""

    own: range  # numbers of the angular velocities
    ground: tuple[int, ...]
    body: tuple[int, ...]


def kept(lesson: Turning, joint: Joint) -> Kept | None:
    """Return what stays; None where a drive, a load or friction acts on the rotation."""
    own = _free(lesson, joint)
    if own is None:
        return None
    change = {i: lesson.p_rates[i] - lesson.needed[i] for i in own}
    e = tuple(lesson.graph.symbol(name) for name in joint.coordinates[-4:])
    ground = []
    for a, row in enumerate(Mat.of_quaternion(e) if joint.parent == Scene.GROUND else ()):
        turned = tangents(row, lesson.state.velocity)
        rate = [x * lesson.p[i] + y * change[i] for x, y, i in zip(turned, row, own, strict=True)]
        if zero(lesson, lesson.graph.total(rate)):
            ground.append(a)
    return Kept(own, tuple(ground), tuple(k for k, i in enumerate(own) if zero(lesson, change[i])))


def along_ground(joint: Joint, found: Kept, a: int) -> Form:
    """Return the angular momentum along an axis of the ground, by the rotation matrix and the momenta."""
    names = [Symbol(f"R:{joint.name},{a + 1}{b}") for b in (1, 2, 3)]
    return Form.sum(Form.product((x, Symbol(f"p:{i + 1}"))) for x, i in zip(names, found.own, strict=True))


def _conserved(lesson: Turning) -> list[Step]:
    """Return the momenta that stay, along axes of the ground and of the body, and the energy."""
    steps = list[Step]()
    for joint in lesson.balls:
        found = kept(lesson, joint)
        if found is None:
            continue
        whole = [along_ground(joint, found, a) for a in found.ground]
        if len(whole) == 3:
            claim = lesson.say("turning.whole", momenta=together(whole))
            steps.append(Step(f"kept:{joint.name}", claim, (), lesson.say("turning.whole.reason"), show=("momenta",)))
        elif whole:
            axis = AXES[found.ground[0]]
            claim = lesson.say("turning.along", axis=axis, momentum=whole[0])
            reason = lesson.say("turning.along.reason", axis=axis)
            steps.append(Step(f"kept:{joint.name}", claim, (), reason, show=("momenta",)))
        for k in found.body:
            i = found.own[k]
            rate = Symbol(lesson.scene.velocities[i])
            claim = lesson.say("turning.own", axis=AXES[k], momentum=Symbol(f"p:{i + 1}"), rate=rate)
            steps.append(Step(f"kept:{i + 1}", claim, (), lesson.say("turning.own.reason", axis=AXES[k])))
    timed = lesson.graph.symbol(TIME) in reachable([lesson.L, *lesson.acting])
    if not timed and all(x.is_zero for x in lesson.acting):
        total = Form.sum((Symbol("K:"), Symbol("P:")))
        steps.append(Step("energy", lesson.say("energy.kept", total=total), (), show=("energies",)))
    return steps


# A body without moments


def _spins(lesson: Turning, chosen: Chosen) -> list[Step]:
    """Return which spins about axes of inertia are stable, of every body that nothing turns."""
    steps = list[Step]()
    for joint in lesson.balls:
        own = _free(lesson, joint)
        if own is None or any(not x.is_zero for i in own for x in (lesson.weights[i], lesson.springs[i])):
            continue
        rows = [_spin(lesson, own, k, chosen) for k in range(3)]
        shown = [row for row in rows if row is not None]
        if len(shown) == 3:
            table = lesson.table(("turning.axis", "turning.square", "table.kind"), shown)
            claim = lesson.say("turning.spins", joint=joint.name)
            steps.append(Step(f"spins:{joint.name}", claim, (table,), lesson.say("turning.spins.reason")))
    return steps


def _spin(lesson: Turning, own: range, k: int, chosen: Chosen) -> tuple[str, Form, Words] | None:
    """Return an axis, λ²/ω² of a spin about it, and the verdict; None where it is no steady motion by itself."""
    names, (i, j) = lesson.names, (x for x in own if x != own[k])

    def key(kind: str, row: int, *columns: int) -> str:
        return f"{kind}:{row + 1},{','.join(str(x + 1) for x in sorted(columns))}"

    others = [key("k_z", row, x) for row in (i, j) for x in range(lesson.state.n) if x != row]
    others += [x for row in (i, j) for x in (key("k_D", row, own[k]), key("k_C", row, row, own[k]))]
    if any(x in names for x in others):
        return None
    slopes = [names.get(key("k_C", row, x, own[k])) for row, x in ((i, j), (j, i))]
    a, b = (lesson.graph.zero if x is None or x.node is None else x.node for x in slopes)
    try:
        square = a * b / (node_of(lesson, key("k_z", i, i)) * node_of(lesson, key("k_z", j, j)))
        form = Ratios.form_of(lesson.shape(square).express(lesson.graph))
    except NO_FORM:
        return None
    (value,) = chosen.of(square)
    kind = "stable" if value < 0 else "unstable" if value > 0 else "undecided"
    return AXES[k], form, lesson.say(f"equilibria.{kind}")


# A symmetric top


def _top(lesson: Turning, chosen: Chosen) -> list[Step]:
    """Return how a symmetric body about a fixed point precesses, by Euler's angles; none of other mechanisms."""
    scene = lesson.scene
    if len(scene.bodies) != 1 or scene.elements or [joint.type for joint in scene.joints] != ["spherical"]:
        return []
    (joint,), (body,) = scene.joints, scene.bodies
    own, axis = _free(lesson, joint), _axis(body)
    if own is None or axis is None or {joint.origin, joint.tip} != {Pose()} or joint.armature != Quantity.ZERO:
        return []
    falls = [k for k, x in enumerate(scene.gravity) if x != Quantity.ZERO]
    up = falls[0] if falls else axis
    if len(falls) > 1:
        return []
    twin = _by_angles(lesson, joint, body, axis, up)
    left = reduced(twin, choose_state(twin.scene, twin.state, twin.graph))
    if left is None or len(left.cyclic) != 2:
        return []
    psi, theta, phi = twin.state.q
    spin = lesson.graph.symbol(lesson.scene.velocities[own[axis]])
    A, C = (gradient(p, [u])[0] for p, u in zip(twin.momenta[1:], twin.state.qd[1:], strict=True))
    turn = lesson.graph.cos(theta)
    momentum = lowest(A) * lesson.graph.sin(theta) ** 2 * twin.state.qd[0] + lowest(C) * spin * turn
    lesson.name("p:euler", "p", "psi", node=momentum)
    lesson.names["spin:3"] = Name(Letter(latex_symbols(scene)[str(spin.value)]), spin)
    places: dict[str, str | Form] = {
        "up": AXES[up], "axis": AXES[axis], "psi": named(psi), "theta": named(theta), "phi": named(phi),
        "cosine": Form.of(turn), "entry": Symbol(f"R:{joint.name},{up + 1}{axis + 1}"),
    }  # fmt: skip
    blocks: list[Block] = [
        lesson.say("turning.angles", **places),
        Formula("", named(spin), right=shortened(twin, twin.state.qd[2] + twin.state.qd[0] * turn)),
        Formula("p:euler", shortened(twin, momentum)),
        _start(lesson, node_of(lesson, f"R:{joint.name},{up + 1}{axis + 1}"), own[axis], named(theta), chosen),
    ]
    claim = lesson.say("turning.top", axis=AXES[axis])
    first = Step("euler", claim, tuple(blocks), lesson.say("turning.top.reason", momentum=Symbol("p:euler")))
    momenta = {0: Symbol("p:euler"), 2: Symbol(f"p:{own[axis] + 1}")}
    return [first, *precession_steps(left, momenta, {2: chosen.of(spin)[0]})]


def _start(lesson: Turning, entry: Expr, spin: int, theta: Symbol, chosen: Chosen) -> Words:
    """Return at which inclination the scene starts, whose cosine is an entry of the rotation matrix, and the spin."""
    start = start_of(lesson.scene)
    position = [x.express(lesson.graph) for x in start.position]
    (there,) = substitute([entry], dict(zip(lesson.state.q, position, strict=True)))
    cosine, rate = chosen.of(there, start.velocity[spin].express(lesson.graph))
    angle = lesson.equals(acos(max(-1.0, min(1.0, cosine))))
    symbol = Symbol(lesson.scene.velocities[spin])
    return lesson.say("turning.start", theta=theta, angle=angle, spin=symbol, rate=lesson.equals(rate))


def _axis(body: Body) -> int | None:
    """Return the axis about which a body is symmetric, its centre of mass on it; None for none."""
    if body.particles or any(x != Quantity.ZERO for x in body.inertia[3:]):
        return None
    centre = body.first_moment or body.com or ()
    for k in range(3):
        i, j = (n for n in range(3) if n != k)
        if body.inertia[i] == body.inertia[j] and all(centre[n] == Quantity.ZERO for n in (i, j)):
            return k
    return None


def _by_angles(lesson: Turning, joint: Joint, body: Body, axis: int, up: int) -> Lesson:
    """Return the mechanism by Euler's angles on the same graph, the body's axes called so that `axis` is `up`."""

    def called(entries: Sequence[Quantity]) -> tuple[Quantity, Quantity, Quantity]:
        x, y, z = (entries[(k + axis - up) % 3] for k in range(3))
        return x, y, z

    letter, other = AXES[up], AXES[(up + 1) % 3]
    names = tuple(f"euler:{one}" for one in EULER)
    angles = replace(
        joint.shaped(orientation=f"{letter}{other}{letter}"),
        coordinates=names,
        velocities=(),
        start=(),
        start_rates=(),
    )
    com, first = (None if x is None else called(x) for x in (body.com, body.first_moment))
    turned = replace(body, com=com, first_moment=first, inertia=(*called(body.inertia[:3]), *body.inertia[3:]))
    taken = set(latex_symbols(lesson.scene).values())
    for name, one in zip(names, EULER, strict=True):
        index = ("e",) if f"\\{one}" in taken else ()
        lesson.names[name] = Name(Letter(one, index))
        lesson.names[f"{name}_dot"] = Name(Letter(one, index, dots=1))
    scene = replace(lesson.scene, bodies=(turned,), joints=(angles,), points=(), outputs=())
    return Lesson(scene, lesson.language, lesson.names, graph=lesson.graph)
