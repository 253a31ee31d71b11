"""Sines and cosines that are shorter than doubles allow: a row for every accuracy that `--accuracy` takes.

    n = round(2x/π),   y = x - n π/2                 |y| ≤ π/4, one product; 2⁻⁵³ |x| and n times the rest of π/2 off
    sin y = y + y³ S(y²),   cos y = 1 + y² C(y²)     as `benchmarks/minimax.py` prints them

The bound of a row holds whether sums and products are fused or not: `tests/test_short_sines.py` proves it by balls, the
polynomials, every rounding and the reduction. It is absolute; near multiples of π/2 that are not zero few digits of a
small sine are right.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symdyn.errors import EmitError


@dataclass(frozen=True)
class ShortSines:
    """How sines and cosines of one accuracy are computed.

    Attributes:
        accuracy: what `--accuracy` calls it: about what functions are right to, relative to their largest entry.
        real: type of all numbers.
        bound: no sine or cosine is farther than this from that of the same angle.
        limit_exponent: angles below 2 to this in size are reduced here, others by the C library.
        half_pi: the double next to π/2.
        sine: coefficients of S, lowest power first.
        cosine: those of C.
    """

    accuracy: str
    real: str
    bound: float
    limit_exponent: int
    half_pi: float
    sine: tuple[float, ...]
    cosine: tuple[float, ...]

    @classmethod
    def accuracies(cls) -> tuple[str, ...]:
        """Return those that there are."""
        return tuple(SHORT_SINES)

    @classmethod
    def find(cls, accuracy: str, real: str = "") -> ShortSines | None:
        """Return the sines of an accuracy, None for "": as near as the type allows. Type "" is that of the sines.

        Raises:
            EmitError: there is no such accuracy, or not of this type.
        """
        if not accuracy:
            return None
        known = " or ".join(map(repr, SHORT_SINES))
        if accuracy not in SHORT_SINES:
            raise EmitError(
                f"accuracy {accuracy!r} is not known; give {known}, or leave it out for about 1e-16, in float 1e-7"
            )
        row = SHORT_SINES[accuracy]
        if real not in ("", row.real):
            raise EmitError(f"accuracy {accuracy} is one of {row.real}, not of {real}; leave one of both out")
        return row

    @property
    def description(self) -> str:
        """What files say of it."""
        return (
            f"Accuracy {self.accuracy}: where angles are taken in rows (of many states, or three and more of one) each "
            f"sine and cosine\nis within {self.bound:.0e} of the true one, below {2**self.limit_exponent} rad in size. "
            "Others are the C library's."
        )


SHORT_SINES: Mapping[str, ShortSines] = {
    row.accuracy: row
    for row in (
        ShortSines(
            accuracy="1e-10",
            real="double",
            bound=8e-12,
            limit_exponent=15,
            half_pi=1.5707963267948966,
            sine=(
                -0.16666666627998725,
                0.00833332823869236,
                -0.0001983904376548974,
                2.716013980798435e-06,
            ),
            cosine=(
                -0.499999999995451,
                0.04166666656208085,
                -0.0013888881078919053,
                2.4799041081799083e-05,
                -2.718010367936957e-07,
            ),
        ),
    )
}


def bound_of_sines(accuracy: str) -> float:
    """Return how far a sine may be off beside its rounding, absolutely; 0 for "".

    Raises:
        EmitError: there is no such accuracy.
    """
    row = ShortSines.find(accuracy)
    return row.bound if row else 0.0
