"""The WebAssembly target in Node.js and in a browser: what JavaScript computes, one state a call and many."""

from __future__ import annotations

import json
import math
import re
import subprocess
from base64 import b64decode
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import chromium, window
from formulas import every_op, one, states
from mpmath import mp, mpf

from symdyn.build.run_node import find_node, run_js
from symdyn.build.runners import run_python
from symdyn.dynamics import derive
from symdyn.dynamics.roads.named_functions import Equations
from symdyn.emit import emit, write
from symdyn.emit.targets.wasm.binary import BLOCK
from symdyn.emit.targets.wasm.encoding import PLAIN, VECTOR, signed, unsigned
from symdyn.emit.targets.wasm.sincos import CHAINS
from symdyn.errors import EmitError
from symdyn.graph import Graph
from symdyn.program import Program, formulate, lower, prepare
from symdyn.scene import read, read_text
from symdyn.verify import measure

pytestmark = pytest.mark.runs("node")

ROOT = Path(__file__).parent.parent

DRIVEN = """
[parameters]
m = { positive = true }
[bodies.bob]
mass = "m"
com = [0, -1, 0]
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
motion = "sin(3*t)/5"
[bodies.cart]
mass = 2
[joints.pivot]
type = "revolute"
parent = "cart"
child = "bob"
"""

LENGTHS = [*range(2 * CHAINS + 2), *(blocks * BLOCK + more for blocks in (1, 2, 3) for more in (-1, 0, 1))]

CALLS = """
import * as module from "./{name}_wasm.mjs";
let text = "";
for await (const chunk of process.stdin) text += chunk;
const answers = JSON.parse(text).map(([name, ...given]) => {{
  try {{ return Array.from(module[name](...given)); }} catch (fault) {{ return String(fault); }}
}});
console.log(JSON.stringify(answers));
"""


def called(program: Program, folder: Path, calls: list[list[Any]]) -> list[Any]:
    """Return what calls of a module with batches answer: lists of numbers, or what was thrown."""
    sources = emit(program, "wasm", option="batch")
    write(sources, folder)
    name = next(iter(sources)).removesuffix("_wasm.mjs")
    command = [find_node(), "--input-type=module", "--eval", CALLS.format(name=name)]
    done = subprocess.run(command, cwd=folder, input=json.dumps(calls), capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def angles(count: int) -> Equations:
    """Return sines and cosines of so many angles."""
    g = Graph()
    q = [g.symbol(f"q{k}") for k in range(1, count + 1)]
    return one([function(x) for x in q for function in (g.sin, g.cos)], q)


@pytest.mark.parametrize("option", ["", "batch"])
def test_every_operation_is_as_accurate_as_doubles_allow(option: str) -> None:
    program = lower(every_op())
    found = measure(program, {"wasm": run_js(emit(program, "wasm", option=option))}, states=40)

    assert {a.function for a in found} == {"matrix", "scalar", "nothing", "rotated"}
    assert {a.passed for a in found} == {True}, found


@pytest.mark.parametrize("scene", ["two_link", "four_bar", "puma560"])
def test_arms_are_as_accurate_as_doubles_allow(scene: str) -> None:
    program = lower(formulate(read(ROOT / "examples" / f"{scene}.toml"), ("inverse_dynamics", "forward_dynamics")))

    assert {a.passed for a in measure(program, {"wasm": run_js(emit(program, "wasm"))})} == {True}


def test_batches_are_right_in_every_length_up_to_three_blocks(tmp_path: Path) -> None:
    program = lower(every_op())
    plain = run_python(emit(program))
    calls, wanted = [], []
    for length in LENGTHS:
        for routine in program.routines:
            *given, params = states(every_op(), routine.function.name, length + 1, seed=length)
            name = routine.function.name
            calls.append([f"{name}_batch", length, *(a[:length].T.ravel().tolist() for a in given), [*params[0]]])
            result = getattr(plain, name)(*(a[:length] for a in given), params[0])
            wanted.append(np.moveaxis(np.reshape(result, (length, -1)) if length else np.empty(0), 0, -1).ravel())
    for call, found, right in zip(calls, called(program, tmp_path, calls), wanted, strict=True):
        np.testing.assert_allclose(found, right, rtol=1e-13, atol=1e-15, err_msg=f"{call[0]} of {call[1]} states")


def test_a_state_of_a_batch_has_the_bits_that_it_has_alone_whatever_stands_beside_it(tmp_path: Path) -> None:
    equations = angles(CHAINS + 2)
    rng = np.random.default_rng(1)
    q = rng.uniform(-4, 4, (CHAINS + 2, 40)) * 10.0 ** rng.integers(-3, 9, (CHAINS + 2, 40))
    calls = [["f_batch", 40, q.ravel().tolist()], *(["f", column.tolist()] for column in q.T)]

    many, *single = called(lower(equations), tmp_path, calls)
    assert np.reshape(many, (-1, 40)).T.tobytes() == np.array(single).tobytes()


def test_sines_and_cosines_are_right_to_one_unit_in_the_last_place(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    near = [math.nextafter(k * math.pi / 2, side) for k in (1, 2, 3, 77, 600_001) for side in (-math.inf, math.inf)]
    tiny = [0.0, -0.0, 5e-324, -1e-310, 2.0**-241, 1e-200]
    large = [2.0**20, math.nextafter(2.0**20, 0), 1e22, -1.7e308]
    q = [*near, *tiny, *large, *rng.uniform(-7, 7, 200), *rng.uniform(-(2**20), 2**20, 200)]
    found = called(lower(angles(1)), tmp_path, [["f", [float(x)]] for x in q])
    with mp.workprec(1200):
        for x, (s, c) in zip(q, found, strict=True):
            for value, right in ((s, mp.sin(mpf(float(x)))), (c, mp.cos(mpf(float(x))))):
                assert abs(mpf(value) - right) <= math.ulp(value), x
    assert np.signbit(run_js(emit(lower(angles(1)), "wasm")).f([-0.0])[0])


def test_what_is_not_finite_gives_nan_and_spoils_no_neighbour() -> None:
    module = run_js(emit(lower(angles(4)), "wasm"))
    found = module.f([math.inf, 0.5, math.nan, 1e7])

    assert np.isnan(found[[0, 1, 4, 5]]).all()
    np.testing.assert_allclose(found[[2, 3, 6, 7]], [f(x) for x in (0.5, 1e7) for f in (math.sin, math.cos)])


def test_functions_after_prepare_take_what_it_returns(tmp_path: Path) -> None:
    equations = formulate(read(ROOT / "examples" / "two_link.toml"), ("inverse_dynamics",))
    params, q, qd, qdd = (np.linspace(0.3, 1.1, k).tolist() for k in (5, 6, 6, 6))
    ((first,), (plain,)) = (
        called(prepare(lower(equations)), tmp_path, [["prepare", params]]),
        called(lower(equations), tmp_path, [["inverse_dynamics_batch", 3, q, qd, qdd, params]]),
    )
    (found,) = called(prepare(lower(equations)), tmp_path, [["inverse_dynamics_batch", 3, q, qd, qdd, first]])

    np.testing.assert_allclose(found, plain, rtol=1e-14)


def test_time_differs_from_state_to_state(tmp_path: Path) -> None:
    program = lower(derive(read_text(DRIVEN, "driven.toml"), ("forward_dynamics",)))
    arguments = program.routines[0].function.arguments
    *given, params = [np.linspace(0.2, 1.1, 3 * len(a.symbols)).reshape(-1, 3) for a in arguments]
    assert sum(a.scalar for a in arguments) == 1
    common = params[:, 0].tolist()
    calls = [["forward_dynamics_batch", 3, *(a.ravel().tolist() for a in given), common]]
    for k in range(3):
        state = [a[0, k] if one.scalar else a[:, k].tolist() for one, a in zip(arguments, given, strict=False)]
        calls.append(["forward_dynamics", *state, common])

    many, *each = called(program, tmp_path, calls)
    assert np.reshape(many, (-1, 3)).T.tolist() == each


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (["matrix", [1], [1, 2], [1]], "RangeError: matrix: q has length 1; give an array of 2 numbers"),
        (["matrix", [1, 2], [1, 2]], "TypeError: matrix: params is of type undefined; give an array of 1 number"),
        (["matrix_batch", 2, [1, 2]], "RangeError: matrix_batch: q has length 2; give an array of 4 numbers"),
        (["matrix_batch", -1], "RangeError: matrix_batch: count is -1; give the number of states"),
        (["matrix_batch", "1"], "RangeError: matrix_batch: count is of type string; give the number of states"),
        (["nothing_batch", 1, [1, 2], [1, 2], [1], [0, 0]], "TypeError: nothing_batch: out is no Float64Array.*"),
    ],
)  # fmt: skip
def test_wrong_arguments_throw_an_error_that_says_what_is_right(call: list[Any], message: str, tmp_path: Path) -> None:
    (found,) = called(lower(every_op()), tmp_path, [call])
    assert re.fullmatch(message, found)


def test_a_name_that_batch_code_has_is_refused() -> None:
    equations = every_op()
    two = equations.functions[1]
    named = [two, type(two)(**{**vars(two), "name": "scalar_batch"})]
    program = lower(Equations(equations.scene, equations.graph, tuple(named)))

    emit(program, "wasm")
    with pytest.raises(EmitError, match="function scalar_batch would be called as scalar for many states is"):
        emit(program, "wasm", option="batch")


def test_the_code_of_both_scripts_is_the_file_that_stands_alone() -> None:
    for option in ("", "batch"):
        sources = emit(lower(every_op()), "wasm", option=option)
        module, script, code = sources.files
        assert (module[0], script[0], code[0]) == ("every_op_wasm.mjs", "every_op_wasm.js", "every_op.wasm")
        for _, text in (module, script):
            found = re.search(r'atob\("([^"]*)"\)', str(text))
            assert found is not None
            assert b64decode(found[1]) == code[1]
        assert b"symdyn generate every op.toml --bind b=0.25 --target wasm" in bytes(code[1])


def test_what_a_browser_opens_from_a_disk_computes_what_node_computes(tmp_path: Path) -> None:
    program = lower(formulate(read(ROOT / "examples" / "arm7.toml"), ("inverse_dynamics",)))
    q, qd, qdd = (np.linspace(-1, 1, 21).reshape(7, 3) + k for k in range(3))
    lists = [a.ravel().tolist() for a in (q, qd, qdd)]
    (wanted,) = called(program, tmp_path, [["inverse_dynamics_batch", 3, *lists]])
    page = tmp_path / "page.html"
    page.write_text('<!doctype html><title>t</title><script src="arm7_wasm.js"></script>', encoding="utf-8")
    with chromium() as browser:
        shown = window(browser)
        shown.goto(page.as_uri())
        found = shown.evaluate("given => Array.from(symdyn.arm7.inverse_dynamics_batch(3, ...given))", lists)

    assert found == wanted


def test_numbers_are_encoded_as_the_specification_says() -> None:
    assert [unsigned(n).hex() for n in (0, 127, 128, 624485)] == ["00", "7f", "8001", "e58e26"]
    assert [signed(n).hex() for n in (0, 63, 64, -1, -64, -123456)] == ["00", "3f", "c000", "7f", "40", "c0bb78"]
    assert len({*PLAIN.values()}) == len(PLAIN)
    assert len({*VECTOR.values()}) == len(VECTOR)
