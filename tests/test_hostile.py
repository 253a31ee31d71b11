"""What a stranger's scene may say, and what becomes of the rest: refused at the door, printable where it is quoted."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import hostile
import pytest
from hostile import NAME, in_notebook, in_pdflatex, quoted, scene_with
from placeless import placeless

from symdyn.cli import main
from symdyn.errors import SceneError
from symdyn.scene.toml import read_text

FOUND = Path(__file__).parent / "data" / "found"


def lesson(scene: Path, ending: str) -> Path | None:
    """Return the lesson of a scene, None where the scene is refused."""
    path = scene.parent / f"l.{ending}"
    return path if main(["walkthrough", str(scene), "-o", str(path)]) == 0 else None


def saved(folder: Path, latex: str, texts: dict[str, str] | None = None) -> Path:
    path = folder / f"{NAME}.toml"
    path.write_text(scene_with(texts or {}, latex), encoding="utf-8")
    return path


# The LaTeX of a symbol


@pytest.mark.mends("1.1")
@pytest.mark.parametrize("own", [False, True])
def test_a_notebook_runs_nothing_of_its_scene(own: bool, tmp_path: Path) -> None:
    scene = saved(tmp_path, hostile.PAYLOADS["raw"])
    if not own:
        scene.write_bytes((FOUND / "lesson_payload.toml").read_bytes())

    book = lesson(scene, "ipynb")

    assert book is None or in_notebook(book) == []
    assert not (tmp_path / "PWNED").exists()


@pytest.mark.mends("1.2")
@pytest.mark.parametrize(
    "latex",
    [
        r"l\immediate\write18{touch canary}",
        r"l\immediate\openout15=canary.txt ",
        r"\input{|touch^^20canary}l",
        r"\catcode`!=0 !immediate!write18{touch canary}l",
    ],
)
def test_no_latex_of_a_symbol_runs_in_tex(latex: str, tmp_path: Path) -> None:
    path = lesson(saved(tmp_path, latex), "tex")

    assert path is None or in_pdflatex(path) == []


@pytest.mark.mends("1.3")
def test_no_latex_of_a_symbol_becomes_a_link(tmp_path: Path) -> None:
    path = lesson(saved(tmp_path, r"\href{javascript:alert(1)}{l}"), "html")

    assert path is None or "javascript:" not in path.read_text(encoding="utf-8")


BROKEN = ["_", "^", "a^b^c", "a_b_c", "a^b'", r"\left(", r"\frac", r"\def\x{\x\x}\x", r"\hat", r"\mathrm", "k_"]
BROKEN += [r"\text", r"k^\frac", r"\begin{x}", r"\sqrt[", "{}", r"\middle|", r"\unknown", r"l\over", r"\limits"]
BROKEN += ["(", r"\text{a$b}"]


@pytest.mark.mends("1.4")
@pytest.mark.parametrize("latex", BROKEN)
def test_latex_that_no_target_shows_is_refused_in_a_sentence(
    latex: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert lesson(saved(tmp_path, latex), "html") is None

    said = capsys.readouterr().err
    assert f'{NAME}.toml: parameters.l: latex = "' in placeless(said)
    assert "; " in said


@pytest.mark.runs
def test_what_the_grammar_holds_every_target_shows(tmp_path: Path) -> None:
    from random_latex import random_symbols

    from symdyn.draw.style import Text
    from symdyn.scene.values import LatexSymbol
    from symdyn.teach.mathematics import inner

    symbols = random_symbols(600, 11)
    elements = {"mi", "mn", "mo", "mtext", "mrow", "msub", "msup", "msubsup", "mover", "munder", "mspace"}
    for latex in symbols:
        mathml = inner(latex)
        assert {*re.findall(r"<(\w+)", mathml)} <= elements, latex
        assert "\\" not in Text.of_latex(latex).svg(), latex

    powers = [f"{x}^2" if LatexSymbol(x).takes_exponent else f"({x})^2" for x in symbols]
    lines = "\n\n".join(f"${x}$ $\\frac{{{x}}}{{2}} {power}$" for x, power in zip(symbols, powers, strict=True))
    packages = r"\usepackage[T1]{fontenc}\usepackage{amsmath}"
    path = tmp_path / "symbols.tex"
    path.write_text(
        f"\\documentclass{{article}}{packages}\\begin{{document}}{lines}\\end{{document}}", encoding="utf-8"
    )
    assert in_pdflatex(path) == []


def test_symbols_that_look_alike_are_one() -> None:
    from symdyn.scene.values import LatexSymbol

    looks = {LatexSymbol(x).letters for x in ("m_1", "m_{1}", "{m} _1", "m _ { 1 }")}
    assert looks == {"m_{1}"}


def test_a_parameter_that_is_printed_as_another_symbol_is_told_apart() -> None:
    from symdyn.emit.print.printed_names import latex_symbols

    for latex in ("m_{ }{g}", "{g}", "{q}_1", r"\dot{q}_{1}", r"\ddot q _1"):
        shown = latex_symbols(read_text(scene_with({}, latex)))
        assert shown["l"] == r"\mathtt{l}" or latex == "m_{ }{g}"


# A scene made in Python takes the same door


def declared(text: str) -> dict[str, dict[str, object]]:
    """Return what says a text in each place of a scene that is made in Python."""
    from symdyn.scene import body, constraint, parameter, point, revolute, spring

    joints: dict[str, dict[str, object]] = {
        "drive": {"drive": text},
        "coordinate": {"coordinate": text},
        "parent": {"parent": text},
        "axis": {"axis": [0, 0, text]},
    }
    made: dict[str, dict[str, object]] = {
        "name": {"name": text},
        "parameter": {"parameters": [parameter(text, 1)]},
        "parameters": {"parameters": {text: 1}},
        "value": {"parameters": [parameter("k", text)]},
        "latex": {"parameters": [parameter("k", 1, latex=text)]},
        "body": {"bodies": [body("bob", mass=1), body(text, mass=1)]},
        "mass": {"bodies": [body("bob", mass=text)]},
        "point": {"points": [point(text, "bob")]},
        "spring": {"springs": [spring(text, joint="hinge", stiffness=1)]},
        "row": {"constraints": [constraint("r", text)]},
        "gravity": {"gravity": [0, 0, text]},
    }
    hinge: dict[str, object] = {"parent": "ground", "child": "bob", "axis": [0, 0, 1]}
    for key, given in joints.items():
        made[key] = {"joints": [revolute("hinge", **(hinge | given))]}  # type: ignore[arg-type]
    return made


@pytest.mark.parametrize("where", declared(""))
def test_a_scene_made_in_python_says_no_more_than_one_in_a_file(where: str) -> None:
    from symdyn.scene import body, revolute, scene

    plain = {"bodies": [body("bob", mass=1)], "joints": [revolute("hinge", "ground", "bob", axis=[0, 0, 1])]}
    for text in (*hostile.PAYLOADS.values(), CONTROLS):
        with pytest.raises(SceneError) as caught:
            scene(**({"name": "made"} | plain | declared(text)[where]))  # type: ignore[arg-type]
        assert printable(str(caught.value))


# Words


@pytest.mark.parametrize(
    ("key", "text"), [("text", "a" * 201), ("unit", "m\u202e"), ("text", "a\nb"), ("unit", "\x9b")]
)
def test_words_are_one_line_of_bearable_length(key: str, text: str) -> None:
    scene = scene_with({}).replace('unit = "m",', f"{key} = {quoted(text)},")
    with pytest.raises(
        SceneError, match=rf"parameters.l: {key} = .* (200 are enough|unprintable character; write one line)"
    ):
        read_text(scene)


CONTROLS = "\x1b[2J\x1b]0;title\x07\r\b\x7f\x9b31m\u202e\u2028"

QUOTING = {  # where a scene may put control characters so that a message quotes them
    "name": ('name = "stranger"', f"name = {quoted(CONTROLS)}"),
    "root key": ('name = "stranger"', f'{quoted(CONTROLS)} = 1\nname = "stranger"'),
    "parameter": ("g = {", f'{quoted(CONTROLS)} = 1\ng = {{'),
    "unit": ('unit = "kg"', f"unit = {quoted(CONTROLS)}"),
    "text": ('unit = "kg"', f"text = {quoted(CONTROLS)}"),
    "latex": ('unit = "kg"', f"latex = {quoted(CONTROLS)}"),
    "value": ('unit = "kg"', f"value = {quoted(CONTROLS)}"),
    "key": ('unit = "kg"', f"{quoted(CONTROLS)} = 1"),
    "body": ("[bodies.bob]", f"[bodies.{quoted(CONTROLS)}]"),
    "joint": ("[joints.hinge]", f"[joints.{quoted(CONTROLS)}]"),
    "type": ('"revolute"', quoted(CONTROLS)),
    "parent": ('"ground"', quoted(CONTROLS)),
    "coordinate": ("axis =", f"coordinate = {quoted(CONTROLS)}\naxis ="),
    "drive": ("axis =", f"drive = {quoted(CONTROLS)}\naxis ="),
    "formula": ('"-g", 0]\n[par', f'{quoted("g*" + CONTROLS)}, 0]\n[par'),
    "axis": ("[0, 0, 1]", f"[0, 0, {quoted(CONTROLS)}]"),
    "point": ("[joints", f"[points.{quoted(CONTROLS)}]\nbody = \"bob\"\n[joints"),
    "spring": ("[joints", f"[springs.{quoted(CONTROLS)}]\njoint = {quoted(CONTROLS)}\nstiffness = 1\n[joints"),
    "row": ("[joints", f"[constraints.{quoted(CONTROLS)}]\nformula = {quoted(CONTROLS)}\n[joints"),
    "loop": ("[joints", f"[[loop]]\nname = {quoted(CONTROLS)}\ntype = {quoted(CONTROLS)}\n[joints"),
    "no TOML": ("[joints", f"{CONTROLS}\n[joints"),
}  # fmt: skip


def printable(text: str) -> bool:
    return all(line.isprintable() for line in text.split("\n"))


def mended(cases: Iterable[Any], *held: Any) -> list[Any]:
    """Return cases, those marked that obeyed control characters once; some held from the start."""
    return [pytest.param(x, marks=() if x in held else pytest.mark.mends("2.control")) for x in cases]


@pytest.mark.parametrize("where", mended(QUOTING, "no TOML"))
def test_no_message_obeys_control_characters_of_a_scene(
    where: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    old, new = QUOTING[where]
    scene = scene_with({})
    assert old in scene
    path = tmp_path / f"{NAME}.toml"
    path.write_text(scene.replace(old, new, 1), encoding="utf-8")

    assert main(["info", str(path)]) == 1

    said = capsys.readouterr()
    assert printable(said.err), repr(said.err)
    assert said.err.startswith(f"symdyn: {path}:")


@pytest.mark.parametrize("where", [where for where in QUOTING if where not in ("unit", "text", "no TOML")])
def test_what_acts_in_some_target_is_no_name_and_no_formula(where: str) -> None:
    old, new = QUOTING[where]
    for payload in hostile.PAYLOADS.values():
        told = new.replace(quoted(CONTROLS), quoted(payload)).replace(quoted("g*" + CONTROLS), quoted("g*" + payload))
        with pytest.raises(SceneError) as caught:
            read_text(scene_with({}).replace(old, told, 1))
        assert printable(str(caught.value))


def test_no_name_of_a_scene_begins_a_line_that_looks_like_ours(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"{NAME}.toml"
    path.write_text(scene_with({}).replace("bob", "b", 1).replace("[bodies.b]", '[bodies."b\\nsymdyn: all is well"]'))

    assert main(["info", str(path)]) == 1
    assert all(line.startswith(("symdyn: /", "/")) for line in capsys.readouterr().err.splitlines())


ROBOT = """<?xml version="1.0"?>
<robot name="r{bad}"><link name="base{bad}"/><link name="arm{bad}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge{bad}" type="revolute"><parent link="base{bad}"/><child link="arm{bad}"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="{bad}" multiplier="{factor}"/></joint></robot>
"""


@pytest.mark.mends("2.control")
@pytest.mark.parametrize("factor", ["1", "&#x9b;31m"])
def test_no_message_obeys_control_characters_of_a_robot(
    factor: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "r.urdf"
    path.write_text(ROBOT.format(bad="&#x9b;2J&#x202e;&#x85;", factor=factor), encoding="utf-8")

    assert main(["info", str(path)]) == 1

    said = capsys.readouterr()
    assert printable(said.err), repr(said.err)


FUNCTIONS = ["generate", "{scene}", "--functions", "\x1b[2J"]


@pytest.mark.parametrize(
    "words",
    mended(
        [
            ["info", "{folder}/\x1b[2J\r.toml"],
            ["draw", "{scene}", "--at", "\x1b[2J=1"],
            ["draw", "{scene}", "--body", "\x1b[2J"],
            FUNCTIONS,
            ["info", "{scene}", "--bind", "\x1b[2J=1"],
            ["check-derivation", "{folder}/\x1b[2J", "{scene}"],
            ["draw", "{scene}", "-o", "{folder}/\x1b[2J\n.svg"],
            ["generate", "{scene}", "-o", "{folder}/\x1b[2J\r"],
        ],
        FUNCTIONS,
    ),
)
def test_no_message_obeys_control_characters_of_an_argument(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = saved(tmp_path, "")

    status = main([word.format(scene=scene, folder=tmp_path) for word in words])

    said = capsys.readouterr()
    assert status == (0 if "-o" in words else 2 if words[0] == "check-derivation" else 1)
    assert printable(said.err + said.out), repr(said.err)


USAGE = [["info", "x.toml", "\x1b[2J"], ["\x1b[2J"], ["draw", "x.toml", "--scheme", "\x1b[2J"]]


@pytest.mark.parametrize("words", mended(USAGE, *USAGE[1:]))
def test_no_usage_message_obeys_control_characters(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(words)
    assert printable(capsys.readouterr().err)


@pytest.mark.parametrize("answer", ["k_{z,11} = \x1b[2J m", "l\x9b = 3", "k_{z,11} = m l^2 \x07"])
def test_a_student_s_text_is_quoted_without_control_characters(
    answer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.txt"
    path.write_text(answer, encoding="utf-8")

    assert main(["check-derivation", str(path), str(saved(tmp_path, ""))]) in (1, 2)

    said = capsys.readouterr()
    assert said.out + said.err
    assert printable(said.out + said.err)
