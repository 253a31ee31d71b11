"""One law of mechanics: a claim about outputs of one scene, or what is looked at in numbers."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symdyn.dynamics import Workspace, derive_one
from symdyn.graph import Expr
from symdyn.program import Program
from symdyn.scene import Scene
from symdyn.verdict import Unclaimed
from symdyn.verify.equality import Claim, Finding

Outputs = tuple[str, ...]

Looked = tuple[list[Finding], list[Unclaimed]]
"""What was found in numbers, and where there is nothing to claim."""


@dataclass(frozen=True)
class About:
    """The outputs that a law is about.

    Attributes:
        trees: those of trees; None where it is no law of trees.
        loops: those where loops or rows close the scene; None where it is no law of such.
    """

    trees: Outputs | None
    loops: Outputs | None

    def fits(self, scene: Scene, outputs: Collection[str]) -> bool:
        """Tell whether it is a law of scenes of this kind, and about nothing but these outputs."""
        needed = self.loops if scene.is_closed else self.trees
        return needed is not None and set(needed) <= set(outputs)


@dataclass(frozen=True)
class Law(About):
    """A law that is proved; `claim` returns None where it says nothing about a scene."""

    claim: Callable[[Workspace], Claim | None]


@dataclass(frozen=True)
class Seen:
    """What is looked at in numbers: a scene's derivations, their outputs, and its program with its built modules."""

    workspace: Workspace
    outputs: Sequence[str]
    program: Program
    modules: Mapping[str, Any]
    seed: int


@dataclass(frozen=True)
class Look(About):
    """A law that is looked at in numbers, where proofs see nothing; `look` returns findings, and what is no claim.

    Attributes:
        doing: what is being done, in words.
    """

    doing: str
    look: Callable[[Seen], Looked]


def everywhere(claim: Callable[[Workspace], Claim | None], *outputs: str) -> Law:
    """Return a law about the same outputs of trees and of closed scenes."""
    return Law(outputs, outputs, claim)


def of_loops(claim: Callable[[Workspace], Claim | None], *outputs: str) -> Law:
    """Return a law of closed scenes alone."""
    return Law(None, outputs, claim)


def entries(w: Workspace, name: str) -> tuple[Expr, ...]:
    """Return the entries of an output, in the formulation that code is generated from."""
    return derive_one(w, name).entries
