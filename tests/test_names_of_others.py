"""Generated C beside what others call their own: their macros stay, and two headers do not meet in any order."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from formulas import every_op, one
from test_loops_over_tables import LOOP, tree, with_rotors

import symdyn
from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.errors import EmitError
from symdyn.graph import Graph, Op
from symdyn.program import formulate, lower
from symdyn.resources import folder
from symdyn.scene import read_text

pytestmark = [pytest.mark.long(0)]

THEIRS = [
    "restrict",
    "WIDE",
    "ALONE",
    "ALIGNED",
    "PART",
    "INLINED",
    "SOON",
    "AHEAD",
    "CROWDED",
    "CHAINS",
    "EACH",
    "LANES",
    "WITHIN",
    "FUSED",
    "RESTRICT",
    "T",
    "I",
    "N",
    "M",
    "dd",
    "fill",
    "drain",
    "upper",
    "horner",
    "noinline",
    "aligned",
    "always_inline",
    "optimize",
    "vector_size",
    "may_alias",
]
"""What headers use for themselves under other names, and what others call so."""

STANDARD = {"casadi_real", "casadi_int", "NPY_NO_DEPRECATED_API"}
"""What others say shall be defined, and by whom it is not yet."""

OTHER = "int other(void);\nint other(void) { return 0; }"

STRICT = ["-O1", "-Wall", "-Wextra", "-Wundef", "-Wshadow", "-Wconversion", "-pedantic", "-Werror"]

COMPILERS = {
    "gcc": ["gcc", "-std=c99", *STRICT],
    "clang": ["clang", "-std=c99", "-Wreserved-identifier", *STRICT],
    "g++": ["g++", "-std=c++11", "-x", "c++", *STRICT],
    "clang++": ["clang++", "-std=c++11", "-Wreserved-identifier", "-x", "c++", *STRICT],
}


@pytest.fixture(scope="module")
def headers() -> Mapping[str, str]:
    """Return headers of all kinds: lines, parts, rows that are solved, loops over tables, double-doubles."""
    kinds = {
        "ops": (lower(every_op("ops")), "double"),
        "other_ops": (lower(every_op("other_ops")), "float"),
        "arm7": (lower(formulate(symdyn.example("arm7"), ["forward_dynamics_derivatives"])), "double"),
        "tree12": (lower(formulate(with_rotors(tree(4, 12)), ["inverse_dynamics"], LOOP)), "float"),
        "two_link": (lower(derive(symdyn.example("two_link"), ("inverse_dynamics",))), "dd"),
    }
    made = {}
    for program, real in kinds.values():
        ((file, text),) = emit(program, "c", real, option="header-only").texts.items()
        made[file] = text
    return made


def compiled(folder: Path, words: list[str], lines: list[str]) -> str:
    """Return what a compiler has to say of lines."""
    (folder / "all.c").write_text("\n".join([*lines, ""]))
    command = [*words, "-Wno-unknown-pragmas", "-Wno-keyword-macro", "-c", "all.c", "-o", "all.o"]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return ran.stderr + f"exit status {ran.returncode}" * (ran.returncode != 0)


@pytest.mark.runs("gcc", "g++", "clang")
@pytest.mark.parametrize("compiler", COMPILERS)
def test_macros_of_others_stay_and_headers_stand_in_either_order(
    compiler: str, headers: Mapping[str, str], tmp_path: Path
) -> None:
    for file, text in headers.items():
        (tmp_path / file).write_text(text)
    own = {name for text in headers.values() for name in re.findall(r"\b\w+?_own_(\w+)", text)}
    assert {"sign_of", "exp_of", "column_vec", "dd", "sincos_row", "forward_dynamics_derivatives_part1"} <= own
    names = dict.fromkeys([*THEIRS, *sorted(own)])
    begin = [f"#include <{name}.h>" for name in ("math", "stddef", "stdint", "string")]  # theirs would break these
    theirs = [f"#define {name} 3" for name in names]
    there = [f"#if {name} != 3\n#error {name} is lost\n#endif" for name in names]
    included = [f'#include "{file}"' for file in headers]

    for order in (included, included[::-1], included * 2):
        assert compiled(tmp_path, COMPILERS[compiler], [*begin, *theirs, *order, *there, OTHER]) == ""


@pytest.mark.runs("gcc")
def test_a_header_that_takes_a_name_of_others_would_be_found(headers: Mapping[str, str], tmp_path: Path) -> None:
    there = "#define WIDE 3\n", "#if WIDE != 3\n#error lost\n#endif", "int other(void);"
    (tmp_path / "arm7.h").write_text(headers["arm7.h"].replace("SYMDYN_WIDE", "WIDE"))

    said = compiled(tmp_path, COMPILERS["gcc"], [there[0], '#include "arm7.h"', *there[1:]])

    assert "WIDE" in said


@pytest.mark.runs("gcc")
def test_scenes_that_differ_by_a_capital_stand_side_by_side(tmp_path: Path) -> None:
    for place in ("one", "other"):  # which may be one on disks that know no capitals
        (tmp_path / place).mkdir()
    for place, name in (("one", "ops"), ("other", "Ops")):
        for file, text in emit(lower(every_op(name)), "c").texts.items():
            (tmp_path / place / file).write_text(text)
    call = "void f(double *x);\nvoid f(double *x) { ops_scalar(x, x, x, x); Ops_scalar(x, x, x, x); }"
    assert compiled(tmp_path, COMPILERS["gcc"], ['#include "one/ops.h"', '#include "other/Ops.h"', call]) == ""


def test_no_template_defines_a_macro_that_is_not_of_symdyn() -> None:
    files = [file for file in folder("templates").rglob("*") if file.suffix in (".h", ".jinja")]
    text = "\n".join(file.read_text("utf-8") for file in files)
    found = set(re.findall(r"^ *# *(?:define|undef) +([^\s({]+)", text, re.MULTILINE))

    assert {"SYMDYN_ALONE", "SYMDYN_", "SYMDYN_LANES", "SYMDYN_EXPORT", "SYMDYN_PACK"} <= found
    assert {one for one in found if not one.startswith("SYMDYN_")} == STANDARD


@pytest.mark.parametrize(("real", "scene", "name"), [("dd", "dd", "add"), ("double", "fill", "columns")])
def test_what_is_for_callers_is_called_as_nothing_of_the_files_own(real: str, scene: str, name: str) -> None:
    g = Graph()
    x = g.symbol("x")
    entry = g.sin(x) * g.function(Op.SIGN, x) if real == "double" else g.sin(x)
    made = one([entry], [x], symdyn.Scene(scene))
    program = lower(replace(made, functions=(replace(made.functions[0], name=name),)))

    for option in ("batch", "header-only")[: 1 + (real == "dd")]:
        with pytest.raises(EmitError, match=f"{scene}_{name} would be a function for callers, .* rename the scene or"):
            emit(program, "c", real, option=option)


SCENE = """
name = "memcpy"
gravity = [0, "-linux", 0]
parameters = { WIDE = {}, linux = {}, NULL = {}, EOF = {}, PART = {} }
[bodies.part]
particles = [{ mass = "WIDE", at = [0, "-EOF", 0] }]
[bodies.aligned]
particles = [{ mass = "NULL", at = [0, "-PART", 0] }]
[joints.part]
type = "revolute"
parent = "ground"
child = "part"
axis = [0, 0, 1]
[joints.elbow]
type = "revolute"
parent = "part"
child = "aligned"
axis = [0, 0, 1]
origin = [0, "-EOF", 0]
coordinate = "I"
"""


@pytest.mark.heavy("batch")
@pytest.mark.runs("gcc", "g++", "clang")
@pytest.mark.parametrize("option", ["", "batch", "header-only"])
def test_a_scene_may_be_called_as_what_c_has(option: str, tmp_path: Path) -> None:
    program = lower(derive(read_text(SCENE), ("inverse_dynamics", "forward_dynamics")))
    for file, text in emit(program, "c", option=option).texts.items():
        (tmp_path / file).write_text(text)
    shown = "memcpy.h" if option == "header-only" else "memcpy.c"
    for words in (["gcc", "-std=gnu99"], ["clang", "-std=gnu99"], ["g++", "-x", "c++", "-Drestrict=__restrict"]):
        lines = ["#include <stdio.h>", "#include <complex.h>"[: 22 * (words[0] != "g++")], f'#include "{shown}"', OTHER]
        assert compiled(tmp_path, [*words, *STRICT], lines) == ""


@pytest.mark.wide("g++")
@pytest.mark.runs("g++", "clang")
@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_headers_of_cpp_leave_macros_too(compiler: str, tmp_path: Path) -> None:
    programs = lower(every_op("ops")), lower(formulate(symdyn.example("arm7"), ["forward_dynamics_derivatives"]))
    for program in programs:
        for file, text in emit(program, "cpp", option="batch").texts.items():
            (tmp_path / file).write_text(text)
    names = sorted({*THEIRS} - {*"TMN"})
    begin = [f"#include <{name}>" for name in ("array", "cmath", "cstring", "limits", "type_traits")]
    theirs = [f"#define {name} 3" for name in names]
    there = [f"#if {name} != 3\n#error {name} is lost\n#endif" for name in names]
    words = [*COMPILERS[compiler], "-std=c++17"]
    lines = [*begin, *theirs, '#include "ops.hpp"', '#include "arm7.hpp"', '#include "ops.hpp"', *there, OTHER]

    assert compiled(tmp_path, words, lines) == ""
