"""Files of a stranger that say one thing to a grammar and another to a compiler, or hide what they do, are refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

import symdyn
from symdyn.emit import emit
from symdyn.verify.building import files_of
from symdyn.verify.written import Printed, Written, languages, printed, prove_texts


@pytest.fixture(scope="module")
def numbers() -> Printed:
    return printed(
        symdyn.program.lower(symdyn.dynamics.derive(symdyn.example("two_link"), ["inverse_dynamics", "mass_matrix"])),
        "double",
    )


def attacked(numbers: Printed, target: str, ending: str, old: str, new: str, option: str = "") -> Written:
    """Return what is known of the one file of a target with a piece of its text changed."""
    files = files_of(emit(numbers.program, target, option=option))
    name = next(one for one in files.contents if one.endswith(ending))
    text = str(files.contents[name])
    assert old in text
    changed = replace(files, contents={**files.contents, name: text.replace(old, new, 1)})
    found = prove_texts(numbers, changed, languages(target, option), files.contents)
    return next(one for one in found if one.file == name)


C = ("c", "two_link.c")
OUT = "    out[1] = x5;"
POWER = f"{2**600}.0"


@pytest.mark.parametrize(
    "new",
    [
        "    // ??/\n    out[1] = x5;",
        "    // \\ \n    out[1] = x5;",
        "    // \r out[0] = 1.0;\n    out[1] = x5;",
        "    out[1] = -\\\n-x5;",
        "    SYMDYN_EACH out[1] = x5;",
        "    SYMDYN_ALONE out[1] = x5;",
    ],
    ids=["trigraph", "splice with a space", "carriage return", "splice of two signs", "macro of a loop", "macro"],
)
def test_what_compilers_see_and_grammars_do_not_is_refused(numbers: Printed, new: str) -> None:
    assert attacked(numbers, *C, OUT, new).verdict == "not shown"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("= x5;", "= x5 * (q_1 / q_1);"),
        ("= x5;", "= x5 + (x1 - x1);"),
        ("= x5;", "= x5 + 0.0 * log(q_1);"),
        ("= x5;", "= x5 * ((1e308 * 1e308) / (1e308 * 1e308));"),
        ("= x5;", f"= (1.0 / {POWER}) * ((1.0 / {POWER}) * ({POWER} * ({POWER} * x5)));"),
        ("2.0 * p_h1", "((0.1 + 2.0) - 0.1) * p_h1"),
        ("out[3] = x2;", "out[3] = x3 - p_h1 * x1;"),
    ],
)
def test_what_algebra_takes_away_and_rounding_does_not_is_found(numbers: Printed, old: str, new: str) -> None:
    found = attacked(numbers, *C, old, new)

    assert (found.verdict, found.where.partition(": ")[2]) == ("fails", "is the same function by other operations")


@pytest.mark.parametrize(
    ("target", "ending", "old", "new"),
    [
        ("numpy", ".py", '"""', '# coding: unicode_escape \\n\n"""'),
        ("casadi", ".py", '"""', '# vim: set fileencoding=utf-7 :\n"""'),
        ("numpy", ".py", "    return (\n        x", "    \uff585 = q_1\n    return (\n        x"),
        ("numpy", ".py", "    x1 =", "    # \r    of = q\n    x1 ="),
        ("js", ".mjs", "  const x1", "  // \u2028 out[0] = 1;\n  const x1"),
        ("js", ".mjs", "const x1", "const \\u0078\\u0031"),
        ("rust", ".rs", "    let x3", "    let r#x1 = 1.0;\n    let x3"),
        ("julia", ".jl", "    x1 =", "    \u212b = T(1.0)\n    x1 ="),
    ],
)
def test_letters_that_mean_something_else_elsewhere_are_refused(
    numbers: Printed, target: str, ending: str, old: str, new: str
) -> None:
    assert attacked(numbers, target, ending, old, new).verdict == "not shown"


@pytest.mark.parametrize(
    ("target", "ending", "old", "new"),
    [
        (*C, "q[0]", f"q[{'9' * 5000}]"),
        (*C, "2.0 *", "2.0e999999999 *"),
        (*C, "2.0 *", "2.0e-999999999 *"),
        (*C, OUT, f"    out[1] = {'(' * 3000}x5{')' * 3000};"),
        (*C, OUT, f"    double w[999999999999];\n{OUT}"),
        ("cpp", ".hpp", "= x3", f"= {'(' * 3000}x3{')' * 3000}"),
        ("matlab", "mass_matrix.m", "= x3", f"= {'(' * 3000}x3{')' * 3000}"),
        ("js", ".js", "const x2 =", "const x2 = <!-- no comment here\n"),
        ("rust", ".rs", "    let x1", "    let r = &mut [0.0; 99999999999999];\n    let x1"),
    ],
)
def test_what_is_too_large_or_too_deep_is_told(numbers: Printed, target: str, ending: str, old: str, new: str) -> None:
    assert attacked(numbers, target, ending, old, new).verdict == "not shown"


def test_a_comment_alone_between_two_words_does_not_join_them(numbers: Printed) -> None:
    header = attacked(numbers, "c", "two_link.h", "#define SYMDYN_two_link_H", "#define SYMDYN_two/**/_link_H")

    assert not header.passed
