"""What a user should know of a problem before it is solved: kinks, and what does not follow unknown parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

from symdyn.dynamics.outputs import kinks
from symdyn.errors import listed
from symdyn.graph import substitute
from symdyn.scene import Quantity, Scene, parse
from symdyn.scene.joints import start_of
from symdyn.simulation.prescribed import drive_names
from symdyn.transcription.local import Source

WHAT = {
    "balance": "the equations of motion",
    "rates": "the rates of states",
    "held": "loops and prescribed motions",
    "path": "the path",
    "open": "contacts",
    "law": "impacts",
    "running": "the cost",
    "final": "the final cost",
}
"""What functions are called that may have kinks."""


def remarks(source: Source) -> Iterator[str]:
    """Tell where functions have kinks, and whether the start, which is given whole, fixes what is unknown."""
    w, found = source.workspace, source.written
    meant = dict(zip(w.state.tau, map(w.graph.symbol, drive_names(w.scene)), strict=True))
    varied = substitute(list(chain(*found.kinds.values())), meant)
    for name, what in WHAT.items():
        if told := kinks(substitute(list(found.entries.get(name, ())), meant), varied):
            yield f"slopes of {what} are {told.removeprefix('; ')}"
    if "held" in source.locals:
        pattern = source.locals["held"].pattern
        moving = {source.free[k] for i, kind, k in pattern if kind == "free" and i < len(found.holding)}
        if moving:
            yield (
                f"rows at the start, which is given whole, have {listed(sorted(moving))} in them: only values that "
                "close them there are left"
            )


def taken(scene: Scene, free: Sequence[str], given: Mapping[str, Mapping[str, object]]) -> Iterator[str]:
    """Tell where the guess of an unknown parameter is taken for its value: in what must be a number."""
    formulas = [
        (f"{where}: {name}", parse(text))
        for where, one in given.items()
        for name, text in one.items()
        if isinstance(text, str)
    ]
    for where, names, those in (
        ("start", scene.coordinates, start_of(scene).position),
        ("start", [one.name for one in scene.states], [one.value for one in scene.states]),
        ("start rates", scene.velocities, start_of(scene).velocity),
    ):
        formulas += [(f"{where}: {n}", x) for n, x in zip(names, those, strict=True) if n not in given.get(where, {})]
    for joint in scene.moving:
        limits = joint.limits
        every = (limits.lower, limits.upper, limits.velocity, limits.effort)
        formulas += [(f"limits of {joint.name}", x) for x in every if isinstance(x, Quantity)]
    for where, formula in formulas:
        if unknown := [name for name in formula.symbols if name in free]:
            yield f"{where} takes {listed(unknown)} as the scene has it, not as it is found"
