"""A language is one file: a made-up one is added, and no word of another is left on any page."""

from __future__ import annotations

import json
import re
import shutil
import tomllib
from collections.abc import Iterator
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path

import pytest
from lessons import lesson_of

from symdyn.cli import main
from symdyn.errors import SceneError
from symdyn.frozen import fields
from symdyn.scene import Scene, read
from symdyn.scene.forces import FORCES
from symdyn.scene.forces.force_table import sections
from symdyn.scene.joints import JOINTS
from symdyn.scene.toml import read_text, write_text
from symdyn.scene.values import model
from symdyn.scene.values.key import keys_of
from symdyn.teach import rendered, walkthrough

room = import_module("symdyn.teach.languages")  # a name that its package offers for something else

EXAMPLES = Path(__file__).parent.parent / "examples"
LETTERS = dict(
    zip(
        map(ord, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"),
        "àáâãäåæçèéêëìíîïðñòóôõöøùúÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÐÑÒÓÔÕÖØÙÚ",
        strict=True,
    )
)
"""Letters that LaTeX sets as they are."""
KEPT = re.compile(r"(\{\w*\}|<[^>]*>|\\\w+)")
CODE = "xx"
SILENT = ("script", "style", "math", "code")
SPOKEN = ("aria-label", "title", "alt", "placeholder", "data-text")
UNITS = {"rad", "sin", "cos", "tan", "atan"}
"""And functions, which formulas have in every language."""


def pseudo(text: str) -> str:
    """Return a text in other letters, its places, tags and commands as they are."""
    return "".join(piece if k % 2 else piece.translate(LETTERS) for k, piece in enumerate(KEPT.split(text)))


def spelled(table: dict[str, object], name: str = "") -> Iterator[str]:
    """Yield the lines of a TOML table of texts and tables, all texts in other letters."""
    inner = {key: value for key, value in table.items() if isinstance(value, dict)}
    if name:
        yield f"[{name}]"
    for key, value in table.items():
        if isinstance(value, str):
            said = pseudo(value).replace("\\", "\\\\").replace('"', '\\"')
            yield f'"{key}" = "{said}"'
    for key, value in inner.items():
        yield from spelled(value, f"{name}.{key}" if name else key)


@pytest.fixture
def made_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Add a language that nobody speaks, and return its code."""
    folder = tmp_path / "languages"
    folder.mkdir()
    for path in room.FOLDER.glob("*.toml"):
        shutil.copy(path, folder)
    english = tomllib.loads((folder / "en.toml").read_text("utf-8"))
    kinds = {name: kind.words["en"] for name, kind in {**JOINTS, **FORCES}.items()}
    text = "\n".join(spelled({**english, "kinds": kinds}))
    (folder / f"{CODE}.toml").write_text(text, "utf-8")
    monkeypatch.setattr(room, "FOLDER", folder)
    return CODE


class Seen(HTMLParser):
    """What a person reads or hears of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.depth: list[str] = []
        self.parts: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.parts += [value for key, value in attrs if key in SPOKEN and value]
        if tag in SILENT and tag not in self.depth[-1:]:
            self.depth.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if self.depth[-1:] == [tag]:
            self.depth.pop()

    def handle_data(self, data: str) -> None:
        if not self.depth:
            self.parts.append(data)


def foreign(text: str, scene: str) -> list[str]:
    """Return the words of a text that are neither the scene's nor made up."""
    one = read(EXAMPLES / f"{scene}.toml")
    parts = (one, *one.bodies, *one.joints, *one.loops, *one.elements, *one.parameters)
    known = set(re.findall(r"[A-Za-z]+", " ".join([*one.coordinates, *(f"{x.name} {x.text}" for x in parts)])))
    known |= UNITS | {word.capitalize() for word in known}  # a title begins with a capital
    return sorted({word for word in re.findall(r"[A-Za-z]{3,}", text) if word not in known})


def seen(page: str) -> str:
    """Return what is read or heard of a page, a part a line."""
    parser = Seen()
    parser.feed(page)
    return "\n".join(parser.parts)


def said_in_markdown(text: str) -> str:
    """Return what is read of Markdown: no formulas, no code, no names of files."""
    for kept in (r"```.*?```", r"\$\$.*?\$\$", r"\$[^$]*\$", r"`[^`]*`", r"\]\([^)]*\)", r"<[^>]*>"):
        text = re.sub(kept, " ", text, flags=re.S)
    return text


def said_in_notebook(text: str) -> str:
    """Return what is read of a notebook: cells of text, and comments of cells of code."""
    cells = json.loads(text)["cells"]
    told = [said_in_markdown("".join(cell["source"])) for cell in cells if cell["cell_type"] == "markdown"]
    code = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    return "\n".join([*told, *re.findall(r"^\s*# (.*)$", code, flags=re.M)])


def said_in_latex(text: str) -> str:
    """Return what is read of the body of a LaTeX file: no formulas, pictures' strokes, commands or sizes."""
    body = text[text.index(r"\begin{document}") :]
    for kept in (
        r"\\pdfliteral\{[^}]*\}",
        r"\\(begin|end)\{(equation|align|gather|multline)\*?\}.*?\\end\{\2\*?\}",
        r"\\\[.*?\\\]",
        r"\$[^$]*\$",
        r"\\(begin|end|label|tag|includegraphics|href|url|color|textcolor)(\[[^]]*\])?\{[^}]*\}(\{@\{\}\w*@\{\}\}|\{\w{6}\})?",
        r"\\[A-Za-z]+",
    ):
        body = re.sub(kept, " ", body, flags=re.S)
    return body


SAID = {"html": seen, "md": said_in_markdown, "ipynb": said_in_notebook, "tex": said_in_latex, "svg": seen}
"""What is read of a file, by how its name ends."""

LESSON = ("--format", "html,md,notebook,latex")
CASES = [
    ("two_link", LESSON),
    ("cart_pole", ("--format", "html,md", "--exercises")),
    ("four_bar", ("--format", "html,md", "--formulation", "dalembert")),
    ("slider_crank", (*LESSON, "--formulation", "multipliers")),
    ("heavy_top", (*LESSON, "--formulation", "quaternions")),
    ("rolling_disc", ("--format", "html,md", "--formulation", "quaternions")),
    ("cart_with_wheel", ("--format", "html,md", "--formulation", "multipliers")),
    ("double_pendulum", ("--format", "html,md", "--sheet", "solutions", "--seed", "3")),
    ("heavy_top", ("--format", "sliders")),
]


@pytest.mark.wide("slider_crank-words3")
@pytest.mark.long(0)
@pytest.mark.parametrize(("scene", "words"), CASES)
def test_no_word_of_another_language_is_in_a_lesson(
    made_up: str, scene: str, words: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "lesson"
    assert main(["walkthrough", str(EXAMPLES / f"{scene}.toml"), *words, "--language", made_up, "-o", str(out)]) == 0

    for path in sorted(out.iterdir()):
        text = path.read_text("utf-8")
        if path.suffix == ".html":
            assert f'lang="{made_up}"' in text
        assert (path.name, foreign(SAID[path.suffix[1:]](text), scene)) == (path.name, [])


# What a scene says of its parameters

BOB = """
name = "bob"
gravity = [0, -9.81, 0]
[parameters]
m = {{ value = 2, unit = "kg", text = {text} }}
[inputs.u]
text = {{ en = "voltage", sk = "napätie" }}
[bodies.rod]
particles = [{{ mass = "m", at = [1.5, 0, 0] }}]
[joints.pivot]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 0, 1]
"""


def test_a_scene_may_say_what_its_letters_are_in_several_languages() -> None:
    scene = read_text(BOB.format(text='{ en = "mass of the bob", sk = "hmotnosť závažia" }'))

    assert [one.text for one in (*scene.parameters, *scene.inputs)] == ["mass of the bob", "voltage"]
    assert [one.text for one in scene.in_language("sk").parameters] == ["hmotnosť závažia"]
    assert read_text(write_text(scene).text) == scene
    pages = {code: rendered(walkthrough(scene, code), "md")["bob.md"] for code in ("en", "sk")}
    assert "hmotnosť závažia" in pages["sk"]
    assert "mass of the bob" not in pages["sk"]
    assert "mass of the bob" in pages["en"]
    only = read_text(BOB.format(text='{ sk = "hmotnosť závažia" }'))
    assert only.parameters[0].text == "hmotnosť závažia"
    assert read_text(write_text(only).text) == only


SPRUNG = """
name = "cart"
gravity = "none"
units = "none"
bodies.cart = { mass = 2, text = { en = "trolley", sk = "vozík" } }
joints.rail = { type = "prismatic", axis = [1, 0, 0], parent = "ground", child = "cart", coordinate = "x" }
springs.s = { from = "ground", to = "cart", stiffness = 3, text = { en = "buffer", sk = "nárazník" } }
dampers.d = { joint = "rail", damping = 1, text = { en = "oil", sk = "olej" } }
loads.w = { body = "cart", force = [3, 0, 0], text = { en = "gust", sk = "poryv" } }
"""


def test_what_acts_is_called_in_lessons_and_pictures_as_its_scene_says_in_each_language() -> None:
    scene = read_text(SPRUNG)
    assert read_text(write_text(scene).text) == scene
    words = {code: [one.text for one in scene.in_language(code).elements] for code in ("en", "sk")}
    assert words == {"en": ["buffer", "oil", "gust"], "sk": ["nárazník", "olej", "poryv"]}
    for code, other in (("en", "sk"), ("sk", "en")):
        lesson = rendered(walkthrough(scene, code, detail="full"), "md")
        (page,) = (text for name, text in lesson.items() if name.endswith(".md"))
        (drawn,) = (text for name, text in lesson.items() if name.endswith("-scene.svg"))
        for one, strange in zip(words[code], words[other], strict=True):
            assert one in page
            assert one in re.sub("<title>.*?</title>", "", drawn), "its label"
            assert one in "".join(re.findall("<title>.*?</title>", drawn)), "what is told to who points at it"
            assert strange not in page + drawn


def test_what_takes_a_description_is_said_once() -> None:
    """The lists of `DESCRIBED` are those of a scene whose members have a text, and sections of files with that key."""
    lists = {one.name: one.type[6:-6] for one in fields(Scene) if str(one.type).endswith(", ...]")}
    nouns = {name: getattr(model, noun) for name, noun in lists.items() if noun != "tuple[str, str]"}
    assert [name for name in nouns if name in model.DESCRIBED] == [
        name for name, noun in nouns.items() if "text" in {one.name for one in fields(noun)}
    ]
    assert all("text" in keys_of(kind.parts) for kind in FORCES.values() if kind.section in sections())


@pytest.mark.parametrize("text", ['{ english = "mass" }', "{ en = 1 }", "{}", '{ en = "a", sk = ["b"] }', "3"])
def test_what_is_no_description_is_told(text: str) -> None:
    with pytest.raises(SceneError, match=r"parameters\.m"):
        read_text(BOB.format(text=text))


@pytest.mark.parametrize("code", room.languages())
def test_no_key_of_lessons_stands_in_two_tables(code: str) -> None:
    """All tables are read as one: the later of two would be said in place of the other."""
    tables = tomllib.loads((room.FOLDER / f"{code}.toml").read_text(encoding="utf-8"))["lesson"]
    keys = [key for table in tables.values() for key in table]
    assert sorted(keys) == sorted(set(keys))


# What is not on a page


@pytest.mark.long(0)
def test_no_word_of_another_language_is_in_an_answer(
    made_up: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.txt"
    mine.write_text(
        "k_z12 = m_2 h_2^2 + m_2 h_1 h_2 sin q_2\nk_z22 = 1.5 m_2 h_2^2\nK = K\nP = m_1 g\nM_1 = M_1\n"
        "k_z11 = (m_1 + m_2) h_1^2 + m_2 h_2^2\n",
        "utf-8",
    )

    main(["check-derivation", str(mine), str(EXAMPLES / "two_link.toml"), "--language", made_up])

    said = capsys.readouterr().out
    assert len(said.splitlines()) > 6
    assert set(foreign(said, "two_link")) <= {"sin", "cos", "tau"}


@pytest.mark.long(0)
@pytest.mark.wide("slider_crank")
@pytest.mark.parametrize(("scene", "formulation"), [("slider_crank", "multipliers"), ("heavy_top", "quaternions")])
def test_slovak_lessons_have_decimal_commas(scene: str, formulation: str) -> None:
    page = rendered(lesson_of(read(EXAMPLES / f"{scene}.toml"), "sk", formulation=formulation), "md")[f"{scene}.md"]

    assert "9,81" in page
    assert re.findall(r"(?<![\d.(])\d+\.\d+", re.sub(r"\\tag\{[^}]*\}|\(5\.[\d.,() -]*\)", "", page)) == []


def test_a_lesson_calls_the_scene_its_bodies_and_joints_as_they_are_described() -> None:
    scene = read(EXAMPLES / "two_link.toml")
    english, slovak = (walkthrough(scene, language, until="energies") for language in ("en", "sk"))
    told = str(rendered(slovak, "md")["two_link.md"])

    assert english.title == "Two-link mechanism: the equations of motion, step by step"
    assert slovak.title == "Dvojčlenný otvorený mechanizmus: pohybové rovnice krok za krokom"
    assert "spojení S1" in told
    assert "člena 2" in told
    assert "shoulder" not in told
    back = read_text(write_text(scene).text)
    assert back == scene
    assert [one.text for one in (*back.bodies, *back.joints)] == ["link 1", "link 2", "shoulder", "elbow"]
