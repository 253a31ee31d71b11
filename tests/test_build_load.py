"""symdyn.load: a scene's functions ready to call, here and in other processes, with a compiler or without."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import sysconfig
import warnings
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import numpy as np
import pytest
from mechanisms import random_tree

import symdyn
import symdyn.runtime.compiler as compiler_room
from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.errors import BuildError, DerivationError, SceneError, UnknownNameError
from symdyn.program import lower
from symdyn.runtime.cache import warn_once
from symdyn.runtime.compiler import find_compiler
from symdyn.runtime.library import build_extension

pytestmark = [pytest.mark.runs("cc"), pytest.mark.usefixtures("optimised")]

ARM = Path(__file__).parent.parent / "examples" / "two_link.toml"
STATE = ([0.3, 0.5], [1.0, -2.0], [0.7, 1.1])
PARAMS = [1.0, 1.0, 1.0, 1.0, 9.81]
TORQUE = [18.22932611, 9.93099658]


@pytest.fixture(scope="module")
def arm():
    return symdyn.load(ARM)


@pytest.fixture
def no_compiler(monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(compiler_room.shutil, "which", lambda name: None)
    monkeypatch.setattr(compiler_room, "find_spec", lambda name: None)
    warn_once.cache_clear()
    yield
    warn_once.cache_clear()


def test_a_file_gives_its_functions(arm):
    assert arm.compiled
    np.testing.assert_allclose(arm.inverse_dynamics(*STATE, PARAMS), TORQUE, rtol=1e-9)
    tau = arm.inverse_dynamics(*STATE, PARAMS)
    np.testing.assert_allclose(arm.forward_dynamics(*STATE[:2], tau, PARAMS), STATE[2], rtol=1e-12)


def test_functions_are_found_by_name_and_as_they_were_asked_for(arm):
    assert arm["pose:tool"] is arm.pose_tool
    assert arm["mass_matrix"] is arm.mass_matrix
    with pytest.raises(KeyError, match="k_C"):
        _ = arm["k_C"]
    with pytest.raises(AttributeError, match=r"no function 'k_C'; there are inverse_dynamics, .*functions=…"):
        _ = arm.k_C


def test_it_tells_what_is_in_it(arm):
    assert "pose:tool" in arm
    assert "pose_tool" in arm
    assert "nothing" not in arm
    assert 3 not in arm
    assert list(arm) == list(arm.signatures)
    with pytest.raises(UnknownNameError):
        arm[3]


def test_signatures_and_docstrings_tell_shapes_and_units(arm):
    assert arm.signatures["mass_matrix"] == "mass_matrix(q, params) -> M: (2),(5)->(2,2)"
    assert "shape (..., 2, 2); kg m^2" in arm.mass_matrix.__doc__
    assert repr(arm).splitlines()[0] == "<two_link, compiled:"
    assert repr(arm).splitlines()[-1] == f"    ... ({len(arm.calls)} in all)>"
    assert arm.signatures["pose_tool"] == "pose_tool(q, params) -> T: (2),(5)->(3,4)"


def test_large_coefficients_are_compiled_when_they_are_asked_for(arm):
    assert not any(name.startswith("k_") or name == "coriolis_matrix" for name in arm.calls)
    asked = symdyn.load(symdyn.read(ARM), ["k_C", "coriolis_matrix", "k_C"])
    assert list(asked.calls) == ["k_C", "coriolis_matrix"]
    assert asked.k_C([0.3, 0.5], PARAMS).shape == (2, 1)


def test_bound_parameters_are_no_operands(arm):
    bound = symdyn.load(ARM, ["inverse_dynamics"], parameters=dict(zip(("m1", "m2", "h1", "h2"), PARAMS, strict=False)))
    assert bound.signatures["inverse_dynamics"].endswith("(2),(2),(2),(1)->(2)")
    np.testing.assert_allclose(bound.inverse_dynamics(*STATE, [9.81]), TORQUE, rtol=1e-9)
    with pytest.raises(SceneError, match="m9"):
        symdyn.load(ARM, parameters={"m9": 1})


def test_a_result_without_entries_is_there_as_well():
    scene = random_tree(1, 1, False)
    loaded = symdyn.load(scene, ["k_C", "mass_matrix"])
    assert loaded.compiled
    assert loaded.k_C(np.zeros((4, 1))).shape == (4, 1, 0)
    assert loaded.mass_matrix(np.zeros((4, 1))).shape == (4, 1, 1)


def test_an_unknown_function_is_named():
    with pytest.raises(DerivationError, match="inverse_dynamcs"):
        symdyn.load(ARM, ["inverse_dynamcs"])


@pytest.mark.parametrize(
    "request_",
    [
        *(pytest.param(one, marks=pytest.mark.mends("30.robots.6")) for one in ("jacobian:tol:local", "pose:elbow")),
        "inverse_dynamics_jvp:tool",
    ],
)
def test_a_place_that_is_not_there_is_refused_when_it_is_asked_for(request_):
    with pytest.raises(DerivationError, match=r"there is no body or point|is about the whole scene"):
        symdyn.load(ARM, [request_])


READ = """
import pickle, sys
arm = pickle.load(sys.stdin.buffer)
print(arm.compiled, *arm.calls, *arm.inverse_dynamics([0.3, 0.5], [1.0, -2.0], [0.7, 1.1], [1, 1, 1, 1, 9.81]).round(8))
"""


def test_it_pickles_into_another_process(arm):
    once = symdyn.load(ARM, ["inverse_dynamics", "pose:tool"])
    environment = {**os.environ, "PYTHONPATH": str(Path(symdyn.__file__).parent.parent)}
    ran = subprocess.run(
        [sys.executable, "-c", READ], input=pickle.dumps(once), env=environment, capture_output=True, check=True
    )
    assert ran.stdout.decode().split() == ["True", "inverse_dynamics", "pose_tool", *map(str, TORQUE)]


def test_a_pickle_keeps_bound_parameters():
    bound = symdyn.load(ARM, ["potential_energy"], parameters={"m1": "2.5"})
    again = pickle.loads(pickle.dumps(bound))
    assert again.signatures == bound.signatures
    assert again.scene == bound.scene


def test_a_pickle_keeps_compiler_machine_and_prepared_parameters():
    words = find_compiler().command[0]
    once = symdyn.load(ARM, "inverse_dynamics", compiler=words, machine="portable", prepare=True)
    again = pickle.loads(pickle.dumps(once))
    assert (again.compiler, again.machine, again.prepared) == (words, "portable", True)
    assert again.signatures == once.signatures


def test_a_string_is_one_function():
    assert list(symdyn.load(ARM, "mass_matrix").calls) == ["mass_matrix"]


def test_what_was_asked_for_and_is_not_there_is_an_error_and_no_slow_module(monkeypatch):
    with pytest.raises(BuildError, match="machine 'protable' is not known"):
        symdyn.load(ARM, "mass_matrix", machine="protable")
    with pytest.raises(BuildError, match="compiler = gccc: there is no such program"):
        symdyn.load(ARM, "mass_matrix", compiler="gccc")
    monkeypatch.setenv("CC", "no-such-cc")
    with pytest.raises(BuildError, match="CC = no-such-cc: there is no such program"):
        symdyn.load(ARM, "mass_matrix")


def test_extensions_are_named_without_asking_sysconfig(monkeypatch):
    # Threads that ask it first at the same time may be told None.
    monkeypatch.setattr(sysconfig, "get_config_var", lambda name: None)
    monkeypatch.setattr(sysconfig, "get_path", lambda name: None)
    path, _ = build_extension(emit(lower(derive(symdyn.read(ARM), ["gravity_forces"])), "ufunc"))
    assert path.name.endswith(EXTENSION_SUFFIXES[0])


def test_without_a_compiler_the_numpy_module_steps_in_and_says_so_once(no_compiler):
    with pytest.warns(RuntimeWarning, match=r"(?s)no C compiler found.*functions are those of the NumPy module"):
        plain = symdyn.load(ARM)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = symdyn.load(ARM, ["mass_matrix"])
    assert not plain.compiled
    assert not again.compiled
    assert repr(again).startswith("<two_link, NumPy:")
    np.testing.assert_allclose(plain.inverse_dynamics(*STATE, PARAMS), TORQUE, rtol=1e-9)
    assert again.mass_matrix(np.zeros((3, 2)), PARAMS, out=np.empty((3, 2, 2))).shape == (3, 2, 2)
    assert plain["pose:tool"] is plain.pose_tool


def test_both_ways_take_the_same_calls(arm, no_compiler):
    with pytest.warns(RuntimeWarning, match="NumPy module"):
        plain = symdyn.load(ARM)
    rng = np.random.default_rng(0)
    lengths = {"params": 5}
    for name, signature in arm.signatures.items():
        assert plain.signatures[name] == signature
        names = signature.split("(")[1].split(")")[0].split(", ")
        args = [rng.uniform(0.5, 1.0, (6, lengths.get(n, 2))) for n in names]
        np.testing.assert_allclose(arm.calls[name](*args), plain.calls[name](*args), rtol=1e-12, atol=1e-14)
