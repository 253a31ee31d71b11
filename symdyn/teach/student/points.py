"""Points at which answers are compared by value, the same in every run and in both checkers.

0 … 5      drawn       6 … 9      parameters of 0 … 3 at another position
10 … 12    those of 0 … 2, parameters and position, with other rates, accelerations and drives
13         the first, with lengths, masses and times in other units, where the scene says its units
14 … 17    parameters as declared: with all else of 0, 1, 10 and 11; only where the scene has such
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from symdyn.algebra import Floats
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Unit, UnitError, acceleration_name
from symdyn.teach.student.vocabulary import Names

DRAWN, TWINS, MOVERS = 6, 4, 3
SCALED = DRAWN + TWINS + MOVERS
BOUND = SCALED + 1
SCALES = (1.7, 1.3, 0.6)
"""How much larger numbers of kg, m and s become."""
NONE: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class Points:
    """Values of every symbol of a scene, point by point."""

    at: tuple[Mapping[str, float], ...]
    scaled: bool

    def marks(self, free: bool = False) -> list[int]:
        """Return the points that mark a value, two and two; where it goes to and from, if a constant is free."""
        return [DRAWN, 0, DRAWN + 1, 1] if free else [0, 1, *range(BOUND, len(self.at))[:2]]

    @property
    def pairs(self) -> list[int]:
        """Return the points that mark what vanishes, times a factor that is free of rates: two and two."""
        first = DRAWN + TWINS
        bound = BOUND
        return [0, first, 1, first + 1, *([bound, bound + 2, bound + 1, bound + 3] if len(self.at) > bound else [])]

    def marked(self, nodes: Sequence[Expr], free: bool = False) -> list[list[float]]:
        """Return what marks each of some nodes."""
        columns = [list(row) for row in zip(*self.values(nodes, self.marks(free)), strict=True)]
        return [[x[0] - x[1], x[2] - x[3]] if free else x for x in columns]

    def united(self, right: Sequence[float]) -> bool:
        """Whether a value has a unit that can be told, from the first point and the scaled one."""
        return self.scaled and 0 not in right and _is_product(right[1] / right[0])

    def fits(self, mine: Sequence[float], right: Sequence[float]) -> bool:
        """Whether a value changes as the right one when units do, or none can tell."""
        off = abs(mine[1] * right[0] - right[1] * mine[0])
        return not self.united(right) or not off > 1e-7 * abs(right[1] * mine[0])  # nan: a symbol of no known unit

    def values(self, nodes: Sequence[Expr], at: Sequence[int] | None = None) -> list[list[float]]:
        """Return the values of nodes, point by point; nan where there is none."""
        symbols = [x for x in reachable(list(nodes)) if x.op is Op.SYMBOL]
        found = []
        for k in range(len(self.at)) if at is None else at:
            seeds = {x: self.at[k][str(x.value)] for x in symbols}
            try:
                found.append([float(value) for value in evaluate(list(nodes), Floats(), seeds)])
            except (ArithmeticError, ValueError):
                found.append([_value(node, seeds) for node in nodes])
        return found


def _is_product(ratio: float) -> bool:
    """Whether a number is a product of small powers of the scales: what has a unit is."""
    span = range(-4, 5)
    return any(abs(_scale((a, b, c)) / ratio - 1) < 1e-9 for a in span for b in span for c in span)


def _value(node: Expr, seeds: Mapping[Expr, float]) -> float:
    try:
        return float(evaluate([node], Floats(), seeds)[0])
    except (ArithmeticError, ValueError):
        return float("nan")


def points_of(scene: Scene, others: Mapping[str, str] = NONE) -> Points:
    """Return the points of a scene; `others` are symbols beside it, such as multipliers, with their units."""
    names = Names(scene, tuple(others))
    every = list(dict.fromkeys(names.symbols.values()))
    parameters = {p.name for p in scene.parameters}
    resting = {*parameters, *scene.coordinates}
    drawn = [{name: _drawn(name, k) for name in every} for k in range(DRAWN)]
    twins = [_mixed(point, k, parameters) for k, point in enumerate(drawn[:TWINS])]
    movers = [_mixed(point, k, resting) for k, point in enumerate(drawn[:MOVERS])]
    given = {p.name: p.value.known_at({}) for p in scene.parameters if p.value is not None and p.name in every}
    bound = {name: float(value) for name, value in given.items() if value is not None}
    scales = _scales(scene, others)
    scaled = {name: value * scales.get(name, 1.0) for name, value in drawn[0].items()}
    declared = [{**point, **bound} for point in (*drawn[:2], *movers[:2])] if bound else []
    return Points((*drawn, *twins, *movers, scaled, *declared), bool(scales))


def _scales(scene: Scene, others: Mapping[str, str]) -> dict[str, float]:
    """Return what the value of each symbol is times in other units; none if a unit is not known, nan for one without.

    The unit of a multiplier is not known where the row is the user's: what it stands in has no unit that can be told.
    """
    found: dict[str, float] = {}
    for parameter in scene.parameters:
        powers = powers_of(parameter.unit)
        if powers is None:
            return {}
        found[parameter.name] = _scale(powers)
    rates = zip(scene.velocities, SceneUnits(scene).velocities, strict=True)
    second = SCALES[2]
    for velocity, unit in rates:
        found[velocity] = _scale(powers_of(unit)) / second
        found[acceleration_name(velocity)] = found[velocity] / second
    for coordinate, unit in zip(scene.coordinates, SceneUnits(scene).coordinates, strict=True):
        found[coordinate] = _scale(powers_of(unit))
    for _, drive, unit in SceneUnits(scene).each_drive():
        found[drive] = _scale(powers_of(unit))
    return found | {name: _scale(powers_of(unit)) if unit else float("nan") for name, unit in others.items()}


def _scale(powers: Sequence[int] | None) -> float:
    kg, m, s = powers or (0, 0, 0)
    return float(SCALES[0] ** kg * SCALES[1] ** m * SCALES[2] ** s)


def powers_of(unit: str) -> tuple[int, int, int] | None:
    """Return the powers of kg, m and s in a unit such as "N m s/rad", None where it is not of these alone."""
    try:
        kg, m, s, *others = Unit.read(unit).dimension.exponents
    except UnitError:
        return None
    return None if any(others) else (int(kg), int(m), int(s))


def _mixed(point: Mapping[str, float], k: int, kept: set[str]) -> dict[str, float]:
    """Return a point with other values of all but those that are kept."""
    return {name: value if name in kept else _drawn(name, DRAWN + k) for name, value in point.items()}


def _drawn(name: str, k: int) -> float:
    """Return the value of a symbol at a point: between 1/4 and 2."""
    return round(random.Random(f"{k}:{name}").uniform(0.25, 2.0), 6)
