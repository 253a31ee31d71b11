"""Floating-point exceptions and NaN: what headers and docstrings promise, held by the compiled code."""

from __future__ import annotations

import subprocess
import textwrap
from pathlib import Path

import numpy as np
import pytest

from symdyn.emit import emit, write
from symdyn.program import formulate, lower
from symdyn.runtime import build, run_python
from symdyn.runtime.compiler import find_compiler
from symdyn.scene import Scene, body, prismatic, read, revolute, scene

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"

PROMISE = "NaN in any entry that a result depends on makes that result NaN"


def rubbing() -> Scene:
    """Two links with dry friction, an ideal sign in one and a smooth tanh in the other."""
    rod = {"mass": 1, "com": [0, -1, 0], "inertia": ["1/10"] * 3, "about": "com"}
    return scene(
        "rubbing",
        gravity=[0, "-9.81", 0],
        bodies=[body("a", **rod), body("b", **rod)],
        joints=[
            revolute("j1", "ground", "a", friction={"coulomb": 3}),
            revolute("j2", "a", "b", origin=[0, -2, 0], friction={"coulomb": 1, "smoothing": "1/100"}),
        ],
    )


TRAPPED = """
    #define _GNU_SOURCE
    #include <fenv.h>
    #include <math.h>
    #include <stdio.h>
    #include "rubbing.h"

    int main(void)
    {
        double q[2 * 70], qd[2 * 70], qdd[2 * 70], tau[2 * 70];
        const double hard[] = {0.3, NAN, 0.0, -0.0, 1e-150, 1e300};
        feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
        for (int i = 0; i < 5; i++) {
            for (int k = 0; k < 140; k++) {
                q[k] = 0.1 * k, qd[k] = 0.5 - 0.01 * k, qdd[k] = 1.0;
            }
            q[3] = hard[i], qd[5] = hard[i], qdd[7] = hard[i];
            rubbing_inverse_dynamics(q + 2, qd + 4, qdd + 6, tau);
            rubbing_inverse_dynamics_rows(70, q, qd, qdd, tau);
            rubbing_inverse_dynamics_batch(70, q, qd, qdd, tau);
        }
        puts("no trap");
        return 0;
    }
"""


def test_no_trap_is_sprung_by_nan_zeros_and_tiny_numbers(tmp_path: Path) -> None:
    program = lower(formulate(rubbing(), ("inverse_dynamics",)))
    sources = emit(program, "c", option="batch")
    write(sources, tmp_path)
    (tmp_path / "main.c").write_text(textwrap.dedent(TRAPPED))
    compiler = find_compiler()
    command = [*compiler.command, "-O2", "main.c", "rubbing.c", "-o", "trapped", "-lm"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    if "feenableexcept" in made.stderr:
        pytest.skip("this C library cannot enable traps")
    assert made.returncode == 0, made.stderr

    done = subprocess.run([str(tmp_path / "trapped")], capture_output=True, text=True, check=False)

    assert done.returncode == 0
    assert done.stdout == "no trap\n"
    assert "sign_of" in sources["rubbing.c"]


@pytest.mark.parametrize("many", [1, 70])
def test_nan_in_gives_nan_out_in_both_targets(many: int) -> None:
    program = lower(formulate(rubbing(), ("inverse_dynamics",)))
    state = [np.full((many, 2), 0.25) for _ in range(3)]
    for module in (build(program), run_python(emit(program))):
        for argument in range(3):
            spoiled = [x.copy() for x in state]
            spoiled[argument][:, 1] = np.nan
            result = np.squeeze(module.inverse_dynamics(*spoiled))
            assert np.isnan(result).all() or argument == 0
            assert np.isnan(result[..., 1]).all()


def test_every_file_says_so() -> None:
    program = lower(formulate(rubbing(), ("inverse_dynamics", "gravity_forces")))

    for text in (
        emit(program)["rubbing.py"],
        emit(program, "c")["rubbing.h"],
        emit(program, "c", option="batch")["rubbing.h"],
    ):
        assert PROMISE in " ".join(text.replace(" * ", " ").split())


@pytest.mark.wide(2)
@pytest.mark.parametrize("name", ["two_link", "cart_pole", "four_bar", "heavy_top"])
def test_every_function_says_which_nan_it_passes_on_and_does_so(name: str) -> None:
    """What a docstring names spoils the result; what it does not name changes nothing."""
    one = read(EXAMPLES / f"{name}.toml")
    names = ("inverse_dynamics", "forward_dynamics", "mass_matrix", "kinetic_energy", "gravity_forces")
    program = lower(formulate(one, names))
    sources = {"numpy": emit(program, "numpy"), "c": emit(program, "c")}
    modules = {"numpy": run_python(sources["numpy"]), "c": build(program)}
    header = sources["c"][f"{name}.h"]
    rng = np.random.default_rng(3)
    for routine in program.routines:
        function = routine.function
        given = [rng.uniform(0.5, 1.5, a.shape or ()) for a in function.arguments]
        told = [line for line in getattr(modules["numpy"], function.name).__doc__.splitlines() if "A NaN in" in line]
        needed = told[0].split(" makes ")[0].removeprefix("    A NaN in ") if told else ""
        assert not told or told[0].strip() in header
        listed = [word for part in needed.split(", ") for word in part.split(" or ")]
        for way, module in modules.items():
            call = getattr(module, function.name)
            whole = np.asarray(call(*given))
            for k, argument in enumerate(function.arguments):
                for place in range(len(argument.symbols)):
                    spoiled = [np.array(x, float) for x in given]
                    spoiled[k].reshape(-1)[place] = np.nan
                    with np.errstate(all="raise"):
                        result = np.asarray(call(*spoiled))
                    where = (function.name, way, argument.name, place)
                    if any(_holds(word, argument.name, place) for word in listed):
                        assert np.isnan(result).any(), where
                    else:
                        assert np.array_equal(result, whole), where


def _holds(word: str, name: str, place: int) -> bool:
    """Tell whether an entry is in "q", "q[2]" or "q[1:3]"."""
    head, _, rest = word.partition("[")
    first, _, last = rest.rstrip("]").partition(":")
    return head == name and (not rest or int(first) <= place < int(last or int(first) + 1))


def test_an_exponential_that_would_be_denormal_is_zero_and_raises_nothing() -> None:
    one = scene(
        "fading",
        bodies=[body("b", mass=1)],
        joints=[prismatic("j", "ground", "b", axis=[1, 0, 0], coordinate="x", force="exp(x)")],
        units="none",
    )
    for real, exponents in (("double", [-700.0, -707.0, -709.0, -740.0, -1e6]), ("float", [-80.0, -86.0, -88.0, -1e3])):
        module = build(lower(formulate(one, ("forward_dynamics",))), real=real)
        with np.errstate(all="raise"):
            found = [float(module.forward_dynamics([x], [0.0], [0.0])[0]) for x in exponents]
        smallest = np.finfo({"double": np.float64, "float": np.float32}[real]).tiny
        exact = [np.exp(x) if np.exp(x) >= smallest else 0.0 for x in exponents]
        assert found == pytest.approx(exact, rel=1e-6, abs=0)
        assert np.isnan(module.forward_dynamics([np.nan], [0.0], [0.0])).all()


def test_the_stress_case_sees_a_trap() -> None:
    """An infinite angle raises invalid: the flags that the case reads are those of the compiled code."""
    from symdyn.bench.stress import odd_numbers

    real = np.random.default_rng
    cases = list(odd_numbers.traps())
    assert {case.passed for case in cases} == {True}
    assert len(cases) == 12

    class Infinite:
        def __init__(self, seed: int) -> None:
            self.rng = real(seed)

        def uniform(self, low: float, high: float, size: tuple[int, int]) -> np.ndarray:
            return np.full(size, np.inf)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(np.random, "default_rng", Infinite)
        assert not all(case.passed for case in odd_numbers.traps())
