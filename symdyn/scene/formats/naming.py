"""Names of other formats made printable: any text there, identifiers of Python, C and LaTeX here."""

from __future__ import annotations

import re
from collections.abc import Iterable

from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import check_name

LONGEST_CORE = 40

SYMBOL = "symbol"
"""The kind of what formulas name."""


def printable_names(names: Iterable[str], kind: str) -> dict[str, str]:
    """Return a printable name for each name; good ones stay, the others come as near as they can and stay unique.

    Args:
        names: in the order of the file; repeated ones share a name.
        kind: such as "link"; helps where a name has no letters, or is one that something else needs.
    """
    every = dict.fromkeys(names)
    chosen = {name: name for name in every if _good(name, kind)}
    taken = dict.fromkeys(chosen)
    for name in every:
        if name not in chosen:
            chosen[name] = _near(name, kind, taken)
            taken[chosen[name]] = None
    return chosen


def _good(name: str, kind: str) -> bool:
    return check_name(name, letter=kind == SYMBOL) is None and name != Scene.GROUND


def _near(name: str, kind: str, taken: dict[str, None]) -> str:
    core = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")[:LONGEST_CORE].rstrip("_")
    if not _good(core, kind):
        core = f"{core}_{kind}" if core[:1].isalpha() else f"{kind}_{core}".rstrip("_")
    found, k = core, 2
    while found in taken or not _good(found, kind):
        found, k = f"{core}_{k}", k + 1
    return found
