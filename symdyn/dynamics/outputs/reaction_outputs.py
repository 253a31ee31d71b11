"""The outputs that are reactions: rows of OUTPUTS that a scene has when it is asked for them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from symdyn.dynamics.outputs import closed_outputs as loops, result_labels as labels, tree_formulations as formulations
from symdyn.dynamics.outputs.output import Formulation, Output
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr, substitute

WORDS = {
    "body": "the child's body frame",
    "joint": "the joint frame on the parent",
    "ground": "the ground frame",
}


def _inverse(w: Workspace, axes: str) -> list[Expr]:
    """Return reactions of a motion that is given."""
    from symdyn.dynamics.reactions.free_bodies import reactions  # with NumPy, which printing can do without

    return reactions(w.hanging, axes)


Solved = Callable[[Workspace], list[Expr]]


def forward_reactions(
    w: Workspace,
    axes: str,
    moved: tuple[Solved, Solved, Solved] = (formulations.forward, loops.forward, loops.multipliers),
) -> list[Expr]:
    """Return reactions during the motion that driving forces give, with the multipliers of that motion.

    `moved` derive accelerations of trees, those of closed scenes, and multipliers.
    """
    from symdyn.dynamics.reactions.free_bodies import reactions

    accelerations = w.once(moved[w.scene.is_closed])
    multipliers = w.once(moved[2]) if w.hanging.cuts else ()
    return substitute(reactions(w.hanging, axes, multipliers), dict(zip(w.state.qdd, accelerations, strict=True)))


def unique(w: Workspace, axes: str) -> tuple[bool, ...]:
    """Return which entries rigid bodies determine, () for all."""
    if not w.scene.is_closed:
        return ()
    from symdyn.dynamics.outputs.unique_reactions import unique_entries

    return unique_entries(w, axes)


def _rows(axes: str) -> dict[str, Output]:
    suffix = "" if axes == "body" else f":{axes}"
    text = (
        "reactions [force; moment] that parents exert on children, a row a joint and then a loop, drives included, at "
        f"the origin of the moved joint frame, axes of {WORDS[axes]}"
    )
    usual = partial(
        Output,
        result="R",
        axes=(labels.joints, labels.fixed(*labels.COMPONENTS)),
        units="N and N m",
        when_constrained="same",
        may_fail="reported",
        unique=lambda w: w.once(unique, axes),
    )
    return {
        f"reactions{suffix}": usual(
            text,
            ("q", "qd", "qdd"),
            formulations={"recursive": Formulation(lambda w: _inverse(w, axes))},
            default_in="request" if suffix else "verify",
        ),
        f"forward_reactions{suffix}": usual(
            f"{text}, during forward dynamics",
            ("q", "qd", "tau"),
            formulations={"recursive": Formulation(lambda w: forward_reactions(w, axes))},
            default_in="request",
            depends=("independent", "alpha", "beta"),
        ),
    }


REACTIONS: dict[str, Output] = {name: row for axes in WORDS for name, row in _rows(axes).items()}
"""Rows of the table; they cost nothing where nobody asks."""
