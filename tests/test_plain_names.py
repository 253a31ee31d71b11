"""Coordinates, parameters, drives and springs may be called q, tau, t: code and pages say the same as under others."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.scene import read_text, write_text

NAMES = {
    "x1": "q", "x2": "qd", "m1": "tau", "k1": "params", "h1": "out", "l1": "np", "f1": "qdd", "u1": "qdd_r",
    "spring1": "t", "body1": "t", "joint1": "t", "point1": "q", "load1": "tau",
}  # fmt: skip
"""What generated code calls its own, by what else it may be called."""

SCENE = """
name = "named"
[parameters]
m1 = { value = 2, positive = true }
k1 = { value = 30 }
h1 = {}
l1 = { value = "1/2" }
[inputs]
u1 = { value = 1 }
[bodies]
body1 = { mass = "m1", com = [0, 0, 0] }
arm = { particles = [{ mass = 1, at = ["l1", 0, "h1"] }] }
[joints]
joint1 = { type = "prismatic", parent = "ground", child = "body1", axis = [1, 0, 0], coordinate = "x1", drive = "f1" }
pin = { type = "revolute", parent = "body1", child = "arm", axis = [0, 1, 0], coordinate = "x2", drive = false }
[points.point1]
body = "arm"
at = ["l1", 0, 0]
[springs.spring1]
joint = "joint1"
stiffness = "k1"
[loads.load1]
body = "body1"
force = ["u1*sin(x2)*t", 0, 0]
"""


def renamed(text: str) -> str:
    """Return text in which what is called plainly is called as generated code calls its own."""
    return re.sub(r"[A-Za-z]\w*", lambda found: NAMES.get(found[0], found[0]), text)


@pytest.fixture(scope="module")
def plain() -> symdyn.Scene:
    return read_text(SCENE)


@pytest.fixture(scope="module")
def named() -> symdyn.Scene:
    try:
        return read_text(renamed(SCENE))
    except symdyn.SymdynError as fault:
        pytest.fail(str(fault))


@pytest.mark.mends("30.numbers.6")
def test_what_generated_code_calls_its_own_is_a_name(named: symdyn.Scene) -> None:
    assert (named.coordinates, named.drives, named.elements[0].name) == (("q", "qd"), ("qdd", None), "t")
    assert read_text(write_text(named, "toml").text) == named


@pytest.mark.parametrize("key", ["[parameters]\nt = {}", "[inputs]\nt = {}"])
def test_the_time_is_no_other_letter(key: str) -> None:
    section = key.partition("\n")[0]
    with pytest.raises(symdyn.SymdynError, match=r'"t" is the time in formulas and runs; rename it, such as t_0'):
        read_text(SCENE.replace(section, key))
    with pytest.raises(
        symdyn.SymdynError, match=r'coordinate = "t" is the time in formulas and runs; rename it, such as t_0'
    ):
        read_text(SCENE.replace('coordinate = "x1"', 'coordinate = "t"'))


@pytest.mark.parametrize("name", ["q", "t"])
@pytest.mark.parametrize("old", ["named", "body1", "joint1", "point1", "spring1", "load1"])
def test_what_no_formula_names_may_be_called_so(name: str, old: str) -> None:
    found = read_text(re.sub(rf"\b{old}\b", name, SCENE))
    assert symdyn.dynamics.derive(found, ["pose:t"] if (name, old) == ("t", "point1") else ["inverse_dynamics"])
    assert read_text(write_text(found, "toml").text) == found


REQUESTS = ["inverse_dynamics", "forward_dynamics_derivatives", "kinetic_energy_by_parameters", "pose:body1"]


@pytest.mark.parametrize("request_", REQUESTS)
def test_functions_compute_the_same(request_: str, plain: symdyn.Scene, named: symdyn.Scene) -> None:
    found = []
    for scene, request in ((plain, request_), (named, renamed(request_))):
        equations = symdyn.dynamics.derive(scene, [request])
        function = symdyn.lambdify(scene, request)
        rng = np.random.default_rng(3)
        given = [rng.uniform(0.2, 2, () if one.scalar else len(one.symbols)) for one in equations[request].arguments]
        found.append(function(*given))
    np.testing.assert_array_equal(found[0], found[1])


def test_pages_say_the_same(plain: symdyn.Scene, named: symdyn.Scene) -> None:
    for scene in (plain, named):
        assert symdyn.equations(scene).sympy()["t"].name == "t"
    said, other = (symdyn.equations(scene).text("coefficients") for scene in (plain, named))
    assert renamed_all(said) == other
    one, two = (symdyn.equations(scene).sympy() for scene in (plain, named))
    letters = {one[name]: two[new] for name in one.symbols if (new := renamed_all(name)) in two.symbols}
    assert len(letters) == len(two.symbols)
    assert one.M.subs(letters, simultaneous=True) == two.M
    assert one.c.subs(letters, simultaneous=True) == two.c
    assert one.P.subs(letters, simultaneous=True) == two.P


def renamed_all(text: str) -> str:
    """Return text renamed, rates of coordinates and their coefficients too."""
    words = {f"{old}{end}": f"{new}{end}" for old, new in NAMES.items() for end in ("", "_dot", "_ddot")}
    return re.sub(r"[A-Za-z]\w*", lambda found: words.get(found[0], found[0]), text)


@pytest.mark.slow
@pytest.mark.runs("cc")
def test_runs_are_the_same(plain: symdyn.Scene, named: symdyn.Scene, tmp_path: Path) -> None:
    runs = []
    for scene, force, values in ((plain, "f1", "h1"), (named, "qdd", "out")):
        given = {"until": 0.5, "values": {values: 0.1}, "start": {scene.coordinates[1]: 0.3}}
        run = symdyn.simulate(scene, forces=f"{force}=cos(t)", reports=f"{scene.coordinates[0]} - 0.01", **given)
        run.to_csv(tmp_path / "run.csv")
        again = symdyn.inverse(scene, tmp_path / "run.csv", values={values: 0.1}, times=run.t)
        slopes = symdyn.sensitivity(scene, forces=f"{force}=cos(t)", **given)
        slow = symdyn.linearize(scene, values={values: 0.1}, forces=f"{force}=2", anywhere=True)
        many = symdyn.ensemble(scene, until=0.1, values={values: [0.1, 0.2]}, measures=f"max({scene.coordinates[1]})")
        study = symdyn.sweep(scene, f"{values}=[0.1, 0.2]", f"end({scene.coordinates[0]})", until=0.1)
        found = symdyn.collocation(symdyn.scene.bind(scene, {values: 0.1}), until=1, intervals=2, cost=f"{force}**2")
        parts = [run.table()[1], again.tau, slopes.matrix, slow.A, slow.B, *many.measures.values()]
        runs.append([*parts, *study.measures.values(), found.residual(found.guess), found.gradient(found.guess)])
    for one, other in zip(*runs, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.long
def test_verbs_write_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("plain.toml").write_text(SCENE)
    Path("named.toml").write_text(renamed(SCENE))
    said = []
    for scene, value in (("plain", "h1"), ("named", "out")):
        for line in ("equations --format text", "equations --format text --as matrix", "info --json"):
            verb, _, rest = line.partition(" ")
            assert main([verb, f"{scene}.toml", *rest.split()]) == 0
            said.append(capsys.readouterr().out)
        for file in ("lesson.md", "lesson.html", "lesson.tex", "lesson.ipynb"):
            formulation = ["--bind", f"{value}=0.1"]
            assert main(["walkthrough", f"{scene}.toml", "-o", file, *formulation]) == 0, capsys.readouterr().err
        assert main(["draw", f"{scene}.toml", "-o", "scene.svg", "--bind", f"{value}=0.1"]) == 0
        capsys.readouterr()
    for one, other in zip(said[:2], said[3:5], strict=True):
        assert "".join(renamed_all(one).split()) == "".join(other.split())


def test_what_is_printed_for_sympy_runs(
    named: symdyn.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "named.toml").write_text(renamed(SCENE))
    assert main(["equations", str(tmp_path / "named.toml"), "--format", "sympy", "--as", "matrix"]) == 0
    space: dict[str, Any] = {}
    exec("from sympy import *\n" + capsys.readouterr().out, space)
    told = symdyn.equations(named).sympy()
    assert space["M"] == told.M
    assert space["equation"].lhs == space["M"] * space["qdd_"] + space["c"] + space["g"]


QUICK, ALL = ["numpy", "c"], ["ufunc", "js", "cpp", "rust", "casadi"]


@pytest.mark.long(0)
@pytest.mark.runs("cc")
@pytest.mark.parametrize("target", [*QUICK, *(pytest.param(one, marks=pytest.mark.slow) for one in ALL)])
def test_targets_are_proved_and_measured(target: str, named: symdyn.Scene) -> None:
    found = symdyn.certify(named, ["inverse_dynamics", "forward_dynamics", "pose:t"], targets=[target])
    assert found.passed, str(found)


@pytest.mark.targets
def test_kernels_are_proved_and_measured(named: symdyn.Scene) -> None:
    pytest.importorskip("pyopencl")
    test_targets_are_proved_and_measured("gpu", named)
