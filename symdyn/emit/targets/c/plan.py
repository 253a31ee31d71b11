"""How a batch of states is computed: in which order the loops run and what they hand on to each other.

One routine becomes stages that run one after the other over a block of states. A pass is one loop of plain arithmetic,
which compilers turn into vector code. Sines and cosines are taken a row at a time between two passes, and so are calls
into the C library, which would keep the whole loop from being vectorised. Passes are cut where they grow too long for a
compiler. A value that leaves its stage waits in a row of work space; rows are used again when their value is spent.

What depends on parameters alone, or on what was prepared from them, is uniform: computed once a block, before the loop.

Steps run together in one loop over the states of a block as far as can be: what calls wait for comes as early as it
can, all the rest after the last call, cut where it grows too long for a compiler.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from heapq import heappop, heappush
from itertools import count
from math import prod

from symdyn.emit.code.schedule import schedule
from symdyn.emit.code.spelling import operands, standing
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op
from symdyn.program import Routine, RoutineStep, shared

Constants = Mapping[Expr, Fraction]

LONGEST = 1600
"""Operations up to which a routine of one state stays whole. 7 axes need a third of them."""
LONGEST_LOOP, WIDEST_LOOP = 4500, 500
"""Operations and entries of the result up to which a routine stays one loop over states, where much is used again.

Pieces are slower there, as of derivatives; loops of more operations compile for long. gcc makes no vectors of a loop
that reads and writes 1,000 places.
"""
USED_AGAIN = 5
"""Operations for each value that one piece loads from another, below which much is used again.

Derivatives of 6 and 7 axes have 3 to 4, mass matrices of 12 to 32 joints 7 to 9.
"""
LONGEST_OF_VECTOR = 480
"""Operations up to which a routine over states stays one loop where its result is a vector, as motions and forces are.

What is used again is little then, and of shorter loops more turns are under way at once. Six axes, forward, are just
below and lose a twentieth in pieces; seven, inverse, are just above and gain as much.
"""
PIECE = 300
"""Operations of one piece of a longer routine: time to compile grows faster than its length.

Of 100 to 600, all compiled 64 joints about as fast; 300 ran as fast as any, with batch code and without.
"""

TRIGONOMETRIC = (Op.SIN, Op.COS)
CALLS = (*TRIGONOMETRIC, Op.EXP, Op.LOG, Op.TANH, Op.ATAN2, Op.POW)


def longest_loop(shape: Sequence[int], operations: int, loads: int) -> int:
    """Return up to how many operations a routine stays one loop over states.

    Args:
        shape: of its result.
        operations: how many it has.
        loads: how many values its pieces load from each other.
    """
    if len(shape) < 2:
        return LONGEST_OF_VECTOR
    return LONGEST_LOOP if prod(shape) <= WIDEST_LOOP and loads * USED_AGAIN > operations else LONGEST


@dataclass
class Stage:
    """A stage in the making; `kind` is "pass", "sincos" or "call"."""

    kind: str
    steps: list[RoutineStep]
    outputs: list[int]
    angle: Expr | None = None


def complete(routine: Routine, known: Constants, short: bool = False) -> list[RoutineStep]:
    """Return the steps with a name for every call and for whatever is called with.

    If they are to be `short`, every operation that reads several values gets a name, too. A long line keeps all that it
    reads waiting for what comes last; short ones add up early what comes early.
    """
    taken = {step.name for step in (*routine.inputs, *routine.steps)}
    names = (f"y{number}" for number in count(1))
    named = {step.node for step in (*routine.inputs, *routine.steps)}
    steps: list[RoutineStep] = []

    def add(node: Expr) -> None:
        named.add(node)
        steps.append(RoutineStep(next(name for name in names if name not in taken), node))

    def lift(node: Expr) -> int:  # as deep as a line is wide
        """Return how many values the text of `node` reads, after naming what has to be."""
        if node in named or node in known:
            return int(node in named)
        read = below(node)
        if node.op in CALLS or (short and read > 1):
            add(node)
            return 1
        return read

    def below(node: Expr) -> int:
        read = 0
        for arg in node.args:
            read += lift(arg)
            if node.op in CALLS and arg not in named and arg not in known:
                add(arg)
        return read

    for step in routine.steps:
        below(step.node)
        steps.append(step)
    for entry in routine.function.entries:
        lift(entry)
    return steps


def _operations(step: RoutineStep, named: Mapping[Expr, str], known: Constants) -> int:
    """Return how many operations one line holds."""
    return 1 + sum(node not in named for node in standing(step.node.args, named, known))


def stages_of(
    steps: Sequence[RoutineStep],
    needs: Mapping[Expr, Sequence[Expr]],
    named: Mapping[Expr, str],
    known: Constants,
    longest: int,
) -> list[Stage]:
    """Return the stages: what calls wait for as early as can be, all the rest after the last call.

    Passes of more than `longest` operations are cut.
    """
    level: dict[Expr, int] = {}
    for step in steps:
        level[step.node] = max((level.get(n, 0) for n in needs[step.node]), default=0) + (step.node.op in CALLS)
    early: set[Expr] = set()
    for step in reversed(steps):
        if step.node.op in CALLS or step.node in early:
            early.update(needs[step.node])
    last = max(level.values(), default=0)
    stages: list[Stage] = []
    for here in range(last + 1):
        calls = [s for s in steps if s.node.op in CALLS and level[s.node] == here]
        angles: dict[Expr, list[RoutineStep]] = {}
        for s in calls:
            if s.node.op in TRIGONOMETRIC:
                angles.setdefault(s.node.args[0], []).append(s)
        stages += [Stage("sincos", both, [], angle) for angle, both in angles.items()]
        stages += [Stage("call", [s], []) for s in calls if s.node.op not in TRIGONOMETRIC]
        plain = (s for s in steps if s.node.op not in CALLS)
        mine = [s for s in plain if here == (level[s.node] if s.node in early else last)]
        if mine or here == last:
            stages += _passes(mine, needs, {s.node: _operations(s, named, known) for s in mine}, longest)
    return stages


def _passes(
    steps: Sequence[RoutineStep], needs: Mapping[Expr, Sequence[Expr]], sizes: Mapping[Expr, int], longest: int
) -> list[Stage]:
    """Return `steps` as one pass, or cut into several in the better of two orders: as given, and with short lives."""
    total = sum(sizes.values())
    if total <= longest:
        return [Stage("pass", list(steps), [])]
    count = -(-total // PIECE)
    ordered = [steps[place] for place in schedule([(step.node, needs[step.node]) for step in steps])]
    ways = [_cut(order, [sizes[step.node] for step in order], count) for order in (steps, ordered)]
    return min(ways, key=lambda passes: _carried(passes, needs))


def _cut(steps: Sequence[RoutineStep], sizes: Sequence[int], count: int) -> list[Stage]:
    """Return `steps` as `count` passes of about equal length."""
    passes = [Stage("pass", [], []) for _ in range(count)]
    done, total = 0, sum(sizes)
    for step, size in zip(steps, sizes, strict=True):
        passes[min(count - 1, done * count // total)].steps.append(step)
        done += size
    return passes


def _carried(passes: Sequence[Stage], needs: Mapping[Expr, Sequence[Expr]]) -> int:
    """Return how many values wait between passes for a later one that reads them, summed over all cuts."""
    born = {step.node: number for number, stage in enumerate(passes) for step in stage.steps}
    last: dict[Expr, int] = {}
    for number, stage in enumerate(passes):
        last |= {node: number for step in stage.steps for node in needs[step.node] if node in born}
    return sum(number - born[node] for node, number in last.items())


@dataclass(frozen=True)
class Pass:
    """One loop over the states of a block.

    Attributes:
        plain: whether it is arithmetic alone, and so fit for vectors.
        inputs: entries of arguments that it reads.
        loads, stores: (step, row) of what comes from and goes to other stages.
        order: its lines: what is read, right before its first use, or computed, or the place of an entry of the result.
        uniform: steps and parameters that are computed before the loop.
    """

    plain: bool
    inputs: tuple[RoutineStep, ...]
    loads: tuple[tuple[RoutineStep, int], ...]
    stores: tuple[tuple[RoutineStep, int], ...]
    order: tuple[RoutineStep | int, ...]
    uniform: tuple[RoutineStep, ...]

    @property
    def steps(self) -> tuple[RoutineStep, ...]:
        given = {*self.inputs, *(step for step, _ in self.loads)}
        return tuple(line for line in self.order if isinstance(line, RoutineStep) and line not in given)

    @property
    def outputs(self) -> tuple[int, ...]:
        """Places of the entries of the result that it writes."""
        return tuple(line for line in self.order if isinstance(line, int))


@dataclass(frozen=True)
class SineCosine:
    """Sine and cosine of one row.

    Attributes:
        angle: an input, or a step in a row.
        row: where the angle stands; None for an input.
        sine, cosine: the step and its row; None for the step where only the other one is asked for.
    """

    angle: RoutineStep
    row: int | None
    sine: tuple[RoutineStep | None, int]
    cosine: tuple[RoutineStep | None, int]

    @property
    def rows(self) -> tuple[int, int]:
        """Where sine and cosine go."""
        return self.sine[1], self.cosine[1]


@dataclass(frozen=True)
class Plan:
    """A routine in stages."""

    stages: tuple[Pass | SineCosine, ...]  # in running order; the last is a pass
    rows: int  # how many rows of work space there are
    names: Mapping[Expr, str]  # of inputs and steps, the few added ones included

    @property
    def loads(self) -> int:
        """How many values passes load from work space."""
        return sum(len(stage.loads) for stage in self.stages if isinstance(stage, Pass))


def plan(routine: Routine, known: Constants, short: bool = False, longest: int = LONGEST) -> Plan:
    """Return the stages of `routine`, passes of more than `longest` operations cut.

    `short` cuts its lines up, too, so that fewer values wait between stages.
    """
    steps = complete(routine, known, short)
    named = {step.node: step.name for step in (*routine.inputs, *steps)}
    needs = {step.node: operands(step.node.args, named, known) for step in steps}
    common = shared([argument.name for argument in routine.function.arguments])
    everywhere = {s for a in routine.function.arguments if a.name == common for s in a.symbols}
    for step in steps:
        if all(node in everywhere for node in needs[step.node]):
            everywhere.add(step.node)
    varying = [step for step in steps if step.node not in everywhere]
    stages = stages_of(varying, needs, named, known, longest)
    entries = [operands((entry,), named, known) for entry in routine.function.entries]
    # every entry is written by the first pass that has all it needs; constants by the last one
    born = {step.node: i for i, stage in enumerate(stages) for step in stage.steps}
    passes = [i for i, stage in enumerate(stages) if stage.kind == "pass"]
    for place, needed in enumerate(entries):
        ready = max((born[node] for node in needed if node in born), default=len(stages) - 1)
        stages[next(i for i in passes if i >= ready)].outputs.append(place)
    return _finish(routine, steps, stages, needs, entries, everywhere, named)


def _finish(
    routine: Routine,
    steps: Sequence[RoutineStep],
    stages: Sequence[Stage],
    needs: Mapping[Expr, Sequence[Expr]],
    entries: Sequence[Sequence[Expr]],
    everywhere: set[Expr],
    named: Mapping[Expr, str],
) -> Plan:
    """Return the plan with a row for every value that leaves its stage."""
    step_of = {step.node: step for step in (*routine.inputs, *steps)}
    inputs = {step.node for step in routine.inputs}
    used = [_used(stage, needs, entries) for stage in stages]
    last_use = {node: i for i, nodes in enumerate(used) for node in nodes}
    row: dict[Expr, int] = {}
    free: list[int] = []
    rows = 0
    done: list[Pass | SineCosine] = []

    def take() -> int:
        nonlocal rows
        if free:
            return heappop(free)
        rows += 1
        return rows - 1

    for i, stage in enumerate(stages):
        kept = [s for s in stage.steps if last_use.get(s.node, i) > i]
        for step in kept:
            row[step.node] = take()
        spare: list[int] = []
        if stage.angle is not None:
            pair: list[tuple[RoutineStep | None, int]] = []
            for op in TRIGONOMETRIC:
                found = next((s for s in kept if s.node.op is op), None)
                if found is None:
                    spare.append(take())
                pair.append((found, row[found.node] if found else spare[-1]))
            done.append(SineCosine(step_of[stage.angle], row.get(stage.angle), pair[0], pair[1]))
        else:
            own = {s.node for s in stage.steps}
            done.append(
                Pass(
                    plain=stage.kind == "pass",
                    inputs=tuple(step_of[n] for n in used[i] if n in inputs and n not in everywhere),
                    loads=tuple((step_of[n], row[n]) for n in used[i] if n in row and n not in own),
                    stores=tuple((s, row[s.node]) for s in kept),
                    order=_order(stage, needs, entries, everywhere, step_of),
                    uniform=_uniform(used[i], needs, everywhere, (*routine.inputs, *steps)),
                )
            )
        for number in (*spare, *(row[n] for n in used[i] if n in row and last_use[n] == i)):
            heappush(free, number)
    return Plan(tuple(done), rows, named)


def _order(
    stage: Stage,
    needs: Mapping[Expr, Sequence[Expr]],
    entries: Sequence[Sequence[Expr]],
    everywhere: set[Expr],
    step_of: Mapping[Expr, RoutineStep],
) -> tuple[RoutineStep | int, ...]:
    """Return the lines of a pass in an order of short lives, each value that is read right before its first use."""
    lines: list[RoutineStep | int] = [*stage.steps, *stage.outputs]
    read = [needs[line.node] if isinstance(line, RoutineStep) else entries[line] for line in lines]
    read = [[node for node in nodes if node not in everywhere] for nodes in read]
    made = [line.node if isinstance(line, RoutineStep) else None for line in lines]
    known = set(made)
    order: list[RoutineStep | int] = []
    for place in schedule(list(zip(made, read, strict=True))):
        first = [node for node in read[place] if node not in known]
        known.update(first)
        order += [*(step_of[node] for node in first), lines[place]]
    return tuple(order)


def _used(stage: Stage, needs: Mapping[Expr, Sequence[Expr]], entries: Sequence[Sequence[Expr]]) -> dict[Expr, None]:
    """Return what a stage reads, in order."""
    found = [node for step in stage.steps for node in needs[step.node]]
    return dict.fromkeys(found + [node for place in stage.outputs for node in entries[place]])


def _uniform(
    used: Iterable[Expr], needs: Mapping[Expr, Sequence[Expr]], everywhere: set[Expr], order: Iterable[RoutineStep]
) -> tuple[RoutineStep, ...]:
    """Return the uniform steps behind what is used, each after what it needs."""
    wanted: set[Expr] = set()
    stack = [node for node in used if node in everywhere]
    while stack:
        node = stack.pop()
        if node not in wanted:
            wanted.add(node)
            stack += needs.get(node, ())
    return tuple(step for step in order if step.node in wanted) if wanted else ()
