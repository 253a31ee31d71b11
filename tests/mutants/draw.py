"""Draw mutants by cosmic-ray's operators: `pip install cosmic-ray`, then `python -m tests.mutants draw`.

Places are drawn, not operators: else most mutants would be the eleven other operators of the same plus sign. What
changes annotations and docstrings alone is no fault and not drawn; what changes more than one line is left out.
"""

from __future__ import annotations

import ast
import random
import subprocess
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from . import Mutant

SEED = 12
COUNT = 400
FILES = ("symdyn/graph/*.py", "symdyn/program/passes.py", "symdyn/dynamics/recursive/*.py")


def draw(root: Path) -> Iterator[str]:
    """Yield the lines of the list."""
    commit = subprocess.run(
        ["git", "-C", str(root), "rev-parse", "--short", "HEAD"], check=True, capture_output=True, text=True
    ).stdout.strip()
    places: dict[tuple[str, tuple[int, int]], list[tuple[str, int, str]]] = defaultdict(list)
    for pattern in FILES:
        for path in sorted(root.glob(pattern)):
            file = path.relative_to(root).as_posix()
            for start, operator, source in mutations(path.read_text(encoding="utf-8")):
                places[file, start].append((operator, *source))
    rng = random.Random(SEED)
    chosen = sorted((where, rng.choice(places[where])) for where in rng.sample(sorted(places), COUNT))
    yield f"# {COUNT} of {len(places)} places of {', '.join(FILES)} at {commit}, seed {SEED}"
    yield "# number, file, line, same lines above, operator, line, what it becomes"
    for number, ((file, _), (operator, index, after)) in enumerate(shuffled(rng, chosen)):
        lines = [text.strip() for text in (root / file).read_text(encoding="utf-8").splitlines()]
        one = Mutant(number, file, index + 1, lines[:index].count(lines[index]), operator, lines[index], after)
        yield "\t".join(map(str, vars(one).values()))


def shuffled(rng: random.Random, found: list) -> list:
    """Return a list in the order in which mutants are run: the first hundred are drawn like all."""
    return rng.sample(found, len(found))


def mutations(source: str) -> Iterator[tuple[tuple[int, int], str, tuple[int, str]]]:
    """Yield place, operator, and index and new text of the line, for all mutants of a file."""
    from cosmic_ray.ast import ast_nodes, get_ast
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator, operator_names

    tree, lines, meaning = get_ast(source), source.splitlines(), bare(source)
    for name in operator_names():
        if get_operator(name).arguments():
            continue
        operator = get_operator(name)()
        places = [start for node in ast_nodes(tree) for start, _ in operator.mutation_positions(node)]
        for occurrence, start in enumerate(places):
            changed = mutate_code(source, operator, occurrence)
            line = one_line(lines, changed.splitlines()) if changed else None
            if line is not None and bare(changed) not in (None, meaning):
                yield start, name.removeprefix("core/"), line


def one_line(before: list[str], after: list[str]) -> tuple[int, str] | None:
    """Return the index of the line that differs and what it becomes, or None if there are more."""
    if len(before) == len(after):
        differ = [k for k, (old, new) in enumerate(zip(before, after, strict=True)) if old != new]
        return (differ[0], after[differ[0]].strip()) if len(differ) == 1 else None
    gone = next((k for k in range(len(before)) if before[:k] + before[k + 1 :] == after), None)
    return None if gone is None else (gone, "")


def bare(source: str) -> str | None:
    """Return a file as a tree without annotations and docstrings, or None if it is no Python."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return None
    for node in ast.walk(tree):
        match node:
            case ast.arg():
                node.annotation = None
            case ast.FunctionDef():
                node.returns = None
            case ast.AnnAssign():
                node.annotation = ast.Constant(None)
        body = getattr(node, "body", None)
        if (
            isinstance(body, list)
            and body
            and isinstance(body[0], ast.Expr)
            and isinstance(body[0].value, ast.Constant)
        ):
            body[0].value.value = None
    return ast.dump(tree)
