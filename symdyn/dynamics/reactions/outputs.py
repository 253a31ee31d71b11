"""The outputs that are reactions: rows of OUTPUTS that a scene has when it is asked for them."""

from __future__ import annotations

from typing import Any

from symdyn.dynamics.output import Output
from symdyn.dynamics.workspace import Workspace
from symdyn.graph import Expr, substitute

WORDS = {
    "body": "the child's body frame",
    "joint": "the joint frame on the parent",
    "ground": "the ground frame",
}


def _inverse(w: Workspace, axes: str) -> list[Expr]:
    """Return reactions of a motion that is given."""
    from symdyn.dynamics.reactions.recursion import reactions  # with NumPy, which printing can do without

    return reactions(w.hanging, axes)


def _forward(w: Workspace, axes: str) -> list[Expr]:
    """Return reactions during the motion that driving forces give, with the multipliers of that motion."""
    from symdyn.dynamics.derive import derive_one  # the table is above its rows
    from symdyn.dynamics.reactions.recursion import reactions

    moved = derive_one(w, "forward_dynamics").entries
    multipliers = derive_one(w, "multipliers").entries if w.hanging.cuts else ()
    return substitute(reactions(w.hanging, axes, multipliers), dict(zip(w.state.qdd, moved, strict=True)))


def _unique(w: Workspace, axes: str) -> tuple[bool, ...]:
    """Return which entries rigid bodies determine, () for all."""
    if not w.scene.is_closed:
        return ()
    from symdyn.dynamics.reactions.loose import unique_entries

    return unique_entries(w, axes)


def _rows(axes: str) -> dict[str, Output]:
    suffix = "" if axes == "body" else f":{axes}"
    text = (
        "reactions [force; moment] that parents exert on children, a row a joint and then a loop, drives included, at "
        f"the origin of the moved joint frame, axes of {WORDS[axes]}"
    )
    units, shape = "N and N m", lambda n: (-1, 6)
    inverse = {"recursive": lambda w: _inverse(w, axes)}
    forward = {"recursive": lambda w: _forward(w, axes)}
    known: dict[str, Any] = {"exists": lambda scene: False, "unique": lambda w: _unique(w, axes)}
    return {
        f"reactions{suffix}": Output(text, ("q", "qd", "qdd"), "R", shape, units, inverse, **known),
        f"forward_reactions{suffix}": Output(
            f"{text}, during forward dynamics", ("q", "qd", "tau"), "R", shape, units, forward, **known
        ),
    }


REACTIONS: dict[str, Output] = {name: row for axes in WORDS for name, row in _rows(axes).items()}
"""Rows of the table; they cost nothing where nobody asks."""
