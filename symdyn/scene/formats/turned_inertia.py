"""An inertia matrix seen from turned axes: R I Rᵀ, one elementary rotation after the other."""

from __future__ import annotations

from symdyn.graph import Graph, Op
from symdyn.scene.values import folding
from symdyn.scene.values.quantity import Quantity, Vector, express, number

Entries = tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]

_KEYS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def turned(entries: Entries, rpy: Vector) -> Entries:
    """Return R I Rᵀ with R = Rz(yaw) Ry(pitch) Rx(roll), exact; right angles only permute the entries.

    Args:
        entries: xx, yy, zz, xy, xz, yz of I along the turned axes, kg m^2.
        rpy: roll, pitch and yaw of these axes in the body frame, rad.
    """
    matrix = dict(zip(_KEYS, entries, strict=True))
    for axis, angle in enumerate(rpy):
        matrix = _turned_about(axis, angle, matrix)
    xx, yy, zz, xy, xz, yz = (matrix[key] for key in _KEYS)
    return xx, yy, zz, xy, xz, yz


def _turned_about(axis: int, angle: Quantity, old: dict[tuple[int, int], Quantity]) -> dict[tuple[int, int], Quantity]:
    """Return R I Rᵀ for a rotation in the plane j, k that takes j towards k."""
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    c, s = circular(Op.COS, angle), circular(Op.SIN, angle)
    cc, ss, cs = folding.mul(c, c), folding.mul(s, s), folding.mul(c, s)

    def at(a: int, b: int) -> tuple[int, int]:
        return (a, b) if a <= b else (b, a)

    twice = folding.mul(number(2), folding.mul(cs, old[at(j, k)]))
    difference = folding.sub(old[at(j, j)], old[at(k, k)])
    new = {
        at(i, i): old[at(i, i)],
        at(j, j): _sum(folding.mul(cc, old[at(j, j)]), folding.neg(twice), folding.mul(ss, old[at(k, k)])),
        at(k, k): _sum(folding.mul(ss, old[at(j, j)]), twice, folding.mul(cc, old[at(k, k)])),
        at(j, k): _sum(folding.mul(cs, difference), folding.mul(folding.sub(cc, ss), old[at(j, k)])),
        at(i, j): folding.sub(folding.mul(c, old[at(i, j)]), folding.mul(s, old[at(i, k)])),
        at(i, k): folding.add(folding.mul(s, old[at(i, j)]), folding.mul(c, old[at(i, k)])),
    }
    return {key: new[key] for key in _KEYS}


def _sum(*terms: Quantity) -> Quantity:
    total = terms[0]
    for term in terms[1:]:
        total = folding.add(total, term)
    return total


def circular(op: Op, angle: Quantity) -> Quantity:
    """Return sin or cos (the operation) of an angle, as a number where it is rational."""
    value = express(folding.function(op, angle), Graph())
    return number(value.value) if value.op is Op.CONSTANT else folding.function(op, angle)  # type: ignore[arg-type]
