"""What stands beside generated C: an example whose numbers must come out, and CMake's file, as C and as C++."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from arms import chain
from formulas import every_op

from symdyn.cli import main
from symdyn.dynamics import derive
from symdyn.emit import beside, emit, write
from symdyn.emit.code import worked_example
from symdyn.errors import BuildError
from symdyn.program import Program, formulate, lower, prepare
from symdyn.runtime import build

pytestmark = [pytest.mark.long(0), pytest.mark.runs("gcc", "g++")]

EXAMPLES = Path(__file__).parent.parent / "examples"
TWO_LINK = str(EXAMPLES / "two_link.toml")

STRICT = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror"]
LANGUAGES = {"C": ["gcc", "-std=c99"], "CXX": ["g++", "-std=c++11", "-Drestrict=__restrict", "-x", "c++"]}

Capture = pytest.CaptureFixture[str]


def generated(folder: Path, *words: str, scene: str = TWO_LINK) -> Path:
    assert main(["generate", scene, "--target", "c", *words, "-o", str(folder), "--quiet"]) == 0
    return folder


def by_cmake(folder: Path, language: str, name: str) -> None:
    """Configure, build without a warning, and run by CTest."""
    flags = " ".join(STRICT)
    asked = [f"-DSYMDYN_LANGUAGE={language}", f"-DCMAKE_{language}_FLAGS={flags}"]
    for words in (["-S", ".", "-B", "out", *asked], ["--build", "out"]):
        ran = subprocess.run(["cmake", *words], cwd=folder, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stdout + ran.stderr
        assert "warning" not in (ran.stdout + ran.stderr).lower()
    ran = subprocess.run(["ctest", "--test-dir", "out"], cwd=folder, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout
    assert "100% tests passed, 0 tests failed out of 1" in ran.stdout
    assert (folder / "out" / f"symdyn_{name}_example").is_file()


def by_hand(folder: Path, language: str, files: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Compile without a warning and run; the example links the library's C, whatever it is itself."""
    words = [*LANGUAGES[language], "-O0", *STRICT, "-Wno-unknown-pragmas", *files, "-o", "example", "-lm"]
    built = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert (built.returncode, built.stderr) == (0, "")
    return subprocess.run(["./example"], cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.wide("plain-C", "--header-only-CXX")
@pytest.mark.runs("cmake")
@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("option", ["plain", "--header-only"])
def test_cmake_builds_and_runs_the_example(option: str, language: str, tmp_path: Path) -> None:
    folder = generated(tmp_path, *([] if option == "plain" else [option]))
    assert (folder / "two_link.c").is_file() == (option == "plain")
    by_cmake(folder, language, "two_link")


@pytest.mark.slow
@pytest.mark.runs("cmake")
@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("words", ["--batch", "--header-only", "--prepare", "--real float", "--static"])
@pytest.mark.parametrize("scene", sorted(path.stem for path in EXAMPLES.glob("*.toml")))
def test_cmake_builds_every_example_every_way(scene: str, words: str, language: str, tmp_path: Path) -> None:
    generated(tmp_path, *words.split(), scene=str(EXAMPLES / f"{scene}.toml"))
    by_cmake(tmp_path, language, scene)


@pytest.mark.wide(3)
@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("words", ["--batch", "--prepare", "--real float", "--static", "--prepare --real float"])
def test_the_numbers_come_out_in_every_way(words: str, language: str, tmp_path: Path) -> None:
    functions = "inverse_dynamics,forward_dynamics,mass_matrix,pose:tool"
    generated(tmp_path, *words.split(), "--functions", functions)
    ran = by_hand(tmp_path, language, ["two_link.c", "main.c"])
    assert ran.returncode == 0, ran.stdout
    assert ran.stdout.count(" right ") == 4 + ("--prepare" in words)


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_operation_comes_out(language: str, tmp_path: Path) -> None:
    sources = emit(lower(every_op()), "c")
    write({**sources, **beside(sources)}, tmp_path)
    ran = by_hand(tmp_path, language, ["every_op.c", "main.c"])
    assert ran.returncode == 0, ran.stdout


@pytest.mark.parametrize(
    ("pattern", "other"), [(r"(out\[1\] = )", r"\1-"), (r"\bcos\(", "sin("), (r"(out\[0\] = )", r"\1NAN + ")]
)
def test_a_wrong_number_ends_with_1(pattern: str, other: str, tmp_path: Path) -> None:
    generated(tmp_path, "--functions", "inverse_dynamics,gravity_forces")
    path = tmp_path / "two_link.c"
    path.write_text(re.sub(pattern, other, path.read_text(), count=1))
    ran = by_hand(tmp_path, "C", ["two_link.c", "main.c"])
    assert ran.returncode == 1
    assert "WRONG" in ran.stdout


def long_chain() -> Program:
    return lower(derive(chain(90), ("inverse_dynamics", "gravity_forces")))


@pytest.mark.wide(2)
@pytest.mark.parametrize("language", LANGUAGES)
def test_lone_headers_stand_side_by_side_in_two_files(language: str, tmp_path: Path) -> None:
    """Their helpers, parts and macros do not meet, and what is not called is no warning."""
    ops, long = emit(lower(every_op()), "c", option="header-only"), emit(long_chain(), "c", option="header-only")
    assert "_part4(" in long["chain90.h"]
    write({**ops, **long}, tmp_path)
    both = '#include "every_op.h"\n#include "chain90.h"\n#include "every_op.h"\n'
    asked = "double x[90] = {0.0}; chain90_inverse_dynamics(x, x, x, x); "
    called = "double y[90] = {0.0}; every_op_scalar(y, y, y, y); return (x[0] < 0.0) + (int)y[1];"
    (tmp_path / "one.c").write_text(f"{both}int other(void);\nint main(void) {{ {asked}{called} }}\n")
    (tmp_path / "two.c").write_text(f"{both}int other(void);\nint other(void) {{ return 0; }}\n")
    assert not re.search(r"^#define (?!SYMDYN)\w+", undefined(long["chain90.h"]), re.MULTILINE)
    by_hand(tmp_path, language, ["one.c", "two.c"])


def undefined(text: str) -> str:
    """Return a header without the macros that it takes back in the end."""
    for name in re.findall(r"^#undef (\w+)$", text, re.MULTILINE):
        text = re.sub(rf"^#define {name}\b.*$", "", text, flags=re.MULTILINE)
    return text


def test_a_lone_header_is_not_compiled_by_itself() -> None:
    with pytest.raises(BuildError, match="header-only"):
        build(emit(lower(every_op()), "c", option="header-only"))


def test_files_of_others_stay(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "main.c").write_text("int main(void) { return 0; }\n")
    words = ["generate", TWO_LINK, "--target", "c", "-o", str(tmp_path)]
    for _ in range(2):  # ours are written again, theirs are not
        assert main(words) == 0
        out, err = capsys.readouterr()
        assert [Path(line).name for line in out.splitlines()] == ["two_link.c", "two_link.h", "CMakeLists.txt"]
        assert err == "symdyn: main.c: is not of symdyn and left as it is; generate into another folder to have ours\n"
    assert (tmp_path / "main.c").read_text() == "int main(void) { return 0; }\n"


def test_a_scene_called_main_keeps_its_code(tmp_path: Path) -> None:
    scene = tmp_path / "main.toml"
    scene.write_text(Path(TWO_LINK).read_text().replace('name = "two_link"', 'name = "main"'))
    generated(tmp_path, "--functions", "mass_matrix", scene=str(scene))
    assert "int main" not in (tmp_path / "main.c").read_text()
    assert by_hand(tmp_path, "C", ["main.c", "example.c"]).returncode == 0


def test_the_same_bytes_again() -> None:
    sources = emit(prepare(lower(derive(chain(3), ("inverse_dynamics",)))), "c")
    assert beside(sources) == beside(sources)


def test_no_text_of_a_scene_reaches_what_stands_beside() -> None:
    sources = emit(lower(every_op('x");system("id");/*')), "c")
    assert list(beside(sources)) == ["main.c", "CMakeLists.txt"]
    assert not any(word in text for text in beside(sources).values() for word in ('system("', "load", "mass"))


@pytest.mark.runs("gcc")
def test_what_is_no_file_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "main.c")  # whoever opened it would wait for its writer
    generated(tmp_path, "--functions", "mass_matrix")
    assert "int main" in (tmp_path / "main.c").read_text()


def test_a_bound_that_holds_nowhere_is_not_looked_for_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[int] = []

    def count(*given: Any) -> Any:
        tried.append(1)
        return results(*given)

    results = worked_example._results
    monkeypatch.setattr(worked_example, "_results", count)
    code = lower(formulate(chain(24), ("forward_dynamics", "inverse_dynamics"), "aba"))
    found = worked_example.worked_example(emit(code, "c"))

    assert (found.left_out, [one.name for one in found.called]) == (("forward_dynamics",), ["inverse_dynamics"])
    assert len(tried) == worked_example.ENOUGH
