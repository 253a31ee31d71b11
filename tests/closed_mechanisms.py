"""Closed mechanisms that the tests run over: four-bars, a slider-crank, RSSR, Bricard, chains of four-bars."""

from __future__ import annotations

from fractions import Fraction

from mechanisms import shape

from symdyn.scene import Scene
from symdyn.scene.values import Body, Joint, Parameter, Pose
from symdyn.scene.values.body import Particle
from symdyn.scene.values.entry import compose
from symdyn.scene.values.quantity import Quantity, Vector

HINGE = shape("revolute")
HERE = Pose()
DOWN: Vector = (Quantity.ZERO, Quantity.number(Fraction("-9.81")), Quantity.ZERO)


def exact(value: str | int | Fraction) -> Quantity:
    return Quantity.number(Fraction(value))


def rod(name: str, length: Quantity, mass: Quantity) -> Body:
    """A slender rod along x from its joint."""
    third = Quantity.number(Fraction(1, 12)) * mass * length * length
    half = Quantity.number(Fraction(1, 2)) * length
    return Body(
        name,
        mass,
        (half, Quantity.ZERO, Quantity.ZERO),
        inertia=(Quantity.ZERO, third, third, Quantity.ZERO, Quantity.ZERO, Quantity.ZERO),
    )


def along_x(length: Quantity) -> Pose:
    return Pose((("Tx", length),))


def hinge(name: str, parent: str, child: str, at: Pose = HERE, drive: str | None = None, **more: object) -> Joint:
    return Joint(name, "revolute", parent, child, HINGE, at, coordinates=(f"q_{name}",), drives=(drive,), **more)  # type: ignore[arg-type]


def four_bar(
    a: Quantity,
    b: Quantity,
    c: Quantity,
    d: Quantity,
    masses: tuple[Quantity, Quantity, Quantity],
    start: tuple[str, str, str] | None = ("4/5", "1/7", "2"),
    parameters: tuple[Parameter, ...] = (),
    name: str = "four_bar",
) -> Scene:
    """Crank a, coupler b, rocker c of slender rods, ground d; the joint of coupler and rocker is cut."""
    angles = [()] * 3 if start is None else [(exact(x),) for x in start]
    return Scene(
        name,
        parameters,
        DOWN,
        (rod("crank", a, masses[0]), rod("coupler", b, masses[1]), rod("rocker", c, masses[2])),
        (
            hinge("A", "ground", "crank", drive="tau", start=angles[0]),
            hinge("B", "crank", "coupler", along_x(a), start=angles[1]),
            hinge("D", "ground", "rocker", along_x(d), start=angles[2]),
        ),
        loops=(
            Joint("C", "revolute", "coupler", "rocker", HINGE, along_x(b), Pose((("Tx", Quantity.number(-1) * c),))),
        ),
    )


def crank_rocker() -> Scene:
    lengths = [exact(x) for x in ("1", "3", "7/2", "4")]
    return four_bar(*lengths, (exact(1), exact(3), exact("7/2")))  # type: ignore[arg-type]


def symbolic_four_bar() -> Scene:
    names = ("a", "b", "c", "d", "m1", "m2", "m3")
    parameters = tuple(Parameter(name, positive=True) for name in names)
    a, b, c, d, m1, m2, m3 = (Quantity.symbol(name) for name in names)
    return four_bar(a, b, c, d, (m1, m2, m3), None, parameters, "symbolic_four_bar")


def slider_crank() -> Scene:
    """Crank 1, coupler 3, a slider along x; the joint of coupler and slider is cut."""
    return Scene(
        "slider_crank",
        (),
        DOWN,
        (rod("crank", Quantity.ONE, Quantity.ONE), rod("coupler", exact(3), exact(2)), Body("slider", exact("3/2"))),
        (
            hinge("A", "ground", "crank", drive="tau", start=(exact("1/2"),)),
            hinge("B", "crank", "coupler", along_x(Quantity.ONE), start=(exact("-2/3"),)),
            Joint(
                "P", "prismatic", "ground", "slider",
                shape("prismatic", axis=(Quantity.ONE, Quantity.ZERO, Quantity.ZERO)),
                coordinates=("x",), drives=(None,), start=(exact("19/5"),),
            ),
        ),
        loops=(Joint("C", "revolute", "coupler", "slider", HINGE, along_x(exact(3))),),
    )  # fmt: skip


def n_four_bar(n: int) -> Scene:
    """N four-bars in a row, all bars 1 m and 1 kg, cranks a metre apart (IFToMM benchmark A02)."""
    upright = (Quantity.number(Fraction("1.5707963267948966")),)
    level = (Quantity.number(Fraction("-1.5707963267948966")),)
    bodies, joints, loops = (
        [rod("crank0", Quantity.ONE, Quantity.ONE)],
        [hinge("A0", "ground", "crank0", start=upright)],
        [],
    )
    for k in range(1, n + 1):
        bodies += [rod(f"coupler{k}", Quantity.ONE, Quantity.ONE), rod(f"crank{k}", Quantity.ONE, Quantity.ONE)]
        joints += [
            hinge(f"B{k}", f"crank{k - 1}", f"coupler{k}", along_x(Quantity.ONE), start=level),
            hinge(f"A{k}", "ground", f"crank{k}", along_x(exact(k)), start=upright),
        ]
        loops.append(
            Joint(
                f"C{k}",
                "revolute",
                f"coupler{k}",
                f"crank{k}",
                HINGE,
                along_x(Quantity.ONE),
                Pose((("Tx", exact(-1)),)),
            )
        )
    return Scene(f"four_bars_{n}", (), DOWN, tuple(bodies), tuple(joints), loops=tuple(loops))


def rssr() -> Scene:
    """Crank about z, rocker about x, a coupler between balls: one freedom, and the coupler's idle spin."""
    slim = (exact("1/50"), Quantity.ONE, Quantity.ONE, Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)
    pin = Particle(Quantity.ONE, (Quantity.ZERO, exact("1/10"), Quantity.ZERO))
    return Scene(
        "rssr",
        (),
        (Quantity.ZERO, Quantity.ZERO, exact("-9.81")),
        (
            rod("crank", Quantity.ONE, Quantity.ONE),
            Body("coupler", exact(2), (exact("7/4"), Quantity.ZERO, Quantity.ZERO), inertia=slim, particles=(pin,)),
            rod("rocker", exact(2), Quantity.ONE),
        ),
        (
            hinge("A", "ground", "crank", drive="tau", start=(exact("1/3"),)),
            Joint(
                "B", "spherical", "crank", "coupler", origin=along_x(Quantity.ONE),
                coordinates=("e0", "e1", "e2", "e3"),
                velocities=("w1", "w2", "w3"), drives=(None,) * 3,
                start=(Quantity.ONE, Quantity.ZERO, exact("-1/5"), exact("1/5")),
            ),
            Joint(
                "D", "revolute", "ground", "rocker",
                shape("revolute", axis=(Quantity.ONE, Quantity.ZERO, Quantity.ZERO)),
                compose(("Tx", exact("5/2")), ("Ty", exact("3/2"))), tip=compose(("Rz", exact("1"))),
                coordinates=("q_D",), drives=(None,), start=(exact("1/2"),),
            ),
        ),
        loops=(
            Joint(
                "C", "spherical", "coupler", "rocker", shape("spherical"), along_x(exact("7/2")),
                Pose((("Tx", exact(-2)),)),
            ),
        ),
    )  # fmt: skip


def bricard() -> Scene:
    """Bricard's orthogonal linkage: six bars of unit length, six right twists, one freedom where (5.20) counts none."""

    quarter = Quantity.number(Fraction(1, 2)) * Quantity.PI
    step = [
        Pose((("Tx", Quantity.ONE), ("Rx", quarter if k % 2 == 0 else Quantity.number(-1) * quarter))) for k in range(6)
    ]
    guess = "1.5707963267948966"
    starts = [(exact(guess if k % 2 else "-" + guess),) for k in range(6)]
    bodies = tuple(rod(f"bar{k}", Quantity.ONE, Quantity.ONE) for k in range(5))
    joints = [hinge("J0", "ground", "bar0", start=starts[0], drive="tau")]
    joints += [hinge(f"J{k}", f"bar{k - 1}", f"bar{k}", step[k - 1], start=starts[k]) for k in range(1, 5)]
    loop = Joint("J5", "revolute", "bar4", "ground", HINGE, step[4], Pose(step[5].steps))
    return Scene("bricard", (), DOWN, bodies, tuple(joints), loops=(loop,))
