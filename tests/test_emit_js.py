"""The JavaScript target in Node.js: as accurate as its numbers allow, strict about lengths, a module and a script."""

from __future__ import annotations

import gc
import json
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from formulas import every_op, states

from symdyn.dynamics import derive
from symdyn.emit import emit, write
from symdyn.errors import BuildError, EmitError
from symdyn.program import formulate, lower, prepare
from symdyn.runtime.machine import find_node, run_js
from symdyn.scene import Scene, read, read_text
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


def ran(code: str, folder: Path) -> str:
    """Return what a module that Node.js runs in a folder prints."""
    command = [find_node(), "--input-type=module", "--eval", code]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout.strip()


def test_every_operation_is_as_accurate_as_doubles_allow() -> None:
    program = lower(every_op())
    found = measure(program, {"js": run_js(emit(program, "js"))}, states=40)

    assert {a.function for a in found} == {"matrix", "scalar", "nothing", "chosen", "rotated"}
    assert {a.passed for a in found} == {True}, found


def test_an_error_in_the_text_is_measured() -> None:
    program = lower(every_op())
    sources = emit(program, "js")
    text = sources.files[0][1].replace("Math.tanh(", "Math.sinh(")
    assert text != sources.files[0][1]
    wrong = replace(sources, files=((sources.files[0][0], text), *sources.files[1:]))

    assert [a.function for a in measure(program, {"js": run_js(wrong)}) if not a.passed] == ["matrix"]


def test_time_is_a_number_where_a_function_depends_on_it() -> None:
    program = lower(derive(read_text(DRIVEN, "driven.toml"), ("forward_dynamics", "prescribed_motion", "drive_forces")))
    module = run_js(emit(program, "js"))

    assert {a.passed for a in measure(program, {"js": module})} == {True}
    place = module.prescribed_motion(0.3, [1.0])
    np.testing.assert_allclose(place, [[np.sin(0.9) / 5], [0.6 * np.cos(0.9)], [-1.8 * np.sin(0.9)]], rtol=1e-15)


def test_functions_after_prepare_take_what_it_returns() -> None:
    equations = formulate(read(ROOT / "examples" / "two_link.toml"), ("inverse_dynamics",))
    plain, prepared = (run_js(emit(program, "js")) for program in (lower(equations), prepare(lower(equations))))
    q, qd, qdd, params = (np.linspace(0.3, 1.1, k) for k in (2, 2, 2, 5))

    found = prepared.inverse_dynamics(q, qd, qdd, prepared.prepare(params))
    np.testing.assert_allclose(found, plain.inverse_dynamics(q, qd, qdd, params), rtol=1e-14)


def test_a_result_without_entries_is_an_empty_array() -> None:
    module = run_js(emit(lower(every_op()), "js"))

    assert module.empty(*(array[0] for array in states(every_op(), "empty"))).shape == (1, 0)


def test_nan_goes_in_and_comes_out() -> None:
    module = run_js(emit(lower(every_op()), "js"))

    assert np.isnan(module.matrix([0.1, 0.2], [np.nan, 0.3], [1.0])[[0, 0, 1, 1], [0, 1, 0, 2]]).all()


@pytest.mark.wide(2)
@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("matrix([1], [1, 2], [1])", "RangeError: matrix: q has length 1; give an array of 2 numbers"),
        ("matrix([1, 2], [1, 2, 3], [1])", "RangeError: matrix: qd has length 3; give an array of 2 numbers"),
        ("matrix([1, 2], [1, 2], [])", "RangeError: matrix: params has length 0; give an array of 1 number"),
        ("matrix([1, 2], [1, 2])", "TypeError: matrix: params is of type undefined; give an array of 1 number"),
        ("matrix(null, [1, 2], [1])", "TypeError: matrix: q is null; give an array of 2 numbers"),
        ("matrix('ab', [1, 2], [1])", "TypeError: matrix: q is of type string; give an array of 2 numbers"),
        ("matrix(['1', 2], [1, 2], [1])", "TypeError: matrix: q[0] is of type string; give an array of 2 numbers"),
        ("matrix([1, 2], [1, 2], [1], [1])", "RangeError: matrix: out has length 1; give an array of 6 numbers"),
    ],
)
def test_wrong_arguments_throw_an_error_that_says_what_is_right(call: str, message: str, tmp_path: Path) -> None:
    write(emit(lower(every_op()), "js"), tmp_path)
    code = f'import {{ matrix }} from "./every_op.mjs"; try {{ {call} }} catch (e) {{ console.log(String(e)); }}'

    assert ran(code, tmp_path) == message


def test_time_must_be_a_number(tmp_path: Path) -> None:
    write(emit(lower(derive(read_text(DRIVEN, "driven.toml"), ("prescribed_motion",))), "js"), tmp_path)
    code = (
        'import * as f from "./driven.mjs"; try { f.prescribed_motion([1], [1]) } catch (e) { console.log(String(e)); }'
    )

    assert ran(code, tmp_path) == "TypeError: prescribed_motion: t is of type object; give a number"


def test_the_output_may_be_one_of_the_inputs_and_typed_arrays_are_arrays(tmp_path: Path) -> None:
    write(emit(lower(every_op()), "js"), tmp_path)
    code = """
    import { rotated } from "./every_op.mjs";
    const q = Float64Array.of(0.25, 0.5), given = [Float32Array.of(1, 2), new Float64Array(1)];
    const wanted = [...rotated([0.25, 0.5], [1, 2], [0])];
    console.log(JSON.stringify([wanted, [...rotated(q, ...given, q)], [...q]]));
    """
    wanted, returned, place = json.loads(ran(code, tmp_path))

    assert wanted == returned == place


def test_the_script_gives_the_functions_of_the_module(tmp_path: Path) -> None:
    write(emit(lower(every_op("new-top")), "js"), tmp_path)
    code = """
    import vm from "node:vm";
    import fs from "node:fs";
    import * as module from "./new_top.mjs";
    const context = vm.createContext({});
    vm.runInContext(fs.readFileSync("new_top.js", "utf8"), context);
    const calls = vm.runInContext("symdyn.new_top", context);
    const same = JSON.stringify([...calls.matrix([1, 2], [3, 4], [5])]);
    console.log(same === JSON.stringify([...module.matrix([1, 2], [3, 4], [5])]), Object.keys(context).join());
    console.log(Object.keys(calls).sort().join() === Object.keys(module).sort().join());
    """

    assert ran(code, tmp_path).split() == ["true", "symdyn", "true"]


def test_no_text_of_a_scene_ends_a_comment(tmp_path: Path) -> None:
    equations = every_op()
    name = "*/ throw 1; /* <!--"
    parameters = (
        replace(equations.scene.parameters[0], text="*/ throw 1; /*\n--> `${1}`"),
        equations.scene.parameters[1],
    )
    equations = replace(equations, scene=Scene(name, parameters))
    module = run_js(emit(lower(equations), "js"))

    assert module.scalar([0, 0], [2, 3], [10]) == 21


def test_node_ends_with_the_module(young: None) -> None:
    module = run_js(emit(lower(every_op()), "js"))
    process = module.matrix.__closure__
    assert process is not None
    running = next(cell.cell_contents._process for cell in process if hasattr(cell.cell_contents, "_process"))
    assert running.poll() is None
    del module, process
    gc.collect()
    assert running.poll() == 0


def test_what_node_refuses_is_told_in_its_words() -> None:
    sources = emit(lower(every_op()), "js")
    broken = replace(sources, files=(("every_op.mjs", "const a = ;"),))

    with pytest.raises(BuildError, match=r"Node\.js refused the code: SyntaxError: Unexpected token"):
        run_js(broken)
    with pytest.raises(BuildError, match="sources of target 'numpy' are not of target 'js'"):
        run_js(emit(lower(every_op())))


def test_floats_and_batches_are_refused() -> None:
    with pytest.raises(
        EmitError, match=r"real type 'float': target js .JavaScript, which computes in doubles, .* takes double alone"
    ):
        emit(lower(every_op()), "js", "float")
    with pytest.raises(
        EmitError, match=r"target js .JavaScript, .* one state a call. has no option batch; leave it out"
    ):
        emit(lower(every_op()), "js", option="batch")


SCRIPTS = [path for path in sorted((ROOT / "templates").rglob("*.*js")) if path.suffix in (".js", ".mjs")]

READ = """const { readFileSync } = require("node:fs"), { wrap } = require("node:module"), vm = require("node:vm");
for (const filename of process.argv.slice(1)) new vm.Script(wrap(readFileSync(filename, "utf8")), { filename });"""


def test_every_script_of_ours_is_javascript_as_it_stands() -> None:
    """One process reads all but the modules."""
    modules = [path for path in SCRIPTS if re.search(r"^(import|export) ", path.read_text(encoding="utf-8"), re.M)]
    plain = [path for path in SCRIPTS if path not in modules]
    assert len(plain) > len(modules) > 0
    for words in (["-e", READ, *map(str, plain)], *(["--check", str(path)] for path in modules)):
        read = subprocess.run([find_node(), *words], capture_output=True, text=True, check=False)
        assert read.stderr == ""
