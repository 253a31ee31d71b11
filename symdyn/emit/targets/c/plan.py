"""How a batch of states is computed: in which order the loops run and what they hand on to each other.

One routine becomes stages that run one after the other over a block of states. A pass is one loop of plain arithmetic,
which compilers turn into vector code. Sines and cosines are taken a row at a time between two passes, and so are calls
into the C library, which would keep the whole loop from being vectorised. Passes are cut where they grow too long for
a compiler. A value that leaves its stage waits in a row of work space; rows are used again when their value is spent.

What depends on parameters alone, or on what was prepared from them, is uniform: computed once a block, before the loop.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

from symdyn.emit.code.operands import operands
from symdyn.emit.code.schedule import schedule
from symdyn.emit.targets.c.stages import (
    LONGEST,
    TRIGONOMETRIC,
    Constants,
    Stage,
    complete,
    place_outputs,
    stages_of,
)
from symdyn.graph import Expr
from symdyn.program import Routine, RoutineStep, shared


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
        """What it computes, in order."""
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
    """A routine in stages.

    Attributes:
        stages: in running order; the last is a pass.
        rows: how many rows of work space there are.
        names: of inputs and steps, the few added ones included.
    """

    stages: tuple[Pass | SineCosine, ...]
    rows: int
    names: Mapping[Expr, str]

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
    place_outputs(stages, entries)
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
