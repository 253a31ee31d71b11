"""Exercises: chosen results of a document become blanks, and a section at its end solves them.

A page checks an answer by value: `questions` gives it the symbols, points and what each result is worth there, never
the result itself.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from symdyn.algebra.form import ZERO, Form, Symbol, express_form, symbols_of
from symdyn.algebra.numeric import Floats
from symdyn.errors import TeachError
from symdyn.graph import Expr, Graph, Op, evaluate, gradient, reachable
from symdyn.scene import Scene
from symdyn.teach.document import (
    ERRATA,
    Blank,
    Block,
    Box,
    Braced,
    Document,
    Fold,
    Formula,
    Matrix,
    Section,
    Step,
    Words,
)
from symdyn.teach.languages import fill, language_of
from symdyn.teach.practice.hidden import Hidden
from symdyn.teach.shown_state import shown_state
from symdyn.teach.student.statements import read_formula
from symdyn.teach.student.vocabulary import Names, Target
from symdyn.verify import NUMERICAL, PROVED, Claim, prove

CHOSEN = ("square", "potential", "momentum", "slope", "equation", "coefficients", "bivectors", "solved")
"""Steps whose results are asked for: what stands before the colon of their keys."""

EACH = ("coefficients", "bivectors", "solved")
"""Those of which every result is asked for by itself, and the others only for the last one."""

FREE = "potential:"
"""What stands before the keys of blanks whose results hold a constant that is free."""

POINTS = 6
TWINS = 4  # further points, with the parameters of the first and another position
LONGEST = 60  # symbols of an answer that anyone types
MOST = 6  # coefficients of one kind that are asked for; the others are shown


def with_exercises(document: Document) -> Document:
    """Return the document with blanks in place of chosen results, and their solutions as its last section.

    Raises:
        TeachError: there is no result that could be left out.
    """
    found = {step.key: asked for section in document.sections for step in section.steps
             if (asked := _asked(document, step)) is not None}  # fmt: skip
    hidden = Hidden(document, list(found.values()))
    solved: list[Step] = []
    sections = []
    for section in document.sections:
        steps = []
        for step in section.steps:
            asked = found.get(step.key, step)
            solved += [_solution(document, block) for block in asked.blocks if isinstance(block, Blank)]
            if step.key.startswith(ERRATA):
                if step.key.removeprefix(ERRATA) in found or hidden.parts(step)[1]:  # they say what is right
                    solved.append(_folded(document, step.key, Words(()), step.blocks))
                else:
                    steps.append(step)
                continue
            kept, told = hidden.parts(asked)
            if told:
                solved.append(_folded(document, f"follows:{step.key}", step.claim, told))
                kept.append(Words((language_of(document.language).lesson["exercise.later"],)))
            steps.append(replace(asked, blocks=tuple(kept)))
        sections.append(replace(section, steps=tuple(steps)))
    if not solved:
        raise TeachError(
            f"{document.scene.name}: nothing in this walkthrough can be left out; give a later part with --until, "
            "or leave --until out"
        )
    sections.append(Section("solutions", language_of(document.language).lesson["section.solutions"], tuple(solved)))
    return replace(document, sections=tuple(sections))


def _asked(document: Document, step: Step) -> Step | None:
    """Return the step with blanks for its results; None if it has none that can be asked for."""
    kind = step.key.partition(":")[0]
    if kind not in CHOSEN:
        return None
    results = {block: answer for block in step.blocks if (answer := answer_of(document, block)) is not None}
    if kind == "coefficients":
        results = dict(list(results.items())[:MOST])
    if kind == "solved":  # of all reactions only the drives, which the scene names
        drives = {drive for drive in document.scene.drives if drive}
        results = {block: answer for block, answer in results.items() if answer[0] in drives}
    if not results:
        return None
    if kind in EACH:
        blocks = [
            _blank(document, step, results[block], (block,)) if block in results else block for block in step.blocks
        ]
        return replace(step, blocks=tuple(blocks))
    return replace(step, blocks=(_blank(document, step, list(results.values())[-1], step.blocks),), reason=Words(()))


def answer_of(document: Document, block: Block) -> tuple[str, Form] | None:
    """Return the name and the result of a block, if it is written in not too many symbols of the scene alone.

    Of an inertia bivector (5.17) it is the last entry that is not zero.
    """
    if isinstance(block, Matrix):
        found = [pair for pair in zip(block.names, block.entries, strict=True) if pair[1] != ZERO]
        return found[-1] if found and block.number == "5.17" and _plain(document, found[-1][1]) else None
    if not isinstance(block, (Formula, Braced)):
        return None
    key = block.value if isinstance(block, Braced) else block.left
    name = document.names.get(key)
    if name is None or name.node is None:
        return None
    forms = [block.form, *([block.right] if isinstance(block, Formula) and block.right is not None else [])]
    plain = [form for form in forms if _plain(document, form)]
    return (key, plain[-1]) if plain else None


def _plain(document: Document, form: Form) -> bool:
    return 0 < len(found := symbols_of(form)) <= LONGEST and set(found) <= set(Names(document.scene).symbols.values())


def _blank(document: Document, step: Step, result: tuple[str, Form], solution: Sequence[Block]) -> Blank:
    texts, (key, answer) = language_of(document.language).lesson, result
    kind = step.key.partition(":")[0]
    shown = next((b.left for b in solution if isinstance(b, Braced) and b.value == key and b.left != ZERO), Symbol(key))
    ask = Words(fill(texts["exercise.ask"], {"left": shown}))
    hint = Words((texts[f"exercise.hint.{kind}"],))
    return Blank(f"{step.key}:{key}" if kind in EACH else step.key, ask, key, answer, hint, tuple(solution))


def _solution(document: Document, blank: Blank) -> Step:
    texts = language_of(document.language).lesson
    claim = Words(fill(texts["exercise.solved"], {"left": Symbol(blank.left)}))
    return _folded(document, f"solution:{blank.key}", claim, blank.solution)


def _folded(document: Document, key: str, claim: Words, blocks: Sequence[Block]) -> Step:
    summary = Words((language_of(document.language).lesson["exercise.solution"],))
    if isinstance(blocks[0], Box):
        summary = blocks[0].title
    return Step(key, claim, (Fold(summary, tuple(blocks)),))


def judge(document: Document, key: str, text: str) -> str:
    """Return whether a typed answer to a blank, plain text or LaTeX, is right, in the language of the document.

    Raises:
        TeachError: there is no such blank.
    """
    blanks = {block.key: block for _, block in document.blocks() if isinstance(block, Blank)}
    if key not in blanks:
        raise TeachError(f"there is no exercise {key!r}; there are {', '.join(blanks)}")
    words = language_of(document.language).lesson
    if not text.strip():
        return words["fault.empty"]
    try:
        form = read_formula(text, document.scene)
    except TeachError as fault:
        return str(fault)
    named = [name for name in symbols_of(form) if name in map(str, quantities(Names(document.scene)).values())]
    if named:
        return words["fault.quantity"].format(text=named[0])
    graph = Graph()
    typed, right = express_form(form, graph), express_form(blanks[key].answer, graph)
    same, turned = (
        Claim("same", "typed", "answer", (typed,), (right,)),
        Claim("turned", "typed", "-", (-typed,), (right,)),
    )
    verdicts = [finding.verdict in (PROVED, NUMERICAL) for finding in prove([same, turned])[1]]
    if not verdicts[0] and _lies_elsewhere(document.scene, blanks[key], typed, right):
        return words["answer.shifted"]
    return words["answer.right" if verdicts[0] else "answer.turned" if verdicts[1] else "answer.wrong"]


def _lies_elsewhere(scene: Scene, blank: Blank, typed: Expr, right: Expr) -> bool:
    """Whether a potential energy that changes with position differs from the answer by what does not."""
    moving = [typed.graph.symbol(name) for name in (*scene.coordinates, *scene.velocities)]
    slopes = list(zip(gradient(typed, moving), gradient(right, moving), strict=True))
    if not blank.key.startswith(FREE) or all(x.is_zero for _, x in slopes):
        return False
    claims = [Claim(f"{k}", "typed", "answer", (mine,), (x,)) for k, (mine, x) in enumerate(slopes)]
    return all(finding.verdict in (PROVED, NUMERICAL) for finding in prove(claims)[1])


def quantities(names: Names) -> dict[str, Target]:
    """Return what may be claimed and is no symbol of the scene, by plain name: y1, k_z21, K."""
    return {word: target for word, target in names.targets.items() if word not in names.symbols}


# What a page is told


def questions(document: Document) -> dict[str, Any]:
    """Return what a page needs to check answers, as JSON takes it; empty for a document without blanks.

    Returns:
        symbols: the scene's name of every way to write one, dotted: velocity and acceleration of coordinates, short:
        shorthands such as c12, quantities: names of results, points: values of all symbols: six drawn
        ones, those of `twins` with the parameters of the first and another position, then parameters as declared;
        values: for each blank its value at every point, free: blanks that a constant may be added to, words.
    """
    blanks = {block.key: block for _, block in document.blocks() if isinstance(block, Blank)}
    if not blanks:
        return {}
    names = Names(document.scene)
    nodes = {key: document.value(blank.answer) for key, blank in blanks.items()}
    every = list(dict.fromkeys(names.symbols.values()))
    points = [dict(zip(every, _drawn(every, k), strict=True)) for k in range(POINTS)]
    moving = {*document.scene.coordinates, *names.rates}
    points += [
        point | {name: value for name, value in zip(every, _drawn(every, POINTS + k), strict=True) if name in moving}
        for k, point in enumerate(points[:TWINS])
    ]
    symbols = [x for x in reachable(list(nodes.values())) if x.op is Op.SYMBOL]
    given = shown_state(document.scene).parameters
    bound = {p.name: given[p.name] for p in document.scene.parameters if p.value is not None and p.name in every}
    points += [point | bound for point in points[:2]] if bound else []
    values = []
    for point in points:
        seeds = {x: point[str(x.value)] for x in symbols}
        values.append(evaluate(list(nodes.values()), Floats(), seeds))
    said = language_of(document.language).lesson
    return {
        "symbols": dict(names.symbols),
        "dotted": {q: list(rates) for q, rates in names.dotted.items()},
        "short": {key: [form.op.name.lower(), symbols_of(form)] for key, form in names.shorthands.items()},  # type: ignore[union-attr]
        "quantities": {word: str(target) for word, target in quantities(names).items()},
        "drawn": POINTS,
        "twins": TWINS,
        "free": [key for key in blanks if key.startswith(FREE)],
        "points": points,
        "values": {key: [float(f"{value[i]:.12g}") for value in values] for i, key in enumerate(nodes)},
        "words": {key: text for key, text in said.items() if key.startswith(("answer.", "fault."))},
    }


def _drawn(names: Sequence[str], k: int) -> list[float]:
    """Return the values of a point: between 1/4 and 2, the same in every run."""
    return [round(random.Random(f"{k}:{name}").uniform(0.25, 2.0), 6) for name in names]
