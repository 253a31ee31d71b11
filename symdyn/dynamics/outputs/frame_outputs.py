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
from symdyn.dynamics.outputs.output import Formulation, Output, by_differentiation
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr, tangents

WORDS = {
    "aligned": "ground frame",
    "local": "in its own axes",
    "world": "axes of the ground, of the point of the body that passes the origin of the ground",
}
"""What texts say of a frame, and of the point whose velocity the linear part is."""

Derive = Callable[..., list[Expr]]
Kind = tuple[str, tuple[str, ...], str, tuple[labels.Axis, ...], str, Derive, Derive]


def _by_rates(w: Workspace, name: str, frame: str) -> list[Expr]:
    return frames.differentiated(w.scene, name, w.graph, frame)


_TWIST = labels.fixed(*labels.TWIST)
_RATES = "m/s^2 and rad/s^2"
KINDS: dict[str, Kind] = {
    "jacobian": (
        "Jacobian J of {{name}}: [velocity of its origin; angular velocity] = J qd, {at}",
        ("q",), "J", (_TWIST, labels.velocities), "m or 1, and 1",
        lambda w, name, frame: frames.jacobian(w.scene, w.tree, w.state, name, frame),
        lambda w, name, frame: frames.differentiated_jacobian(w.scene, name, w.graph, frame),
    ),
    "jdot_qdot": (
        "velocity product Jdot qd of {{name}}: its [acceleration; angular acceleration] at qdd = 0, {at}{rate}",
        ("q", "qd"), "a", (_TWIST,), _RATES,
        lambda w, name, frame: frames.acceleration(w.scene, w.tree, w.state, name, frame),
        lambda w, name, frame: tangents(_by_rates(w, name, frame), w.state.velocity),
    ),
    "velocity": (
        "[velocity of its origin; angular velocity] of {{name}}, {at}",
        ("q", "qd"), "V", (_TWIST,), "m/s and rad/s",
        lambda w, name, frame: frames.velocity(w.scene, w.tree, w.state, name, frame),
        _by_rates,
    ),
    "acceleration": (
        "[acceleration of its origin; angular acceleration] of {{name}}, {at}, without gravity{rate}",
        ("q", "qd", "qdd"), "A", (_TWIST,), _RATES,
        lambda w, name, frame: frames.acceleration(w.scene, w.tree, w.state, name, frame, w.state.qdd),
        lambda w, name, frame: tangents(_by_rates(w, name, frame), w.state.acceleration),
    ),
}  # fmt: skip
"""Text, arguments, result, axes and units, and the two formulations."""


def _row(kind: str, frame: str) -> Output:
    text, arguments, result, axes, units, recursive, by_rates = KINDS[kind]
    usual = frame == FRAMES[0]
    return Output(
        text.format(at=WORDS[frame], rate="" if usual else ", the rate of its velocity there"),
        arguments, result, axes, units, "same",
        {
            "recursive": Formulation(partial(recursive, frame=frame)),
            "differentiation": by_differentiation(partial(by_rates, frame=frame)),
        },
        place="point",
        default_in="load" if usual and kind in ("jacobian", "jdot_qdot") else "request",
    )  # fmt: skip


IN_FRAMES: Mapping[str, Mapping[str, Output]] = {frame: {kind: _row(kind, frame) for kind in KINDS} for frame in FRAMES}
"""Rows by the word for the frame, then by name."""

MOVING = IN_FRAMES[FRAMES[0]]
"""Rows of the table of outputs."""
