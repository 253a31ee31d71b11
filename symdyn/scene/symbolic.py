"""Names in place of numbers, for readable closed forms or for identification, and numbers in place of names.

    m<k>  mx<k> my<k> mz<k>  Ixx<k> ... Iyz<k>   the k-th body: mass, first moment, inertia about the body frame; the
                                                equations are linear in these ten
    x<k> y<k> z<k>                              its centre of mass, where something of the body is a formula already
    Ia<k>                                       armature of its joint
    a<k> b<k> d<k>                              shifts along x, y, z in the placement of its joint
    alpha<k> beta<k> gamma<k>                   turns about x, y, z there, but for right angles
    h<k> l<k>, L<k>                             pitch of a screw, length of a rod; length of the k-th rope
    fv<k>, fc<k> fs<k> vs<k> ve<k>, g           damping of its joint, its dry friction; gravity
    k<k> s<k> p<k>, c<k>                        the k-th spring: stiffness, free position, preload; the k-th damper
    Fx<k> ... Cz<k>, r<k>                       force and couple of the k-th load; radius of the wheel of the k-th row

The second shift along x in one placement is a<k>_2, those of the k-th point are a_p<k> and so on: _o of loops, _s<k>f
and _s<k>t of the ends of springs, _v of dampers, _w of loads, _r of rows, _c<k>_<i> of places of ropes, _e and _d of
elastic ones and their damping. All names take a suffix "_b" (twice if need be) when one of them is in use.

The equations of motion are linear in the ten inertial parameters of a body (Atkeson, An, Hollerbach 1986).

A parameter that is bound keeps its name and gets its value, which the program folds in. One whose value is zero is zero
at once in every formula, so that the derivations see what is gone: a massless body, a shift of no length, gravity. It
is no longer assumed to be positive then.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields, replace
from fractions import Fraction

from symdyn.arguments import argument, checked
from symdyn.errors import SceneError, suggestion
from symdyn.scene.declaration.draft import draft_of, slides
from symdyn.scene.declaration.reading import value_for
from symdyn.scene.declaration.whole_scene import check
from symdyn.scene.forces.force_table import FORCES, sections
from symdyn.scene.joints.joint_table import ARMATURE, DAMPING, JOINTS
from symdyn.scene.values.body import Body, Particle, Pose
from symdyn.scene.values.dimensional_analysis import ask_for_units
from symdyn.scene.values.entry import Faults, compose, show
from symdyn.scene.values.folding import add, map_quantities, mul, neg, substituted, vanishes
from symdyn.scene.values.joint import Element, Joint
from symdyn.scene.values.key import Key, Names
from symdyn.scene.values.letters import Parameter
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, Vector, spell

INERTIAL = (
    ("m", "kg", "mass"),
    ("mx", "kg m", "first moment along x"),
    ("my", "kg m", "first moment along y"),
    ("mz", "kg m", "first moment along z"),
    ("Ixx", "kg m^2", "inertia about the body frame, entry xx"),
    ("Iyy", "kg m^2", "inertia about the body frame, entry yy"),
    ("Izz", "kg m^2", "inertia about the body frame, entry zz"),
    ("Ixy", "kg m^2", "inertia about the body frame, entry xy"),
    ("Ixz", "kg m^2", "inertia about the body frame, entry xz"),
    ("Iyz", "kg m^2", "inertia about the body frame, entry yz"),
)

Ten = tuple[Quantity, ...]


@checked(SceneError)
def with_symbolic_inertia(scene: Scene, avoid: Collection[str] = ()) -> Scene:
    """Return the scene with mass, first moment and inertia of every body as free parameters; none in `avoid`.

    Parameters that nothing uses any longer go.
    """
    others = replace(scene, bodies=(), parameters=())
    used = {name for quantity in Quantity.inside(others) for name in quantity.symbols}
    kept = tuple(parameter for parameter in scene.parameters if parameter.name in used)
    taken = {parameter.name for parameter in kept} | scene.moving_names | set(avoid)
    suffix = ""
    while taken & {f"{kind}{k}{suffix}" for kind, _, _ in INERTIAL for k in range(1, len(scene.bodies) + 1)}:
        suffix += "_b"
    bodies, added = [], []
    for k, body in enumerate(scene.bodies, start=1):
        names = [f"{kind}{k}{suffix}" for kind, _, _ in INERTIAL]
        bodies.append(_open(body, names))
        added += [
            Parameter(name, positive=kind == "m", unit=unit, text=f"{text} of {body.name}")
            for name, (kind, unit, text) in zip(names, INERTIAL, strict=True)
        ]
    return replace(scene, bodies=tuple(bodies), parameters=kept + tuple(added))


def _open(body: Body, names: list[str]) -> Body:
    mass, x, y, z, xx, yy, zz, xy, xz, yz = (Quantity.symbol(name) for name in names)
    return Body(body.name, mass, None, (x, y, z), (xx, yy, zz, xy, xz, yz), "frame", shape=body.shape)


def named_body(body: Body, k: int, names: Names) -> Body:
    """Return the body with its numbers named: ten about its frame, or as they stand where some are formulas."""
    extended = (body.mass, *(body.com or ()), *(body.first_moment or ()), *body.inertia)
    if any(x.symbols for x in extended):
        return _as_it_stands(body, k, names)
    apart = tuple(p for p in body.particles if any(x.symbols for x in (p.mass, *p.at)))
    ten = _ten(body.mass, body.com, body.first_moment, body.inertia, body.about)
    for particle in body.particles:
        if particle not in apart:
            more = _ten(particle.mass, particle.at, None, (Quantity.ZERO,) * 6, "com")
            ten = tuple(add(a, b) for a, b in zip(ten, more, strict=True))
    if not any(x != Quantity.ZERO for x in ten):
        return body
    m, x, y, z, xx, yy, zz, xy, xz, yz = (
        names.of(entry, f"{kind}{k}", unit, f"{text} of {body.name}", kind == "m")
        for entry, (kind, unit, text) in zip(ten, INERTIAL, strict=True)
    )
    excused = body.allow_invalid_inertia
    return Body(body.name, m, None, (x, y, z), (xx, yy, zz, xy, xz, yz), "frame", apart, excused, body.shape)


def _as_it_stands(body: Body, k: int, names: Names) -> Body:
    """Return the body with a name for every number, its centre of mass at (x<k>, y<k>, z<k>)."""

    def mass(quantity: Quantity) -> Quantity:
        return names.of(quantity, f"m{k}", "kg", f"mass of {body.name}", True)

    def vector(quantities: Vector | None, kind: str, unit: str, what: str) -> Vector | None:
        if quantities is None:
            return None
        x, y, z = (
            names.of(quantity, f"{kind}{axis}{k}", unit, f"{what} along {axis} of {body.name}")
            for axis, quantity in zip("xyz", quantities, strict=True)
        )
        return (x, y, z)

    m = mass(body.mass)
    com = vector(body.com, "", "m", "centre of mass")
    first_moment = vector(body.first_moment, "m", "kg m", "first moment")
    about = "frame" if body.about == "frame" else "centre of mass"
    xx, yy, zz, xy, xz, yz = (
        names.of(entry, f"{kind}{k}", unit, f"{text.replace('body frame', about)} of {body.name}")
        for entry, (kind, unit, text) in zip(body.inertia, INERTIAL[4:], strict=True)
    )
    particles = tuple(Particle(mass(p.mass), vector(p.at, "", "m", "place") or NULL) for p in body.particles)
    return replace(
        body, mass=m, com=com, first_moment=first_moment, inertia=(xx, yy, zz, xy, xz, yz), particles=particles
    )  # fmt: skip


def _ten(mass: Quantity, com: Vector | None, first_moment: Vector | None, inertia: Ten, about: str) -> Ten:
    """Return mass, first moment and inertia about the frame: I + m (r·r 1 - r rᵀ) if `inertia` is about the com."""
    r = com or NULL
    h = tuple(mul(mass, x) for x in r) if first_moment is None else first_moment
    if about == "com":
        x, y, z = (mul(h[i], r[i]) for i in range(3))
        moved = [add(y, z), add(x, z), add(x, y)]
        moved += [neg(mul(h[i], r[j])) for i, j in ((0, 1), (0, 2), (1, 2))]
        inertia = tuple(add(entry, more) for entry, more in zip(inertia, moved, strict=True))
    return (mass, *h, *inertia)


KINDS = ("inertia", "geometry", "all")

STEPS = {"Tx": "a", "Ty": "b", "Tz": "d", "Rx": "alpha", "Ry": "beta", "Rz": "gamma"}

RIGHT_ANGLES = tuple(mul(Quantity.number(Fraction(k, 2)), Quantity.PI) for k in range(-8, 9))


@checked(SceneError)
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
    named: Joint = ARMATURE.named(joint, "forces", "", k, names, JOINTS[joint.type].slides(joint))
    return named


def _damper(joint: Joint, k: int, names: Names) -> Joint:
    slides = JOINTS[joint.type].slides(joint)
    joint, dry = DAMPING.named(joint, "forces", "", k, names, slides), joint.dry
    for key in FORCES[dry.kind].parts if dry else ():
        dry = key.named(dry, "forces", "", k, names, slides)
    return replace(joint, dry=dry)


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


@checked(SceneError)
def bind(scene: Scene, values: Mapping[str, object]) -> Scene:
    """Return the scene with values for some of its parameters, in place of values they may have.

    Args:
        scene: any scene.
        values: by name of the parameter: a number in SI, formula text without symbols, a value with its unit such as
            "400 mm", or a quantity.

    Raises:
        SceneError: an unknown parameter, no number, or a value that the scene cannot have; with every fault. Or what a
            value without a unit may mean, of a parameter that the scene has in another unit than that of SI.
    """
    ask_for_units(scene.parameters, values.items(), argument("values"))
    return with_values(scene, values)


def with_values(scene: Scene, values: Mapping[str, object]) -> Scene:
    """Return the scene of `bind`, which asks, at values that were asked for or computed."""
    faults = Faults(scene.source or scene.name)
    names = {parameter.name: parameter for parameter in scene.parameters}
    known: dict[str, Parameter] = {}
    for name, raw in values.items():
        if name not in names:
            told = scene.derived_words(name) or f'"{name}" is not a parameter; {suggestion(name, names)}'
            faults.add("", told)
            continue
        try:
            value, unit, written = value_for(names[name], raw)
        except FormulaError as error:
            reason = str(error)
            told = f"{show(raw)} {reason}" if reason.startswith("is in ") else reason
            faults.add(f"parameters.{name}", f"value {told}")
            continue
        known[name] = replace(names[name], value=value, unit=unit, written=written)
    faults.close()
    parameters = tuple(known.get(p.name, p) for p in scene.parameters)
    bound = without_zeros(replace(scene, parameters=parameters), faults)
    said = any(one.unit != names[name].unit for name, one in known.items())
    check(draft_of(bound), faults, dimensions=said)  # which no value changes but one that says a unit first
    faults.close()
    return bound


def without_zeros(scene: Scene, faults: Faults | None = None) -> Scene:
    """Return the scene with zero in every formula for the parameters that are zero; they cannot be bound again there.

    Raises:
        SceneError: a formula has no value then.
    """
    faults = faults or Faults(scene.source or scene.name)
    zeros = {p.name: Quantity.ZERO for p in scene.parameters if p.value and not p.value.symbols and p.value.is_zero}
    if not zeros:
        return scene
    parameters = tuple(replace(p, positive=p.positive and p.name not in zeros) for p in scene.parameters)
    try:
        return map_quantities(replace(scene, parameters=parameters), lambda one: substituted(one, zeros))
    except FormulaError as error:
        faults.add("", f"with {' = '.join(zeros)} = 0 a formula has no value: {_whose(scene, zeros)}{error}")
        faults.close()
        raise AssertionError("a fault closes") from error


def _whose(scene: Scene, values: Mapping[str, Quantity]) -> str:
    """Return which formula has no value with some values, and whose that is, as the beginning of a sentence."""
    lists = (getattr(scene, one.name) for one in fields(scene))
    for part in (one for found in lists if isinstance(found, tuple) for one in found if hasattr(one, "name")):
        for formula in Quantity.inside(part):
            try:
                substituted(formula, values)
            except FormulaError:
                return f"{spell(formula)} of {part.name}: "
    return ""


def without_hidden_zeros(scene: Scene) -> Scene:
    """Return the scene with zero in place of what is zero with its parameters' values, such as a mass a - b, too.

    For derivations, which see then what is gone; other values cannot be given to these parameters there any more.

    Raises:
        SceneError: a formula has no value with a parameter that is zero.
    """
    scene = without_zeros(scene)
    values = {p.name: p.value for p in scene.parameters if p.value and not p.value.symbols}

    def settled(one: Quantity) -> Quantity:
        """Return zero for a formula of parameters that is zero with their values."""
        known = one.symbols and set(one.symbols) <= values.keys()
        return Quantity.ZERO if known and vanishes(one, values) else one

    return map_quantities(scene, settled) if values else scene
