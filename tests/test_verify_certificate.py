"""The certificate sees what is wrong: in derivations, in programs, in built code."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mechanisms import random_tree

from symdyn.cli import main
from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.errors import DerivationError
from symdyn.program import lower
from symdyn.runtime import run_python
from symdyn.scene import read, read_text
from symdyn.verdict import Verdict
from symdyn.verify import certify, measure

pytestmark = [pytest.mark.runs(), pytest.mark.usefixtures("optimised")]

MODULES = {"numpy", "c", "ufunc", *(["js"] if shutil.which("node") else [])}
EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.toml"))


SLOW = ("bicycle",)  # two wheels, whose roots are looked at with all their signs; a part of it is proved in every run


@pytest.mark.wide("free_body", "rsup")
@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=pytest.mark.slow if path.stem in SLOW else ()) for path in EXAMPLES],
    ids=lambda path: path.stem,
)
def test_every_example_passes_with_every_output(path: Path) -> None:
    certificate = certify(read(path))

    assert certificate.passed, [f for f in certificate.findings if f.verdict == Verdict.DIFFERENT]
    unsure = [f.claim for f in certificate.findings if f.verdict != Verdict.PROVED]
    told = [claim for claim in unsure if not claim.startswith(("mass matrix: positive definite", "positions"))]
    assert [claim for claim in told if not claim.endswith("in numbers")] == []  # closed mechanisms at natural positions
    assert {a.module for a in certificate.accuracy} == MODULES
    json.dumps(certificate.as_dict())


@pytest.mark.usefixtures("numpy_alone")
def test_what_two_wheels_do_is_proved() -> None:
    """The axis of the rear one has the root of a square, cos² of the lean, above its plane."""
    certificate = certify(read(EXAMPLES[0].parent / "bicycle.toml"), ("forward_dynamics", "constraint_jacobian"))
    proved = {f.claim for f in certificate.findings if f.verdict == Verdict.PROVED}

    assert certificate.passed
    assert "forward_dynamics: crba = lagrange" in proved
    assert "constraint_jacobian: recursive = differentiation" in proved


@pytest.mark.wide("1")
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("seed", range(3))
def test_random_trees_with_oblique_axes_and_odd_angles_pass(seed: int) -> None:
    certificate = certify(random_tree(seed, 3), ("inverse_dynamics", "forward_dynamics", "mass_matrix", "k_C"))

    assert certificate.passed
    assert max(f.error_log10 for f in certificate.findings if f.verdict == Verdict.PROVED) < -40


@pytest.mark.usefixtures("numpy_alone")
def test_the_same_seed_gives_the_same_certificate() -> None:
    scene = random_tree(3, 3)

    assert certify(scene, ("mass_matrix",), seed=5) == certify(scene, ("mass_matrix",), seed=5)
    assert certify(scene, ("mass_matrix",), seed=5).fields != certify(scene, ("mass_matrix",), seed=6).fields


@pytest.mark.parametrize("fault", [1e-12, float("nan"), float("inf")])
def test_a_module_that_is_slightly_wrong_fails(fault: float) -> None:
    program = lower(derive(read(EXAMPLES[0]), ("inverse_dynamics",)))
    module = run_python(emit(program))
    wrong = SimpleNamespace(inverse_dynamics=lambda *state: module.inverse_dynamics(*state) * (1 + fault))

    assert {a.passed for a in measure(program, {"numpy": module})} == {True}
    with np.errstate(invalid="ignore"):
        assert {a.passed for a in measure(program, {"numpy": wrong})} == {False}


@pytest.mark.usefixtures("numpy_alone")
def test_a_massless_end_has_no_forward_dynamics_and_the_rest_is_certified() -> None:
    text = """
    [bodies.arm]
    mass = 1
    com = [1, 0, 0]
    [bodies.ghost]
    [joints.a]
    type = "revolute"
    parent = "ground"
    child = "arm"
    axis = [0, 0, 1]
    [joints.b]
    type = "revolute"
    parent = "arm"
    child = "ghost"
    axis = [0, 0, 1]
    """
    scene = read_text(text, "ghost.toml")
    certificate = certify(scene)

    why = [one.why for one in certificate.absent if "forward_dynamics" in one.what]
    assert any("a motion of the joint b, which carries ghost, moves no mass" in one for one in why)
    assert certificate.passed
    assert all(f.verdict == Verdict.PROVED for f in certificate.findings)
    with pytest.raises(DerivationError, match="forward dynamics does not exist"):
        certify(scene, ("forward_dynamics",))


def test_a_compiler_that_refuses_fails_the_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "false")
    certificate = certify(read(EXAMPLES[0]), ("mass_matrix",))

    assert not certificate.passed
    assert "could not compile" in certificate.refused


def test_no_compiler_is_no_claim(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("symdyn.runtime.compiler.find_spec", lambda name: None)
    certificate = certify(read(EXAMPLES[0]), ("mass_matrix",))

    assert certificate.passed
    assert any("no C compiler found" in one.why for one in certificate.not_run)
    assert any(one.what == "the error of JavaScript" and "no Node.js" in one.why for one in certificate.not_run)


@pytest.mark.mends("30.also.verdicts")
def test_where_nothing_that_was_asked_for_runs_it_is_not_shown_and_the_rest_is_looked_at(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", "")
    assert main(["verify", str(EXAMPLES[0]), "--functions", "mass_matrix,forward_dynamics", "--targets", "js"]) == 1

    told = capsys.readouterr().out
    assert "Not shown: the error of JavaScript: no Node.js found" in told
    assert "positive definite" in told
    assert "50 digits" not in told


def test_single_precision_is_measured_with_its_own_yardstick() -> None:
    certificate = certify(read(EXAMPLES[-1]), ("inverse_dynamics", "forward_dynamics"), real="float")

    assert certificate.passed
    assert {a.real for a in certificate.accuracy} == {"float"}


def test_a_wrong_small_entry_beside_a_large_one_fails() -> None:
    text = """
    [bodies.cart]
    mass = 1e6
    [bodies.bob]
    mass = 1e-20
    com = [0, -1, 0]
    [joints.rail]
    type = "prismatic"
    parent = "ground"
    child = "cart"
    axis = [1, 0, 0]
    [joints.pivot]
    type = "revolute"
    parent = "cart"
    child = "bob"
    """
    program = lower(derive(read_text(text, "cart.toml"), ("mass_matrix",)))
    module = run_python(emit(program))
    wrong = SimpleNamespace(mass_matrix=lambda q: module.mass_matrix(q) * [[1, 1], [1, -7]])

    assert {a.passed for a in measure(program, {"numpy": module})} == {True}
    assert {a.passed for a in measure(program, {"numpy": wrong})} == {False}


@pytest.mark.usefixtures("numpy_alone")
def test_parameters_outside_their_range_at_first_are_drawn_again_and_json_stays_json() -> None:
    text = """
    [parameters]
    l = { positive = true }
    [bodies.bob]
    mass = 1
    com = [0, 0, -1]
    [joints.pivot]
    type = "revolute"
    parent = "ground"
    child = "bob"
    axis = [1, 0, 0]
    force = "-2*log(l - 3)*q1_dot"
    """
    certificate = certify(read_text(text, "root.toml"))

    assert certificate.passed
    assert all(a.states for a in certificate.accuracy)
    json.dumps(certificate.as_dict(), allow_nan=False)
