"""What an engineer types who knows python-control, SciPy, pandas and SymPy, and no page: it works, or is told."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from sympy.physics.vector.printing import vlatex as latex

import symdyn
from symdyn.errors import ArgumentError, SceneError, SimulateError, SymdynError, UnknownNameError, hints
from symdyn.identification import Identification
from symdyn.identification.output_error import OutputFit
from symdyn.linear.linearization import Linearization
from symdyn.linear.responses import FrequencyResponse, TimeResponse
from symdyn.linear.system import track
from symdyn.scene.toml import read_text
from symdyn.shown import Suggesting
from symdyn.simulation.panels import panels
from symdyn.transcription import Collocation, Solution

pytestmark = pytest.mark.runs

CART = symdyn.example("cart_pole")


@cache
def held() -> dict[str, Any]:
    """Return what is held, by the name that it has when it is asked."""
    system = symdyn.linearize(CART)
    return {
        "run": symdyn.simulate(CART, until=0.1, start={"theta": 0.2}, method="dop853"),
        "lin": system,
        "step": system.step(points=3),
        "bode": system.bode(omega=[1.0]),
        "lqr": system.lqr(),
        "lqg": system.lqg(),
        "eq": symdyn.equations(CART),
        "scene": CART,
    }


KINDS = (Identification, OutputFit, Linearization, FrequencyResponse, TimeResponse, Collocation, Solution)

ATTRIBUTES = """
run.at run.final run.resample run.interp run.u run.y run.energy run.velocities run.success run.nfev run.gif run.max
lin.x0 lin.K lin.lqi lin.observer lin.eigenvalues lin.eigs lin.bandwidth lin.sensitivity lin.nichols lin.dcgain lin.rank
lin.symbolic lin.minreal lin.text step.y step.overshoot step.to_csv bode.to_csv bode.to_pandas lqr.P lqr.E lqr.Q
lqr.step lqr.simulate lqg.K eq.M eq.T eq.V eq.forcing eq.lagrangian eq.qdd eq.solve eq.linearize eq.pdf eq.coordinates
scene.dof scene.mass scene.start scene.forces scene.fk scene.latex scene.with_values scene.replace scene.save scene.plot
scene.l scene.rail lin.to_pandas
"""


@pytest.mark.parametrize("typed", ATTRIBUTES.split())
def test_an_attribute_that_others_have_is_told_where_it_is(typed: str) -> None:
    noun, name = typed.split(".")
    with pytest.raises(AttributeError, match=f"no attribute '{name}'; ") as caught:
        getattr(held()[noun], name)
    told = str(caught.value)
    assert "known are" not in told
    assert "did you mean" not in told  # of what sounds like it


TOLD: dict[str, Callable[[], object]] = {
    "it goes by name, until=10": lambda: symdyn.simulate(CART, 10),  # type: ignore[call-arg]
    "it goes by name, start={'theta': 0}": lambda: symdyn.linearize(CART, {"theta": 0}),  # type: ignore[call-arg]
    "it goes by name, values={'mp': [1, 2]}": lambda: symdyn.ensemble(CART, {"mp": [1, 2]}),  # type: ignore[call-arg]
    "it goes by name, parameters='mp'": lambda: symdyn.sensitivity(CART, "mp"),  # type: ignore[call-arg]
    "the scene comes first": lambda: symdyn.ensemble({"mp": [1, 2]}, CART),  # type: ignore[call-arg, arg-type]
    "or text; the scene comes first": lambda: symdyn.sweep({"mp": [1, 2]}, CART),  # type: ignore[arg-type]
    "symdyn.sweep over=": lambda: symdyn.sweep(CART, values={"mp": [1, 2]}, measure="max(x)"),
    "at most until = 1 s, the length of the run": lambda: symdyn.simulate(CART, until=1, every=3),
    "is a controller; give it as feedback=": lambda: symdyn.simulate(CART, until=1, forces=held()["lin"].transfer()),
    "is a controller; give it as feedback=symdyn.Feedback(CONTROLLER, 'F')": lambda: symdyn.simulate(
        CART, until=1, forces={"F": held()["lin"].transfer("x", "F")}
    ),
    "is a controller; motion takes a course over time: a formula": lambda: symdyn.inverse(
        CART, until=1, motion={"x": held()["lqr"]}
    ),
    "a=b.json: there is no such file": lambda: symdyn.simulate(CART, until=1, feedback="a=b.json"),
    "give gains as feedback=, or a formula": lambda: symdyn.simulate(CART, until=1, forces=held()["lqr"].K),
    'it is a formula of drives, cost="F**2"': lambda: symdyn.collocation(CART, until=1, cost="tau1^2"),
    "are forces: forces=\"F=2*t\"": lambda: symdyn.simulate(CART, until=1, feedback="F=2*t"),
    "it is values={'mp': 2}": lambda: symdyn.simulate(CART, mp=2),  # type: ignore[call-arg]
    "over={'mc': ...} gives a parameter": lambda: symdyn.sweep(CART, m=[1, 2]),  # type: ignore[call-arg]
    "discretize(0.01) is the sampled system": lambda: symdyn.linearize(CART, dt=0.01),  # type: ignore[call-arg]
    'all of the scene are there, lin["OUTPUT", "INPUT"] chooses': lambda: symdyn.linearize(CART, inputs=["F"]),  # type: ignore[call-arg]
    "'end'; it is until": lambda: symdyn.simulate(CART, end=10),  # type: ignore[call-arg]
    "feedback=symdyn.Feedback(law, seed=...)": lambda: symdyn.simulate(CART, seed=1),  # type: ignore[call-arg]
    "'nodes'; it is intervals": lambda: symdyn.collocation(CART, until=1, nodes=50),  # type: ignore[call-arg]
    "a figure of matplotlib, to be changed there": lambda: held()["lin"].plot(title="A"),  # type: ignore[call-arg]
    "degrees=True is in degrees": lambda: held()["run"].plot(units="deg"),  # type: ignore[call-arg]
    "lin.bode(hertz=True).plot() is over Hz": lambda: held()["bode"].plot(Hz=True),
    "filter: is of the derivative": lambda: symdyn.pid("theta", "F", 10, filter=0.1),
    "there is no m; did you mean mp?": lambda: CART.parameters["m"],  # type: ignore[call-overload]
    "give numbers in this order: F": lambda: symdyn.simulate(CART, until=0.1, feedback=lambda t, q, u: {"F": 0.0}),
    "{'F': 1} are not 1 finite numbers": lambda: symdyn.simulate(
        CART, until=0.1, feedback=symdyn.Feedback(lambda t, q, u: 0.0, period=0.1, initial={"F": 1})  # type: ignore[arg-type]
    ),
}  # fmt: skip


@pytest.mark.parametrize("told", TOLD)
def test_what_is_called_as_elsewhere_is_told_how_it_is_called(told: str) -> None:
    with pytest.raises((ArgumentError, SimulateError, UnknownNameError)) as caught:
        TOLD[told]()
    assert told in str(caught.value)


COPIED = {
    'lin.bode("x", "F").response': "held()['lin'].freqresp",
    'lin.step("x", "F").info()': "held()['lin'].step_info",
    'mag, phase, omega = lin.bode("x", "F")': "held()['bode'][0]",
    'run["x"].max()': "held()['run'].max",
    'run["F"]': "held()['run'].torque",
    'run.plot("x_dot", x="x")': "held()['run'].plot(y='x', x='theta')",
    'scene.parameters["mp"].value': "CART['mp']",
    'symdyn.scene.bind(scene, {"mc": 0.2})': "CART.with_parameters(mp=1)",
    'symdyn.simulate(scene, until=1, values={"mc": 0.2})': "CART.set",
    "symdyn.simulate(scene, until=0.1, values={'mp': 0.1})": "symdyn.simulate(CART, until=0.1, mp=0.1)",
    "symdyn.simulate(scene, until=0.1, start={'theta': 0.1})": "symdyn.simulate(CART, until=0.1, theta=0.1)",
    "symdyn.simulate(scene, until=0.1, start={'x': 0.1, 'x_dot': 0})": "symdyn.simulate(CART, until=0.1, y0=[0])",
    "symdyn.simulate(scene, until=0.1, forces={'F': '0.1*t'})": "symdyn.simulate(CART, until=0.1, u=0)",
    "lin.step(until=5)": "held()['lin'].step(5)",
    "lin.bode(omega=[1, 10])": "held()['lin'].bode([1, 10])",
    'symdyn.collocation(scene, until=1, cost="F**2")': "symdyn.collocation(CART, until=1, cost='minimum effort')",
    "symdyn.collocation(scene, until=1, cost='F**2')": "symdyn.collocation(CART, until=1, cost='F^2')",
    'lin.formulas.lambdify("mp")(0.1)': "held()['lin'].formulas['mp']",
}
"""What a message says, as it is copied, by what was typed; of an argument or a formula the call is written again."""


@pytest.mark.parametrize("copied", COPIED)
def test_what_a_message_says_runs_as_it_is_copied(copied: str) -> None:
    names = {**held(), "CART": CART, "held": held, "symdyn": symdyn, "scene": CART}
    with pytest.raises((AttributeError, ArgumentError, SimulateError, SymdynError)) as caught:
        eval(COPIED[copied], names)
    inside = re.search(r"""\w+=['"]?([{\[].*|F\*\*2|5)['"]?\)$""", copied)
    said = inside[1] if inside else copied.removeprefix("run.").removeprefix("lin.formulas.")
    assert said in str(caught.value) or copied in str(caught.value)
    exec(copied, names)


def test_the_name_of_a_joint_means_its_coordinate_or_its_drive() -> None:
    scene = symdyn.example("furuta")
    joint = next(one for one in scene.joints if one.drives[0])
    coordinate, drive = joint.coordinates[0], joint.drives[0]
    assert joint.name not in (coordinate, drive)
    for call, meant in (
        (lambda: symdyn.simulate(scene, until=0.1, start={joint.name: 0.1}), coordinate),
        (lambda: symdyn.simulate(scene, until=0.1, forces={joint.name: 0.1}), drive),
        (lambda: symdyn.simulate(scene, until=1e-3)[joint.name], coordinate),
        (lambda: symdyn.collocation(scene, until=1, end={joint.name: 0}), coordinate),
        (lambda: symdyn.sweep(scene, f"{scene.parameters[0].name}=[1, 2]", f"end({joint.name})"), coordinate),
    ):
        with pytest.raises(SymdynError, match=f"did you mean {meant}[?]"):
            call()


def test_a_period_as_long_as_the_run_is_told_and_how_milliseconds_are_written() -> None:
    law = held()["lqr"]

    def noted(period: float | str) -> str:
        return " ".join(symdyn.simulate(CART, until=0.1, feedback=symdyn.Feedback(law, period=period)).notes)

    assert 'of ms write "10 ms"' in noted(10)
    assert "one sample" not in noted("10 ms")


def test_equations_with_values_in_them_have_a_latex_of_their_own() -> None:
    equations = symdyn.equations(CART).subs(mp=2)
    left, right = equations.equations[0].args
    assert f"{latex(left, symbol_names=equations.letters)} &= {latex(right, symbol_names=equations.letters)}" in (
        equations.latex()
    )
    assert "m_p" not in equations.latex()
    assert "m_p" in symdyn.equations(CART).sympy().latex()


def test_what_pandas_and_python_control_do_works() -> None:
    run, regulator = held()["run"], held()["lqr"]
    assert len(run) == len(run.t)
    assert np.array_equal(np.asarray(run), run.table()[1])
    assert np.array_equal(regulator.poles(), regulator.poles)
    assert float(CART.parameters["mp"].value) == 0.1  # type: ignore[call-overload]
    assert CART.bodies["cart"] is CART.bodies[0]  # type: ignore[call-overload]
    assert "mp = 2 kg" in str(symdyn.scene.bind(CART, {"mp": 2}))
    made = symdyn.scene.scene(
        "one",
        inputs={"road": {"rates": 1}},
        parameters={"m": {"value": 2, "unit": "kg"}},
        bodies=[symdyn.scene.body("b", mass="m")],
        joints=[symdyn.scene.prismatic("s", "ground", "b", axis=[1, 0, 0])],
    )
    assert [one.name for one in made.inputs] == ["road", "road_dot"]
    assert made.parameters[0].unit == "kg"


def test_plots_in_degrees_have_their_units() -> None:
    run = held()["run"]
    (shown,) = panels(run, ["theta"], degrees=True)
    assert shown.title.endswith("deg")
    assert np.array_equal(shown.curves[0].values, np.degrees(run["theta"]))
    assert np.array_equal(panels(run, ["x"], degrees=True)[0].curves[0].values, run["x"])


def test_gains_that_act_far_from_the_start_are_told() -> None:
    scene = symdyn.example("furuta")
    up = symdyn.linearize(scene, start={"theta2": np.pi}).lqr()

    def notes(feedback: object) -> str:
        run = symdyn.simulate(scene, until=1e-3, every=1e-3, start={"theta2": 3}, feedback=feedback, method="dop853")  # type: ignore[arg-type]
        return " ".join(run.notes)

    assert "the gains act about theta2 = 0 rad, and the start is 3 rad from there" in notes(up.K)
    assert "gains act" not in notes(up)


def test_stiff_gains_along_a_motion_raise_no_warning(recwarn: pytest.WarningsRecorder) -> None:
    track(held()["run"], {"theta": 1e8}, {"F": 1e-3})
    assert not [one for one in recwarn if issubclass(one.category, RuntimeWarning)]


SCENE = """
gravity = [0, 0, -9.81]
parameters = { m = "2 kg", l = "1 m", k = "100 N/m" }
[bodies.rod]
mass = "m"
com = [0, "-l/2", 0]
[joints.pin]
type = "revolute"
parent = "ground"
child = "rod"
axis = [1, 0, 0]
coordinate = "phi"
"""

WORDS = {
    "revolute": "hinge pin rotary rotation pivot bearing R",
    "prismatic": "slider slide sliding linear translation telescopic P",
    "fixed": "weld welded rigid clamp",
    "spherical": "ball ball-and-socket ball_and_socket sphere S",
    "universal": "cardan hooke U",
    "cylindrical": "cylinder C",
    "planar": "plane",
    "helical": "screw helix",
    "free": "floating 6dof free_flyer",
    "point_on_line": "pin_in_slot slot",
    "rod": "massless_rod link",
    "mimic = { joint": "rack gear belt",
    'type = "rolling"': "wheel",
    "[ropes.NAME]": "rope",
}

KEYS = {
    "it is mass = 2": "weight",
    "it is com = [0, 0, 0.1]": "cg cog center centre center_of_mass",
    "mass, com and inertia say": "length radius size density",
    "it is inertia": "Izz ixx moment_of_inertia J",
    'child = "rod", origin': "position origin parent",
    "[joints.NAME] start": "start",
    '[loads.NAME] body = "rod"': "force",
}

SIDES = {"plate": "cuboid brick box", "rod": "tube bar", "ring": "hoop", "disc": "cylinder disk", "ball": "sphere"}

WRONG = [
    *(('"revolute"', f'"{word}"', told) for told, words in WORDS.items() for word in words.split()),
    *(("mass =", f"{word} = 3\nmass =", told) for told, words in KEYS.items() for word in words.split()),
    *(
        ("mass =", f'shape = "{word}"\nmass =', f"mean {told}?")
        for told, some in SIDES.items()
        for word in some.split()
    ),
    *(
        ("[1, 0, 0]", f'"{one}"', f"write axis = {told}")
        for one, told in {"z": "[0, 0, 1]", "-x": "[-1, 0, 0]", "X": "[1, 0, 0]", "0 0 1": "[0, 0, 1]"}.items()
    ),
    ("[1, 0, 0]", "(1, 0, 0)", "a list stands in [ and ]; write [1, 0, 0]"),
    ("[0, 0, -9.81]", '"y"', "write gravity = [0, -9.81, 0]"),
    ("[0, 0, -9.81]", '"-z"', "write gravity = [0, 0, -9.81]"),
    ("[0, 0, -9.81]", '"0, 0, -9.81"', "write gravity = [0, 0, -9.81]"),
    ("[0, 0, -9.81]", '"g"', 'write gravity = [0, 0, "-g"]'),
    ("[0, 0, -9.81]", '"off"', 'write gravity = "none"'),
    *(
        ("[0, 0, -9.81]", one, f"write gravity = {told}")
        for one, told in {
            "1e1": "[0, 0, -1E+1]",
            '"9,81"': "[0, 0, -9.81]",
            '"-9810 mm/s^2"': '[0, 0, "-9810 mm/s^2"]',
            '"32.2 ft/s^2"': '[0, 0, "-32.2 ft/s^2"]',
            '"9.8 N/kg"': '[0, 0, "-9.8 N/kg"]',
            '"5/3"': '[0, 0, "-5/3"]',
            '"-z axis"': "[0, 0, -9.81]",
            '"-e_z"': "[0, 0, -9.81]",
        }.items()
    ),
    *(("[0, 0, -9.81]", one, "vector; give a vector such as") for one in ('"1 g"', '"1/6 g"', '"0 0 -9810 mm/s^2"')),
    *(
        ('"phi"', f'"phi"\n{line}', told)
        for line, told in {
            'motion = "A sin(w t)"': "write A*sin(w*t)",
            'motion = "0.3 sin(2 t)"': "write 0.3*sin(2*t)",
            'drive = "0.3*sin(2*t)"': "motion prescribes it",
            'drive = "none"': "false where it is passive",
            'driven = "0.3*t"': 'motion = "0.3*sin(2*t)"',
            'phi = "0.3*t"': 'motion = "0.3*sin(2*t)"',
            "omega = 3": "start_rates = 2",
            "limits = { min = -1 }": "it is lower",
            'limits = { effort = "m*l" }': "N m is asked for",
            'force = "PI"': "write pi",
        }.items()
    ),
    ("[bodies.rod]", '[springs.a]\njoint = "phi"\nstiffness = "k*l"\n[bodies.rod]', "did you mean pin?"),
    ("[bodies.rod]", '[constraints.a]\ntype = "distance"\n[bodies.rod]', '[[loop]] type = "rod"'),
]


@pytest.mark.parametrize(("there", "typed", "told"), WRONG)
def test_words_of_other_tools_are_told_at_their_line(there: str, typed: str, told: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_text(SCENE.replace(there, typed, 1), "a.toml")
    line = SCENE[: SCENE.index(there)].count("\n") + 1 + typed.startswith('"phi"\n') + typed.startswith("[springs")
    lines = [one for one in caught.value.faults if told in one]
    assert lines, caught.value
    assert int(lines[0].split(":")[1]) in (line, line + 1), lines
    if told.startswith("write gravity") and '"-g"' not in told:
        assert read_text(SCENE.replace(there, told.partition("= ")[2]))


@pytest.mark.parametrize(
    ("there", "typed", "told"),
    [
        ('"1 m"', '"400 kg"', "a.toml:3: parameters.l: l fits nowhere: bodies.rod: com[1] = -l/2 is in kg"),
        ('"-l/2"', '"m"', "a.toml:6: bodies.rod: com[1] = m is in kg"),
    ],
)
def test_a_unit_that_fits_nowhere_is_told_where_it_is_declared(there: str, typed: str, told: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_text(SCENE.replace(there, typed), "a.toml")
    assert len(caught.value.faults) == 1
    assert caught.value.faults[0].startswith(told)


def test_formulas_that_hints_tell_are_formulas() -> None:
    told = [one for text in hints()["formulas"].values() for one in re.findall(r"^write (.+?)(?:, NAME.*)?$", text)]
    assert len(told) > 20
    for formula in told:
        assert "has no" not in str(symdyn.scene.parse(formula.replace("s in s**3", "s**3").split(" for ")[-1]))


def _nouns(kind: type) -> list[type]:
    return [kind, *(one for sub in kind.__subclasses__() for one in _nouns(sub))]


def test_hints_stand_once_and_none_is_of_what_is_there() -> None:
    rows = hints()
    fields = {one: {*dir(one), *getattr(one, "__dataclass_fields__", ())} for one in _nouns(Suggesting)}
    for one in held().values():
        fields[type(one)] |= {*vars(one)}
    for has, group in rows["attributes"].items():
        nouns = [one for one, known in fields.items() if has in known]
        assert nouns, f"no noun has {has}"
        names = [name for some in group for name in some.split()]
        assert len(names) == len({*names}), has
        idle = {name for name in names if all(name in fields[one] for one in nouns)}
        assert not idle, f"{has}: {idle} are there"
    assert {*KINDS} <= {*fields}
    rows_of = {"keywords": [(name, has) for some, (has, _) in rows["keywords"].items() for name in some.split()]}
    rows_of |= {kind: [(name, "") for some in rows[kind] for name in some.split()] for kind in ("functions", "names")}
    for kind, names in rows_of.items():
        assert len(names) == len({*names}), kind
    assert not {*dir(symdyn)} & {name for some in rows["functions"] for name in some.split()}


def test_functions_that_hints_name_are_there() -> None:
    for path in re.findall(r"symdyn\.([a-z_.]+[a-z_])\(", json.dumps(hints())):
        found: Any = symdyn
        for name in path.split("."):
            found = getattr(found, name)
        assert callable(found)
