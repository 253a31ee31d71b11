"""The built-in scenes of the hard cases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from symdyn.scene import Quantity, Scene, body, damper, joint, loop, point, scene, spring
from symdyn.scene.values import Body

G = "9.81"


def two_link(first: Fraction | int = 1, second: Fraction | int = 1) -> Scene:
    """Return two point masses on massless links of 1 m; angles from the downward vertical and from link 1."""
    return scene(
        "two_link",
        gravity=[0, f"-{G}", 0],
        bodies=[body(f"b{k}", particles=[{"mass": m, "at": [0, -1, 0]}]) for k, m in enumerate((first, second), 1)],
        joints=[
            joint("j1", "revolute", "ground", "b1", coordinate="q1"),
            joint("j2", "revolute", "b1", "b2", origin=[0, -1, 0], coordinate="q2"),
        ],
        points=[point("tool", "b2", [("Ty", -1)])],
    )


def chain(n: int, absolute: bool = False) -> Scene:
    """Return n unit point masses on links of 1 m, with angles relative to the link before or to the vertical.

    An absolute angle is a joint that takes the angle before it back, then one that turns by its own.
    """
    bodies, joints = [], []
    for k in range(1, n + 1):
        parent, origin = ("ground", [0, 0, 0]) if k == 1 else (f"b{k - 1}", [0, -1, 0])
        if absolute and k > 1:
            bodies.append(body(f"a{k}"))
            joints.append(
                joint(
                    f"back{k}",
                    "revolute",
                    parent,
                    f"a{k}",
                    origin=origin,
                    mimic={"coordinate": f"q{k - 1}", "ratio": -1},
                )
            )
            parent, origin = f"a{k}", [0, 0, 0]
        bodies.append(body(f"b{k}", particles=[{"mass": 1, "at": [0, -1, 0]}]))
        joints.append(joint(f"j{k}", "revolute", parent, f"b{k}", origin=origin, coordinate=f"q{k}"))
    return scene(f"chain{n}{'_absolute' if absolute else ''}", gravity=[0, f"-{G}", 0], bodies=bodies, joints=joints)


def gimbal() -> Scene:
    """Return a rigid body with inertia diag(1, 2, 3) on three massless gimbals z, y, x, free of gravity."""
    return scene(
        "gimbal",
        bodies=[body("outer"), body("inner"), body("top", mass=1, com=[0, 0, 0], inertia=[1, 2, 3], about="com")],
        joints=[
            joint("yaw", "revolute", "ground", "outer", axis=[0, 0, 1], coordinate="psi"),
            joint("pitch", "revolute", "outer", "inner", axis=[0, 1, 0], coordinate="theta"),
            joint("roll", "revolute", "inner", "top", axis=[1, 0, 0], coordinate="phi"),
        ],
    )


def arm(n: int = 6) -> Scene:
    """Return an arm of n links of full inertia, each axis across the one before it."""
    axes = ([0, 0, 1], [0, 1, 0], [1, 0, 0])
    tensor = {"xx": "3/100", "yy": "1/25", "zz": "1/50", "xy": "1/500", "xz": "-3/1000", "yz": "1/1000"}
    return scene(
        "arm",
        gravity=[0, 0, f"-{G}"],
        bodies=[
            body(f"b{k}", mass=n + 1 - k, com=["1/10", "-1/50", "1/20"], inertia=tensor, about="com")
            for k in range(1, n + 1)
        ],
        joints=[
            joint(
                f"j{k}",
                "revolute",
                f"b{k - 1}" if k > 1 else "ground",
                f"b{k}",
                axis=axes[k % 3],
                origin=["3/10" if k > 1 else 0, 0, "1/5"],
            )
            for k in range(1, n + 1)
        ],
    )


def heavier(one: Scene, factors: Sequence[Fraction | int]) -> Scene:
    """Return a scene whose bodies are so many times as heavy, density by density."""

    def scaled(part: Body, factor: Quantity) -> Body:
        particles = tuple(replace(p, mass=p.mass * factor) for p in part.particles)
        inertia = None if part.inertia is None else tuple(x * factor for x in part.inertia)
        return replace(part, mass=part.mass * factor, inertia=inertia, particles=particles)  # type: ignore[arg-type]

    return replace(one, bodies=tuple(scaled(b, Quantity.number(f)) for b, f in zip(one.bodies, factors, strict=True)))


def one_body(kind: str = "revolute") -> Scene:
    """Return a pendulum, or a mass on a slide."""
    bodies = [body("b", mass=1, com=[0, -1, 0], inertia=["1/10", "1/10", "1/10"], about="com")]
    return scene(
        "one_body", gravity=[0, f"-{G}", 0], bodies=bodies, joints=[joint("j", kind, "ground", "b", coordinate="q1")]
    )


def offset_pendulum() -> Scene:
    """Return a pendulum of 1 m hung so that its point stands in the origin at rest: its height is 1 - cos q."""
    return scene(
        "offset_pendulum",
        gravity=[0, f"-{G}", 0],
        bodies=[body("b", particles=[{"mass": 1, "at": [0, -1, 0]}])],
        joints=[joint("j", "revolute", "ground", "b", origin=[0, 1, 0], coordinate="q1")],
        points=[point("bob", "b", [("Ty", -1)])],
    )


def pinned() -> Scene:
    """Return a point mass on a massless link of 1 m, free in its plane and held by a pin: a pendulum as a loop."""
    return scene(
        "pinned",
        gravity=[0, f"-{G}", 0],
        bodies=[body("b", particles=[{"mass": 1, "at": [0, 0, 0]}])],
        joints=[joint("j", "planar", "ground", "b", coordinates=["x", "y", "phi"], start=[1, 0, 0], drive=False)],
        loops=[loop("pin", "revolute", "ground", "b", tip=[1, 0, 0])],
    )


def heavy_top() -> Scene:
    """Return the heavy top of Geradin and Cardona: m = 15, J = diag(15/64, 15/32, 15/64), 1 m from the fixed point."""
    return scene(
        "heavy_top",
        gravity=[0, 0, f"-{G}"],
        bodies=[body("top", mass=15, com=[0, 1, 0], inertia=["15/64", "15/32", "15/64"], about="com")],
        joints=[joint("ball", "spherical", "ground", "top", start_rates=[0, 150, "-4.61538"])],
    )


def free_top() -> Scene:
    """Return a top of inertia diag(1, 2, 3) that spins about its middle axis, without gravity."""
    return scene(
        "free_top",
        bodies=[body("top", mass=1, com=[0, 0, 0], inertia=[1, 2, 3], about="com")],
        joints=[joint("ball", "spherical", "ground", "top", start_rates=["1/1000", 10, "1/1000"])],
    )


def stiff_spring(stiffness: int, damping: int) -> Scene:
    """Return a mass of 1 kg on a slide with a spring and a damper, one metre out."""
    return scene(
        "stiff_spring",
        bodies=[body("b", mass=1, com=[0, 0, 0])],
        joints=[joint("j", "prismatic", "ground", "b", axis=[1, 0, 0], coordinate="x", start=1)],
        springs=[spring("s", joint="j", stiffness=stiffness)],
        dampers=[damper("d", joint="j", damping=damping)],
    )


def rubbing() -> Scene:
    """Return a mass of 1 kg on a slide with Stribeck's friction, a spring and a damper, half a metre out."""
    friction: dict[str, int | str] = {"coulomb": 1, "static": "3/2", "stribeck": "1/20", "smoothing": "1/1000"}
    return scene(
        "rubbing",
        bodies=[body("b", mass=1, com=[0, 0, 0])],
        joints=[joint("j", "prismatic", "ground", "b", axis=[1, 0, 0], coordinate="x", start="1/2", friction=friction)],
        springs=[spring("s", joint="j", stiffness=50)],
        dampers=[damper("d", joint="j", damping="2/5")],
    )


def parallelogram(second: bool = False) -> Scene:
    """Return a parallelogram of unit rods, which meets its change point; with a second coupler loops are redundant.

    Two couplers of equal length between the same rods say one thing twice.
    """
    rod = {"mass": 1, "com": ["1/2", 0, 0], "inertia": {"zz": "1/12", "yy": "1/12"}, "about": "com"}
    names = ["a", "b", "c"]
    bodies = [body(name, **rod) for name in names]  # type: ignore[arg-type]
    if second:
        bodies.append(body("d", **rod))  # type: ignore[arg-type]
    joints = [
        joint("j1", "revolute", "ground", "a", coordinate="q1", start="pi/2", start_rates=-1, drive=False),
        joint("j2", "revolute", "a", "b", origin=[1, 0, 0], coordinate="q2", start="-pi/2", start_rates=1, drive=False),
        joint(
            "j3",
            "revolute",
            "ground",
            "c",
            origin=[1, 0, 0],
            coordinate="q3",
            start="pi/2",
            start_rates=-1,
            drive=False,
        ),
    ]
    loops = [loop("ring", "revolute", "b", "c", origin=[1, 0, 0], tip=[-1, 0, 0])]
    if second:
        joints.append(
            joint(
                "j4",
                "revolute",
                "a",
                "d",
                origin=["1/2", 0, 0],
                coordinate="q4",
                start="-pi/2",
                start_rates=1,
                drive=False,
            )
        )
        loops.append(loop("ring2", "revolute", "d", "c", origin=[1, 0, 0], tip=["-1/2", 0, 0]))
    return scene("parallelogram", gravity=[0, f"-{G}", 0], bodies=bodies, joints=joints, loops=loops)
