"""A scene with its inertias left open: ten named parameters for every body, for identification and for counting."""

from __future__ import annotations

from dataclasses import replace

from symdyn.scene.model import Body, Parameter, Scene, velocity_name
from symdyn.scene.quantity import symbol

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


def with_symbolic_inertia(scene: Scene) -> Scene:
    """Return the scene with mass, first moment and inertia of every body as free parameters.

    The k-th body gets m<k>, mx<k>, my<k>, mz<k>, Ixx<k>, ... Iyz<k>, about the origin of its frame; all of them take a
    suffix "_b" (twice if need be) when one of these names is in use. Parameters that nothing uses any longer go.
    """
    used = _used(scene)
    kept = tuple(parameter for parameter in scene.parameters if parameter.name in used)
    taken = {parameter.name for parameter in kept} | _moving_names(scene)
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
    mass, x, y, z, xx, yy, zz, xy, xz, yz = (symbol(name) for name in names)
    return Body(body.name, mass, None, (x, y, z), (xx, yy, zz, xy, xz, yz), "frame")


def _moving_names(scene: Scene) -> set[str]:
    names = {name for q in scene.coordinates for name in (q, velocity_name(q))}
    return names | {joint.drive for joint in scene.joints if joint.drive}


def _used(scene: Scene) -> set[str]:
    """Return the symbols of everything but the bodies."""
    quantities = list(scene.gravity)
    for joint in scene.joints:
        quantities += [joint.force, *(amount for pose in (joint.origin, joint.tip) for _, amount in pose.steps)]
    quantities += [amount for point in scene.points for _, amount in point.at.steps]
    return {name for quantity in quantities for name in quantity.symbols}
