"""Contacts, stops and dry friction in runs, against closed forms and published figures; see tests/data/impacts."""

from __future__ import annotations

import json
from math import atan, pi
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.algebra import Floats
from symdyn.cli import main
from symdyn.dynamics.outputs.contact_outputs import _phase
from symdyn.errors import SceneError, SimulateError, SymdynError
from symdyn.graph import Graph, evaluate
from symdyn.scene import read_text, write_text
from symdyn.simulation.equations.complementarity import FREE, Laws

DATA = Path(__file__).parent / "data" / "impacts"
CASES = {one["id"]: one for one in json.loads((DATA / "references.json").read_text())["cases"]}

pytestmark = pytest.mark.runs("cc")

METHODS = ("taylor", "dop853")


def told(run: symdyn.Trajectory, what: list) -> float:
    """Return what a reference tells of a run."""
    kind, *rest = what
    if kind == "end":
        return float(run[rest[0]][-1])
    names = {"impact": "strikes", "stick": "sticks", "slip": "slips"}
    hits = [one for one in run.impacts if one.what == names[rest[0]] and _is(one.contact, rest[1]) and one.t > 1e-9]
    if kind == "time":
        return hits[rest[2]].t
    return float(run(hits[rest[2]].t + 1e-12)[rest[3]][0])


def _is(contact: str, name: str) -> bool:
    return name in (contact, contact.rpartition("_")[0])


@pytest.mark.parametrize("name", [one for one, case in CASES.items() if "scene" in case])
@pytest.mark.parametrize("method", METHODS)
def test_runs_agree_with_closed_forms(name: str, method: str) -> None:
    case = CASES[name]
    run = symdyn.simulate(symdyn.read(DATA / case["scene"]), until=case["until"], method=method, rtol=1e-13)
    for one in case["expect"]:
        assert told(run, one["what"]) == pytest.approx(one["value"], rel=0, abs=one["tol"]), one["what"]
    assert np.abs(run["energy_error"]).max() < 1e-10
    assert min((one.lost for one in run.impacts), default=0.0) >= 0.0
    missed = {name: value for name, value in run.monitors.items() if name.startswith(("penetration", "contact_laws"))}
    assert max(missed.values(), default=0.0) < 1e-11, missed


def test_flights_that_become_shorter_without_end_are_passed_in_their_limit() -> None:
    case = CASES["ball"]
    run = symdyn.simulate(symdyn.read(DATA / case["scene"]), until=6, method="taylor")
    assert run.impacts[-1].rest == pytest.approx(case["zeno_time"], rel=0, abs=case["zeno_tol"])
    resting = run.t > case["zeno_time"]
    assert np.all(run["z_dot"][resting] == 0.0)
    assert np.all(run["mode_floor"][resting] == 1.0)
    assert run["normal_floor"][-1] == pytest.approx(9.81)


BELT = """
gravity = [0, 0, -9.81]
[bodies.belt]
mass = 1
[bodies.rail]
[bodies.block]
mass = 1
[joints.belt]
type = "prismatic"
parent = "ground"
child = "belt"
axis = [1, 0, 0]
coordinate = "b"
motion = "0.5*t"
[joints.slide]
type = "prismatic"
parent = "ground"
child = "rail"
axis = [1, 0, 0]
coordinate = "x"
start_rates = 0.5
[joints.lift]
type = "prismatic"
parent = "rail"
child = "block"
axis = [0, 0, 1]
coordinate = "z"
[springs.s]
joint = "slide"
stiffness = 100
[contacts.c]
body = "block"
plane = { body = "belt", normal = [0, 0, 1] }
friction = 0.2
static = 0.4
"""


def test_a_block_on_a_belt_sticks_and_slips_with_the_period_of_its_closed_form() -> None:
    run = symdyn.simulate(read_text(BELT), until=3, method="taylor")
    slips = [one.t for one in run.impacts if one.what == "slips"]
    d = 0.2 * 9.81 / 100
    assert slips[0] == pytest.approx(CASES["stick_slip_belt"]["values"]["first_slip"], abs=1e-13)
    assert np.diff(slips) == pytest.approx(2 * (pi - atan(d * 10 / 0.5)) / 10 + 2 * d / 0.5, abs=1e-12)
    assert np.abs(run["energy_error"]).max() < 1e-12
    sticking = run["mode_c"] == 1
    assert np.all(run["x_dot"][sticking] == pytest.approx(0.5, abs=1e-12))
    assert np.all(np.abs(run["friction_c"]) <= 0.4 * run["normal_c"] + 1e-9)


TWO = """
gravity = [0, 0, 0]
[bodies.a]
inertia = [2, 2, 2]
inertia_about = "com"
[bodies.b]
inertia = [3, 3, 3]
inertia_about = "com"
[joints.a]
type = "revolute"
parent = "ground"
child = "a"
axis = [0, 0, 1]
coordinate = "p1"
start_rates = 10
[joints.b]
type = "revolute"
parent = "a"
child = "b"
axis = [0, 0, 1]
coordinate = "p2"
start_rates = 90
friction = { coulomb = 20 }
"""


def test_a_clutch_locks_when_its_closed_form_says() -> None:
    run = symdyn.simulate(read_text(TWO), until=8)
    (lock,) = run.impacts
    assert (lock.contact, lock.what) == ("b_friction", "sticks")
    assert lock.t == pytest.approx(90 / (20 / 2 + 20 / 3), abs=1e-12)
    assert run["p1_dot"][-1] == pytest.approx(64, abs=1e-12)  # (2*10 + 3*100)/5
    assert run["p2_dot"][-1] == pytest.approx(0, abs=1e-12)


def row_of_balls(law: str, restitution: float = 1) -> str:
    text = "gravity = [0, 0, 0]\n"
    for k, name in enumerate("abc"):
        text += f'[bodies.{name}]\nmass = 1\n[joints.{name}]\ntype = "prismatic"\nparent = "ground"\nchild = "{name}"\n'
        text += f'axis = [1, 0, 0]\ncoordinate = "x{name}"\nstart = {min(k, 1)}\nstart_rates = {1 - min(k, 1)}\n'
    for one, other in ("ab", "bc"):
        text += f'[contacts.{one}{other}]\ntype = "gap"\ngap = "x{other} - x{one}"\nlaw = "{law}"\n'
        text += f"restitution = {restitution}\n"
    return text


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_three_balls_at_once_part_as_published(law: str) -> None:
    run = symdyn.simulate(read_text(row_of_balls(law)), until=2)
    assert [run[f"x{name}_dot"][-1] for name in "abc"] == pytest.approx(CASES["three_balls"]["values"]["at_once"])
    assert sum(run[f"x{name}_dot"][-1] for name in "abc") == pytest.approx(1)


def wheel(slope: float, spokes: int = 8) -> str:
    text = f"""
gravity = ["9.81*sin({slope})", "-9.81*cos({slope})", 0]
[bodies.x]
[bodies.y]
[bodies.wheel]
mass = 1
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[joints.x]
type = "prismatic"
parent = "ground"
child = "x"
axis = [1, 0, 0]
coordinate = "x"
start_rates = "cos(pi/8)"
[joints.y]
type = "prismatic"
parent = "x"
child = "y"
axis = [0, 1, 0]
coordinate = "y"
start = "cos(pi/8)"
start_rates = "sin(pi/8)"
[joints.turn]
type = "revolute"
parent = "y"
child = "wheel"
axis = [0, 0, 1]
coordinate = "theta"
start_rates = -1
"""
    for k in range(spokes):
        angle = f"-pi/2 - pi/{spokes} + {k}*2*pi/{spokes}"
        text += f'[contacts.s{k}]\nbody = "wheel"\nat = ["cos({angle})", "sin({angle})", 0]\nnormal = [0, 1, 0]\n'
        text += "friction = 10\n"
    return text


def test_a_rimless_wheel_rolls_down_as_mcgeer_has_it() -> None:
    values = CASES["rimless_wheel"]["values"]["rates_after_strike"]
    run = symdyn.simulate(read_text(wheel(0.08)), until=4.6, method="taylor")
    strikes = [one.t for one in run.impacts if one.what == "strikes" and one.t > 1e-6]
    rates = [-float(run(t + 1e-9)["theta_dot"][0]) for t in dict.fromkeys(strikes)]
    assert rates[: len(values)] == pytest.approx(values[: len(rates)], abs=1e-7)
    assert len(rates) >= 4


# The laws in numbers


def drawn(rng: np.random.Generator) -> tuple[Laws, np.ndarray]:
    k, nv = int(rng.integers(1, 4)), 8
    B, W = rng.normal(size=(nv, nv)), rng.normal(size=(2 * k, nv))
    D = W @ np.linalg.solve(B @ B.T + 0.1 * np.eye(nv), W.T)
    mu, e = rng.uniform(0, 1, k), np.full(k, rng.uniform(0, 1))
    laws = Laws(D, tuple(range(0, 2 * k, 2)), tuple((i,) for i in range(1, 2 * k, 2)), mu, mu, e)
    return laws, W @ rng.normal(size=nv)


def kept(laws: Laws, impulses: np.ndarray, xi: np.ndarray) -> bool:
    small, slow = 1e-8 * max(1e-6, np.abs(impulses).max()), 1e-8 * max(1.0, np.abs(laws.D @ impulses).max())
    for k, (n, t) in enumerate(zip(laws.normals, (one[0] for one in laws.tangents), strict=True)):
        if impulses[n] < -small or xi[n] < -slow or (impulses[n] > small and xi[n] > slow):
            return False
        largest = laws.friction[k] * impulses[n]
        if abs(impulses[t]) > largest + small or (
            abs(xi[t]) > 1e-8 and abs(impulses[t] + np.sign(xi[t]) * largest) > 1e-7
        ):
            return False
    return True


def test_lemke_and_all_cases_find_the_same_impulses() -> None:
    rng, differ = np.random.default_rng(1), 0
    for _ in range(400):
        laws, v = drawn(rng)
        count = len(laws.normals)
        target = np.zeros(len(v))
        target[::2] = -laws.restitution * v[::2]
        every = [(FREE, *laws.slips(k)) for k in range(count)]
        cases = [found for _, found in laws.solutions(v, every, None, target)]
        pivots = laws.by_pivots(v, [0.0] * count, np.zeros(count), target)
        assert pivots is not None
        assert cases
        assert all(kept(laws, found, laws.D @ found + v - target) for found in (pivots, *cases))
        size = max(1e-6, np.abs(pivots).max())
        differ += min(np.abs(found - pivots).max() for found in cases) > 1e-8 * size
    assert differ == 0


def test_poisson_with_one_restitution_never_adds_energy_and_newton_may() -> None:
    rng, gained = np.random.default_rng(2), {True: 0, False: 0}
    for _ in range(400):
        laws, v = drawn(rng)
        for poisson in gained:
            impulses = laws.impact(v, [poisson] * len(laws.normals))
            work = impulses @ (2 * v + laws.D @ impulses) / 2
            gained[poisson] += work > 1e-14 * np.abs(impulses * v).sum()
    assert gained[True] == 0
    assert gained[False] > 0


ROD = (DATA / "scenes" / "falling_rod_0.36.toml").read_text()


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("friction", [0, 0.3, 2.5])
def test_the_impact_of_one_contact_is_a_formula(law: str, friction: float) -> None:
    text = ROD.replace('friction = "0.36"', f'friction = {friction}\nrestitution = 0.7\nlaw = "{law}"')
    scene = read_text(text)
    call = symdyn.load(scene, ["impact:foot", "delassus", "gap_rate:foot", "impact_matrix:foot"])
    rng = np.random.default_rng(3)
    for _ in range(50):
        q, u = rng.normal(size=3), rng.normal(size=3)
        D, v, C = call.delassus(q), call.gap_rate_foot(q, u), call.impact_matrix_foot(q)
        m, mu = len(D), np.array([friction])
        laws = Laws(D, (0,), ((1,) if m == 2 else (),), mu, mu, np.array([0.7]))
        impulses = laws.impact(v[:m], [law == "poisson"]) if v[0] < 0 else np.zeros(m)
        found = call.impact_foot(q, u)
        assert found[3 : 3 + m] == pytest.approx(impulses, abs=1e-12)
        assert found[:3] == pytest.approx(u + C[:, :m] @ impulses, abs=1e-12)


def test_the_formula_of_a_phase_is_that_of_all_cases_however_rough() -> None:
    """Where μ |D_nt| is above D_nn, no impulse fits one of the ways to slip."""
    graph, rng, steep = Graph(), np.random.default_rng(4), 0
    a, b, c, mu, vn, vt = letters = [graph.symbol(name) for name in ("a", "b", "c", "mu", "vn", "vt")]
    touch = SimpleNamespace(friction=mu)
    forms = _phase([[a, b], [b, c]], [vn, vt], touch, graph.zero)  # type: ignore[arg-type]
    for _ in range(400):
        B, size = rng.normal(size=(2, 2)), float(rng.uniform(0, 2))
        D, v = B @ B.T + 0.02 * np.eye(2), rng.normal(size=2) * (-1, 1)
        v[0] = -abs(v[0])
        laws = Laws(D, (0,), ((1,),), np.array([size]), np.array([size]), np.zeros(1))
        values = dict(zip(letters, [D[0, 0], D[0, 1], D[1, 1], size, *v], strict=True))
        assert evaluate(forms, Floats(), values) == pytest.approx(laws.impact(v, [False]), rel=1e-7, abs=1e-12)
        steep += D[0, 0] < size * abs(D[0, 1])
    assert steep > 20


def test_outputs_of_contacts_are_proved() -> None:
    names = ["gap:foot", "gap_jacobian:foot", "gap_rate:foot", "gap_jdot:foot", "impact_matrix:foot", "impact:foot"]
    found = symdyn.certify(read_text(ROD), [*names, "delassus", "contact_bias", "contact_dynamics"])
    assert found.passed
    assert len([one for one in found.findings if one.verdict == "proved"]) == 22


def test_the_dynamics_of_a_mode_keep_its_rows() -> None:
    q, u, tau = np.array([-0.2, 0.4, 0.4]), np.array([0.1, -0.2, 0.3]), np.zeros(3)
    call = symdyn.load(read_text(ROD), ["contact_dynamics", "forward_dynamics", "gap_jacobian:foot", "gap_jdot:foot"])

    def moved(closed: float, slip: float) -> np.ndarray:
        return np.asarray(call.contact_dynamics(q, u, tau, np.array([closed]), np.array([slip])))

    W, bias = call.gap_jacobian_foot(q), call.gap_jdot_foot(q, u)
    assert moved(0, 0)[:3] == pytest.approx(call.forward_dynamics(q, u, tau))
    assert W @ moved(1, 0)[:3] + bias == pytest.approx(np.zeros(3), abs=1e-13)
    slips = moved(1, 1)
    assert (W @ slips[:3] + bias)[0] == pytest.approx(0, abs=1e-13)
    assert slips[4] == pytest.approx(-0.36 * slips[3])


# What is wrong


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('friction = "0.36"', "restitution = 1.5", "contacts.foot: restitution = 1.5 is not between 0 and 1"),
        (
            'friction = "0.36"',
            "friction = 0.5\nstatic = 0.4",
            "contacts.foot: static = 0.4 is less than friction = 0.5; what sticks holds as much as what slips",
        ),
        (
            'friction = "0.36"',
            'law = "hertz"',
            'contacts.foot: law = "hertz" is not known; write "poisson" or "newton"',
        ),
        (
            'type = "point"',
            'type = "cube"',
            'contacts.foot: type = "cube" is not a contact; known are point, ball, wheel, gap',
        ),
        ('type = "point"', 'type = "ball"', "contacts.foot: radius is missing; write radius = 0.1"),
        ('body = "rod"', 'body = "rob"', 'contacts.foot: body = "rob" is not a body; did you mean rod?'),
    ],
)
def test_what_is_wrong_is_told(old: str, new: str, words: str) -> None:
    with pytest.raises(SceneError) as fault:
        read_text(ROD.replace(old, new))
    assert words in str(fault.value)


GAP = row_of_balls("poisson").replace('gap = "xb - xa"', 'gap = "GAP"\ntangent = "TANGENT"\nfriction = 0.1')


@pytest.mark.parametrize(
    ("gap", "tangent", "words"),
    [
        (
            "xb - xa_dot",
            "xa_dot",
            "gap = xb - xa_dot uses xa_dot; a gap is a formula in coordinates and parameters",
        ),
        ("xb - xa", "xa_dot**2", "contacts.ab: tangent = xa_dot**2 is not linear in the velocities"),
        ("xb - xa", "xa", "contacts.ab: tangent = xa is no sum of velocities, each times a formula in coordinates"),
    ],
)
def test_formulas_of_contacts_that_are_none_are_told(gap: str, tangent: str, words: str) -> None:
    with pytest.raises(SceneError) as fault:
        read_text(GAP.replace("GAP", gap).replace("TANGENT", tangent))
    assert words in str(fault.value)


def test_a_restitution_needs_a_limit() -> None:
    with pytest.raises(SceneError) as fault:
        read_text(TWO.replace("friction = { coulomb = 20 }", "limits = { restitution = 0.5 }"))
    assert "limits.restitution goes with lower or upper, which the joint strikes; give one of them" in str(fault.value)


def test_a_contact_that_begins_inside_its_plane_is_told() -> None:
    with pytest.raises(SimulateError) as fault:
        symdyn.simulate(read_text(ROD), until=1, start="y=0.3")
    assert "contact foot begins 0.199" in str(fault.value)
    assert "start where it touches, or above" in str(fault.value)


@pytest.mark.parametrize(
    "ask",
    [
        symdyn.linearize,
        lambda scene: symdyn.sensitivity(scene, until=0.1),
        lambda scene: symdyn.inverse(scene, motion="x=t,y=1,theta=0", until=1),
        lambda scene: symdyn.collocation(scene, until=1, cost="1"),
    ],
)
def test_what_knows_no_contacts_refuses_them(ask) -> None:
    with pytest.raises(SymdynError) as fault:
        ask(read_text(ROD))
    assert "contacts" in str(fault.value)


def test_a_method_that_begins_anew_slowly_is_refused() -> None:
    with pytest.raises(SymdynError) as fault:
        symdyn.simulate(read_text(ROD), until=1, method="lsoda")
    assert "it would begin anew at every event of a contact, with small steps; take radau" in str(fault.value)


def test_a_scene_with_contacts_is_written_as_it_was_read() -> None:
    for text in (ROD, BELT, TWO, row_of_balls("newton"), wheel(0.1)):
        scene = read_text(text)
        assert read_text(write_text(scene, "toml").text) == scene


def test_contacts_are_declared_in_python() -> None:
    scene = symdyn.scene.scene(
        "ball",
        bodies=[symdyn.scene.body("ball", mass=1)],
        joints=[symdyn.scene.joint("fall", "prismatic", "ground", "ball", axis=[0, 0, 1], coordinate="z", start=1)],
        contacts=[symdyn.scene.contact("floor", body="ball", restitution=0.8)],
    )
    assert (
        scene.unilaterals[0].restitution
        == read_text((DATA / "scenes/ball.toml").read_text()).unilaterals[0].restitution
    )


def test_an_ensemble_of_contacts_runs_one_by_one() -> None:
    scene = symdyn.read(DATA / "scenes/ball.toml")
    found = symdyn.ensemble(scene, start={"z": [1.0, 2.0]}, until=0.7, measures="max(abs(z_dot))")
    speeds = [(2 * 9.81 * z) ** 0.5 for z in (1, 2)]
    assert np.ravel(found["max(abs(z_dot))"]) == pytest.approx(speeds, rel=0.05)


def test_a_rod_slips_at_the_angle_of_its_closed_form() -> None:
    run = symdyn.simulate(read_text(ROD), until=1, method="taylor")
    slip = next(one for one in run.impacts if one.what == "slips")
    assert float(run(slip.t)["theta"][0]) == pytest.approx(CASES["falling_rod_0.36"]["slips_at_angle"], abs=1e-10)


# What a second look found

FALL = """
gravity = [0, 0, -9.81]
[parameters]
e = 0.7
[bodies.b]
mass = 1
[joints.z]
type = "prismatic"
parent = "ground"
child = "b"
axis = [0, 0, 1]
coordinate = "z"
start = 0
[contacts.f]
body = "b"
restitution = "e"
"""

TABLE = FALL.replace('body = "b"\nrest', 'body = "b"\nplane = { body = "table", normal = [0, 0, 1] }\nrest')
TABLE += """
[bodies.table]
mass = 3
[joints.t]
type = "prismatic"
parent = "ground"
child = "table"
axis = [0, 0, 1]
coordinate = "h"
motion = "0.05*sin(20*t)"
"""

SLOPE = """
gravity = ["9.81*sin(0.4)", 0, "-9.81*cos(0.4)"]
[bodies.rail]
[bodies.b]
mass = 1
[joints.x]
type = "prismatic"
parent = "ground"
child = "rail"
axis = [1, 0, 0]
coordinate = "x"
[joints.z]
type = "prismatic"
parent = "rail"
child = "b"
axis = [0, 0, 1]
coordinate = "z"
[contacts.c]
body = "b"
plane = { body = "ground", normal = [0, 0, 1] }
friction = 0.3
static = 0.6
"""

KNEE = """
gravity = [0, 0, -9.81]
[bodies.b]
mass = 2
com = [0.5, 0, 0]
inertia = [0, 0.2, 0.2]
inertia_about = "com"
[joints.h]
type = "revolute"
parent = "ground"
child = "b"
axis = [0, 1, 0]
coordinate = "q"
limits = { lower = -1, upper = 0.5, restitution = 0 }
"""


def test_what_is_pulled_up_lifts_off_again_and_again() -> None:
    run = symdyn.simulate(read_text(FALL), until=1, forces="tau1=20*t")
    assert [one.what for one in run.impacts] == ["lifts off"]
    assert run["z"][-1] == pytest.approx(20 / 6 * (1 - 9.81 / 20) ** 3)
    run = symdyn.simulate(read_text(FALL), until=4, forces="tau1=15*sin(5*t)", values={"e": 0})
    assert [one.what for one in run.impacts] == ["lifts off", "strikes"] * 3 + ["lifts off"]
    assert run["gap_f"].min() > -1e-12
    assert run["normal_f"].min() >= 0
    run = symdyn.simulate(read_text(KNEE), until=2, forces="tau1=-15*t")
    assert [(one.contact, one.what) for one in run.impacts][:2] == [("h_upper", "strikes"), ("h_upper", "lifts off")]
    assert "rad/s" in run.impacts[0].words


@pytest.mark.parametrize("e", [0, 0.7])
def test_a_plane_that_moves_as_it_is_told_keeps_the_balance_of_energy(e: float) -> None:
    run = symdyn.simulate(read_text(TABLE), until=2, start="z=0.1", values={"e": e})
    assert len(run.impacts) > 6
    assert np.abs(run["energy_error"]).max() < 1e-11
    assert run["gap_f"].min() > -1e-12
    assert min(one.lost for one in run.impacts) >= 0


@pytest.mark.parametrize(("rate", "sticks"), [(0, 0.0), (-1, 1 / 9.81 / (np.sin(0.4) + 0.3 * np.cos(0.4)))])
def test_static_friction_holds_what_sliding_friction_would_not(rate: float, sticks: float) -> None:
    run = symdyn.simulate(read_text(SLOPE), until=1, start_rates=f"x_dot={rate}")
    assert run["mode_c"][-1] == 1
    assert run["x_dot"][-1] == 0
    assert [one.t for one in run.impacts] == pytest.approx([sticks] if rate else [])


def test_formulas_of_accelerations_know_the_forces_of_contacts() -> None:
    scene = read_text(SLOPE.replace("0.4)", "0)") + '[outputs]\na = "x_ddot"\n')
    run = symdyn.simulate(scene, until=1, start_rates="x_dot=1", stops=["x_ddot + 2"])
    assert run["a"][0] == pytest.approx(-0.3 * 9.81)
    assert run.t[-1] == pytest.approx(1 / (0.3 * 9.81))


@pytest.mark.parametrize(
    ("more", "asked", "words"),
    [
        (
            "",
            {"stops": ["reaction_z_fx"]},
            "reaction_z_fx: events do not know the forces of contacts in them; name normal_NAME",
        ),
        ("[inputs.gap_f]\n", {}, "gap_f is the name of a column of contact f, too; rename it or the contact"),
        ('[outputs]\nmode_f = "z"\n', {}, "mode_f is the name of a column of contact f, too"),
    ],
)
def test_what_a_run_with_contacts_cannot_tell_is_refused(more: str, asked: dict[str, Any], words: str) -> None:
    with pytest.raises(SymdynError) as fault:
        symdyn.simulate(read_text(FALL + more), until=1, **asked)
    assert words in str(fault.value)


def test_starts_beyond_a_stop_and_names_of_stops_are_told_in_their_words() -> None:
    with pytest.raises(SimulateError) as fault:
        symdyn.simulate(read_text(KNEE), until=1, start="q=0.7")
    assert "start: stop h_upper is passed by 0.2 rad; start the joint within its limits" in str(fault.value)
    with pytest.raises(SimulateError) as fault:
        symdyn.simulate(read_text(KNEE + '[contacts.h_upper]\nbody = "b"\n'), until=1)
    assert "h_upper is the name of a stop or a friction, too" in str(fault.value)


def test_friction_that_turns_round_at_once_does_not_stick() -> None:
    scene = read_text(KNEE.replace("restitution = 0 }", "restitution = 0.5 }\nfriction = { coulomb = 2 }"))
    run = symdyn.simulate(scene, until=0.5)
    assert [one.what for one in run.impacts] == ["strikes", "slips"]
    assert run.impacts[1].mode[-1] == "slips +"
    told = symdyn.simulate(scene, until=0.1, reactions=True)  # beside stops and friction of joints they are known
    assert np.isfinite(told["reaction_h_fz"]).all()
    formula = read_text(write_text(scene, "toml").text + '[outputs]\nr = "reaction_h_fz"\n')
    assert symdyn.simulate(formula, until=0.1)["r"] == pytest.approx(told["reaction_h_fz"])


def test_a_run_between_its_samples_tells_the_impacts_of_the_run() -> None:
    run = symdyn.simulate(read_text(FALL), until=1, start="z=1", every=0.5)
    assert len(run(0.9).impacts) == len(run.impacts) == 1
    assert run(0.7)["z_dot"][0] == pytest.approx(0.7 * (2 * 9.81) ** 0.5 - 9.81 * (0.7 - (2 / 9.81) ** 0.5))


def test_who_takes_contacts_as_open_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, text in (("fall", FALL), ("knee", KNEE)):
        (tmp_path / f"{name}.toml").write_text(text)
        for verb in ("equations", "info"):
            assert main([verb, str(tmp_path / f"{name}.toml")]) == 0
            err = capsys.readouterr().err
            assert f"{name}: all contacts open: {'f' if name == 'fall' else 'stops of h'}; runs, sensitivity" in err
    main(["info", str(tmp_path / "fall.toml")])
    assert "restitution e, friction 0, Poisson's law" in capsys.readouterr().out
    assert "limits.restitution: the file has limits that nothing strikes" in "".join(
        write_text(read_text(KNEE), "urdf", lossy=True).lost
    )


BLOCK = """
gravity = [0, 0, -9.81]
[bodies.x]
[bodies.z]
[bodies.b]
mass = 1
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[joints.x]
type = "prismatic"
parent = "ground"
child = "x"
axis = [1, 0, 0]
coordinate = "x"
[joints.z]
type = "prismatic"
parent = "x"
child = "z"
axis = [0, 0, 1]
coordinate = "z"
start = 0.5
[joints.r]
type = "revolute"
parent = "z"
child = "b"
axis = [0, 1, 0]
coordinate = "r"
"""
for at in (-0.3, 0.3):
    BLOCK += f'[contacts.c{int(at > 0)}]\nbody = "b"\nat = [{at}, 0, -0.5]\nfriction = 0.5\n'
    BLOCK += 'plane = { body = "ground", normal = [0, 0, 1] }\n'


def test_a_block_on_two_corners_slides_when_both_are_at_the_edge_of_their_cones() -> None:
    run = symdyn.simulate(read_text(BLOCK), until=1, forces="tau1=8*t")
    slips = 0.5 * 9.81 / 8
    assert run["x_dot"][-1] == pytest.approx(4 * (1 - slips**2) - 0.5 * 9.81 * (1 - slips))
    assert run.impacts[-1].t == pytest.approx(slips)


def test_a_block_that_rocks_from_corner_to_corner_comes_to_rest() -> None:
    run = symdyn.simulate(read_text(BLOCK), until=2, start="z=0.8, r=0.3")
    assert min(run["gap_c0"].min(), run["gap_c1"].min()) > -1e-11
    assert (run["mode_c0"][-1], run["mode_c1"][-1]) == (1, 1)
    assert run["z"][-1] == pytest.approx(0.5, abs=1e-9)
    assert np.abs(run["energy_error"]).max() < 1e-10


LOOPED = """
gravity = [0, 0, -9.81]
[bodies.left]
mass = 1
com = [0.2, 0, 0]
inertia = [0.02, 0.02, 0.02]
inertia_about = "com"
[bodies.right]
mass = 2
com = [0.3, 0, 0]
inertia = [0.03, 0.03, 0.03]
inertia_about = "com"
[bodies.coupler]
mass = 3
[joints.a]
type = "revolute"
parent = "ground"
child = "left"
axis = [0, 1, 0]
coordinate = "a"
start = 0.2
[joints.b]
type = "revolute"
parent = "ground"
child = "right"
axis = [0, 1, 0]
origin = [1, 0, 0]
coordinate = "b"
start = 0.2
[joints.c]
type = "revolute"
parent = "left"
child = "coupler"
axis = [0, 1, 0]
origin = [0.5, 0, 0]
coordinate = "c"
start = -0.2
[[loop]]
type = "revolute"
parent = "coupler"
child = "right"
axis = [0, 1, 0]
origin = [1, 0, 0]
tip = [-0.5, 0, 0]
[contacts.floor]
body = "coupler"
at = [0.4, 0, -0.1]
restitution = 0.5
friction = 0.2
plane = { at = [0, 0, -0.45], normal = [0, 0, 1] }
"""
"""A parallelogram, which is a pendulum of one angle."""

ALONE = """
gravity = [0, 0, -9.81]
[parameters]
J = "0.02 + 0.03 + 1*0.2**2 + 2*0.3**2 + 3*0.5**2"
Jc = "J - (1*0.2 + 2*0.3 + 3*0.5)**2/6"
[bodies.arm]
mass = 6
com = ["(1*0.2 + 2*0.3 + 3*0.5)/6", 0, 0]
inertia = ["Jc/2", "Jc", "Jc/2"]
inertia_about = "com"
[joints.a]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 1, 0]
coordinate = "a"
start = 0.2
[contacts.floor]
type = "gap"
gap = "0.35 - 0.5*sin(a)"
tangent = "-0.5*a_dot*sin(a)"
restitution = 0.5
friction = 0.2
"""


def test_contacts_of_a_loop_are_those_of_the_same_mechanism_without() -> None:
    one, other = (
        symdyn.simulate(read_text(text), until=3, method="dop853", rtol=1e-11, atol=1e-12) for text in (LOOPED, ALONE)
    )
    assert one["a"] == pytest.approx(other["a"], abs=1e-7)
    assert [hit.t for hit in one.impacts[:8]] == pytest.approx([hit.t for hit in other.impacts[:8]], abs=1e-8)
    assert one.impacts[0].impulse == pytest.approx(other.impacts[0].impulse, rel=1e-7)
    assert one["normal_floor"][-1] == pytest.approx(other["normal_floor"][-1])
    assert np.abs(one["loop_error"]).max() < 1e-9


ROPE = """
gravity = [0, 0, -9.81]
[bodies.x]
[bodies.b]
mass = 1
[joints.x]
type = "prismatic"
parent = "ground"
child = "x"
axis = [1, 0, 0]
coordinate = "x"
[joints.z]
type = "prismatic"
parent = "x"
child = "b"
axis = [0, 0, 1]
coordinate = "z"
start = -1
[ropes.r]
type = "slack"
through = ["ground", "b"]
length = 1
"""


def test_a_pendulum_on_a_rope_leaves_its_circle_where_its_closed_form_says() -> None:
    """At (v² - 2 g l)/(3 g l) above the pivot; then a parabola until it is taut again."""
    scene = read_text(ROPE)
    run = symdyn.simulate(scene, until=2, start_rates={"x_dot": (3.5 * 9.81) ** 0.5}, rtol=1e-12)
    slack, taut = run.impacts[:2]
    assert (slack.what, taut.what) == ("goes slack", "becomes taut")
    assert run(slack.t)["z"][0] == pytest.approx(0.5, abs=1e-9)
    falls = taut.t - slack.t
    speed = (0.5 * 9.81) ** 0.5  # v² = g l sin φ where it leaves
    x, z = run(slack.t)["x"][0] - 0.5 * speed * falls, 0.5 + 0.75**0.5 * speed * falls - 9.81 / 2 * falls**2
    assert np.hypot(x, z) == pytest.approx(1, abs=1e-9)
    assert "becomes taut" in taut.words
    assert "J lost" in taut.words
    assert symdyn.certify(scene, ["gap:r", "gap_jacobian:r", "gap_jdot:r", "impact:r"]).passed
    assert read_text(write_text(scene, "toml").text) == scene


@pytest.mark.filterwarnings("error")
def test_a_slack_rope_whose_ends_meet_is_told() -> None:
    with pytest.raises(SimulateError, match=r"start: r has no direction there, as of a rope whose ends meet"):
        symdyn.simulate(read_text(ROPE), until=1, start="z=0")


def test_a_slack_rope_around_a_wheel_is_told() -> None:
    over = ', { body = "ground", at = [0, 0, 1], radius = 0.1, axis = [0, 1, 0], turn = "left" }, "b"]'
    with pytest.raises(SceneError, match=r"ropes\.r: a rope that may be slack leaves a wheel, and its length jumps"):
        read_text(ROPE.replace(', "b"]', over))


def test_what_is_not_active_passes_its_plane() -> None:
    """A compass walker scuffs with its swinging leg; every published gait lets it."""
    scene = read_text(FALL.replace('restitution = "e"', 'restitution = "e"\nactive = "z + 2"'))
    run = symdyn.simulate(scene, until=1, start="z=1")
    assert run.impacts[0].t == pytest.approx((2 / 9.81) ** 0.5)
    scene = read_text(FALL.replace('restitution = "e"', 'restitution = "e"\nactive = "-z - 2"'))
    assert not symdyn.simulate(scene, until=1, start="z=1").impacts


HELD = FALL.replace("contacts.f", "contacts.floor").replace("e = 0.7", "e = 0").replace("start = 0", "start = 1")


@pytest.mark.parametrize("method", ["taylor", "radau"])
@pytest.mark.parametrize(
    ("column", "least", "t", "there"),
    [("gap_floor", 0.1, 0.428352936878, 0.1), ("normal_floor", 5, 0.451523640986, 9.81)],
)
def test_a_column_of_a_contact_ends_a_run(method: str, column: str, least: float, t: float, there: float) -> None:
    run = symdyn.simulate(read_text(HELD), until=3, stops=[f"{column} - {least}"], method=method)

    assert run.stopped == f"{column} - {least}"
    assert run.t[-1] == pytest.approx(t, abs=1e-9)
    assert run[column][-1] == pytest.approx(there, abs=1e-8)


@pytest.mark.parametrize("name", ["friction_floor", "mode_floor", "normal_flor"])
def test_a_column_of_a_contact_that_there_is_not_is_told(name: str) -> None:
    with pytest.raises(
        SimulateError, match=f"{name}.* not known|{name} is no column of this scene; known are gap_floor"
    ):
        symdyn.simulate(read_text(HELD), until=3, stops=[f"{name} - 1"])
