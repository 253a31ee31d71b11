"""The stages of a plan as lines of C, for a block of states or for a single one, and the generated sincos.

Results of many entries are written into rows of work space and copied, block by block: where a block's states go to
columns a power of two apart, and always where entries lie state by state. Half of a mass matrix equals the other half,
and much of a tree's is zero: such entries are copied from the row that holds them already. A copy of 64 states at a
time is several times as fast as one of 32, since caches fetch ahead along long pieces only. Rows are a cache line
further apart than they are long, so that they do not all fall on the same few places of the nearest cache.

Sine and cosine take π/2 in parts and minimax polynomials, with numbers as `benchmarks/minimax.py` prints them:

    k = round(2x/π),   y = x - k π/2 = hi + lo       |y| ≤ π/4, four parts of π/2, the first three times k exact
    sin y = y + y³ S(y²),   cos y = 1 - y²/2 + y⁴ C(y²)

The reduction keeps a low part, so that the result is right to 1 ulp next to multiples of π/2 too. The error of the
second difference is folded into the third part: where it is not zero, the difference is so large that rounding the sum
does no harm. In float everything is computed in double, where the sum of three parts and short polynomials are enough,
and rounded once. The polynomials are in h = y²/2, which is needed anyway; powers of two cost no digit. The excess of y
is subtracted together with the rest of the series, whose signs are such that -0 stays -0.

References: Cody and Waite, Software Manual for the Elementary Functions (1980), for the reduction in parts; the order
of summation is that of FDLIBM's k_sin.c and k_cos.c.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from symdyn.emit.code.spelling import REALS, Printer, ShortSines
from symdyn.emit.code.target import Line
from symdyn.emit.targets.c.plan import Pass, Plan, SineCosine
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op
from symdyn.program import Program, Routine, RoutineStep, identifier

ATAN2_HELPER = "atan2_of"
"""A function of our own in files of doubles, without branches, which a loop over states becomes vectors of."""

NAME, GROUP = re.compile(r"[A-Za-z_]\w*"), 8
"""Of a line. Angles of one state are taken together in groups of so many."""


@dataclass(frozen=True)
class PassText:
    """One loop."""

    number: int  # from 1
    vector: bool  # whether it must become vector code
    unused: tuple[str, ...]  # what it is handed and does not read
    before: tuple[Line, ...]  # what is uniform, ahead of the loop
    lines: tuple[Line, ...]  # the body of the loop
    names: frozenset[str]  # targets of lines that are new variables; other lines go to work space and to the result


@dataclass(frozen=True)
class ScalarStage:
    """A piece of the scalar function: lines, or angles whose sines and cosines are taken together, or a call."""

    number: int  # tells the arrays of angles apart
    lines: tuple[Line, ...] = ()  # assignments
    angles: tuple[str, ...] = ()  # where the angles are, padded with zeros to whole groups; () for lines
    results: tuple[Line, ...] = ()  # what becomes of sines and cosines; without `angles`, all there is to it
    call: str = ""  # of a part that stands in a function of its own; "" for none
    count: int = 0  # how many there are without the padding


@dataclass(frozen=True)
class Layout:
    """How a place in memory is written: entries of arguments and of the result, rows of work space."""

    entry: str
    result: str
    row: str
    common: tuple[str, ...]


LANED = Layout("{}[{} * stride + k]", "{}[{} * reach + k]", "w[{}][k]", ("stride", "reach"))
SINGLE = Layout("{}[{}]", "{}[{}]", "w[{}]", ())


@dataclass(frozen=True)
class Writer:
    """Prints the stages of one routine; `printed` holds what stands for each name."""

    routine: Routine
    program: Program
    printer: Printer
    plan: Plan
    places: Mapping[Expr, tuple[str, int]]
    printed: Mapping[str, str]

    def row(self, stage: SineCosine) -> str:
        """Return where the angles of a stage stand."""
        if stage.row is not None:
            return f"w[{stage.row}]"
        argument, place = self.places[stage.angle.node]
        return f"{argument} + {place} * stride"

    def several(self) -> tuple[SineCosine, ...]:
        """Return the stages at the beginning that take neighbouring entries of one argument to the first rows, in turn.

        One alone is none.
        """
        found: list[SineCosine] = []
        for stage in self.plan.stages:
            if not isinstance(stage, SineCosine) or stage.row is not None:
                break
            argument, place = self.places[stage.angle.node]
            before = (argument, place - 1)
            first = 2 * len(found)
            if (found and self.places[found[-1].angle.node] != before) or stage.rows != (first, first + 1):
                break
            found.append(stage)
        return tuple(found) if len(found) > 1 else ()

    def loop(self, stage: Pass, number: int, layout: Layout, written: Mapping[int, int] | None = None) -> PassText:
        """Return one pass as text, for the states of a block or for a single one.

        Of the entries of the result those of `written` alone are written, to its places; None for all to their own.
        """
        places = {
            place: place if written is None else written[place]
            for place in stage.outputs
            if written is None or place in written
        }
        read = {self.places[step.node][0] for step in (*stage.inputs, *stage.uniform) if step.node.op is Op.SYMBOL}
        read |= {"stride"} if stage.inputs else set()
        read |= {"reach"} if places else set()
        read |= {"w"} if stage.loads or stage.stores else set()
        read |= {"out"} if places else set()
        handed = (*layout.common, *(argument.name for argument in self.routine.function.arguments), "w", "out")
        loads = {step.node: row for step, row in stage.loads}
        stores = {step.node: row for step, row in stage.stores}
        lines: list[Line] = []
        for line in stage.order:
            if isinstance(line, int):
                if line in places:
                    lines.append(Line(layout.result.format("out", places[line]), self.entry(line)))
            elif line.node in loads:
                lines.append(Line(line.name, layout.row.format(loads[line.node])))
            elif line.node.op is Op.SYMBOL:
                lines.append(Line(line.name, layout.entry.format(*self.places[line.node])))
            else:
                lines.append(self._define(line))
            if isinstance(line, RoutineStep) and line.node in stores:
                lines.append(Line(layout.row.format(stores[line.node]), line.name))
        if layout is SINGLE:
            lines = _read_where_used(lines, {step.name for step, _ in stage.loads})
        return PassText(
            number=number,
            vector=stage.plain or any(ATAN2_HELPER in line.code for line in lines),
            unused=tuple(name for name in handed if name not in read),
            before=tuple(self._define(step) for step in stage.uniform),
            lines=tuple(lines),
            names=frozenset(line.name for line in stage.order if isinstance(line, RoutineStep)),
        )

    def scalar(self) -> tuple[ScalarStage, ...]:
        """Return the stages of the scalar function; neighbouring angles are taken together."""
        pending = [Line(step.name, self._given(step)) for step in self.routine.inputs]
        known = {line.target for line in pending}
        stages: list[ScalarStage] = []
        for group in self._grouped():
            if isinstance(group, Pass):
                for step in (*group.uniform, *group.steps):
                    if step.name not in known:
                        known.add(step.name)
                        pending.append(self._define(step))
            else:
                stages.append(ScalarStage(len(stages), tuple(pending)))
                pending = []
                angles = [stage.angle.name for stage in group]
                stages.append(self._angles(len(stages), group, angles, lambda step, _: step.name))
        return (*stages, ScalarStage(len(stages), tuple(pending)))

    def scalar_calls(self, handed: str, together: bool) -> tuple[ScalarStage, ...]:
        """Return the stages of a scalar function that is cut into parts; angles are taken `together` or one by one."""
        name = identifier(self.routine.function.name)
        stages: list[ScalarStage] = []
        parts = 0
        for group in self._grouped():
            if isinstance(group, Pass):
                parts += 1
                stages.append(ScalarStage(len(stages), call=f"{name}_part{parts}({handed}w, r);"))
            else:
                angles = [
                    SINGLE.row.format(stage.row) if stage.row is not None else self._given(stage.angle)
                    for stage in group
                ]
                if together:
                    stages.append(self._angles(len(stages), group, angles, lambda _, row: SINGLE.row.format(row)))
                else:
                    stages.append(ScalarStage(len(stages), results=self._one_by_one(group, angles)))
        return tuple(stages)

    def _given(self, step: RoutineStep) -> str:
        """Return an entry of an argument of the scalar function, which takes single numbers by value."""
        name, place = self.places[step.node]
        scalars = [argument.name for argument in self.routine.function.arguments if argument.scalar]
        return name if name in scalars else SINGLE.entry.format(name, place)

    def _grouped(self) -> Iterator[Pass | list[SineCosine]]:
        """Iterate over the stages, neighbouring sines and cosines together."""
        for is_pass, group in groupby(self.plan.stages, lambda stage: isinstance(stage, Pass)):
            if is_pass:
                yield from (stage for stage in group if isinstance(stage, Pass))
            else:
                yield [stage for stage in group if isinstance(stage, SineCosine)]

    def _angles(
        self, number: int, group: list[SineCosine], angles: list[str], target: Callable[[RoutineStep, int], str]
    ) -> ScalarStage:
        """Return the stage that takes sines and cosines of `angles`; `target` says where one of them goes."""
        results = [
            Line(target(step, row), f"{kind}{number}[{place}]")
            for place, stage in enumerate(group)
            for (step, row), kind in ((stage.sine, "sine"), (stage.cosine, "cosine"))
            if step is not None
        ]
        padding = ["0"] * (-len(angles) % GROUP)
        return ScalarStage(number, angles=(*angles, *padding), results=tuple(results), count=len(angles))

    def _one_by_one(self, group: list[SineCosine], angles: list[str]) -> tuple[Line, ...]:
        """Return what a stage of angles computes by the functions of the C library."""
        return tuple(
            Line(SINGLE.row.format(row), self.printer.spellings[step.node.op].pattern.format(angle))
            for stage, angle in zip(group, angles, strict=True)
            for step, row in (stage.sine, stage.cosine)
            if step is not None
        )

    def _define(self, step: RoutineStep) -> Line:
        if step.node.op is Op.SYMBOL:
            return Line(step.name, SINGLE.entry.format(*self.places[step.node]))
        return Line(step.name, self.printed[step.name])

    def zero(self, place: int) -> bool:
        """Return whether an entry of the result is zero whatever the state."""
        return self.program.constants.get(self.routine.function.entries[place]) == 0

    def entry(self, place: int) -> str:
        entry = self.routine.function.entries[place]
        return self.printer.code(entry, self.plan.names, self.program.constants)


def _read_where_used(lines: Sequence[Line], loads: Container[str]) -> list[Line]:
    """Return lines without `loads`: what uses one reads the row itself, until that is overwritten.

    Nor has what goes to one place alone, in the next line, a name.
    """
    uses = Counter(name for line in lines for name in NAME.findall(line.code))
    rows, found = dict[str, str](), list[Line]()
    for line in lines:
        if line.target in loads:
            rows[line.target] = line.code
            continue
        if found and line.code == found[-1].target and uses[line.code] == 1:
            line = Line(line.target, found.pop().code)  # noqa: PLW2901
        uses.subtract(name for name in NAME.findall(line.code))
        code = NAME.sub(lambda name: rows.get(name[0], name[0]), line.code)
        over = [name for name, row in rows.items() if row == line.target]
        found += [Line(name, row) for name in over if (row := rows.pop(name)) and uses[name] > 0]
        found.append(Line(line.target, code))
    return found


LANES = REALS["double"].lanes
"""States in a block, of all types but double-doubles."""

LINE = 64
"""Bytes of a line of the cache."""

WAYS = 8
"""How many columns a power of two apart find a place in a cache at once; results of more go through rows."""

NEAREST = 32 * 1024
"""Bytes of a result of a block up to which its loops may write all entries, each to its own column."""


@dataclass(frozen=True)
class Gathered:
    """What becomes of the result of a block."""

    rows: int  # of a block: entries that are written, and one of zeros where there are some
    zeros: bool  # whether the last row holds zeros
    written: Mapping[int, int]  # entries that loops write, with their rows
    places: tuple[int, ...]  # of each entry, the row that it is; () where every entry has its own
    direct: bool  # whether loops write all entries, so that they may write where the result has to go
    wide: bool  # whether the result has so many entries that columns a power of two apart are not written directly

    def reach(self, states: int, width: int) -> int:
        """Return how far rows of so many states of `width` bytes are apart; where room is scarce, no further."""
        return states + LINE // width if self.wide and states == LANES else states

    def states(self, lanes: int, width: int, room: int) -> int:
        """Return how many states are copied at once: more than the `lanes` of one block, if `room` bytes hold them."""
        states = LANES if self.wide else lanes
        while states > lanes and self.rows * self.reach(states, width) * width > room:
            states //= 2
        return states


def gathered(routine: Routine, program: Program, width: int) -> Gathered:
    """Return what becomes of the result of a block, an entry of one state taking `width` bytes."""
    entries = routine.function.entries
    size, wide = len(entries), len(entries) > WAYS
    first = {entry: place for place, entry in reversed(tuple(enumerate(entries)))}
    own = {place: place for place in range(size)}
    if not wide or len(first) == size:
        return Gathered(size, False, own, (), direct=True, wide=wide)
    if size * LANES * width <= NEAREST:
        return Gathered(size, False, own, tuple(first[entry] for entry in entries), direct=True, wide=True)
    kept = [place for place in sorted(first.values()) if program.constants.get(entries[place]) != 0]
    row = {entries[place]: number for number, place in enumerate(kept)}
    zeros = len(row) < len(first)
    places = tuple(row.get(entry, len(row)) for entry in entries)
    written = {place: row[entries[place]] for place in kept}
    return Gathered(len(row) + zeros, zeros, written, places, direct=False, wide=True)


LIMIT_EXPONENT = 20
"""Angles below 2^20 in size are reduced here, others by the C library."""

CHAINS = 4
"""Angles that one turn of the loop takes side by side: one waits for its own results most of the time."""

LANES_AT_ONCE = 8
"""Rows of angles that go through both halves together: what remains of them waits in the nearest cache."""

TINY = 2.0**-200
"""Added and subtracted again, it leaves alone what has digits to lose; what is smaller becomes a multiple of 2^-252."""

TWO_OVER_PI = 0.6366197723675814

HALF_PI = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487111665e-21, 8.4784276603689e-32)

SINE = {
    "double": (
        -0.1666666666666663,
        0.00833333333332184,
        -0.00019841269829358544,
        2.755731353852763e-06,
        -2.5050734392599535e-08,
        1.589543355068773e-10,
    ),
    "float": (
        -0.16666666640796732,
        0.008333329304823271,
        -0.00019839312266407334,
        2.7181216116233883e-06,
    ),
}

COSINE = {
    "double": (
        0.0416666666666666,
        -0.0013888888888874474,
        2.4801587289671537e-05,
        -2.7557314401030616e-07,
        2.0875729281241468e-09,
        -1.135993424414567e-11,
    ),
    "float": (
        0.04166666662282967,
        -0.0013888883753536672,
        2.4799520039253818e-05,
        -2.7210240065091214e-07,
    ),
}


def horner(coefficients: Sequence[float], variable: str) -> str:
    """Return a polynomial as C: c0 + h * (c1 + h * (…))."""
    *low, top = coefficients
    text = repr(top)
    for coefficient in reversed(low):
        text = f"({text})" if " " in text or text.startswith("-") else text
        text = f"{coefficient!r} + {variable} * {text}"
    return text


def in_halves(coefficients: Sequence[float], first: int) -> list[float]:
    """Return the coefficients of a polynomial in z/2 for those of one in z, the first of them times 2^first."""
    return [coefficient * 2.0**power for power, coefficient in enumerate(coefficients, first)]


def sincos_values(real: str, short: ShortSines | None = None) -> Mapping[str, Any]:
    """Return what the template of sincos is given for "double" or "float", or for shorter sines of this type."""
    if short:
        return {
            "short": short,
            "two_over_pi": repr(TWO_OVER_PI),
            "sine": horner(short.sine, "z[j]"),
            "cosine": horner(short.cosine, "z[j]"),
            "chains": CHAINS,
            "limit_exponent": short.limit_exponent,
        }
    return {
        "two_over_pi": repr(TWO_OVER_PI),
        "half_pi": tuple(map(repr, HALF_PI)),
        "sine": horner(in_halves([-c for c in SINE[real]], 1), "h[j]"),
        "cosine": horner(in_halves(COSINE[real], 2), "h[j]"),
        "short": None,
        "tiny": repr(TINY),
        "lockstep": LANES_AT_ONCE,
        "chains": CHAINS,
        "limit_exponent": LIMIT_EXPONENT,
    }
