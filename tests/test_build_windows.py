"""What compilers on Windows are told, by a stand-in for `cl` that passes it on; plain C linked for Windows by zig."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path, PureWindowsPath

import numpy as np
import pytest
from formulas import every_op

import symdyn
from symdyn.cli import main
from symdyn.emit import emit
from symdyn.program import lower
from symdyn.runtime import build
from symdyn.runtime.commands import CL, CLANG_CL, GNU, MINGW, Needs, candidates, dialect_of
from symdyn.runtime.compiler import find_compiler, words_of
from symdyn.runtime.library import python_libraries

pytestmark = pytest.mark.runs("cc")

EXAMPLES = Path(__file__).parent.parent / "examples"

NEEDS = Needs(headers=("H",), libraries=(("C:/Python/libs", "python311"),), exports=("arm_mass_matrix",), soon=True)


@pytest.mark.parametrize(
    ("command", "platform", "dialect"),
    [
        (r"C:\Program Files\VC\bin\cl.exe", "win32", CL),
        ("CL.EXE", "win32", CL),
        (r"C:\LLVM\bin\clang-cl.exe", "win32", CLANG_CL),
        (r"C:\mingw64\bin\gcc.exe", "win32", MINGW),
        (r"C:\LLVM\bin\clang.exe", "win32", MINGW),
        ("python.exe", "win32", MINGW),  # of ziglang
        ("/usr/bin/cc", "linux", GNU),
        ("/opt/cl/gcc", "darwin", GNU),
    ],
)
def test_a_compiler_is_known_by_its_name(command: str, platform: str, dialect: object) -> None:
    assert dialect_of((command,), platform) is dialect


def test_what_is_looked_for() -> None:
    assert candidates("linux") == ("cc", "gcc", "clang")
    assert candidates("win32")[:2] == ("cl", "clang-cl")


def test_extensions_link_against_python_on_windows_alone() -> None:
    ((folder, name),) = python_libraries("win32")
    assert PureWindowsPath(folder).name == "libs"
    assert name == f"python{sys.version_info.major}{sys.version_info.minor}"
    assert python_libraries("linux") == python_libraries("darwin") == ()


def test_an_extension_is_linked_in_the_words_of_each() -> None:
    made = Path("aside") / "arm.pyd"
    cl, clang_cl, mingw, gnu = (
        one.line((), [Path("arm.c")], made, NEEDS, part=False) for one in (CL, CLANG_CL, MINGW, GNU)
    )
    for words in (cl, clang_cl):
        assert {"/IH", "/LD", f"/Fe:{made}", "/LIBPATH:C:/Python/libs", "python311.lib"} <= {*words}
        before, after = words[: words.index("/link")], words[words.index("/link") :]
        assert "arm.c" in before
        assert "/EXPORT:arm_mass_matrix" in after
        assert not any(word.startswith("-") for word in words)
    assert mingw[-4:] == ("-o", str(made), "-LC:/Python/libs", "-lpython311")
    assert "-fPIC" not in mingw
    assert gnu[-3:] == ("-o", str(made), "-lm")
    assert "-fPIC" in gnu


def test_a_backslash_on_windows_is_part_of_a_path() -> None:
    assert words_of(r'"C:\Program Files\cl.exe" /O1', "win32") == [r"C:\Program Files\cl.exe", "/O1"]
    assert words_of(r"C:\mingw\gcc.exe -O1", "win32") == [r"C:\mingw\gcc.exe", "-O1"]
    assert words_of(r"gcc\ 12 -O1", "linux") == ["gcc 12", "-O1"]


STAND_IN = r"""#!/bin/sh
[ $# = 0 ] && { echo "Compiler of C, Version 19, stand-in" >&2; exit 0; }
echo "$@" >> FOLDER/said
out= part= files= more= linking=
for word in "$@"; do
    case $linking$word in
        /link) linking=1;;
        1/EXPORT:*) nm_wanted="$nm_wanted ${word#/EXPORT:}";;
        1/*) ;;
        /c) part=-c;;
        /Fe:*) out=${word#/Fe:};;
        /Fo*\\) ;;
        /Fo*) out=${word#/Fo};;
        /I*) more="$more -I ${word#/I}";;
        /nologo|/utf-8|/std:c11|/O1|/O2|/fp:precise|/LD|/clang:*) ;;
        /*.c|/*.obj) files="$files $word";;
        *) echo "unknown word $word" >&2; exit 2;;
    esac
done
CC -x none -O1 -fPIC -shared -fvisibility=hidden $part $more $files -o "$out" -lm || exit 1
"""


@pytest.fixture
def cl(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A program called cl, which takes words of `cl` alone and compiles by another."""
    script = STAND_IN.replace("FOLDER", str(tmp_path)).replace("CC ", f"{find_compiler().command[0]} ")
    (tmp_path / "cl").write_text(script.replace(" -fvisibility=hidden", ""))
    (tmp_path / "cl").chmod(0o755)
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("CC", str(tmp_path / "cl"))
    return tmp_path


def test_plain_c_is_built_by_what_speaks_as_cl(cl: Path) -> None:
    sources = emit(lower(every_op()), "c", option="batch")
    assert build(sources).scalar([0.0, 0.0], [2.0, 3.0], [10.0]) == 21.0
    said = (cl / "said").read_text()
    assert all(f"/EXPORT:every_op_scalar{ending} " in said for ending in ("", "_batch", "_rows"))


def test_an_extension_is_built_by_what_speaks_as_cl(cl: Path) -> None:
    arm = symdyn.load(EXAMPLES / "two_link.toml", "mass_matrix")
    assert arm.compiled
    np.testing.assert_allclose(arm.mass_matrix([0, 0], [1, 1, 1, 1, 9.81]), [[5, 2], [2, 1]])
    assert f"/I{np.get_include()}" in (cl / "said").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("words", ["", "--batch", "--header-only", "--real float", "--prepare"])
@pytest.mark.parametrize("machine", ["x86_64-windows-gnu", "aarch64-windows-gnu"])
def test_plain_c_is_linked_for_windows(words: str, machine: str, zig: list[str], tmp_path: Path) -> None:
    scene = str(EXAMPLES / "two_link.toml")
    assert main(["generate", scene, "--target", "c", *words.split(), "-o", str(tmp_path), "--quiet"]) == 0
    strict = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror"]
    files = [path.name for path in sorted(tmp_path.glob("*.c"))]
    line = [*zig, "cc", "-target", machine, *strict, "-Wno-unknown-pragmas", *files, "-o", "example.exe"]
    ran = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "example.exe").read_bytes()[:2] == b"MZ"


@pytest.mark.slow
def test_a_library_for_windows_hands_out_its_functions(zig: list[str], tmp_path: Path) -> None:
    sources = emit(lower(every_op()), "c", option="batch")
    (tmp_path / "every_op.h").write_text(sources.texts["every_op.h"])
    (tmp_path / "every_op.c").write_text(sources.texts["every_op.c"])
    made = tmp_path / "every_op.dll"
    line = MINGW.line((), [tmp_path / "every_op.c"], made, Needs(), part=False)
    ran = subprocess.run(
        [*zig, "cc", "-target", "x86_64-windows-gnu", *line], capture_output=True, text=True, check=False
    )
    assert (ran.returncode, made.read_bytes()[:2]) == (0, b"MZ"), ran.stderr
    for ending in ("", "_batch", "_rows"):
        assert f"every_op_scalar{ending}\0".encode() in made.read_bytes()
