"""The link frames that the generator chose, and the base parameters in them, as formulas to read.

A frame is a product of elementary motions from the one before it:

    T_pi = Rz(γ) Tz(ε) Rx(α) Tx(d) Rz(θ) Tz(r)       θ = θ0 + q (revolute) or r = r0 + q (prismatic)

γ and ε appear where a body carries several joints. Where no common normal could be had (see `reframe`), the shift is
Tx Ty Tz, and a declared rotation that no Rx replaces stands as a matrix.

Driving forces depend on the base parameters alone, which are formulas of the declared inertias:

    revolute joint k     mxR<k>, myR<k>                     first moments
                         XXR<k>                             I_xx - I_yy
                         XYR<k>, XZR<k>, YZR<k>, ZZR<k>     entries of the inertia matrix
    prismatic joint k    MR<k>, mxR<k>, myR<k>, mzR<k>      mass and first moments

Bodies that have these inertias in these frames, with I_xx = XX and m = h_z = I_yy = 0 on a revolute
joint and I = 0 on a prismatic one, move as the declared ones do. Parameters that no driving force depends on are left
out, such as all but ZZR of a first joint that turns about the direction of gravity.

    to the parent     m, h_z and diag(I_yy, I_yy, 0) of a body on a revolute joint, I of one on a prismatic joint, and
                      h_x, h_y where a prismatic joint slides along the only direction that the body can turn about

That is the choice of the literature; the recursions run over another one that is as good, J_zz = 0 in place of
I_yy = 0 (`regroup`).

Reference: Gautier and Khalil 1990; Khalil and Dombre (2002), section 9.4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

from symdyn.algebra import Form, Number
from symdyn.dynamics.mechanism.tree import Tree, has_symbols, in_fractions, settle, turns_of
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.links import GeneralTurn, JointTransform, Moments, PlanarTurn, moments_of
from symdyn.dynamics.recursive.reduced_tree import ReducedTree, reframe, settled, slides_along_all_turns
from symdyn.dynamics.recursive.tree_dynamics import rnea
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, evaluate, gradient, reachable, substitute
from symdyn.rounding import digits_or
from symdyn.scene import Scene
from symdyn.scene.joints import joint_motion
from symdyn.scene.values import Joint
from symdyn.spatial import Inertia, Mat, Transform

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
    """Return the frames of all moving bodies, the ground's side first; one an elementary joint."""
    w = Workspace(scene)
    framed = reframe(w.tree)
    joints = [joint for joint in scene.joints for _ in joint_motion(joint, w.graph).joints]
    still = dict.fromkeys(w.state.q, w.graph.zero)
    found = []
    for i, joint in enumerate(joints, start=1):
        p = framed.parent[i]
        steps = _steps(framed.X[i], framed.slides[i], w.tree.position[i], still)
        shown = tuple((kind, amounts) for kind, amounts in steps if not all(map(vanishes, amounts)))
        found.append(ChosenFrame(joint, joints[p - 1].name if p else Scene.GROUND, shown, framed.moved[i]))
    return tuple(found)


def _steps(X: JointTransform, slides: bool, position: Expr, still: dict[Expr, Expr]) -> Iterator[Step]:
    """Yield the steps of X, `still` being all coordinates at zero; its shift is turned into the frame behind γ."""
    turns, (x, y, z) = X.fixed, X.shift
    if turns and isinstance(gamma := turns[0], PlanarTurn) and gamma.k == 2:
        turns = turns[1:]
        x, y, z = gamma.out(X.shift)
        yield "Rz", (angle_of(gamma.cos, gamma.sin),)
    rise = X.offset
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
        yield "Rz", (angle_of(X.turn.cos, X.turn.sin),)
    else:
        c, s, start = substitute([X.turn.cos, X.turn.sin, position], still)
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


def formulas(values: Sequence[Expr], digits: int) -> list[Form]:
    """Return the values as formulas; zero is `Number(0)`. DerivationError where a root has no place in their ring.

    Numbers are exact, unless an angle among them has no exact sine (0.3 rad): then all are rounded to so many digits.
    """
    from symdyn.algebra import Compactor, TrigonometricRing

    odd = any(node.op.is_function and node.op is not Op.SQRT and not has_symbols(node) for node in reachable(values))
    values = in_fractions(values) if odd else values
    ring = TrigonometricRing(values)
    short, found = Compactor(ring), evaluate(values, ring, ring.values(values))
    if odd:
        found = [ring.in_digits(p, digits) for p in found]
    return [Number.ZERO if ring.is_zero(p) else short(p) for p in found]


def vanishes(value: Expr) -> bool:
    """Tell whether a value is zero, though its node may not show it."""
    return value.is_zero or (value.op not in (Op.CONSTANT, Op.SYMBOL) and formulas([value], 1) == [Number.ZERO])


TURNING = ("mx", "my", "XX", "XY", "XZ", "YZ", "ZZ")
SLIDING = ("M", "mx", "my", "mz")

DIGITS = 12


def base_parameters(scene: Scene) -> tuple[tuple[str, Expr], ...]:
    """Return name and formula of every base parameter, the ground's side first; kg, kg m and kg m^2.

    No driving force depends on anything else. On some arms with special lengths, or with a slide aslant to the one
    direction that they turn about, the number can be one or two smaller still; for the PUMA 560 these are its 36.
    """
    w = Workspace(scene)
    for parameter in scene.parameters:
        w.graph.symbol(parameter.name)  # before all else, so that forms print them in declared order
    framed = reframe(w.tree)
    names = [f"{name}R{k}" for k in framed.outward() for name in (SLIDING if framed.slides[k] else TURNING)]
    marks = [w.graph.symbol(f"mark of {name}") for name in names]
    forces = rnea(with_base_parameters(framed, marks), w.state.qd, w.state.qdd)
    columns = zip(*(gradient(force, marks) for force in forces), strict=True)
    felt = [any(not slope.is_zero for slope in column) for column in columns]
    found = zip(names, _grouped(w.tree, framed), felt, strict=True)
    return tuple((name, value) for name, value, needed in found if needed and not value.is_zero)


def base_parameter_forms(scene: Scene) -> tuple[tuple[str, Form], ...]:
    """Return the base parameters as `formulas` to read."""
    named = base_parameters(scene)
    forms = formulas([value for _, value in named], max(DIGITS, digits_or(DIGITS)))
    return tuple((name, form) for (name, _), form in zip(named, forms, strict=True) if form != Number.ZERO)


def with_base_parameters(tree: ReducedTree, values: Sequence[Expr]) -> ReducedTree:
    """Return the tree with bodies of these base parameters: seven a revolute joint, four a prismatic one, all named."""
    left, zero = iter(values), tree.graph.zero
    bodies = [moments_of(Inertia.none(tree.graph))]
    for k in tree.outward():
        if tree.slides[k]:
            m, x, y, z = islice(left, len(SLIDING))
            bodies.append(Moments(m, (x, y, z), Mat.symmetric(*(zero,) * 6)))
        else:
            x, y, xx, xy, xz, yz, zz = islice(left, len(TURNING))
            bodies.append(moments_of(Inertia(zero, (x, y, zero), Mat.symmetric(xx, zero, zz, xy, xz, yz))))
    return replace(tree, body=tuple(bodies))


def _grouped(tree: Tree, framed: ReducedTree) -> list[Expr]:
    """Return the values of all named parameters, those that nothing depends on included."""
    body = [inertia.seen_from(settled(T.inverse())) for inertia, T in zip(tree.inertia, framed.moved, strict=True)]
    values: list[list[Expr]] = [[] for _ in body]
    for k in framed.inward():
        kept, given = _split(body[k], framed.slides[k], slides_along_all_turns(framed, k))
        values[k], p = kept, framed.parent[k]
        body[p] = body[p] + given.seen_from(framed.X[k].fixed_part(framed.slides[k]).transform)
    return [value for kept in values for value in kept]


def _split(body: Inertia, slides: bool, along_all_turns: bool) -> tuple[list[Expr], Inertia]:
    """Return the named parameters of a body, and what its parent gets."""
    zero, (x, y, z) = body.m.graph.zero, body.h
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.I
    if slides and along_all_turns:
        return [body.m, zero, zero, z], Inertia(zero, (x, y, zero), body.I)
    if slides:
        return [body.m, x, y, z], Inertia(zero, (zero, zero, zero), body.I)
    kept = [x, y, xx - yy, xy, xz, yz, zz]
    return kept, Inertia(body.m, (zero, zero, z), Mat.symmetric(yy, yy, zero, zero, zero, zero))
