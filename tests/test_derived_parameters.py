"""Parameters made of parameters: their formulas stand in place of their names, everywhere that a name may stand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

import symdyn
import symdyn.scene as declared
from symdyn.errors import SceneError, SymdynError
from symdyn.scene.toml import write_text

ROD = """
name = "rod"
[parameters]
h = "l/2"
l = { value = 2, unit = "m" }
m = 1.5
J = { value = "m*l**2/12", unit = "kg m^2", text = "of a thin rod" }
[bodies.rod]
mass = "m"
com = ["h", 0, 0]
inertia = [0, "J", "J"]
inertia_about = "com"
[joints.pin]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 1, 0]
coordinate = "theta"
"""


def rod(tmp_path: Path, text: str = ROD) -> symdyn.Scene:
    file = tmp_path / "rod.toml"
    file.write_text(text)
    return symdyn.read(file)


def test_equations_are_those_of_the_formulas_put_in(tmp_path: Path) -> None:
    scene = rod(tmp_path)
    found = symdyn.equations(scene)
    mass = found.sympy().M[0, 0]
    length, m = sorted(mass.free_symbols, key=str)

    assert [one.name for one in scene.parameters] == ["l", "m"]
    assert {one.name for one in scene.derived} == {"h", "J"}
    assert sympy.simplify(mass - m * length**2 / 3) == 0


def test_a_written_scene_is_the_same_and_python_declares_it_too(tmp_path: Path) -> None:
    scene = rod(tmp_path)
    again = tmp_path / "again.toml"
    again.write_text(write_text(scene).text)
    body = declared.body("rod", mass="m", com=["h", 0, 0], inertia={"yy": "J", "zz": "J"}, about="com")
    pin = declared.revolute("pin", "ground", "rod", axis=[0, 1, 0], coordinate="theta")
    parameters = [
        declared.parameter("h", "l/2"),
        declared.parameter("l", 2, unit="m"),
        declared.parameter("m", 1.5),
        declared.parameter("J", "m*l**2/12", unit="kg m^2", text="of a thin rod"),
    ]

    assert symdyn.read(again) == scene
    assert declared.scene("rod", parameters=parameters, bodies=[body], joints=[pin]) == scene


def test_a_bound_parameter_takes_what_is_derived_with_it(tmp_path: Path) -> None:
    scene = rod(tmp_path)
    direct = rod(tmp_path, ROD.replace("value = 2", "value = 4"))

    assert declared.bind(scene, {"l": "4 m"}) == direct
    with pytest.raises(SceneError, match=r"h is derived, h = l/2; give l"):
        declared.bind(scene, {"h": 4})


@pytest.mark.runs
def test_derivatives_go_through_what_is_derived(tmp_path: Path) -> None:
    scene = rod(tmp_path)
    inertia = symdyn.lambdify(scene, "mass_matrix_by_l", target="numpy")

    assert_allclose(np.ravel(inertia([0.3])), 2 * 1.5 * 2 / 3)  # of m l²/3


@pytest.mark.runs
def test_formulas_of_a_run_may_name_what_is_derived(tmp_path: Path) -> None:
    scene = rod(tmp_path)
    named = symdyn.simulate(scene, until=0.3, forces={"tau1": "h*3*theta"}, start={"theta": "h/2"}, stops="h*theta-9")
    plain = symdyn.simulate(scene, until=0.3, forces={"tau1": "l/2*3*theta"}, start={"theta": 0.5}, stops="theta-9")
    runs = symdyn.sweep(scene, until=0.1, over={"l": [2, 3]}, measure=["max(h*theta_dot)", "max(theta_dot)*h"])
    first, second = (runs[name] for name in ("max(h*theta_dot)", "max(theta_dot)*h"))

    assert np.array_equal(named.q, plain.q)
    assert_allclose(first, second)


@pytest.mark.parametrize(
    ("formula", "told"),
    [
        ('h = "k/2"', "uses the undefined symbol k"),
        ('h = "h/2"', "depends on itself: h -> h"),
        ('h = "J/(m*l)"\n', None),
        ('h = "theta"', "uses the undefined symbol theta"),
        ('h = { value = "l/2", unit = "mm" }', 'what is computed is; write "m"'),
        ('h = { value = "l*m", unit = "m" }', "is in kg m"),
        ('h = { value = "l/2", tolerance = "5 %" }', "give the tolerance to what it is derived from"),
        ('h = { value = "-l/2", positive = true }', "is not positive"),
        ('h = "1/(l - 2)"', "divides by zero"),
        ('h = "sqrt(l - 5)"', "square root of -3"),
    ],
)
def test_what_is_derived_wrongly_is_told_in_words(tmp_path: Path, formula: str, told: str | None) -> None:
    text = ROD.replace('h = "l/2"', formula).replace("m = 1.5", 'm = { value = 1.5, unit = "kg" }')
    if told is None:
        assert rod(tmp_path, text).derived_formulas["h"].at({"l": 2, "m": 1}) is not None
        return
    with pytest.raises(SymdynError) as error:
        rod(tmp_path, text)
    assert told in str(error.value)
    assert "parameters.h" in str(error.value)


def test_a_circle_and_a_tower_of_formulas_are_refused_at_once(tmp_path: Path) -> None:
    tower = "\n".join(f'x{k} = "x{k - 1}*x{k - 1} + x{k - 1}"' for k in range(1, 40))
    with pytest.raises(SceneError, match="multiplies out to too many terms"):
        rod(tmp_path, ROD.replace('h = "l/2"', f'h = "l/2"\nx0 = "l"\n{tower}'))
    with pytest.raises(SceneError, match=r"depends on itself: l -> J -> l|depends on itself: J -> l -> J"):
        rod(tmp_path, ROD.replace('l = { value = 2, unit = "m" }', 'l = "J/3"'))


@pytest.mark.runs
def test_a_sweep_a_sensitivity_and_a_locus_say_what_to_vary(tmp_path: Path) -> None:
    scene = rod(tmp_path)
    with pytest.raises(SymdynError, match=r"h is derived, h = l/2; give l"):
        symdyn.sweep(scene, until=0.1, over={"h": [1, 2]}, measure=["max(theta)"])
    with pytest.raises(SymdynError, match=r"h is derived, h = l/2; give l"):
        symdyn.sensitivity(scene, until=0.1, parameters=["h"])
