"""Steps: matrices of direction cosines of neighbouring bodies in space, and angular velocities read from them.

C_pb holds the axes of body b as columns, in axes of its neighbour p towards the ground; vectors of b go to p by it.
From C_0b = C_0p C_pb and the skew matrix ω̃ = Cᵀ Ċ follows ω_b = C_pbᵀ ω_p + what joint b adds, all in body axes.
"""

from __future__ import annotations

from symdyn.algebra import Form, Symbol
from symdyn.dynamics.mechanism import joint_placement
from symdyn.emit.print import Letters
from symdyn.graph import Expr, tangents
from symdyn.scene import Scene
from symdyn.scene.values import Body, Joint
from symdyn.spatial import Vec
from symdyn.teach.document import Block, Fold, Letter, Matrix, Step
from symdyn.teach.lesson import Lesson
from symdyn.teach.masses import AXES, Mass

WIDEST = 3
"""Terms of an entry up to which a matrix stands open."""


def rotation_steps(lesson: Lesson, result: list[Mass]) -> list[Step]:
    """Return one step a body on the way to a body with inertia; none where all turn about one direction."""
    bodies = {mass.body.name: mass.body for mass in result if mass.spins}
    turning = [angular_velocity(lesson, body) for body in bodies.values()]
    axes = {tuple(lesson.vanishes(x) for x in w) for w in turning} - {(True,) * 3}
    if not any(sum(still) < 2 for still in axes) and len(axes) < 2:
        return []
    carrier = {joint.child: joint for joint in lesson.scene.joints}
    wanted: set[str] = set()
    for name in bodies:
        below = name
        while below != Scene.GROUND and below not in wanted:
            wanted.add(below)
            below = carrier[below].parent
    return [_rotation(lesson, joint) for joint in lesson.scene.joints if joint.child in wanted]


def number_of(scene: Scene, body: str) -> str:
    """Return the number of a body in print, "0" for the ground."""
    return "0" if body == Scene.GROUND else str(Letters.body_number([one.name for one in scene.bodies].index(body)))


def _rotation(lesson: Lesson, joint: Joint) -> Step:
    """Return C of one joint, and the product that leads to the ground."""
    here, there = number_of(lesson.scene, joint.parent), number_of(lesson.scene, joint.child)
    R = joint_placement(joint, lesson.graph).R
    left, names, entries = cosines(here, there), [], []
    lesson.called(left, Letter("C", (here + there,)))
    for a in range(3):
        for b in range(3):
            names.append(f"{left}:{AXES[a]}{AXES[b]}")
            lesson.called(names[-1], Letter("C", (here + there, AXES[a] + AXES[b])), R[a][b])
            entries.append(lesson.short(R[a][b]))
    matrix: Block = Matrix(left, tuple(entries), tuple(names), width=3)
    if max(len(entry.terms) for entry in entries) > WIDEST:
        matrix = Fold(lesson.say("rotation.fold", name=Symbol(left)), (matrix,))
    blocks = [matrix]
    if joint.parent != Scene.GROUND:
        first, whole = cosines("0", here), cosines("0", there)
        for key, of in ((first, here), (whole, there)):
            lesson.called(key, Letter("C", ("0" + of,)))
        product = Form.product((Symbol(first), Symbol(left)))
        blocks.append(lesson.say("rotation.product", body=joint.child, whole=Symbol(whole), product=product))
    claim = lesson.say("rotation", body=joint.child, parent=_called(lesson, joint.parent))
    return Step(f"rotation:{joint.child}", claim, tuple(blocks), lesson.once("rotation.reason", joint.child))


def cosines(here: str, there: str) -> str:
    """Return the key of C of two bodies by their numbers."""
    return f"C:{here},{there}"


def _called(lesson: Lesson, body: str) -> str:
    return lesson.text("rotation.ground") if body == Scene.GROUND else body


# Angular velocities


def angular_velocity(lesson: Lesson, body: Body) -> Vec:
    """Return ω in body axes from ω̃ = Cᵀ Ċ, C from the body to the ground."""
    R = lesson.placed[body.name].R
    dR = [tangents(row, lesson.state.velocity) for row in R]
    pairs = ((2, 1), (0, 2), (1, 0))
    x, y, z = (lesson.graph.total(R[k][a] * dR[k][b] for k in range(3)) for a, b in pairs)
    return x, y, z


def read_from(lesson: Lesson, body: Body, result: list[Mass]) -> list[Form] | None:
    """Return the three components of ω as they are read from C; None where no matrix is shown.

    From a neighbour p each is the sum over the column of C_pb times ω_p, and what the joint adds; of a joint with
    several turns on the ground it is an entry of Cᵀ Ċ.
    """
    joint = next(one for one in lesson.scene.joints if one.child == body.name)
    key = cosines(number_of(lesson.scene, joint.parent), number_of(lesson.scene, body.name))
    if key not in lesson.names:
        return None
    if joint.parent == Scene.GROUND:
        return _skew(lesson, key) if len(joint.coordinates) > 1 else None
    parent = next(one for one in lesson.scene.bodies if one.name == joint.parent)
    above, R = angular_velocity(lesson, parent), joint_placement(joint, lesson.graph).R
    tags = [mass.tag for mass in result if mass.body is parent and mass.spins]
    handed = R.T @ above
    components = []
    for a, own in enumerate(angular_velocity(lesson, body)):
        terms: list[Form] = []
        for k in range(3):
            if not lesson.vanishes(above[k]) and not lesson.vanishes(R[k][a]):
                rate: Form = Symbol(f"omega:{tags[0]}{AXES[k]}") if tags else lesson.short(above[k])
                terms.append(Form.product((lesson.short(R[k][a]), rate)))
        terms += lesson.short(own - handed[a]).terms
        components.append(Form.sum(terms))
    return components


def _skew(lesson: Lesson, key: str) -> list[Form]:
    """Return entries zy, xz, yx of Cᵀ Ċ, in names of the entries of C and their rates."""

    def entry(name: str) -> Expr:
        node = lesson.names[name].node
        assert node is not None, "an entry of C has a value"
        return node

    components = []
    for a, b in (("z", "y"), ("x", "z"), ("y", "x")):
        terms = []
        for k in AXES:
            (rate,) = tangents([entry(f"{key}:{k}{b}")], lesson.state.velocity)
            if lesson.vanishes(rate) or lesson.vanishes(entry(f"{key}:{k}{a}")):
                continue
            look = lesson.names[f"{key}:{k}{b}"].look
            assert isinstance(look, Letter), "an entry of C is called by a letter"
            moving = lesson.called(f"d{key}:{k}{b}", Letter("C", look.index, dots=1), rate)
            terms.append(Form.product((Symbol(f"{key}:{k}{a}"), moving)))
        components.append(Form.sum(terms))
    return components
