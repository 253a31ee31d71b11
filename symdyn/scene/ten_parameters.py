"""The ten inertial parameters of a body as names: mass, first moment, inertia about the body frame.

The equations of motion are linear in them (Atkeson, An, Hollerbach 1986).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.scene.values.body import Body, Particle
from symdyn.scene.values.folding import add, mul, neg
from symdyn.scene.values.made_names import Names
from symdyn.scene.values.model import Parameter, Scene
from symdyn.scene.values.quantity import NULL, Quantity, Vector

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


def with_symbolic_inertia(scene: Scene, avoid: Collection[str] = ()) -> Scene:
    """Return the scene with mass, first moment and inertia of every body as free parameters; none in `avoid`.

    Parameters that nothing uses any longer go.
    """
    check_arguments(with_symbolic_inertia, locals(), SceneError)
    used = _used(scene)
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


def _used(scene: Scene) -> set[str]:
    """Return the symbols of everything but the bodies."""
    rest = replace(scene, bodies=(), parameters=())
    return {name for quantity in Quantity.inside(rest) for name in quantity.symbols}


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
