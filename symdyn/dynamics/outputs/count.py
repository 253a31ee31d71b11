"""Operation counts, the currency in which formulations are compared.

Categories and weights are those of `symdyn.dynamics.mechanism.cost`. What has no symbol below it is a constant
and costs nothing at run time.

Binding time says when the arguments of an operation are known: work on parameters alone is done once for a mechanism,
work on q once for a configuration, and so on.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cache

from symdyn.dynamics.mechanism.cost import CATEGORY, FREE, WEIGHTS
from symdyn.dynamics.outputs.named_functions import Function
from symdyn.dynamics.recursive.table_loops import Sweep, TableLoop
from symdyn.graph import Expr, Op, reachable

SYMBOL = Op.SYMBOL  # see `Op`

BINDING: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("params", ("params", "prepared")),
    ("q", ("q",)),
    ("q, qd", ("qd",)),
    ("all", ("qdd", "tau")),
)
"""Binding times from early to late, and the arguments that are known from then on."""


@dataclass(frozen=True)
class Counts:
    """Operations of one call; additions include subtractions, sincos counts distinct angles."""

    multiplications: int = 0
    additions: int = 0
    divisions: int = 0
    sincos: int = 0
    others: int = 0

    @classmethod
    def of(cls, function: Function) -> Counts:
        """Return the operations that one call of `function` takes, every shared subexpression computed once."""
        return sum(cls.by_binding(function).values(), cls())

    @staticmethod
    def by_binding(function: Function) -> dict[str, Counts]:
        """Return the operations of `function` by binding time, a key for every row of `BINDING`.

        Symbols are told by their names; one that is no argument counts as known last.
        """
        if function.loop and function.is_loop_alone:
            return {name: Counts.of_loop(function.loop) if name == BINDING[-1][0] else Counts() for name, _ in BINDING}
        known = {symbol.value: _time(argument.name) for argument in function.arguments for symbol in argument.symbols}
        times: dict[Expr, int] = {}  # -1 for what has no symbol below it
        tallies = [Counter[str]() for _ in BINDING]
        angles: set[Expr] = set()
        for node in reachable(function.entries):
            op = node.op
            if op is SYMBOL:
                times[node] = known.get(node.value, len(BINDING) - 1)
                continue
            time = -1
            for arg in node.args:
                time = max(time, times[arg])
            times[node] = time
            category = CATEGORY[op]
            if time >= 0 and category and not (category == "sincos" and node.args[0] in angles):
                tallies[time][category] += 1
                if category == "sincos":
                    angles.add(node.args[0])
        return {name: Counts(**tally) for (name, _), tally in zip(BINDING, tallies, strict=True)}

    @staticmethod
    def counts_alone(op: Op) -> bool:
        """Whether an operation costs something, and is not counted in pairs as sines are."""
        return CATEGORY[op] not in (FREE, "sincos")

    @classmethod
    def of_loop(cls, loop: TableLoop) -> Counts:
        """Return the operations of one call of a loop over a table; what several hand to one joint is added."""
        sweeps = loop.algorithm.sweeps
        found, handed = Counts(), set[int]()
        for row, kind in zip(loop.table.rows, loop.kinds, strict=True):
            found += _count_sweeps(sweeps(kind))
            if row.parent in handed:
                inward = (one for one in sweeps(kind) if one.inward)
                found += Counts(additions=sum(not x.is_zero for one in inward for x in one.handed))
            handed.add(row.parent)
            found += Counts(sincos=1) if not row.slides else Counts()
            found += Counts() if row.at_zero or row.slides else FROM_ZERO
        return found

    @property
    def cost(self) -> int:
        """All operations in one number, by `WEIGHTS`."""
        return sum(weight * int(getattr(self, name)) for name, weight in WEIGHTS.items())

    def __add__(self, other: Counts) -> Counts:
        return Counts(*(int(getattr(self, name)) + int(getattr(other, name)) for name in WEIGHTS))

    def __sub__(self, other: Counts) -> Counts:
        return Counts(*(int(getattr(self, name)) - int(getattr(other, name)) for name in WEIGHTS))

    def __str__(self) -> str:
        words = (
            f"{self.multiplications} mul",
            f"{self.additions} add",
            *(f"{number} {name}" for number, name in ((self.divisions, "div"), (self.sincos, "sincos")) if number),
            *(f"{self.others} other" for _ in range(bool(self.others))),
        )
        return ", ".join(words)


FROM_ZERO = Counts(4, 2)
"""What a turn that is not zero where q is costs besides in a loop over a table."""


@cache
def _count_sweeps(sweeps: tuple[Sweep, ...]) -> Counts:
    """Return the operations of sweeps at a joint, as they are printed: each is a function of its own."""
    found = Counts()
    for one in sweeps:
        found += Counts(**Counter(name for node in reachable(one.results) if (name := CATEGORY[node.op])))
    return found


def _time(argument: str) -> int:
    """Return the binding time of an argument, a row of `BINDING`; the last one if it is in no row."""
    return next((k for k, (_, names) in enumerate(BINDING) if argument in names), len(BINDING) - 1)
