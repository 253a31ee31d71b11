"""A tree of revolute and prismatic joints as a table, which a loop over its joints reads.

A row holds the placement of frame i in frame p and the base parameters of body i, in the frames of the reduced tree:

    T_pi = T(shift) · fixed · Rz(θ0 + q) Tz(offset)      a turn;   a slide has Rz(θ0) Tz(offset + q)

No row holds what exerts no force on a turn (m, h_z and J_zz) or on a slide (J), see `reduced_tree`.

Rows are of kinds. What all rows of a kind have in common (a right angle, no shift, no rotor) is written out and costs
the loop nothing; what differs is a symbol:

    cosine, sine                    of the turn of the joint, which c0, s0 have at zero
    c, s, matrix0 ..                a fixed turn about x, or any
    x, y, z, offset, rotor, b0 ..     as in a row of the table
    q, qd, qdd, tau                 of the joint
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import ClassVar

from symdyn.algebra import constants
from symdyn.dynamics.mechanism.tree import Tree, build_tree
from symdyn.dynamics.recursive.links import GeneralTurn, JointTransform, LinkMotion, Moments, PlanarTurn, Turn
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, reachable, substitute
from symdyn.scene import Quantity, Scene
from symdyn.spatial import Mat, Vec, neg, zero_vector


@dataclass(frozen=True)
class JointRow:
    """One joint; see the module's legend. Lengths in m, masses in kg.

    Attributes:
        parent: number of the body that carries it, from 1; 0 is the ground.
        slides: whether it is prismatic.
        fixed: cosine and sine of a turn about x, or nine entries of a matrix that takes frame i to frame p.
        shift: origin of the joint in frame p.
        zero: cosine and sine of θ0.
        offset: along z afterwards.
        rotor: inertia of its rotor, seen at the joint, kg m^2 or kg.
        moments: h_x, h_y, J_xx, J_yy, J_xy, J_xz, J_yz of a turn; m, h_x, h_y, h_z of a slide.
    """

    parent: int
    slides: bool
    fixed: tuple[Expr, ...]
    shift: Vec
    zero: tuple[Expr, Expr]
    offset: Expr
    rotor: Expr
    moments: tuple[Expr, ...]

    @property
    def at_zero(self) -> bool:
        return self.zero[1].is_zero and self.zero[0] is self.zero[0].graph.one

    @property
    def entries(self) -> tuple[Expr, ...]:
        return (*self.fixed, *self.shift, *self.zero, self.offset, self.rotor, *self.moments)


@dataclass(frozen=True)
class JointTable:
    """The rows of joints 1..n, parents first, and the acceleration of the ground, m/s^2, which is -g."""

    ground: Vec
    rows: tuple[JointRow, ...]

    MOMENTS: ClassVar[int] = 7
    """Numbers of a body that a row of code has room for."""

    @property
    def carried(self) -> list[int]:
        """How many joints each of them carries, itself among them."""
        many = [1] * (len(self.rows) + 1)
        for i in range(len(self.rows), 0, -1):
            many[self.rows[i - 1].parent] += many[i]
        return many[1:]

    def numbers(self, scene: Scene) -> list[Fraction]:
        """Return the acceleration of the ground and then every entry of every row, parameters with their values.

        Numbers are exact, or to 50 digits and more.

        Raises:
            DerivationError: one of them is not a finite real number.
        """
        entries = [*self.ground, *(x for row in self.rows for x in row.entries)]
        values = {one.name: one.value for one in scene.parameters if one.value is not None}
        graph = Graph()
        bound: dict[Expr, Expr] = {
            node: values[str(node.value)].express(graph) for node in reachable(entries) if node.op is Op.SYMBOL
        }
        found = substitute(entries, bound, graph)
        known = constants(found)
        return [known[node] for node in found]

    def in_order(self, scene: Scene) -> list[Fraction]:
        """Return the numbers as tables of code have them, rows of one length: the ground, the rows, and the matrices.

        A row whose fixed turn is a matrix has cosine and sine of no turn; what a slide has no moments for is zero.
        """
        numbers = iter(self.numbers(scene))
        found, matrices = [next(numbers) for _ in self.ground], list[Fraction]()
        for row in self.rows:
            here = [next(numbers) for _ in row.entries]
            turn, rest = here[: len(row.fixed)], here[len(row.fixed) :]
            found += turn if len(turn) == 2 else [Fraction(1), Fraction(0)]
            matrices += turn if len(turn) > 2 else []
            found += [*rest, *[Fraction(0)] * (self.MOMENTS - len(row.moments))]
        return found + matrices


@lru_cache(maxsize=4)
def tree_alone(scene: Scene) -> Tree:
    """Return the kinematic tree of a scene on a graph of its own, which several ask in a row what kind it is of."""
    return build_tree(scene, Graph())


def lacking(scene: Scene) -> str:
    """Return what a scene has that no row holds, in words; "" where a table holds all of it."""
    tree = tree_alone(scene)
    shared = tree.coupled or tree.spherical_rotors or any(tree.b) or any(len(block) > 1 for block in tree.block)
    reasons = {
        "loops or rows close it": scene.is_constrained,
        "parameters have no value": scene.free_parameters,
        "springs, dampers or loads act on it": scene.struts or scene.loads,
        "friction, damping or declared forces act at its joints": any(
            joint.forces or joint.dry is not None or joint.damping != Quantity.ZERO for joint in scene.joints
        ),
        "motions are prescribed": any(joint.motion is not None for joint in scene.joints),
        "spherical, helical or coupled joints are neither revolute nor prismatic": shared,
        "nothing moves": len(tree.parent) < 2,
    }
    return next((words for words, found in reasons.items() if found), "")


def joint_table(tree: ReducedTree, position: Sequence[Expr]) -> JointTable:
    """Return the table of a reduced tree that lacks nothing; `position` are the coordinates, shape (n,)."""
    graph = tree.graph
    zero_position = dict.fromkeys(position, graph.zero)
    moving = [(X.turn.cos, X.turn.sin, X.offset) for X in tree.X]
    at_zero = substitute([x for one in moving for x in one], zero_position)
    rows = []
    for i in tree.outward():
        body, (xx, xy, xz), (_, yy, yz) = tree.body[i], *tree.body[i].J[:2]
        c, s, offset = at_zero[3 * i : 3 * i + 3]
        kept = (body.m, *body.h) if tree.slides[i] else (*body.h[:2], xx, yy, xy, xz, yz)
        X, slides = tree.X[i], tree.slides[i]
        rows.append(JointRow(tree.parent[i], slides, _fixed(X), X.shift, (c, s), offset, tree.armature[i], tuple(kept)))
    return JointTable(neg(tree.gravity), tuple(rows))


def _fixed(X: JointTransform) -> tuple[Expr, ...]:
    """Return the fixed turns of a transform as one, about x where that is all there is."""
    graph = X.offset.graph
    if not X.fixed:
        return graph.one, graph.zero
    (first, *more) = X.fixed
    if isinstance(first, PlanarTurn) and first.k == 0 and not more:
        return first.cos, first.sin
    R = JointTransform(zero_vector(graph), X.fixed, PlanarTurn(2, graph.one, graph.zero), graph.zero).transform.R
    return (*R[0], *R[1], *R[2])


NO_TURN, RIGHT, LEFT, ABOUT_X, ANY = "none", "right", "left", "x", "any"
"""Fixed turns: none, by ±90° about x, by another angle about x, by a matrix."""

MOTION, ORIGIN = 18, 6
"""Numbers of a motion (w, dw, a, U), and where a begins."""

MOST_KINDS = 8
"""Kinds of joints that a mechanism may have before they are told apart by fewer of their numbers."""


@dataclass(frozen=True, order=True)
class RowKind:
    """What all rows of a kind have in common."""

    slides: bool  # whether it is prismatic
    fixed: str  # of the fixed turns above
    shift: int  # how many numbers the shift has, from the first on
    has_offset: bool  # whether there is an offset along z, which prismatic joints have
    rotor: bool  # whether there is a rotor


def kinds_of(table: JointTable, few: bool = False) -> list[RowKind]:
    """Return the kind of every row; of many kinds those become one that differ in zeros alone.

    Where they shall be `few`, turns about x by several angles are of one kind, whatever the angles.
    """
    found = [_kind(row) for row in table.rows]
    if few and len({one.fixed for one in found} - {ANY}) > 1:
        found = [replace(one, fixed=ANY if one.fixed == ANY else ABOUT_X) for one in found]
    if len(set(found)) > MOST_KINDS:
        return [RowKind(one.slides, one.fixed, 3, True, True) for one in found]
    return found


def _kind(row: JointRow) -> RowKind:
    turn, shift = row.fixed, sum(not x.is_zero for x in row.shift)
    if len(turn) > 2:
        fixed = ANY
    elif turn[0].is_zero and turn[1].value in (1, -1):
        fixed = RIGHT if turn[1].value == 1 else LEFT
    else:
        fixed = NO_TURN if turn[1].is_zero and turn[0] is turn[0].graph.one else ABOUT_X
    along_x = shift == 0 or (shift == 1 and not row.shift[0].is_zero)
    has_offset = row.slides or not row.offset.is_zero
    return RowKind(row.slides, fixed, shift if along_x else 3, has_offset, not row.rotor.is_zero)


def names_of(row: JointRow) -> list[str]:
    """Return what steps call the entries of a row, in their order."""
    turn = [f"matrix{k}" for k in range(9)] if len(row.fixed) > 2 else ["c", "s"]
    return [*turn, "x", "y", "z", "c0", "s0", "offset", "rotor", *(f"b{k}" for k in range(len(row.moments)))]


def transform_of(kind: RowKind, graph: Graph) -> JointTransform:
    """Return the transform of a row of a kind, in symbols."""
    zero, one = graph.zero, graph.one
    matrix = vectors(symbols(graph, "matrix", 9))
    turns: dict[str, tuple[Turn, ...]] = {
        NO_TURN: (),
        RIGHT: (PlanarTurn(0, zero, one),),
        LEFT: (PlanarTurn(0, zero, -one),),
        ABOUT_X: (PlanarTurn(0, graph.symbol("c"), graph.symbol("s")),),
        ANY: (GeneralTurn(Mat(matrix)),),
    }
    x, y, z = (graph.symbol(name) if k < kind.shift else zero for k, name in enumerate("xyz"))
    turn = PlanarTurn(2, graph.symbol("cosine"), graph.symbol("sine"))
    offset = graph.symbol("offset") if kind.has_offset else zero
    return JointTransform((x, y, z), turns[kind.fixed], turn, offset + graph.symbol("q") if kind.slides else offset)


def body_of(kind: RowKind, graph: Graph) -> Moments:
    """Return the body of a row: what exerts no force on its joint stands with its parent."""
    b, zero = symbols(graph, "b", 7), graph.zero
    if kind.slides:
        return Moments(b[0], (b[1], b[2], b[3]), Mat((zero_vector(graph),) * 3))
    return Moments(zero, (b[0], b[1], zero), Mat.symmetric(b[2], b[3], zero, b[4], b[5], b[6]))


def rotor_of(kind: RowKind, graph: Graph) -> Expr:
    """Return the rotor of a row."""
    return graph.symbol("rotor") if kind.rotor else graph.zero


def motion_of(graph: Graph, name: str) -> LinkMotion:
    """Return the motion of a parent, of symbols with this name."""
    w, dw, a, *U = vectors(symbols(graph, name, MOTION))
    return LinkMotion(w, dw, a, Mat(U))


def symbols(graph: Graph, name: str, many: int) -> list[Expr]:
    """Return so many symbols that begin with a name."""
    return [graph.symbol(f"{name}{k}") for k in range(many)]


def vectors(entries: Sequence[Expr]) -> list[Vec]:
    """Return entries as vectors."""
    return [(entries[k], entries[k + 1], entries[k + 2]) for k in range(0, len(entries), 3)]


def flat(*rows: Vec) -> tuple[Expr, ...]:
    """Return the entries of vectors."""
    return tuple(x for row in rows for x in row)
