"""Where a placement puts the origin of its frame, in formulas; quarters of a turn stay exact."""

from __future__ import annotations

from fractions import Fraction

from symdyn.graph import Op
from symdyn.scene.values.folding import add, function, mul, neg
from symdyn.scene.values.model import Pose
from symdyn.scene.values.quantity import NULL, ONE, PI, ZERO, Vector, number


def translation(pose: Pose) -> Vector:
    """Return where a placement puts the origin, m."""
    r = list(NULL)
    for kind, amount in reversed(pose.steps):
        k = "xyz".index(kind[1])
        if kind[0] == "T":
            r[k] = add(r[k], amount)
            continue
        i, j = (k + 1) % 3, (k + 2) % 3
        if r[i] == r[j] == ZERO:
            continue
        c, s = _QUARTERS.get(amount) or (function(Op.COS, amount), function(Op.SIN, amount))
        r[i], r[j] = add(mul(c, r[i]), neg(mul(s, r[j]))), add(mul(s, r[i]), mul(c, r[j]))
    return (r[0], r[1], r[2])


_MINUS = number(-1)

_QUARTERS = {  # cosine and sine, exact
    mul(number(Fraction(k, 2)), PI): pair
    for k, pair in ((-2, (_MINUS, ZERO)), (-1, (ZERO, _MINUS)), (1, (ZERO, ONE)), (2, (_MINUS, ZERO)))
}
