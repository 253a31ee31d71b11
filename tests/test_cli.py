"""The command line as a user meets it."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from patience import HANG

import symdyn
from symdyn.cli import main
from symdyn.emit import emit
from symdyn.program import formulate, lower
from symdyn.scene import bind, read

EXAMPLES = Path(__file__).parent.parent / "examples"

Capture = pytest.CaptureFixture[str]


@pytest.mark.long
def test_info_tells_the_tree_and_the_costs(capsys: Capture) -> None:
    assert main(["info", str(EXAMPLES / "puma560.toml")]) == 0
    out = capsys.readouterr().out

    assert "puma560: 6 degrees of freedom, gravity (0, 0, -9.81) m/s^2" in out
    assert "link6  (joint6: revolute, q6 in rad)" in out
    assert "inverse_dynamics" in out


def test_info_as_json_has_every_function(capsys: Capture) -> None:
    assert main(["info", str(EXAMPLES / "two_link.toml"), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["result"]

    assert facts["degrees_of_freedom"] == 2
    assert [p["name"] for p in facts["parameters"]] == ["m1", "m2", "h1", "h2", "g"]
    assert {"inverse_dynamics", "k_z", "k_C", "k_D", "k_G", "pose_tool"} <= {f["name"] for f in facts["functions"]}


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_the_command_in_a_header_makes_the_file_again(
    tmp_path: Path, target: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two_link.toml").write_text((EXAMPLES / "two_link.toml").read_text("utf-8"), "utf-8")
    scene = bind(read("two_link.toml"), {"m1": "2.5", "h1": "atan2(1, 2) + 1/3"})
    sources = emit(lower(formulate(scene, ("mass_matrix", "pose:tool"))), target)
    name, text = sources.files[0]
    again = next(line for line in text.splitlines() if "symdyn generate" in line)
    words = shlex.split(again[again.index("symdyn generate") :])

    assert main(words[1:]) == 0
    assert Path(name).read_text("utf-8") == text


def test_generate_prints_the_paths_of_what_it_wrote(tmp_path: Path, capsys: Capture) -> None:
    scene = str(EXAMPLES / "cart_pole.toml")

    assert (
        main(["generate", scene, "--target", "c", "--functions", "mass_matrix, mass_matrix", "-o", str(tmp_path)]) == 0
    )
    out = capsys.readouterr().out.split()
    assert out == [str(tmp_path / name) for name in ("cart_pole.c", "cart_pole.h", "main.c", "CMakeLists.txt")]
    assert "symdyn generate cart_pole.toml --target c --functions mass_matrix" in (tmp_path / "cart_pole.c").read_text()


@pytest.mark.parametrize(
    "words",
    [["equations"], ["linearize", "arm.toml", "--along"], ["check-derivation", "arm.tml"], ["info", "other/arm.tml"]],
    ids=" ".join,
)
def test_a_file_that_is_not_there_is_answered_by_the_one_beside_it(
    words: list[str], tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.toml").write_text((EXAMPLES / "pendulum.toml").read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "arm.csv").touch()
    last = {"linearize": ["am.csv"], "equations": ["arm.tml"], "check-derivation": ["arm.toml"]}.get(words[0], [])
    assert main([*words, *last]) != 0
    said = capsys.readouterr().err
    meant = "arm.csv" if words[0] == "linearize" else "arm.toml"
    assert (f"did you mean {meant}?" in said) == (words[0] != "info"), said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["info", "nowhere.toml"], "nowhere.toml: there is no such file"),
        (["info", "examples/cart_pole.toml"], "there is no such file; symdyn new --example cart_pole writes the scene"),
        (["generate", "{two_link}", "--functions", "mass"], "there is no output 'mass'"),
        (["generate", "{two_link}", "--functions", "pose"], "pose needs a point; write pose:NAME"),
        (["generate", "{two_link}", "--functions", "pose:hand"], "there is no body or point 'hand'"),
        (["generate", "{two_link}", "--functions", "k_z:tool"], "k_z is about the whole scene"),
        (["generate", "{two_link}", "--functions", ","], "there is no function to write; name one"),
        (["verify", "{two_link}", "--functions", "com_acceleration:tool"], "there is no body 'tool'"),
        (["generate", "{two_link}", "-o", "{file}"], "cannot write"),
        (["new", "arm", "--template", "rx"], 'there is no template "rx"'),
        (["new", "chain", "--n", "0"], "n = 0 is out of range"),
    ],
)
def test_a_users_mistake_is_one_message_and_exit_1(
    arguments: list[str], words: str, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("in the way")
    places = {"two_link": str(EXAMPLES / "two_link.toml"), "file": "file"}

    assert main([word.format(**places) for word in arguments]) == 1
    streams = capsys.readouterr()
    assert streams.out == ""
    assert streams.err.startswith("symdyn: ")
    assert words in streams.err
    assert "Traceback" not in streams.err


@pytest.mark.parametrize("arguments", [[], ["derive"], ["info"], ["generate", "x.toml", "--target", "fortran"]])
def test_wrong_usage_is_exit_2(arguments: list[str], capsys: Capture) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(arguments)

    said, see = capsys.readouterr().err.splitlines()
    assert said.startswith("symdyn")
    assert re.fullmatch(r"see: symdyn.* --help", see)


def test_new_writes_a_scene_that_generates_and_never_overwrites(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    assert main(["new", "chain", "--n", "3"]) == 0
    assert main(["generate", "chain.toml"]) == 0
    assert (tmp_path / "chain.py").exists()
    assert main(["new", "chain", "--n", "3"]) == 1
    assert "chain.toml exists" in capsys.readouterr().err
    assert main(["new", "chain", "--n", "4", "--force"]) == 0


def test_new_writes_an_example_under_its_own_name_or_another(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    assert main(["new", "--example", "four-bar"]) == 0
    assert (tmp_path / "four_bar.toml").read_bytes() == (EXAMPLES / "four_bar.toml").read_bytes()
    assert main(["new", "mine.toml", "--example", "four_bar"]) == 0  # with the ending, or without
    assert read(tmp_path / "mine.toml") == replace(symdyn.example("four_bar"), name="mine")
    assert main(["new", "person", "--example", "humanoid"]) == 0
    assert symdyn.read("person.urdf").name == "person"
    assert main(["new", "--example", "fourbar"]) == 1
    assert 'there is no example "fourbar"; did you mean four_bar?' in capsys.readouterr().err
    assert main(["new"]) == 1
    assert "symdyn new --example four_bar" in capsys.readouterr().err


@pytest.mark.runs
def test_verify_reports_the_certificate_as_json(capsys: Capture) -> None:
    assert main(["verify", str(EXAMPLES / "pendulum.toml"), "--json"]) == 0
    certificate = json.loads(capsys.readouterr().out)["result"]

    assert certificate["passed"] is True
    assert len(certificate["fields"]["primes"]) == 2
    assert {f["verdict"] for f in certificate["findings"]} == {"proved", "agrees in numbers"}


@pytest.mark.usefixtures("numpy_alone")
def test_verify_for_people_ends_with_the_verdict(capsys: Capture) -> None:
    assert main(["verify", str(EXAMPLES / "cart_pole.toml"), "--functions", "mass_matrix"]) == 0
    out = capsys.readouterr().out

    assert "mass_matrix: crba = lagrange" in out
    assert out.rstrip().endswith("cart_pole: passed")


@pytest.mark.runs
def test_the_module_runs_as_a_command_and_survives_a_closed_pipe() -> None:
    command = f"({sys.executable} -m symdyn info {EXAMPLES / 'puma560.toml'}; echo $? >&2) | head -n 1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False, env=os.environ)

    assert done.stdout == "puma560: 6 degrees of freedom, gravity (0, 0, -9.81) m/s^2\n"
    assert done.stderr == "0\n"


def test_an_interrupted_run_leaves_one_line(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("symdyn.cli.scene_options.read_noting", interrupt)

    assert main(["info", "x.toml"]) == 130
    assert capsys.readouterr().err == "symdyn: interrupted\n"


@pytest.mark.usefixtures("numpy_alone")
def test_a_body_called_b_is_no_emoji(tmp_path: Path, capsys: Capture) -> None:
    scene = tmp_path / "one.toml"
    scene.write_text(
        '[bodies.b]\nmass = 1\ncom = [1, 0, 0]\n[joints.j]\ntype = "revolute"\nparent = "ground"\nchild = "b"\n'
    )

    assert main(["verify", str(scene)]) == 0
    assert "jacobian:b: recursive = differentiation" in capsys.readouterr().out


def test_an_unbalanced_quote_in_cc_is_one_message(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setenv("CC", '"gcc')

    assert main(["verify", str(EXAMPLES / "pendulum.toml"), "--functions", "mass_matrix"]) == 1
    assert "is no command line" in capsys.readouterr().out


def test_a_name_with_hyphens_names_a_template_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)

    assert main(["new", "n-four-bar", "--n", "40"]) == 0

    assert capsys.readouterr().out == "n_four_bar.toml\n"
    assert len(read(tmp_path / "n_four_bar.toml").loops) == 40


def test_the_joints_to_cut_are_chosen_on_the_command_line(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "ring.toml"
    bodies = "".join(f"[bodies.{name}]\nmass = 1\n" for name in "ab")
    joints = "".join(
        f'[joints.j{k}]\ntype = "revolute"\nparent = "{parent}"\nchild = "{child}"\norigin = [{k}, 0, 0]\n'
        for k, (parent, child) in enumerate((("ground", "a"), ("a", "b"), ("ground", "b")))
    )
    path.write_text(bodies + joints)

    assert main(["convert", str(path), str(tmp_path / "chosen.toml"), "--spanning-tree", "j0"]) == 0

    assert [loop.name for loop in read(tmp_path / "chosen.toml").loops] == ["j0"]
    assert "joints.j1: is turned round" in capsys.readouterr().err


@pytest.mark.runs
@pytest.mark.parametrize(
    "words",
    [
        ["equations", "pendulum.toml"],
        ["equations", "pendulum.toml", "--as", "base-parameters"],
        ["new", "four_bar"],
        ["convert", "pendulum.toml", "again.toml"],
        ["info", "pendulum.toml"],
    ],
    ids=" ".join,
)
def test_what_computes_with_no_arrays_starts_without_numpy(words: list[str], tmp_path: Path) -> None:
    (tmp_path / "pendulum.toml").write_text((EXAMPLES / "pendulum.toml").read_text(encoding="utf-8"), encoding="utf-8")
    script = "import sys; from symdyn.cli import main; main(sys.argv[1:]); print('numpy' in sys.modules)"
    command = [sys.executable, "-c", script, *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path, timeout=HANG)

    assert done.stdout.splitlines()[-1] == "False"


ROADS = """
import sys
sys.modules["numpy"] = sys.modules["scipy"] = None  # an import of it fails
import symdyn
from symdyn.dynamics import derive
from symdyn.emit import TARGETS, emit
from symdyn.playground import answer
from symdyn.program import lower
for path in sys.argv[1:]:
    scene = symdyn.read(path)
    equations = symdyn.equations(scene)
    assert equations.latex() and equations.text()
    program = lower(derive(scene))
    for target, row in TARGETS.items():
        assert row.functions or emit(program, target).texts
    text = open(path, encoding="utf-8").read()
    for what in ("scene", "equations", "coefficients", "code"):
        told = answer(what, text, {"target": "js"})
        assert not {"faults", "refused", "failed"} & set(told), told
"""


@pytest.mark.runs
def test_reading_equations_of_trees_code_and_their_page_take_no_numpy() -> None:
    scenes = [str(EXAMPLES / f"{name}.toml") for name in ("two_link", "cart_pole")]
    command = [sys.executable, "-c", ROADS, *scenes]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=HANG)

    assert done.stderr == ""


def test_lists_are_split_by_one_reader() -> None:
    verbs = sorted((Path(symdyn.__file__).parent / "cli").glob("*.py"))
    assert [path.name for path in verbs if re.search(r"split\(\s*[\"'],", path.read_text(encoding="utf-8"))] == []
