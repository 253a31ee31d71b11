"""A tree of turns and slides as a table, which a loop over its joints reads.

A row says how frame i lies in frame p and what base parameters body i has, in the frames of the reduced tree:

    T_pi = T(shift) · fixed · Rz(θ0 + q) Tz(rise)      a turn;   a slide has Rz(θ0) Tz(rise + q)

What a turn does not feel, m, h_z and J_zz, and what a slide does not, J, stand in no row (`reduced_tree`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from symdyn.algebra import constants
from symdyn.dynamics.mechanism.tree import build_tree
from symdyn.dynamics.recursive.links import Link, PlanarTurn
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.graph import Expr, Graph, Op, reachable, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Joint
from symdyn.spatial import Vec, neg, zero_vector


@dataclass(frozen=True)
class JointRow:
    """One joint; see the module's legend. Lengths in m, masses in kg.

    Attributes:
        parent: number of the body that carries it, from 1; 0 is the ground.
        slides: whether it is prismatic.
        fixed: cosine and sine of a turn about x, or nine entries of a matrix that takes frame i to frame p.
        shift: origin of the joint in frame p.
        zero: cosine and sine of θ0.
        rise: along z afterwards.
        rotor: inertia of its rotor, seen at the joint, kg m^2 or kg.
        moments: h_x, h_y, J_xx, J_yy, J_xy, J_xz, J_yz of a turn; m, h_x, h_y, h_z of a slide.
    """

    parent: int
    slides: bool
    fixed: tuple[Expr, ...]
    shift: Vec
    zero: tuple[Expr, Expr]
    rise: Expr
    rotor: Expr
    moments: tuple[Expr, ...]

    @property
    def at_zero(self) -> bool:
        """Whether θ0 is zero."""
        return self.zero[1].is_zero and self.zero[0] is self.zero[0].graph.one

    @property
    def entries(self) -> tuple[Expr, ...]:
        """Every number of the row."""
        return (*self.fixed, *self.shift, *self.zero, self.rise, self.rotor, *self.moments)


@dataclass(frozen=True)
class JointTable:
    """The rows of joints 1..n, parents first, and the acceleration of the ground, m/s^2, which is -g."""

    ground: Vec
    rows: tuple[JointRow, ...]

    MOMENTS: ClassVar[int] = 7
    """Numbers of a body that a row of code has room for."""

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


def lacking(scene: Scene) -> str:
    """Return what a scene has that no row holds, in words; "" where a table holds all of it."""
    tree = build_tree(scene, Graph())
    shared = tree.coupled or tree.balls or any(tree.b) or any(len(block) > 1 for block in tree.block)
    reasons = {
        "loops or rows close it": scene.is_closed,
        "parameters have no value": scene.free_parameters,
        "springs, dampers or loads act on it": scene.struts or scene.loads,
        "friction, damping or declared forces act at its joints": any(map(_resists, scene.joints)),
        "motions are prescribed": any(joint.motion is not None for joint in scene.joints),
        "balls, screws or joints that follow others are no turns and slides": shared,
        "nothing moves": len(tree.parent) < 2,
    }
    return next((words for words, found in reasons.items() if found), "")


def _resists(joint: Joint) -> bool:
    return bool(joint.forces) or joint.dry is not None or joint.damping != Quantity.ZERO


def joint_table(tree: ReducedTree, position: Sequence[Expr]) -> JointTable:
    """Return the table of a reduced tree that lacks nothing; `position` are the coordinates, shape (n,)."""
    graph = tree.graph
    still = dict.fromkeys(position, graph.zero)
    moving = [(link.turn.cos, link.turn.sin, link.rise) for link in tree.link]
    at_zero = substitute([x for one in moving for x in one], still)
    rows = []
    for i in tree.outward():
        body, (xx, xy, xz), (_, yy, yz) = tree.body[i], *tree.body[i].J[:2]
        c, s, rise = at_zero[3 * i : 3 * i + 3]
        kept = (body.m, *body.h) if tree.slides[i] else (*body.h[:2], xx, yy, xy, xz, yz)
        link, slides = tree.link[i], tree.slides[i]
        rows.append(
            JointRow(tree.parent[i], slides, _fixed(link), link.shift, (c, s), rise, tree.armature[i], tuple(kept))
        )
    return JointTable(neg(tree.gravity), tuple(rows))


def _fixed(link: Link) -> tuple[Expr, ...]:
    """Return the fixed turns of a link as one, about x where that is all there is."""
    graph = link.rise.graph
    if not link.fixed:
        return graph.one, graph.zero
    (first, *more) = link.fixed
    if isinstance(first, PlanarTurn) and first.k == 0 and not more:
        return first.cos, first.sin
    R = Link(zero_vector(graph), link.fixed, PlanarTurn(2, graph.one, graph.zero), graph.zero).transform.R
    return (*R[0], *R[1], *R[2])
