"""One row of the table of outputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symdyn.dynamics.workspace import Workspace
from symdyn.graph import Expr
from symdyn.scene import Scene

Road = Callable[..., list[Expr]]
Shape = Callable[[int], tuple[int, ...]]


@dataclass(frozen=True)
class Output:
    """One row of the table.

    Attributes:
        text: what it computes, one line; in braces what `derive` fills in.
        arguments: names of its arguments, keys of `ARGUMENTS`.
        result: short name of the result.
        shape: shape of the result from the number of velocities; -1 for what the number of entries says.
        units: unit of the result, one line.
        roads: derivations by name; the first is the one that code is generated from, unless `prefer` says otherwise.
        place: "" for a whole-scene output, "body" or "point" where a name must be given.
        prefer: which road is cheapest for a mechanism, where that depends on it.
        exists: which scenes have it without being asked.
        closed: the row of scenes with loops or rows, where it is another one.
        unique: which entries of the result rigid bodies determine, row by row, () for all; None where all always are.
    """

    text: str
    arguments: tuple[str, ...]
    result: str
    shape: Shape
    units: str
    roads: dict[str, Road]
    place: str = ""
    prefer: Callable[[Workspace], str] | None = None
    exists: Callable[[Scene], bool] = lambda scene: True
    closed: Output | None = None
    unique: Callable[[Workspace], tuple[bool, ...]] | None = None

    def preferred(self, workspace: Workspace) -> str:
        """Return the name of the road that code is generated from."""
        return self.prefer(workspace) if self.prefer else next(iter(self.roads))
