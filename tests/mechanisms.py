"""Mechanisms that the tests run over: seeded random trees of all joints, oblique axes, odd placements, couplings."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction

from symdyn.graph import Op
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces.applied_forces import Damper, Friction, Spring
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Body, Joint, Load, Parameter, Place, Pose, folding
from symdyn.scene.values.body import Particle
from symdyn.scene.values.entry import compose
from symdyn.scene.values.joint import Coupling, Limits

AXES = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 1, 0), (1, 1, 0), (1, -2, 2), (3, 0, 4), (1, 2, 3)]
ANGLES = [0, Fraction(1, 6), Fraction(1, 3), Fraction(1, 4), Fraction(1, 2), Fraction(-2, 3), 1, Fraction(37, 180)]


def turn(multiple: Fraction | int) -> Quantity:
    """Return multiple·π."""
    return folding.mul(Quantity.number(multiple), Quantity.PI)


USUAL = Quantity.number(Fraction(3, 7))
"""What a number of a joint type is where a test gives it no value: not 0, at which a law may hold by chance."""


def shape(kind: str, **values: object) -> tuple[tuple[str, object], ...]:
    """Return what the keys of a joint type say: values that it takes; else 3/7 for numbers, defaults for the rest."""
    usual = {key.name: USUAL if isinstance(key.default, Quantity) else key.default for key in JOINTS[kind].keys}
    return tuple((name, values.get(name, default)) for name, default in usual.items())


def random_tree(seed: int, n: int = 5, free: bool = True) -> Scene:
    """Return a tree of n joints: revolute, prismatic and fixed, right, usual and odd angles, an angle parameter.

    Args:
        seed: the same seed, the same scene.
        n: number of joints; at least one moves.
        free: whether the parameters stay without values.
    """
    rng = random.Random(seed)

    def small() -> Quantity:
        return Quantity.number(Fraction(rng.randint(-9, 9), 10))

    bodies, joints = [], []
    for i in range(n):
        kind = "revolute" if i == 0 else rng.choice(["revolute", "revolute", "prismatic", "fixed"])
        steps = [(t, small()) for t in ("Tx", "Ty", "Tz")]
        steps += [(rng.choice(["Rx", "Ry", "Rz"]), turn(rng.choice(ANGLES))) for _ in range(2)]
        if i == 1:
            steps.append(("Rx", Quantity.symbol("beta")))
        if i == 2:
            steps.append(("Ry", Quantity.number(Fraction(3, 10))))
        axis = rng.choice(AXES)
        axis = axis if kind != "fixed" else AXES[0]
        joints.append(
            Joint(
                f"j{i}",
                kind,
                "ground" if i == 0 else f"b{rng.randint(max(0, i - 2), i - 1)}",
                f"b{i}",
                shape(kind, axis=tuple(Quantity.number(x) for x in axis)),
                compose(*steps),
                compose(("Tx", small()), ("Rz", turn(rng.choice(ANGLES)))) if rng.random() < 0.4 else Pose(),
                () if kind == "fixed" else (f"x{i}",),
                drives=() if kind == "fixed" else (None,),
            )
        )
        points = (Particle(Quantity.number(Fraction(1, 2)), (small(), small(), small())),) if rng.random() < 0.3 else ()
        xx, yy = Fraction(rng.randint(10, 20), 10), Fraction(rng.randint(10, 20), 10)
        products = (small().value / 3, small().value / 4, Fraction(1, 9))
        inertia = tuple(Quantity.number(x) for x in (xx, yy, Fraction(3, 2), *products))
        mass = Quantity.symbol("m0") if i == 0 else Quantity.number(Fraction(rng.randint(1, 30), 10))
        bodies.append(Body(f"b{i}", mass, (small(), small(), small()), None, inertia, "com", points, True))
    parameters = (
        Parameter("m0", None if free else Quantity.number(Fraction(7, 5)), positive=True),
        Parameter("beta", None if free else Quantity.number(Fraction(4, 5))),
    )
    gravity = (Quantity.number(0), Quantity.number(Fraction(1, 2)), Quantity.number(Fraction("-9.81")))
    return Scene(f"random{seed}", parameters, gravity, tuple(bodies), tuple(joints))


def whole_tree(seed: int) -> Scene:
    """Return a tree of 2 to 5 joints along x, y and z whose numbers are 0, 1 and 2: ratios are 1 by chance."""
    rng = random.Random(seed)

    def three() -> tuple[Quantity, ...]:
        return tuple(Quantity.number(rng.choice([0, 0, 1, -1, 2])) for _ in range(3))

    bodies, joints = [], []
    for i in range(rng.randint(2, 5)):
        kind, parent = rng.choice(["revolute", "prismatic"]), f"b{rng.randint(max(0, i - 2), i - 1)}" if i else "ground"
        axis = rng.choice([(0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, -1)])
        place = compose(*zip(("Tx", "Ty", "Tz"), three(), strict=True))
        moves = shape(kind, axis=tuple(Quantity.number(x) for x in axis))
        joints.append(Joint(f"j{i}", kind, parent, f"b{i}", moves, place, Pose(), (f"x{i}",), drives=(None,)))
        inertia = tuple(Quantity.number(x) for x in (4, 5, 4, 0, *(rng.choice([0, 1, -1]) for _ in range(2))))
        bodies.append(Body(f"b{i}", Quantity.number(rng.choice([1, 2])), three(), None, inertia, "com", (), True))
    return Scene(
        f"whole{seed}", (), (Quantity.number(0), Quantity.number(0), Quantity.number(-9)), tuple(bodies), tuple(joints)
    )


RATIOS = [1, -1, 2, Fraction(1, 2), Fraction(-3, 2), 3]
OFFSETS = [Quantity.number(0), turn(Fraction(1, 4)), turn(Fraction(-1, 3)), Quantity.number(Fraction(1, 5))]


def coupled_tree(seed: int, n: int = 5) -> Scene:
    """Return a tree of which some joints follow others, with rotors and dampers; at least one does.

    A joint follows one that comes earlier or later; a sliding joint may do so by the ratio of a parameter.
    """
    rng = random.Random(seed)
    tree = random_tree(seed, n)
    moving = [k for k, joint in enumerate(tree.joints) if joint.moves]
    if len(moving) < 2:
        return coupled_tree(seed + 1000, n)
    followers = rng.sample(moving, rng.randint(1, len(moving) - 1))
    leaders = [tree.joints[k].coordinate for k in moving if k not in followers]
    joints = list(tree.joints)
    for k in moving:
        joints[k] = replace(joints[k], armature=tenths(rng), damping=tenths(rng), friction=tenths(rng))
    for k in followers:
        ratio = Quantity.symbol("rho") if joints[k].type == "prismatic" else Quantity.number(rng.choice(RATIOS))
        coupling = Coupling(((rng.choice(leaders), ratio),), rng.choice(OFFSETS))
        joints[k] = replace(joints[k], coordinates=(), drives=(), coupling=coupling)
    rotor = min(k for k in moving if k not in followers)
    joints[rotor] = replace(
        joints[rotor],
        armature=Quantity.symbol("Ia"),
        limits=Limits(tenths(rng), Quantity.number(3), None, Quantity.number(9)),
    )
    parameters = (*tree.parameters, Parameter("rho"), Parameter("Ia", positive=True))
    return replace(tree, name=f"coupled{seed}", joints=tuple(joints), parameters=parameters)


def tenths(rng: random.Random) -> Quantity:
    """Return 0.1 ... 0.9, or zero."""
    return Quantity.number(Fraction(max(0, rng.randint(-3, 9)), 10))


def jointed(*types: str, seed: int = 1, orientation: str = "quaternion") -> Scene:
    """Return a chain of joints of the given types, oblique axes and odd placements, full inertias.

    A custom joint slides and turns by formulas in two coordinates.
    """
    rng = random.Random(seed)
    joints, bodies, count = [], [], 0
    for i, kind in enumerate(types):
        p, r = Quantity.symbol(f"x{count}"), Quantity.symbol(f"x{count + 1}")
        values = {
            "axis": tuple(Quantity.number(x) for x in rng.choice(AXES)),
            "second_axis": tuple(Quantity.number(x) for x in (2, 1, -2)),
            "pitch": Quantity.number(Fraction(1, 5)),
            "length": Quantity.symbol("L"),
            "orientation": orientation,
            "steps": Pose((("Tz", p * p * r), ("Rx", p + r * Quantity.number(2)), ("Ty", Quantity(Op.SIN, (r,))))),
            "units": ("rad", "rad"),
        }
        for key in JOINTS[kind].keys:
            known = key.name in values or isinstance(key.default, Quantity)
            assert known, f"`jointed` has no value for the key {key.name} of {kind}; add one in tests/mechanisms.py"
        own = shape(kind, **values)
        joint = Joint(
            f"j{i}",
            kind,
            "ground" if i == 0 else f"b{i - 1}",
            f"b{i}",
            own,
            compose(("Tx", tenths(rng)), ("Ry", turn(rng.choice(ANGLES)))),
            compose(("Ty", tenths(rng)), ("Rx", Quantity.number(Fraction(3, 10)))),
            (f"x{count}", f"x{count + 1}"),
        )
        names = tuple(f"x{count + k}" for k in range(len(JOINTS[kind].coordinates(joint))))
        joints.append(replace(joint, coordinates=names, velocities=quasi_velocities(joint, count)))
        count += len(names)
        com = (tenths(rng), Quantity.number(Fraction(-1, 3)), tenths(rng))
        inertia = tuple(Quantity.number(Fraction(x)) for x in ("3/2", "7/5", "8/5", "1/9", "-1/8", "1/7"))
        bodies.append(Body(f"b{i}", Quantity.number(rng.randint(1, 3)), com, None, inertia, "com", (), True))
    parameters = (Parameter("L", Quantity.number(Fraction(6, 5))),)
    return Scene("_".join(types), parameters, bodies=tuple(bodies), joints=tuple(joints))


def quasi_velocities(joint: Joint, first: int) -> tuple[str, ...]:
    """Return the names of a joint's velocities where some are no rates of its coordinates x<first>, …; else ()."""
    names: list[str] = []
    for block in JOINTS[joint.type].blocks(joint):
        names += [f"{joint.name}_{letter}" for letter in block.letters] or [
            f"x{first + k}_dot" for k in range(len(block.velocities))
        ]
        first += len(block.coordinates)
    return tuple(names) if any(not name.endswith("_dot") for name in names) else ()


def with_loads(tree: Scene, seed: int) -> Scene:
    """Return a tree with a spring and a damper at joints, others between points, dry friction, and two loads.

    Forces depend on time, velocities and parameters; springs and dampers are not linear.
    """
    rng = random.Random(seed)
    names = ["ground", *(body.name for body in tree.bodies)]
    moving = [joint.name for joint in tree.joints if joint.moves and len(joint.rates) <= 1]

    def small() -> Quantity:
        return Quantity.number(Fraction(rng.randint(-9, 9), 10))

    def place(body: str) -> Place:
        return Place(body, (small(), small(), small()))

    def ends() -> tuple[Place, Place]:
        first, second = rng.sample(names, 2)
        return place(first), place(second)

    k, c, f, t = Quantity.symbol("k1"), Quantity.symbol("c1"), Quantity.symbol("f1"), Quantity.symbol("t")
    springs = [Spring("far", "", ends(), (k, Quantity.number(2)), free=Quantity.symbol("l0"), preload=small())]
    dampers = [Damper("far", "", ends(), (c, Quantity.number(3)))]
    if moving:
        springs.append(Spring("near", rng.choice(moving), (), (k, Quantity.number(2)), free=small(), preload=small()))
        dampers.append(Damper("near", rng.choice(moving), (), (c, Quantity.number(2))))
    joints = list(tree.joints)
    for i, joint in enumerate(joints):
        if joint.moves and rng.random() < 0.6:
            joints[i] = replace(
                joint,
                dry=Friction(
                    joint.name,
                    Quantity.number(1),
                    Quantity.number(2),
                    Quantity.number(3),
                    tenths(rng) + Quantity.number(1),
                ),
            )
    u, v = Quantity.symbol(tree.velocities[0]), Quantity.symbol(tree.velocities[-1])
    loads = (
        Load("tool", place(names[-1]), (u, t, small()), (small(), f, v), "body"),
        Load("wind", place(rng.choice(names[1:])), (small(), t, f * u), (small(), f, small()), "ground"),
    )
    parameters = (*tree.parameters, *(Parameter(name) for name in ("k1", "l0", "c1", "f1")))
    return replace(
        tree,
        name=f"{tree.name}_loaded",
        parameters=parameters,
        joints=tuple(joints),
        elements=(*springs, *dampers, *loads),
    )


TREES = [random_tree(seed, 5 if seed < 4 else 4) for seed in range(8)]
COUPLED = [coupled_tree(seed, 5 if seed < 2 else 4) for seed in range(5)]
"""What most laws run over; equal scenes share what is derived of them (`running.workspace`)."""
