"""Springs, dampers, friction, loads, prescribed motions: against formulas by hand, by both formulations, everywhere."""

from __future__ import annotations

import ctypes
import math
from dataclasses import replace

import numpy as np
import pytest
from mechanisms import coupled_tree, random_tree, with_loads
from running import agreements, call

from symdyn.algebra.numeric import Floats
from symdyn.dynamics import OUTPUTS, Workspace, available, derive, derive_one, expected, formulations_of
from symdyn.dynamics.closed_forms.closed_form import closed_form
from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.recursive.tree_dynamics import rnea
from symdyn.emit import emit
from symdyn.emit.print.equations_text import equations_text
from symdyn.errors import DerivationError
from symdyn.program import formulate, lower
from symdyn.runtime import build, lambdify
from symdyn.runtime.backends.load_functions import load as load_scene
from symdyn.scene import Quantity, Scene, body, parse, prismatic, revolute, scene
from symdyn.scene.forces.applied_forces import Damper, Friction, Spring
from symdyn.scene.values import Body, Joint, Load, Parameter, Place
from symdyn.verdict import Verdict
from symdyn.verify import certify
from symdyn.verify.certificate import on_unit_sphere
from symdyn.verify.equality import Claim, prove
from symdyn.verify.laws import laws

RNG = np.random.default_rng(5)


def vec(*formulas):
    return tuple(parse(str(formula)) for formula in formulas)


def pendulum(**more):
    """A point mass m at distance l, turning about y from the horizontal x axis downwards; gravity 9.81 along -z."""
    names = ("m", "l", "k", "c", "h", "s0", "F")
    one = scene(
        "pendulum",
        parameters=dict.fromkeys(names),
        bodies=[body("bob", mass="m", com=["l", 0, 0])],
        joints=[revolute("hinge", "ground", "bob", axis=[0, 1, 0], coordinate="q1")],
    )
    joint = {key: more.pop(key) for key in ("dry", "motion", "damping") if key in more}
    return replace(one, joints=(replace(one.joints[0], **joint),), **more)


VALUES = (1.3, 0.7, 40.0, 2.5, 0.9, 0.5, 3.0)  # m, l, k, c, h, s0, F
M, L, K, C, H, S0, F = VALUES
TIP = Place("bob", vec("l", 0, 0))
ABOVE = Place("ground", vec(0, 0, "h"))


def length(q):
    """Distance of the tip (l cos q, 0, -l sin q) from (0, 0, h)."""
    return math.sqrt(L * L + H * H + 2 * L * H * math.sin(q))


def inverse(one, q, qd, qdd, *time):
    return float(lambdify(one, "inverse_dynamics")([q], [qd], [qdd], *time, VALUES)[0])


def without_load(q, qdd):
    return M * L * L * qdd - 9.81 * M * L * math.cos(q)


# Against formulas by hand


def test_spring_at_a_joint():
    spring = Spring("s", "hinge", (), vec("k", 5), free=parse("s0"), preload=Quantity.number(2))
    one, q = pendulum(elements=(spring,)), 0.8
    x = q - S0

    assert inverse(one, q, 0.3, 0.4) == pytest.approx(without_load(q, 0.4) + 2 + K * x + 5 * x * x, rel=1e-14)
    assert lambdify(one, "k_E")([q], VALUES)[0] == pytest.approx(2 + K * x + 5 * x * x, rel=1e-14)
    energy = -9.81 * M * L * math.sin(q) + 2 * x + K * x * x / 2 + 5 * x**3 / 3
    assert lambdify(one, "potential_energy")([q], VALUES) == pytest.approx(energy, rel=1e-14)
    assert lambdify(one, "gravity_forces")([q], VALUES)[0] == pytest.approx(without_load(q, 0), rel=1e-14)


def test_spring_between_points():
    one, q = pendulum(elements=(Spring("s", "", (ABOVE, TIP), vec("k"), free=parse("s0")),)), 0.8
    s = length(q)
    slope = L * H * math.cos(q) / s

    assert lambdify(one, "elastic_forces")([q], VALUES)[0] == pytest.approx(K * (s - S0) * slope, rel=1e-14)
    energy = -9.81 * M * L * math.sin(q) + K * (s - S0) ** 2 / 2
    assert lambdify(one, "potential_energy")([q], VALUES) == pytest.approx(energy, rel=1e-14)


def test_damper_between_points_and_at_a_joint():
    far, near = Damper("d", "", (TIP, ABOVE), vec("c", 4)), Damper("e", "hinge", (), vec("c", 0, 2))
    one, q, qd = pendulum(elements=(far, near)), 0.8, -1.7
    slope = L * H * math.cos(q) / length(q)
    v = slope * qd

    expected = without_load(q, 0) + (C * v + 4 * v**3) * slope + C * qd + 2 * qd**5
    assert inverse(one, q, qd, 0) == pytest.approx(expected, rel=1e-14)


def test_points_that_never_part_pull_at_nothing():
    """A spring that would pull and a damper between the hinge and itself change nothing, by any formulation."""
    ends = Place("ground", vec(0, 0, 0)), Place("bob", vec(0, 0, 0))
    one = pendulum(elements=(Spring("s", "", ends, vec("k"), free=parse("s0")), Damper("d", "", ends, vec("c"))))
    state = {"q": [0.8], "qd": [-1.7], "qdd": [0.6], "params": VALUES}

    for formulation in formulations_of("inverse_dynamics"):
        forces = call(derive(one, ["inverse_dynamics"], formulation), "inverse_dynamics", Floats(), **state)
        assert forces == pytest.approx([without_load(0.8, 0.6)], rel=1e-14)
    with_pair, alone = (lambdify(x, "reactions")([0.8], [-1.7], [0.6], VALUES) for x in (one, pendulum()))
    np.testing.assert_allclose(with_pair, alone, atol=1e-14)


@pytest.mark.parametrize("frame", ["ground", "body"])
def test_load_in_either_frame(frame):
    wrench = Load("w", TIP, vec("F*cos(t)", 1, "2*q1_dot"), vec(0, "q1*t", 7), frame)
    one, q, qd, t = pendulum(elements=(wrench,)), 0.8, -1.7, 0.6
    f = (F * math.cos(t), 1, 2 * qd)
    across = -math.sin(q) * f[0] - math.cos(q) * f[2] if frame == "ground" else -f[2]

    assert inverse(one, q, qd, 0, t) == pytest.approx(without_load(q, 0) - L * across - q * t, rel=1e-13)


def test_stribeck_friction_smoothed_and_ideal():
    rough = Friction("hinge", Quantity.number(2), Quantity.number(5), parse("0.1"), parse("0.01"))
    smooth = pendulum(dry=rough)
    ideal = pendulum(dry=replace(rough, smoothing=Quantity.number(0)))

    def friction(one, v):
        return inverse(one, 0.0, v, 0.0) - inverse(pendulum(), 0.0, v, 0.0)

    for v in (-3.0, -0.05, 0.0, 0.05, 0.1, 2.0):
        size = 2 + 3 * math.exp(-((v / 0.1) ** 2))
        assert friction(smooth, v) == pytest.approx(size * math.tanh(v / 0.01), rel=1e-13, abs=1e-13)
        assert friction(ideal, v) == pytest.approx(size * np.sign(v), rel=1e-13, abs=1e-13)
    assert friction(smooth, 2.0) == pytest.approx(friction(ideal, 2.0), rel=1e-13)  # far from rest they are one


def test_a_spring_pendulum_moves_as_the_book_says():
    """A point mass on a spring along a slider that turns: m r̈ - m r θ̇² - m g cos θ + k (r - r0) = 0."""
    one = scene(
        "spring_pendulum",
        parameters=dict.fromkeys(("m", "k", "r0")),
        gravity=[0, "-9.81", 0],
        bodies=[body("rod"), body("bob", mass="m")],
        joints=[
            revolute("hinge", "ground", "rod", coordinate="theta"),
            prismatic("slider", "rod", "bob", axis=[0, -1, 0], coordinate="r"),
        ],
    )
    one = replace(one, elements=(Spring("s", "slider", (), vec("k"), free=parse("r0")),))
    m, k, r0, (theta, r), (w, v) = 1.3, 40.0, 0.5, (0.4, 0.8), (1.1, -0.6)
    expected = [
        -(2 * v * w + 9.81 * math.sin(theta)) / r,
        r * w * w + 9.81 * math.cos(theta) - k / m * (r - r0),
    ]

    found = lambdify(one, "forward_dynamics")([theta, r], [w, v], [0, 0], [m, k, r0])
    assert found == pytest.approx(expected, rel=1e-13)


def governor():
    """Two arms of length l on a massless vertical spindle, one following the other, a spring between the two balls."""
    ball = {"mass": "m", "com": [0, 0, "-l"]}
    one = scene(
        "governor",
        parameters=dict.fromkeys(("m", "l", "k", "s0")),
        bodies=[body("spindle"), body("left", **ball), body("right", **ball)],
        joints=[
            revolute("spin", "ground", "spindle", coordinate="psi"),
            revolute("arm", "spindle", "left", axis=[0, 1, 0], coordinate="theta"),
            revolute("twin", "spindle", "right", axis=[0, 1, 0], mimic={"joint": "arm", "ratio": -1}),
        ],
    )
    balls = (Place("left", vec(0, 0, "-l")), Place("right", vec(0, 0, "-l")))
    return replace(one, elements=(Spring("s", "", balls, vec("k"), free=parse("s0")),))


def test_a_governor_with_a_spring_finds_its_balance():
    """2 m l² (θ̈ - ψ̇² sin θ cos θ) + 2 m g l sin θ + k (2 l sin θ - s0) 2 l cos θ = 0; ψ̈ = 0 where θ̇ = 0."""
    m, arm, k, s0, theta, speed = 0.8, 0.5, 30.0, 0.2, 0.6, 9.0
    sin, cos = math.sin(theta), math.cos(theta)
    expected = speed**2 * sin * cos - 9.81 / arm * sin - k * (2 * arm * sin - s0) * 2 * arm * cos / (2 * m * arm * arm)

    found = lambdify(governor(), "forward_dynamics")([0.3, theta], [speed, 0], [0, 0], [m, arm, k, s0])
    assert found == pytest.approx([0, expected], rel=1e-12, abs=1e-12)


# Both formulations and every law, proved


def floating():
    """A free body and one on a ball joint, with quaternions, under all kinds of loads."""
    joints = (
        Joint(
            "ship",
            "free",
            "ground",
            "hull",
            coordinates=tuple("xyzabcd"),
            velocities=("v1", "v2", "v3", "w1", "w2", "w3"),
        ),
        Joint("ball", "spherical", "hull", "crane", coordinates=tuple("efgh"), velocities=("w4", "w5", "w6")),
    )
    inertia = tuple(Quantity.number(k) for k in (2, 3, 4, 0, 0, 0))
    bodies = tuple(
        Body(name, Quantity.number(k), vec("0.1", 0, "0.2"), None, inertia) for k, name in ((2, "hull"), (1, "crane"))
    )
    return with_loads(Scene("floating", (Parameter("gravity"),), vec(0, 0, "-gravity"), bodies, joints), 3)


LOADED = [
    *(with_loads(random_tree(seed, 4 if seed < 2 else 3), seed) for seed in range(6)),
    *(with_loads(coupled_tree(seed, 4 if seed < 2 else 3), seed) for seed in range(4)),
    floating(),
]


@pytest.mark.wide("floating_loaded")
@pytest.mark.long(0)
@pytest.mark.parametrize("one", LOADED, ids=lambda one: one.name)
def test_both_formulations_and_all_laws_are_proved(one):
    w = Workspace(one)
    asked = [name for name in expected(one) if one.name != "floating_loaded" or not OUTPUTS[name].cubic]
    claims = [claim for claim in [*laws(w, asked), *agreements(w, asked)] if claim.left or claim.name != "k_C"]
    findings = prove(on_unit_sphere(one, claims))[1]  # k_C of one coordinate has no entries

    assert {finding.claim for finding in findings if finding.verdict != Verdict.PROVED} == set()
    assert any("g + k_E" in finding.claim for finding in findings)
    assert any(finding.claim.startswith("power balance") for finding in findings)


def test_a_distance_that_is_a_square_is_proved_for_either_sign_of_its_root():
    """The balls of the governor are 2 l |sin θ| apart: what holds for one sign of the root need not for the other."""
    findings = prove(laws(Workspace(governor()), expected(governor())))[1]

    assert {finding.verdict for finding in findings} == {Verdict.PROVED}


def test_a_load_rides_the_recursion_and_costs_little():
    one = random_tree(3, 6, free=False)
    load = Load("tool", Place(one.bodies[-1].name, vec(1, 2, 3)), vec("t", 2, 5), vec(1, 2, 3), "body")
    w = Workspace(replace(one, elements=(load,)))
    varying = (*w.state.q, *w.state.qd, *w.state.qdd, w.graph.symbol("t"))
    alone = rnea(w.recursion_tree, w.state.qd, w.state.qdd)

    assert cost(derive_one(w, "inverse_dynamics", "rnea").entries, varying) - cost(alone, varying) < 40
    assert cost(w.Q, varying) > 60


# Ideal friction


def test_ideal_friction_is_refused_in_forward_dynamics_with_the_reason_and_what_to_do():
    one = pendulum(dry=Friction("hinge", Quantity.number(1)))

    for formulation in formulations_of("forward_dynamics", one):
        with pytest.raises(DerivationError, match=r"joint hinge is an ideal sign .* at rest .* smoothing .* inverse"):
            derive(one, ["forward_dynamics"], formulation)
    wanted, why = available(one)
    assert "inverse_dynamics" in wanted
    assert "forward_dynamics" not in wanted
    assert "ideal sign" in " ".join(why)


def linkage(**changes):
    """The pendulum with its tip on a vertical plane: a scene with a loop."""
    joint = Joint("guide", "point_on_plane", "ground", "bob", (("axis", vec(1, 0, 0)),))
    return replace(pendulum(**changes), loops=(joint,))


def test_closed_scenes_refuse_ideal_friction_too():
    with pytest.raises(DerivationError, match=r"hinge is an ideal sign"):
        derive(linkage(dry=Friction("hinge", Quantity.number(1))), ["forward_dynamics"])


# Prescribed motions


def cart_pole(motion=None):
    """A cart on x and a pole of length l with a point mass m, from the downward vertical; cart of mass 2."""
    one = scene(
        "cart",
        parameters=dict.fromkeys(("m", "l")),
        gravity=[0, "-9.81", 0],
        bodies=[body("cart", mass=2), body("pole", mass="m", com=[0, "-l", 0])],
        joints=[
            prismatic("rail", "ground", "cart", axis=[1, 0, 0], coordinate="x"),
            revolute("hinge", "cart", "pole", coordinate="phi"),
        ],
    )
    return replace(one, joints=(replace(one.joints[0], motion=motion and parse(motion)), one.joints[1]))


def test_a_prescribed_motion_moves_its_joint_and_tells_its_drive():
    one, (m, pole, t) = cart_pole("0.1*sin(3*t)"), (0.7, 0.4, 0.9)
    q, qd, tau, params = [0.03, 0.5], [0.2, -1.2], [123.0, 0.6], [m, pole]
    a = -0.9 * math.sin(3 * t)
    swing = (tau[1] - m * pole * math.cos(q[1]) * a - m * 9.81 * pole * math.sin(q[1])) / (m * pole * pole)
    force = (2 + m) * a + m * pole * (math.cos(q[1]) * swing - math.sin(q[1]) * qd[1] ** 2)

    forward, drives, motion = lambdify(one, ("forward_dynamics", "drive_forces", "prescribed_motion"))
    assert forward(q, qd, tau, t, params) == pytest.approx([a, swing], rel=1e-13)
    assert drives(q, qd, tau, t, params) == pytest.approx([force, tau[1]], rel=1e-13)
    assert motion(t, params).ravel() == pytest.approx([0.1 * math.sin(3 * t), 0.3 * math.cos(3 * t), a], rel=1e-13)
    assert forward(q, qd, [0.0, tau[1]], t, params) == pytest.approx([a, swing], rel=1e-13)  # its tau is not read


@pytest.mark.heavy("1")
@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_hybrid_dynamics_of_trees_is_proved(seed):
    one = random_tree(seed, 5)
    moving = [i for i, joint in enumerate(one.joints) if joint.moves]
    joints = list(one.joints)
    for i in moving[seed % 2 :: 2]:
        joints[i] = replace(joints[i], motion=parse("sin(t) + t**2"))
    one = replace(one, joints=tuple(joints))
    w = Workspace(one)
    claims = laws(w, ("inverse_dynamics", "forward_dynamics"))
    for name in ("forward_dynamics", "drive_forces"):
        left, right = (derive_one(w, name, formulation).entries for formulation in ("crba", "lagrange"))
        claims.append(Claim(name, "crba", "lagrange", left, right))

    assert formulations_of("forward_dynamics", one) == ("crba", "lagrange")
    assert {finding.verdict for finding in prove(claims)[1]} == {Verdict.PROVED}


# Time


def test_time_is_an_argument_only_of_what_depends_on_it():
    one = pendulum(elements=(Load("w", TIP, vec(0, 0, "F*t")),))
    names = {f.name: [a.name for a in f.arguments] for f in derive(one, ["inverse_dynamics", "mass_matrix"]).functions}

    assert names == {"inverse_dynamics": ["q", "qd", "qdd", "t", "params"], "mass_matrix": ["q", "params"]}


@pytest.mark.runs
@pytest.mark.parametrize("target", ["numpy", "c"])
def test_time_is_one_number_or_a_batch_of_them(target):
    one = pendulum(elements=(Load("w", TIP, vec(0, 0, "F*sin(t)")),))
    call = lambdify(one, "inverse_dynamics", target)
    q, qd, qdd = RNG.normal(size=(3, 5000, 1))
    t = RNG.normal(size=5000)

    def expected(q, qdd, t):
        return without_load(q, qdd) + F * math.sin(t) * L * math.cos(q)

    many = [expected(q[i, 0], qdd[i, 0], t[i]) for i in range(5000)]
    assert call(q, qd, qdd, t, VALUES)[:, 0] == pytest.approx(many, rel=1e-12)
    assert call(q, qd, qdd, 0.3, VALUES)[7, 0] == pytest.approx(expected(q[7, 0], qdd[7, 0], 0.3), rel=1e-12)
    assert call(q[0], qd[0], qdd[0], t[:9], VALUES).shape == (9, 1)
    assert call(q[0], qd[0], qdd[0], 0.3, VALUES).shape == (1,)


@pytest.mark.runs
def test_the_ufunc_takes_time_without_a_dimension():
    one = pendulum(elements=(Load("w", TIP, vec(0, 0, "F*sin(t)")),))
    loaded = load_scene(one, ("inverse_dynamics",))
    call, plain = loaded.inverse_dynamics, lambdify(one, "inverse_dynamics")
    q, qd, qdd = RNG.normal(size=(3, 40, 1))
    t = RNG.normal(size=40)

    assert "(1),(1),(1),(),(7)->(1)" in repr(loaded)
    assert np.allclose(call(q, qd, qdd, t, VALUES), plain(q, qd, qdd, t, VALUES), rtol=1e-13)
    assert np.allclose(
        call(q[0], qd[0], qdd[0], np.array(t[0]), np.array(VALUES)), plain(q[0], qd[0], qdd[0], t[0], VALUES)
    )


@pytest.mark.parametrize("real", ["double", "float"])
def test_c_takes_time_by_value_and_its_batches_by_address(real):
    one = pendulum(elements=(Load("w", TIP, vec("F*cos(3*t)", 0, "F*sin(t)")),))
    program = lower(formulate(one, ("inverse_dynamics",)))
    header = dict(emit(program, "c", real, option="batch").files)["pendulum.h"]

    assert f"const {real} *qdd, {real} t, const {real} *params, {real} *out);" in header
    assert header.count(f"const {real} *qdd, const {real} *t, const {real} *params") == 2


@pytest.mark.runs
def test_batches_by_columns_take_a_column_of_times():
    one = pendulum(elements=(Load("w", TIP, vec("F*cos(3*t)", 0, "F*sin(t)")),))
    module = build(lower(formulate(one, ("inverse_dynamics",))))
    entry = ctypes.CDLL(str(module.path)).pendulum_inverse_dynamics_batch
    n = 150
    columns = [np.ascontiguousarray(RNG.normal(size=n)) for _ in range(4)]
    params, out = np.array(VALUES), np.empty(n)
    entry(ctypes.c_size_t(n), *(ctypes.c_void_p(a.ctypes.data) for a in (*columns, params, out)))

    q, qd, qdd, t = columns
    expected = lambdify(one, "inverse_dynamics")(q[:, None], qd[:, None], qdd[:, None], t, VALUES)[:, 0]
    assert out == pytest.approx(expected, rel=1e-12)


@pytest.mark.runs
def test_a_long_scalar_function_hands_time_to_its_parts():
    one = with_loads(random_tree(4, 8), 1)
    call, plain = (lambdify(one, "forward_dynamics", target) for target in ("c", "numpy"))
    n = len(one.velocities)
    state = (*RNG.normal(size=(3, n)), 0.4, np.full(len(one.free_parameters), 0.8))

    assert call(*state) == pytest.approx(plain(*state), rel=1e-8)


@pytest.mark.runs
def test_the_certificate_of_a_loaded_scene_proves_and_measures_everything():
    spring, damper = Spring("s", "", (ABOVE, TIP), vec("k"), free=parse("s0")), Damper("d", "", (ABOVE, TIP), vec("c"))
    load, dry = (
        Load("w", TIP, vec("F*sin(t)", 0, 0)),
        Friction("hinge", Quantity.number(1), None, Quantity.number(1), parse("0.1")),
    )
    found = certify(pendulum(elements=(spring, damper, load), dry=dry))

    assert found.passed
    assert {finding.verdict for finding in found.findings} == {Verdict.PROVED}
    assert {"elastic_forces", "k_E", "forward_dynamics"} <= {one.function for one in found.accuracy if one.states}


# In print


@pytest.mark.long
def test_every_load_is_printed():
    spring, twist = (
        Spring("s", "", (ABOVE, TIP), vec("k"), free=parse("s0")),
        Spring("e", "hinge", (), vec("c"), free=parse("s0")),
    )
    load, dry = (
        Load("w", TIP, vec("F*sin(t)", 0, 0), frame="body"),
        Friction("hinge", parse("F"), None, Quantity.number(1), parse("c")),
    )
    across = Load("v", TIP, vec("F*sin(t)", 0, 0))
    one = pendulum(elements=(spring, twist, load, across), dry=dry, motion=parse("sin(t)"))
    text, page = equations_text(one, "text", "coefficients"), equations_text(one, "latex", document=True)

    assert "k_E1 = k*(s_s - s0)*l*h*cos(q1)/s_s" in text
    assert "s_s = sqrt(l**2 + h**2 + 2*l*h*sin(q1))" in text
    assert "+ c*(q1 - s0)" in text
    assert r"= \tau_1 - F \tanh\Bigl(\frac{\dot q_1}{c}\Bigr) - F \sin t \, l \sin q_1" in page
    assert r"q_1 &= \sin t" in page
    assert "+ k_{E,i}$ equals the drive" in page
    assert r"\tfrac{1}{2} c (q_1 - s_0)^2" in page
    assert r"$t$ & time &" in page
    assert "t = symbols(" in equations_text(one, "sympy").replace("\n", " ")


@pytest.mark.long(0)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_is_printed_is_what_is_derived(seed):
    one = with_loads(random_tree(seed, 3), seed)
    w, closed = Workspace(one), closed_form(one)
    n = range(w.state.n)
    elastic = tuple(closed.form("k_E", i).express(w.graph) for i in n)
    acting = tuple(form.express(w.graph) for form in closed.loads.acting(closed.compactor))
    claims = [
        Claim("k_E", "form", "recursive", elastic, tuple(w.elastic.forces)),
        Claim("P", "form", "lagrange", (closed.form("P").express(w.graph),), (w.energy.P,)),
        Claim("Q", "form", "virtual work", acting, tuple(w.Q)),
    ]

    assert [finding.verdict for finding in prove(claims)[1]] == [Verdict.PROVED] * 3
