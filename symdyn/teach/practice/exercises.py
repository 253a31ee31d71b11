"""Exercises: results of a document become blanks; what comes after one needs it answered or given up.

A page checks an answer by value: `questions` gives it the symbols, points and what each result is worth there, never
the result itself.

Until they are answered what comes after them stays hidden, and what is worth the same. The rule is the order of the
derivation: a step may follow from every result before it, unless it is about another mass or body, or a row of `APART`
says otherwise. So a new kind of step leaks nothing before anyone thinks of exercises.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import isclose

from symdyn.algebra import Form, Number, Symbol
from symdyn.arguments import argument
from symdyn.errors import TeachError, choice
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, gradient, reachable
from symdyn.scene import Scene
from symdyn.table import Table
from symdyn.teach.document import (
    ERRATA,
    Blank,
    Block,
    Box,
    Braced,
    Choice,
    Document,
    Fold,
    Formula,
    Matrix,
    Questions,
    Section,
    Step,
    Words,
)
from symdyn.teach.languages import fill, language_of
from symdyn.teach.mathematics import Spelling
from symdyn.teach.practice.asked import with_physics
from symdyn.teach.practice.derived import with_given
from symdyn.teach.practice.physics import PHYSICS
from symdyn.teach.student.course import acting
from symdyn.teach.student.diagnosis import Diagnosis
from symdyn.teach.student.grammar import Names, Target
from symdyn.teach.student.mistakes import FREE
from symdyn.teach.student.motions import at_points
from symdyn.teach.student.statements import read_formula
from symdyn.verdict import Verdict
from symdyn.verify import Claim, prove

MASS = ("position", "rotation", "turning", "velocity", "square", "spin", "offset", "kinetic", "potential")
BODY = ("free", "frame", "moved", "about", "bivectors", "balance", "substituted")
OF_ONE = (*MASS, *BODY)
"""Kinds of steps about one mass or body, which is what stands behind the colon of their keys."""

APART = {
    "potential": ("velocity", "turning", "square", "spin", "offset", "kinetic"),
    "rotation": ("position",),
    "turning": ("position", "velocity"),
    "spin": ("position", "velocity", "square"),
    "rotor": MASS,
    "springs": MASS,
}
"""Kinds of steps that come after others and do not follow from them."""


def follows(step: str, requested: str) -> bool:
    """Whether a step, by its key, may follow from another one that comes before it."""
    kind, _, of = step.removeprefix(ERRATA).partition(":")
    source, _, other = requested.partition(":")
    if kind in OF_ONE and source in OF_ONE and of != other:
        return False
    return source not in APART.get(kind, ())


def plain(form: Form, own: frozenset[str]) -> bool:
    """Whether a form is written out: more than a name or a number, in symbols of the scene alone."""
    found = set(form.symbols)
    return bool(found) and found <= own and not isinstance(form.split_sign()[1], Symbol)


def own_symbols(document: Document) -> frozenset[str]:
    """Return the symbols of the scene, without those that the document gives a value, such as drives."""
    return frozenset(Names(document.scene).symbols.values()) - {k for k, x in document.names.items() if x.node}


class Hidden:
    """Answers by value, to find where else one of them stands."""

    def __init__(self, document: Document, answers: Mapping[str, Form]) -> None:
        """Begin with the answers by keys of blanks."""
        self.document, self.own = document, own_symbols(document)
        self.points: list[dict[str, float]] = [{}, {}]
        self.answers = {key: self._values(document.value(form)) for key, form in answers.items()}

    def by(self, step: Step) -> Iterator[str]:
        """Yield the blanks that a step gives away: a formula in it is worth the answer, its sign apart."""
        forms = [form for block in (step.claim, *step.blocks, step.reason) for form in written_out(block)]
        found = [self._values(self.document.value(form)) for form in forms if plain(form, self.own)]
        for key, answer in self.answers.items():
            if any(self._alike(one, answer, sign) for one in found for sign in (1, -1)):
                yield key

    @staticmethod
    def _alike(result: list[float], answer: list[float], sign: int) -> bool:
        return all(isclose(x, sign * y, rel_tol=1e-9, abs_tol=1e-12) for x, y in zip(result, answer, strict=True))

    def _values(self, node: Expr) -> list[float]:
        """Return the values at points that are the same for all, NaN where there is none, which is like nothing."""
        for name in (str(x.value) for x in reachable([node]) if x.op is Op.SYMBOL):
            for k, point in enumerate(self.points):
                point.setdefault(name, random.Random(f"{k}:{name}").uniform(0.25, 2.0))
        return at_points([node], self.points)[0]


def written_out(block: Block) -> Iterator[Form]:
    """Yield the right-hand sides of a block, of tables and prose all forms; of what is asked nothing."""
    if isinstance(block, Formula):
        yield from (form for form in (block.form, block.right) if form is not None)
    elif isinstance(block, Braced):
        yield from (block.form, *(term.form for term in block.terms))
    elif isinstance(block, Matrix):
        yield from block.entries
    elif isinstance(block, (Box, Fold)):
        yield from (form for inner in block.blocks for form in written_out(inner))
    elif isinstance(block, Questions):
        yield from (part for part in block.ask.parts if not isinstance(part, str))
    elif isinstance(block, (Table, Words)):
        cells = [cell for row in block.rows for cell in row] if isinstance(block, Table) else [block]
        yield from (part for cell in cells for part in cell.parts if not isinstance(part, str))


RESULTS = ("square", "potential", "momentum", "rate", "slope", "equation", "coefficients", "bivectors", "solved",
           "derived", "result")  # fmt: skip
"""Kinds of steps, what stands before the colon of their keys, that end a part of the derivation."""


@dataclass(frozen=True)
class Grade:
    """How much a student is left to do."""

    kinds: tuple[str, ...]  # the kinds of steps whose results are asked for; none for all
    alone: bool = False  # whether the way to a result is hidden with it


GRADES: Mapping[int, Grade] = {
    1: Grade(()),  # every step to the equations and coefficients, each from the one before it
    2: Grade(RESULTS),
    3: Grade(("energies", "lagrangian", "equation", "solved", "result"), alone=True),
}

ASIDE = ("meaning", "power")
"""Kinds of steps that are asked for when they alone are named, as are those after the equations."""

AFTER = ("after", "numbers")
"""What keys of sections after the equations begin with."""

LATER = ("formulations", "laws", "errata")
"""Sections that come after all derivations."""

GIVEN = ("scene", "principle", "count")
"""Sections that state what is known, which no grade hides."""

LONGEST = 60  # symbols of an answer that anyone types
MOST = 6  # results of one step that are asked for; the others stand with the solutions


def with_exercises(document: Document, grade: int = 2, ask: Collection[str] = ()) -> Document:
    """Return the document with blanks in place of results, then questions of physics; what comes after one needs it.

    Args:
        document: a walkthrough.
        grade: 1 for every step, 2 for the results of each part, 3 for energies and equations without the steps.
        ask: steps, by key or kind ("square:2", "square", "physics"), that are asked for in place of those of the
            grade.

    Raises:
        TeachError: there is no such grade or step, or no result that could be left out.
    """
    if grade not in GRADES:
        raise TeachError(f"there is no grade {grade}; give one of {', '.join(map(str, GRADES))}")
    every = {step.key: (part, step) for part in document.sections if not is_given(part) for step in part.steps}
    results = {key: found for key, (_, step) in every.items() if (found := _results(document, step))}
    document, physics = with_physics(document)
    of_physics = [step.key for step in physics.steps] if physics else []
    if not results and not of_physics:
        raise TeachError(
            f"{document.scene.name}: nothing in this walkthrough can be left out; give a later part with "
            f"{argument('until')}, or leave it out"
        )
    kinds = ask or GRADES[grade].kinds
    known = {name for key in (*results, *of_physics) for name in (key, _kind(key))}
    if missing := sorted(set(ask) - known):
        listed = ", ".join(dict.fromkeys(map(_kind, (*results, *of_physics))))
        raise TeachError(f"{document.scene.name}: {', '.join(missing)} cannot be asked for here; give some of {listed}")
    chosen = {key for key in results if key in kinds or _kind(key) in kinds}
    if not kinds:
        chosen = {key for key in results if _kind(key) not in ASIDE and not every[key][0].key.startswith(AFTER)}
    asked_physics = {key for key in of_physics if not ask or key in ask or _kind(key) in ask}
    chosen = chosen or {key for key in results if _kind(key) in RESULTS and not (ask and asked_physics)}
    alone = GRADES[grade].alone and not ask
    sections = [_asked(document, part, results, chosen, alone) for part in document.sections]
    sections = _joined(sections) if alone and chosen else sections
    if physics and asked_physics:
        steps = tuple(step for step in physics.steps if step.key in asked_physics)
        place = next((k for k, one in enumerate(sections) if one.key.startswith((*AFTER, *LATER))), len(sections))
        sections.insert(place, replace(physics, steps=steps))
    return with_given(replace(document, sections=tuple(_gated(document, sections))))


def is_given(section: Section) -> bool:
    """Whether a section states what is known."""
    return section.key.partition(".")[0] in GIVEN


def _kind(key: str) -> str:
    return key.partition(":")[0]


# What is asked for

Results = Mapping[int, tuple[str, Form]]
"""By number of the block: what it is called and its answer."""


def _results(document: Document, step: Step) -> Results:
    """Return the results of a step, the last one of each quantity."""
    last = {answer[0]: (k, answer) for k, block in enumerate(step.blocks) if (answer := answer_of(document, block))}
    found = [last[name] for name in last if _kind(step.key) != "solved" or name in document.scene.drives]
    return dict(found[:MOST])


def answer_of(document: Document, block: Block) -> tuple[str, Form] | None:
    """Return the name and the result of a block, if it is written in not too many symbols of the scene alone.

    Of an inertia bivector (5.17) it is the last entry that is not zero.
    """
    if isinstance(block, Matrix):
        found = [pair for pair in zip(block.names, block.entries, strict=True) if pair[1] != Number.ZERO]
        inertial = block.names[-1].startswith("MD:")
        return found[-1] if found and inertial and _typed(document, found[-1][1]) else None
    if not isinstance(block, (Formula, Braced)):
        return None
    key = block.value if isinstance(block, Braced) else block.left
    name = document.names.get(key)
    if name is None or name.node is None:
        return None
    forms = [block.form, *([block.right] if isinstance(block, Formula) and block.right is not None else [])]
    found_forms = [form for form in forms if _typed(document, form)]
    return (key, found_forms[-1]) if found_forms else None


def _typed(document: Document, form: Form) -> bool:
    """Whether a form is a result that is typed."""
    found = form.symbols
    known = set(Names(document.scene).symbols.values())
    return 0 < len(found) <= LONGEST and set(found) <= known and not isinstance(form.split_sign()[1], Symbol)


def _asked(
    document: Document, section: Section, results: Mapping[str, Results], chosen: Collection[str], alone: bool
) -> Section:
    """Return the section with blanks in its chosen steps."""
    steps = [_with_blanks(document, x, results[x.key], alone) if x.key in chosen else x for x in section.steps]
    return replace(section, steps=tuple(steps))


def _with_blanks(document: Document, step: Step, results: Results, alone: bool) -> Step:
    """Return a step with its results left out: definitions in names stay, all else is part of a solution."""
    own, kept = own_symbols(document), list[Block]()
    one, solution = len(results) == 1, list[Block]()
    for k, block in enumerate(step.blocks):
        if k in results:
            solution.append(block)
            kept.append(_blank(document, step, results[k], one, solution, alone))
            solution = []
        elif not alone and _names_only(block, own):
            kept.append(block)
        else:
            solution.append(block)
    rest = [*solution, *([step.reason] if step.reason.parts else [])]
    last = max(k for k, block in enumerate(kept) if isinstance(block, Blank))
    blank = kept[last]
    assert isinstance(blank, Blank), "a step that is asked for has a blank"
    kept[last] = replace(blank, solution=(*blank.solution, *rest))
    claim = Words(()) if any(plain(form, own) for form in written_out(step.claim)) else step.claim
    return replace(step, claim=claim, blocks=tuple(kept), reason=Words(()))


def _names_only(block: Block, own: frozenset[str]) -> bool:
    """Whether a block is a definition: one formula, with a quantity in it that only has a name."""
    forms = list(written_out(block))
    return isinstance(block, Formula) and all(set(form.symbols) - own for form in forms)


def _blank(
    document: Document, step: Step, result: tuple[str, Form], one: bool, solution: Sequence[Block], alone: bool
) -> Blank:
    texts, (key, answer) = language_of(document.language).lesson, result
    shown = next((b.left for b in solution if isinstance(b, Braced) and b.value == key), None)
    if shown is None:
        shown = (acting(document.scene, int(key[4:]) - 1) if key.startswith("tau:") else None) or Symbol(key)
    hints = ("exercise.hint.alone",) if alone else (f"exercise.hint.{_kind(step.key)}", "exercise.hint.other")
    hint = next(texts[name] for name in hints if name in texts)
    name = step.key if one else f"{step.key}:{key}"
    asked = Words(fill(texts["exercise.zero" if shown == Number.ZERO else "exercise.ask"], {"left": shown}))
    return Blank(name, asked, key, shown, answer, Words((hint,)), tuple(solution))


# What is shown when


def _joined(sections: Sequence[Section]) -> list[Section]:
    """Return the sections with the way to each result as the beginning of its solution."""
    way: list[Block] = []
    found = []
    for section in sections:
        steps = []
        for step in section.steps:
            blanks = [k for k, block in enumerate(step.blocks) if isinstance(block, Blank)]
            if is_given(section):
                steps.append(step)
            elif blanks:
                blocks = list(step.blocks)
                blank = blocks[blanks[0]]
                assert isinstance(blank, Blank), "its number says so"
                blocks[blanks[0]] = replace(blank, solution=(*way, *blocks[: blanks[0]], *blank.solution))
                steps.append(replace(step, blocks=tuple(blocks[blanks[0] :])))
                way = []
            else:
                parts = (step.claim, *step.blocks, step.reason)
                way += [part for part in parts if not isinstance(part, Words) or part.parts]
        found.append((section, steps))
    if way:  # what comes after the last result keeps its steps
        last = max(
            k for k, (_, steps) in enumerate(found) if any(isinstance(b, Blank) for s in steps for b in s.blocks)
        )
        found = [(part, steps if k <= last else list(part.steps)) for k, (part, steps) in enumerate(found)]
    return [replace(part, steps=tuple(steps)) for part, steps in found if steps]


def _gated(document: Document, sections: Sequence[Section]) -> Iterator[Section]:
    """Yield the sections; a step without blanks needs those before it that it may follow from, and those it tells."""
    blanks = [b for part in sections for step in part.steps for b in step.blocks if isinstance(b, Questions)]
    answers = {blank.key: blank.answer for blank in blanks if isinstance(blank, Blank)}
    told, before = Hidden(document, answers), list[tuple[str, str]]()
    for section in sections:
        steps = []
        for step in section.steps:
            own = [(step.key, block.key) for block in step.blocks if isinstance(block, Questions)]
            before += own
            needs = {key for source, key in before if follows(step.key, source)} if not own else set()
            if not own and not is_given(section):
                needs |= set(told.by(step))
            steps.append(replace(step, needs=tuple(blank.key for blank in blanks if blank.key in needs)))
        yield replace(section, steps=tuple(steps))


def judge(document: Document, key: str, text: str) -> str:
    """Return whether a typed answer is right, in the language of the document.

    To a blank it is plain text or LaTeX, to a choice the letters of what is chosen: "a, c".

    Raises:
        TeachError: there is no such exercise.
    """
    blanks = {block.key: block for _, block in document.blocks() if isinstance(block, Questions)}
    if key not in blanks:
        raise TeachError(f"there is no exercise {key!r}; {choice(key, blanks)}")
    words = language_of(document.language).lesson
    if not text.strip():
        return words["fault.empty"]
    asked = blanks[key]
    if isinstance(asked, Choice):
        return _judged_choice(document, asked, text)
    assert isinstance(asked, Blank), "the two kinds of questions"
    try:
        form = read_formula(text, document.scene)
    except TeachError as fault:
        return str(fault)
    named = [name for name in form.symbols if name in map(str, quantities(Names(document.scene)).values())]
    if named:
        return words["fault.quantity"].format(text=named[0])
    graph = Graph()
    typed, right = form.express(graph), asked.answer.express(graph)
    rounded, diagnosis = asked.left.startswith(ROUNDED), Diagnosis(document.scene.as_parameters())
    if rounded and diagnosis.points.near(typed, right, ENOUGH):
        return words["answer.right"]
    same, turned = (
        Claim("same", "typed", "answer", (typed,), (right,)),
        Claim("turned", "typed", "-", (-typed,), (right,)),
    )
    findings = prove([same, turned])[1]
    if all(finding.verdict == Verdict.NOT_SHOWN for finding in findings):
        return words["answer.undefined"]
    verdicts = [finding.verdict in Verdict.HOLD for finding in findings]
    if not verdicts[0] and _lies_elsewhere(document.scene, asked, typed, right):
        return words["answer.shifted"]
    if rounded and not verdicts[0] and (rule := diagnosis.number(asked.left, asked.answer, typed, ENOUGH)):
        return words["answer.mistake"].format(rule=language_of(document.language).mistakes[rule])
    return words["answer.right" if verdicts[0] else "answer.turned" if verdicts[1] else "answer.wrong"]


ROUNDED, ENOUGH = f"{PHYSICS}:", 5e-3
"""What keys of quantities begin with that may be given as a number, in the scene's own numbers; to which part of it."""


def _judged_choice(document: Document, asked: Choice, text: str) -> str:
    """Return whether the letters of what is chosen are right, with the reasons why others are not."""
    words, spelled = language_of(document.language).lesson, Spelling(document)
    chosen = set(text.lower()) - set(" ,;.()")
    if not chosen <= set(asked.lettered):
        return words["answer.letters"].format(letters=", ".join(asked.lettered))
    wrong = sorted(chosen - set(asked.right))
    reasons = [f"{letter}) {spelled.words(asked.lettered[letter].reason, str)}" for letter in wrong]
    if wrong:
        return " ".join((words["answer.chosen"], *reasons))
    return words["answer.right" if chosen == set(asked.right) else "answer.more"]


def _lies_elsewhere(scene: Scene, blank: Blank, typed: Expr, right: Expr) -> bool:
    """Whether a potential energy that changes with position differs from the answer by what does not."""
    moving = [typed.graph.symbol(name) for name in (*scene.coordinates, *scene.velocities)]
    slopes = list(zip(gradient(typed, moving), gradient(right, moving), strict=True))
    if not blank.left.startswith(FREE) or all(x.is_zero for _, x in slopes):
        return False
    claims = [Claim(f"{k}", "typed", "answer", (mine,), (x,)) for k, (mine, x) in enumerate(slopes)]
    return all(finding.verdict in Verdict.HOLD for finding in prove(claims)[1])


def quantities(names: Names) -> dict[str, Target]:
    """Return what may be claimed and is no symbol of the scene, by plain name: y1, k_z21, K."""
    return {word: target for word, target in names.targets.items() if word not in names.symbols}
