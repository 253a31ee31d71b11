"""Mechanisms that the tests run over: seeded random trees with every joint type, oblique axes and odd placements."""

from __future__ import annotations

import random
from fractions import Fraction

from symdyn.graph import Op
from symdyn.scene import Body, Joint, Parameter, Particle, Pose, Quantity, Scene, number, symbol
from symdyn.scene.quantity import PI

AXES = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 1, 0), (1, 1, 0), (1, -2, 2), (3, 0, 4), (1, 2, 3)]
ANGLES = [0, Fraction(1, 6), Fraction(1, 3), Fraction(1, 4), Fraction(1, 2), Fraction(-2, 3), 1, Fraction(37, 180)]


def turn(multiple: Fraction | int) -> Quantity:
    """Return multiple·π."""
    return Quantity(Op.MUL, (number(multiple), PI))


def random_tree(seed: int, n: int = 5, free: bool = True) -> Scene:
    """Return a tree of n joints: revolute, prismatic and fixed, right, usual and odd angles, an angle parameter.

    Args:
        seed: the same seed, the same scene.
        n: number of joints; at least one moves.
        free: whether the parameters stay without values.
    """
    rng = random.Random(seed)

    def small() -> Quantity:
        return number(Fraction(rng.randint(-9, 9), 10))

    bodies, joints = [], []
    for i in range(n):
        kind = "revolute" if i == 0 else rng.choice(["revolute", "revolute", "prismatic", "fixed"])
        steps = [(t, small()) for t in ("Tx", "Ty", "Tz")]
        steps += [(rng.choice(["Rx", "Ry", "Rz"]), turn(rng.choice(ANGLES))) for _ in range(2)]
        if i == 1:
            steps.append(("Rx", symbol("beta")))
        if i == 2:
            steps.append(("Ry", number(Fraction(3, 10))))
        axis = rng.choice(AXES)
        joints.append(
            Joint(
                f"j{i}",
                kind,
                "ground" if i == 0 else f"b{rng.randint(max(0, i - 2), i - 1)}",
                f"b{i}",
                tuple(number(x) for x in axis),
                Pose(tuple(steps)),
                Pose((("Tx", small()), ("Rz", turn(rng.choice(ANGLES))))) if rng.random() < 0.4 else Pose(),
                "" if kind == "fixed" else f"x{i}",
            )
        )
        points = (Particle(number(Fraction(1, 2)), (small(), small(), small())),) if rng.random() < 0.3 else ()
        xx, yy = Fraction(rng.randint(10, 20), 10), Fraction(rng.randint(10, 20), 10)
        products = (small().value / 3, small().value / 4, Fraction(1, 9))
        inertia = tuple(number(x) for x in (xx, yy, Fraction(3, 2), *products))
        mass = symbol("m0") if i == 0 else number(Fraction(rng.randint(1, 30), 10))
        bodies.append(Body(f"b{i}", mass, (small(), small(), small()), None, inertia, "com", points, True))
    parameters = (
        Parameter("m0", None if free else number(Fraction(7, 5)), positive=True),
        Parameter("beta", None if free else number(Fraction(4, 5))),
    )
    gravity = (number(0), number(Fraction(1, 2)), number(Fraction("-9.81")))
    return Scene(f"random{seed}", parameters, gravity, tuple(bodies), tuple(joints))
