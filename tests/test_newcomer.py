"""What one types who knows another tool, and what it is answered: the word that is meant, or how it is called."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

import symdyn
from symdyn.algebra.sympy_algebra import sympy_symbol
from symdyn.arguments import suggesting
from symdyn.errors import (
    ArgumentError,
    DerivationError,
    DrawError,
    EmitError,
    IdentifyError,
    LinearizeError,
    SceneError,
    SimulateError,
    UnknownNameError,
    suggestion,
)
from symdyn.linear import root_locus
from symdyn.linear.weights import read_weights
from symdyn.scene import body, damper, revolute, scene, spring, table
from symdyn.scene.toml import read_text
from symdyn.simulation.integrate import integration

pytestmark = pytest.mark.runs("cc")

CART = symdyn.example("cart_pole")

WRONG_CALLS: dict[str, Callable[[], object]] = {
    "body() got an unexpected keyword argument 'inertia_about'; did you mean about?": (
        lambda: body("bob", mass=1, inertia_about="com")  # type: ignore[call-arg]
    ),
    "spring() got an unexpected keyword argument 'from_'; did you mean ends?": (
        lambda: spring("s", from_="a", to="b")  # type: ignore[call-arg]
    ),
    "load() got an unexpected keyword argument 'values'; did you mean parameters?": (
        lambda: symdyn.load(CART, values={})  # type: ignore[call-arg]
    ),
    "simulate() takes 1 positional argument but 2 were given; it goes by name, until=3; call it as simulate(scene": (
        lambda: symdyn.simulate(CART, (0, 3))  # type: ignore[arg-type, call-arg]
    ),
    "simulate() got an unexpected keyword argument 'period'; give it with the controller: feedback=symdyn.Feedback("
    "law, period=...)": lambda: symdyn.simulate(CART, period=0.1),  # type: ignore[call-arg]
    "simulate() got an unexpected keyword argument 'bind'; did you mean values?": (
        lambda: symdyn.simulate(CART, bind={"mc": 1})  # type: ignore[call-arg]
    ),
    "simulate() got an unexpected keyword argument 'controller'; did you mean feedback?": (
        lambda: symdyn.simulate(CART, controller=0)  # type: ignore[call-arg]
    ),
    "Feedback() got an unexpected keyword argument 'limit'; did you mean limits?": (
        lambda: symdyn.Feedback(0, limit=1)  # type: ignore[call-arg]
    ),
    "Problem() got an unexpected keyword argument 'bind'; did you mean values?": (
        lambda: symdyn.Problem(CART, bind={})  # type: ignore[call-arg]
    ),
    "example() missing 1 required positional argument: 'name'; call it as example(name, floating_base=)": (
        symdyn.example  # type: ignore[dict-item]
    ),
    "root_locus() got an unexpected keyword argument 'start'; system takes it": (
        lambda: root_locus("mp", [1, 2], CART, start={})  # type: ignore[call-arg, arg-type]
    ),
    "place() missing 1 required positional argument: 'poles'; call it as place(poles, period)": (
        lambda: symdyn.linearize(CART).place()  # type: ignore[call-arg]
    ),
}


@pytest.mark.parametrize("told", WRONG_CALLS)
def test_a_call_that_does_not_fit_is_told_how_it_is_made(told: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        WRONG_CALLS[told]()
    assert str(caught.value).startswith(told)


def test_an_error_from_inside_a_function_stays_what_it_is() -> None:
    @suggesting
    def outer(names: list[str]) -> str:
        return " ".join(names)

    with pytest.raises(TypeError, match="expected str instance") as caught:
        outer([1])  # type: ignore[list-item]
    assert not isinstance(caught.value, ArgumentError)


@pytest.mark.parametrize(
    ("word", "meant"), [("tf", "transfer"), ("c2d", "discretize"), ("eig", "poles"), ("ctrb", "controllability")]
)
def test_words_of_other_control_tools_are_known(word: str, meant: str) -> None:
    with pytest.raises(AttributeError, match=f"did you mean {meant}\\?"):
        getattr(symdyn.linearize(CART), word)


@pytest.mark.parametrize(("word", "meant"), [("to_df", "to_pandas"), ("time", "t"), ("to_excel", "to_csv")])
def test_words_of_tables_are_known(word: str, meant: str) -> None:
    with pytest.raises(AttributeError, match=f"did you mean {meant}\\?"):
        getattr(symdyn.simulate(CART, until=0.1), word)


def test_of_many_names_the_likest_are_told() -> None:
    many = [f"alpha{k}" for k in range(20)] + ["zeta_bits"]
    assert suggestion("bits_of_it", many).startswith("known are zeta_bits, ")
    assert suggestion("wave", ["c", "b", "a"]) == "known are c, b, a"


def test_a_run_that_takes_long_warns_and_names_what_grows() -> None:
    said: list[str] = []
    outlook = integration.Outlook(1e6, said.append)
    outlook.last -= 10.0
    outlook.look(1e-3, lambda: "; x_dot has grown to 5e+03 in SI units, so look whether it is unstable")
    assert len(said) == 1
    assert said[0].endswith("x_dot has grown to 5e+03 in SI units, so look whether it is unstable")


@pytest.mark.parametrize(
    ("formula", "written"),
    [
        ("step(t)", "write if(t > 1, 1, 0)"),
        ("1 if t > 1 else 0", "write if(x > y, a, b)"),
        ("t > 1", "write if(t > 1, 1, 0)"),
        ("5*(t<0.25)", "a comparison is not a number; write if(t < 0.25, 1, 0)"),
        ("5*(t<2 and t>1)", "a condition is not a number; write if(t < 2 and t > 1, 1, 0)"),
        ("clip(t, -1, 1)", "write max(-1, min(x, 1))"),
        ("np.sin(t)", "write sin(x) alone"),
        ("0.1sin(t)", "write 0.1*sin(t)"),
        ("A sin(w t)", "write A*sin(w*t)"),
        ("0.1 sin(2 t)", "write 0.1*sin(2*t)"),
        ("sin x + cos(2t)", "write sin(x) + cos(2*t)"),
        ("2theta", "or write 2*theta"),
        ("x(t)", "of a symbol write x alone"),
        ("sin^2(theta)", "write sin(theta)**2"),
        ("2·theta", "a product is *"),
        ("PI*theta", "write pi"),
        ("cot(theta)", "write 1/tan(x)"),
        ("smoothstep(t)", "s**3*(10 - 15*s + 6*s**2)"),
        ("interp(t, d)", 'write table("NAME", x)'),
        ("hypot(t, 1)", "write sqrt(x**2 + y**2)"),
        ("wobble(t)", "functions are sin, cos"),
    ],
)
def test_formulas_of_other_tools_are_told_how_they_are_written(formula: str, written: str) -> None:
    with pytest.raises(SimulateError, match=re.escape(written)):
        symdyn.simulate(CART, forces={"F": formula})


def _flat() -> symdyn.Scene:
    one = body("b", mass=1, inertia=(0, 0, "J"), about="com")
    return scene("flat", parameters={"J": 1}, bodies=[one], joints=[revolute("p", "ground", "b")])


BASE = """
units = "none"
gravity = "none"
parameters = {{ k = 3, c = 1 }}
inputs = {{ base = 0 }}
bodies.floor.mass = 1
joints.story = {{ type = "prismatic", parent = "ground", child = "floor", coordinate = "x", force = "{force}" }}
{more}
"""

DASHPOT = '[dampers.pot]\nfrom = "floor"\nto = "ground"\ndamping = 1'
"""Between points that meet."""


def upright() -> symdyn.linear.Linearization:
    return symdyn.linearize(CART)


TOLD: dict[str, tuple[type[Exception], Callable[[], object]]] = {
    "formulas has A, B, C and D in SymPy": (AttributeError, lambda: symdyn.linearize(CART).symbolic()),  # type: ignore[attr-defined]
    "margins() and step().info() are numbers of it": (AttributeError, lambda: symdyn.linearize(CART).info()),  # type: ignore[attr-defined]
    "run.notes, run.events and run.columns tell of it": (
        AttributeError,
        lambda: symdyn.simulate(CART, until=0.1).info(),  # type: ignore[attr-defined]
    ),
    "symdyn.equations(scene).text() its equations": (AttributeError, lambda: CART.info),  # type: ignore[attr-defined]
    "it is symdyn.identification.output_error": (AttributeError, lambda: symdyn.output_error),  # type: ignore[attr-defined]
    "take the values: load(...).mass_matrix(...)": (ArgumentError, lambda: symdyn.load(CART, "mass_matrix")([0, 0])),
    "'at'; did you mean start?": (ArgumentError, lambda: symdyn.linearize(CART, at="theta=0")),  # type: ignore[call-arg]
    'reactions="ground" adds reaction_JOINT_fx': (
        UnknownNameError,
        lambda: symdyn.inverse(CART, {"x": "t", "theta": 0}, [0, 1])["reaction_x_ground"],
    ),
    'names stand apart, "x", "theta"; a list': (
        UnknownNameError,
        lambda: symdyn.simulate(CART, until=0.1).plot("x,theta"),
    ),
    "positions of rest, symdyn.linear.linearize_at_rest(scene)": (
        SimulateError,
        lambda: symdyn.simulate(CART, start="rest"),
    ),
    "noise: F drives, and noise is of what is measured; what disturbs it stands in forces": (
        SimulateError,
        lambda: symdyn.simulate(CART, feedback=symdyn.Feedback([[1, 1, 1, 1]], period=0.1, noise={"F": 1})),
    ),
    "returned [0, 0], numbers of shape (2,), at t = 0 s; give one number a force, in this order: F": (
        SimulateError,
        lambda: symdyn.simulate(CART, until=0.1, forces=lambda t, q, u: [0, 0]),
    ),
    "as in lin.lqg(..., period=0.01), pid(..., period=0.01) or system.discretize(0.01)": (
        SimulateError,
        lambda: symdyn.simulate(CART, feedback=symdyn.Feedback(symdyn.linearize(CART).lqg(), period=0.01)),
    ),
    'say what each does there, mode={"floor": "open"}; or closed': (
        DerivationError,
        lambda: symdyn.linearize(symdyn.example("hopper")),
    ),
    'write "com" (centre of mass) or "frame"': (
        SceneError,
        lambda: _with(body="mass = 1\ncom = [0, 0, 0.1]\ninertia = [1, 1, 1]"),
    ),
    "a unit stands behind a number alone: in a formula write SI": (
        SimulateError,
        lambda: symdyn.inverse(CART, {"x": "0 m", "theta": "1500 rpm*t"}, until=1),
    ),
    "it is symdyn.identification.excite": (AttributeError, lambda: symdyn.excite),  # type: ignore[attr-defined]
    "it is symdyn.linear.linearize_along": (AttributeError, lambda: symdyn.linearize_along),  # type: ignore[attr-defined]
    "symdyn.load has functions to call": (AttributeError, lambda: symdyn.generate),  # type: ignore[attr-defined]
    'symdyn.scene.write_text(scene, "toml").text is its file': (AttributeError, lambda: CART.save),  # type: ignore[attr-defined]
    "symdyn.Feedback(regulator, reference={...}) sets another point": (
        AttributeError,
        lambda: symdyn.linearize(CART).lqr().kr,  # type: ignore[attr-defined]
    ),
    'a list of names is one panel: plot([["x", "theta"]])': (
        UnknownNameError,
        lambda: symdyn.simulate(CART, until=0.1).plot("x+theta"),
    ),
    "a flat body has [J/2, J/2, J]": (SceneError, _flat),
    'linearize(..., outputs=["x_ddot"]) asks for others': (
        LinearizeError,
        lambda: symdyn.linearize(CART).transfer("x_ddot", "F"),
    ),
    "systems along a run are symdyn.linear.linearize_along(scene, run)": (
        ArgumentError,
        lambda: symdyn.linearize(CART, along=None),  # type: ignore[call-arg]
    ),
    "tau[1]: of what no drive moves, 0": (
        ArgumentError,
        lambda: symdyn.load(CART, "forward_dynamics").forward_dynamics([0, 0], [0, 0], [1]),
    ),
    "Scene has no attribute 'equations'; it is a function: symdyn.equations(scene)": (
        AttributeError,
        lambda: CART.equations,  # type: ignore[attr-defined]
    ),
    "Scene has no attribute 'l'; write .parameters[\"l\"]": (AttributeError, lambda: CART.l),  # type: ignore[attr-defined]
    "'saturation'; did you mean feedback?": (
        ArgumentError,
        lambda: symdyn.simulate(CART, saturation=8),  # type: ignore[call-arg]
    ),
    "'measures'; did you mean measure?": (
        ArgumentError,
        lambda: symdyn.sweep(CART, "mp=[1,2]", measures="end(x)"),  # type: ignore[call-arg]
    ),
    "the function peak is not known; statistics are max, min,": (
        SimulateError,
        lambda: symdyn.sweep(CART, "mp=[1,2]", "peak(x)", until=1),
    ),
    "symdyn.identification.output_error(scene, data, parameters) takes it": (
        ArgumentError,
        lambda: symdyn.identify(CART, {}, parameters=["mp"]),  # type: ignore[call-arg]
    ),
    'the times of all arrays are called "t"': (
        IdentifyError,
        lambda: symdyn.identify(CART, {"time": np.arange(9.0), "x": np.zeros(9)}),
    ),
    'abs(lin.bode("x", "F").response) has ratios': (
        AttributeError,
        lambda: symdyn.linearize(CART).transmissibility,  # type: ignore[attr-defined]
    ),
    "did you mean gravity_forces?": (AttributeError, lambda: symdyn.load(CART, "gravity_forces").gravity),
    "did you mean axes? (there are axes)": (
        ArgumentError,
        lambda: symdyn.linearize(CART).bode("x", "F").plot(ax=0),  # type: ignore[call-arg]
    ),
    'x_dot is a velocity; give it by end_rates={"x_dot": 0}': (
        SimulateError,
        lambda: symdyn.collocation(CART, until=1, end={"x": 1, "x_dot": 0}),
    ),
    "start rates: x_dot is given twice": (
        SimulateError,
        lambda: symdyn.simulate(CART, start={"x_dot": 1}, start_rates={"x": 1}),
    ),
    "'N'; did you mean intervals?": (
        ArgumentError,
        lambda: symdyn.collocation(CART, until=1, N=5),  # type: ignore[call-arg]
    ),
    'theta = 179 is in rad; write "179 deg" for degrees': (
        LinearizeError,
        lambda: symdyn.linearize(CART, start="theta=179"),
    ),
    """noise: 0.01 is one number for 2: x, theta; give all, or by name, as in {"x": 0.1}""": (
        SimulateError,
        lambda: symdyn.simulate(
            CART, until=0.1, feedback=symdyn.Feedback(symdyn.linearize(CART).lqg(period=0.01), noise=0.01)
        ),
    ),
    "gravity: is a parameter here; write what acts, gravity = [0, 0, -9.81], above all tables": (
        SceneError,
        lambda: read_text("[parameters]\ngravity = [0, -9.81, 0]\n[bodies.a]"),
    ),
    "write rates = 1 in [inputs.base]": (SceneError, lambda: _on_a_base("-k*x - c*(x_dot - base_dot)", "")),
    "base disturbs, as there is a drive to control by: tau1; base controls where its joint has drive = false": (
        LinearizeError,
        lambda: symdyn.linearize(_on_a_base("base - k*x", "")).lqr({"x": 1}, {"base": 1}),
    ),
    'outputs come first, then inputs: ("theta", "F")': (
        LinearizeError,
        lambda: symdyn.linearize(CART).bode("F", "theta"),
    ),
    "gains are those of its parts, .regulator.K and .observer.L": (
        AttributeError,
        lambda: symdyn.linearize(CART).lqg().K,  # type: ignore[attr-defined]
    ),
    "film('a.gif') writes a file": (
        DrawError,
        lambda: symdyn.simulate(CART, until=0.1).animate("a.gif"),  # type: ignore[arg-type]
    ),
    "symdyn.picture(scene) draws it": (AttributeError, lambda: CART.plot),  # type: ignore[attr-defined]
    "did you mean pose:NAME?": (DerivationError, lambda: symdyn.load(CART, "fk")),
    "write pose:NAME, such as pose:tip": (DerivationError, lambda: symdyn.load(CART, "pose")),
    "limits: u: is no input of the controller; it has F": (
        SimulateError,
        lambda: symdyn.simulate(CART, until=0.1, feedback=symdyn.pid("theta", "F", kp=1, limits={"u": 8})),
    ),
    "write Q=theta:100;theta_dot:10": (
        LinearizeError,
        lambda: read_weights("--lqr", ["theta=100,theta_dot=10"], {"Q": (), "R": ()}),
    ),
    "outputs are weighed by Q = lin.C.T @ W @ lin.C": (LinearizeError, lambda: symdyn.linearize(CART).lqr({"v": 1})),
    "feedback: cart_pole is the mechanism, and no controller; give lin.lqr(Q, R) or lin.lqg(...), which have a .closed_"
    "loop": (LinearizeError, lambda: symdyn.linearize(CART).feedback()),
    "period: '10' is no number of seconds; write 0.01 or \"10 ms\"": (
        SimulateError,
        lambda: symdyn.simulate(CART, until=1, feedback=symdyn.Feedback(symdyn.pid("theta", "F", 1), period="10")),  # type: ignore[arg-type]
    ),
    "revolute() missing 1 required positional argument: 'child'": (
        ArgumentError,
        lambda: revolute("a", "ground", axis=[0, 1, 0]),  # type: ignore[call-arg]
    ),
    "revolute() got an unexpected keyword argument 'axsi'; did you mean axis?": (
        ArgumentError,
        lambda: revolute("a", axsi=[0, 1, 0]),  # type: ignore[call-arg]
    ),
    "scene() takes no loop; did you mean loops?": (TypeError, lambda: scene("s", loop=[])),  # type: ignore[call-arg]
    "scene() takes no input; did you mean inputs?": (TypeError, lambda: scene("s", input={"u": 0})),  # type: ignore[call-arg]
    's: dampers: this is no list; give [damper("d", ...)]': (
        SceneError,
        lambda: scene("s", dampers=damper("d", joint="h", damping=1)),  # type: ignore[arg-type]
    ),
    's: bodies: this is no list; give [body("a", ...)]': (
        SceneError,
        lambda: scene("s", bodies={"a": {"mass": 1}}),  # type: ignore[arg-type]
    ),
    "uses q1, an output; move it to [signals], which other formulas may use": (
        SceneError,
        lambda: read_text('[outputs]\nq1 = "2*t"\ngrip = "2*q1"', "s.toml"),
    ),
    "breaks off at character 9; write 0.3*sin(2*t); check": (
        SimulateError,
        lambda: symdyn.simulate(CART, until=1, forces={"F": "0.3*sin(2t)"}),
    ),
    'where "lambda" is a keyword of Python; try lambda1': (
        SimulateError,
        lambda: symdyn.simulate(CART, until=1, forces={"F": "3*lambda"}),
    ),
    "V: x: 0.5 mm is in mm, and m^2 is asked for": (
        LinearizeError,
        lambda: upright().kalman(None, {"x": "0.5 mm"}, period="10 ms"),  # type: ignore[arg-type]
    ),
    "V: x: 1 m^2 is in m^2, and m^2 s is asked for": (
        LinearizeError,
        lambda: upright().kalman(None, {"x": "1 m^2"}),
    ),
    "Q: theta: 2 m is in m, and 1/rad^2 is asked for": (
        LinearizeError,
        lambda: upright().lqr({"theta": "2 m"}),
    ),
    "give text; root_locus(": (LinearizeError, lambda: root_locus(CART, "mp", [1, 2])),  # type: ignore[arg-type]
    'symdyn.linear.root_locus("mp", values, system)': (
        LinearizeError,
        lambda: symdyn.linearize(CART).root_locus("theta", "mp"),
    ),
    "did you mean theta_dot?": (SimulateError, lambda: symdyn.simulate(CART, forces={"F": "-2*dtheta"})),
    "did you mean M?": (AttributeError, lambda: symdyn.equations(CART).sympy().mass_matrix),  # type: ignore[attr-defined]
    "it is tau - c - g - k_E": (AttributeError, lambda: symdyn.equations(CART).sympy().forcing),  # type: ignore[attr-defined]
    "run(0.5) has all columns at a time": (
        AttributeError,
        lambda: symdyn.simulate(CART, until=0.1).sol,  # type: ignore[attr-defined]
    ),
    'design="saltelli"': (AttributeError, lambda: symdyn.sobol),  # type: ignore[attr-defined]
    "of symdyn.load(scene), .mass_matrix(q, ...)": (AttributeError, lambda: symdyn.mass_matrix),  # type: ignore[attr-defined]
    'symdyn.scene.bind(scene, {"mc": 0.2}) keeps them': (AttributeError, lambda: CART.replace),  # type: ignore[attr-defined]
    "'events'; did you mean stops?": (ArgumentError, lambda: symdyn.simulate(CART, events="x")),  # type: ignore[call-arg]
    "write gravity = [0, 0, -9.81]": (SceneError, lambda: _with("gravity = 9.81")),
    "of a ball [J, J, J]": (SceneError, lambda: _with(body="inertia = 3")),
    "a flat body has [J/2, J, J/2]": (SceneError, lambda: _with(body="inertia = [0, 1, 0]")),
    '[springs.j] joint = "j", stiffness = 3': (SceneError, lambda: _with(joint="stiffness = 3")),
    "a place in space is its origin": (SceneError, lambda: _with(joint="position = [0, 0, 1]")),
    "column 6: decimals have a point; write 9.81": (SceneError, lambda: _with("g = 9,81")),
    "symdyn.draw is a package, and not called; symdyn.picture(scene) does it": (
        ArgumentError,
        lambda: symdyn.draw(CART),  # type: ignore[operator]
    ),
    "symdyn.verify is a package, and not called; symdyn.certify(scene) does it": (
        ArgumentError,
        lambda: symdyn.verify(CART),  # type: ignore[operator]
    ),
    "symdyn.linear.linearize_at_rest(scene) finds all": (AttributeError, lambda: symdyn.trim),  # type: ignore[attr-defined]
    "it is symdyn.linearize(...).poles": (AttributeError, lambda: symdyn.eigenvalues),  # type: ignore[attr-defined]
    "it is symdyn.simulate(scene, until=...)": (AttributeError, lambda: symdyn.solve_ivp),  # type: ignore[attr-defined]
    "every=0.01 spaces the rows; run(t) has": (ArgumentError, lambda: symdyn.simulate(CART, t_eval=[0])),  # type: ignore[call-arg]
    "a run begins at t = 0, and until= is": (ArgumentError, lambda: symdyn.simulate(CART, t_span=(0, 1))),  # type: ignore[call-arg]
    "run(t) has all columns between": (ArgumentError, lambda: symdyn.simulate(CART, dense_output=True)),  # type: ignore[call-arg]
    "steps are chosen for rtol=": (ArgumentError, lambda: symdyn.simulate(CART, max_step=0.1)),  # type: ignore[call-arg]
    "values={'mc': 0.1} gives parameters": (ArgumentError, lambda: symdyn.simulate(CART, args=())),  # type: ignore[call-arg]
    "'x_dot': 0} gives positions and": (ArgumentError, lambda: symdyn.simulate(CART, y0=[0])),  # type: ignore[call-arg]
    "forces={'F': '0.1*t'} drives": (ArgumentError, lambda: symdyn.simulate(CART, u=1)),  # type: ignore[call-arg]
    "known are A, B, C, D, bode,": (AttributeError, lambda: symdyn.linearize(CART).zz9),  # type: ignore[attr-defined]
    "it is symdyn.equations(scene).latex()": (AttributeError, lambda: symdyn.latex),  # type: ignore[attr-defined]
    "it is .sympy().M": (AttributeError, lambda: symdyn.equations(CART).M),  # type: ignore[attr-defined]
    "its .closed_loop has them": (AttributeError, lambda: symdyn.linearize(CART).lqr().step),  # type: ignore[attr-defined]
    "did you mean pose_tip?": (AttributeError, lambda: symdyn.load(CART).forward_kinematics),
    "did you mean damp?": (AttributeError, lambda: symdyn.linearize(CART).natural_frequencies),  # type: ignore[attr-defined]
    "column energy; did you mean kinetic_energy?": (
        UnknownNameError,
        lambda: symdyn.simulate(CART, until=0.1)["energy"],
    ),
    "an integral time is ki = kp/Ti": (ArgumentError, lambda: symdyn.pid("x", "F", kp=1, Ti=1)),  # type: ignore[call-arg]
    "did you mean restitution?": (ArgumentError, lambda: symdyn.scene.contact("c", body="b", e=1)),  # type: ignore[call-arg]
    "did you mean hertz?": (ArgumentError, lambda: symdyn.linearize(CART).bode(Hz=True)),  # type: ignore[call-arg]
    "method ode45 is not known; did you mean rk45?": (SimulateError, lambda: symdyn.simulate(CART, method="ode45")),
    "depends on x_ddot, which forces make at once": (
        SimulateError,
        lambda: symdyn.simulate(
            CART, until=0.1, feedback=symdyn.linearize(CART, outputs=["theta", "x", "x_ddot"]).lqg()
        ),
    ),
    "integral: xx is no output or state; did you mean x?": (
        LinearizeError,
        lambda: symdyn.linearize(CART).lqr(integral="xx"),
    ),
    "N: is no matrix of 4 x 1": (LinearizeError, lambda: symdyn.linearize(CART).lqr(N=[[1.0]])),
    "N: is so large that": (LinearizeError, lambda: symdyn.linearize(CART).lqr(0.1, 1, N=[[9.0]] * 4)),
    "leave period out": (LinearizeError, lambda: symdyn.linearize(CART).lqr(N=[[0.1]] * 4, period=0.1)),
    "gains act on integrals, too": (LinearizeError, lambda: symdyn.linearize(CART).lqr(integral="x").gains()),
    "no input moves the mode 0, of theta_integral": (
        LinearizeError,
        lambda: symdyn.linearize(CART).lqr(integral="theta"),
    ),
    'scene.toml:3: column 9: quotes are missing around 2*m; write "2*m"': (
        SceneError,
        lambda: _with(body="mass = 2*m"),
    ),
    "scene.toml:3: column 8: −2 has no minus of a keyboard; write -2": (SceneError, lambda: _with(body="mass = −2")),
    'a value with a unit stands in quotes, "170 deg"': (SceneError, lambda: _with(body='mass = "2" kg')),
    "lines end in CR alone; save the file with": (SceneError, lambda: _with(body="mass = 1\rcom = [0, 0, 0]")),
    'quotes are missing around max(a, 2); write "max(a, 2)"': (SceneError, lambda: _with(body="mass = max(a, 2)")),
    'quotes are missing around l/2; write "l/2"': (SceneError, lambda: _with(body="mass = 1\ncom = [l/2, 0, 0]")),
    'quotes are missing around 3*k; write "3*k"': (SceneError, lambda: _with("parameters = { m = 3*k, n = 1 }")),
    'quotes are missing around 90 deg; write "90 deg"': (SceneError, lambda: _with(joint="start = 90 deg")),
    '“m1” stands in curly quotes; write "m1"': (SceneError, lambda: _with(body="mass = “m1”")),
    "decimals have a point; write 0.5": (SceneError, lambda: _with("parameters = { m = { value = 0,5 } }")),
    "write false in small letters": (SceneError, lambda: _with(joint="drive = False")),
    ".5 lacks a digit beside its point; write 0.5": (SceneError, lambda: _with(body="mass = .5")),
    "0 1: a comma stands between numbers": (SceneError, lambda: _with(joint="axis = [0, 0 1]")),
    'the text has no end; write " behind it': (SceneError, lambda: _with(joint='coordinate = "phi')),
    "is not valid TOML: Unclosed array": (SceneError, lambda: _with(joint="axis = [0, 0, 1\ndrive = false")),
    "spring prop has no length there, where it pulls (with free = 0 it would not": (
        LinearizeError,
        lambda: symdyn.linearize(
            _on_a_base("-k*x", '[springs.prop]\nfrom = "floor"\nto = "ground"\nstiffness = 1\nfree = 1')
        ),
    ),
    "put it on a joint, or give a spring beside it a free length (free = 0.5) and start where it has it": (
        LinearizeError,
        lambda: symdyn.linearize(_on_a_base("-k*x", DASHPOT)),
    ),
    "give 3 values; symdyn.scene.scene(name, bodies=[symdyn.scene.body(...)], ...) takes what a file has": (
        SceneError,
        lambda: symdyn.Scene("rot", gravity=[0, 0, -9.81]),  # type: ignore[arg-type]
    ),
    "give a list of Body; symdyn.scene.scene(": (
        SceneError,
        lambda: symdyn.Scene("rot", bodies=[body("arm", mass=1)]),  # type: ignore[arg-type]
    ),
    "give a number in SI for each of: mp": (ArgumentError, lambda: upright().formulas.lambdify("mp")("85 g")),
    "give a number in SI for each of: mp, l": (ArgumentError, lambda: upright().formulas.lambdify("mp", "l")(1)),
    "t = [0, 0.1, 0, 0], x = 0: give a number and a list of 4": (
        ArgumentError,
        lambda: symdyn.equations(CART).lambdify()([0, 0.1, 0, 0], 0),  # type: ignore[arg-type]
    ),
    "t = 0, x = [0, 0.1, 0]: give a number and a list of 4": (
        ArgumentError,
        lambda: symdyn.equations(CART).lambdify()(0, [0, 0.1, 0]),
    ),
    'lambdify("mc")(0.1) has A, B, C, D in numbers': (AttributeError, lambda: upright().formulas.subs(mp=1)),  # type: ignore[attr-defined]
    'lambdify("mp")(0.1) has A, B, C, D': (ArgumentError, lambda: upright().formulas["mp"]),  # type: ignore[index]
    "K has gains, an array": (ArgumentError, lambda: upright().lqr()[0]),  # type: ignore[index]
    'float(scene.parameters["mp"].value)': (ArgumentError, lambda: CART["mp"]),  # type: ignore[index]
    'simulate(scene, until=1, values={"mc": 0.2})': (AttributeError, lambda: CART.with_parameters(mp=1)),  # type: ignore[attr-defined]
    "symdyn.identification.output_error(scene, data, ['mp']) finds chosen parameters": (
        IdentifyError,
        lambda: symdyn.identify(CART, {}, ["mp"]),  # type: ignore[arg-type]
    ),
    'the shortest motion has cost="1"': (
        SimulateError,
        lambda: symdyn.collocation(CART, until=1, end={"x": 1}, cost="minimum time"),
    ),
    'until=(3, 20), and cost="1" makes it the soonest': (
        SimulateError,
        lambda: symdyn.collocation(CART, until="free", end={"x": 1}),  # type: ignore[arg-type]
    ),
    "it is symdyn.collocation(scene, until=(3, 20)": (AttributeError, lambda: symdyn.minimum_time),  # type: ignore[attr-defined]
    "it is symdyn.simulate(..., reactions=True)": (AttributeError, lambda: symdyn.reactions),  # type: ignore[attr-defined]
    ".text() or .sympy()": (AttributeError, lambda: symdyn.to_sympy),  # type: ignore[attr-defined]
    'linearize(...).transfer("OUTPUT", "INPUT")': (AttributeError, lambda: symdyn.transfer_function),  # type: ignore[attr-defined]
    'it is symdyn.read("FILE")': (AttributeError, lambda: symdyn.from_toml),  # type: ignore[attr-defined]
    'quantiles("end(x)", [0.5]) has it': (
        AttributeError,
        lambda: symdyn.sweep(CART, "mp=[1,2]", "end(x)", until=0.02).median,  # type: ignore[attr-defined]
    ),
    'mag, phase, omega = lin.bode("x", "F") and t, y = lin.step("x", "F")': (
        LinearizeError,
        lambda: upright().bode("x", "F")[0],  # type: ignore[index]
    ),
    "output = 0: give text or None; names are x, theta": (
        LinearizeError,
        lambda: upright().bode(0, 0),  # type: ignore[arg-type]
    ),
    ".axes[0].set_xlim(0, 1)": (
        ArgumentError,
        lambda: symdyn.simulate(CART, until=0.1).plot("x", xlim=(0, 1)),  # type: ignore[call-arg]
    ),
    "a Start or None; names are x, theta": (SimulateError, lambda: symdyn.simulate(CART, start=[0, 0.1, 0, 0])),  # type: ignore[arg-type]
}


def test_functions_of_formulas_take_symbols_and_lists_of_names() -> None:
    lin = upright()
    of_names = lin.formulas.lambdify("mp", "l")(0.2, 0.3)
    symbols = [symdyn.equations(CART).sympy()[name] for name in ("mp", "l")]
    assert all(np.array_equal(x, y) for x, y in zip(of_names, lin.formulas.lambdify(*symbols)(0.2, 0.3), strict=True))
    assert np.array_equal(of_names[0], lin.formulas.lambdify(["mp", "l"])(0.2, 0.3)[0])
    assert np.allclose(of_names[0], symdyn.linearize(CART, values={"mp": 0.2, "l": 0.3}).A)
    transfer = lin.transfer("x", "F")
    assert transfer(1j) == transfer.at(1j)


def _with(head: str = "", body: str = "mass = 1", joint: str = "") -> symdyn.Scene:
    kind = 'type = "revolute"\nparent = "ground"\nchild = "b"'
    return read_text(f"{head}\n[bodies.b]\n{body}\n[joints.j]\n{kind}\n{joint}\n")


def _on_a_base(force: str, more: str) -> symdyn.Scene:
    return read_text(BASE.format(force=force, more=more))


@pytest.mark.parametrize("told", TOLD)
def test_what_is_asked_in_another_place_is_told_where_it_is(told: str) -> None:
    error, asked = TOLD[told]
    with pytest.raises(error, match=re.escape(told)):
        asked()


WORKS: dict[str, Callable[[], object]] = {
    "poles()": lambda: np.array_equal(symdyn.linearize(CART).poles(), symdyn.linearize(CART).poles),
    "zeros()": lambda: len(symdyn.linearize(CART, outputs="x").zeros()) == 2,
    "abs(poles)": lambda: type(abs(symdyn.linearize(CART).poles)) is np.ndarray,
    "repr(poles)": lambda: repr(symdyn.linearize(CART).poles).startswith("array(["),
    "formulas()": lambda: symdyn.linearize(CART).formulas().A.rows == 4,
    "margins of LQG": lambda: (lqg := symdyn.linearize(CART).lqg()).margins() == lqg.loop.margins(),
    "limits by name": lambda: _largest(symdyn.pid("theta", "F", kp=900, limits={"F": 8})) == 8,
    "limits as a pair": lambda: _largest(symdyn.Feedback(lambda t, q, u: 99, limits=(-1, 8))) == 8,
    "a column of a solution": lambda: len(_reached()["F"]) > 4,
    "velocities at the start": lambda: symdyn.simulate(CART, until=0.1, start={"x": 0, "x_dot": 1})["x_dot"][0] == 1,
    "states of a run": lambda: symdyn.simulate(CART, until=0.1).states.shape[1] == 4,
    "the only measure": lambda: np.isfinite(symdyn.sweep(CART, "mp=[1,2]", "end(x)", until=0.1).mean()),
    "inertia without a centre of mass": lambda: _with(body="mass = 1\ninertia = [1, 1, 1]").bodies[0].about == "com",
    "K, S, E": lambda: [len(one) for one in symdyn.linearize(CART).lqr()] == [1, 4, 4],
    "L, P, E": lambda: [len(one) for one in symdyn.linearize(CART).kalman()] == [4, 4, 4],
    "mag, phase, omega": lambda: [one.shape for one in symdyn.linearize(CART).bode("x", "F")] == [(200,)] * 3,
    "t, y": lambda: [one.shape for one in symdyn.linearize(CART).step()] == [(500,), (2, 1, 500)],
    "gm, pm, wcg, wcp": lambda: len([*symdyn.linearize(CART).lqr().loop.margins()]) == 4,
    "forces as a dict of columns": lambda: (
        symdyn.simulate(CART, until=1, forces={"t": [0, 1], "F": [0, 2]})["F"][-1] == 2
    ),
    "times of a motion given as columns": lambda: (
        len(symdyn.inverse(CART, {"t": [0, 0.5, 1], "x": [0, 1, 2], "theta": [0, 0, 0]}).t) == 3
    ),
    "a motion that joints have, alone": lambda: (
        symdyn.inverse(_with('units = "none"', joint='motion = "t"'), until=1).complete
    ),
    "a table as columns": lambda: table("d", {"x": [0, 1], "y": [1, 2]}) == table("d", [(0, 1), (1, 2)]),
    "a table by its values": lambda: table("d", {0: 1, 1: 2}) == table("d", [(0, 1), (1, 2)]),
    "bounds as a size": lambda: 15 in symdyn.collocation(CART, until=1, bounds={"F": 15}, intervals=1).upper,
}


def _reached() -> symdyn.transcription.Solution:
    pytest.importorskip("casadi", reason="needs IPOPT")
    return symdyn.collocation(CART, until=1, end={"x": 0.1}, cost="F**2", intervals=4).solve()


def _largest(controller: symdyn.Feedback) -> float:
    return float(abs(symdyn.simulate(CART, until=0.1, start={"theta": 0.3}, feedback=controller)["F"]).max())


@pytest.mark.parametrize("words", WORKS)
def test_what_one_writes_who_knows_another_tool_works(words: str) -> None:
    assert WORKS[words]()


@pytest.mark.parametrize(
    ("motion", "told"),
    [
        ("hinge=sin(t)", "hinge is not a coordinate, but a joint: it has theta"),
        ("x=t;theta=sin(t)", "';' has no place in a formula"),
        ("theta=minjerk(0,1,2)", "a motion has quintic(a, b, T)"),
        ("theta=angle.csv", "theta: a file is given alone, angle.csv"),
    ],
)
def test_motions_as_one_would_write_them_are_told_how(motion: str, told: str) -> None:
    with pytest.raises(SimulateError, match=re.escape(told)):
        symdyn.inverse(CART, [motion], until=1)


def test_equations_are_printed_by_other_formulations_in_python() -> None:
    pendulum = symdyn.example("pendulum")
    page = symdyn.equations(pendulum, "dalembert")
    assert page.text() != symdyn.equations(pendulum).text()
    with pytest.raises(EmitError, match="are printed, by"):
        page.sympy()
    with pytest.raises(EmitError, match=r"did you mean dalembert\?"):
        symdyn.equations(pendulum, "d'alembert")


def test_a_plot_may_be_over_another_column_than_time() -> None:
    pytest.importorskip("matplotlib", reason="draws")
    run = symdyn.simulate(CART, until=0.5, start={"theta": 0.3})
    (axis,) = run.plot("x", x="theta").axes
    assert np.array_equal(axis.lines[0].get_xdata(), run["theta"])
    assert "rad" in axis.get_xlabel()
    assert axis.get_ylabel() == "$x$, m"  # a phase portrait had none
    with pytest.raises(UnknownNameError, match="thet"):
        run.plot("x", x="thet")


def test_sympy_prints_rates_with_dots_and_they_stay_symbols_of_their_names() -> None:
    import pickle

    import sympy

    cart = symdyn.equations(CART).sympy()
    assert r"\ddot{x}" in sympy.latex(cart.equations)
    assert sympy.latex(symdyn.equations(CART)) == sympy.latex(cart) == sympy.latex(sympy.Tuple(*cart.equations))
    assert "x\N{COMBINING DIAERESIS}" in sympy.pretty(symdyn.equations(CART), use_unicode=True)
    assert sympy.sympify(cart) == sympy.Tuple(*cart.equations)
    assert sympy.latex(cart["theta_ddot"], symbol_names={cart["theta_ddot"]: "a"}) == "a"
    for name, latex in {"q1_dot": r"\dot{q}_{1}", "q_1_ddot": r"\ddot{q}_{1}", "s_sf_dot": r"\dot{s}_{sf}"}.items():
        assert sympy.latex(sympy_symbol(name, {})) == latex
    ours, plain = cart["x_dot"], sympy.Symbol("x_dot", real=True)
    assert (ours == plain, plain == ours, hash(ours) == hash(plain), str(ours)) == (True, True, True, "x_dot")
    assert (ours - plain, (plain**2).subs(ours, 3), (ours**2).subs(plain, 3), (ours**2).diff(plain)) == (
        0,
        9,
        9,
        2 * ours,
    )
    assert ours not in (sympy.Symbol("x_dot"), sympy.Dummy("x_dot", real=True))
    assert pickle.loads(pickle.dumps(cart.M * cart.qdd)) == cart.M * cart.qdd


def test_all_transfer_functions_are_shown_line_by_line() -> None:
    found = symdyn.linearize(CART).transfer()
    assert [line.split(": ")[0] for line in repr(found).splitlines()[1:]] == ["    x / F", "    theta / F"]
    assert "x / F: gain 0.97561" in found._repr_mimebundle_()["text/html"]  # type: ignore[attr-defined]
    assert found == tuple(found)


def test_a_data_frame_of_a_run_says_its_times_to_an_inverse_run() -> None:
    pytest.importorskip("pandas")
    scene = symdyn.example("double_pendulum")
    run = symdyn.simulate(scene, until=0.2, every=0.05, start={"q1": 0.5})

    np.testing.assert_array_equal(symdyn.inverse(scene, run.to_pandas()).tau, symdyn.inverse(scene, run).tau)


def test_the_text_of_a_scene_is_no_path_and_values_are_no_start() -> None:
    with pytest.raises(SceneError, match=r"this is the text of a scene.*symdyn\.scene\.read_text"):
        symdyn.simulate('gravity = "none"\n[bodies.b]\nmass = 1\n', until=1)
    with pytest.raises(SceneError, match="this is the text of a scene"):
        symdyn.simulate('gravity = "none"', until=1)
    with pytest.raises(SimulateError, match="values by name") as told:
        symdyn.simulate(symdyn.example("double_pendulum"), until=0.1, values="m2=2.5")  # type: ignore[arg-type]
    assert "start=" not in str(told.value)


def test_independent_coordinates_and_the_function_of_a_controller_are_taken_as_elsewhere() -> None:
    loop = symdyn.example("five_bar")
    ways = ("theta1, theta2", ["theta1", "theta2"])
    by_text, by_list = (symdyn.linearize(loop, independent=x, anywhere=True) for x in ways)
    np.testing.assert_array_equal(by_text.A, by_list.A)

    class Held:
        def feedback(self) -> object:
            return lambda t, q, u: -3 * q - u

    run = symdyn.simulate(symdyn.example("pendulum"), until=0.1, start={"q1": 0.2}, feedback=Held())
    np.testing.assert_allclose(run["tau1"], -3 * run["q1"] - run["q1_dot"], atol=1e-12)
