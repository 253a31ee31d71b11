"""One law of mechanics: a claim about outputs of one scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symdyn.dynamics import Workspace, derive_one
from symdyn.graph import Expr
from symdyn.scene import Scene
from symdyn.verify.equality import Claim

Outputs = tuple[str, ...]


@dataclass(frozen=True)
class Law:
    """A law, and the outputs that it is about.

    Attributes:
        claim: what it claims of the scene of a workspace; None where it says nothing about it.
        trees: the outputs that it is about; None where it is no law of trees.
        loops: those that it is about where loops or rows close the scene; None where it is no law of such.
    """

    claim: Callable[[Workspace], Claim | None]
    trees: Outputs | None
    loops: Outputs | None

    def about(self, scene: Scene) -> Outputs | None:
        """Return the outputs of a scene that it is about, None where it is no law of its kind."""
        return self.loops if scene.is_closed else self.trees


def everywhere(claim: Callable[[Workspace], Claim | None], *outputs: str) -> Law:
    """Return a law about the same outputs of trees and of closed scenes."""
    return Law(claim, outputs, outputs)


def of_loops(claim: Callable[[Workspace], Claim | None], *outputs: str) -> Law:
    """Return a law of closed scenes alone."""
    return Law(claim, None, outputs)


def entries(w: Workspace, name: str) -> tuple[Expr, ...]:
    """Return the entries of an output, by the road that code is generated from."""
    return derive_one(w, name).entries
