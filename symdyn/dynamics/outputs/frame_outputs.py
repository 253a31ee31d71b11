"""Outputs of how a named frame moves, in the axes and at the point that the word behind its name says: rows of OUTPUTS.

"jacobian:tool" is that of frames that are aligned with the ground, as is "jacobian:tool:aligned"; "jacobian:tool:local"
and "jacobian:tool:world" are others, with derivatives of their own: "jacobian_jvp:tool:local".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from symdyn.dynamics.mechanism import frames
from symdyn.dynamics.mechanism.frames import FRAMES
from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.output import DefaultIn, Formulation, Output, by_differentiation
from symdyn.graph import Expr

WORDS = {
    "aligned": "ground frame",
    "local": "in its own axes",
    "world": "axes of the ground, of the point of the body that passes the origin of the ground",
}
"""What texts say of a frame, and of the point whose velocity the linear part is."""

_MOVES = partial(Output, when_constrained="same", place="point")


def _both(
    recursive: Callable[..., list[Expr]], by_rates: Callable[..., list[Expr]], frame: str
) -> dict[str, Formulation]:
    """Return the two formulations of how a frame moves."""
    return {
        "recursive": Formulation(lambda w, name: recursive(w.scene, w.tree, w.state, name, frame)),
        "differentiation": by_differentiation(lambda w, name: by_rates(w.scene, name, w.graph, frame)),
    }


def _rows(frame: str) -> dict[str, Output]:
    at, usual = WORDS[frame], frame == FRAMES[0]
    written: DefaultIn = "load" if usual else "request"
    found = "" if usual else ", the rate of its velocity there"
    twist = labels.fixed(*labels.TWIST)
    return {
        "jacobian": _MOVES(
            f"Jacobian J of {{name}}: [velocity of its origin; angular velocity] = J qd, {at}",
            ("q",),
            "J",
            (twist, labels.velocities),
            "m or 1, and 1",
            formulations=_both(frames.jacobian, frames.differentiated_jacobian, frame),
            default_in=written,
        ),
        "jdot_qdot": _MOVES(
            f"velocity product Jdot qd of {{name}}: its [acceleration; angular acceleration] at qdd = 0, {at}{found}",
            ("q", "qd"),
            "a",
            (twist,),
            "m/s^2 and rad/s^2",
            formulations=_both(frames.velocity_product, frames.differentiated_velocity_product, frame),
            default_in=written,
        ),
        "velocity": _MOVES(
            f"[velocity of its origin; angular velocity] of {{name}}, {at}",
            ("q", "qd"),
            "V",
            (twist,),
            "m/s and rad/s",
            formulations=_both(frames.velocity, frames.differentiated_velocity, frame),
            default_in="request",
        ),
        "acceleration": _MOVES(
            f"[acceleration of its origin; angular acceleration] of {{name}}, {at}, without gravity{found}",
            ("q", "qd", "qdd"),
            "A",
            (twist,),
            "m/s^2 and rad/s^2",
            formulations=_both(frames.acceleration, frames.differentiated_acceleration, frame),
            default_in="request",
        ),
    }


IN_FRAMES: Mapping[str, Mapping[str, Output]] = {frame: _rows(frame) for frame in FRAMES}
"""Rows by the word for the frame, then by name."""

MOVING = IN_FRAMES[FRAMES[0]]
"""Rows of the table of outputs."""
