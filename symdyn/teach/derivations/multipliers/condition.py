"""One condition that ties coordinates: a row of a loop, of a contact, or of the scene."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.graph import Expr


@dataclass(frozen=True)
class Condition:
    """One condition.

    Attributes:
        number: "1", its index in print.
        owner: name of the loop or of the scene's row.
        loop: whether a loop has it; else a contact or a formula of the scene.
        words: key of the sentence about its multiplier.
        axis: x, y or z in that sentence, or "".
        parent, child: bodies on both sides; "" where there are none.
        residual: what it keeps zero; None where it holds velocities alone.
        slopes: A_ki, shape (nv,).
        bias: Ȧ_ki u_i.
        shown: slopes, bias and residual where they are written in letters of the lesson, else ().
    """

    number: str
    owner: str
    loop: bool
    words: str
    axis: str
    parent: str
    child: str
    residual: Expr | None
    slopes: tuple[Expr, ...]
    bias: Expr
    shown: tuple[Expr, ...] = ()

    @property
    def nodes(self) -> tuple[Expr, ...]:
        """Slopes, bias and residual as they are written."""
        return self.shown or (*self.slopes, self.bias, *(() if self.residual is None else (self.residual,)))

    @property
    def key(self) -> str:
        """Key of its name: f where it holds a position, s where velocities alone."""
        return f"s:{self.number}" if self.residual is None else f"f:{self.number}"

    @property
    def rate(self) -> str:
        """Key of what it says of the velocities."""
        return self.key if self.residual is None else f"df:{self.number}"

    @property
    def acceleration(self) -> str:
        """Key of what it says of the accelerations."""
        return f"d{self.rate}"
