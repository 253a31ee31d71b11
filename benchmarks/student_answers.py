"""How well answers of students are judged, by the checker of the shell and by that of a page.

    python benchmarks/student_answers.py [--list FILE ...] [--verbose]
    python benchmarks/student_answers.py --sealed FILE.json.gz


reads tests/data/student_answers/first.toml and second.toml, or other lists, judges every answer where it was typed
(`file` by `check_derivation`, `page` by the page's own program in node) and prints how many are judged right, and of
how many wrong ones the hint names the cause, by door, scene and spelling. A sealed list (tests/data/answers) is judged
by both doors, and told in counts alone.
"""

from __future__ import annotations

import argparse
import gzip
import json
import re
import subprocess
import tomllib
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from symdyn.algebra import Form
from symdyn.errors import SymdynError
from symdyn.graph import Expr, gradient
from symdyn.resources import folder
from symdyn.scene import Scene, read
from symdyn.scene.toml import read_text
from symdyn.scene.values import acceleration_name
from symdyn.teach import check_derivation, in_words
from symdyn.teach.languages import language_of
from symdyn.teach.practice.questions import BALANCED, questions_of
from symdyn.teach.practice.quiz import boxed
from symdyn.teach.student.answer import EMPTY
from symdyn.teach.student.course import Course
from symdyn.teach.student.diagnosis import Diagnosis
from symdyn.teach.student.grammar import Target
from symdyn.teach.student.statements import find_target

ROOT = Path(__file__).parent.parent
LISTS = tuple(ROOT / "tests" / "data" / "student_answers" / f"{name}.toml" for name in ("first", "second"))

CAUSES: tuple[tuple[str, tuple[str, ...]], ...] = (
    (r"says nothing|not a formula|restates", ("empty", "nothing")),
    (r"dimension wrong", ("dimension",)),
    (r"Steiner|wrong axis", ("steiner", "carried")),
    (
        r"rides along|also rises|also turns|crankpin moves|height of the elbow|at the end of link 1",
        ("carried", "absolute"),
    ),
    (r"turned alone", ("relative", "carried")),
    (r"accelerations? (?:and squares )?in a momentum|not squared", ("dimension",)),
    (r"inner derivative", ("chain", "index")),
    (r"gravity angle|is relative to|wrong angle", ("absolute",)),
    (r"of the tip|to the tip|lever arm", ("arm", "cross")),
    (r"rod instead of a point mass", ("inertia",)),
    (r"second arm|share", ("body",)),
    (r"factor 1/2|1/2 missing|kinetic energy's half", ("half", "factor")),
    (r"power rule|factor 2|coefficient of the kinetic energy|twice", ("factor", "half", "cross")),
    (r"product rule", ("product", "velocities", "convention")),
    (r"dK/d", ("slope",)),
    (r"Coriolis|centrifugal", ("slope", "product", "velocities", "chain")),
    (r"without its minus|sign of the derivative|chain rule", ("chain", "slope", "gravity", "trig")),
    (r"textbook's convention", ("convention", "gravity", "turned")),
    (r"cross term|double product|cosine", ("cross", "trig", "height", "clockwise", "index")),
    (r"sine", ("trig", "height")),
    (r"x coordinate|height|horizontal", ("height", "trig")),
    (r"moment arm", ("height", "trig", "arm")),
    (r"from the vertical|absolute angle|relative angle", ("absolute", "relative")),
    (r"relative rate|absolute rate", ("relative",)),
    (r"clockwise", ("clockwise", "cross")),
    (r"sign of gravity|second term only|K \+ P", ("gravity", "energies")),
    (r"forgot gravity|weight(?! at| in| does)", ("weightless", "gravity", "body")),
    (r"friction", ("friction",)),
    (r"coupling|reaction|simple inverted", ("coupling", "body")),
    (r"moments? of inertia|rotation", ("inertia", "half", "body", "steiner")),
    (r"point mass|distance|middle of|end of|l instead of|at the end", ("arm", "inertia", "steiner")),
    (r"ind(?:ices|ex)|masses|mixed|swapped", ("index",)),
    (r"not divided|divided", ("undivided",)),
    (r"not differentiated", ("undifferentiated", "spring")),
    (r"with respect to", ("variable", "index")),
    (r"spring", ("spring", "undifferentiated")),
    (r"rate squared", ("squared",)),
    (r"along the axis|does no work", ("direction",)),
    (r"sign", ("turned", "termsign", "gravity", "chain", "slope")),
)
"""What a cause is written with, and the rules of which a hint names it: every line that fits counts."""


@dataclass(frozen=True)
class Row:
    """One answer of a list, and how it was judged: whether right, by which rules it is explained, in which words."""

    scene: str
    place: str
    asked: str
    typed: str
    right: bool
    cause: str
    judged: bool | None = None
    rules: tuple[str, ...] = ()
    told: str = ""

    @property
    def spelling(self) -> str:
        """What the text is written in."""
        return "LaTeX" if "\\" in self.typed or "$" in self.typed else "plain" if self.typed.isascii() else "Unicode"

    @property
    def named(self) -> bool:
        """Whether the hint names the cause."""
        meant = {rule for pattern, rules in CAUSES if re.search(pattern, self.cause) for rule in rules}
        return bool(meant & set(self.rules))


def rows_of(path: Path) -> list[Row]:
    """Return the answers of a list."""
    return [Row(**row) for row in tomllib.loads(path.read_text(encoding="utf-8"))["answer"]]


def scene_of(name: str) -> Scene:
    """Return an example."""
    return read(ROOT / "examples" / f"{name}.toml")


# The shell


def judged_in_shell(row: Row) -> Row:
    """Return a row with what `check_derivation` says."""
    try:
        answers = check_derivation(row.typed, scene_of(row.scene))
    except SymdynError as fault:
        return replace(row, judged=False, rules=("empty",) if "symbol" in str(fault) else (), told=str(fault))
    rules: list[str] = []
    for one in answers:
        rules += ["empty"] if one.verdict == EMPTY else []
        rules += [one.mistake.rule, one.mistake.other] if one.mistake else []
        rules += ["turned"] if one.turned else ["slope"] if one.forgotten else []
    told = " / ".join(line for one in answers for line in in_words(one))
    return replace(row, judged=all(one.right for one in answers), rules=tuple(filter(None, rules)), told=told)


# The page


def key_of(asked: str, scene: Scene) -> str:
    """Return the key of what is asked, as documents have it."""
    if found := re.match(r"v_(\d+)", asked):
        return f"v2:{found[1]}"
    if found := re.match(r"([KPL])(?:_(\d+))?(?= |$)", asked):
        return f"{found[1]}:{found[2] or ''}"
    if found := re.match(r"(k_[zCDGE])(\d+)(?:_(\d+))?", asked):
        return f"{found[1]}:{','.join(found[2] + (found[3] or ''))}"
    if found := re.match(r"(d/dt )?dL/d(\w+)", asked):
        return f"{found[1] or ''}dL:/d{re.sub(r'^qd([0-9]+)$', r'q{}_dot'.format(chr(92) + '1'), found[2])}"
    if "solved" in asked:
        name = re.sub(r"^qdd([0-9]+)$", r"q\1_ddot", asked.split(maxsplit=1)[0])
        return f"solved:{[acceleration_name(u) for u in scene.velocities].index(name) + 1}"
    number = next((k for k, word in enumerate(("first", "second", "third", "fourth"), 1) if word in asked), 1)
    return f"tau:{number}"


def judged_on_page(rows: Sequence[Row]) -> Iterator[Row]:
    """Yield rows with what a page's program says: those of one scene by one run of node."""
    for name in dict.fromkeys(row.scene for row in rows):
        own = [row for row in rows if row.scene == name]
        scene = scene_of(name)
        course = Course(scene)
        asked = {}
        for key in dict.fromkeys(key_of(row.asked, scene) for row in own):
            node = _asked(course, key, scene)
            assert node is not None, f"{name}: {key} is no step of the derivation"
            asked[key] = (key, Form.of(node))
        texts = [(key_of(row.asked, scene), row.typed) for row in own]
        for row, told in zip(own, told_by_page(scene, asked, texts), strict=True):
            yield replace(row, judged=told["right"], rules=_rules(told["text"]), told=told["text"])


def _asked(course: Course, key: str, scene: Scene) -> Expr | None:
    """Return what a box asks for, by its key: behind drive and loads, or what an equation solved for one is."""
    node = course.value(key.replace("solved", "tau"), course.right)
    if node is None or not key.startswith(BALANCED):
        return node
    i = int(key.partition(":")[2]) - 1
    if key.startswith("tau"):
        return node + course.right.Q[i]
    a = course.state.qdd[i]
    M = gradient(node, [a])[0]
    drive = scene.drives[i]
    return ((course.graph.symbol(drive) if drive else course.graph.zero) - (node - M * a)) / M


READER = """
const part = () => ({parts: [], of: {}, dataset: {}, classList: {toggle() {}},
  get textContent() { return this.parts.map(one => one.textContent ?? one).join(""); },
  set textContent(text) { this.parts = [text]; }, append(...more) { this.parts.push(...more); },
  addEventListener(name, told) { this.of[name] = told; }, querySelector() { return part(); },
  set innerHTML(text) { this.parts = [text]; }});
const asks = key => Object.prototype.hasOwnProperty.call(QUESTIONS.values, key);
const forms = typed.map(([key, text], number) => {
  const own = {".verdict": part(), ".solution": part(), ".echo": null}, form = part();
  const elements = {answer: {...part(), value: text}};
  return Object.assign(form, {dataset: {key, number}, elements, querySelector: name => own[name]});
});
const document = {querySelector: part, createElementNS: part,
  querySelectorAll: name => name === "form.blank" ? forms.filter(form => asks(form.dataset.key)) : []};
let logged;
const Log = {add: one => { logged = one; }};
"""
"""A page with a box for every answer, for the program of a page without a browser."""

TRIES = """
console.log(JSON.stringify(forms.map(form => {
  if (!asks(form.dataset.key)) return {right: false, text: "", tries: []};
  const tries = [1, 2, 3].map(() => (form.of.submit({preventDefault() {}}), logged.told));
  return {right: logged.right, text: tries[0], tries};
})));
"""
"""Every answer is typed three times."""


def told_by_page(
    scene: Scene, asked: Mapping[str, tuple[str, Form]], texts: Sequence[tuple[str, str]]
) -> list[dict[str, Any]]:
    """Return what the program of a page says to answers, each with its key, and to three `tries` of each."""
    teach = folder("templates") / "teach"
    scripts = [(teach / f"{name}.js").read_text("utf-8") for name in ("formulas", "terms", "answers", "practice")]
    questions = {**questions_of(scene, asked, "en"), "choices": {}}
    given = f"const QUESTIONS={json.dumps(questions)}, typed={json.dumps(texts)};"
    program = "\n".join([given, READER, *scripts, TRIES])
    done = subprocess.run(["node", "-"], input=program, text=True, capture_output=True, check=True)
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found


def _rules(text: str) -> tuple[str, ...]:
    """Return the rules that a page's words tell."""
    spoken = language_of("en")
    said = {"answer.always": "empty", "answer.turned": "turned"}
    found = [rule for key, rule in said.items() if text.startswith(spoken.lesson[key])]
    begins = [spoken.lesson[key].partition("{text}") for key in ("fault.quantity", "fault.name")]
    if (
        any(text.startswith(head) and text.endswith(tail) for head, _, tail in begins)
        or text == spoken.lesson["fault.empty"]
    ):
        found.append("empty")
    told = [rule for rule, words in spoken.mistakes.items() if len(words) > 12 and words in text]
    return (*found, *(one for rule in told for one in rule.split(".")))


# The report


def judged(path: Path) -> list[Row]:
    """Return the answers of a list as both checkers judge them."""
    rows = rows_of(path)
    shell = [judged_in_shell(row) for row in rows if row.place == "file"]
    return [*shell, *judged_on_page([row for row in rows if row.place == "page"])]


def rates(rows: Iterable[Row]) -> tuple[float, float]:
    """Return the share judged right, and of wrong ones the share whose hint names the cause."""
    found = list(rows)
    wrong = [row for row in found if not row.right]
    named = sum(row.named and row.judged is False for row in wrong)
    right = sum(row.judged is row.right for row in found)
    return right / len(found), named / len(wrong) if wrong else 1.0


def report(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the rates as lines: of all, by door, scene and spelling."""
    groups = {"all": rows}
    for name in ("place", "scene", "spelling"):
        for value in sorted({getattr(row, name) for row in rows}):
            groups[f"{name} {value}"] = [row for row in rows if getattr(row, name) == value]
    for name, own in groups.items():
        right, named = rates(own)
        wrong = Counter(row.right for row in own)[False]
        yield f"{name:24} {len(own):4} answers  judged right {right:6.1%}   {wrong:4} wrong, cause named {named:6.1%}"


# Sealed lists


NAMES: Mapping[str, str] = {
    "half": "factor",
    "steiner": "wrong-inertia inertia-of-body-missing missing-term",
    "inertia": "wrong-inertia inertia-of-body-missing",
    "arm": "wrong-parameter wrong-inertia",
    "cross": "cross-term-missing missing-term sign factor wrong-function",
    "carried": "moved-mass-missing cross-term-missing missing-term",
    "relative": "wrong-angle cross-term-missing",
    "absolute": "wrong-angle",
    "height": "wrong-function",
    "trig": "wrong-function missing-factor",
    "gravity": "gravity-sign",
    "weightless": "gravity-missing missing-term moved-mass-missing",
    "energies": "sign gravity-sign",
    "index": "wrong-parameter copied-other-coordinate",
    "ratio": "factor wrong-parameter power",
    "force": "drive-missing missing-term",
    "product": "rate-product-missing",
    "slope": "rate-product-missing",
    "chain": "sign rate-product-missing",
    "convention": "sign",
    "friction": "damping-missing damping-sign",
    "coupling": "cross-term-missing missing-term",
    "body": "moved-mass-missing inertia-of-body-missing missing-term",
    "factor": "factor",
    "undifferentiated": "dimension",
    "undivided": "missing-factor arithmetic dimension",
    "squared": "power dimension",
    "clockwise": "sign wrong-angle",
    "velocities": "rate-product-missing missing-term",
    "spring": "spring-sign spring-free-length",
    "turned": "sign gravity-sign spring-sign damping-sign",
    "term": "missing-term",
    "termgravity": "gravity-missing missing-term",
    "termsign": "sign",
    "termfactor": "factor missing-factor arithmetic",
    "direction": "extra-term",
    "dimension": "dimension",
    "nothing": "",
    "other": "copied-other-coordinate",
    "variable": "",
    "row": "",
    "multiplier": "",
    "power": "power missing-factor",
    "extra": "extra-term",
    "drive": "drive-missing",
    "untied": "constraint-ignored",
    "steady": "missing-term",
    "law": "power wrong-function wrong-parameter damping-sign",
    "prescribed": "prescribed-motion-ignored missing-term",
}
"""Which causes of a sealed list a rule names."""

VAGUE = ("term", "termgravity", "termsign", "termfactor", "turned", "extra")
"""Rules that say how a term differs and give no reason, so never a false one."""

WHOLE = {"answer.factor": "termfactor", "answer.turned": "turned"}
"""What a page says where all of an answer has a wrong factor, or the other sign, as a rule."""

FINER: Mapping[str, str] = {
    "inertia-of-body-missing": "inertia-missing",
    "wrong-inertia": "factor",
    "missing-factor": "factor",
    "cross-term-missing": "missing-term",
    "gravity-missing": "missing-term",
    "drive-missing": "missing-term",
    "spring-free-length": "missing-term",
    "damping-sign": "sign",
    "power": "dimension",
}
"""Causes that a list with fewer keys counts to others."""

TERMS: Mapping[str, str] = {
    "sign": "sign gravity-sign spring-sign damping-sign",
    "factor": "factor arithmetic wrong-inertia",
    "power": "power",
    "moved": "wrong-parameter",
    "function": "wrong-function",
    "angle": "wrong-angle",
    "missing": "missing-term inertia-of-body-missing moved-mass-missing cross-term-missing rate-product-missing "
    "gravity-missing damping-missing drive-missing",
    "extra": "extra-term",
}
"""Which causes a difference names whose term is shown."""

KINDS: Mapping[str, str] = {
    **dict.fromkeys(("kinetic_energy", "kinetic"), "K:"),
    **dict.fromkeys(("potential_energy", "potential"), "P:"),
    "lagrangian": "L:",
    **dict.fromkeys(("coefficient", "mass"), "k_z:{row},{column}"),
    "momentum": "dL:/d{rate}",
    "equation": "tau:{number}",
    "acceleration": "solved:{number}",
    "drive": "tau:{number}",
}
"""Keys of what is asked; for other kinds the checker has no box."""


def key_of_sealed(asked: Mapping[str, Any], scene: Scene) -> str | None:
    """Return the key of what a sealed answer answers, None where no box asks for it."""
    if asked["kind"] not in KINDS:
        return None
    filled = dict(asked)
    if "coordinate" in asked or "drive" in asked:
        drive, name = asked.get("drive"), asked.get("coordinate")
        i = scene.drives.index(drive) if drive else scene.coordinates.index(name)
        filled |= {"number": i + 1, "rate": scene.velocities[i]}
    for place in ("row", "column"):
        if asked.get(place) in scene.coordinates:
            filled[place] = scene.coordinates.index(asked[place]) + 1
    return KINDS[asked["kind"]].format(**filled)


@dataclass(frozen=True)
class Judged:
    """What one door says: whether right, None for what cannot be read, and which causes it names, and by rules."""

    right: bool | None
    rules: tuple[str, ...] = ()
    terms: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """Return it in the words of the list."""
        return "unreadable" if self.right is None else "right" if self.right else "wrong"

    def names(self, cause: str, coarse: Collection[str] = ()) -> bool:
        """Whether a cause is named; `coarse` are its finer causes, where a list does not part them."""
        said = {one for x in self.rules for one in NAMES[x].split()}
        said |= {one for x in self.terms for one in TERMS.get(x, "").split()}
        return bool(said & {cause, *coarse})


def sealed_in_shell(answer: Mapping[str, Any], key: str, scene: Scene) -> Judged:
    """Return what `check_derivation` says to a sealed answer."""
    kind, _, at = key.partition(":")
    name = re.sub(r"_dot$", "dot", f"{kind}{at}".replace(",", "").replace("dL/d", "slope"))
    try:  # the shell is given what stands before a box; a drive called tau2 may be that of another joint
        target = Target("tau", (int(at),)) if kind in ("tau", "solved") else find_target(name, scene)
        answers, _ = boxed(answer["answer"], target, key, Diagnosis(scene), "text")
    except SymdynError:
        return Judged(None)
    rules = [
        rule
        for one in answers
        if one.mistake
        for rule in (one.mistake.rule, one.mistake.other, *one.mistake.more)
        if rule
    ]
    rules += ["turned" for one in answers if one.turned] + ["slope" for one in answers if one.forgotten]
    terms = [d.kind for one in answers if not one.right for d in one.differences[:3]]
    return Judged(all(one.right for one in answers), tuple(rules), tuple(terms))


def sealed_on_page(answers: Sequence[tuple[str, str]], scene: Scene) -> list[tuple[Judged, Judged]]:
    """Return what a page's program says to sealed answers to a scene, with keys: at the first try, and over three."""
    texts, says = language_of("en").lesson, language_of("en").answers
    unread = [texts[key].split("{text}") for key in texts if key.startswith("fault.")]
    course, found = Course(scene), []
    asked = {}
    for key in dict.fromkeys(key for key, _ in answers):
        if node := _asked(course, key, scene):
            asked[key] = (key, Form.of(node))
    for told, (key, _) in zip(told_by_page(scene, asked, answers), answers, strict=True):
        text = told["text"]
        faulty = any(text.startswith(parts[0]) and text.endswith(parts[-1]) for parts in unread)
        right = None if faulty or key not in asked else bool(told["right"])
        rules = [rule for rule in _rules(text) if rule in NAMES]
        rules += [rule for key, rule in WHOLE.items() if text.startswith(texts[key].partition("{factor}")[0])]
        shown = (told["tries"] or [""])[-1].removeprefix(text)
        terms = [kind for kind in TERMS if says[kind].partition(":")[0].capitalize() in shown]
        found.append((Judged(right, tuple(rules)), Judged(right, tuple(rules), tuple(terms))))
    return found


DOORS = ("shell", "page, first try", "page, three tries")


def opened(path: Path) -> dict[str, Any]:
    """Return a sealed list."""
    found: dict[str, Any] = json.loads(gzip.decompress(path.read_bytes()))
    return found


def sealed(data: Mapping[str, Any]) -> Iterator[tuple[Mapping[str, Any], Judged, Judged, Judged]]:
    """Yield the boxed answers of a sealed list with what shell and page say, the page at one try and over three."""
    for name, text in data["scenes"].items():
        scene = read_text(text, f"{name}.toml")
        own = [(a, key_of_sealed(a["asked"], scene)) for a in data["answers"] if a["scene"] == name]
        boxed = [(a, key) for a, key in own if key is not None]
        page = sealed_on_page([(key, a["answer"]) for a, key in boxed], scene) if boxed else []
        yield from ((a, sealed_in_shell(a, key, scene), *told) for (a, key), told in zip(boxed, page, strict=True))


def counted(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield what became of a sealed list, in counts."""
    rows = list(sealed(data))
    yield f"{len(rows)} answers judged; {len(data['answers']) - len(rows)} to what no box asks for are not asked"
    for k, door in enumerate(DOORS, 1):
        yield from _counts(door, [(row[0], row[k]) for row in rows], data["causes"])
    same = sum(shell.verdict == page.verdict for _, shell, page, _ in rows)
    yield f"page and shell agree on {same} of {len(rows)}"


def _counts(door: str, rows: Sequence[tuple[Mapping[str, Any], Judged]], keys: Collection[str]) -> Iterator[str]:
    ok = Counter(a["verdict"] for a, told in rows if a["verdict"] == told.verdict)
    every = Counter(a["verdict"] for a, _ in rows)
    shown = ", ".join(f"{kind} {ok[kind]} of {every[kind]}" for kind in ("right", "wrong", "unreadable"))
    yield f"{door}: judged as they are {ok.total()} of {len(rows)} = {ok.total() / len(rows):.1%} ({shown})"
    wrong = [(a, told) for a, told in rows if a["verdict"] == "wrong"]
    causes = [told.right is False and told.names(c, finer(c, keys)) for a, told in wrong for c in a["causes"]]
    false = sum(is_false(a, told, keys) for a, told in wrong)
    yield f"{door}: causes named {sum(causes)} of {len(causes)} = {sum(causes) / len(causes):.1%}; false causes {false}"


def finer(cause: str, keys: Collection[str]) -> list[str]:
    """Return the finer causes that a list counts to one of its own."""
    return [fine for fine, whole in FINER.items() if whole == cause and fine not in keys]


def is_false(answer: Mapping[str, Any], told: Judged, keys: Collection[str]) -> bool:
    """Whether reasons are given for a wrong answer, and none of them is true."""
    reasons = tuple(rule for rule in told.rules if rule not in VAGUE)
    true = [*answer["causes"], *answer.get("also", ())]
    return bool(reasons) and not any(Judged(False, told.rules).names(c, finer(c, keys)) for c in true)


def main() -> None:
    """Print the report, and with --verbose every answer that is misjudged or whose hint says something else."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--list", "--last", type=Path, action="append", help="a list in place of both")
    options.add_argument("--verbose", action="store_true", help="every answer that is misjudged, or not explained")
    options.add_argument("--sealed", type=Path, help="a sealed list, of which counts alone are told")
    given = options.parse_args()
    if given.sealed:
        print("\n".join(counted(opened(given.sealed))))
        return
    rows = [row for path in given.list or LISTS for row in judged(path)]
    print("\n".join(report(rows)))
    for row in rows if given.verbose else ():
        if row.judged is not row.right or (not row.right and not row.named):
            what = (
                "misjudged" if row.judged is not row.right else f"not explained ({row.cause}; {', '.join(row.rules)})"
            )
            print(f"\n{what}: {row.scene}, {row.place}, {row.asked}\n  {row.typed[:300]!r}\n  {row.told[:300]}")


if __name__ == "__main__":
    main()
