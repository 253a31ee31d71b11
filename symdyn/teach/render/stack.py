"""Exercises as a STACK question in Moodle XML: Maxima judges, exactly where its algebra can, else at points.

Equal formulas are found by AlgEquiv. Another answer is right if it has its value, or an equation holds, at the points
on the motions of `symdyn.teach.student.motions`, in floating-point numbers; an equation of an open mechanism only if
what is left of it is zero, too, once the equations of motion are put in, times their determinant.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence

from symdyn.algebra import Form
from symdyn.dynamics.mechanism import prescribed
from symdyn.emit import render, verbatim
from symdyn.emit.code import page_stem
from symdyn.graph import Graph
from symdyn.scene.values import acceleration_name
from symdyn.teach.document import Choice
from symdyn.teach.practice.quiz import Part, Variant
from symdyn.teach.render.quiz_text import Dialect, Html, Quiz, points_by

RESERVED = (
    "e i j pi inf minf ind und infinity true false and or not if then else do for while in lambda gamma beta zeta "
    "delta step next thru unless elseif "  # and what holds values of Maxima's own
    "aliases arrays context contexts domain error features float functions gcd genindex grind labels linel linenum "
    "macros numer programmode prompt props rot rules simp sparse structures timer trace translate values verbose"
)
MAXIMA = Dialect({"log": "log", "sign": "signum", "pi": "%pi"}, RESERVED, exact=True)

Node = tuple[str, str, str, int, str]
"""Of a potential response tree: name, what is compared with what, what that is worth, what is said if it is equal."""


def stack(quiz: Quiz) -> dict[str, str]:
    """Return the one file by name."""
    pages = [_Page(one) for one in quiz.variants]
    parts = [_PartOf(quiz, pages, key, k) for k, key in enumerate(quiz.keys, 1)]
    words, body = quiz.words, _chosen([page.task for page in pages])
    asked = "\n".join(one.text for one in parts)
    values = {
        "title": _safe(quiz.variants[0].document.title),
        "words": words,
        "text": f"{body}\n<p>{words['quiz.how']}</p>\n{_chosen([page.how for page in pages])}\n<ol>\n{asked}\n</ol>",
        "solution": "\n".join(one.solution for one in parts),
        "marks": sum(one.marks for one in parts),
        "variables": "\n".join([*_common(pages), *(line for one in parts for line in one.variables)]),
        "note": words["quiz.note"].format(number="{@quiz_variant@}"),
        "description": words["quiz.weaker"],
        "parts": parts,
        "seeds": range(1, 1 + len(pages)) if len(pages) > 1 else (),
    }
    return {f"{page_stem(quiz.scene.name)}-stack.xml": render("quiz/stack.xml.jinja", values)}


class _Page:
    """One variant in Maxima's words."""

    def __init__(self, variant: Variant) -> None:
        self.variant, self.letters, self.html = variant, MAXIMA.letters(variant), Html(variant)
        self.task, self.how = _safe(self.html.blocks(variant.task)), _safe(self.html.how(self.letters))

    def text(self, form: Form) -> str:
        return MAXIMA.text(form, self.letters)

    def equal(self, pairs: Mapping[str, str]) -> str:
        """Return equations for `subst`."""
        return _list(f"{self.letters[name]} = {value}" for name, value in pairs.items())

    def points(self, points: Sequence[Mapping[str, float]]) -> str:
        return _list(
            _list(f"{x} = {v!r}" for x, v in p.items()) for p in points_by(self.letters, points, self.variant.scene)
        )

    @property
    def given(self) -> str:
        scene, graph = self.variant.scene, Graph()
        found = prescribed(scene, graph)
        names = [(scene.coordinates[k], scene.velocities[k]) for k in found.place]
        rates = [*(q for q, _ in names), *(u for _, u in names), *(acceleration_name(u) for _, u in names)]
        nodes = [*found.position, *found.velocity, *found.acceleration]
        return self.equal({name: self.text(Form.of(x)) for name, x in zip(rates, nodes, strict=True)})

    @property
    def numbers(self) -> str:
        values = ((p.name, p.value) for p in self.variant.scene.parameters if p.value is not None)
        return self.equal({name: self.text(Form.of(value.express(Graph()))) for name, value in values})

    @property
    def held(self) -> tuple[int, ...]:
        return tuple(prescribed(self.variant.scene, Graph()).place)

    @property
    def kept(self) -> list[int]:
        """The equations with an unknown: an acceleration, or the drive of a prescribed motion."""
        return [i for i, drive in enumerate(self.variant.scene.drives) if drive or i not in self.held]

    @property
    def balance(self) -> tuple[str, str]:
        """Return the equations of motion of an open mechanism, each zero, and their unknowns."""
        course, scene, held = self.variant.diagnosis.course, self.variant.scene, self.held
        if course is None or scene.is_constrained:
            return "[]", "[]"
        equations, unknowns = [], []
        for i in self.kept:
            total = course.value(f"tau:{i + 1}", course.right)
            assert total is not None, "every joint has a drive or none"
            equations.append(self.text(Form.of(total - self.variant.diagnosis.drive(i))))
            unknowns.append(str(scene.drives[i]) if i in held else acceleration_name(scene.velocities[i]))
        return _list(equations), _list(self.letters[name] for name in unknowns)

    @property
    def moving(self) -> str:
        return _list(self.letters[x] for x in (*self.variant.scene.coordinates, *self.variant.scene.velocities))

    def off(self, equation: int | None) -> list[str]:
        """Return points on the motions, and where an equation is broken, by letters and by the scene's numbers."""
        every = self.variant.groups
        return [self.points(on[: len(on) // 2] if equation is None else off[equation]) for on, off in every]


def _common(pages: Sequence[_Page]) -> Iterator[str]:
    """Yield statements that all parts need: the variant, the functions, motions."""
    yield f"quiz_variant: 1 + mod(stack_seed - 1, {len(pages)});"
    yield verbatim("quiz/motions.mac")
    yield f"quiz_given: {_by(page.given for page in pages)};"
    yield f"quiz_numbers: {_by(page.numbers for page in pages)};"
    yield f"quiz_moving: {_by(page.moving for page in pages)};"
    yield f"quiz_balance: subst(quiz_given, {_by(page.balance[0] for page in pages)});"
    yield f"quiz_unknown: {_by(page.balance[1] for page in pages)};"
    if pages[0].variant.diagnosis.motions:
        yield f"quiz_on: {_by(_list(page.off(None)) for page in pages)};"


class _PartOf:
    """One question in all variants."""

    def __init__(self, quiz: Quiz, pages: Sequence[_Page], key: str, number: int) -> None:
        self.quiz, self.pages, self.number, self.every = quiz, pages, number, quiz.parts(key)
        self.part = self.every[0]
        self.options, self.marks = isinstance(self.part.asked, Choice), self.part.marks
        self.rules = list(dict.fromkeys(x.text for one in self.every for x in one.wrong))
        self.wrong = f"<p>{quiz.words['answer.wrong']}</p>"
        if self.options:
            self.wrong = f"<p>{quiz.words['answer.chosen']}</p>{self._reasons()}"

    @property
    def text(self) -> str:
        told = [page.html.asked(one) for page, one in zip(self.pages, self.every, strict=True)]
        before, left = (_chosen([_safe(one[k]) for one in told]) for k in (0, 1))
        check = "" if self.options else f"\n[[validation:ans{self.number}]]"
        return f"<li>{before}\n<p>{left}[[input:ans{self.number}]]</p>{check}\n[[feedback:prt{self.number}]]</li>"

    @property
    def solution(self) -> str:
        return _chosen([_safe(page.html.solved(one)) for page, one in zip(self.pages, self.every, strict=True)])

    @property
    def variables(self) -> Iterator[str]:
        """Statements of the question: the answer, wrong ones, what stands in front, points."""
        k, pairs = self.number, list(zip(self.pages, self.every, strict=True))
        if self.options:
            yield f"quiz_options{k}: {_by(_options(page, one) for page, one in pairs)};"
            right = (json.dumps(one.asked.right) for one in self.every if isinstance(one.asked, Choice))
            yield f"quiz_right{k}: setify({_by(right)});"
            return
        yield f"quiz_ta{k}: {_by(page.text(one.answer) for page, one in pairs)};"
        if self.rules:
            yield f"quiz_marks{k}: {_by(page.points(page.variant.marks(one)) for page, one in pairs)};"
            yield f"quiz_wrong{k}: {_by(_list(self._wrong(one)) for _, one in pairs)};"
        if self.part.equation is not None:
            yield f"quiz_front{k}: {_by(page.text(one.front) for page, one in pairs)};"
            if self.pages[0].variant.diagnosis.motions:
                yield f"quiz_off{k}: {_by(_list(page.off(one.equation)) for page, one in pairs)};"

    def _wrong(self, one: Part) -> Iterator[str]:
        return (f"[{self.rules.index(x.text) + 1}, {x.marks[0]!r}, {x.marks[1]!r}]" for x in one.wrong)

    @property
    def feedback(self) -> str:
        """Statements of the tree: what is left of the answer."""
        k, i = self.number, self.part.equation
        if self.options:
            return f"quiz_chosen{k}: setify(ans{k});"
        d, page = f"quiz_front{k} - ans{k}", self.pages[0]
        moves = page.variant.diagnosis.motions is not None
        if i is not None and moves:
            put, bound = (f"quiz_held({d}, {at}(quiz_on), {at}(quiz_off{k}))" for at in ("first", "last"))
            if not page.variant.scene.is_constrained and i in page.kept:
                exact = f"quiz_left(subst(quiz_given, {d}), {page.kept.index(i) + 1}, quiz_balance, quiz_unknown)"
                put = f"if {put} = 0 then {exact} else 1"
        elif moves and not self.part.is_rounded:
            put, bound = (f"quiz_equal(ans{k}, quiz_ta{k}, {at})" for at in ("first(quiz_on)", "last(quiz_on)"))
        else:
            put = f"subst(quiz_given, ans{k} - quiz_ta{k})"
            bound = f"subst(quiz_numbers, {put})"
        lines = [f"quiz_put{k}: {put};", f"quiz_bound{k}: {bound};"]
        if self.part.is_free:
            lines.append(f"quiz_slope{k}: map(lambda([quiz_u], diff(ans{k} - quiz_ta{k}, quiz_u)), quiz_moving);")
        if self.rules:
            lines.append(f"quiz_rule{k}: quiz_rule(ans{k}, quiz_marks{k}, quiz_wrong{k});")
        return "\n".join(lines)

    @property
    def nodes(self) -> list[Node]:
        """The tree, each node asked where those before it say no."""
        k, say = self.number, self.quiz.words
        if self.options:
            return [("right", f"quiz_chosen{k}", f"quiz_right{k}", 1, "")]
        nodes = [
            ("right", f"ans{k}", f"quiz_ta{k}", 1, ""),
            ("motions", f"quiz_put{k}", "0", 1, say["answer.motions"]),
            ("numbers", f"quiz_bound{k}", "0", 1, say["answer.numbers"]),
        ]
        if self.part.is_rounded:
            near = f"is(abs(float(quiz_bound{k})) < 0.005*abs(float(subst(quiz_numbers, quiz_ta{k}))))"
            nodes.append(("near", near, "true", 1, ""))
        if self.part.is_free:
            nodes.append(("shifted", f"quiz_slope{k}", "0*quiz_moving", 1, say["answer.shifted"]))
        nodes.append(("turned", f"ans{k}", f"-quiz_ta{k}", 0, say["answer.turned"]))
        return [*nodes, *((f"rule{j}", f"quiz_rule{k}", f"{j}", 0, _safe(x)) for j, x in enumerate(self.rules, 1))]

    def _reasons(self) -> str:
        told = []
        for v, (page, one) in enumerate(zip(self.pages, self.every, strict=True), 1):
            assert isinstance(one.asked, Choice), "every variant asks alike"
            for letter, option in one.asked.lettered.items():
                if not option.right:
                    test = f'quiz_variant={v} and elementp("{letter}", quiz_chosen{self.number})'
                    told.append(f"[[if test='{test}']]<p>{letter}) {_safe(page.html.words(option.reason))}</p>[[/if]]")
        return "".join(told)


def _options(page: _Page, one: Part) -> str:
    assert isinstance(one.asked, Choice), "every variant asks alike"
    rows = ((letter, option, page.html.words(option.text)) for letter, option in one.asked.lettered.items())
    return json.dumps([[key, x.right, f"{key}) {text}"] for key, x, text in rows], ensure_ascii=False)


def _list(texts: Iterator[str] | Sequence[str]) -> str:
    return f"[{', '.join(texts)}]"


def _by(texts: Iterator[str]) -> str:
    """Return what the variant has of some texts."""
    every = list(texts)
    return every[0] if len(set(every)) == 1 else f"{_list(every)}[quiz_variant]"


def _safe(text: str) -> str:
    """Return text that is no CASText and ends no CDATA."""
    return text.replace("]]>", "]]&gt;").replace("[[", "[&#8203;[").replace("{@", "{ @").replace("{#", "{ #")


def _chosen(texts: Sequence[str]) -> str:
    """Return a block that shows the text of the variant."""
    if len(set(texts)) == 1:
        return texts[0]
    return "".join(f'[[if test="quiz_variant={k}"]]{text}[[/if]]' for k, text in enumerate(texts, 1))
