"""Where the functions of a problem come from: its scene, what is free in it, and formulas of the user."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

from symdyn.dynamics import LoopChoices, Workspace
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Faults
from symdyn.simulation.prescribed import number_of, parameter_values
from symdyn.transcription.local import Local, Written, locals_of, written

Formulas = tuple[tuple[str, tuple[Quantity, ...]], ...]
"""Those of the user, by the function that they are."""


@dataclass(frozen=True, eq=False)
class Source:
    """Where the functions of a problem come from: the same for every mesh, method and bounds.

    Pickled is what they are made from; another process makes them again.

    Attributes:
        scene: the mechanism.
        free: names of the parameters that are unknowns.
        formulas: those of path, running and final.
        workspace: with the graph that they are written on.
        written: their entries.
        locals: the functions, compiled.
    """

    scene: Scene
    free: tuple[str, ...]
    formulas: Formulas
    workspace: Workspace
    written: Written
    locals: Mapping[str, Local]

    def __reduce__(self) -> tuple[Callable[..., Source], tuple[Scene, tuple[str, ...], Formulas]]:
        """Return the function that makes it, and of what."""
        return source, (self.scene, self.free, self.formulas)


@lru_cache(maxsize=16)
def source(scene: Scene, free: tuple[str, ...], formulas: Formulas) -> Source:
    """Return the functions of a scene, the parameters that are unknowns without value; theirs decide about loops."""
    values = parameter_values(scene)
    opened = replace(scene, parameters=tuple(replace(p, value=None) if p.name in free else p for p in scene.parameters))
    at = {name: number_of(values[name], values, f"parameters.{name}", Faults("")) or 0.0 for name in free}
    w = Workspace(opened, LoopChoices(parameters=tuple(at.items())))
    found = written(w, free, dict(formulas))
    return Source(scene, free, formulas, w, found, locals_of(w, found))
