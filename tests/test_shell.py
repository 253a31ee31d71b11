"""Manners of the command line that all verbs share: one shape of JSON, silence, notes, options written out."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path

import pytest

import symdyn
from symdyn.cli import VERBS, main

EXAMPLES = Path(__file__).parent.parent / "examples"
PENDULUM = str(EXAMPLES / "pendulum.toml")
TWO_LINK = str(EXAMPLES / "two_link.toml")

Capture = pytest.CaptureFixture[str]

KEYS = ["verb", "scene", "status", "result", "files", "notes", "errors", "places"]

STUDENT = "k_{z,22} = m_2 h_2^2\nk_{z,12} = m_2 h_1"

LINES = {  # what a verb is asked, its exit status, what its result must hold
    "equations": (["equations", TWO_LINK, "--format", "text"], 0, lambda told: "cos(q2)" in told),
    "walkthrough": (["walkthrough", TWO_LINK, "-o", "lesson.md", "--until", "energies"], 0, lambda told: told is None),
    "check-derivation": (["check-derivation", "own.tex", TWO_LINK], 1, lambda told: not told[1]["right"]),
    "generate": (["generate", TWO_LINK, "--functions", "mass_matrix"], 0, lambda told: told is None),
    "verify": (["verify", PENDULUM, "--functions", "mass_matrix"], 0, lambda told: told["passed"]),
    "simulate": (
        ["simulate", PENDULUM, "--until", "0.1", "--every", "0.05", "--method", "dop853"],
        0,
        lambda told: told["columns"]["t"] == [0, 0.05, 0.1] and told["method"] == "dop853",
    ),
    "inverse": (
        ["inverse", PENDULUM, "--motion", "q1=t", "--until", "0.1", "--every", "0.05"],
        0,
        lambda told: told["columns"]["q1"] == [0, 0.05, 0.1],
    ),
    "sweep": (
        ["sweep", PENDULUM, "--over", "q1=[0.1,0.2]", "--measure", "max(abs(q1))", "--until", "0.1"],
        0,
        lambda told: told["runs"] == 2 and told["columns"]["q1"] == [0.1, 0.2],
    ),
    "identify": (
        ["identify", PENDULUM, "--excite", "--starts", "1", "--terms", "2", "--period", "2", "--every", "0.1"],
        0,
        lambda told: 1 <= told["condition"] < 10,
    ),
    "calibrate": (
        ["calibrate", PENDULUM, str(EXAMPLES.parent / "tests" / "data" / "poses.csv")],
        0,
        lambda told: abs(told["parameters"][0]["after"] - 0.51) < 1e-6,
    ),
    "gait": (["gait", PENDULUM, "--period", "1"], 0, lambda told: told["period"] == 1.0 and told["stable"]),
    "linearize": (["linearize", PENDULUM], 0, lambda told: told["kind"] == "rest"),
    "bench": (
        ["bench", PENDULUM, "--quick", "--functions", "mass_matrix", "--no-trajectories"],
        0,
        lambda told: told["measured"],
    ),
    "stress": (["stress", PENDULUM, "--families", "angles"], 0, lambda told: told["cases"]),
    "info": (["info", TWO_LINK], 0, lambda told: told["degrees_of_freedom"] == 2),
    "draw": (["draw", TWO_LINK], 0, lambda told: told.startswith("<svg")),
    "convert": (["convert", PENDULUM, "out.toml"], 0, lambda told: told == {"format": "toml", "lost": []}),
    "new": (["new", "arm"], 0, lambda told: told is None),
    "completion": (["completion", "fish"], 0, lambda told: "complete -c symdyn" in told),
    "doctor": (["doctor"], 0, lambda told: told["python"]),
}


def test_every_verb_is_asked() -> None:
    assert set(LINES) == set(VERBS) - {"play"}  # a page is no JSON


@pytest.mark.heavy("bench")
@pytest.mark.runs("cc")
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("verb", LINES)
def test_json_has_one_shape(verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.tex").write_text(STUDENT)
    words, status, holds = LINES[verb]

    assert main([*words, "--json", "--quiet"]) == status
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert list(told) == KEYS
    assert (told["verb"], told["status"], told["errors"], err) == (verb, status, [], "")
    assert holds(told["result"])
    assert all((tmp_path / name).is_file() for name in told["files"])
    assert told["files"] or told["result"] is not None


def test_json_tells_errors_too(capsys: Capture) -> None:
    assert main(["info", "nowhere/nothing.toml", "--json"]) == 1
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert (told["scene"], told["status"], told["result"]) == ("nothing.toml", 1, None)
    assert told["errors"] == [line.removeprefix("symdyn: ") for line in err.splitlines()]


def test_json_has_no_number_that_is_none(capsys: Capture) -> None:
    from symdyn.rounding import finite

    assert finite({"a": [float("nan"), 1.5, (float("inf"), "x")]}) == {"a": [None, 1.5, [None, "x"]]}


def test_a_file_that_is_not_there_is_told_with_those_beside_it(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "m1.toml").write_text(LOOP)
    (tmp_path / "notes.md").write_text("")
    assert main(["info", str(tmp_path / "m2.toml")]) == 1
    assert f"did you mean {tmp_path / 'm1.toml'}?" in capsys.readouterr().err
    assert main(["info", str(tmp_path / "crane.toml")]) == 1
    assert capsys.readouterr().err.endswith("; there is m1.toml\n")
    (tmp_path / "m1.toml").unlink()
    assert main(["info", str(tmp_path / "m2.toml")]) == 1
    assert "there is no such file; check the path, or begin a scene with symdyn new\n" in capsys.readouterr().err


@pytest.mark.parametrize("quiet", ["-q", "--quiet"])
def test_quiet_leaves_results_and_errors(quiet: str, tmp_path: Path, capsys: Capture) -> None:
    scene = tmp_path / "loop.toml"
    scene.write_text(LOOP.replace("3]", "2]"))
    words = ["generate", str(scene), "-o", str(tmp_path)]
    assert main(words) == 0
    assert "poses and Jacobians are asked for by name" in capsys.readouterr().err
    assert main([*words, quiet]) == 0
    assert capsys.readouterr() == (f"{tmp_path / 'loop.py'}\n", "")
    assert main(["info", "nothing.toml", quiet]) == 1
    assert "there is no such file" in capsys.readouterr().err


@pytest.mark.runs("cc")
def test_quiet_tells_why_a_motion_ended_early(capsys: Capture) -> None:
    words = ["simulate", PENDULUM, "--until", "1", "--forces", "tau1=1/(0.5-t)**2", "--method", "dop853", "--quiet"]
    assert main(words) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "t = 0." in line
    assert main([*words, "--json"]) == 1
    assert len(json.loads(capsys.readouterr().out)["errors"]) == 1


LOOP = """
[bodies.a]
mass = 1
inertia = [1, 1, 3]
inertia_about = "com"
[joints.j]
type = "revolute"
parent = "ground"
child = "a"
"""


@pytest.mark.parametrize("spelled", ["{folder}/loop.toml", "{folder}//./loop.toml", "loop.toml", "./loop.toml"])
def test_a_note_is_one_line_once_with_the_name_of_the_file(
    spelled: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop.toml").write_text(LOOP)

    assert main(["info", spelled.format(folder=tmp_path), "--allow-invalid-inertia"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("symdyn: loop.toml: bodies.a: inertia")


def test_behind_two_dashes_a_word_is_no_option(capsys: Capture) -> None:
    assert main(["info", "--quiet", "--", "--bind.toml"]) == 1
    assert capsys.readouterr().err.startswith("symdyn: --bind.toml: there is no such file")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (
            ["linearize", PENDULUM, "--force", "tau1=1"],
            "--force is no option; did you mean --forces?",
        ),
        (["simulate", PENDULUM, "--unti", "1"], "--unti is no option; did you mean --until?"),
        (["simulate", PENDULUM, "--star=1", "--until", "1"], "did you mean --start or --start-rates?"),
        (["info", PENDULUM, "--bynd", "m=1"], "--bynd is no option; did you mean --bind?"),
        (["info", PENDULUM, "-x"], "-x is no option"),
        (["simulate", PENDULUM, "--tend", "1"], "--tend is no option; did you mean --until?"),
        (["simulat", PENDULUM], "there is no verb 'simulat'; did you mean simulate? (there are equations, "),
        (["plot", PENDULUM], "there is no verb 'plot'; simulate, inverse and sweep write one, --plot FILE"),
        (["generate", PENDULUM, "--target", "python"], "--target: target 'python' is not known; did you mean numpy?"),
        (["equations", PENDULUM, "--as", "textbok"], "--as: there is no 'textbok'; did you mean textbook? (there are "),
    ],
)
def test_an_option_that_is_none_is_told_what_was_meant(words: list[str], told: str, capsys: Capture) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(words)
    said, see = capsys.readouterr().err.splitlines()  # and no more
    assert told in said
    assert see.endswith(" --help")


def test_an_output_and_a_type_are_told_by_what_others_call_them(tmp_path: Path, capsys: Capture) -> None:
    """`massmatrix` was answered by sixty names, `hinge` by thirteen."""
    hinged = tmp_path / "hinged.toml"
    hinged.write_text(Path(PENDULUM).read_text().replace('type = "revolute"', 'type = "hinge"'))
    assert main(["info", str(hinged)]) == 1
    assert main(["generate", PENDULUM, "--functions", "massmatrix", "-o", str(tmp_path)]) == 1

    joint, output = capsys.readouterr().err.splitlines()
    assert 'type = "hinge" is not a joint; did you mean revolute? (there are ' in joint
    assert output == "symdyn: there is no output 'massmatrix'; did you mean mass_matrix?"


def test_python_is_told_arguments_and_the_shell_options(capsys: Capture) -> None:
    """Errors of Python spoke of `--bind`."""
    with pytest.raises(
        symdyn.SymdynError, match=r'give them, as in values=\{"m1": 1, "m2": 1, "h1": 1, "h2": 1, "g": 1\}$'
    ):
        symdyn.simulate(TWO_LINK, until=1)
    assert main(["simulate", TWO_LINK, "--until", "1"]) == 1
    assert "give them, as in --bind m1=1,m2=1,h1=1,h2=1,g=1\n" in capsys.readouterr().err
    with pytest.raises(TypeError, match=r"unexpected keyword argument 't_end'; did you mean until\?"):
        symdyn.simulate(TWO_LINK, t_end=1)  # type: ignore[call-arg]
    with pytest.raises(AttributeError, match=r"symdyn has no 'derive'; it is symdyn\.dynamics\.derive"):
        symdyn.derive  # noqa: B018


URDF = """<robot name="rod"><link name="a"/><link name="b"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1"
ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
</robot>"""

SCENE_FIRST = {verb: words for verb, (words, _, _) in LINES.items() if {PENDULUM, TWO_LINK} & {*words}}


def piped(path: str) -> io.TextIOWrapper:
    return io.TextIOWrapper(io.BytesIO(Path(path).read_bytes()), encoding="ascii")


@pytest.mark.runs("cc")
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("verb", [verb for verb in SCENE_FIRST if verb not in ("bench", "verify")])
def test_a_scene_comes_from_stdin_as_from_its_file(
    verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.tex").write_text(STUDENT)
    words, status, holds = LINES[verb]
    scene = next(word for word in words if word in (PENDULUM, TWO_LINK))
    monkeypatch.setattr(sys, "stdin", piped(scene))

    assert main(["-" if word == scene else word for word in words] + ["--json", "--quiet"]) == status
    told = json.loads(capsys.readouterr().out)
    assert told["scene"] == "-"
    assert holds(told["result"])


def test_a_robot_comes_from_stdin_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    path = tmp_path / "rod.urdf"
    path.write_text(URDF)
    assert main(["info", str(path), "--quiet"]) == 0
    wanted = capsys.readouterr().out
    monkeypatch.setattr(sys, "stdin", piped(str(path)))
    assert main(["info", "-", "--quiet"]) == 0
    assert capsys.readouterr().out == wanted


@pytest.mark.parametrize(
    ("content", "words", "told"),
    [
        (b"", ["info", "-"], "symdyn: stdin: is empty; pipe a scene in"),
        (b"\xff\xfe", ["info", "-"], "symdyn: stdin:1: byte 0 is not UTF-8"),
        (b"bodies = 1", ["info", "-"], "symdyn: stdin:1: bodies"),
        (b"x = 1", ["check-derivation", "-", "-"], "FILE and SCENE are both -"),
    ],
)
def test_what_is_no_scene_on_stdin_is_told(
    content: bytes, words: list[str], told: str, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))
    assert main(words) > 0
    assert told in capsys.readouterr().err


ODD = """
[parameters]
g = 9.80665
[bodies.rod]
mass = 1.23456789012345
com = [0.333333333333, 0, 0]
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[joints.swing]
coordinate = "phi"
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 1, 0]
limits = { lower = -1.23456789012345, upper = 2 }
"""

DIGITS = {  # a command line, and how a number of it is shown as usual, with three digits, with all
    "equations {scene}": ("- 4.03704 ", "- 4.04 ", "- 4.0370370006996445 "),
    "equations {scene} --format text": ("- 4.03703700069964*", "- 4.04*", "- 4.0370370006996445*"),
    "equations {scene} --formulation dalembert": (" 4.03704 ", " 4.04 ", " 4.0370370006996445 "),
    "equations {scene} --as base-parameters": ("= 0.411523", "= 0.412", "= 0.41152263004073848"),
    "info {scene}": ("from ≈ -1.23457 to 2", "from ≈ -1.23 to 2", "from -1.23456789012345 to 2"),
    "linearize {scene} --start phi=pi/2": ("phi_dot  -17.0214 ", "phi_dot  -17 ", "phi_dot  -17.02139958839048 "),
    "verify {scene} --functions mass_matrix --rigorous --at phi=0.3": ("", "", ""),
}


@pytest.mark.runs("cc")
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("line", DIGITS)
def test_digits_are_as_many_as_are_asked_for(line: str, tmp_path: Path, capsys: Capture) -> None:
    scene = tmp_path / "odd.toml"
    scene.write_text(ODD)
    wanted = DIGITS[line]
    for more, number in zip(([], ["--digits", "3"], ["--digits", "all"]), wanted, strict=True):
        assert main([*line.format(scene=scene).split(), *more]) == 0
        assert number in capsys.readouterr().out


@pytest.mark.parametrize("digits", ["0", "18", "-1", "x", "6.5", "٣", "0123", "9" * 5000])
def test_what_is_no_number_of_digits_is_told(digits: str, capsys: Capture) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["info", PENDULUM, f"--digits={digits}"])
    assert "give 1 to 17, or all" in capsys.readouterr().err


def test_machines_get_all_digits_whatever_is_asked(tmp_path: Path, capsys: Capture) -> None:
    scene = tmp_path / "odd.toml"
    scene.write_text(ODD)
    assert main(["info", str(scene), "--digits", "2", "--json"]) == 0
    assert '"-1.23456789012345"' in capsys.readouterr().out


def test_lessons_have_as_many_digits_as_are_asked_for(tmp_path: Path, capsys: Capture) -> None:
    scene = tmp_path / "odd.toml"
    scene.write_text(ODD)
    for more, number in zip(([], ["--digits", "9"]), ("0.237174 ", "0.23717421 "), strict=True):
        assert main(["walkthrough", str(scene), "-o", str(tmp_path / "lesson.md"), *more]) == 0
        assert number in (tmp_path / "lesson.md").read_text()
