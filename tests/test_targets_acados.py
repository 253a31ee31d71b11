"""The model of acados: its variables, its explicit and implicit equations, and their derivatives, against our own."""

from __future__ import annotations

import importlib
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from symdyn.cli import main
from symdyn.dynamics import derive
from symdyn.runtime import lambdify
from symdyn.runtime.compiler import find_compiler
from symdyn.scene import Scene, read

EXAMPLES = Path(__file__).parent.parent / "examples"

PRESCRIBED = """
name = "led"
[bodies.a]
mass = 1
com = [1, 0, 0]
[joints.turn]
type = "revolute"
parent = "ground"
child = "a"
axis = [0, 1, 0]
motion = "sin(w*t)"
[parameters.w]
unit = "rad/s"
value = 2
"""

CART_WITH_INPUTS = """
name = "blown"
[inputs.wind]
unit = "N"
[bodies.m1]
mass = "m"
[bodies.bob]
mass = 2
com = [0, 0, -1]
[joints.x]
type = "prismatic"
parent = "ground"
child = "m1"
axis = [1, 0, 0]
drive = false
force = "wind"
[joints.u]
type = "revolute"
parent = "m1"
child = "bob"
axis = [0, 1, 0]
damping = "1/10"
[parameters.m]
unit = "kg"
"""


def generated(folder: Path, scene: Path | str, *words: str) -> int:
    return main(["generate", str(scene), "--target", "acados", "-o", str(folder), "--quiet", *words])


def written(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return path


REFUSED = [
    (PRESCRIBED, "depend on time, which acados' explicit integrators do not know"),
    ('name = "still"\n', "nothing moves"),
]


@pytest.mark.parametrize(("text", "told"), REFUSED)
def test_what_acados_does_not_know_is_refused(
    text: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert generated(tmp_path / "out", written(tmp_path, text)) == 1
    assert told in capsys.readouterr().err


def test_our_c_is_refused_where_it_lacks_hessians(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for scene in (written(tmp_path, CART_WITH_INPUTS), *(EXAMPLES / f"{x}.toml" for x in ("four_bar", "free_body"))):
        assert generated(tmp_path / "out", scene, "--external") == 1
        assert "our C has Hessians of open mechanisms" in capsys.readouterr().err


def test_variables_are_told_by_their_names_and_drives_that_there_are(tmp_path: Path) -> None:
    assert generated(tmp_path, written(tmp_path, CART_WITH_INPUTS)) == 0
    text = (tmp_path / "blown_acados.py").read_text(encoding="utf-8")

    assert sorted(path.name for path in tmp_path.glob("*.py")) == ["blown_acados.py", "blown_casadi.py"]
    names = dict(re.findall(r"^([xup])_names = \((.*)\)$", text, re.MULTILINE))
    assert names == {"x": '"q1", "q2", "q1_dot", "q2_dot",', "u": '"tau2", "wind",', "p": '"m",'}
    compile(text, "blown_acados.py", "exec")


# With CasADi

casadis = pytest.mark.targets


def module(folder: Path, scene: Path, monkeypatch: pytest.MonkeyPatch, *words: str) -> ModuleType:
    assert generated(folder, scene, *words) == 0
    monkeypatch.syspath_prepend(str(folder))
    (path,) = folder.glob("*_acados.py")
    monkeypatch.delitem(sys.modules, path.stem, raising=False)
    return importlib.import_module(path.stem)


def values_of(model: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return numbers for the variables."""
    rng = np.random.default_rng(4)
    return {name: rng.uniform(0.3, 0.9, model[name].numel()) for name in ("x", "xdot", "u", "p")}


def called(scene: Scene, name: str, known: dict[str, np.ndarray]) -> np.ndarray:
    """Return a function of ours, as NumPy computes it."""
    (function,) = derive(scene, (name,)).functions
    return np.asarray(lambdify(scene, name, "numpy")(*(known[one.name] for one in function.arguments)))


SCENES = ["cart_pole", "puma560", "two_link", "double_pendulum", "quadruped", "free_body", "gripper2", "governor"]


@casadis
@pytest.mark.parametrize("name", [*SCENES, "four_bar", "rolling_disc", "states/servo", "states/dc_motor"])
def test_both_forms_are_the_equations_of_motion(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import casadi

    path = EXAMPLES / f"{name}.toml"
    scene, made = read(path), module(tmp_path, path, monkeypatch)
    model = made.expressions()
    given = values_of(model)
    symbols = [model[one] for one in given]
    both = casadi.Function("both", symbols, [model["f_expl_expr"], model["f_impl_expr"]])
    numbers = [*given.values()]

    nq, nv = len(scene.coordinates), len(scene.velocities)
    x, u = given["x"], given["u"]
    drives = [k for k, one in enumerate(scene.drives) if one]
    known = {"q": x[:nq], "qd": x[nq : nq + nv], "tau": np.zeros(nv), "inputs": u[len(drives) :]}
    known |= {"internal": x[nq + nv :], "params": given["p"]}
    known["tau"][drives] = u[: len(drives)]
    if scene.states:
        wanted = called(scene, "state_rates", known)
    else:
        rates = called(scene, "coordinate_rates", known) if nq != nv else known["qd"]
        wanted = np.concatenate([rates, called(scene, "forward_dynamics", known)])

    explicit, _ = both(*numbers)
    np.testing.assert_allclose(explicit.full()[:, 0], wanted, rtol=1e-11, atol=1e-11)
    _, zero = both(x, wanted, u, given["p"])  # what moves as it must leaves nothing
    assert np.abs(zero.full()).max() <= 1e-9 * (1 + np.abs(wanted).max())
    _, more = both(*numbers)
    assert np.abs(more.full()).max() > 1e-3  # what does not, does


def sensitivities(model: dict[str, Any], form: str, kind: Any) -> list[np.ndarray]:
    """Return J, wᵀ J and the derivatives of that of a form."""
    import casadi

    f, moved = model[form], casadi.vertcat(model["x"], model["xdot"], model["u"])
    weights = kind.sym("w", f.numel())
    adjoint = casadi.jtimes(f, moved, weights, True)
    symbols = [*(model[one] for one in ("x", "xdot", "u", "p")), weights]
    asked = [casadi.jacobian(f, moved), adjoint, casadi.jacobian(adjoint, moved)]
    numbers = [*values_of(model).values(), np.random.default_rng(5).normal(size=f.numel())]
    return [one.full() for one in casadi.Function("f", symbols, asked)(*numbers)]


@casadis
@pytest.mark.parametrize("name", ["cart_pole", "two_link", "puma560", "free_body"])
@pytest.mark.parametrize("form", ["f_expl_expr", "f_impl_expr"])
def test_sensitivities_as_acados_asks_for_them_are_those_of_all_lines_differentiated(
    name: str, form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With MX by our Jacobians; with SX by CasADi, which sees every line."""
    import casadi

    made = module(tmp_path, EXAMPLES / f"{name}.toml", monkeypatch)
    found = [sensitivities(made.expressions(kind.sym), form, kind) for kind in (casadi.MX, casadi.SX)]
    if name != "free_body":
        assert "jac_" in str(casadi.jacobian((model := made.expressions())[form], model["x"]))
    for ours, casadis in zip(*found, strict=True):
        np.testing.assert_allclose(ours, casadis, rtol=1e-9, atol=1e-9 * max(1, np.abs(casadis).max()))
    assert np.abs(found[0][2]).max() > 1e-3


@casadis
@pytest.mark.runs("cc")
def test_our_c_has_the_same_sensitivities_and_a_process_takes_one_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import casadi

    plain = module(tmp_path / "plain", EXAMPLES / "puma560.toml", monkeypatch)
    made = module(tmp_path / "c", EXAMPLES / "puma560.toml", monkeypatch, "--external")
    library = shared_library(tmp_path / "c" / "puma560_external.c")
    for form in ("f_expl_expr", "f_impl_expr"):
        ours = sensitivities(made.expressions(str(library)), form, casadi.MX)
        for one, other in zip(ours, sensitivities(plain.expressions(casadi.SX.sym), form, casadi.SX), strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * max(1, np.abs(other).max()))
    another = module(tmp_path / "d", EXAMPLES / "cart_pole.toml", monkeypatch, "--external")
    with pytest.raises(ImportError, match="the functions of another model; take a process for each"):
        another.filled(SimpleNamespace(), str(shared_library(tmp_path / "d" / "cart_pole_external.c")))


def shared_library(source: Path) -> Path:
    made = source.with_suffix(".so")
    subprocess.run([*find_compiler().command, "-O1", "-shared", "-fPIC", source, "-o", made, "-lm"], check=True)
    return made


@casadis
def test_an_input_and_a_parameter_act_and_what_is_prepared_is_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import casadi

    path = written(tmp_path, CART_WITH_INPUTS)
    plain = module(tmp_path / "plain", path, monkeypatch).expressions()
    monkeypatch.delitem(sys.modules, "blown_casadi")
    ready = module(tmp_path / "ready", path, monkeypatch, "--prepare").expressions()
    x, u, p = [0.1, 0.2, 0.3, 0.4], [1.5, 2.5], [3.0]
    f = [casadi.Function("f", [m["x"], m["u"], m["p"]], [m["f_expl_expr"]]) for m in (plain, ready)]

    first = f[0](x, u, p).full()
    np.testing.assert_allclose(f[1](x, u, p).full(), first, rtol=1e-12)
    assert np.abs(f[0](x, [1.5, 3.5], p).full() - first)[2] > 0.1
    assert np.abs(f[0](x, u, [4.0]).full() - first)[2] > 1e-3


@casadis
def test_a_model_of_acados_is_filled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = module(tmp_path, EXAMPLES / "cart_pole.toml", monkeypatch).filled(SimpleNamespace())

    assert model.name == "cart_pole"
    assert (model.x.numel(), model.u.numel(), model.p.numel()) == (4, 1, 0)
    assert model.f_expl_expr.shape == model.f_impl_expr.shape == model.xdot.shape == (4, 1)
