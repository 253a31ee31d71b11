"""Any placement as rows of Khalil's six parameters, without a rounding.

    row = Rz(γ) Tz(b) Rx(α) Tx(d) Rz(θ) Tz(r)

Steps along one axis commute and add up, and what happens about y is what happens about x seen from a frame turned by
90° about z: Ty(y) = Rz(π/2) Tx(y) Rz(-π/2). So every placement is a product of motions about z and x in turn, and
every "z x z" of it is a row. One row is enough for all but a few placements; the others take massless frames between.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, permutations, product

from symdyn.scene.values import folding
from symdyn.scene.values.quantity import Quantity
from symdyn.scene.values.turns import RIGHT, Step, plus, quarter_turns, turns

SLOTS = ("Rz", "Tz", "Rx", "Tx", "Rz", "Tz")

MOST_ORDERS = 720


@dataclass(frozen=True)
class ParRow:
    """The six parameters of a frame, rad and m."""

    gamma: Quantity = Quantity.ZERO
    b: Quantity = Quantity.ZERO
    alpha: Quantity = Quantity.ZERO
    d: Quantity = Quantity.ZERO
    theta: Quantity = Quantity.ZERO
    r: Quantity = Quantity.ZERO


@dataclass(frozen=True)
class Screw:
    """A turn about an axis "x" or "z" with a shift along it."""

    axis: str
    angle: Quantity = Quantity.ZERO
    shift: Quantity = Quantity.ZERO


def rows(steps: Sequence[Step]) -> list[ParRow]:
    """Return the fewest rows found whose product is the placement; one row of zeros for the identity."""
    direct = _direct(steps)
    if direct is not None:
        return [direct]
    best = [_chop(_screws(order)) for order in _orders(steps)]
    found = min(best, key=len)
    single = _right_angled(steps) if len(found) > 1 else None
    return [single] if single else found


def _direct(steps: Sequence[Step]) -> ParRow | None:
    """Return the row whose steps are exactly these, the last slots taken first."""
    amounts = [Quantity.ZERO] * 6
    slot = 5
    for kind, amount in reversed(steps):
        while slot >= 0 and SLOTS[slot] != kind:
            slot -= 1
        if slot < 0:
            return None
        amounts[slot] = amount
        slot -= 1
    return ParRow(*amounts)


def _orders(steps: Sequence[Step]) -> Iterator[list[Step]]:
    """Return the steps in every order that means the same: neighbouring shifts commute and add up."""
    runs: list[list[tuple[Step, ...]]] = []
    count = 1
    for shifts, run in groupby(steps, key=lambda step: step[0][0] == "T"):
        if not shifts:
            runs.append([tuple(run)])
            continue
        sums: dict[str, Quantity] = {}
        for kind, amount in run:
            sums[kind] = folding.add(sums.get(kind, Quantity.ZERO), amount)
        orders = list(permutations(sums.items()))
        count *= len(orders)
        runs.append(orders if count <= MOST_ORDERS else orders[:1])
    for choice in product(*runs):
        yield [step for part in choice for step in part]


def _screws(steps: Sequence[Step]) -> list[Screw]:
    """Return a placement as screws about z and x in turn."""
    found: list[Screw] = []
    for kind, amount in steps:
        axis = kind[1]
        screw = Screw(
            "z" if axis == "z" else "x", *((amount, Quantity.ZERO) if kind[0] == "R" else (Quantity.ZERO, amount))
        )
        around = (Screw("z", RIGHT), screw, Screw("z", folding.neg(RIGHT))) if axis == "y" else (screw,)
        for part in around:
            _append(found, part)
    return found


def _append(screws: list[Screw], screw: Screw) -> None:
    if screws and screws[-1].axis == screw.axis:
        last = screws.pop()
        screw = Screw(screw.axis, _plus(last.angle, screw.angle), folding.add(last.shift, screw.shift))
    if screw.angle != Quantity.ZERO or screw.shift != Quantity.ZERO:
        screws.append(screw)


def _plus(a: Quantity, b: Quantity) -> Quantity:
    """Return the sum of two angles; multiples of π lose whole turns."""
    total = plus(a, b)
    whole = turns(total)
    if whole is None:
        return total
    rest = (whole + 1) % 2 - 1
    return folding.mul(Quantity.number(1 if rest == -1 else rest), Quantity.PI)


def _chop(screws: Sequence[Screw]) -> list[ParRow]:
    """Return screws that take turns about z and x as rows: z x z, x z, x z, ..."""
    found: list[ParRow] = []
    left = list(screws)
    while left or not found:
        first = left.pop(0) if not found and len(left) > 1 and left[0].axis == "z" else Screw("z")
        middle = left.pop(0) if left and left[0].axis == "x" else Screw("x")
        last = left.pop(0) if left else Screw("z")
        found.append(ParRow(first.angle, first.shift, middle.angle, middle.shift, last.angle, last.shift))
    return found


def _right_angled(steps: Sequence[Step]) -> ParRow | None:
    """Return the row of a placement whose turns are all by right angles, None if there is none or it has others.

    With R = Rz(γ) Rx(α) Rz(θ) and p = Rz(γ) (d, -r sin α, b + r cos α), whole numbers of right angles are tried.
    """
    if any(kind[0] == "R" and quarter_turns(amount) is None for kind, amount in steps):
        return None
    matrix, place = _frame(steps)
    for g, a, t in product((0, 1, 3, 2), (0, 1, 3, 2), (0, 1, 3, 2)):
        turned, _ = _frame((("Rz", _quarters(g)), ("Rx", _quarters(a)), ("Rz", _quarters(t))))
        if turned != matrix:
            continue
        _, (d, across, up) = _frame((("Rz", _quarters(-g % 4)), *zip(("Tx", "Ty", "Tz"), place, strict=True)))
        if a in (1, 3):
            r = folding.neg(across) if a == 1 else across
            return ParRow(_quarters(g), up, _quarters(a), d, _quarters(t), r)
        if across == Quantity.ZERO:
            return ParRow(_quarters(g), up, _quarters(a), d, _quarters(t))
    return None


def _quarters(k: int) -> Quantity:
    return (Quantity.ZERO, RIGHT, Quantity.PI, folding.neg(RIGHT))[k]


def _frame(steps: Sequence[Step]) -> tuple[list[list[int]], tuple[Quantity, Quantity, Quantity]]:
    """Return rotation and origin of a placement with right angles only."""
    matrix = [[int(i == j) for j in range(3)] for i in range(3)]
    place = [Quantity.ZERO, Quantity.ZERO, Quantity.ZERO]
    for kind, amount in steps:
        k = "xyz".index(kind[1])
        if kind[0] == "T":
            for i in range(3):
                moved = folding.mul(Quantity.number(matrix[i][k]), amount)
                place[i] = folding.add(place[i], moved)
            continue
        u, v = (k + 1) % 3, (k + 2) % 3
        for _ in range(quarter_turns(amount) or 0):
            for line in matrix:
                line[u], line[v] = line[v], -line[u]
    return matrix, (place[0], place[1], place[2])
