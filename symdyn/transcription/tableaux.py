"""The methods of collocation: Runge-Kutta methods whose stages are the places where the dynamics holds.

    c        stages within an interval, 0 … 1
    A, b     stage i: y_i = y_0 + h Σ A_ij f_j; end: y_1 = y_0 + h Σ b_j f_j
    order    p, with which a smooth solution's error falls: h^p

A first stage at 0 and a last one at 1 are the interval's ends, and its neighbours have them too. Simpson's rule and the
cubic through the ends, (y_0 + y_1) / 2 + h (f_0 - f_1) / 8 in the middle, are A and b of Lobatto IIIA with three
stages: Hermite-Simpson collocation, in its separated form, where the middle is an unknown.

References: Hargraves and Paris, Direct trajectory optimization using nonlinear programming and collocation, J. Guidance
10 (1987) 338; Betts, Practical Methods for Optimal Control (2010), sections 4.5 and 4.6; Kelly, An introduction to
trajectory optimization, SIAM Review 59 (2017) 849, sections 3 and 4; Hairer and Wanner, Solving Ordinary Differential
Equations II (1996), tables IV.5.1 (Gauss), IV.5.7 (Lobatto IIIA).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

Row = tuple[Fraction, ...]


@dataclass(frozen=True)
class Method:
    """A method of collocation.

    Attributes:
        text: what it is.
        c, b: shape (s,).
        A: shape (s, s).
        order: p.
    """

    text: str
    c: Row
    A: tuple[Row, ...]
    b: Row
    order: int

    @property
    def starts(self) -> bool:
        """Whether the first stage is the interval's start."""
        return self.c[0] == 0

    @property
    def ends(self) -> bool:
        """Whether the last stage is the interval's end."""
        return self.c[-1] == 1

    @property
    def inner(self) -> range:
        """The stages between the ends."""
        return range(int(self.starts), len(self.c) - int(self.ends))


def _row(text: str) -> Row:
    return tuple(map(Fraction, text.split()))


def _method(text: str, order: int, c: str, A: Sequence[str], b: str) -> Method:
    return Method(text, _row(c), tuple(map(_row, A)), _row(b), order)


METHODS: dict[str, Method] = {
    "trapezoidal": _method(
        "the trapezoidal rule, Lobatto IIIA with two stages", 2, "0 1", ("0 0", "1/2 1/2"), "1/2 1/2"
    ),
    "hermite_simpson": _method(
        "Hermite-Simpson, separated; Lobatto IIIA with three stages",
        4,
        "0 1/2 1",
        ("0 0 0", "5/24 1/3 -1/24", "1/6 2/3 1/6"),
        "1/6 2/3 1/6",
    ),
    "implicit_midpoint": _method("the implicit midpoint rule, Gauss with one stage", 2, "1/2", ("1/2",), "1"),
}
"""By the name that `symdyn.collocation` takes."""
