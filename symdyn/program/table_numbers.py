"""The numbers of a table of joints: exact, or to 50 digits and more."""

from __future__ import annotations

from fractions import Fraction

from symdyn.dynamics import JointTable
from symdyn.graph import Expr, Graph, Op, reachable, substitute
from symdyn.program.constants import constants
from symdyn.scene import Scene

MOMENTS = 7
"""Numbers of a body that a row has room for."""


def table_in_order(table: JointTable, scene: Scene) -> list[Fraction]:
    """Return the numbers as tables of code have them, rows of one length: the ground, the rows, and the matrices.

    A row whose fixed turn is a matrix has cosine and sine of no turn; what a slide has no moments for is zero.
    """
    numbers = iter(table_numbers(table, scene))
    found, matrices = [next(numbers) for _ in table.ground], list[Fraction]()
    for row in table.rows:
        here = [next(numbers) for _ in row.entries]
        turn, rest = here[: len(row.fixed)], here[len(row.fixed) :]
        found += turn if len(turn) == 2 else [Fraction(1), Fraction(0)]
        matrices += turn if len(turn) > 2 else []
        found += [*rest, *[Fraction(0)] * (MOMENTS - len(row.moments))]
    return found + matrices


def table_numbers(table: JointTable, scene: Scene) -> list[Fraction]:
    """Return the acceleration of the ground and then every entry of every row, parameters with their values.

    Raises:
        DerivationError: one of them is not a finite real number.
    """
    entries = [*table.ground, *(x for row in table.rows for x in row.entries)]
    values = {one.name: one.value for one in scene.parameters if one.value is not None}
    graph = Graph()
    bound: dict[Expr, Expr] = {
        node: values[str(node.value)].express(graph) for node in reachable(entries) if node.op is Op.SYMBOL
    }
    found = substitute(entries, bound, graph)
    known = constants(found)
    return [known[node] for node in found]
