"""The commonest connected sub-patterns of emitted inverse dynamics, and a search for forms with fewer operations.

    python benchmarks/sub_patterns.py [--operations 5] [--shown 30]

A pattern is one operation and some of those below it, up to names and signs of what goes in: x is an input, y! is used
elsewhere too and has to be kept. One in which every input stands once is told as read once: m inputs that all matter
need m - 1 operations, so that nothing can be cheaper. For the rest all programs with fewer operations are tried, values
at one random point modulo 2^61 - 1 standing for expressions; two that differ agree there with a chance of about 1e-17.
"""

from __future__ import annotations

import argparse
import random
import re
from collections import Counter
from collections.abc import Iterator, Sequence

import operation_counts
from cases import chain

from symdyn.graph import Expr, Op, reachable
from symdyn.program import formulate, lower
from symdyn.scene import Scene, read

PRIME = (1 << 61) - 1
SPELLED = {Op.ADD: "+", Op.SUB: "-", Op.MUL: "*"}
EXAMPLES = ("arm7", "quadruped")
TRIED = 6
"""Operations up to which all programs are tried."""

Node = tuple[str, tuple[int, ...]]
"""An operation and what it takes; an input takes nothing."""


def scenes() -> Iterator[Scene]:
    """Yield the robots of the operation counts, examples and a chain."""
    yield from (scene for *_, scene in operation_counts.cases())
    yield from (read(operation_counts.ROOT / "examples" / f"{name}.toml") for name in EXAMPLES)
    yield chain(8)


def _bare(node: Expr) -> Expr:
    return node.args[0] if node.op is Op.NEG else node


def patterns(scene: Scene, most: int) -> Iterator[str]:
    """Yield the patterns of 3 to `most` operations in emitted inverse dynamics, one for every place."""
    (routine,) = lower(formulate(scene, ["inverse_dynamics"])).routines
    entries = routine.function.entries
    nodes = [node for node in reachable(entries) if node.op is not Op.NEG]
    uses = Counter([_bare(arg) for node in nodes for arg in node.args] + [_bare(entry) for entry in entries])
    parameters = {one for a in routine.function.arguments if a.name == "params" for one in a.symbols}
    state = set[Expr]()
    for node in nodes:
        if (node.op is Op.SYMBOL and node not in parameters) or any(_bare(arg) in state for arg in node.args):
            state.add(node)
    inner = {node for node in state if node.op in SPELLED}
    for root in (node for node in nodes if node in inner):
        todo = [frozenset([root])]
        seen = set(todo)
        while todo:
            part = todo.pop()
            if len(part) > 2:
                yield _text(root, part, uses)
            more = {_bare(arg) for node in part for arg in node.args} & inner - part if len(part) < most else ()
            new = {part | {one} for one in more} - seen
            seen |= new
            todo += new


def _text(root: Expr, part: frozenset[Expr], uses: Counter[Expr]) -> str:
    names: dict[Expr, str] = {}
    inside = Counter(_bare(arg) for node in part for arg in node.args)

    def text(node: Expr) -> str:
        if node in names or node not in part:
            return names.setdefault(node, f"x{len(names)}")
        a, b = (("-" if arg.op is Op.NEG else "") + text(_bare(arg)) for arg in node.args)
        whole = f"({a}{SPELLED[node.op]}{b})"
        if node is root or uses[node] == 1:
            return whole
        names[node] = f"y{len(names)}"
        return f"[{names[node]}{'!' if uses[node] > inside[node] else ''}={whole}]"

    return text(root)


def values(pattern: str) -> tuple[list[int], list[int]]:
    """Return the inputs of a pattern at a random point, and what is to be computed of them, modulo `PRIME`."""
    chance = random.Random(1)
    env = {name: chance.randrange(PRIME) for name in sorted(set(re.findall(r"x\d+", pattern)))}
    inputs, wanted, at = list(env.values()), list[int](), 0

    def value() -> int:
        nonlocal at
        if pattern[at] == "-":
            at += 1
            return -value() % PRIME
        if found := re.compile(r"\[(y\d+)(!?)=").match(pattern, at):
            at = found.end()
            env[found[1]] = value()
            at += 1
            wanted.extend([env[found[1]]] if found[2] else [])
            return env[found[1]]
        if pattern[at] == "(":
            at += 1
            a, op = value(), pattern[at]
            at += 1
            b = value()
            at += 1
            return (a + b if op == "+" else a - b if op == "-" else a * b) % PRIME
        name = re.compile(r"[xy]\d+").match(pattern, at)
        assert name is not None, pattern
        at = name.end()
        return env[name[0]]

    wanted.append(value())
    return inputs, wanted


def cheaper(known: Sequence[int], wanted: Sequence[int], steps: int) -> bool:
    """Tell whether `steps` sums, differences and products give all that is wanted, up to signs."""
    have = {min(x, PRIME - x) for x in known}
    missing = [x for x in {min(x, PRIME - x) for x in wanted} if x not in have]
    if not missing or steps < len(missing):
        return not missing
    new = {v for i, a in enumerate(known) for b in known[i:] for v in (a + b, a - b, a * b)}
    new = {min(v % PRIME, -v % PRIME) for v in new} - have - {0}
    if steps == len(missing):  # nothing but what is missing can be computed
        new &= set(missing)
    if steps == 1:
        return bool(new)
    return any(cheaper([*known, v], missing, steps - 1) for v in new)


def main() -> int:
    """Print the table."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    asked.add_argument("--operations", type=int, default=5, help="of the largest patterns")
    asked.add_argument("--shown", type=int, default=30, help="patterns of each kind and size")
    given = asked.parse_args()
    tally = Counter(one for scene in scenes() for one in patterns(scene, given.operations))
    shown = Counter[tuple[int, bool]]()
    for pattern, times in sorted(tally.items(), key=lambda one: (-one[1], one[0])):
        size, (inputs, wanted) = sum(map(pattern.count, "+*")) + len(re.findall(r"[\d\])]-", pattern)), values(pattern)
        once = len(inputs) == size + 1
        shown[size, once] += 1
        if shown[size, once] > given.shown:
            continue
        if once:
            verdict = "read once"
        else:
            verdict = "not tried" if size > TRIED else "CHEAPER" if cheaper(inputs, wanted, size - 1) else "none"
        print(f"{size} operations, {times:4} times, {verdict:9}  {pattern}", flush=True)
    print(f"{len(tally)} patterns in {sum(tally.values())} places")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
