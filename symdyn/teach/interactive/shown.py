"""What the figure of a page shows: the words of `Step.show`, and which vector a term of a formula speaks of."""

from __future__ import annotations

from collections.abc import Mapping

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


def is_shown(word: str) -> bool:
    """Tell whether a word is one of `Step.show`."""
    return word in SHOWN or any(word.startswith(kind) and len(word) > len(kind) for kind in POINTING)


def pointed(key: str, masses: Mapping[str, str]) -> str:
    """Return what a name speaks of: "velocities:arm", "inertia", "coriolis/0,1", for k_C of velocities 0 and 1; or "".

    Args:
        key: of `Document.names`.
        masses: bodies by the number of a mass.
    """
    kind, _, rest = key.partition(":")
    if kind in OF_A_MASS:
        return f"{OF_A_MASS[kind]}:{masses[rest]}" if rest in masses else "" if rest else OF_A_MASS[kind]
    found = OF_ALL.get(kind.removesuffix("bar"), "")
    if found in ("coriolis", "centrifugal"):
        by = [str(int(number) - 1) for number in rest.split(",")[1:] if number.isdigit()]
        return f"{found}/{','.join(by)}" if by else found
    return found
