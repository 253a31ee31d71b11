"""Exercises for learning platforms: one list of questions, three files, and one verdict of four judges."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
from contextlib import suppress
from functools import cache
from pathlib import Path

import pytest
from quiz_answers import ANSWERS
from quiz_jme import JmeError, Numbas, Script, parsed
from quiz_platforms import Stack

from symdyn.cli import main
from symdyn.emit.print import text_of
from symdyn.errors import TeachError
from symdyn.resources import folder
from symdyn.scene import read, read_text
from symdyn.teach import Handout
from symdyn.teach.document import Blank, Choice
from symdyn.teach.practice.questions import questions
from symdyn.teach.render import PLATFORMS, asked
from symdyn.teach.render.numbas import JME
from symdyn.teach.render.quiz_text import Dialect, Quiz
from symdyn.teach.render.stack import MAXIMA

OTHERS = [name for name in ANSWERS if name != "pendulum"]
EXAMPLES = Path(__file__).parent.parent / "examples"


@cache
def quiz(name: str, variants: int = 1, language: str = "en") -> Quiz:
    return Handout(read(EXAMPLES / f"{name}.toml"), language=language, exercises=True, variants=variants).quiz()


@cache
def text(name: str, platform: str, variants: int = 1, language: str = "en") -> str:
    (found,) = asked(quiz(name, variants, language), platform).values()
    assert isinstance(found, str)
    return found


def typed(answer: str, dialect: Dialect, own: Quiz) -> str:
    """Return an answer in the letters of a platform, as its table says."""
    letters = dialect.letters(own.variants[0])
    return re.sub(r"[A-Za-z_]\w*", lambda found: letters.get(found[0], found[0]), answer)


# One list


def test_parts_come_in_the_order_of_the_derivation_and_are_those_of_every_variant():
    own = quiz("pendulum", 3)

    assert own.keys[:6] == ("square:1", "potential:1", "momentum:1", "rate:1", "slope:1", "equation:1")
    assert [one.seed for one in own.variants] == [None, 1, 2]
    for key in own.keys:
        assert len({type(part.asked) for part in own.parts(key)}) == 1
    assert own.marks("equation:1") > own.marks("square:1")
    assert len({one.document.scene.name for one in own.variants}) == 3


@pytest.mark.parametrize(
    ("platform", "language"),
    [
        *zip(PLATFORMS, ("en", "en", "sk"), strict=True),
        *(pytest.param(x, y, marks=pytest.mark.slow) for x, y in zip(PLATFORMS, ("sk", "sk", "en"), strict=True)),
    ],
)
def test_the_files_are_the_same_in_every_run_and_speak_the_language(platform, language):
    own = quiz("pendulum", 2, language)
    first = asked(own, platform)

    again = asked(Handout(own.scene, language=language, exercises=True, variants=2).quiz(), platform)

    assert first == again
    shown = "".join(map(str, first.values())) + str(own.shown())
    assert {"en": "What is", "sk": "Čo je"}[language] in shown
    assert "data:image/svg+xml;base64," in shown


# PrairieLearn


def served(folder: Path, seed: int) -> tuple[object, dict]:
    """Return the module of a question's folder and the documented data of a variant that it has generated."""
    spec = importlib.util.spec_from_file_location("server", folder / "server.py")
    server = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(server)
    data = {name: {} for name in ("params", "correct_answers", "submitted_answers", "format_errors", "partial_scores",
                                  "feedback")}  # fmt: skip
    data |= {"variant_seed": str(seed), "score": 0.0}
    server.generate(data)
    return server, data


def test_a_folder_of_prairielearn_generates_and_grades(tmp_path):
    files = asked(quiz("pendulum", 2), "prairielearn")
    for name, contents in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(contents, encoding="utf-8")
    folder = tmp_path / "pendulum-prairielearn"

    server, data = served(folder, 1)
    right = dict(data["correct_answers"])
    for k in range(1, len(server.KEYS) + 1):
        if options := data["params"].get(f"options{k}"):
            right[f"p{k}"] = [
                letter for letter, one in zip("abcdefgh", options, strict=False) if one["right"] == "true"
            ]
    data["submitted_answers"] = right
    server.parse(data)
    server.grade(data)
    assert data["score"] == 1.0
    assert not data["format_errors"]

    k = server.KEYS.index("equation:1") + 1
    data["submitted_answers"] = {**right, f"p{k}": "0", "p1": "l q1'^2 +", "p2": ""}
    server.parse(data)
    server.grade(data)
    assert set(data["format_errors"]) == {"p1"}
    assert data["partial_scores"][f"p{k}"] == {"score": 0.0, "weight": 3}
    assert 0 < data["score"] < 1
    assert "should be" not in str(data["feedback"])  # which would be the answer
    html = (folder / "question.html").read_text()
    assert set(re.findall(r"\{\{\{?[#/]?(?:params|feedback)\.(\w+)", html)) <= {*data["params"], *data["feedback"]}
    json.dumps(data)


def test_the_folder_describes_itself_as_the_schema_of_prairielearn_wants():
    info = json.loads(asked(quiz("pendulum", 2), "prairielearn")["pendulum-prairielearn/info.json"])

    assert {"uuid", "type", "title", "topic"} <= set(info)  # required
    assert set(info) <= {
        "uuid",
        "type",
        "title",
        "topic",
        "tags",
        "partialCredit",
        "singleVariant",
    }  # no others are used
    assert re.fullmatch(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}", info["uuid"])
    assert info["type"] == "v3"
    assert isinstance(info["singleVariant"], bool)
    assert all(isinstance(one, str) for one in info["tags"])
    other = json.loads(asked(quiz("pendulum", 1), "prairielearn")["pendulum-prairielearn/info.json"])
    assert other["uuid"] != info["uuid"]


# STACK


@pytest.mark.parametrize("name", ["pendulum", pytest.param("cart_with_wheel", marks=pytest.mark.slow)])
def test_a_question_of_stack_is_whole(name):
    own, found = quiz(name, 2), Stack(text(name, "stack", 2))
    assert found.question.get("type") == "stack"
    inputs = [one.findtext("name") for one in found.question.findall("input")]
    assert inputs == [f"ans{k}" for k in range(1, len(own.keys) + 1)]
    shown = found.question.findtext("questiontext/text")
    for k, one in enumerate(inputs, 1):
        assert shown.count(f"[[input:{one}]]") == 1
        assert shown.count(f"[[feedback:prt{k}]]") == 1
    for tree in found.question.findall("prt"):
        nodes = tree.findall("node")
        for k, node in enumerate(nodes):
            assert node.findtext("name") == str(k)
            assert node.findtext("falsenextnode") == str(k + 1 if k + 1 < len(nodes) else -1)
        assert nodes[0].findtext("truescore") == "1"
    assert [one.text for one in found.question.findall("deployedseed")] == ["1", "2"]
    assert shown.count("[[if ") == shown.count("[[/if]]")
    own_marks = sum(own.marks(key) for key in own.keys)
    assert found.question.findtext("defaultgrade") == str(own_marks)


@pytest.mark.slow
@pytest.mark.runs("maxima")
@pytest.mark.parametrize("name", ANSWERS)
def test_maxima_finds_the_teachers_answers_right_and_every_wrong_one_of_a_rule_wrong(name):
    own, found = quiz(name, 2), Stack(text(name, "stack", 2))
    for seed, variant in enumerate(own.variants, 1):
        parts = [(k, variant.parts[key]) for k, key in enumerate(own.keys, 1)]
        right = [(k, f"quiz_ta{k}" if isinstance(x.asked, Blank) else f"listify(quiz_right{k})") for k, x in parts]
        assert found.notes(right, seed) == [(1.0, "right")] * len(right)
        letters = MAXIMA.letters(variant)
        wrong = [(k, one) for k, x in parts for one in x.wrong[:6]]
        told = found.notes([(k, MAXIMA.text(one.form, letters)) for k, one in wrong], seed)
        for (k, one), (score, note) in zip(wrong, told, strict=True):
            if note == "numbers":  # in the scene's own numbers it is the right one, as the checker says as well
                assert own.variants[seed - 1].document.scene.parameters
                continue
            assert score == 0.0, (name, own.keys[k - 1], one.text)
            assert note == "turned" or note.startswith("rule"), (name, own.keys[k - 1], one.text)


# Numbas


def test_the_reader_of_jme_reads_as_its_documents_say():
    def value(source: str) -> object:
        return Script({}, {"x": 3.0}).value(parsed(source), {})

    assert value("2 + 3*x^2") == 29
    assert value("-x^2") == -9
    assert value("2^3^2") == 512
    assert value("7 - 2 - 1") == 4
    assert value("let(a, [1, 2], map(2*k, k, a + [x])[2])") == 6
    assert value('try(eval(parse("y"), ["z": 1]), fault, "none")') == "none"
    assert value('x isa "number" and not ("a" isa "number")') is True
    with pytest.raises(JmeError, match="missing"):
        parsed("2*(x")


def test_an_exam_of_numbas_is_whole_and_its_parts_are_marked():
    own, found = quiz("pendulum", 2), Numbas(text("pendulum", "numbas", 2), 1)
    assert [part["type"] for part in found.question["parts"]] == [
        "jme" if isinstance(part.asked, Blank) else "m_n_2"
        for part in own.variants[0].parts.values()
        if part.key in own.keys
    ]
    assert set(found.question["variables"]) == {"quiz_variant", "quiz_data", "quiz_shown"}
    known = found.known()
    answers = [(k, part["answer"]) for k, part in enumerate(known["quiz_data"]["parts"]) if "answer" in part]
    assert all(credit == 1.0 for credit, _ in found.marked(answers))
    told = found.marked([(0, f"3*({answers[0][1]})"), (0, "q9"), (0, "l*("), (0, "")])
    assert [credit for credit, _ in told] == [0.0] * 4
    choice = next(k for k, key in enumerate(own.keys) if isinstance(own.parts(key)[1].asked, Choice))
    lettered = own.parts(own.keys[choice])[1].asked
    assert [m > 0 for m in known["quiz_data"]["parts"][choice]["matrix"]] == [x.right for x in lettered.options]


# One verdict


@pytest.mark.parametrize("name", ["pendulum", *(pytest.param(x, marks=pytest.mark.slow) for x in OTHERS)])
def test_the_checker_and_numbas_give_one_verdict(name):
    own, rows = quiz(name), ANSWERS[name]

    ours = [own.marked(key, answer).right for key, answer, _ in rows]
    numbas = Numbas(text(name, "numbas")).marked([(own.keys.index(key), typed(x, JME, own)) for key, x, _ in rows])

    expected = [right for *_, right in rows]
    assert ours == expected
    assert [credit == 1.0 for credit, _ in numbas] == expected


@pytest.mark.slow
@pytest.mark.runs("maxima")
@pytest.mark.parametrize("name", ANSWERS)
def test_stack_gives_the_same_verdict(name):
    own, rows = quiz(name), ANSWERS[name]

    told = Stack(text(name, "stack")).notes([(own.keys.index(key) + 1, typed(x, MAXIMA, own)) for key, x, _ in rows])

    assert [score == 1.0 for score, _ in told] == [right for *_, right in rows]


@pytest.mark.targets
@pytest.mark.runs("node")
@pytest.mark.skipif("NUMBAS" not in os.environ, reason="NUMBAS is a copy of its source, with npm install in its tests/")
@pytest.mark.parametrize("name", ANSWERS)
def test_numbas_itself_gives_the_same_verdict(name):
    own, rows, exam = quiz(name), ANSWERS[name], text(name, "numbas")
    answers = [[own.keys.index(key), typed(x, JME, own)] for key, x, _ in rows]
    known = Numbas(exam).known()["quiz_data"]["parts"]
    chosen = [[k, [[m > 0] for m in part["matrix"]]] for k, part in enumerate(known) if "matrix" in part]
    given = json.dumps({"exam": exam, "variant": 0, "answers": answers + chosen})

    script = Path(__file__).parent / "quiz_numbas.mjs"
    done = subprocess.run(["node", str(script)], input=given, capture_output=True, text=True, check=True, timeout=300)

    credits = [credit == 1 for credit, _ in json.loads(done.stdout)]
    assert credits == [right for *_, right in rows] + [True] * len(chosen)


# Letters and errors


def test_a_term_that_the_numbers_of_a_scene_make_zero_is_zero():
    """cos(D) at D = 90 deg was 5e-12, as D had twelve digits, and 0 was wrong on platforms alone."""
    source = (
        'gravity = [0, "-g", 0]\n[parameters]\nm = 1\ng = 9.81\nD = "90 deg"\n[bodies.cart]\nmass = "m"\n'
        '[joints.rail]\ntype = "prismatic"\nparent = "ground"\nchild = "cart"\naxis = [0, 1, 0]\n'
        'origin = { rpy = [0, 0, "D"] }\n'
    )
    own = Handout(read_text(source, "x.toml"), exercises=True, until="equations").quiz()
    exam = Numbas(*asked(own, "numbas").values())

    for key, answer in (("potential:1", "0"), ("slope:1", "0"), ("potential:1", "m*q1")):
        credit = exam.marked([(own.keys.index(key), answer)])[0][0]
        assert (credit == 1.0) == own.marked(key, answer).right == (answer == "0")


def test_braces_of_a_text_are_no_expressions_of_numbas():
    """Numbas evaluates what stands between them, in names, prose and what pictures say: the exam did not start."""
    source = (EXAMPLES / "pendulum.toml").read_text(encoding="utf-8")
    scene = read_text(source.replace("of the bob", "of {m}").replace('en = "pendulum"', 'en = "rod {@1@}"'), "x.toml")
    exam = Numbas(asked(Handout(scene, exercises=True, until="energies").quiz(), "numbas")["pendulum-numbas.exam"], 0)

    shown = exam.known()["quiz_shown"]
    assert exam.question["name"].startswith("Rod (@1@)")
    assert "<td>mass of (m)</td>" in shown["task"]
    assert not re.search(r"\{[@m]", re.sub(r"\\[(\[].*?\\[)\]]", "", shown["task"]))


def test_a_letter_that_means_something_else_on_a_platform_gets_another_name():
    source = (EXAMPLES / "pendulum.toml").read_text(encoding="utf-8")
    scene = read_text(re.sub(r'^l(?= =)|(?<=-)l(?=")', "e", source, flags=re.MULTILINE), "e.toml")
    own = Handout(scene, exercises=True, until="energies").quiz()
    letters = MAXIMA.letters(own.variants[0])

    assert letters["e"] == "e_1"
    assert "<code>e_1</code>" in asked(own, "stack")["pendulum-stack.xml"]
    assert JME.letters(quiz("two_link").variants[0])["M1"] == "M1_1"  # beside m1: capital letters do not count


@pytest.mark.parametrize(
    ("dialect", "name", "new"),
    [(MAXIMA, "values", "values_1"), (MAXIMA, "step", "step_1"), (JME, "nand", "nand_1"), (JME, "Fact", "Fact_1"),
     (MAXIMA, "nand", "nand"), (JME, "step", "step")],
)  # fmt: skip
def test_words_of_a_platform_are_no_letters_there(dialect, name, new):
    """Maxima put its lists of functions into the answers, and found wrong ones right; Numbas could not read them."""
    source = (EXAMPLES / "pendulum.toml").read_text(encoding="utf-8")
    scene = read_text(re.sub(r'^l(?= =)|(?<=-)l(?=")', name, source, flags=re.MULTILINE), "x.toml")

    assert dialect.letters(Handout(scene, exercises=True, until="energies").quiz().variants[0])[name] == new


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--format", "stack"], "give --exercises, --grade or --ask"),
        (["--format", "moodle", "--exercises"], "'moodle' is no format"),
        (["--format", "numbas", "--exercises", "--sheet", "questions"], "--sheet is for pages and paper"),
        (["--format", "numbas", "--exercises", "--detail", "full"], "--detail is for pages and paper"),
        (["--format", "prairielearn", "--exercises", "-o", "q.zip"], "a folder of four files"),
        (["--format", "html", "--exercises", "--variants", "2"], "--variants are of a question"),
        (["--format", "stack", "--exercises", "--variants", "21"], "give 1 to 20"),
    ],
)
def test_what_does_not_fit_is_said(more, told, capsys):
    with suppress(SystemExit):
        assert main(["walkthrough", str(EXAMPLES / "pendulum.toml"), *more]) == 1
    assert told in capsys.readouterr().err


def test_a_question_that_is_none_is_refused():
    with pytest.raises(TeachError, match="there is no exercise 'square:9'"):
        quiz("pendulum").marked("square:9", "1")
    with pytest.raises(TeachError, match="nothing in this walkthrough can be left out; give a later part"):
        Handout(read(EXAMPLES / "four_bar.toml"), formulation="dalembert", until="count").quiz()


@pytest.mark.runs("node")
@pytest.mark.parametrize("name", ["cart_with_wheel", pytest.param("four_bar", marks=pytest.mark.slow)])
def test_a_page_finds_every_answer_of_its_own_lesson_right(name):
    """Equations with multipliers were judged wrong: what stands in front of their box was taken without these."""
    document = quiz(name).variants[0].document
    own = [(one.key, text_of(one.answer)) for _, one in document.blocks() if isinstance(one, Blank)]
    scripts = (folder("templates") / "teach" / one for one in ("formulas.js", "terms.js", "answers.js"))
    program = [
        f"const QUESTIONS = {json.dumps(questions(document))};",
        *(one.read_text(encoding="utf-8") for one in scripts),
    ]
    program.append(
        f"console.log(JSON.stringify({json.dumps(own)}.map(([key, text]) => Answers.judge(key, text).right)))"
    )

    done = subprocess.run(["node", "-"], input="\n".join(program), capture_output=True, text=True, check=True)

    assert any(key.startswith("equation") for key, _ in own)
    assert json.loads(done.stdout) == [True] * len(own)
