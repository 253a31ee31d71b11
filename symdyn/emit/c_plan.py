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
from fractions import Fraction
from heapq import heappop, heappush

from symdyn.graph import Expr, Op
from symdyn.program import Routine, Step
from symdyn.program.assemble import shared

Constants = Mapping[Expr, Fraction]

LONGEST = 1200
"""Operations up to which a routine stays one loop. 7 axes need half of them."""
PIECE = 400
"""Operations of one loop of a longer routine: time to compile grows faster than its length."""

TRIGONOMETRIC = (Op.SIN, Op.COS)
CALLS = (*TRIGONOMETRIC, Op.EXP, Op.LOG, Op.TANH, Op.ATAN2)


@dataclass(frozen=True)
class Pass:
    """One loop over the states of a block.

    Attributes:
        plain: whether it is arithmetic alone, and so fit for vectors.
        inputs: entries of arguments that it reads.
        loads, stores: (step, row) of what comes from and goes to other stages.
        steps: what it computes, in order.
        outputs: places of the entries of the result that it writes.
        uniform: steps and parameters that are computed before the loop.
    """

    plain: bool
    inputs: tuple[Step, ...]
    loads: tuple[tuple[Step, int], ...]
    steps: tuple[Step, ...]
    stores: tuple[tuple[Step, int], ...]
    outputs: tuple[int, ...]
    uniform: tuple[Step, ...]


@dataclass(frozen=True)
class SineCosine:
    """Sine and cosine of one row.

    Attributes:
        angle: an input, or a step in a row.
        row: where the angle stands; None for an input.
        sine, cosine: the step and its row; None for the step where only the other one is asked for.
    """

    angle: Step
    row: int | None
    sine: tuple[Step | None, int]
    cosine: tuple[Step | None, int]


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


@dataclass
class _Stage:
    """A stage in the making; `kind` is "pass", "sincos" or "call"."""

    kind: str
    steps: list[Step]
    outputs: list[int]
    angle: Expr | None = None


def plan(routine: Routine, known: Constants) -> Plan:
    """Return the stages of `routine`.

    Args:
        routine: what to compute.
        known: nodes that are constants.
    """
    steps = _complete(routine, known)
    named = {step.node: step.name for step in (*routine.inputs, *steps)}
    needs = {step.node: _needs(step.node.args, named, known) for step in steps}
    common = shared([argument.name for argument in routine.function.arguments])
    everywhere = {s for a in routine.function.arguments if a.name == common for s in a.symbols}
    for step in steps:
        if all(node in everywhere for node in needs[step.node]):
            everywhere.add(step.node)
    varying = [step for step in steps if step.node not in everywhere]
    stages = _stages(varying, needs, named, known)
    entries = [_needs((entry,), named, known) for entry in routine.function.entries]
    _place_outputs(stages, entries)
    return _finish(routine, steps, stages, needs, entries, everywhere, named)


def _complete(routine: Routine, known: Constants) -> list[Step]:
    """Return the steps with a name for every call and for whatever is called with."""
    taken = {step.name for step in (*routine.inputs, *routine.steps)}
    named = {step.node for step in (*routine.inputs, *routine.steps)}
    steps: list[Step] = []

    def add(node: Expr) -> None:
        number = 1 + sum(step.name not in taken for step in steps)
        while f"y{number}" in taken:
            number += 1
        named.add(node)
        steps.append(Step(f"y{number}", node))

    def lift(node: Expr) -> None:  # as deep as a line is wide
        if node in named or node in known:
            return
        below(node)
        if node.op in CALLS:
            add(node)

    def below(node: Expr) -> None:
        for arg in node.args:
            lift(arg)
            if node.op in CALLS and arg not in named and arg not in known:
                add(arg)

    for step in routine.steps:
        below(step.node)
        steps.append(step)
    for entry in routine.function.entries:
        lift(entry)
    return steps


def _needs(nodes: Iterable[Expr], named: Mapping[Expr, str], known: Constants) -> tuple[Expr, ...]:
    """Return the named nodes that stand in the text of `nodes`."""
    found: dict[Expr, None] = {}
    stack = list(nodes)[::-1]
    while stack:
        node = stack.pop()
        if node in named:
            found[node] = None
        elif node not in known:
            stack += node.args[::-1]
    return tuple(found)


def _operations(step: Step, named: Mapping[Expr, str], known: Constants) -> int:
    """Return how many operations one line holds."""
    total, stack = 1, list(step.node.args)
    while stack:
        node = stack.pop()
        if node not in named and node not in known:
            total += 1
            stack += node.args
    return total


def _stages(
    steps: Sequence[Step],
    needs: Mapping[Expr, Sequence[Expr]],
    named: Mapping[Expr, str],
    known: Constants,
) -> list[_Stage]:
    """Return the stages: what calls wait for as early as can be, all the rest after the last call."""
    level: dict[Expr, int] = {}
    for step in steps:
        level[step.node] = max((level.get(n, 0) for n in needs[step.node]), default=0) + (step.node.op in CALLS)
    early: set[Expr] = set()
    for step in reversed(steps):
        if step.node.op in CALLS or step.node in early:
            early.update(needs[step.node])
    last = max(level.values(), default=0)
    stages: list[_Stage] = []
    for here in range(last + 1):
        calls = [s for s in steps if s.node.op in CALLS and level[s.node] == here]
        angles = dict.fromkeys(s.node.args[0] for s in calls if s.node.op in TRIGONOMETRIC)
        stages += [
            _Stage("sincos", [s for s in calls if s.node.op in TRIGONOMETRIC and s.node.args[0] is angle], [], angle)
            for angle in angles
        ]
        stages += [_Stage("call", [s], []) for s in calls if s.node.op not in TRIGONOMETRIC]
        plain = (s for s in steps if s.node.op not in CALLS)
        mine = [s for s in plain if here == (level[s.node] if s.node in early else last)]
        if mine or here == last:
            stages += _cut(mine, [_operations(s, named, known) for s in mine])
    return stages


def _cut(steps: Sequence[Step], sizes: Sequence[int]) -> list[_Stage]:
    """Return `steps` as passes of about equal length; one pass unless that is too long."""
    total = sum(sizes)
    count = 1 if total <= LONGEST else -(-total // PIECE)
    passes = [_Stage("pass", [], []) for _ in range(count)]
    done = 0
    for step, size in zip(steps, sizes, strict=True):
        passes[min(count - 1, done * count // max(total, 1))].steps.append(step)
        done += size
    return passes


def _place_outputs(stages: Sequence[_Stage], entries: Sequence[Sequence[Expr]]) -> None:
    """Let every entry of the result be written by the first pass that has all it needs; constants by the last one."""
    born = {step.node: i for i, stage in enumerate(stages) for step in stage.steps}
    passes = [i for i, stage in enumerate(stages) if stage.kind == "pass"]
    for place, needed in enumerate(entries):
        ready = max((born[node] for node in needed if node in born), default=len(stages) - 1)
        stages[next(i for i in passes if i >= ready)].outputs.append(place)


def _finish(
    routine: Routine,
    steps: Sequence[Step],
    stages: Sequence[_Stage],
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
            pair: list[tuple[Step | None, int]] = []
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
                    steps=tuple(stage.steps),
                    stores=tuple((s, row[s.node]) for s in kept),
                    outputs=tuple(stage.outputs),
                    uniform=_uniform(used[i], needs, everywhere, (*routine.inputs, *steps)),
                )
            )
        for number in (*spare, *(row[n] for n in used[i] if n in row and last_use[n] == i)):
            heappush(free, number)
    return Plan(tuple(done), rows, named)


def _used(stage: _Stage, needs: Mapping[Expr, Sequence[Expr]], entries: Sequence[Sequence[Expr]]) -> dict[Expr, None]:
    """Return what a stage reads, in order."""
    found = [node for step in stage.steps for node in needs[step.node]]
    return dict.fromkeys(found + [node for place in stage.outputs for node in entries[place]])


def _uniform(
    used: Iterable[Expr], needs: Mapping[Expr, Sequence[Expr]], everywhere: set[Expr], order: Iterable[Step]
) -> tuple[Step, ...]:
    """Return the uniform steps behind what is used, each after what it needs."""
    wanted: set[Expr] = set()
    stack = [node for node in used if node in everywhere]
    while stack:
        node = stack.pop()
        if node not in wanted:
            wanted.add(node)
            stack += needs.get(node, ())
    return tuple(step for step in order if step.node in wanted)
