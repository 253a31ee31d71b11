"""A joint type from outside: a pinion that rolls along a rack, x = r φ. One coordinate, class t = 5.

The rack is the x axis of the joint frame, shifted by r along y; the pinion turns about z.
"""

from __future__ import annotations

from symdyn.graph import Expr, Graph, Op
from symdyn.scene import Quantity
from symdyn.scene.joints import JOINTS, JointBlock, JointMotion, MarkPart
from symdyn.scene.joints.blocks import forces, leaning, moments, offsets
from symdyn.scene.joints.joint_kind import ElementaryJoint, Forbids, JointKind, JointMark
from symdyn.scene.values import Joint, folding
from symdyn.scene.values.entry import EntryReader
from symdyn.scene.values.key import Key
from symdyn.spatial import Mat, Transform, Wrench, dot, scale

RADIUS = Key(
    "radius",
    EntryReader.quantity,
    Quantity.number(0),
    example="radius = 0.1, that of the pitch circle in metres",
    above_zero="is that of no pinion; give that of the pitch circle",
    letters=("rp",),
    unit="m",
    text="pitch radius of {}",
    positive=True,
    geometry=True,
)


def _blocks(joint: Joint) -> tuple[JointBlock, ...]:
    def motion(graph: Graph, q: tuple[Expr, ...], u: tuple[Expr, ...]) -> JointMotion:
        (x, _, z), still, r = Mat.identity(graph), Transform.unit(graph), RADIUS.of(joint).express(graph)
        rolls = ElementaryJoint(True, x, r * q[0], still, ((0, r),))
        return JointMotion((rolls, ElementaryJoint(False, z, q[0], still, ((0, graph.one),))), still, u)

    return (JointBlock(("rad",), ("rad",), motion),)


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    x, y, z = Mat.identity(X.p[0].graph)
    return forces(y, z) + moments(x, y) + (Wrench(x, scale(-RADIUS.of(joint).express(x[0].graph), z)),)


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    graph = X.p[0].graph
    x, y, z = Mat.identity(graph)
    angle = graph.function(Op.ATAN2, X.R[1][0], X.R[0][0])
    return (*offsets(X, y, z), *leaning(X, z, x, y), dot(x, X.p) - RADIUS.of(joint).express(graph) * angle)


def _held(joint: Joint, angle: Quantity) -> tuple[tuple[str, Quantity], ...]:
    return (("Tx", folding.mul(RADIUS.of(joint), angle)), ("Rz", angle))


JOINTS["rack_and_pinion"] = JointKind(
    keys=(RADIUS,),
    blocks=_blocks,
    forbids=Forbids(_wrenches, _residual),
    words={"en": "rack and pinion", "sk": "pastorok na ozubenom hrebeni"},
    mark=JointMark(
        (MarkPart("rail", way="x"), MarkPart("cylinder", 0.5, "z")), flat=(MarkPart("rail", way="x"), MarkPart("ring"))
    ),
    held=_held,
)
