"""The numbers of a table of joints: exact, or to 50 digits and more."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from symdyn.dynamics import JointTable
from symdyn.graph import Expr, Graph, Op, reachable, substitute
from symdyn.program.constants import constants
from symdyn.scene import Scene


@dataclass(frozen=True)
class TableNumbers:
    """The numbers of a table.

    Attributes:
        table: the joints.
        scene: the mechanism, which has the values of parameters.
        MOMENTS: numbers of a body that a row of code has room for.
    """

    table: JointTable
    scene: Scene

    MOMENTS: ClassVar[int] = 7

    def in_order(self) -> list[Fraction]:
        """Return them as tables of code have them, rows of one length: the ground, the rows, and the matrices.

        A row whose fixed turn is a matrix has cosine and sine of no turn; what a slide has no moments for is zero.
        """
        numbers = iter(self.every())
        found, matrices = [next(numbers) for _ in self.table.ground], list[Fraction]()
        for row in self.table.rows:
            here = [next(numbers) for _ in row.entries]
            turn, rest = here[: len(row.fixed)], here[len(row.fixed) :]
            found += turn if len(turn) == 2 else [Fraction(1), Fraction(0)]
            matrices += turn if len(turn) > 2 else []
            found += [*rest, *[Fraction(0)] * (self.MOMENTS - len(row.moments))]
        return found + matrices

    def every(self) -> list[Fraction]:
        """Return the acceleration of the ground and then every entry of every row, parameters with their values.

        Raises:
            DerivationError: one of them is not a finite real number.
        """
        entries = [*self.table.ground, *(x for row in self.table.rows for x in row.entries)]
        values = {one.name: one.value for one in self.scene.parameters if one.value is not None}
        graph = Graph()
        bound: dict[Expr, Expr] = {
            node: values[str(node.value)].express(graph) for node in reachable(entries) if node.op is Op.SYMBOL
        }
        found = substitute(entries, bound, graph)
        known = constants(found)
        return [known[node] for node in found]
