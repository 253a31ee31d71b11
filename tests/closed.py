"""Closed mechanisms for the tests of reactions: built from the nouns, so that no reader comes in between."""

from __future__ import annotations

from fractions import Fraction

from symdyn.scene import Body, Joint, Parameter, Quantity, Scene, number, symbol
from symdyn.scene.table import compose

Z = tuple(number(x) for x in (0, 0, 1))


def rod(name: str, length: Quantity, mass: Quantity) -> Body:
    """A uniform slender rod along x from the origin of its frame."""
    from symdyn.scene import folding

    middle = folding.mul(length, number(Fraction(1, 2)))
    across = folding.mul(mass, folding.mul(folding.mul(length, length), number(Fraction(1, 12))))
    zero = number(0)
    inertia = (zero, across, across, zero, zero, zero)
    return Body(name, mass, (middle, zero, zero), None, inertia, "com", (), True)


def four_bar(numbers: dict[str, str] | None = None) -> Scene:
    """Crank (driven), coupler and rocker of uniform rods in the plane of x and y; the rocker hangs on the ground.

    Args:
        numbers: values of a, b, c, d, m1, m2, m3; None leaves them parameters.
    """
    names = ("a", "b", "c", "d", "m1", "m2", "m3")
    value = {name: number(Fraction(numbers[name])) if numbers else symbol(name) for name in names}
    bodies = (
        rod("crank", value["a"], value["m1"]),
        rod("coupler", value["b"], value["m2"]),
        rod("rocker", value["c"], value["m3"]),
    )
    joints = (
        Joint("A", "revolute", "ground", "crank", coordinates=("q1",), drives=("M",)),
        Joint("B", "revolute", "crank", "coupler", origin=compose(("Tx", value["a"])), coordinates=("q2",)),
        Joint("D", "revolute", "ground", "rocker", origin=compose(("Tx", value["d"])), coordinates=("q3",)),
    )
    back = compose(("Tx", negative(value["c"])))
    loop = Joint("C", "revolute", "coupler", "rocker", origin=compose(("Tx", value["b"])), tip=back)
    gravity = (number(0), number(Fraction("-9.81")), number(0))
    parameters = () if numbers else tuple(Parameter(name, positive=True) for name in names)
    return Scene("four_bar", parameters, gravity, bodies, joints, loops=(loop,))


def negative(quantity: Quantity) -> Quantity:
    """Return -quantity."""
    from symdyn.scene import folding

    return folding.mul(number(-1), quantity)
