"""WebAssembly is made of generated C by the line of docs/c.md; who asks for it as a target is told that line."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
from ctypes import CDLL, c_double, c_size_t
from pathlib import Path

import numpy as np
import pytest

from symdyn import certify, example
from symdyn.cli import main
from symdyn.emit import emit
from symdyn.errors import EmitError
from symdyn.program import formulate, lower
from symdyn.runtime.machine import find_node

PAGE = (Path(__file__).parent.parent / "docs" / "c.md").read_text(encoding="utf-8").partition("\n## WebAssembly\n")[2]
GENERATE, COMPILE = (line.strip() for line in PAGE.splitlines() if line.startswith("    "))
STATES = 9
MANY = """
const count = COUNT, many = memory.grow(1) * 65536;
const columns = new Float64Array(memory.buffer, many, 24 * count);
columns.set(COLUMNS);
const at = k => many + 48 * k * count;
instance.exports.puma560_inverse_dynamics_batch(count, at(0), at(1), at(2), at(3));
console.log(JSON.stringify([...columns.slice(18 * count)]));
"""


@pytest.mark.slow
@pytest.mark.runs("node", "cc")
def test_the_line_of_the_page_makes_a_module_with_the_bits_of_c(
    zig: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    program, *words = shlex.split(GENERATE)
    assert (program, main(["new", "--example", "puma560", "--quiet"]), main([*words, "--quiet"])) == ("symdyn", 0, 0)
    program, *words = shlex.split(COMPILE)
    assert program == "zig"
    subprocess.run([*zig, *words], check=True)
    (script,) = re.findall(r"```js\n(.*?)```", PAGE, re.DOTALL)
    given = np.random.default_rng(1).uniform(-3, 3, (18, STATES))
    more = MANY.replace("COUNT", str(STATES)).replace("COLUMNS", json.dumps(given.ravel().tolist()))
    Path("run.mjs").write_text(script + more, encoding="utf-8")
    ran = subprocess.run([find_node(), "run.mjs"], check=True, capture_output=True, text=True)
    tau, columns = (np.array(json.loads(line)) for line in ran.stdout.splitlines())

    subprocess.run([*shlex.split("cc -O2 -ffp-contract=off -fPIC -shared puma560.c -o puma560.so -lm")], check=True)
    library = CDLL(str(tmp_path / "puma560.so"))
    right = (c_double * 6)()
    library.puma560_inverse_dynamics(
        (c_double * 6)(0.1, 0.2, 0.3, 0.4, 0.5, 0.6), (c_double * 6)(), (c_double * 6)(), right
    )
    np.testing.assert_allclose(tau, list(right), rtol=1e-13)
    many = (c_double * (6 * STATES))()
    parts = [(c_double * (6 * STATES))(*part.ravel()) for part in np.split(given, 3)]
    library.puma560_inverse_dynamics_batch(c_size_t(STATES), *parts, many)
    assert columns.tobytes() == bytes(many)


def test_who_asks_for_it_as_a_target_is_told_the_line(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["generate", "arm.toml", "--target", "wasm"])
    said = [" ".join(capsys.readouterr().err.split())]
    for ask in (
        lambda: emit(lower(formulate(example("pendulum"), ("mass_matrix",))), "wasm"),
        lambda: certify(example("pendulum"), ["mass_matrix"], targets=["wasm"]),
    ):
        with pytest.raises(EmitError) as refusal:
            ask()
        said.append(str(refusal.value))
    line = COMPILE.replace("puma560", "NAME").replace("-msimd128 ", "")
    assert [line in one for one in said] == [True] * 3
