"""Files found on disk are proved to be a scene's equations, however long ago they were made; nothing of them is run."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from symdyn.cli import main

EXAMPLES = Path(__file__).parent.parent / "examples"
TWO_LINK = str(EXAMPLES / "two_link.toml")

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def folder(tmp_path: Path, capsys: Capture) -> Path:
    """Return a folder with C files for many states, and a C++ header with a value bound."""
    functions = ["--functions", "inverse_dynamics,mass_matrix"]
    assert main(["generate", TWO_LINK, "--target", "c", "--batch", *functions, "-o", str(tmp_path)]) == 0
    assert main(["generate", TWO_LINK, "--target", "cpp", "--bind", "g=9.81", "--prepare", "-o", str(tmp_path)]) == 0
    capsys.readouterr()
    return tmp_path


def certificate(folder: Path, capsys: Capture, scene: str = TWO_LINK) -> dict[str, object]:
    status = main(["verify", scene, "--files", str(folder), "--json"])
    found: dict[str, object] = json.loads(capsys.readouterr().out)["result"]
    assert found["passed"] is (status == 0)
    return found


def written(found: dict[str, object]) -> dict[str, dict[str, str]]:
    files = found["written"]
    assert isinstance(files, list)
    return {one["file"]: one for one in files}


def test_files_are_proved_by_what_their_headers_say(folder: Path, capsys: Capture) -> None:
    found = certificate(folder, capsys)
    files = written(found)

    assert found["passed"]
    assert files["two_link.c"]["verdict"] == "proved"
    assert files["two_link.c"]["option"] == "batch"
    assert files["two_link.h"]["verdict"] == "proved"
    assert "raw::prepare" in files["two_link.hpp"]["functions"]
    assert "CMakeLists.txt, main.c" in str(found["notes"])


@pytest.mark.long(0)
def test_the_certificate_names_the_very_bytes(folder: Path, capsys: Capture) -> None:
    before = written(certificate(folder, capsys))["two_link.c"]["sha256"]
    path = folder / "two_link.c"
    path.write_bytes(path.read_bytes().replace(b"Do not edit", b"Do edit"))
    after = written(certificate(folder, capsys))["two_link.c"]

    assert after["verdict"] == "proved"
    assert after["sha256"] != before


@pytest.mark.long(0)
@pytest.mark.wide(2)
@pytest.mark.parametrize(
    ("file", "old", "new", "told"),
    [
        ("two_link.c", "s1 = sin(q_1)", "s1 = cos(q_1)", "two_link_inverse_dynamics, entry 0, line "),
        ("two_link.hpp", "* c2", "* s2", "entry 0"),
        ("two_link.c", "k += states;", "k += states + 1;", "fixed text"),
        ("two_link.h", "double *out);", "float *out);", "fixed text"),
        ("two_link.c", "#include <math.h>", "#include <math.h>\n#define sin(x) system(x)", "fixed text: '#define sin"),
    ],
)
def test_an_edited_file_is_found(folder: Path, capsys: Capture, file: str, old: str, new: str, told: str) -> None:
    path = folder / file
    text = path.read_text(encoding="utf-8")
    there = text.index(old, text.index("#include"))
    path.write_text(text[:there] + new + text[there + len(old) :], encoding="utf-8")
    found = certificate(folder, capsys)

    assert not found["passed"]
    assert told in written(found)[file]["where"]


def test_a_file_that_was_taken_away_is_missed(folder: Path, capsys: Capture) -> None:
    (folder / "two_link.h").unlink()

    found = certificate(folder, capsys)
    header = written(found)["two_link.h"]

    assert (header["verdict"], header["where"]) == ("not shown", "there is no such file")
    assert not found["passed"]


@pytest.mark.long(0)
def test_a_scene_that_has_changed_is_told(folder: Path, capsys: Capture, tmp_path: Path) -> None:
    changed = tmp_path / "elsewhere" / "two_link.toml"
    changed.parent.mkdir()
    text = Path(TWO_LINK).read_text(encoding="utf-8")
    changed.write_text(text.replace('at = [0, "-h2", 0] }]', 'at = [0, "-h1", 0] }]'), encoding="utf-8")
    found = certificate(folder, capsys, str(changed))
    assert not found["passed"]
    assert written(found)["two_link.c"]["verdict"] == "fails"

    other = certificate(folder, capsys, str(EXAMPLES / "double_pendulum.toml"))

    assert not other["passed"]
    assert "another scene's: two_link.c" in str(other["notes"])


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("symdyn generate x.toml --target c --output /etc", "its command says --output"),
        ("symdyn generate x.toml --target c --help", "its command says --help"),
        ("symdyn generate x.toml --target fortran", "none of this version"),
        ("symdyn generate x.toml --target c --rm -rf", "none of this version"),
        ("symdyn generate x.toml 'unfinished", "is no line of a shell"),
        ("symdyn generate x.toml --target fmu", "are not read back"),
    ],
)
def test_a_header_is_data_and_what_is_strange_is_refused(
    tmp_path: Path, capsys: Capture, command: str, told: str
) -> None:
    (tmp_path / "x.c").write_text(f"/*\n *     {command}\n */\n", encoding="utf-8")

    assert main(["verify", TWO_LINK, "--files", str(tmp_path)]) == 1
    assert told in capsys.readouterr().err


@pytest.mark.long(0)
@pytest.mark.wide("math.h", "numpy.py")
@pytest.mark.parametrize("name", ["math.h", "include/math.h", "cmath", "numpy.py", "numpy/__init__.py"])
def test_a_file_that_hides_what_ours_ask_for_is_found(folder: Path, capsys: Capture, name: str) -> None:
    assert main(["generate", TWO_LINK, "--functions", "mass_matrix", "-o", str(folder)]) == 0
    capsys.readouterr()
    assert certificate(folder, capsys)["passed"]
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_text("", encoding="utf-8")
    found = certificate(folder, capsys)

    assert not found["passed"]
    assert "would be given this file" in written(found)[name]["where"]


def test_a_private_function_that_hides_one_of_matlab_is_found(tmp_path: Path, capsys: Capture) -> None:
    assert main(["generate", TWO_LINK, "--target", "matlab", "--functions", "mass_matrix", "-o", str(tmp_path)]) == 0
    capsys.readouterr()
    private = tmp_path / "+two_link" / "private"
    private.mkdir()
    (private / "q.m").write_text("function q\nend\n", encoding="utf-8")
    assert certificate(tmp_path, capsys)["passed"]
    (private / "cos.m").write_text("function y = cos(x)\ny = x;\nend\n", encoding="utf-8")
    found = certificate(tmp_path, capsys)

    assert "would be given this file" in written(found)["+two_link/private/cos.m"]["where"]
    assert not found["passed"]


@pytest.mark.mends("30.class.verdicts")
@pytest.mark.parametrize(("target", "file"), [("json", "two_link.json"), ("ufunc", "two_link_f32.c")])
def test_files_that_are_not_read_back_are_not_shown_and_leave_the_others_in_peace(
    target: str, file: str, tmp_path: Path, capsys: Capture
) -> None:
    asked = ["generate", TWO_LINK, "--functions", "mass_matrix", "-o", str(tmp_path)]
    assert main([*asked, "--target", target]) == 0
    assert main(["verify", TWO_LINK, "--files", str(tmp_path)]) == 1
    assert f"{file}: files of target {target} (" in capsys.readouterr().err

    assert main([*asked, "--target", "numpy"]) == 0
    capsys.readouterr()
    found = certificate(tmp_path, capsys)
    assert not found["passed"]
    assert {name: one["verdict"] for name, one in written(found).items()} == {"two_link.py": "proved"}
    (left,) = found["not_shown"]
    assert file in left["what"]
    assert left["why"].startswith(f"files of target {target} (")
    assert "give a folder of files for numpy or " in left["why"]
    assert left["why"].endswith(f"or verify the scene with --targets {target}, which measures it")


@pytest.mark.parametrize("line", ["\n", " ", "*\n", "symdyn generate ", "symdyn generate" + " " * 9999 + "x\n"])
def test_a_header_of_a_million_letters_is_soon_looked_through(tmp_path: Path, capsys: Capture, line: str) -> None:
    (tmp_path / "x.c").write_text(line * (1_000_000 // len(line)) + "é", encoding="utf-8")

    assert main(["verify", TWO_LINK, "--files", str(tmp_path)]) == 1
    assert "no file there says which command made it" in capsys.readouterr().err


def test_names_of_files_do_nothing_to_a_terminal(folder: Path, capsys: Capture) -> None:
    (folder / "a\x1b[31m\nb.txt").write_text("", encoding="utf-8")
    assert main(["verify", TWO_LINK, "--files", str(folder)]) == 0

    assert not {"\x1b", "\nb.txt"} & {*capsys.readouterr().out.replace("\nb.txt", "\x1b")}


def test_a_folder_without_files_of_ours_is_told(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "x.c").write_text("int main(void) { return 0; }\n", encoding="utf-8")

    assert main(["verify", TWO_LINK, "--files", str(tmp_path)]) == 1
    assert "no file there says which command made it" in capsys.readouterr().err
    assert main(["verify", TWO_LINK, "--files", str(tmp_path / "x.c")]) == 1
    assert "is no folder" in capsys.readouterr().err


def test_files_need_their_scene_and_nothing_else(folder: Path, capsys: Capture) -> None:
    with pytest.raises(SystemExit):
        main(["verify", "--files", str(folder)])
    assert "required: SCENE" in capsys.readouterr().err
    assert main(["verify", TWO_LINK, "--files", str(folder), "--prepare"]) == 1
    assert "leave --prepare out" in capsys.readouterr().err
