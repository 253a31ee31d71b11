"""The built-in scenes of the hard cases, as files say them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from symdyn.scene import Quantity, Scene, read_text
from symdyn.scene.values import Body

DOWN = "gravity = [0, -9.81, 0]"

ROUND = 'type = "revolute"'

SLIDE = 'type = "prismatic", parent = "ground", child = "b", axis = [1, 0, 0], coordinate = "x"'


def two_link(first: Fraction | int = 1, second: Fraction | int = 1) -> Scene:
    """Return two point masses on massless links of 1 m; angles from the downward vertical and from link 1."""
    return read_text(f"""
        name = "two_link"
        {DOWN}
        bodies.b1.particles = [{{ mass = "{first}", at = [0, -1, 0] }}]
        bodies.b2.particles = [{{ mass = "{second}", at = [0, -1, 0] }}]
        joints.j1 = {{ {ROUND}, parent = "ground", child = "b1" }}
        joints.j2 = {{ {ROUND}, parent = "b1", child = "b2", origin = [0, -1, 0] }}
        points.tool = {{ body = "b2", at = [0, -1, 0] }}
    """)


def chain(n: int, absolute: bool = False) -> Scene:
    """Return n unit point masses on links of 1 m, with angles relative to the link before or to the vertical.

    An absolute angle is a joint that takes the angle before it back, then one that turns by its own.
    """
    lines = [f'name = "chain{n}{"_absolute" if absolute else ""}"', DOWN]
    for k in range(1, n + 1):
        parent, origin = ("ground", 0) if k == 1 else (f"b{k - 1}", -1)
        if absolute and k > 1:
            back = f'mimic = {{ joint = "j{k - 1}", ratio = -1 }}'
            lines += [
                f"bodies.a{k} = {{}}",
                f'joints.back{k} = {{ {ROUND}, parent = "{parent}", child = "a{k}", origin = [0, -1, 0], {back} }}',
            ]
            parent, origin = f"a{k}", 0
        lines += [
            f"bodies.b{k}.particles = [{{ mass = 1, at = [0, -1, 0] }}]",
            f'joints.j{k} = {{ {ROUND}, parent = "{parent}", child = "b{k}", origin = [0, {origin}, 0] }}',
        ]
    return read_text("\n".join(lines))


def gimbal() -> Scene:
    """Return a rigid body with inertia diag(1, 2, 3) on three massless gimbals z, y, x, free of gravity."""
    return read_text(f"""
        name = "gimbal"
        bodies.outer = {{}}
        bodies.inner = {{}}
        bodies.top = {{ mass = 1, inertia = [1, 2, 3], inertia_about = "com" }}
        joints.yaw = {{ {ROUND}, parent = "ground", child = "outer", axis = [0, 0, 1], coordinate = "psi" }}
        joints.pitch = {{ {ROUND}, parent = "outer", child = "inner", axis = [0, 1, 0], coordinate = "theta" }}
        joints.roll = {{ {ROUND}, parent = "inner", child = "top", axis = [1, 0, 0], coordinate = "phi" }}
    """)


def arm(n: int = 6) -> Scene:
    """Return an arm of n links of full inertia, each axis across the one before it."""
    axes = ([0, 0, 1], [0, 1, 0], [1, 0, 0])
    tensor = "inertia = { xx = 0.03, yy = 0.04, zz = 0.02, xy = 0.002, xz = -0.003, yz = 0.001 }"
    solid = f'com = [0.1, -0.02, 0.05], {tensor}, inertia_about = "com"'
    lines = ['name = "arm"']
    for k in range(1, n + 1):
        placed = f"axis = {axes[k % 3]}, origin = [{0.3 if k > 1 else 0}, 0, 0.2]"
        parent = f"b{k - 1}" if k > 1 else "ground"
        lines += [
            f"bodies.b{k} = {{ mass = {n + 1 - k}, {solid} }}",
            f'joints.j{k} = {{ {ROUND}, parent = "{parent}", child = "b{k}", {placed} }}',
        ]
    return read_text("\n".join(lines))


def heavier(one: Scene, factors: Sequence[Fraction | int]) -> Scene:
    """Return a scene whose bodies are so many times as heavy, density by density."""

    def scaled(part: Body, factor: Quantity) -> Body:
        particles = tuple(replace(p, mass=p.mass * factor) for p in part.particles)
        inertia = None if part.inertia is None else tuple(x * factor for x in part.inertia)
        return replace(part, mass=part.mass * factor, inertia=inertia, particles=particles)  # type: ignore[arg-type]

    return replace(one, bodies=tuple(scaled(b, Quantity.number(f)) for b, f in zip(one.bodies, factors, strict=True)))


def one_body(kind: str = "revolute") -> Scene:
    """Return a pendulum, or a mass on a slide."""
    return read_text(f"""
        name = "one_body"
        {DOWN}
        bodies.b = {{ mass = 1, com = [0, -1, 0], inertia = [0.1, 0.1, 0.1], inertia_about = "com" }}
        joints.j = {{ type = "{kind}", parent = "ground", child = "b" }}
    """)


def offset_pendulum() -> Scene:
    """Return a pendulum of 1 m hung so that its point stands in the origin at rest: its height is 1 - cos q."""
    return read_text(f"""
        name = "offset_pendulum"
        {DOWN}
        bodies.b.particles = [{{ mass = 1, at = [0, -1, 0] }}]
        joints.j = {{ {ROUND}, parent = "ground", child = "b", origin = [0, 1, 0] }}
        points.bob = {{ body = "b", at = [0, -1, 0] }}
    """)


def pinned() -> Scene:
    """Return a point mass on a massless link of 1 m, free in its plane and held by a pin: a pendulum as a loop."""
    return read_text(f"""
        name = "pinned"
        {DOWN}
        loop = [{{ name = "pin", {ROUND}, parent = "ground", child = "b", tip = [1, 0, 0] }}]
        bodies.b.particles = [{{ mass = 1, at = [0, 0, 0] }}]
        [joints.j]
        type = "planar"
        parent = "ground"
        child = "b"
        coordinates = ["x", "y", "phi"]
        start = [1, 0, 0]
        drive = false
    """)


def heavy_top() -> Scene:
    """Return the heavy top of Geradin and Cardona: m = 15, J = diag(15/64, 15/32, 15/64), 1 m from the fixed point."""
    return read_text("""
        name = "heavy_top"
        bodies.top = { mass = 15, com = [0, 1, 0], inertia = ["15/64", "15/32", "15/64"], inertia_about = "com" }
        joints.ball = { type = "spherical", parent = "ground", child = "top", start_rates = [0, 150, -4.61538] }
    """)


def free_top() -> Scene:
    """Return a top of inertia diag(1, 2, 3) that spins about its middle axis, without gravity."""
    return read_text("""
        name = "free_top"
        bodies.top = { mass = 1, inertia = [1, 2, 3], inertia_about = "com" }
        joints.ball = { type = "spherical", parent = "ground", child = "top", start_rates = [0.001, 10, 0.001] }
    """)


def stiff_spring(stiffness: int, damping: int) -> Scene:
    """Return a mass of 1 kg on a slide with a spring and a damper, one metre out."""
    return read_text(f"""
        name = "stiff_spring"
        bodies.b.mass = 1
        joints.j = {{ {SLIDE}, start = 1 }}
        springs.s = {{ joint = "j", stiffness = {stiffness} }}
        dampers.d = {{ joint = "j", damping = {damping} }}
    """)


def rubbing() -> Scene:
    """Return a mass of 1 kg on a slide with Stribeck's friction, a spring and a damper, half a metre out."""
    friction = "{ coulomb = 1, static = 1.5, stribeck = 0.05, smoothing = 0.001 }"
    return read_text(f"""
        name = "rubbing"
        bodies.b.mass = 1
        joints.j = {{ {SLIDE}, start = 0.5, friction = {friction} }}
        springs.s = {{ joint = "j", stiffness = 50 }}
        dampers.d = {{ joint = "j", damping = 0.4 }}
    """)


def parallelogram(second: bool = False) -> Scene:
    """Return a parallelogram of unit rods, which meets its change point; with a second coupler loops are redundant.

    Two couplers of equal length between the same rods say one thing twice.
    """
    rod = 'mass = 1, com = [0.5, 0, 0], inertia = [0, "1/12", "1/12"], inertia_about = "com"'
    up = f'{ROUND}, drive = false, start = "pi/2", start_rates = -1'
    level = f'{ROUND}, drive = false, start = "-pi/2", start_rates = 1'
    closed = f'{ROUND}, child = "c", origin = [1, 0, 0]'
    lines = [
        f'name = "parallelogram"\n{DOWN}',
        *(f"bodies.{name} = {{ {rod} }}" for name in ("abcd" if second else "abc")),
        f'joints.j1 = {{ {up}, parent = "ground", child = "a" }}',
        f'joints.j2 = {{ {level}, parent = "a", child = "b", origin = [1, 0, 0] }}',
        f'joints.j3 = {{ {up}, parent = "ground", child = "c", origin = [1, 0, 0] }}',
    ]
    rings = [f'{{ name = "ring", parent = "b", {closed}, tip = [-1, 0, 0] }}']
    if second:
        lines += [f'joints.j4 = {{ {level}, parent = "a", child = "d", origin = [0.5, 0, 0] }}']
        rings += [f'{{ name = "ring2", parent = "d", {closed}, tip = [-0.5, 0, 0] }}']
    return read_text("\n".join([*lines, f"loop = [{', '.join(rings)}]"]))
