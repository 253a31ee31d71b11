"""Steps: what each coefficient means, from axes, levers and weights, and why products of rates are there or not.

    n, o    unit vector and a point of a joint's axis, ground frame
    a_i     lever: velocity of a place for q̇_i = 1, n × (r - o) for a turn, n for a slide

This computes the coefficients a second time. Nothing here differentiates an energy: k_z,ij = Σ m a_i·a_j + n_i·I n_j,
k_G,i = -Σ m g·a_i. Products and squares of rates have k_C and k_D.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Union

from symdyn.algebra import Form, Number, Symbol
from symdyn.dynamics.mechanism import vector
from symdyn.emit.print import Printable, text_of
from symdyn.frozen import dataclass
from symdyn.graph import Expr, gradient, tangents
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.joints import JOINTS, unit
from symdyn.scene.values import Joint
from symdyn.spatial import Vec, add, cross, dot, sub, zero_vector
from symdyn.teach.derivations.equation_steps import WIDEST, coefficient_key, node_of
from symdyn.teach.derivations.rotations import angular_velocity
from symdyn.teach.derivations.velocities import folded, length
from symdyn.teach.document import Block, Box, Fold, Formula, Name, Step, Words
from symdyn.teach.lesson import AXES, Lesson, Mass, named, together

Row = tuple[Symbol, Union[Form, Words], Words]

SHORT = 4
"""Terms of a coefficient that stands in a table."""


def rates_step(lesson: Lesson, page: Printable, kind: str, mass: list[Mass]) -> Step:
    """Return a table: each coefficient of a product of velocities, and why it is there; folded, why others are zero."""
    rows: tuple[list[Row], list[Row]] = [], []
    slides = [unit == "m" for unit in SceneUnits(lesson.scene).velocities]
    for c in page.coefficients:
        if c.kind == kind:
            short = length(c.form) <= SHORT and len(text_of(c.form)) <= WIDEST
            value = c.form if short else lesson.say("long.short", terms=str(length(c.form)))
            why = lesson.say(_why(lesson, c.indices, slides, kind, mass), **_places(lesson, c.indices))
            rows[c.vanishes].append((Symbol(coefficient_key(c)), value, why))
    there, zero = (lesson.table(("coefficient", "value", "why"), some) for some in rows)
    blocks: list[Block] = [there] if there.rows else []
    if zero.rows:
        names = together([name for name, *_ in rows[True]])
        blocks.append(Fold(lesson.say("meaning.zero", names=names), (zero,)))
    reference = lesson.reference(f"{kind}:1,1") if kind == "k_D" else ""
    if reference:
        node, rate = node_of(lesson, "k_D:1,1"), lesson.state.qd[0]
        lesson.name("k_D torque", "M", "D", "11", node=node * rate * rate)
        product = Form.product((Symbol("k_D:1,1"), named(rate).power(2)))
        said = lesson.say("meaning.k_D.torque", torque=Symbol("k_D torque"), axis=axis_of(lesson, 0))
        blocks += [said, Formula("k_D torque", product, lesson.number("k_D:1,1"), Number.ZERO)]
    claim, reason = lesson.say(f"meaning.{kind}"), lesson.say(f"meaning.{kind}.reason")
    return Step(f"meaning:{kind}", claim, tuple(blocks), reason, reference)


def _places(lesson: Lesson, indices: tuple[int, ...]) -> dict[str, str | Form | Words]:
    i, j, *rest = indices
    k = rest[0] if rest else j
    qd = list(map(named, lesson.state.qd))
    return {"i": str(i), "j": qd[j - 1], "k": qd[k - 1], "axis": str(j)}


def _why(lesson: Lesson, indices: tuple[int, ...], slides: list[bool], kind: str, result: list[Mass]) -> str:
    """Return the key of the sentence that says why a coefficient is there or not."""
    i, j, k = (indices[0] - 1, indices[1] - 1, indices[-1] - 1)
    along = ".slide" if slides[i] else ""
    u = lesson.state.qd
    if not lesson.vanishes(node_of(lesson, f"{kind}:{','.join(map(str, indices))}")):
        turned = [mass for mass in result if kind == "k_C" and _moves(lesson, mass, u[i])]
        return (
            "k_C.gyroscopic" if turned and not any(_travels(lesson, mass) for mass in turned) else f"{kind}.acts{along}"
        )
    if slides[j]:
        return f"{kind}.straight"
    if kind == "k_D" and i == j:
        return "k_D.own"
    moved = [mass for mass in result if all(_moves(lesson, mass, u[x]) for x in (i, j, k))]
    if not moved:
        return f"{kind}.apart"
    if not any(_accelerated(lesson, mass, j, k) for mass in moved):
        return f"{kind}.none"
    alone = all((mass.particle or slides[i]) and lesson.vanishes(_share(lesson, mass, i, j, k)) for mass in moved)
    return f"{kind}.{'meets' if alone else 'cancel'}{along}"


def _moves(lesson: Lesson, mass: Mass, rate: Expr) -> bool:
    """Tell whether a rate gives a mass a velocity."""
    kinetic = lesson.names.get(f"K:{mass.tag}")
    return kinetic is not None and not lesson.vanishes(gradient(_node(kinetic), [rate])[0])


def _travels(lesson: Lesson, mass: Mass) -> bool:
    """Tell whether the centre of a mass can move: what turns about it alone has gyroscopic moments only."""
    return any(not lesson.vanishes(x) for x in tangents((*mass.place, *(mass.h or ())), lesson.state.velocity))


def _accelerated(lesson: Lesson, mass: Mass, j: int, k: int) -> bool:
    """Tell whether both rates together accelerate a mass, or change the angular momentum of one that has inertia."""
    state = lesson.state
    felt = tangents(tangents((*mass.place, *(mass.h or ())), state.velocity), state.velocity)  # r̈ where q̈ = 0
    if mass.spins:
        w = angular_velocity(lesson, mass.body)
        x, y, z = tangents(w, state.velocity)
        felt += add(mass.inertia @ (x, y, z), cross(w, mass.inertia @ w))
    return not all(lesson.vanishes(_of_both(lesson, x, j, k)) for x in felt)


def _share(lesson: Lesson, mass: Mass, i: int, j: int, k: int) -> Expr:
    """Return what one mass adds to the coefficient of q̇_j q̇_k in equation i, by its own kinetic energy."""
    state, K = lesson.state, _node(lesson.names[f"K:{mass.tag}"])
    momentum, slope = gradient(K, [state.qd[i]])[0], gradient(K, [state.q[i]])[0]
    force = tangents([momentum], lesson.state.velocity)[0] - slope
    return _of_both(lesson, force, j, k)


def _of_both(lesson: Lesson, node: Expr, j: int, k: int) -> Expr:
    """Return the coefficient of q̇_j q̇_k, of a square twice that."""
    return gradient(gradient(node, [lesson.state.qd[j]])[0], [lesson.state.qd[k]])[0]


def _node(name: Name) -> Expr:
    assert name.node is not None, "an energy has a value"
    return name.node


def axis_of(lesson: Lesson, i: int) -> Symbol:
    """Return the letter of the axis of coordinate i, which prose speaks of: o_1, o_2."""
    return lesson.name(f"axis:{i + 1}", "o", str(i + 1), node=None)


@dataclass(frozen=True)
class Axis:
    """The axis of coordinate i: direction n and point o in the ground frame; whether it slides; the joint."""

    joint: Joint
    n: Vec
    o: Vec
    slides: bool

    def lever(self, place: Vec) -> Vec:
        """Return the velocity of a place for q̇ = 1."""
        return self.n if self.slides else cross(self.n, sub(place, self.o))


def axes_of(lesson: Lesson) -> list[Axis | None]:
    """Return the axis of every coordinate; None where it moves more than one simple joint."""
    graph = lesson.graph
    found: list[Axis | None] = []
    for joint in lesson.scene.moving:
        followed = lesson.scene.followed.intersection(joint.coordinates)
        kind = JOINTS[joint.type]
        axis = kind.axis(joint)
        if axis is None or followed:
            found += [None] * len(joint.coordinates)
            continue
        T = lesson.placed[joint.parent] @ joint.origin.transform(graph)
        found.append(Axis(joint, T.R @ unit(axis, graph), T.p, kind.slides(joint)))
    return found


def beyond(lesson: Lesson, joint: Joint, result: list[Mass]) -> list[Mass]:
    """Return the masses that a joint carries."""
    carrier = {j.child: j for j in lesson.scene.joints}

    def carried(body: str) -> bool:
        while body != Scene.GROUND:
            if carrier[body] is joint:
                return True
            body = carrier[body].parent
        return False

    return [mass for mass in result if carried(mass.body.name)]


def meaning_steps(lesson: Lesson, page: Printable, mass: list[Mass]) -> list[Step]:
    """Return what k_z, k_C, k_D, k_G mean."""
    axes = axes_of(lesson)
    steps: list[Step] = []
    for i, axis in enumerate(axes):
        if axis is not None:
            steps.append(_own_inertia(lesson, i, axis, mass))
    pairs = [(i, j) for i in range(len(axes)) for j in range(i + 1, len(axes))]
    for i, j in pairs:
        first, second = axes[i], axes[j]
        if first is None or second is None:
            continue
        key = f"k_z:{i + 1},{j + 1}"
        if lesson.vanishes(node_of(lesson, key)):
            way = "induced.none.slide" if first.slides else "induced.none"
            said = lesson.say(way, name=Symbol(key), rate=named(lesson.state.qdd[j]), joint=first.joint.name)
            steps.append(Step(f"meaning:{key}", said, ()))
        else:
            steps.append(_induced(lesson, (i, j), (first, second), mass))
    if len(axes) > 1:
        steps.append(rates_step(lesson, page, "k_D", mass))
        steps.append(rates_step(lesson, page, "k_C", mass))
    for i, axis in enumerate(axes):
        if axis is not None and not lesson.vanishes(node_of(lesson, f"k_G:{i + 1}")):
            steps.append(_weights(lesson, i, axis, mass))
    carriers = [joint.name for joint in lesson.scene.moving for _ in joint.coordinates]
    others = dict.fromkeys(name for name, axis in zip(carriers, axes, strict=True) if axis is None)
    return [*steps, *_others(lesson, page, [joint for joint in lesson.scene.moving if joint.name in others])]


def _others(lesson: Lesson, page: Printable, joints: Sequence[Joint]) -> Iterator[Step]:
    """Yield what is said of joints without an axis of their own, by what they are; of a driven train what it bears."""
    followed = [one for one in joints if lesson.scene.followed.intersection(one.coordinates)]
    alone = followed[0] if followed and lesson.state.n == 1 else None
    if alone is not None and JOINTS[alone.type].axis(alone) is not None:
        slide = ".slide" if JOINTS[alone.type].slides(alone) else ""
        said = lesson.say(f"meaning.reduced{slide}", inertia=Symbol("k_z:1,1"), q=named(lesson.state.q[0]))
        blocks: list[Block] = []
        if (drive := lesson.scene.drives[0]) and not lesson.vanishes(node_of(lesson, "k_G:1")):
            blocks = [lesson.say(f"meaning.holding{slide}", drive=Symbol(drive), value=lesson.forms.form("k_G", 0))]
        yield Step("meaning:reduced", said, tuple(blocks))
    written = [one for one in joints if JOINTS[one.type].forbids is None]
    kinds = {one.name: "followed" if one in followed else "written" if one in written else "several" for one in joints}
    for kind in dict.fromkeys(kinds.values()):
        some = ", ".join(name for name, of in kinds.items() if of == kind)
        said = lesson.say("meaning.others", what=lesson.say(f"meaning.{kind}"), joints=some)
        path = (lesson.say("meaning.path", joint=some),) if kind == "written" else ()
        yield Step(f"meaning:others:{kind}", said, path)


# k_z


def _own_inertia(lesson: Lesson, i: int, axis: Axis, result: list[Mass]) -> Step:
    """Return k_z,ii as the moment of inertia of everything beyond axis i, or the mass that a slide carries."""
    here, key, k_z = str(i + 1), f"J:{i + 1}", f"k_z:{i + 1},{i + 1}"
    carried = beyond(lesson, axis.joint, result)
    blocks: list[Block] = []
    terms: list[Form] = []
    node = lesson.graph.zero
    for mass in carried:
        share, part, shown = _inertia_about(lesson, axis, mass, here)
        node = node + share
        terms += part
        blocks += shown
    rotor = axis.joint.armature.express(lesson.graph)
    if not rotor.is_zero:
        node, terms = node + rotor, [*terms, lesson.short(rotor)]
    lesson.name(key, "m" if axis.slides else "I", here, node=node)
    number = lesson.number(f"J:{here}")
    in_names, written_out = Form.sum(terms), lesson.short(node)
    blocks.append(Formula(key, in_names, number))
    if in_names != written_out:
        blocks.append(folded(lesson, Formula(key, written_out)))
    blocks.append(_check(lesson, k_z, key))
    torque = f"Mz:{here},{here}"
    qdd = lesson.state.qdd[i]
    lesson.name(torque, "F" if axis.slides else "M", "z", here + here, node=node_of(lesson, k_z) * qdd)
    kind, along = "mass" if axis.slides else "inertia", axis_of(lesson, i)
    moved = lesson.say(f"{kind}.torque", rate=named(qdd), torque=Symbol(torque), axis=along)
    product = Form.product((Symbol(k_z), named(qdd)))
    blocks += [moved, Formula(torque, product, lesson.number(torque))]
    bodies = ", ".join(dict.fromkeys(mass.body.name for mass in carried))
    claim = lesson.say(f"{kind}", name=Symbol(k_z), joint=axis.joint.name, bodies=bodies, axis=along)
    reason, reference = lesson.once(f"{kind}.reason"), lesson.reference(k_z, f"J:{here}", torque)
    return Step(f"meaning:{k_z}", claim, tuple(blocks), reason, reference)


def _inertia_about(lesson: Lesson, axis: Axis, mass: Mass, here: str) -> tuple[Expr, list[Form], list[Block]]:
    """Return the moment of inertia of one mass about an axis, its printed terms, and the formulas that they need."""
    m = lesson.short(mass.m)
    if axis.slides:
        return mass.m, [m], []
    lever = axis.lever(mass.place)
    square, share = dot(lever, lever), lesson.graph.zero
    terms: list[Form] = []
    blocks: list[Block] = []
    if not mass.m.is_zero and not lesson.vanishes(square):
        key = f"r2:{mass.tag},{here}"
        symbol = lesson.name(key, "r", mass.tag, here, node=square, power=2)
        sides = _sides(lesson, axis, mass)
        short = lesson.short(square)
        blocks.append(folded(lesson, Formula(key, sides, "", short) if sides is not None else Formula(key, short)))
        share, terms = share + mass.m * square, [Form.product((m, symbol))]
    n = lesson.placed[mass.body.name].R.T @ axis.n
    spin = dot(n, mass.inertia @ n)
    if mass.h is not None:
        spin = spin + 2 * dot(cross(axis.n, mass.h), lever)
    if not lesson.vanishes(spin):
        key = f"I:{mass.tag},{here}"
        symbol = lesson.name(key, "I", mass.tag, here, node=spin)
        blocks.append(folded(lesson, Formula(key, lesson.short(spin))))
        share, terms = share + spin, [*terms, symbol]
    return share, terms, blocks


def _sides(lesson: Lesson, axis: Axis, mass: Mass) -> Form | None:
    """Return x² + y² in names where the axis is an axis of the ground frame through its origin; else None."""
    if not all(lesson.vanishes(x) for x in axis.o):
        return None
    along = [k for k in range(3) if not lesson.vanishes(axis.n[k])]
    if len(along) != 1:
        return None
    across = [k for k in range(3) if k != along[0] and not lesson.vanishes(mass.place[k])]
    return Form.sum(Symbol(f"{AXES[k]}:{mass.tag}").power(2) for k in across)


def _check(lesson: Lesson, a: str, b: str) -> Box:
    """Return the box that says that two values are one function, decided in the ring."""
    equal = lesson.vanishes(node_of(lesson, a) - node_of(lesson, b))
    assert equal, f"{a} and {b} differ: one of the two derivations is wrong"
    key = "check.again" if "check.equal" in lesson.told else "check.equal"
    lesson.told.add("check.equal")
    return Box("check", lesson.say("check.title"), (lesson.say(key, first=Symbol(a), second=Symbol(b)),))


def _induced(lesson: Lesson, at: tuple[int, int], axes: tuple[Axis, Axis], result: list[Mass]) -> Step:
    """Return k_z,ij as the torque that q̈_j induces in axis i, and its symmetry."""
    (i, j), (first, second) = at, axes
    here, there = str(i + 1), str(j + 1)
    k_z, twin = f"k_z:{here},{there}", f"k_z:{there},{here}"
    both = [mass for mass in beyond(lesson, first.joint, result) if mass in beyond(lesson, second.joint, result)]
    node, qdd = lesson.graph.zero, lesson.state.qdd[j]
    for mass in both:
        node = node + mass.m * dot(first.lever(mass.place), second.lever(mass.place)) + _coupled(lesson, axes, mass)
    key = f"D:{here},{there}"
    lesson.name(key, "N", here + there, node=node)
    torque, back = f"Mz:{here},{there}", f"Mz:{there},{here}"
    lesson.name(torque, "F" if first.slides else "M", "z", here + there, node=node_of(lesson, k_z) * qdd)
    other = lesson.state.qdd[i]
    lesson.name(back, "F" if second.slides else "M", "z", there + here, node=node_of(lesson, twin) * other)
    blocks: list[Block] = [
        _called(lesson, torque, i, qdd, first),
        Formula(torque, Form.product((Symbol(k_z), Symbol(str(qdd.value)))), lesson.number(torque)),
        lesson.say("induced.how", rate=Symbol(str(qdd.value))),
        folded(lesson, Formula(key, lesson.short(node))),
        _check(lesson, k_z, key),
    ]
    rest = node_of(lesson, k_z) - node_of(lesson, f"k_z:{there},{there}")
    parallel = not (first.slides or second.slides) and all(
        lesson.vanishes(a - b) for a, b in zip(first.n, second.n, strict=True)
    )
    if parallel and not lesson.vanishes(rest) and length(short := lesson.short(rest)) < length(lesson.short(node)):
        formula = Formula(
            k_z, Form.sum((Symbol(f"k_z:{there},{there}"), short)), lesson.number(f"split:{here},{there}")
        )
        blocks += [lesson.say("induced.split"), formula]
    blocks.append(_called(lesson, back, j, other, second))
    blocks.append(Formula(back, Form.product((Symbol(twin), Symbol(str(other.value)))), lesson.number(back)))
    blocks += [lesson.say("induced.twin"), Formula(twin, Symbol(k_z), lesson.number(twin))]
    claim = lesson.say("induced", name=Symbol(k_z), rate=Symbol(str(qdd.value)), joint=first.joint.name)
    reference = lesson.reference(torque, k_z, f"split:{here},{there}", back, twin)
    return Step(f"meaning:{k_z}", claim, tuple(blocks), lesson.once("induced.reason"), reference)


def _called(lesson: Lesson, torque: str, i: int, rate: Expr, axis: Axis) -> Words:
    """Return what the force or torque in axis i is called that another acceleration induces."""
    key = "induced.force" if axis.slides else "induced.torque"
    return lesson.say(key, torque=Symbol(torque), axis=axis_of(lesson, i), rate=named(rate))


def _coupled(lesson: Lesson, axes: tuple[Axis, Axis], mass: Mass) -> Expr:
    """Return n_i·I n_j and what a first moment about the body frame's origin adds."""
    graph, (first, second) = lesson.graph, axes
    R = lesson.placed[mass.body.name].R
    a, b = (zero_vector(graph) if axis.slides else axis.n for axis in axes)
    term = dot(R.T @ a, mass.inertia @ (R.T @ b))
    if mass.h is not None:
        term = term + dot(cross(a, mass.h), second.lever(mass.place)) + dot(cross(b, mass.h), first.lever(mass.place))
    return term


# k_G


def _weights(lesson: Lesson, i: int, axis: Axis, result: list[Mass]) -> Step:
    """Return k_G,i as what the drive holds at rest: minus the moment (or force along the slide) of all weights."""
    here, graph = str(i + 1), lesson.graph
    gravity = vector(lesson.scene.gravity, graph)
    carried = beyond(lesson, axis.joint, result)
    node = graph.zero
    for mass in carried:
        node = node - mass.m * dot(gravity, axis.lever(mass.place))
        if mass.h is not None and not axis.slides:
            node = node - dot(gravity, cross(axis.n, mass.h))
    key = f"MG:{here}"
    lesson.name(key, "F" if axis.slides else "M", "G", here, node=node)
    blocks: list[Block] = [folded(lesson, Formula(key, lesson.short(node))), _check(lesson, f"k_G:{here}", key)]
    claim = lesson.say("weights.slide" if axis.slides else "weights", name=Symbol(f"k_G:{here}"), joint=axis.joint.name)
    reason = lesson.once("weights.slide.reason" if axis.slides else "weights.reason", drive=here)
    return Step(f"meaning:k_G:{here}", claim, tuple(blocks), reason)
