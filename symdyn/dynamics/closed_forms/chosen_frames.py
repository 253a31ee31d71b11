"""The link frames that the generator chose, as products of elementary motions, and where they are in the declared ones.

    T_pi = Rz(γ) Tz(ε) Rx(α) Tx(d) Rz(θ) Tz(r)       θ = θ0 + q (revolute) or r = r0 + q (prismatic)

γ and ε appear where a body carries several joints. Where no common normal could be had (see `reframe`), the shift is
Tx Ty Tz, and a declared rotation that no Rx replaces stands as a matrix.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from symdyn.dynamics.closed_forms.formulas import vanishes
from symdyn.dynamics.mechanism.exact import has_symbols, settle, turns_of
from symdyn.dynamics.mechanism.state import joint_motion
from symdyn.dynamics.recursive.links import GeneralTurn, Link, PlanarTurn
from symdyn.dynamics.recursive.reframe import reframe
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.graph import Expr, Op, substitute
from symdyn.scene import GROUND, Joint, Scene
from symdyn.spatial import Transform

Step = tuple[str, tuple[Expr, ...]]


@dataclass(frozen=True)
class ChosenFrame:
    """The frame of one moving body.

    Attributes:
        joint: as declared; it carries `joint.child`.
        parent: the joint that carries the frame in which this one is placed, "ground" for the ground's.
        steps: elementary motions from that frame to this one, left to right: "Tx", "Ty", "Tz" by a length (m), "Rx",
            "Rz" by an angle (rad), "R" by the nine entries of a rotation, row by row. What does nothing is left out.
        moved: placement of this frame in the declared frame of the moved joint.
    """

    joint: Joint
    parent: str
    steps: tuple[Step, ...]
    moved: Transform


def chosen_frames(scene: Scene) -> tuple[ChosenFrame, ...]:
    """Return the frames of all moving bodies, the ground's side first; one a move of its joint."""
    w = Workspace(scene)
    framed = reframe(w.tree)
    joints = [joint for joint in scene.joints for _ in joint_motion(joint, w.graph).moves]
    still = dict.fromkeys(w.state.q, w.graph.zero)
    found = []
    for i, joint in enumerate(joints, start=1):
        p = framed.parent[i]
        steps = _steps(framed.link[i], framed.slides[i], w.tree.position[i], still)
        shown = tuple((kind, amounts) for kind, amounts in steps if not all(map(vanishes, amounts)))
        found.append(ChosenFrame(joint, joints[p - 1].name if p else GROUND, shown, framed.moved[i]))
    return tuple(found)


def _steps(link: Link, slides: bool, position: Expr, still: dict[Expr, Expr]) -> Iterator[Step]:
    """Yield the steps of a link, `still` being all coordinates at zero; its shift is turned into the frame behind γ."""
    turns, (x, y, z) = link.fixed, link.shift
    if turns and isinstance(gamma := turns[0], PlanarTurn) and gamma.k == 2:
        turns = turns[1:]
        x, y, z = gamma.out(link.shift)
        yield "Rz", (angle_of(gamma.cos, gamma.sin),)
    rise = link.rise
    if not turns:  # the shift along z goes with the rise
        rise, z = rise + z, z.graph.zero
    along_x: Step = ("Tx", (x,))
    if not vanishes(y) or any(isinstance(turn, GeneralTurn) for turn in turns):
        yield along_x
        yield "Ty", (y,)
        along_x = ("Tx", (x.graph.zero,))
    yield "Tz", (z,)
    for turn in turns:
        if isinstance(turn, PlanarTurn):
            yield "Rx", (angle_of(turn.cos, turn.sin),)
        elif isinstance(turn, GeneralTurn):
            yield "R", (*turn.R[0], *turn.R[1], *turn.R[2])
    yield along_x
    if slides:
        yield "Rz", (angle_of(link.turn.cos, link.turn.sin),)
    else:
        c, s, start = substitute([link.turn.cos, link.turn.sin, position], still)
        yield "Rz", (angle_of(*settle([c, s])) + (position - start),)
    yield "Tz", (rise,)


def angle_of(c: Expr, s: Expr) -> Expr:
    """Return the angle with this cosine and sine: the one that they are of, a part of a turn, or atan2."""
    graph, quarter = c.graph, c.graph.pi / 2
    (minus_c, c_), (minus_s, s_) = _unsigned(c), _unsigned(s)
    if (c_.op, s_.op) in ((Op.COS, Op.SIN), (Op.SIN, Op.COS)) and c_.args == s_.args:
        x = c_.args[0]
        if c_.op is Op.COS:
            return (graph.pi + (x if minus_s else -x)) if minus_c else (-x if minus_s else x)
        return (-quarter if minus_s else quarter) + (x if minus_c != minus_s else -x)
    if not has_symbols(c) and not has_symbols(s):
        turns = turns_of(c, s)
        if turns is not None:
            return graph.pi * (2 * turns)
    return graph.function(Op.ATAN2, s, c)


def _unsigned(node: Expr) -> tuple[bool, Expr]:
    return (True, node.args[0]) if node.op is Op.NEG else (False, node)
