"""What the figure of a page shows: the words of `Step.show`, and which vector a term of a formula speaks of."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

SHOWN: tuple[str, ...] = (
    "frames",
    "angles",
    "places",
    "velocities",
    "accelerations",
    "weights",
    "forces",
    "inertia",
    "coriolis",
    "centrifugal",
    "momenta",
    "reactions",
    "energies",
    "plots",
    "phase",
    "trails",
    "ghost",
)
"""Words that stand alone; `body:NAME` and `joint:NAME` point at one."""

POINTING = ("body:", "joint:")

OF_A_MASS: Mapping[str, str] = {
    **dict.fromkeys(("x", "y", "z"), "places"),
    **dict.fromkeys(("dx", "dy", "dz", "v2", "K"), "velocities"),
    "P": "weights",
}
"""By what stands before the colon of a name's key; behind it, the number of a mass."""

OF_ALL: Mapping[str, str] = {
    "k_z": "inertia",
    "Mz": "inertia",
    "k_C": "coriolis",
    "k_D": "centrifugal",
    "k_G": "weights",
    "MG": "weights",
    "k_E": "forces",
    **dict.fromkeys(("FD", "MD", "F*D", "M*D"), "inertia"),
    **dict.fromkeys(("FR", "MR", "F*R", "M*R", "reaction"), "reactions"),
    **dict.fromkeys(("FA", "MA", "F*A", "M*A"), "weights"),
}

BY_STEP: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("scene", "task", "coordinates"), ("angles",)),
    "notation": ("frames",),
    "position": ("angles", "places"),
    "energies": ("velocities", "weights", "energies"),
    "lagrangian": ("velocities", "weights", "energies"),
    "momentum": ("momenta",),
    "rate": ("accelerations",),
    "equation": ("inertia", "weights", "forces"),
    "coefficients:k_z": ("inertia",),
    "coefficients:k_C": ("coriolis",),
    "coefficients:k_D": ("centrifugal",),
    "coefficients:k_G": ("weights",),
    "state": ("angles",),
    "torque": ("inertia", "coriolis", "centrifugal", "weights"),
    "moved": ("accelerations", "inertia"),
    "balance": ("weights", "inertia", "reactions", "forces"),
    "power": ("energies", "plots"),
}
"""What a step shows that does not say it, by its key or what stands there before a colon."""

_IN_ITS_OWN_FRAME = re.compile(r"(\d)\1(?![\d])")  # F_22 is about body 2, in frame 2


@dataclass(frozen=True)
class Owners:
    """Whose vectors names speak of.

    Attributes:
        masses: bodies by the number of a mass.
        bodies: by number, the first at 0.
        carriers: joints by the body that they carry.
    """

    masses: Mapping[str, str]
    bodies: tuple[str, ...] = ()
    carriers: Mapping[str, str] = field(default_factory=dict)


def pointed(key: str, owners: Owners) -> str:
    """Return what a name of a document speaks of, or "".

    Such as "velocities:arm"; "inertia", that of all; "coriolis/0,1", for k_C of velocities 0 and 1.
    """
    kind, _, rest = key.partition(":")
    if kind in OF_A_MASS:
        known = owners.masses.get(rest, "")
        return f"{OF_A_MASS[kind]}:{known}" if known else "" if rest else OF_A_MASS[kind]
    found = OF_ALL.get(kind.removesuffix("bar"), "")
    if found in ("coriolis", "centrifugal"):
        by = [str(int(number) - 1) for number in rest.split(",")[1:] if number.isdigit()]
        return f"{found}/{','.join(by)}" if by else found
    joint = rest.split(":")[0].partition(",")[2] or (rest.split(":")[0] if kind == "reaction" else "")
    if joint in owners.carriers.values():
        return f"{found}:{joint}" if found == "reactions" else found
    of = _IN_ITS_OWN_FRAME.match(rest)
    if found and of and int(of[1]) <= len(owners.bodies):
        body = owners.bodies[int(of[1]) - 1]
        return f"{found}:{owners.carriers[body]}" if found == "reactions" else f"{found}:{body}"
    return found
