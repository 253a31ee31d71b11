"""Derivatives of forward dynamics solved in rows: what C computes then, when it does so, and how that is proved."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from functools import cache
from io import BytesIO
from itertools import product
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
from mechanisms import jointed, random_tree

import symdyn
from symdyn.bench.reference import reference
from symdyn.cli import generate, main
from symdyn.dynamics.loops import partition as dense, reduction as reduced_rows
from symdyn.dynamics.mechanism import RowSolve
from symdyn.emit import TARGETS, emit
from symdyn.program import Program, formulate, in_lines, lower, prepare
from symdyn.program.lower import RowLoop
from symdyn.program.tunable import quaternion_places
from symdyn.runtime.c_module import build
from symdyn.scene import Scene, read_text
from symdyn.verify.accuracy import measure
from symdyn.verify.building import files_of
from symdyn.verify.claims import program_claims
from symdyn.verify.equality import prove
from symdyn.verify.written import READERS, languages, printed, prove_texts

pytestmark = pytest.mark.usefixtures("optimised")

EXAMPLES = Path(__file__).parent.parent / "examples"
FDD, BY_QD, BY_TAU = "forward_dynamics_derivatives", "forward_dynamics_by_qd", "forward_dynamics_by_tau"
BENT = "forward_dynamics_hessian"
FREE, MULTIPLIERS = "forward_dynamics_unprojected_derivatives", "multipliers_unprojected_derivatives"


def carried(n: int) -> Scene:
    """Return a chain as `carried_text` writes it."""
    return read_text(carried_text(n))


def carried_text(n: int) -> str:
    """Return a chain of n turns about all axes, a slide among them, its third joint moved along as time says."""
    parts = ['name = "carried"']
    for k in range(1, n + 1):
        kind, parent = "prismatic" if k == 5 else "revolute", f"b{k - 1}" if k > 1 else "ground"
        axis = [int(j == k % 3) for j in range(3)]
        parts += [
            f"[bodies.b{k}]\nmass = {k}\ncom = [0.1, 0.0{k}, 0.2]\ninertia = [0.3, 0.2, 0.1{k}]",
            'inertia_about = "com"',
            f'[joints.j{k}]\ntype = "{kind}"\nparent = "{parent}"\nchild = "b{k}"\naxis = {axis}',
            f'origin = [["Tx", 0.{k}], ["Ty", 0.3]]',
            'motion = "sin(2*t)/3"' if k == 3 else "",
        ]
    return "\n".join(parts)


def branching() -> Scene:
    """Return a tree of odd and right angles whose branches do not know of each other."""
    return random_tree(5, 9, free=False)


def fingers(many: int, n: int = 4) -> Scene:
    """Return chains of n slides and turns on the ground."""
    parts = ['name = "fingers"']
    for k in range(many * n):
        parts += [
            f"[bodies.b{k}]\nmass = {k + 1}\ncom = [0.1, 0.2, 0.3]",
            f'[joints.j{k}]\ntype = "{"revolute" if k % n else "prismatic"}"\nchild = "b{k}"',
            f'parent = "{f"b{k - 1}" if k % n else "ground"}"\naxis = {[int(i == k % 3) for i in range(3)]}',
        ]
    return read_text("\n".join(parts))


def held() -> Scene:
    """Return such a chain whose end is held to the ground by a ball."""
    end = '\n[[loop]]\nname = "end"\ntype = "spherical"\nparent = "ground"\nchild = "b9"\norigin = [3.5, 2, 0.5]'
    return read_text(carried_text(9) + end)


SCENES = {
    "arm7": lambda: symdyn.example("arm7"),
    "branching": branching,
    "carried": lambda: carried(8),
    "held": held,
    "quadruped": lambda: symdyn.example("quadruped"),
}
SMALL = list(SCENES)[:4]
ALL, FEW = (pytest.mark.parametrize("name", names) for names in (SCENES, SMALL))


@cache
def program_of(name: str, *functions: str) -> Program:
    """Return the program of functions of a scene, as C takes it."""
    return lower(formulate(SCENES[name](), functions or (FDD,)))


def text_of(program: Program, real: str = "double", option: str = "") -> str:
    """Return C."""
    return "".join(emit(program, "c", real, option=option).texts.values())


@pytest.mark.wide("arm7")
@FEW
@pytest.mark.long(0)
def test_rows_are_what_lines_compute(name: str) -> None:
    program = program_of(name)
    (routine,) = program.routines
    scene = SCENES[name]()
    claims = program_claims(scene, formulate(scene, [FDD]).functions, program)

    _, found = prove(claims, seed=1)

    assert [one.verdict for one in found] == ["proved", "proved"]
    assert "solved in rows" in str(found)
    assert f"{FDD}_solved(r)" in text_of(program)
    assert RowLoop.of(routine.function) is RowLoop.of(routine.function)


@pytest.mark.wide("double-arm7")
@FEW
@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize("real", ["double", "float"])
def test_c_is_within_the_bound_of_its_lines(name: str, real: str) -> None:
    program = program_of(name)

    found = measure(program, {"c": build(emit(program, "c", real))}, real=real)

    assert [one.passed for one in found] == [True]


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize("largest", [2, pytest.param(6, marks=pytest.mark.slow)])
def test_held_points_are_solved_by_minors_and_by_normal_equations(largest: int, monkeypatch: Any) -> None:
    for module in (dense, reduced_rows):
        monkeypatch.setattr(module, "CRAMER", largest)
    equations = formulate(held(), [FREE, MULTIPLIERS])
    program = lower(equations)

    _, proofs = prove(program_claims(program.scene, equations.functions, program), seed=1)
    found = measure(program, {"c": build(emit(program, "c"))})

    assert [one.verdict for one in proofs] == ["proved"] * 4
    assert all(f"{name}_solved(r)" in text_of(program) for name in (FREE, MULTIPLIERS))
    assert [one.passed for one in found] == [True, True]


@pytest.mark.long
def test_forces_are_columns_unless_the_inverse_multiplies() -> None:
    arm, multiplied = (program_of(name).routines[0].function.solve for name in ("arm7", "carried"))

    assert arm is not None
    assert multiplied is not None
    assert (arm.width, multiplied.width) == (3 * 7, 2 * 8)
    assert {entry for row in arm.beside for entry in row} == {None}


@pytest.mark.wide("arm7", "carried")
@ALL
@pytest.mark.long
@pytest.mark.runs("cc")
def test_natural_states_are_within_the_bound_too(name: str) -> None:
    program = program_of(name)
    (function,) = (one.function for one in program.routines)
    states = [natural(function, angle, rate) for angle, rate in product((0.0, 0.5, np.pi / 2, np.pi), (0.0, 1.0))]
    exact = reference(function, {key: np.array([s[key] for s in states]) for key in states[0]}, len(states))
    module = getattr(build(emit(program, "c")), FDD)

    computed = np.array([module(*(state[a.name].reshape(a.shape) for a in function.arguments)) for state in states])

    assert len(exact.kept) >= len(states) / 2
    assert (exact.errors(computed.reshape(len(states), -1)) <= exact.bound).all()


def natural(function: Any, angle: float, rate: float) -> dict[str, Any]:
    """Return a state at rest or in motion, all its angles equal; quaternions stand upright."""
    state = {}
    for one in function.arguments:
        values = np.full(len(one.symbols), {"q": angle, "qd": rate, "tau": rate}.get(one.name, 0.3))
        for k in quaternion_places(one.units) if one.name == "q" else ():
            values[k : k + 4] = 1, 0, 0, 0
        state[one.name] = values
    return state


@pytest.mark.wide("-arm7", "batch-carried")
@FEW
@pytest.mark.long
@pytest.mark.parametrize("option", ["", "batch", "header-only"])
def test_the_text_is_proved_and_a_wrong_place_is_told(name: str, option: str) -> None:
    sources = emit(program_of(name), "c", option=option)
    files = files_of(sources)
    wanted = printed(sources.program, "double", loops=True)
    source = next(file for file, text in sources.texts.items() if "_solved(r)" in text)
    table = sources.texts[source].split("_steps[")[1].split("{")[1].split("}")[0]
    numbers = table.split(", ")
    numbers[4], numbers[1] = numbers[1], numbers[4]  # a scale for a factor, or a row for another one

    good = prove_texts(wanted, files, languages("c", option))
    wrong = {**files.contents, source: sources.texts[source].replace(table, ", ".join(numbers))}
    bad = prove_texts(wanted, replace(files, contents=wrong), languages("c", option))

    assert {one.passed for one in good} == {True}
    assert {one.file for one in bad if not one.passed} == {source}


@pytest.mark.long
@pytest.mark.runs("cc")
def test_half_of_a_hessian_is_added_to_itself_turned() -> None:
    scene = jointed("free", "revolute")  # whose directions do not commute
    equations = formulate(scene, [BENT])
    program = lower(equations)
    sources = emit(program, "c")
    files, wanted = files_of(sources), printed(program, "double", loops=True)
    source = next(file for file, text in sources.texts.items() if "_turned[" in text)
    table = sources.texts[source].split("_turned[")[1].split("{")[1].split("}")[0]
    size, first, *rest = table.split(", ")
    wrong = {**files.contents, source: sources.texts[source].replace(table, ", ".join((size, rest[1], *rest)))}

    _, claims = prove(program_claims(scene, equations.functions, program), seed=1)
    good = prove_texts(wanted, files, languages("c", ""))
    bad = prove_texts(wanted, replace(files, contents=wrong), languages("c", ""))

    assert [one.verdict for one in claims] == ["proved", "proved"]
    assert {one.passed for one in good} == {True}
    assert first != rest[1]
    assert {one.file for one in bad if not one.passed} == {source}
    assert [one.passed for one in measure(program, {"c": build(sources)})] == [True]


@pytest.mark.long
def test_other_languages_hold_the_bytes_that_they_held() -> None:
    program = program_of("arm7")
    (routine,) = program.routines
    assert routine.function.solve is not None
    plain = replace(program, routines=(replace(routine, function=replace(routine.function, solve=None)),))

    for name in READERS.keys() - {"c"}:
        if TARGETS[name].functions is None:
            assert emit(program, name).texts == emit(plain, name).texts, name
    assert emit(program, "c", "dd").texts == emit(plain, "c", "dd").texts
    assert emit(program, "c").texts != emit(plain, "c").texts
    assert emit(in_lines(program), "c").texts == emit(plain, "c").texts


def test_models_of_fmi_hold_the_c_that_solves_in_rows() -> None:
    program = program_of("arm7", "forward_dynamics", FDD)
    archive = emit(program, "fmu", command="ours")["arm7_fmi3.fmu"]
    assert isinstance(archive, bytes)
    with ZipFile(BytesIO(archive)) as found:
        held = found.read("sources/arm7.c").decode()

    assert held == emit(program, "c", command="ours")["arm7.c"]
    assert "forward_dynamics_derivatives_solved(r);" in held


@pytest.mark.long
def test_large_functions_in_lines_are_told_where_c_has_a_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(generate, "LARGE", 500)
    given = str(EXAMPLES / "arm7.toml"), "--functions", f"{FDD},forward_dynamics", "-o", str(tmp_path), "--target"
    for target in ("cpp", "c"):
        assert main(["generate", *given, target]) == 0
        told = f"arm7: {FDD} is in lines; C ends it with a loop" in capsys.readouterr().err
        assert told == (target == "cpp")


@pytest.mark.long
def test_short_ones_and_what_is_no_solution_stay_in_lines() -> None:
    puma = lower(formulate(symdyn.example("puma560"), [FDD]))
    by_tau = program_of("arm7", BY_TAU)

    assert puma.routines[0].function.solve is not None
    assert "_solved" not in text_of(puma)
    assert by_tau.routines[0].function.solve is None
    assert program_of("quadruped", BY_TAU).routines[0].function.solve is None
    assert "_solved(r)" in text_of(program_of("quadruped", BY_QD))


@pytest.mark.long
def test_rows_of_zeros_above_all_stay_in_lines_while_these_are_few(monkeypatch: Any) -> None:
    (function,) = formulate(fingers(5), [FDD]).functions
    solve = function.solve
    assert isinstance(solve, RowSolve)
    zero = solve.factors[0].graph.zero
    rows = {k: [zero] * solve.width for k in range(solve.rows)} | {k: list(side) for k, side in solve.sides}
    count = 0
    for step, column in product(solve.steps, range(solve.width)):
        taken = [(factor, rows[row][column]) for factor, row in step.terms]
        count += sum(not (factor * x).is_zero for factor, x in taken)
        rows[step.row][column] = solve.stepped(rows[step.row][column], step.scale, taken)

    assert solve.products == count > 500
    assert solve.dense == 3600
    assert RowLoop.of(function) is None
    monkeypatch.setattr(sys.modules[RowLoop.__module__], "FEWEST_OF_SPARSE", count)
    assert RowLoop.of(function) is not None


@pytest.mark.long
def test_at_rest_and_prepared_stay_in_lines() -> None:
    text = (EXAMPLES / "arm7.toml").read_text("utf-8").replace("mass = 5.76", 'mass = "m"').replace("3.5", '"m/2"')
    equations = formulate(read_text(text + "\n[parameters]\nm = {}\n"), [FDD])

    assert "_solved(r)" in text_of(lower(equations))
    assert "_solved" not in text_of(prepare(lower(equations)))
    assert equations.at_rest().functions[0].solve is None


@pytest.mark.long
@pytest.mark.runs("cc", "gcc")
def test_compilers_without_vectors_by_type_have_a_loop(tmp_path: Path) -> None:
    program = program_of("arm7")
    sources = emit(program, "c")
    (tmp_path / "arm7.h").write_text(sources.texts["arm7.h"])
    plain = sources.texts["arm7.c"].replace("defined(__GNUC__)", "0").replace("defined(__clang__)", "1")
    texts = {**sources.texts, "arm7.c": plain}

    one = getattr(build(sources), FDD)
    other = getattr(build(replace(sources, files=tuple(texts.items()))), FDD)
    q, u, tau = np.random.default_rng(1).uniform(-1, 1, (3, 7))

    assert "column_vec *x" in plain
    assert np.abs(one(q, u, tau) - other(q, u, tau)).max() < 1e-10 * np.abs(one(q, u, tau)).max()


WARNINGS = ["-Wall", "-Wextra", "-Werror", "-pedantic"]


@pytest.mark.long
@pytest.mark.runs("gcc", "g++", "clang")
def test_two_headers_stand_side_by_side_without_a_warning(tmp_path: Path) -> None:
    texts = emit(program_of("arm7", FDD, BENT), "c", option="header-only").texts
    texts |= emit(program_of("carried"), "c", "float", option="header-only").texts
    for file, text in texts.items():
        (tmp_path / file).write_text(text)
    headers = "".join(f'#include "{file}"\n' for file in texts if file.endswith(".h"))
    (tmp_path / "both.c").write_text(headers)
    (tmp_path / "both.cpp").write_text(headers)

    for command in (["gcc", "-std=c99"], ["clang", "-std=c99"], ["g++", "-std=c++17"]):
        file = "both.cpp" if command[0] == "g++" else "both.c"
        subprocess.run([*command, "-O1", *WARNINGS, "-c", file, "-o", "both.o"], cwd=tmp_path, check=True)
