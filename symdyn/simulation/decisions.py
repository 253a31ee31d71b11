"""What numbers decide about closed mechanisms before their equations are written, at values of the parameters."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import lru_cache

from symdyn.dynamics.loops.closure import Closure, close
from symdyn.dynamics.loops.linear import LinearLoops, linear_loops
from symdyn.dynamics.loops.numbers import Numbers
from symdyn.dynamics.loops.partition import Partition
from symdyn.scene import Scene
from symdyn.simulation.opened import numbers_at, opened


@dataclass(frozen=True)
class Decisions:
    """The decisions that are written into equations; a tree has none.

    Attributes:
        kept, empty, redundant, partition, fails, driven: as of `Closure`.
        linear: how loops hold dependent coordinates in proportion, None where not.
    """

    kept: tuple[int, ...] = ()
    empty: tuple[int, ...] = ()
    redundant: tuple[int, ...] = ()
    partition: Partition | None = None
    fails: bool = False
    driven: Partition | None = None
    linear: LinearLoops | None = None

    def instead_of(self, other: Decisions) -> str:
        """Return what is said where values before have led to other decisions."""
        changed = [WORDS[f.name] for f in fields(self) if getattr(self, f.name) != getattr(other, f.name)]
        words = " and ".join(dict.fromkeys(changed))
        return f"with these values numbers decide otherwise than before about {words}: the equations are written anew"


WORDS = {
    "kept": "redundant rows",
    "empty": "redundant rows",
    "redundant": "redundant rows",
    "partition": "independent velocities",
    "fails": "independent velocities",
    "driven": "what the drives determine",
    "linear": "loops in proportion",
}


@lru_cache(maxsize=16)
def closure_of(scene: Scene) -> tuple[Closure, Numbers]:
    """Return what is decided about the loops and rows of a scene at its values, and the mechanism in numbers.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    return close(numbers_at(scene), opened(scene).closing)


@lru_cache(maxsize=16)
def decided(scene: Scene) -> Decisions:
    """Return the decisions for a scene at its values; errors as of `closure_of`."""
    if not (scene.loops or scene.rows):
        return Decisions()
    closure, numbers = closure_of(scene)
    found = {f.name: getattr(closure, f.name) for f in fields(Decisions) if f.name != "linear"}
    return Decisions(**found, linear=linear_loops(numbers, closure))
