"""Scenes and functions that are called as something of C, C++ or their headers compile, beside all of the headers."""

from __future__ import annotations

import io
import subprocess
import sysconfig
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cuda_on_host import HEADER as CARD, LAUNCH
from formulas import every_op
from names_of_headers import headers, names_of

import symdyn
from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.emit.targets.emit_program import TARGETS
from symdyn.program import lower
from symdyn.scene import read_text

FOUND = """y0 y1 yn j0 j1 jn gamma lgamma tgamma erf erfc div ldiv system free rand srand exit abort pow hypot malloc
calloc realloc size_t ptrdiff_t printf puts isnan isinf signbit errno stdin EOF NULL M_PI M_E HUGE_VAL
INFINITY NAN RAND_MAX INT_MAX CHAR_BIT BUFSIZ assert offsetof va_arg setjmp time clock tm atoi qsort bsearch
getenv strlen strcpy memcpy memset index rindex round floor ceil fma fmod cbrt expm1 log1p log2 nearbyint
remquo scalbn signgam drem significand jnf finite I complex imaginary bool wchar_t char16_t int8_t uint64_t
FILE DIR link read write open close pipe fork wait kill sleep random daemon stat accept bind connect listen
socket poll select signal raise alarm dup nice pause sync tee splice"""
"""Those that did not compile, or might not."""

WORDS = """exp sin sqrt abs int double log cos tan tanh sign atan2 pi deg auto break char const do else enum for goto
if inline long register restrict return static struct switch typedef union unsigned void volatile while
class template namespace new delete this throw try catch using virtual operator private public friend
typename constexpr nullptr and or not xor alignas concept requires co_await export explicit mutable typeid
decltype main std Eigen raw own T N M linux unix q qd qdd tau params out t np lambda in is import def"""
"""Words of languages, and what generated code calls its own."""

NAMES = tuple(dict.fromkeys((FOUND + " " + WORDS).split()))

SHARE = 33
"""Of so many names one is tried always."""

HEADERS = [f"#include <{one}.h>" for one in headers("c++")]
"""All of them before ours, and none between: what they call theirs is all there."""

QUIET = [
    "-fsyntax-only",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-Wno-unused-function",
    "-Wno-unknown-pragmas",
    "-D_GNU_SOURCE",
]
IN_C = ["gcc", "-std=gnu11", *QUIET]
IN_CPP = ["g++", "-std=gnu++17", "-x", "c++", *QUIET]

SCENE = """
[bodies.bar]
particles = [{ mass = 2, at = ["1/3", 0, 0] }]
[joints.pin]
type = "revolute"
parent = "ground"
child = "bar"
axis = [0, 1, 0]
coordinate = "angle"
"""


def refused(command: Sequence[str], folder: Path, *files: str) -> str:
    """Return what a compiler has to say of files, the first lines."""
    done = subprocess.run([*command, *files], cwd=folder, capture_output=True, text=True, check=False)
    return "\n".join(done.stderr.splitlines()[:12]) + "failed" * (done.returncode != 0 and not done.stderr)


def written(folder: Path, names: Sequence[str], target: str, option: str = "") -> dict[str, list[str]]:
    """Return the files of scenes of those names, by name."""
    functions = TARGETS[target].functions
    found = {}
    for name in names:
        scene = replace(read_text(SCENE), name=name)
        wanted = functions(scene) if functions else ("mass_matrix", "forward_dynamics")
        files = emit(lower(derive(scene, wanted)), target, option=option).files
        found[name] = [file for file, _ in files]
        for file, contents in files:
            if isinstance(contents, bytes):
                with zipfile.ZipFile(io.BytesIO(contents)) as packed:
                    packed.extractall(folder / file.partition(".")[0])
            elif not file.endswith((".m", ".py")):
                (folder / file).write_text(contents)
    return found


def together(folder: Path, files: Sequence[str], name: str) -> None:
    """Write a file that opens all headers, then those files."""
    (folder / name).write_text("\n".join([*HEADERS, *(f'#include "{file}"' for file in files), ""]))


def every(written: dict[str, list[str]], ending: str = "") -> list[str]:
    """Return all files of scenes, each once."""
    files = dict.fromkeys(file for some in written.values() for file in some)
    return [file for file in files if file.endswith(ending)]


def in_c(folder: Path, names: Sequence[str]) -> list[str]:
    there = [
        file for option in ("", "batch") for files in written(folder, names, "c", option).values() for file in files
    ]
    together(folder, [file for file in dict.fromkeys(there) if file.endswith(".h")], "all of them.c")
    sources = [file for file in dict.fromkeys(there) if file.endswith(".c")]
    return [refused([*IN_C, "-I."], folder, "all of them.c", *sources)]


def header_only(folder: Path, names: Sequence[str]) -> list[str]:
    together(folder, every(written(folder, names, "c", "header-only")), "all of them.c")
    return [refused(command, folder, "all of them.c") for command in (IN_C, IN_CPP)]


def in_cpp(folder: Path, names: Sequence[str]) -> list[str]:
    told = []
    for option in ("", "batch"):
        together(
            folder, [file for files in written(folder, names, "cpp", option).values() for file in files], "all.cpp"
        )
        told.append(refused(IN_CPP, folder, "all.cpp"))
    return told


def ufunc(folder: Path, names: Sequence[str]) -> list[str]:
    there = every(written(folder, names, "ufunc"), ".c")
    paths = [f"-isystem{path}" for path in (sysconfig.get_paths()["include"], np.get_include())]
    return [refused([*IN_C, *paths, "-Wno-missing-field-initializers"], folder, *there)]


def on_a_card(folder: Path, names: Sequence[str]) -> list[str]:
    there = every(written(folder, names, "gpu"), ".cu")
    (folder / "host.h").write_text(CARD)
    for file in there:
        (folder / file).write_text(LAUNCH.sub("\\1(\\5);", (folder / file).read_text()))
    together(folder, there, "all.cpp")
    return [refused([*IN_CPP, "-include", "host.h"], folder, "all.cpp")]


def fmu(folder: Path, names: Sequence[str]) -> list[str]:
    there = [file.partition(".")[0] for file in every(written(folder, names, "fmu"))]
    sources = [sorted(str(path) for path in (folder / one / "sources").glob("*.c")) for one in there]
    return [refused([*IN_C, "-Wno-unused-parameter"], folder, *some) for some in sources if some]


def mex(folder: Path, names: Sequence[str]) -> list[str]:
    there = [
        file for files in written(folder, names, "matlab", "mex").values() for file in files if file.endswith(".c")
    ]
    return [refused(IN_C, folder, *(file for file in there if not file.endswith("_mex.c")))]


def casadi(folder: Path, names: Sequence[str]) -> list[str]:
    there = every(written(folder, names, "casadi", "external"), ".c")
    return [refused([*IN_C, "-Wno-unused-parameter"], folder, *there)]


WAYS: dict[str, Callable[[Path, Sequence[str]], list[str]]] = {
    "c": in_c,
    "header-only": header_only,
    "cpp": in_cpp,
    "ufunc": ufunc,
    "gpu": on_a_card,
    "fmu": fmu,
    "mex": mex,
    "casadi": casadi,
}


@pytest.mark.wide("c", "cpp")
@pytest.mark.long(0)
@pytest.mark.runs("gcc", "g++")
@pytest.mark.parametrize(
    "way", [pytest.param(way, marks=pytest.mark.mends("30.attacks.5") if way == "cpp" else ()) for way in WAYS]
)
def test_a_scene_called_as_something_of_c_compiles(way: str, tmp_path: Path) -> None:
    few = [name for name in FOUND.split() if name in ("gamma", "system")] + list(FOUND.split()[::SHARE])
    assert "".join(WAYS[way](tmp_path, few)) == ""


@pytest.mark.slow
@pytest.mark.runs("gcc", "g++")
@pytest.mark.parametrize("way", WAYS)
def test_scenes_called_as_anything_of_c_compile(way: str, tmp_path: Path) -> None:
    assert len(NAMES) >= 200
    assert "".join(WAYS[way](tmp_path, NAMES)) == ""


def called(names: Sequence[str]) -> symdyn.program.Program:
    """Return a program with functions of those names, as a JSON graph may have."""
    program = lower(every_op("graph"))
    first = program.routines[1]
    functions = [replace(first, function=replace(first.function, name=name, request=name)) for name in names]
    return replace(program, routines=tuple(functions))


@pytest.mark.wide(2)
@pytest.mark.long(0)
@pytest.mark.runs("gcc", "g++")
@pytest.mark.parametrize(
    ("target", "option"),
    [
        *(("c", ""), ("c", "header-only")),
        *(pytest.param("cpp", option, marks=pytest.mark.mends("30.attacks.5")) for option in ("", "batch")),
    ],
)
def test_functions_called_as_something_of_c_compile(target: str, option: str, tmp_path: Path) -> None:
    names = [name for name in NAMES if name not in ("std", "Eigen")]
    for file, text in emit(called(names), target, option=option).texts.items():
        (tmp_path / file).write_text(text)
    ending = {"cpp": ".hpp"}.get(target, ".h")
    together(tmp_path, [f"graph{ending}"], "all of them.c")
    commands = [IN_CPP] if target == "cpp" else [IN_C, IN_CPP] if option else [IN_C]
    assert "".join(refused(command, tmp_path, "all of them.c") for command in commands) == ""


@pytest.mark.runs("gcc")
def test_a_function_that_c_would_call_as_its_own_gets_an_underscore() -> None:
    program = called(["wait", "mass_matrix"])
    made = emit(replace(program, scene=replace(program.scene, name="sem")), "c").texts["sem.h"]
    assert "sem_wait_(" in made
    assert "sem_mass_matrix(" in made


@pytest.mark.long(0)
@pytest.mark.runs("gcc", "g++")
@pytest.mark.parametrize("language", ["c", "c++"])
def test_what_headers_of_this_machine_call_theirs_is_in_the_list(language: str) -> None:
    from symdyn.emit.code.identifiers import names_of_c

    there = names_of(language)
    assert len(there) > 2000
    assert sorted(there - names_of_c()) == []
