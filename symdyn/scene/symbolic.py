"""Names in place of numbers: with the numbers as values, for readable closed forms, or open, for identification.

    m<k>  mx<k> my<k> mz<k>  Ixx<k> ... Iyz<k>   the k-th body: mass, first moment, inertia about the body frame; the
                                                equations are linear in these ten
    x<k> y<k> z<k>                              its centre of mass, where something of the body is a formula already
    Ia<k>                                       armature of its joint
    a<k> b<k> d<k>                              shifts along x, y, z in the placement of its joint
    alpha<k> beta<k> gamma<k>                   turns about x, y, z there, but for right angles
    h<k> l<k>                                   pitch of a screw, length of a rod
    fv<k>, fc<k> fs<k> vs<k> ve<k>, g           damping of its joint, its dry friction; gravity
    k<k> s<k> p<k>, c<k>                        the k-th spring: stiffness, free position, preload; the k-th damper
    Fx<k> ... Cz<k>, r<k>                       force and couple of the k-th load; radius of the wheel of the k-th row

The second shift along x in one placement is a<k>_2, those of the k-th point are a_p<k> and so on: _o of loops, _s<k>f
and _s<k>t of the ends of springs, _v of dampers, _w of loads, _r of rows. All names take a suffix "_b" (twice if need
be) when one of them is in use.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.scene.checks.draft import slides
from symdyn.scene.forces.force_table import FORCES, sections
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.ten_parameters import named_body, with_symbolic_inertia
from symdyn.scene.values.body import Pose
from symdyn.scene.values.element import Element
from symdyn.scene.values.folding import mul
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key
from symdyn.scene.values.made_names import Names
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import suggestion
from symdyn.scene.values.quantity import Quantity, Vector
from symdyn.scene.values.table import compose

KINDS = ("inertia", "geometry", "all")

STEPS = {"Tx": "a", "Ty": "b", "Tz": "d", "Rx": "alpha", "Ry": "beta", "Rz": "gamma"}

RIGHT_ANGLES = tuple(mul(Quantity.number(Fraction(k, 2)), Quantity.PI) for k in range(-8, 9))


def with_symbols(scene: Scene, what: str) -> Scene:
    """Return the scene with parameters in place of numbers, their values; generated code stays the same function.

    Zero stays zero, right angles stay right angles, and formulas in parameters stay as they are.

    Args:
        scene: any scene.
        what: "inertia" (of bodies and rotors), "geometry" (of placements), or "all" (and what acts: damping, springs,
            loads, gravity).

    Raises:
        SceneError: `what` is none of these.
    """
    check_arguments(with_symbols, locals(), SceneError)
    if what not in KINDS:
        raise SceneError(f'symbols for "{what}" are not known; {suggestion(what, KINDS)}')
    taken = {parameter.name for parameter in scene.parameters} | scene.moving_names
    suffix = ""
    while True:
        names = Names(suffix)
        named = _named(scene, what, names)
        if not taken & {parameter.name for parameter in names.added}:
            return replace(named, parameters=scene.parameters + tuple(names.added))
        suffix += "_b"


def with_force_parameters(scene: Scene) -> Scene:
    """Return the scene with parameters for all that driving forces are linear in, and what stands beside it.

    All ten of every body, zeros too; armatures, damping, dry friction and the numbers of springs, dampers and loads
    where they are declared as numbers. Parameters that nothing uses any longer go.
    """
    declared = {parameter.name for parameter in scene.parameters}
    opened = with_symbolic_inertia(scene, declared)
    taken = {parameter.name for parameter in opened.parameters} | declared | scene.moving_names
    suffix = ""
    while True:
        names = Names(suffix)
        joints = tuple(_damper(_rotor(joint, k, names), k, names) for k, joint in enumerate(opened.joints, start=1))
        named = replace(opened, joints=joints, elements=_elements(opened, "forces", names))
        if not taken & {parameter.name for parameter in names.added}:
            return replace(named, parameters=opened.parameters + tuple(names.added))
        suffix += "_b"


def _named(scene: Scene, what: str, names: Names) -> Scene:
    if what != "geometry":
        bodies = tuple(named_body(body, k, names) for k, body in enumerate(scene.bodies, start=1))
        joints = tuple(_rotor(joint, k, names) for k, joint in enumerate(scene.joints, start=1))
        scene = replace(scene, bodies=bodies, joints=joints)
    if what != "inertia":
        scene = _placed(scene, names)
    if what == "all":
        joints = tuple(_damper(joint, k, names) for k, joint in enumerate(scene.joints, start=1))
        elements = _elements(scene, "forces", names)
        scene = replace(scene, joints=joints, elements=elements, gravity=_gravity(scene.gravity, names))
    return scene


def _placed(scene: Scene, names: Names) -> Scene:
    """Return the scene with its lengths and angles named."""

    def joint(one: Joint, place: str) -> Joint:
        origin, tip = (_pose(pose, place, one.name, names) for pose in (one.origin, one.tip))
        placed = replace(one, origin=origin, tip=tip)
        for key in JOINTS[one.type].keys:
            placed = key.named(placed, "geometry", "", place, names)
        return placed

    return replace(
        scene,
        joints=tuple(joint(one, str(k)) for k, one in enumerate(scene.joints, start=1)),
        points=tuple(
            replace(one, at=_pose(one.at, f"_p{k}", one.name, names)) for k, one in enumerate(scene.points, start=1)
        ),
        loops=tuple(joint(one, f"_o{k}") for k, one in enumerate(scene.loops, start=1)),
        elements=_elements(scene, "geometry", names),
    )


def _elements(scene: Scene, what: str, names: Names) -> tuple[Element, ...]:
    """Return the elements with their places, or their forces, named; the k-th of a section has k in its names."""
    named, counts = [], dict.fromkeys(sections(), 0)
    for element in scene.elements:
        one, kind = element, FORCES[element.kind]
        counts[kind.section] += 1
        for part in sorted(kind.parts, key=lambda part: isinstance(part, Key)):  # places before numbers
            one = part.named(one, what, kind.letter, counts[kind.section], names, slides(scene, element))
        named.append(one)
    return tuple(named)


def _rotor(joint: Joint, k: int, names: Names) -> Joint:
    unit = "kg" if JOINTS[joint.type].slides(joint) else "kg m^2"
    return replace(joint, armature=names.of(joint.armature, f"Ia{k}", unit, f"rotor inertia at {joint.name}", True))


def _damper(joint: Joint, k: int, names: Names) -> Joint:
    slides = JOINTS[joint.type].slides(joint)
    unit = "N s/m" if slides else "N m s/rad"
    damping = names.of(joint.damping, f"fv{k}", unit, f"damping of {joint.name}", True)
    if joint.dry is None:
        return replace(joint, damping=damping)
    dry = joint.dry
    for key in FORCES[dry.kind].parts:
        dry = key.named(dry, "forces", "", k, names, slides)
    return replace(joint, damping=damping, dry=dry)


def _pose(pose: Pose, place: str, of: str, names: Names) -> Pose:
    steps = []
    for kind, amount in pose.steps:
        shift = kind.startswith("T")
        text = f"{'shift along' if shift else 'turn about'} {kind[1]} at {of}"
        exact = not shift and amount in RIGHT_ANGLES
        name = f"{STEPS[kind]}{place}"
        steps.append((kind, amount if exact else names.of(amount, name, "m" if shift else "rad", text, shift)))
    return compose(*steps)


def _gravity(gravity: Vector, names: Names) -> Vector:
    several = sum(component != Quantity.ZERO for component in gravity) > 1
    text, unit = "acceleration of free fall", "m/s^2"
    x, y, z = (
        names.of(component, f"g{axis}" if several else "g", unit, f"{text}, along {axis}" if several else text, True)
        for axis, component in zip("xyz", gravity, strict=True)
    )
    return (x, y, z)
