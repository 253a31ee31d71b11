"""Kinds of rows in tables of joints: what all rows of a kind have in common costs loops over such a table nothing.

A right angle, no shift, no rotor are no symbols but written out; what else a row says are symbols, called as below.

    cosine, sine                    of the turn of the joint, which c0, s0 have at zero
    c, s, matrix0 ..                a fixed turn about x, or any
    x, y, z, rise, rotor, b0 ..     as in a row of the table
    q, qd, qdd, tau                 of the joint
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.dynamics.recursive.joint_table import JointRow, JointTable
from symdyn.dynamics.recursive.link_motion import LinkMotion
from symdyn.dynamics.recursive.links import GeneralTurn, Link, PlanarTurn, Turn
from symdyn.dynamics.recursive.moments import Moments
from symdyn.graph import Expr, Graph
from symdyn.spatial import Mat, Vec, zero_vector

NO_TURN, RIGHT, LEFT, ABOUT_X, ANY = "none", "right", "left", "x", "any"
"""Fixed turns: none, by ±90° about x, by another angle about x, by a matrix."""

MOTION, ORIGIN = 18, 6
"""Numbers of a motion (w, dw, a, U), and where a begins."""

MOST_KINDS = 8
"""Kinds of joints that a mechanism may have before they are told apart by fewer of their numbers."""


@dataclass(frozen=True, order=True)
class RowKind:
    """What all rows of a kind have in common.

    Attributes:
        slides: whether it is prismatic.
        fixed: of the fixed turns above.
        shift: how many numbers the shift has, from the first on.
        rises: whether there is a rise along z, which slides have.
        rotor: whether there is a rotor.
    """

    slides: bool
    fixed: str
    shift: int
    rises: bool
    rotor: bool


def kinds_of(table: JointTable) -> list[RowKind]:
    """Return the kind of every row; of many kinds those become one that differ in zeros alone."""
    found = [_kind(row) for row in table.rows]
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
    rises = row.slides or not row.rise.is_zero
    return RowKind(row.slides, fixed, shift if along_x else 3, rises, not row.rotor.is_zero)


def names_of(row: JointRow) -> list[str]:
    """Return what steps call the entries of a row, in their order."""
    turn = [f"matrix{k}" for k in range(9)] if len(row.fixed) > 2 else ["c", "s"]
    return [*turn, "x", "y", "z", "c0", "s0", "rise", "rotor", *(f"b{k}" for k in range(len(row.moments)))]


def link_of(kind: RowKind, graph: Graph) -> Link:
    """Return the link of a row of a kind, in symbols."""
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
    rise = graph.symbol("rise") if kind.rises else zero
    return Link((x, y, z), turns[kind.fixed], turn, rise + graph.symbol("q") if kind.slides else rise)


def body_of(kind: RowKind, graph: Graph) -> Moments:
    """Return the body of a row: what its joint does not feel stands with its parent."""
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
