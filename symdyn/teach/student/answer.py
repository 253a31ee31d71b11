"""What became of one statement of a student's text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from symdyn.algebra import Form
from symdyn.emit.print import text_of
from symdyn.teach.student.differences import Difference
from symdyn.teach.student.mistakes import Mistake
from symdyn.verdict import HOLD

EQUAL = HOLD

ROUNDED, HOLDS, EMPTY = "rounded", "holds", "empty"


@dataclass(frozen=True)
class Answer:
    """What became of one statement.

    Attributes:
        line: where it stands, from 1.
        name: of the quantity, such as "k_z12", or "equation 2", "velocity row 1".
        verdict: one of `symdyn.verdict`, as of a finding; ROUNDED for equal to the digits written;
            HOLDS for a row that is none of the scene's, but true wherever the loops are closed; EMPTY for what names
            quantities in place of formulas, such as L = K - P.
        error_log10: log10 of the probability that a wrong formula would pass; 0 when not proved.
        differences: term by term; none where it is right or where no term can be told.
        turned: whether all of it has the opposite sign.
        shifted: by how much a potential energy lies elsewhere, which is free; None for not at all.
        scaled: whether an equation is the scene's times a factor.
        valued: parameters in whose place the formula has the scene's numbers.
        multiplied: multipliers that stand in an energy, each times a condition, as they may.
        forgotten: the coordinate q whose -dK/dq is all that is missing; "" for none.
        mistake: the rule that was forgotten, None for none.
    """

    line: int
    name: str
    verdict: str
    error_log10: float = 0.0
    differences: tuple[Difference, ...] = ()
    turned: bool = False
    shifted: Form | None = None
    scaled: bool = False
    valued: tuple[str, ...] = ()
    multiplied: tuple[str, ...] = ()
    forgotten: str = ""
    mistake: Mistake | None = None

    @property
    def right(self) -> bool:
        """Whether the statement is true."""
        return self.verdict in (*EQUAL, ROUNDED, HOLDS)

    def as_dict(self) -> dict[str, Any]:
        """Return what became of one statement, for JSON; formulas as text."""

        def formula(form: Form | None) -> str | None:
            return None if form is None else text_of(form)

        differences = [
            {"kind": one.kind, "found": formula(one.found), "right": formula(one.right), "symbols": list(one.symbols)}
            for one in self.differences
        ]
        told = {name: getattr(self, name) for name in ("line", "name", "verdict", "right", "error_log10", "turned")}
        told |= {
            "shifted": formula(self.shifted),
            "scaled": self.scaled,
            "valued": list(self.valued),
            "multiplied": list(self.multiplied),
        }
        return told | {"forgotten": self.forgotten, "differences": differences}
