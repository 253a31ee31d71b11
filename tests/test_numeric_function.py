"""Functions that `load` and `lambdify` return: values by place and by name, errors that name them, other processes."""

from __future__ import annotations

import inspect
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.errors import ArgumentError, SceneError, UnknownNameError
from symdyn.scene import read_text

pytestmark = pytest.mark.runs("cc")

ROOT = Path(__file__).parent.parent
ARM = ROOT / "examples" / "two_link.toml"
STATE = [0.3, 0.5], [1.0, -2.0], [0.7, 1.1]
NAMED = {"m1": 1, "m2": 2, "h1": 0.5, "h2": 3, "g": 9.81}
PARAMS = list(NAMED.values())


@pytest.fixture(scope="module", params=["load", "c", "numpy"])
def inverse(request):
    """Return inverse dynamics of the two-link arm by every way."""
    if request.param == "load":
        return symdyn.load(ARM, "inverse_dynamics").inverse_dynamics
    return symdyn.lambdify(ARM, "inverse_dynamics", request.param)


def test_values_go_by_name_beside_by_place(inverse):
    expected = inverse(*STATE, PARAMS)

    assert np.array_equal(inverse(*STATE, **NAMED), expected)
    assert np.array_equal(inverse(*STATE, params=PARAMS), expected)
    assert np.array_equal(inverse(STATE[0], qdd=STATE[2], qd=STATE[1], params=PARAMS), expected)
    assert np.array_equal(inverse(q1=0.3, q2=0.5, qd=STATE[1], qdd=STATE[2], **NAMED), expected)


def test_values_by_name_may_be_many(inverse):
    masses = np.linspace(1, 2, 40)
    expected = inverse(*STATE, np.array([[m, *PARAMS[1:]] for m in masses]))

    assert np.array_equal(inverse(*STATE, **{**NAMED, "m1": masses}), expected)


def test_results_go_where_they_are_wanted():
    arm, out = symdyn.load(ARM, "inverse_dynamics"), np.empty(2)

    assert arm.inverse_dynamics(*STATE, **NAMED, out=out) is out
    assert np.array_equal(out, arm.inverse_dynamics(*STATE, PARAMS))


@pytest.mark.parametrize(
    ("given", "named", "told"),
    [
        (STATE, {}, r"^inverse_dynamics: params is missing: m1, m2, h1, h2, g; inverse_dynamics\(q, qd, qdd, params\)"),
        (STATE, {"m1": 1, "m2": 1, "g": 9}, "params is missing: h1, h2;"),
        (STATE[:2], NAMED, "qdd is missing: q1_ddot, q2_ddot"),
        ((), NAMED, "q is missing: q1, q2; qd is missing"),
        (STATE, {**NAMED, "m3": 1}, "there is no m3; "),
        ((*STATE, PARAMS), {"m1": 1}, "m1 is given by name and in params"),
        ((*STATE, PARAMS, np.empty(2)), {"m1": 1}, "m1 is given by name and in params"),
        ((*STATE, PARAMS), {"q": STATE[0]}, "q is given by position and by name"),
        ((*STATE, PARAMS, None, None), {}, "6 arguments are given"),
        ((*STATE, PARAMS[:3]), {}, "params has 3 in its last dimension; give 5 numbers, m1, m2, h1, h2, g"),
        (([1, 2, 3], *STATE[1:], PARAMS), {}, "q has 3 in its last dimension; give 2 numbers, q1, q2"),
        ((1.0, *STATE[1:], PARAMS), {}, "q is one number; give 2 numbers, q1, q2"),
        (({"q1": 1}, *STATE[1:], PARAMS), {}, "q is no array of real numbers"),
        ((["a", "b"], *STATE[1:], PARAMS), {}, "q is no array of real numbers"),
        (([1j, 2], *STATE[1:], PARAMS), {}, "q is no array of real numbers"),
        (([[1], [1, 2]], *STATE[1:], PARAMS), {}, "q is no array of real numbers"),
        ((np.ones((3, 2)), np.ones((4, 2)), STATE[2], PARAMS), {}, r"do not broadcast: q \(3,\), qd \(4,\)"),
        (STATE, {**NAMED, "m1": [1, 2], "m2": [1, 2, 3]}, "values by name do not broadcast"),
        (STATE, {**NAMED, "m1": "heavy"}, "params is no array of real numbers"),
    ],
)
def test_errors_name_arguments_and_their_entries(inverse, given, named, told):
    with pytest.raises(ArgumentError, match=told):
        inverse(*given, **named)


def test_a_parameter_with_a_value_is_told_how_to_be_an_argument():
    bound = symdyn.load(ARM, "mass_matrix", parameters=NAMED)
    with pytest.raises(ArgumentError, match=r'm1 has the value 1 in the scene .* load\(…, free="m1"\)'):
        bound.mass_matrix(STATE[0], m1=2)

    free = symdyn.load(ARM, "mass_matrix", parameters=NAMED, free="m1")
    assert np.array_equal(free.mass_matrix(STATE[0]), bound.mass_matrix(STATE[0]))
    heavier = symdyn.load(ARM, "mass_matrix", parameters={**NAMED, "m1": 2})
    assert np.allclose(free.mass_matrix(STATE[0], m1=2), heavier.mass_matrix(STATE[0]), rtol=1e-14)
    again = pickle.loads(pickle.dumps(free))
    assert np.array_equal(again.mass_matrix(STATE[0]), bound.mass_matrix(STATE[0]))
    massless = symdyn.load(ARM, "mass_matrix", parameters={**NAMED, "m1": 0}, free="m1")
    assert np.allclose(massless.mass_matrix(STATE[0], m1=2), heavier.mass_matrix(STATE[0]), rtol=1e-14)
    with pytest.raises(SceneError, match='free: "m9" is not a parameter'):
        symdyn.load(ARM, "mass_matrix", free=["m9"])


def test_a_parameter_is_freed_by_any_list_of_names_and_what_is_none_is_told():
    cart = ROOT / "examples" / "cart_pole.toml"

    assert symdyn.load(cart, "mass_matrix", free=(name for name in ["mc"])).mass_matrix([0, 0], mc=2)[0, 0] == 2.1
    for given, told in [
        ({"free": None}, "free = None: give text or a list of texts"),
        ({"functions": 3}, "functions = 3: give "),
        ({"parameters": [1, 2]}, "parameters = [1, 2]: give "),
    ]:
        with pytest.raises(ArgumentError) as error:
            symdyn.load(cart, **given)
        assert str(error.value).startswith(told)
    with pytest.raises(ArgumentError, match="name = 3: give text or a list of texts"):
        symdyn.lambdify(cart, 3)


def test_prepared_parameters_go_by_name_too():
    arm = symdyn.load(ARM, "inverse_dynamics", prepare=True)
    prepared = arm.prepare(**NAMED)

    assert np.array_equal(arm.inverse_dynamics(*STATE, prepared), arm.inverse_dynamics(*STATE, prepared=prepared))
    with pytest.raises(ArgumentError, match="there is no m1; "):
        arm.inverse_dynamics(*STATE, m1=1)


def test_a_name_that_is_not_there_is_an_error_of_ours():
    arm = symdyn.load(ARM, "mass_matrix")
    with pytest.raises(UnknownNameError) as caught:
        arm["pose:nothing"]

    assert str(caught.value).startswith("there is no function 'pose:nothing'; there are mass_matrix;")


def test_editors_see_what_a_function_takes(inverse):
    assert list(inspect.signature(inverse).parameters) == ["q", "qd", "qdd", "params", *NAMED]
    assert repr(inverse).startswith("<inverse_dynamics(q, qd, qdd, params) -> tau: (2),(2),(2),(5)->(2)")
    assert inverse.__name__ == "inverse_dynamics"
    assert "Return" in inverse.__doc__


CALL = """
import pickle, sys
kept = pickle.load(sys.stdin.buffer)
print(*(one([0.3, 0.5], [1.0, -2.0], [0.7, 1.1], m1=1, m2=2, h1=0.5, h2=3, g=9.81).tolist() for one in kept), sep=";")
"""


def test_functions_pickle_into_another_process():
    ways = [symdyn.load(ARM, ["mass_matrix", "inverse_dynamics"]).inverse_dynamics]
    ways += [symdyn.lambdify(ARM, ("mass_matrix", "inverse_dynamics"), target)[1] for target in ("numpy", "c")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = [sys.executable, "-c", CALL]
    ran = subprocess.run(words, input=pickle.dumps(ways), env=environment, capture_output=True, check=False)

    assert ran.returncode == 0, ran.stderr.decode()
    assert ran.stdout.decode().strip().split(";") == [str(one(*STATE, PARAMS).tolist()) for one in ways]


def test_inputs_go_by_name_and_are_what_the_scene_says_where_nobody_gives_them():
    text = "[inputs.u]\nvalue = 2\n[bodies.a]\nmass = 1\ncom = [1, 0, 0]\n[joints.j]\ntype = 'revolute'\n"
    scene = read_text(text + "parent = 'ground'\nchild = 'a'\nforce = '3*u'\n")
    call = symdyn.load(scene, "inverse_dynamics").inverse_dynamics

    assert call([0], [0], [0]) == pytest.approx([-6])
    assert call([0], [0], [0], u=5) == call([0], [0], [0], [5]) == pytest.approx([-15])


@pytest.mark.parametrize("backend", ["load", "numpy"])
def test_a_drive_that_is_called_as_the_argument_is_goes_by_name_alone(backend):
    text = Path(ROOT / "examples" / "cart_pole.toml").read_text().replace('"F"', '"tau"')
    scene = read_text(text)
    function = (
        symdyn.load(scene).forward_dynamics
        if backend == "load"
        else symdyn.lambdify(scene, "forward_dynamics", backend)
    )

    assert np.array_equal(function([0, 0.1], [0, 0], tau=2.0), function([0, 0.1], [0, 0], tau=[2.0, 0]))
