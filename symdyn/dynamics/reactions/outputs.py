"""The outputs that are reactions: rows of OUTPUTS that a scene has when it is asked for them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from symdyn.dynamics.output import Output
from symdyn.dynamics.workspace import Workspace
from symdyn.graph import Expr, substitute

Way = Callable[..., list[Expr]]

WORDS = {
    "body": "the child's body frame",
    "joint": "the joint frame on the parent",
    "ground": "the ground frame",
}


def _recursive(*given: Any) -> list[Expr]:
    from symdyn.dynamics.reactions.recursion import reactions  # with NumPy, which printing can do without

    return reactions(*given)


def _solved(*given: Any) -> list[Expr]:
    from symdyn.dynamics.reactions.solution import solved_reactions

    return solved_reactions(*given)


def _forward(w: Workspace, way: Way, axes: str) -> list[Expr]:
    """Return reactions during the motion that driving forces give."""
    from symdyn.dynamics.derive import derive_one  # the table is above its rows

    moved: Sequence[Expr] = derive_one(w, "forward_dynamics").entries
    tau = derive_one(w, "drive_forces").entries if w.prescribed.place else w.state.tau
    return substitute(way(w.hanging, axes, tau), dict(zip(w.state.qdd, moved, strict=True)))


def _rows(axes: str) -> dict[str, Output]:
    suffix = "" if axes == "body" else f":{axes}"
    text = (
        "reactions [force; moment] that parents exert on children, a row a joint and then a loop, drives included, at "
        f"the origin of the moved joint frame, axes of {WORDS[axes]}"
    )
    ways: dict[str, Way] = {"recursive": _recursive, "dalembert": _solved}
    units, shape = "N and N m", lambda n: (-1, 6)
    inverse = {name: lambda w, way=way: way(w.hanging, axes) for name, way in ways.items()}
    forward = {name: lambda w, way=way: _forward(w, way, axes) for name, way in ways.items()}
    return {
        f"reactions{suffix}": Output(text, ("q", "qd", "qdd"), "R", shape, units, inverse, exists=lambda scene: False),
        f"forward_reactions{suffix}": Output(
            f"{text}, during forward dynamics",
            ("q", "qd", "tau"),
            "R",
            shape,
            units,
            forward,
            exists=lambda scene: False,
        ),
    }


REACTIONS: dict[str, Output] = {name: row for axes in WORDS for name, row in _rows(axes).items()}
"""Rows of the table; they cost nothing where nobody asks."""
