"""Second derivatives of large robots as a loop over pairs of velocities: what C computes, and how that is proved."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from arms import turning_chain
from mechanisms import jointed

import symdyn
from symdyn.emit import emit
from symdyn.program import PairLoop, Program, RowLoop, formulate, lower
from symdyn.runtime.c_module import build
from symdyn.scene import Scene
from symdyn.verify.accuracy import measure
from symdyn.verify.building import files_of
from symdyn.verify.claims import program_claims
from symdyn.verify.equality import prove
from symdyn.verify.written import languages, printed, prove_texts

pytestmark = pytest.mark.usefixtures("optimised")

PACKED = "inverse_dynamics_second_derivatives_packed"
SCENES = {
    "flying arm": lambda: jointed("free", "revolute", "revolute"),
    "branches": lambda: turning_chain(4, "tree"),
}


@cache
def scene_of(name: str) -> Scene:
    return SCENES[name]()


@pytest.fixture(autouse=True)
def _all_sizes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[lower.__module__], "FEWEST_OF_PAIRS", 1)


def program_of(name: str) -> Program:
    """Return the program of the packed derivatives of a scene."""
    return lower(formulate(scene_of(name), [PACKED]))


@pytest.mark.parametrize("name", SCENES)
def test_runs_of_pairs_are_proved_to_be_the_entries(name: str) -> None:
    program = program_of(name)
    loop = RowLoop.of(program.routines[0].function)
    assert isinstance(loop, PairLoop)

    _, found = prove(program_claims(scene_of(name), formulate(scene_of(name), [PACKED]).functions, program), seed=1)

    assert [one.verdict for one in found] == ["proved", "proved"]
    assert "in runs of pairs" in str(found)


@pytest.mark.wide("-branches")
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("option", ["", "batch", "header-only"])
def test_the_text_is_proved_and_a_wrong_way_is_told(name: str, option: str) -> None:
    sources = emit(program_of(name), "c", option=option)
    files, wanted = files_of(sources), printed(sources.program, "double", loops=True)
    source = next(file for file, text in sources.texts.items() if "_solved(r, out)" in text)
    table = sources.texts[source].split("_chains[")[1].split("{")[1].split("}")[0]
    numbers = table.split(", ")
    last = len(numbers) - 1 - ([*reversed(numbers)].index("0"))  # the first one on the way of the last velocity

    def told(*texts: str) -> list[Any]:
        changed = {**files.contents, source: sources.texts[source].replace(table, ", ".join(texts))}
        return list(prove_texts(wanted, replace(files, contents=changed), languages("c", option)))

    assert {one.passed for one in told(*numbers)} == {True}
    for wrong in ([*numbers[:last], "1", *numbers[last + 1 :]], numbers[:-1], [*numbers[:-1], "99"]):
        assert {one.file for one in told(*wrong) if not one.passed} == {source}


@pytest.mark.wide("double-branches")
@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("real", ["double", "float"])
def test_c_is_within_the_bound_of_its_lines(name: str, real: str) -> None:
    program = program_of(name)
    sources = emit(program, "c", real)
    assert "_solved(r, out);" in "".join(sources.texts.values())

    found = measure(program, {"c": build(sources)}, real=real)

    assert [one.passed for one in found] == [True]


@pytest.mark.slow
@pytest.mark.runs("cc", "gcc")
def test_gcc_says_nothing_and_no_number_behind_the_result_is_written(tmp_path: Path) -> None:
    sources = emit(program_of("flying arm"), "c", option="header-only")
    ((file, text),) = sources.texts.items()
    (tmp_path / file).write_text(text)
    (size,) = sources.program.routines[0].function.shape
    nq, nv = len(scene_of("flying arm").coordinates), len(scene_of("flying arm").velocities)
    name = text.split("static inline void ")[1].split("(")[0]
    main = f"""#include "{file}"
static double q[{nq}] = {{1}}, u[{nv}], a[{nv}];
int main(void) {{
    double *out = malloc({size} * sizeof *out);
    {name}(q, u, a, out);
    double sum = 0;
    for (int k = 0; k < {size}; k++) sum += out[k];
    free(out);
    return sum != sum;
}}
"""
    (tmp_path / "main.c").write_text("#include <stdlib.h>\n" + main)
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined", "main.c", "-lm"]
    subprocess.run(["gcc", *flags], cwd=tmp_path, check=True)
    subprocess.run([tmp_path / "a.out"], check=True)


def test_springs_by_formulas_stay_in_lines_and_so_do_small_robots(monkeypatch: pytest.MonkeyPatch) -> None:
    text = (Path(symdyn.__file__).parent.parent / "examples" / "two_link.toml").read_text("utf-8")
    tied = symdyn.scene.read_text(text.replace("[joints.elbow]", '[joints.elbow]\nforce = "-3*q2**3"', 1))
    assert lower(formulate(tied, [PACKED])).routines[0].function.solve is None

    monkeypatch.undo()
    assert RowLoop.of(program_of("branches").routines[0].function) is None
