"""The identified scene: what was found, in place of what was declared, in every format that is written."""

import re
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import IdentifyError, SceneError
from symdyn.identification import identify
from symdyn.identification.identification import richer
from symdyn.identification.identified_scene import (
    body_of_ten,
    fit_names,
    identifiable_combinations,
    identified,
    with_parameters,
)
from symdyn.identification.linear_model import TEN, ten_of_body, unknowns
from symdyn.identification.report import report, written
from symdyn.identification.report_sections import TOP, Frame
from symdyn.scene import body, revolute, scene, spring
from symdyn.scene.symbolic import bind
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.quantity import Quantity

pytestmark = pytest.mark.runs("cc")


def _log(scene, seconds=8, noise=0.01, joints=()):
    """Return a log of a simulated motion: sums of sines of all joints or of these, exact forces, noise."""
    draw, n = np.random.default_rng(1), len(scene.coordinates)
    t = np.arange(0, seconds, 0.005)
    q, qd, qdd = np.zeros((3, len(t), n))
    for k in range(1, 7):
        w, (a, b) = 2 * np.pi * k / seconds, draw.normal(size=(2, n)) / 2
        s, c = np.sin(w * t)[:, None], np.cos(w * t)[:, None]
        q, qd, qdd = q + a * s + b * c, qd + w * (a * c - b * s), qdd - w * w * (a * s + b * c)
    for k in set(range(n)) - set(joints or range(n)):
        q[:, k], qd[:, k], qdd[:, k] = 0.3, 0, 0
    tau = symdyn.lambdify(scene, "inverse_dynamics")(q, qd, qdd)
    tau = tau + noise * np.std(tau, axis=0) * draw.normal(size=tau.shape)
    named = {name: q[:, k] for k, name in enumerate(scene.coordinates)}
    return {"t": t, **named, **{name: tau[:, k] for k, name in enumerate(scene.drives) if name}}


@pytest.fixture(scope="module")
def arm():
    scene = symdyn.example("puma560")
    joints = tuple(replace(joint, damping=quantity("0.5")) if k < 2 else joint for k, joint in enumerate(scene.joints))
    return replace(scene, joints=joints)


@pytest.fixture(scope="module")
def found(arm):
    return identify(arm, _log(arm), hold_back=0.25)


@pytest.fixture(scope="module")
def made(found):
    return identified(found)


@pytest.fixture(scope="module")
def pendulums():
    scene = symdyn.example("two_link")
    scene = bind(scene, {"m1": 2, "m2": 1, "h1": 0.5, "h2": 0.4, "g": 9.81})
    return scene, identify(bind(scene, {"m1": 3, "m2": 3}), _log(scene))


@pytest.mark.long
@pytest.mark.parametrize("format", ["toml", "urdf"])
def test_read_back_it_has_the_same_base_parameters(made, format, tmp_path):
    path = tmp_path / f"arm.{format}"
    path.write_text(written(made, format, ["made by <b> -- a\ntest"]).text)

    again = unknowns(symdyn.read(path))

    assert {body.name for body in made.scene.bodies} <= {body.name for body in again.scene.bodies}
    np.testing.assert_allclose(again.map @ again.values, made.physical.base, rtol=1e-8, atol=1e-8)
    if format == "toml":
        assert symdyn.read(path) == made.scene
    else:
        assert ElementTree.parse(path).getroot().tag == "robot"


def test_it_predicts_the_forces_as_well_as_the_estimates_do(found, made):
    off = found.regression.weights * (found.regression.Y @ (made.physical.base - found.after))

    assert np.sqrt(np.mean(off**2)) < 0.3
    assert made.physical.margins.min() > 0 > made.physical.before.min()


def test_parameters_with_names_get_values(pendulums):
    scene, found = pendulums

    made = identified(found)

    assert made.physical is None
    assert made.named.names == ("m1", "m2")
    assert "h2" in made.named.fixed, "a point of the scene stands there"
    assert np.abs((made.named.values - [2, 1]) / made.named.errors).max() < 4
    assert np.abs(made.named.values - [2, 1]).max() < 0.05
    assert made.scene.bodies == scene.bodies
    assert any("geometry or gravity" in note for note in made.notes)


def test_friction_that_was_added_stands_in_the_scene_and_is_not_negative(pendulums):
    scene, _ = pendulums

    made = identified(identify(scene, _log(scene), friction=("viscous", "coulomb")))

    assert {"fv1", "fc1", "fv2", "fc2"} <= set(made.values)
    assert min(value for name, value in made.values.items() if name.startswith("f")) >= 0
    assert "friction" in written(made, "toml").text


def test_estimates_that_names_cannot_give_are_told():
    scene = bind(symdyn.example("two_link"), {"m1": 2, "m2": 1, "h1": 0.5, "h2": 0.4, "g": 9.81})
    known = unknowns(scene)
    count = len(known.base)

    named = fit_names(scene, known.base, np.eye(count), known.map @ known.values + 0.1, 1e-6 * np.eye(count))

    assert named.distance > 100
    assert named.spare == count - 2


def test_what_names_are_not_told_by_stays():
    scene = bind(symdyn.example("two_link"), {"m1": 2, "m2": 1, "h1": 0.5, "h2": 0.4, "g": 9.81})
    known = unknowns(scene)
    of_second = [k for k, name in enumerate(known.base) if "R2" in name]
    chosen = np.eye(len(known.base))[of_second]

    named = fit_names(scene, known.base, chosen, 1.5 * chosen @ known.map @ known.values, 1e-6 * np.eye(len(chosen)))

    assert dict(zip(named.names, named.values, strict=True)) == pytest.approx({"m1": 2, "m2": 1.5}, rel=1e-4)
    assert np.isnan(named.errors[0])


SWINGING = """
name = "swinging"
gravity = [0, 0, 0]

[parameters]
M = { value = 1 }
m2 = { value = 2 }
c = { value = 0.5 }
J = { value = 0.1 }

[bodies]
cart = { mass = "M" }
rod = { mass = "m2", com = ["c", 0, 0], inertia = ["J", "J", "J"], inertia_about = "com" }
[joints]
slide = { type = "prismatic", parent = "ground", child = "cart", axis = [1, 0, 0], drive = "F" }
turn = { type = "revolute", parent = "cart", child = "rod", axis = [0, 0, 1], drive = "T" }
"""


def test_names_that_data_do_not_tell_apart_are_told_and_give_the_estimates(tmp_path):
    """M, m2, c and J from M + m2, m2 c and J + m2 c^2: M = 1.25 +- 440 read as found, and J stayed as it was."""
    file = tmp_path / "swinging.toml"
    file.write_text(SWINGING)
    scene = symdyn.read(file)

    made = identified(identify(scene, _log(bind(scene, {"M": 1.3, "c": 0.45}), noise=1e-3)))

    values = made.values
    assert np.isnan(made.named.errors).all()
    assert values["M"] + values["m2"] == pytest.approx(3.3, rel=1e-3)
    assert values["m2"] * values["c"] == pytest.approx(0.9, rel=1e-3)
    assert values["J"] + values["m2"] * values["c"] ** 2 == pytest.approx(0.505, rel=1e-3)
    assert any("M, m2, c, J: identifiable in combinations only" in note for note in made.notes)


@pytest.mark.filterwarnings("error")
def test_six_names_of_a_log_without_noise_are_told_without_a_warning(tmp_path):
    turning = SWINGING.replace("prismatic", "revolute").replace("axis = [1, 0, 0]", "axis = [0, 0, 1]")
    turning = turning.replace("M = {", "c1 = 0.19\nJ1 = 0.055\nM = {").replace(
        'drive = "T"', 'drive = "T", origin = [0.42, 0, 0]'
    )
    upper = 'mass = "M", com = ["c1", 0, 0], inertia = ["J1", "J1", "J1"], inertia_about = "com"'
    (tmp_path / "turning.toml").write_text(turning.replace('mass = "M"', upper))
    scene = symdyn.read(tmp_path / "turning.toml")

    made = identified(identify(scene, _log(scene, noise=0)))

    assert np.isnan(made.named.errors).all()
    assert len(made.named.errors) == 6


def test_exciting_motions_are_advised_only_where_they_are_found():
    assert "symdyn.identification.excite" in richer(symdyn.example("puma560"))
    assert "excite" not in richer(symdyn.example("four_bar"))


def test_ten_numbers_become_a_body_and_come_back():
    scene = symdyn.example("puma560")
    known = unknowns(scene)
    ten = known.ten(known.values)[1] * 1.1

    body = body_of_ten(scene.bodies[1], ten)
    again = unknowns(replace(scene, bodies=(scene.bodies[0], body, *scene.bodies[2:])))

    np.testing.assert_allclose(again.ten(again.values)[1], ten, rtol=1e-9)
    mass, centre, moments, _ = ten_of_body(ten)
    assert body.mass == Quantity.number(quantity("19.14").value)
    assert mass == pytest.approx(19.14)
    assert centre == pytest.approx([-0.3638, 0.006, 0.2275])
    assert moments == pytest.approx([1.1 * x for x in (0.13, 0.524, 0.539)])


def test_the_mass_of_a_box_is_spread_over_a_twelfth_of_its_squared_lengths():
    m, place, squares = 3.0, np.array([0.4, -0.2, 0.1]), np.array([0.2, 0.5, 0.9]) ** 2
    central = m / 12 * np.diag(squares.sum() - squares)
    about = central + m * (place @ place * np.eye(3) - np.outer(place, place))
    upper = about[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    mass, com, principal, spread = ten_of_body(np.array([m, *(m * place), *upper]))

    assert mass == m
    np.testing.assert_allclose(com, place)
    np.testing.assert_allclose(principal, np.sort(np.diag(central)))
    np.testing.assert_allclose(spread, np.diag(squares) / 12, atol=1e-15)


def test_other_bodies_stay_as_they_are_declared():
    scene = symdyn.example("arm7")
    known = unknowns(scene)

    changed = with_parameters(scene, {known.names[TEN]: 1.001 * known.values[TEN]})

    assert [a == b for a, b in zip(scene.bodies, changed.bodies, strict=True)] == [True, False, *[True] * 5]
    assert changed.joints == scene.joints


@pytest.mark.parametrize(
    ("values", "told"), [({"mm2": 3}, "mm2 is no parameter of it"), ({"Ixx2": -3}, "is not physically consistent")]
)
def test_what_a_scene_cannot_have_is_told(values, told):
    with pytest.raises(SceneError, match=told):
        with_parameters(symdyn.example("arm7"), values)


def test_the_page_is_the_same_and_holds_no_ones_marks(found, made):
    hostile = replace(found, notes=("<script>alert(1)</script>\x1b",))
    page = report(hostile, made, "symdyn identify '<b>.csv'")

    assert page == report(hostile, made, "symdyn identify '<b>.csv'")
    assert "<script" not in page
    assert "&lt;script&gt;" in page
    assert "<b>" not in page
    assert "\x1b" not in page
    assert "http" not in page


def test_the_page_tells_all_of_it(found, made):
    page = report(found, made)

    assert page.count("<svg") == page.count('role="img" aria-label="')
    assert page.count("<h1>") == 1
    for name in found.names:
        assert f'<th scope="row">{name}</th>' in page
    for title in ("Parameters", "Not identifiable from these data", "Driving forces", "Residuals", "Outliers"):
        assert f"<h2>{title}" in page
    assert ("Every base parameter is identifiable." in page) == (not found.not_identifiable)
    assert "nan" not in re.sub(r"<title>.*?</title>", "", page)
    assert len(page) < 500_000


def test_the_ending_says_what_is_written(arm, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.toml").write_text(symdyn.scene.write_text(arm, "toml").text)
    log = _log(arm, seconds=4)
    np.savetxt("log.csv", np.stack(list(log.values()), 1), delimiter=",", header=",".join(log), comments="")
    files = ["page.html", "found.toml", "found.urdf", "found.csv"]
    words = ["identify", "arm.toml", "log.csv", *(word for file in files for word in ("-o", file))]

    assert main([*words, "--total-mass", "25"]) == 0
    told = capsys.readouterr()
    assert [f"wrote {file}" in told.err for file in files] == [True] * 4
    assert "symdyn identify arm.toml log.csv --total-mass 25" in Path("page.html").read_text()
    assert sum(float(body.mass.at({})) for body in symdyn.read("found.toml").bodies) == pytest.approx(25)
    assert Path("found.csv").read_text().startswith("parameter,before,after,standard error,from,to\n")
    before = Path("found.toml").read_text()

    assert main([*words, "-o", "page.pdf", "--total-mass", "-1"]) == 1
    told = capsys.readouterr().err
    assert "found.toml exists" in told
    assert "page.pdf: -o writes .html, .toml, .urdf, .csv files" in told
    assert "--total-mass: -1 is no mass" in told
    assert Path("found.toml").read_text() == before


def test_a_notebook_shows_both(found, made):
    shown = found._repr_mimebundle_()
    assert f">{found.names[0]}<" in shown["text/html"]
    assert shown["text/plain"] == repr(found)
    assert repr(made) == "<Identified puma560: inertias that bodies can have>"
    assert ">link3<" in made._repr_mimebundle_()["text/html"]


def test_without_the_solver_one_is_told_how_to_get_it(arm, found, monkeypatch):
    monkeypatch.setitem(sys.modules, "clarabel", None)

    with pytest.raises(IdentifyError, match=r'needs clarabel: pip install "symdyn\[identify\]"'):
        identified(found)


def test_a_total_mass_of_parameters_with_names_is_told_to_do_nothing(pendulums):
    _, found = pendulums

    free, held = identified(found), identified(found, total_mass=9)

    assert (free.named.values == held.named.values).all()
    assert next(note for note in held.notes if note not in free.notes).startswith("the total mass: of no effect")


@pytest.mark.long
@pytest.mark.parametrize("noise", [0, 0.05])
def test_a_log_of_one_joint_without_noise_becomes_a_scene(arm, noise):
    moved = _log(arm, noise=noise, joints=(0,))
    found = identify(arm, moved)

    made = identified(found)

    assert found.not_identifiable
    assert made.physical.identifiable == len(found.names) - len(found.regression.null_space)
    assert made.physical.margins.min() > 0
    told, estimate, _ = identifiable_combinations(found)
    missed = np.linalg.norm(told @ made.physical.base - estimate) / np.linalg.norm(estimate)
    assert made.physical.missed == pytest.approx(missed, rel=1e-6, abs=1e-12)
    assert made.physical.missed < 0.2
    hardly = [note for note in made.notes if "hardly any noise" in note]
    assert not (hardly and noise)
    assert any(f"which {made.physical.identifiable} combinations are identifiable" in note for note in made.notes)


def test_the_least_value_of_a_chart_is_at_its_bottom_and_the_largest_at_its_top():
    frame = Frame(0.0, 1.0, 2.0, 5.0)
    bottom, middle, top = (frame.up(y) for y in (2.0, 3.5, 5.0))
    assert 0 < top < bottom < frame.height
    assert middle == pytest.approx((bottom + top) / 2)
    assert top == pytest.approx(TOP)


def test_a_spring_whose_free_length_is_a_number_or_a_parameter_has_its_stiffness_identified() -> None:
    """It was refused: free length and stiffness multiply each other, and the first of both was the column."""
    for parameters in ({"k": 120}, {"s0": 0.2, "k": 120}, {"k": 120, "s0": 0.2}):
        sprung = scene(
            "sprung",
            gravity=[0, 0, -9.81],
            parameters=parameters,
            bodies=[body("arm", mass=2, com=[0.2, 0, 0])],
            joints=[revolute("pivot", "ground", "arm", axis=[0, -1, 0], coordinate="q")],
            springs=[
                spring(
                    "coil",
                    ends=({"body": "ground", "at": [0, 0, 0.5]}, {"body": "arm", "at": [0.3, 0, 0]}),
                    stiffness="k",
                    free="s0" if "s0" in parameters else 0.2,
                )
            ],
        )
        log = symdyn.inverse(sprung, "q=sin(t)+0.4*sin(2.7*t)", np.linspace(0, 10, 1001))

        found = symdyn.identify(sprung, log)

        assert found["k"] == pytest.approx(120, rel=1e-3)
