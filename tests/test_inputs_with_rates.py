"""Inputs with rates: joints and supports that they move, in proofs, runs, linear systems, models, lessons and films."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmus import model_of, sources_of
from lessons import lesson_of
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import symdyn
import symdyn.scene as declared
from symdyn.algebra import Array, Floats
from symdyn.dynamics import Workspace, derive_one
from symdyn.errors import LinearizeError, SceneError, SimulateError
from symdyn.graph import Expr, evaluate
from symdyn.scene import read_text
from symdyn.scene.toml import write_text
from symdyn.simulation import Feedback, inverse
from symdyn.simulation.integrate import METHODS
from symdyn.teach.render.markdown import markdown

TABLE = """
name = "table"
[parameters]
m = "0.5 kg"
l = "0.2 m"
g = "9.81 m/s^2"
[inputs.zf]
unit = "m"
rates = 2
[bodies.table]
mass = "2*m"
[bodies.rod]
particles = [{ mass = "m", at = [0, 0, "l"] }]
[joints.guide]
type = "prismatic"
axis = [0, 0, 1]
parent = "ground"
child = "table"
coordinate = "z"
drive = "F"
motion = "zf"
[joints.pin]
type = "revolute"
axis = [0, 1, 0]
parent = "table"
child = "rod"
coordinate = "theta"
drive = false
"""

MASS = """
name = "mass"
gravity = "none"
[parameters]
m = "2 kg"
k = "800 N/m"
c = "12 N*s/m"
l = "0.5 m"
[inputs.y]
unit = "m"
rates = 1
[bodies.block]
mass = "m"
[joints.guide]
type = "prismatic"
axis = [1, 0, 0]
parent = "ground"
child = "block"
coordinate = "x"
drive = false
origin = { xyz = ["l", 0, 0] }
[springs.s]
from = { body = "ground", at = ["y", 0, 0] }
to = { body = "block" }
stiffness = "k"
free = "l"
[dampers.d]
from = { body = "ground", at = ["y", 0, 0] }
to = { body = "block" }
damping = "c"
"""

HUNG = """
name = "hung"
[inputs.s]
rates = 2
unit = "m"
[bodies.trolley]
mass = 5
[bodies.load]
particles = [{ mass = 2, at = [0, 0, -1] }]
[joints.rail]
type = "prismatic"
axis = [1, 0, 0]
parent = "ground"
child = "trolley"
coordinate = "x"
drive = "F"
motion = "s + s**2/4"
[joints.hook]
type = "revolute"
axis = [0, -1, 0]
parent = "trolley"
child = "load"
coordinate = "phi"
drive = false
[springs.wind]
from = { body = "ground", at = ["s + sin(2*t)/4", 0, 1] }
to = { body = "load", at = [0, 0, -1] }
stiffness = 30
free = 1
[dampers.wind]
from = { body = "ground", at = ["s + sin(2*t)/4", 0, 1] }
to = { body = "load", at = [0, 0, -1] }
damping = [3, 1]
"""

pytestmark = [pytest.mark.runs("cc"), pytest.mark.long]

SHAKEN = "0.01*sin(50*t)"


@pytest.fixture(scope="module")
def table() -> symdyn.Scene:
    return read_text(TABLE)


@pytest.fixture(scope="module")
def mass() -> symdyn.Scene:
    return read_text(MASS)


# Read and written


def test_an_input_with_rates_is_three_inputs_and_is_written_as_one(table: symdyn.Scene) -> None:
    assert [(one.name, one.unit) for one in table.inputs] == [("zf", "m"), ("zf_dot", "m/s"), ("zf_ddot", "m/s^2")]
    assert read_text(write_text(table).text) == table
    assert "zf_dot" not in write_text(table).text


def test_python_declares_what_a_file_does(mass: symdyn.Scene) -> None:
    ends = ({"body": "ground", "at": ["y", 0, 0]}, {"body": "block"})
    found = declared.scene(
        "mass",
        parameters={"m": "2 kg", "k": "800 N/m", "c": "12 N*s/m", "l": "0.5 m"},
        gravity="none",
        bodies=[declared.body("block", mass="m")],
        joints=[
            declared.prismatic(
                "guide", "ground", "block", axis=[1, 0, 0], coordinate="x", drive=False, origin={"xyz": ["l", 0, 0]}
            )
        ],
        inputs=[declared.input_signal("y", unit="m", rates=1)],
        springs=[declared.spring("s", ends=ends, stiffness="k", free="l")],
        dampers=[declared.damper("d", ends=ends, damping="c")],
    )
    assert found.inputs == mass.inputs
    assert found.elements == mass.elements


WRONG = {
    "rates = 3 is none of 0, 1, 2; write rates = 2 where it moves a joint, 1 for a spring": (
        TABLE, "rates = 2", "rates = 3",
    ),
    "joints.guide: motion = zf uses zf, an input without its rates; write rates = 2 in [inputs.zf]": (
        TABLE, "rates = 2", "rates = 1",
    ),
    "springs.s: from.at[0] = y uses y, an input without its rates; write rates = 1 in [inputs.y]": (
        MASS, "rates = 1", "rates = 0",
    ),
    'springs.s: to.at has y, which moves on the body "block"; only a place in space moves as it is told: write body '
    '= "ground"': (MASS, 'to = { body = "block" }\nstiff', 'to = { body = "block", at = ["y", 0, 0] }\nstiff'),
    'joints.pin: coordinate = "zf" is already the name of inputs.zf; choose another name': (
        TABLE, 'coordinate = "theta"', 'coordinate = "zf"',
    ),
}  # fmt: skip


@pytest.mark.parametrize("message", WRONG)
def test_what_cannot_be_is_told(message: str) -> None:
    text, old, new = WRONG[message]
    with pytest.raises(SceneError) as found:
        read_text(text.replace(old, new))
    assert message in str(found.value)


# Equations


@pytest.mark.parametrize("place", [{}, {"phi": 0.0, "x": 0.0, "s": 0.0, "t": 0.0}, {"phi": np.pi}, {"phi": np.pi / 2}])
def test_two_derivations_agree_where_supports_move(place: dict[str, float]) -> None:
    names = ("x", "phi", "x_dot", "phi_dot", "x_ddot", "phi_ddot", "s", "s_dot", "s_ddot", "t")
    values = dict(zip(names, np.random.default_rng(3).normal(size=len(names)), strict=True)) | place
    for name, ways in (("inverse_dynamics", ("rnea", "lagrange", "kane")), ("forward_dynamics", ("crba", "lagrange"))):
        found = [derive_one(Workspace(read_text(HUNG)), name, way) for way in ways]
        told = [numbers(one.entries, values) for one in found]
        for one in told[1:]:
            assert_allclose(one, told[0], rtol=1e-12, atol=1e-12)


def numbers(entries: Sequence[Expr], values: Mapping[str, float]) -> Array:
    graph = entries[0].graph
    known = {graph.symbol(name): x for name, x in values.items()} | {graph.symbol(f"tau[{k}]"): 0.0 for k in range(2)}
    return np.array(evaluate(entries, Floats(), known))


def test_a_printed_rate_has_the_velocity_of_the_support(mass: symdyn.Scene) -> None:
    assert "((l + x - y)*x_dot - (l + x - y)*y_dot)/" in symdyn.equations(mass).text()


# Linear systems


def test_transmissibility_is_den_hartogs(mass: symdyn.Scene) -> None:
    """Den Hartog, Mechanical Vibrations, fourth edition, section 2.12: motion of the support."""
    m, k, c = 2.0, 800.0, 12.0
    omega = np.geomspace(1, 200, 20)
    ratio, damping = omega / np.sqrt(k / m), c / (2 * np.sqrt(k * m))
    known = np.sqrt((1 + (2 * damping * ratio) ** 2) / ((1 - ratio**2) ** 2 + (2 * damping * ratio) ** 2))
    lin = symdyn.linearize(mass, outputs=["x", "x_ddot", "x_dot"])

    assert lin.inputs.names == ("y", "y_dot")
    assert_allclose(lin.B, np.array([[0.0, 0.0], [k / m, c / m]]), rtol=1e-12)
    assert_allclose(np.abs(lin.bode("x", "y", omega).response[:, 0, 0]), known, rtol=1e-10)
    assert_allclose(lin.bode("x_ddot", "y", omega).response, -(omega[:, None, None] ** 2) * lin.bode(
        "x", "y", omega).response, rtol=1e-9)  # fmt: skip
    assert_allclose(lin.transfer("x", "y").zeros.real, [-k / c])
    assert lin.step("x", "y").final == pytest.approx(1)
    with pytest.raises(LinearizeError) as found:
        lin.step("x_ddot", "y")
    assert str(found.value) == (
        "mass: x_ddot follows a rate of y at once, which only bode and nyquist can tell; ask for these, or for another "
        "output"
    )
    for whole in (lin.to_control, lambda: lin.discretize(0.1), lin.step):
        with pytest.raises(LinearizeError, match=r'ask for these, or for lin\["x", "y"\]'):
            whole()
    with pytest.raises(LinearizeError) as found:
        lin.lqr()
    assert "mass: only inputs with rates move it, by which no regulator acts" in str(found.value)


def test_python_control_is_handed_what_moves_by_rates_too() -> None:
    """Inputs with one rate and with two beside a drive, against bode: what has B0 alone there is another system."""
    pytest.importorskip("control")
    driven = TABLE.replace("[inputs.zf]", "[inputs.y]\nrates = 1\n[inputs.zf]").replace(
        "axis = [0, 0, 1]", "axis = [1, 0, 0]"
    )
    driven = driven.replace(
        "drive = false", 'drive = "M"\ndamping = 0.02\nforce = "-3*(theta - y) - 0.1*(theta_dot - y_dot)"'
    )
    lin = symdyn.linearize(read_text(driven), outputs=["theta", "z"])
    theirs, omega = lin.to_control(), np.array([0.3, 4.0, 30.0, 500.0])

    assert (lin.inputs.names, theirs.input_labels) == (("M", "y", "y_dot", "zf", "zf_dot", "zf_ddot"), ["M", "y", "zf"])
    for name in theirs.input_labels:
        for output in lin.outputs.names:
            exact = lin.bode(output, name, omega).response[:, 0, 0]
            assert_allclose([theirs[output, name](1j * w) for w in omega], exact, rtol=1e-9, atol=1e-12)
    held = theirs.sample(0.02)
    sampled = lin.discretize("20 ms")
    assert sampled.inputs.names == ("M", "y", "zf")
    for letter in "ABCD":
        assert_allclose(getattr(sampled, letter), getattr(held, letter), rtol=1e-9, atol=1e-12)
    assert_allclose(theirs.A, lin.A)
    for improper in ("theta_dot", "theta_ddot"):
        found = symdyn.linearize(read_text(driven), outputs=["theta", improper])
        for asked in (found.to_control, lambda found=found: found.discretize(0.02)):
            with pytest.raises(LinearizeError, match=f"{improper} follows a rate of (y|zf) at once"):
                asked()


def test_a_full_car_answers_four_roads_as_by_hand() -> None:
    """H = (K + iωC - ω²M)⁻¹ B of heave, pitch, roll and four wheels: Rajamani, Vehicle Dynamics, section 10."""
    car, omega = symdyn.example("full_car"), np.geomspace(0.5, 200, 30)
    x, y = np.array([1.1, 1.1, -1.5, -1.5]), 0.75 * np.array([1, -1, 1, -1])
    k, c = np.array([18e3, 18e3, 16e3, 16e3]), np.array([1200, 1200, 1100, 1100])
    ends = np.column_stack([np.ones(4), x, y, -np.eye(4)])  # how much each suspension gets longer
    M, tyres = np.diag([1080, 1760, 380, 40, 40, 40, 40]), 180e3 * np.eye(7, 4, -3)
    K, C = ends.T * k @ ends + np.diag([0] * 3 + [180e3] * 4), ends.T * c @ ends
    by_hand = np.linalg.inv(K + 1j * omega[:, None, None] * C - omega[:, None, None] ** 2 * M) @ tyres

    lin = symdyn.linearize(car, outputs=list(car.coordinates))

    assert_allclose(
        lin.A, np.block([[np.zeros((7, 7)), np.eye(7)], [-np.linalg.inv(M) @ np.hstack([K, C])]]), atol=1e-9
    )
    found = lin.bode(omega=omega).response
    assert_allclose(found, by_hand, rtol=1e-10, atol=1e-12)
    assert_allclose(lin.bode("phi", "front_left", omega).response[:, 0, 0], by_hand[:, 2, 0], rtol=1e-10)
    assert_allclose(found[:, 2, :2].sum(axis=1), 0, atol=1e-12)  # both sides alike: no roll
    assert_allclose(lin.bode(omega=[1e-6]).response[0] @ np.ones(4), [1, 0, 0, 1, 1, 1, 1], atol=1e-9)


def test_two_derivations_of_a_full_car_agree() -> None:
    assert symdyn.certify(symdyn.example("full_car"), ("inverse_dynamics",), targets=["numpy"]).passed


@pytest.mark.parametrize("above", [False, True])
def test_a_prescribed_joint_drives_by_its_acceleration_alone(table: symdyn.Scene, above: bool) -> None:
    """About a pendulum on a table: l theta'' = (g + zf'') theta, and a trolley instead: l phi'' = -g phi - s''."""
    crane = read_text(HUNG.partition("[springs")[0].replace("s + s**2/4", "s"))
    lin = symdyn.linearize(table if above else crane, outputs=["theta", "z", "F"] if above else ["phi", "x", "F"])
    omega = np.array([0.5, 2.0, 7.0])
    whole = lin.bode(omega=omega).response[:, :, 0]
    if above:
        assert_allclose(whole[:, 0], 0, atol=1e-15)
        assert_allclose(whole[:, 2], -1.5 * omega**2, rtol=1e-12)
        assert lin.point.outputs[2] == pytest.approx(1.5 * 9.81)
    else:
        assert_allclose(whole[:, 0], omega**2 / (9.81 - omega**2), rtol=1e-10)
        assert_allclose(whole[:, 2], -(omega**2) * (7 + 2 * omega**2 / (9.81 - omega**2)), rtol=1e-10)
    assert_allclose(whole[:, 1], 1, rtol=1e-12)


def test_formulas_of_a_linear_system_have_the_columns_of_rates(mass: symdyn.Scene) -> None:
    assert str(symdyn.linearize(mass).formulas.B) == "Matrix([[0, 0], [k/m, c/m]])"


# Runs


@pytest.mark.parametrize(("rate", "stands"), [(1.1, True), (0.9, False)])
def test_a_pendulum_stands_on_a_table_that_shakes_fast_enough(table: symdyn.Scene, rate: float, stands: bool) -> None:
    """Kapitza's pendulum: upright is stable where a^2 Omega^2 > 2 g l (Landau and Lifshitz, Mechanics, section 30)."""
    a = 0.004
    omega = rate * np.sqrt(2 * 9.81 * 0.2) / a
    run = symdyn.simulate(
        table, forces={"zf": f"{a}*cos({float(omega)}*t)"}, until=2, start={"theta": 0.02}, method="taylor", rtol=1e-9
    )
    assert (np.abs(run["theta"]).max() < 0.5) == stands
    assert run.monitors["energy"] < 1e-6


@pytest.mark.parametrize("method", [name for name, one in METHODS.items() if one.finds_events])
def test_every_integrator_moves_the_support(table: symdyn.Scene, method: str) -> None:
    run = symdyn.simulate(table, forces={"zf": SHAKEN}, until=0.2, start={"theta": 0.1}, method=method)
    closed = solve_ivp(
        lambda t, x: [x[1], (9.81 - 25 * np.sin(50 * t)) / 0.2 * np.sin(x[0])],
        (0, 0.2), [0.1, 0], method="DOP853", rtol=1e-12, atol=1e-12,
    )  # fmt: skip
    assert_allclose(run["theta"][-1], closed.y[0, -1], rtol=1e-5)
    assert_allclose(run["z"], 0.01 * np.sin(50 * run.t), atol=1e-6)


def test_tables_functions_and_formulas_give_one_motion(table: symdyn.Scene) -> None:
    t = np.linspace(0, 0.3, 601)
    wave = 0.01 * np.sin(50 * t), 0.5 * np.cos(50 * t), -25 * np.sin(50 * t)
    ways: list[Any] = [
        {"zf": SHAKEN},
        {"zf": (t, wave[0])},
        {"t": t, "zf": wave[0], "zf_dot": wave[1], "zf_ddot": wave[2]},
        {"zf": lambda t: (0.01 * np.sin(50 * t), 0.5 * np.cos(50 * t), -25 * np.sin(50 * t))},
    ]
    runs = [symdyn.simulate(table, forces=way, until=0.3, start={"theta": 0.1}) for way in ways]
    for run in runs[1:]:
        assert_allclose(run["theta"], runs[0]["theta"], rtol=1e-5)
        assert_allclose(run["zf_dot"], runs[0]["zf_dot"], atol=2e-4)
    back = inverse(table, {"theta": (runs[0].t, runs[0]["theta"])}, forces=ways[0], until=0.3, every=0.1)
    assert_allclose(back["F"], np.interp(back.t, runs[0].t, runs[0]["F"]), rtol=1e-3)


def test_a_support_brings_energy_in(mass: symdyn.Scene) -> None:
    run = symdyn.simulate(mass, forces={"y": "0.02*sin(20*t)"}, until=1)
    assert run.monitors["energy"] < 1e-10
    assert np.ptp(run["work"]) > 0.1


def test_ensembles_and_sensitivities_start_where_the_input_does(table: symdyn.Scene) -> None:
    scene = read_text(TABLE.replace('g = "9.81 m/s^2"', 'g = "9.81 m/s^2"\na = "0.01 m"'))
    forces = {"zf": "a*cos(50*t)"}
    runs = symdyn.ensemble(scene, forces=forces, until=0.1, start={"theta": [0.1, 0.2]})
    one = symdyn.simulate(scene, forces=forces, until=0.1, start={"theta": 0.2})
    assert_allclose(runs["end(theta)"][1], one["theta"][-1], rtol=1e-9)
    slopes = symdyn.sensitivity(scene, forces=forces, until=0.1, start={"theta": 0.2})
    z, a = slopes.rows.index("z"), slopes.columns.index("a")
    assert slopes.matrix[z, a] == pytest.approx(np.cos(5), abs=1e-9)


@pytest.mark.parametrize("value", [0.0, 0.02])
def test_a_number_is_a_constant_whose_rates_are_zero(table: symdyn.Scene, mass: symdyn.Scene, value: float) -> None:
    """The table stands there from the start; on its support the block swings about where that is."""
    stands = symdyn.simulate(table, forces={"zf": value}, until=0.1, start={"theta": 0.1})
    swings = symdyn.simulate(mass, forces={"y": value}, until=0.5)

    assert_allclose(stands["z"], value, atol=1e-12)
    assert_allclose([stands["zf_dot"], stands["zf_ddot"], stands["z_dot"]], 0, atol=1e-12)
    decay, omega = 12 / (2 * 2), np.sqrt(800 / 2 - 3**2)
    step = 1 - np.exp(-decay * swings.t) * (np.cos(omega * swings.t) + decay / omega * np.sin(omega * swings.t))
    assert_allclose(swings["x"], value * step, atol=1e-9)


REFUSED: dict[str, Any] = {
    "forces: zf = if(t > 1, 1, 0) has a step at t = 1 s, where zf_dot acts and has no value; give a smoother one": {
        "zf": "if(t > 1, 1, 0)"
    },
    "forces: the rate of zf = max(t - 1, 0) has a step at t = 1 s, where zf_ddot acts and has no value; give a "
    "smoother one": {"zf": "max(t - 1, 0)"},
    "forces: zf = theta depends on theta, and zf has rates; give it in t": {"zf": "theta"},
    "forces: zf_dot is a rate of zf, and follows from it; give zf": {"zf_dot": "t"},
    "forces: zf: 3 rows are too few: zf has rates, and a spline that has them takes 6 at least": {
        "zf": ([0, 1, 3], [0, 1, 0])
    },
    "forces: zf has rates, and its table goes from 0 s to 1 s; give rows for the whole run, from 0 to 2 s": {
        "zf": (np.linspace(0, 1, 9), np.zeros(9))
    },
    "forces: zf: the function returned 1 number at t = 0 s; "
    "it returns 3: zf, zf_dot, zf_ddot; of a formula or a table the rates follow": {"zf": lambda t: 0.1},
    "forces: zf: the function takes 3 arguments; give one of t that returns zf, zf_dot, zf_ddot": {
        "zf": lambda t, q, u: 0.1
    },
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_has_no_rate_is_refused(table: symdyn.Scene, message: str) -> None:
    with pytest.raises(SimulateError) as found:
        symdyn.simulate(table, forces=REFUSED[message], until=2)
    assert str(found.value) == message


def test_no_controller_moves_a_support(table: symdyn.Scene) -> None:
    with pytest.raises(SimulateError) as found:
        symdyn.simulate(table, feedback=Feedback(lambda t, q, u: 0.0, ("zf",)), until=1)
    assert str(found.value) == "feedback: inputs: zf has rates, which no controller tells; give it in forces"


def test_a_kink_of_the_road_is_none_of_a_spring(mass: symdyn.Scene) -> None:
    run = symdyn.simulate(mass, forces={"y": "max(t - 0.1, 0)"}, until=0.3)
    assert run["y_dot"][-1] == 1


# Models, lessons, films


def test_a_model_has_rates_among_its_inputs(table: symdyn.Scene) -> None:
    model = model_of(sources_of(table), "fmi3")
    inputs = [one.get("name") for one in model.find("ModelVariables") or () if one.get("causality") == "input"]
    names = {one.get("valueReference"): one.get("name") for one in model.find("ModelVariables") or ()}
    depends = {
        names[one.get("valueReference")]: [names[k] for k in (one.get("dependencies") or "").split()]
        for one in model.find("ModelStructure") or ()
        if one.tag == "ContinuousStateDerivative"
    }
    assert inputs == ["zf", "zf_dot", "zf_ddot"]
    assert depends["der(z)"] == ["zf", "zf_dot"]
    assert depends["der(z_dot)"] == ["zf_ddot"]


@pytest.mark.parametrize(
    ("language", "sentence"),
    [("en", "the end of s on the ground moves as ($y$, $0$, $0$)"), ("sk", "koniec prvku s na ráme sa pohybuje ako")],
)
def test_a_lesson_tells_how_the_support_moves(mass: symdyn.Scene, language: str, sentence: str) -> None:
    assert sentence in next(iter(markdown(lesson_of(mass, language=language)).values()))


def test_a_film_moves_the_support(mass: symdyn.Scene, tmp_path: Path) -> None:
    from symdyn.draw.places import places

    run = symdyn.simulate(mass, forces={"y": "0.1*sin(20*t)"}, until=0.5)
    moved = np.hstack([run.q, run.inputs, run.t[:, None]])
    found = places(mass, moved, {"m": 2, "k": 800, "c": 12, "l": 0.5})
    assert_allclose(found.ends[mass.struts[0]][0][:, 0], run["y"], atol=1e-15)
    assert symdyn.film(run, tmp_path / "film.svg").stat().st_size > 1000


def test_an_acceleration_that_a_rate_moves_by_cancelling_terms_alone_has_a_transfer_function() -> None:
    """4e-16 of a sum that is zero was taken for a rate that passes at once: the standard curve of a quarter car."""
    for ct in (99, 100, 128):
        car = declared.scene(
            "quarter_car",
            gravity="none",
            parameters={"ct": ct},
            inputs=[declared.input_signal("zr", rates=1)],
            bodies=[declared.body("axle", mass=45), declared.body("cabin", mass=320)],
            joints=[
                declared.prismatic(
                    "tyre", "ground", "axle", axis=[0, 0, 1], coordinate="zu", drive=False,
                    force="-190e3*(zu-zr)-ct*(zu_dot-zr_dot)",
                ),
                declared.prismatic(
                    "strut", "axle", "cabin", axis=[0, 0, 1], coordinate="s", drive="F", damping=1500,
                    force="-22e3*s",
                ),
            ],
            outputs={"acc": "zu_ddot + s_ddot"},
        )  # fmt: skip
        lin = symdyn.linearize(car)

        assert lin.D.tolist() == [[pytest.approx(1 / 320), 0.0, 0.0]]
        assert lin.transfer("acc", "zr").gain == pytest.approx(ct * 1500 / (45 * 320))
        assert lin.step("acc", "zr").final[0, 0] == 0
