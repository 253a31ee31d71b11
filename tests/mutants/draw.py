"""Draw mutants by cosmic-ray's operators: `pip install cosmic-ray`, then `python -m tests.mutants draw > drawn.txt`.

A line is drawn, then a place on it, then an operator there: else most mutants would be the eleven other operators of
the same plus sign. Left out is what is no fault by construction: annotations, docstrings, texts of errors, fronts, what
guards against writers (`frozen`, `slots`) or keeps a result (`cache`), lengths that `strict` compares, `is` for `==`.
"""

from __future__ import annotations

import ast
import random
import subprocess
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from . import Mutant, room

SEED = 31
SHARES = {True: 240, False: 160}
"""How many are drawn from the newer rooms, and from all others."""

NEWER = ("identification", "linear", "study", "transcription", "simulation", "verify/written", "emit/targets")
GUARDS = {"frozen", "slots", "strict", "order"}
KEEPERS = {"cache", "lru_cache", "cached_property", "overload", "final"}
SAME = {"Is_Eq", "IsNot_NotEq", "Eq_Is", "NotEq_IsNot"}


def draw(root: Path) -> Iterator[str]:
    """Yield the lines of the list, of which every beginning has from each room its share."""
    show = ["git", "-C", str(root), "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(show, check=True, capture_output=True, text=True).stdout.strip()
    yield f"# drawn at {commit}, seed {SEED}: {SHARES[True]} of {', '.join(NEWER)}, {SHARES[False]} of all others"
    yield "# number, file, line, same lines above, operator, line, what it becomes"
    rng = random.Random(SEED)
    files = [path.relative_to(root).as_posix() for path in sorted((root / "symdyn").rglob("*.py"))]
    texts = {file: (root / file).read_text(encoding="utf-8") for file in files if not file.endswith("__init__.py")}
    by_room: dict[str, list[tuple[str, int, str, str]]] = defaultdict(list)
    for newer, count in SHARES.items():
        all_lines = [
            (file, index)
            for file, text in texts.items()
            if (room(file) in NEWER) == newer
            for index in range(len(text.splitlines()))
        ]
        rng.shuffle(all_lines)
        drawn = ((file, *one) for file, index in all_lines if (one := mutated(texts[file], index, rng)))
        for _, found in zip(range(count), drawn, strict=False):
            by_room[room(found[0])].append(found)
    spread = [((k + rng.random()) / len(found), one) for found in by_room.values() for k, one in enumerate(found)]
    for number, (_, (file, index, operator, after)) in enumerate(sorted(spread)):
        lines = [text.strip() for text in texts[file].splitlines()]
        mutant = Mutant(number, file, index + 1, lines[:index].count(lines[index]), operator, lines[index], after)
        yield "\t".join(map(str, vars(mutant).values()))


def mutated(source: str, index: int, rng: random.Random) -> tuple[int, str, str] | None:
    """Return index, operator and what the line becomes, or None if nothing on it can be a fault of that line alone."""
    from cosmic_ray.ast import ast_nodes, get_ast  # type: ignore[import-not-found, unused-ignore]
    from cosmic_ray.mutating import mutate_code  # type: ignore[import-not-found, unused-ignore]
    from cosmic_ray.plugins import get_operator, operator_names  # type: ignore[import-not-found, unused-ignore]

    if not source.splitlines()[index].strip():
        return None
    nodes = list(ast_nodes(get_ast(source)))
    near = [node for node in nodes if node.start_pos[0] <= index + 1 <= node.end_pos[0]]
    names = [name for name in operator_names() if not get_operator(name).arguments()]
    places: dict[tuple[int, int], list[str]] = defaultdict(list)
    for name in names:
        if not any(name.endswith(f"Operator_{pair}") for pair in SAME):
            for node in near:
                for start, _ in get_operator(name)().mutation_positions(node):
                    if start[0] == index + 1:
                        places[start].append(name)
    for start in rng.sample(sorted(places), len(places)):
        name = rng.choice(places[start])
        operator = get_operator(name)()
        starts = [begin for node in nodes for begin, _ in operator.mutation_positions(node)]
        changed = mutate_code(source, operator, starts.index(start))
        old, new = source.splitlines(), changed.splitlines()
        after = new[index].strip() if len(new) == len(old) else ""
        alone = old[:index] == new[:index] and old[index + 1 :] == new[len(new) - len(old) + index + 1 :]
        if alone and bare(changed) not in (None, bare(source)):
            return index, name.removeprefix("core/"), after
    return None


class Bare(ast.NodeTransformer):
    """Take out what is no fault if it is changed."""

    def generic_visit(self, node: ast.AST) -> ast.AST:
        super().generic_visit(node)
        match node:
            case ast.arg():
                node.annotation = None
            case ast.FunctionDef(body=[ast.Expr(ast.Constant()), *_]) | ast.ClassDef(body=[ast.Expr(), *_]):
                del node.body[0]
            case ast.AnnAssign():
                node.annotation = ast.Constant(None)
            case ast.Raise(exc=ast.Call(func=kind)):
                node.exc = kind
            case ast.Call():
                node.keywords = [word for word in node.keywords if word.arg not in GUARDS]
            case ast.If(test=test) if "TYPE_CHECKING" in ast.dump(test):
                node.body = [ast.Pass()]
                node.test = ast.Constant(True)
        if isinstance(node, ast.FunctionDef):
            node.returns = None
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            node.decorator_list = [
                one for one in node.decorator_list if KEEPERS.isdisjoint(ast.unparse(one).split("("))
            ]
        return node


def bare(source: str) -> str | None:
    """Return a file as a tree without what is no fault, or None if it is no Python."""
    try:
        return ast.dump(Bare().visit(ast.parse(source)))
    except SyntaxError:
        return None
