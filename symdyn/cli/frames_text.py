"""Chosen link frames as text: `Rx(-90 deg) Tx(a3) Rz(q3) Tz(d3)`, beside the joint as declared."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TypedDict

from symdyn.dynamics import chosen_frames, formulas
from symdyn.emit.print import text_of
from symdyn.graph import Expr, Graph
from symdyn.rounding import digits_or
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Joint, Pose, spell
from symdyn.spatial import Transform

DIGITS = 6


class FrameText(TypedDict):
    """What is said about one frame.

    Attributes:
        joint, body: names.
        declared: type, axis and origin of the joint, as in the scene.
        parent: the joint that carries the frame before, or "ground".
        link: the placement in that frame.
        moved: where the frame is in the declared frame of the joint; "" where it is that frame.
    """

    joint: str
    body: str
    declared: str
    parent: str
    link: str
    moved: str


def frame_texts(scene: Scene) -> list[FrameText]:
    """Return text about every chosen frame, the ground's side first.

    Angles are in degrees where that is exact. Numbers that come of an angle without an exact sine have six digits.
    """
    return [
        FrameText(
            joint=frame.joint.name,
            body=frame.joint.child,
            declared=_declared(frame.joint),
            parent=frame.parent,
            link=" ".join(map(step_text, frame.steps)) or "1",
            moved=moved_text(frame.moved),
        )
        for frame in chosen_frames(scene)
    ]


def _declared(joint: Joint) -> str:
    origin = _pose(joint.origin)
    kind = JOINTS[joint.type]
    axis = kind.axis(joint)
    way = "about" if axis and not kind.slides(joint) else "along"
    shown = ", ".join(map(spell, axis or joint.axis))
    return f"{joint.type} {way} ({shown}) at {joint.parent}{f' {origin}' if origin else ''}"


def _pose(pose: Pose) -> str:
    graph = Graph()
    return " ".join(step_text((kind, (amount.express(graph),))) for kind, amount in pose.steps)


def step_text(step: tuple[str, Sequence[Expr]]) -> str:
    """Return one elementary motion, such as "Rx(90 deg)"."""
    kind, amounts = step
    show = angle_text if kind in ("Rx", "Ry", "Rz") else length_text
    return f"{kind}({', '.join(map(show, amounts))})"


def length_text(length: Expr) -> str:
    """Return a formula."""
    return text_of(formulas([length], digits_or(DIGITS))[0])


def angle_text(angle: Expr) -> str:
    """Return an angle: multiples of π in degrees, the rest as formula in rad."""
    form, graph = angle.linear_form(), angle.graph
    rest = graph.total(graph.constant(factor) * atom for atom, factor in form.terms) + form.constant
    text = "" if rest.is_zero else length_text(rest)
    if not form.turns:
        return text or "0"
    degrees = f"{spell(abs(form.turns) * 180)} deg"
    if not text:
        return f"-{degrees}" if form.turns < 0 else degrees
    return f"{text} {'-' if form.turns < 0 else '+'} {degrees}"


def moved_text(T: Transform) -> str:
    """Return where a frame is, in what differs from the identity: "origin (0, 0, d), x along (0, 1, 0)"."""
    said = [] if all(x.is_zero for x in T.p) else [f"origin {_vector(T.p)}"]
    for name, axis, unit in zip("xz", list(zip(*T.R, strict=True))[::2], ((1, 0, 0), (0, 0, 1)), strict=True):
        if tuple(x.value for x in axis) != tuple(map(Fraction, unit)):
            said.append(f"{name} along {_vector(axis)}")
    return ", ".join(said)


def _vector(x: Sequence[Expr]) -> str:
    return f"({', '.join(map(length_text, x))})"
