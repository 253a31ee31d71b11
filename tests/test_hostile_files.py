"""Every file that we write of a stranger's scene, opened by its own program: no word of the scene acts there."""

from __future__ import annotations

import re
import shlex
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import hostile
import pytest
from hostile import (
    PAYLOADS,
    in_browser,
    in_c,
    in_cpp,
    in_cuda,
    in_fmu,
    in_julia,
    in_jupyter,
    in_markdown,
    in_node,
    in_notebook,
    in_octave,
    in_opencl,
    in_pdflatex,
    in_python,
    in_rust,
    in_xml,
    scene_with,
    unescaped,
    write,
)

from symdyn.scene import read

pytestmark = pytest.mark.runs()

Harness = Callable[[Path], list[str]]

OPENERS: dict[str, Harness] = {
    ".py": in_python,
    ".c": in_c,
    ".hpp": in_cpp,
    ".rs": in_rust,
    ".cu": in_cuda,
    ".cl": in_opencl,
    ".mjs": in_node,
    ".js": in_node,
    ".m": in_octave,
    ".jl": in_julia,
    ".tex": in_pdflatex,
    ".svg": in_xml,
    ".fmu": in_fmu,
    ".ipynb": in_notebook,
    ".md": lambda path: in_markdown(path.read_text(encoding="utf-8")),
}

HEAVY = ("acados", "casadi", "heyoka", "matlab", "mex", "rust")
SLOW = ("asked", "dalembert", "dalembert-tex", "exercises", "free", "ufunc")


@pytest.fixture
def units_are_not_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let any text be a unit, which no reader does, so that what escapes units is seen to escape."""
    from symdyn.scene.values.unit import Unit, UnitError

    read = Unit.read

    def any_unit(text: str) -> Unit:
        try:
            return read(text)
        except UnitError:
            return Unit(text)

    monkeypatch.setattr(Unit, "read", staticmethod(any_unit))


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a scene that holds every payload as a description."""
    path = tmp_path_factory.mktemp("scene") / f"{hostile.NAME}.toml"
    path.write_text(scene_with(PAYLOADS), encoding="utf-8")
    return path


def opened(paths: list[Path], browser: Any = None) -> list[str]:
    """Return what all programs see of canaries in files."""
    openers = OPENERS if browser is None else {".html": partial(in_browser, browser)}
    paths = [path for path in paths if not path.stem.endswith("_main")]  # examples hold no words, and want a device
    return [f"{path.name}: {seen}" for path in paths if path.suffix in openers for seen in openers[path.suffix](path)]


def test_a_scene_may_hold_every_payload_as_words(scene: Path) -> None:
    texts = {parameter.text for parameter in read(scene).parameters}
    assert texts >= set(PAYLOADS.values())


def doors(*names: str) -> list[Any]:
    """Return doors to open, those marked slow that do as others do."""
    marks = {**dict.fromkeys(SLOW, pytest.mark.slow), **dict.fromkeys(HEAVY, pytest.mark.targets)}
    return [pytest.param(name, marks=marks.get(name, ())) for name in names]


@pytest.mark.heavy("fmu")
@pytest.mark.parametrize(
    "door",
    doors(
        *HEAVY,
        "julia",
        "numpy",
        "c",
        "cpp",
        "js",
        "gpu",
        "fmu",
        "ufunc",
        "tex",
        "asked",
        "dalembert-tex",
        "svg",
        "free",
    ),
)
def test_no_file_acts_on_words_of_its_scene(door: str, scene: Path, tmp_path: Path) -> None:
    paths = write(door, scene, tmp_path)

    assert any(path.suffix in OPENERS for path in paths)
    assert opened(paths) == []


@pytest.mark.heavy("ipynb")
@pytest.mark.mends("1.3")
@pytest.mark.parametrize("door", ["md", "ipynb"])
def test_no_prose_becomes_a_link_an_image_or_an_element(door: str, scene: Path, tmp_path: Path) -> None:
    assert opened(write(door, scene, tmp_path)) == []


@pytest.mark.parametrize("door", doors("html", "exercises", "sliders", "dalembert", "svg", "free"))
def test_no_page_acts_on_words_of_its_scene(door: str, scene: Path, tmp_path: Path, browser: Any) -> None:
    pages = [path for path in write(door, scene, tmp_path) if path.suffix in (".html", ".svg")]

    assert pages
    assert [seen for page in pages for seen in in_browser(browser, page)] == []


@pytest.mark.parametrize("door", ["toml", "par"])
def test_words_come_back_from_a_scene_that_was_written(door: str, scene: Path, tmp_path: Path) -> None:
    (path,) = write(door, scene, tmp_path)

    again, before = read(path), read(scene)
    assert [p.name for p in again.parameters] == [p.name for p in before.parameters] or door == "par"
    assert "canary" not in {p.name for p in again.parameters}
    if door == "toml":
        assert again.parameters == before.parameters
        assert "canary" not in tomllib.loads(path.read_text(encoding="utf-8"))["parameters"]


@pytest.mark.slow
def test_a_lesson_that_jupyter_executes_runs_nothing_of_its_scene(scene: Path, tmp_path: Path) -> None:
    assert in_jupyter(*write("ipynb", scene, tmp_path / "closed")) == []

    one = tmp_path / f"{hostile.NAME}.toml"
    one.write_text(scene_with({"triple": PAYLOADS["triple"]}), encoding="utf-8")
    with unescaped("in_code", lambda text: f"'''{text}'''"):
        assert in_jupyter(*write("ipynb", one, tmp_path / "open"))[:1] == ["canary"]


def test_a_document_without_a_shell_holds_every_word_too(scene: Path, tmp_path: Path) -> None:
    (path,) = write("tex", scene, tmp_path)
    assert in_pdflatex(path, shell=False) == []


# Names of files and of robots


SHELL = "x.toml; touch canary; $(touch canary) `touch canary`"
CONTROLLED = "\x1b[2J\n*+ int canary = 1; +*\r\u202e"


@pytest.mark.wide(5)
@pytest.mark.parametrize("door", doors(*HEAVY, "julia", "numpy", "c", "cpp", "js", "gpu"))
@pytest.mark.parametrize("name", [SHELL + PAYLOADS["docstring"], CONTROLLED], ids=["quotes", "controls"])
def test_no_file_acts_on_the_name_of_the_file_of_its_scene(name: str, door: str, tmp_path: Path) -> None:
    path = tmp_path / f"{name}.toml"
    path.write_text(scene_with({}).replace('name = "stranger"', ""), encoding="utf-8")
    paths = write(door, path, tmp_path / "out")

    assert opened(paths) == []
    assert all(line.isprintable() for made in paths for line in made.read_text("utf-8").split("\n"))


def test_the_command_that_a_file_quotes_is_one_word_for_each_of_its_words(tmp_path: Path) -> None:
    path = tmp_path / f"{SHELL}.toml"
    path.write_text(scene_with({}).replace('name = "stranger"', ""), encoding="utf-8")
    written = "".join(made.read_text(encoding="utf-8") for made in write("c", path, tmp_path / "out"))

    (command,) = set(re.findall(r"symdyn generate .*", written))
    assert shlex.split(command) == ["symdyn", "generate", path.name, "--target", "c", "--batch"]


ROD = """<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"""


def in_urdf(names: list[str]) -> str:
    """Return a robot whose links and joints have these names: one hinge, then fixed joints."""
    links = [quoteattr(f"base{name}") for name in names]
    parts = [f"<robot name={quoteattr(names[0])}>", *(f"<link name={link}>{ROD}</link>" for link in links)]
    for k, name in enumerate(names[1:]):
        kind = "fixed" if k else "continuous"
        ends = f'<parent link={links[k]}/><child link={links[k + 1]}/><axis xyz="0 0 1"/>'
        parts.append(f'<joint name={quoteattr(name)} type="{kind}">{ends}</joint>')
    return "".join([*parts, "</robot>"])


def in_mjcf(names: list[str]) -> str:
    """Return a model of hinges beside each other, named by these; names that MuJoCo cuts off stay apart."""
    bodies = "".join(
        f'<body name={quoteattr(name)}><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        f"<joint name={quoteattr(name)}/></body>"
        for name in names
    )
    return f"<mujoco model={quoteattr(names[0])}><worldbody>{bodies}</worldbody></mujoco>"


PENDULUM = (
    "NL = 1|NJ = 1|NF = 1|Type = 0|ant = {0}|sigma = {0}|b = {0}|d = {0}|r = {0}|gamma = {0}|alpha = {0}|mu = {1}"
)
PENDULUM += "|theta = {q1}|XX = {1}|YY = {1}|ZZ = {1}|M = {1}|G = {0, 0, -9}"


def in_par(names: list[str]) -> str:
    """Return a pendulum whose robot, link and joint have names that end no comment there but may act elsewhere."""
    held = [name for name in names if not {*"',\n"} & {*name}]
    said = [f"(* {what} = '{held[k]}' *)" for k, what in enumerate(("Robotname", "Link names", "Joint names"))]
    return "\n".join([*said, *PENDULUM.split("|")])


ROBOTS = {"urdf": in_urdf, "xml": in_mjcf, "par": in_par}
ROBOT_DOORS = [("urdf", door) for door in ("c", "svg", "toml", "urdf", "par", "js", "tex", "html")]
ROBOT_DOORS += [("xml", "toml"), ("xml", "c"), ("xml", "svg"), ("par", "toml"), ("par", "c"), ("par", "svg")]
LATE = [("urdf", "js"), ("urdf", "tex"), ("urdf", "html"), ("xml", "c"), ("xml", "svg"), ("par", "c"), ("par", "svg")]


@pytest.mark.parametrize(
    ("format", "door"),
    [pytest.param(*pair, marks=pytest.mark.slow if pair in LATE else ()) for pair in ROBOT_DOORS],
)
def test_no_file_acts_on_the_names_of_a_robot(
    format: str, door: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    path = tmp_path / f"r.{format}"
    path.write_text(ROBOTS[format]([*PAYLOADS.values()]), encoding="utf-8")
    paths = write(door, path, tmp_path / "out")

    assert paths
    assert opened(paths) == []
    if door in ("toml", "urdf", "par"):
        assert all(joint.name.isidentifier() and joint.child.isidentifier() for joint in read(paths[0]).joints)
    if door == "urdf":
        assert in_xml(paths[0]) == []
    if door == "html":
        assert opened(paths, request.getfixturevalue("browser")) == []


WORDS = ("arguments", "I", "this", "main", "NULL", "constructor", "errno")


@pytest.mark.parametrize("door", doors(*HEAVY, "julia", "numpy", "c", "cpp", "js", "tex"))
def test_names_may_be_words_of_any_language(door: str, tmp_path: Path) -> None:
    text = scene_with({"length": "length"}).replace("axis =", 'coordinate = "undefined"\ndrive = "linux"\naxis =')
    for old, new in zip(("g", "m", "l", "bob", "hinge", "stranger", "p0"), WORDS, strict=True):
        text = re.sub(rf'(?<![\w."]){old}(?= = {{)|(?<!unit = ")(?<=["-]){old}(?=")|(?<=\.){old}(?=\])', new, text)
    path = tmp_path / "words.toml"
    path.write_text(text, encoding="utf-8")
    assert {parameter.name for parameter in read(path).parameters} == {"arguments", "I", "this", "errno"}

    assert opened(write(door, path, tmp_path / "out")) == []


# The harnesses see what is not escaped


def plainly(text: str, *_: Any, **__: Any) -> str:
    return text


SEEN = [  # what is taken away, what stands in its place, a payload, the door
    ("in_docstring", plainly, "docstring", "numpy"),
    ("in_comment", plainly, "comment of C", "c"),
    ("in_comment", plainly, "comment of JavaScript", "js"),
    ("in_comment", plainly, "comment of C", "gpu"),
    ("in_comment", plainly, "comment of C", "cpp"),
    ("in_xml", plainly, "attribute", "fmu"),
    ("in_xml", plainly, "script", "fmu"),
    ("in_comment", plainly, "comment of C", "fmu"),
    ("in_latex", plainly, "write18", "tex"),
    ("in_markdown", plainly, "link of Markdown", "md"),
    ("in_code", lambda text: f"'''{text}'''", "triple", "ipynb"),
    ("in_html", plainly, "attribute", "sliders"),
]
SEEN += [("in_julia_docstring", plainly, payload, "julia") for payload in ("docstring of Julia", "docstring", "shell")]
SEEN_TOO = [
    ("in_markdown", plainly, "image", "ipynb"),
    ("in_latex", plainly, "file of TeX", "tex"),
    ("in_latex", plainly, "pipe of TeX", "tex"),
    ("in_markdown", plainly, "image of Markdown", "ipynb"),
    ("in_markdown", plainly, "address of Markdown", "md"),
    ("in_markdown", plainly, "bare address", "md"),
    ("in_markdown", plainly, "mathematics of Markdown", "ipynb"),
    ("in_markdown", lambda text: text.replace("\\", "\\\\"), "mathematics of Markdown", "ipynb"),
    ("in_html", plainly, "script", "html"),
    ("in_html", plainly, "image", "html"),
    ("in_html", plainly, "title", "sliders"),
    ("in_html", plainly, "mathematics", "html"),
]
SEEN_HEAVY = [
    (
        "in_percent_comment",
        lambda text: "\n".join(f"% {line}" for line in text.split("\n")),
        "link of MATLAB",
        "matlab",
    ),
    ("in_rustdoc", plainly, "link of Markdown", "rust"),
]
EVERY = [pytest.param(*x, id=f"{x[0]}-{x[3]}-{x[2]}") for x in SEEN]
EVERY += [pytest.param(*x, id=f"{x[0]}-{x[3]}-{x[2]}", marks=pytest.mark.slow) for x in SEEN_TOO]

EVERY += [pytest.param(*x, id=f"{x[0]}-{x[3]}-{x[2]}", marks=pytest.mark.targets) for x in SEEN_HEAVY]


@pytest.mark.heavy("in_xml-fmu-script", "in_comment-fmu-comment of C", "in_code-ipynb-triple")
@pytest.mark.wide(2)
@pytest.mark.parametrize(("name", "instead", "payload", "door"), EVERY)
def test_a_harness_sees_what_one_escape_holds_back(
    name: str, instead: Any, payload: str, door: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    path = tmp_path / f"{hostile.NAME}.toml"
    alone = door in ("julia", "sliders")  # where units stand and descriptions do not
    if alone:
        request.getfixturevalue("units_are_not_checked")
    path.write_text(scene_with({payload: PAYLOADS[payload]}, units=alone), encoding="utf-8")
    browser = request.getfixturevalue("browser") if door in ("html", "sliders") else None

    with unescaped(name, instead):
        assert opened(write(door, path, tmp_path / "open"), browser) != []
    assert opened(write(door, path, tmp_path / "closed"), browser) == []


@pytest.mark.usefixtures("units_are_not_checked")
def test_a_page_is_seen_to_set_a_variable_to_open_a_dialog_and_to_ask_a_port(tmp_path: Path, browser: Any) -> None:
    path = tmp_path / f"{hostile.NAME}.toml"
    path.write_text(scene_with({name: PAYLOADS[name] for name in ("image", "alert")}, units=True), encoding="utf-8")

    with unescaped("in_html", plainly):
        seen = opened(write("sliders", path, tmp_path / "open"), browser)

    assert {f"l.html: {one}" for one in ("variable", "dialog canary", hostile.ADDRESS)} <= {*seen}


@pytest.mark.parametrize("door", ["svg", *(pytest.param(x, marks=pytest.mark.slow) for x in ("html", "film"))])
def test_names_that_were_not_checked_would_still_be_escaped(door: str, tmp_path: Path, browser: Any) -> None:
    name = "h<script>window.canary=1<|script>".replace("|", "/")
    path = tmp_path / f"{hostile.NAME}.toml"
    path.write_text(scene_with({}).replace("[joints.hinge]", f'[joints."{name}"]'), encoding="utf-8")

    with unescaped("check_name", lambda *_: None):
        assert [x for page in write(door, path, tmp_path / "closed") for x in in_browser(browser, page)] == []
        with unescaped("in_html", plainly):
            assert [x for page in write(door, path, tmp_path / "open") for x in in_browser(browser, page)] != []


# LaTeX of a symbol


@pytest.mark.parametrize(
    ("latex", "door"),
    [
        (r"l\immediate\write18{touch canary}", "tex"),
        (r"l\newwrite\x\immediate\openout\x=canary.txt", "tex"),
        (r"\href{javascript:window.canary=1}{l}", "html"),
        (r"\style{background:url(http://127.0.0.1:9/canary)}{l}", "ipynb"),
        pytest.param('l"""); open("canary", "w"); (r"""', "ipynb", marks=pytest.mark.slow),
    ],
)
def test_latex_that_acts_is_refused_and_a_harness_sees_it_where_it_is_not(
    latex: str, door: str, tmp_path: Path, request: pytest.FixtureRequest, capsys: pytest.CaptureFixture[str]
) -> None:
    from symdyn.cli import main

    path = tmp_path / f"{hostile.NAME}.toml"
    path.write_text(scene_with({}, latex), encoding="utf-8")

    assert main(["walkthrough", str(path), "-o", str(tmp_path / f"l.{door}")]) == 1
    assert "parameters.l: latex = " in capsys.readouterr().err
    assert not (tmp_path / f"l.{door}").exists()
    if "style" in latex or '"' in latex:  # nothing that we write makes these act, even unchecked
        return
    browser = request.getfixturevalue("browser") if door == "html" else None
    with unescaped("check_latex", lambda _: None):
        assert opened(write(door, path, tmp_path / "open"), browser) != []
