"""Forces and motions as words, numbers, arrays, tables and functions: the same run, and one error a mistake."""

import math
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sympy

import symdyn
from symdyn.errors import ArgumentError, LinearizeError, SceneError, SimulateError
from symdyn.scene import Scene, read
from symdyn.simulation import inverse, read_forces, read_motion, simulate
from symdyn.simulation.prescribed.formulas_in_time import read_file
from symdyn.simulation.prescribed.motion_laws import function_law

EXAMPLES = Path(__file__).parents[1] / "examples"
T = np.linspace(0.0, 1.0, 201)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return read(EXAMPLES / "double_pendulum.toml")


def _column(t: float, q: np.ndarray, u: np.ndarray) -> list[float]:
    return [2 * math.sin(t) - q[0], 0.3]


FORCES = {
    "words and numbers by name": {"tau1": "2*sin(t) - q1", "tau2": 0.3},
    "numbers of NumPy": {"tau1": "2*sin(t) - q1", "tau2": np.float64(0.3)},
    "a function of t, q, u": {"tau1": lambda t, q, u: 2 * math.sin(t) - q[0], "tau2": 0.3},
    "functions by coordinate, an array of one": {"q1": lambda t, q, u: 2 * np.sin([t]) - q[0], "q2": lambda t: 0.3},
    "a formula and a function with more arguments": ["tau1=2*sin(t)-q1", {"tau2": lambda t, gain=0.3: gain}],
    "one function of all": _column,
}
TABLES = {
    "arrays": {"t": T, "tau1": 2 * np.sin(T), "tau2": np.full_like(T, 0.3)},
    "lists and words": {"t": T.tolist(), "tau1": (2 * np.sin(T)).tolist(), "tau2": "3/10"},
    "times and values": [{"tau1": (T, 2 * np.sin(T))}, "tau2=0.3"],
}


@pytest.mark.runs("cc")
@pytest.mark.parametrize("forces", FORCES.values(), ids=FORCES)
def test_forces_are_the_same_whatever_they_are_given_as(scene: Scene, forces: object) -> None:
    words = simulate(scene, forces=["tau1=2*sin(t)-q1", "tau2=0.3"], until=1.0, method="dop853")
    run = simulate(scene, forces=forces, until=1.0, method="dop853")  # type: ignore[arg-type]

    assert np.abs(run.q - words.q).max() < 1e-12
    assert np.abs(run.tau - words.tau).max() < 1e-12


@pytest.mark.runs("cc")
@pytest.mark.parametrize("forces", TABLES.values(), ids=TABLES)
def test_forces_over_time_are_interpolated(scene: Scene, forces: object) -> None:
    words = simulate(scene, forces={"tau1": "2*sin(t)", "tau2": "0.3"}, until=1.0, method="dop853")
    run = simulate(scene, forces=forces, until=1.0, method="dop853")  # type: ignore[arg-type]
    assert np.abs(run.q - words.q).max() < 1e-6
    assert not run.notes


@pytest.mark.runs("cc")
def test_tables_of_pandas_and_xarray_and_a_run_are_forces_and_motions(scene: Scene) -> None:
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    words = simulate(scene, forces={"tau1": "2*sin(t)", "tau2": "0.3"}, until=1.0, every=0.005, method="dop853")
    frame = pandas.DataFrame({"t": T, "tau1": 2 * np.sin(T), "tau2": 0.3, "note": "x"})
    given = [
        frame,
        frame.set_index("t"),
        {"tau1": pandas.Series(2 * np.sin(T), index=T), "tau2": 0.3},
        xarray.Dataset({"tau1": ("t", 2 * np.sin(T)), "tau2": ("t", 0 * T + 0.3)}, coords={"t": T}),
        words,
    ]
    for forces in given:
        assert np.abs(simulate(scene, forces=forces, until=1.0, method="dop853", every=0.005).q - words.q).max() < 1e-6

    with pytest.raises(SimulateError, match=r"^forces: DataFrame has neither a column nor an index t, the times in s$"):
        read_forces(scene, frame.drop(columns="t").assign(B=1.0, num=1.0))  # of which it was a controller
    marked = lambda t: [2 * np.sin(t), 0.3]  # noqa: E731
    marked.num = marked.law = 0  # type: ignore[attr-defined]  # of which it was a controller, too
    for one in (marked, {"tau1": marked}):
        read_forces(scene, one)
    moved = inverse(scene, words, words.t)
    assert np.abs(moved.tau - words.tau).max() < 1e-8
    only_places = inverse(scene, frame.rename(columns={"tau1": "q1", "tau2": "q2"}), T)
    assert np.abs(only_places["q1"] - 2 * np.sin(T)).max() < 1e-15


@pytest.mark.runs("cc")
@pytest.mark.long
@pytest.mark.parametrize("method", ["radau", "cvode", "ida"])
def test_implicit_methods_follow_functions(scene: Scene, method: str) -> None:
    if method != "radau":
        pytest.importorskip("sksundae")
    words = simulate(scene, forces=["tau1=2*sin(t)-9*q1"], until=1.0, method="dop853")
    run = simulate(scene, forces={"tau1": lambda t, q, u: 2 * math.sin(t) - 9 * q[0]}, until=1.0, method=method)
    assert np.abs(run.q - words.q).max() < 1e-5


@pytest.mark.runs("cc")
def test_functions_act_beside_a_sampled_controller_and_series_give_way(scene: Scene) -> None:
    feedback = symdyn.simulation.Feedback(lambda t, q, u: -2 * u[0], ("tau1",), period=0.1)
    words = simulate(scene, forces={"tau1": "sin(t)"}, until=1.0, feedback=feedback)
    run = simulate(scene, forces={"tau1": math.sin}, until=1.0, feedback=feedback)
    assert np.abs(run["tau1"] - words["tau1"]).max() < 1e-7

    said: list[str] = []
    simulate(scene, forces={"tau1": math.sin}, until=0.1, say=said.append)
    assert "no Taylor method: a force is a function" in said[0]


@pytest.mark.runs("cc")
def test_symbols_of_sympy_are_names_wherever_a_name_is_a_key(scene: Scene) -> None:
    t, (q1, tau1) = sympy.Symbol("t"), sympy.symbols("q1 tau1")
    moving = sympy.Function("q1")(t)
    start, rates = {q1: 0.3}, {moving.diff(t): 0.2}
    said = simulate(scene, forces={"tau1": "0.1*t"}, start={"q1": 0.3}, start_rates={"q1_dot": 0.2}, until=0.1)
    for forces in ({tau1: t / 10}, [{tau1: t / 10}], {t: T, tau1: T / 10}):
        run = simulate(scene, forces=forces, start=start, start_rates=rates, until=0.1)
        np.testing.assert_allclose(run.q, said.q, atol=1e-9)
    assert symdyn.inverse(scene, {moving: t, "q2": 0}, until=0.1)["q1"][-1] == pytest.approx(0.1)
    system = symdyn.linearize(scene, start={moving: 0})
    np.testing.assert_array_equal(system.lqr({q1: 2}, {tau1: 1}).K, system.lqr({"q1": 2}, {"tau1": 1}).K)
    with pytest.raises(ArgumentError, match=r"^q1: given twice, as text and as a symbol; leave one out$"):
        simulate(scene, start={q1: 1, "q1": 2}, until=0.1)


MISTAKES = [
    ("tau1=1,", '^forces: "" is neither a file nor name=formula$'),
    ("tau9=1", "^forces: tau9 is neither a drive nor a coordinate; did you mean tau2.$"),
    ({"tau9": math.sin}, "^forces: tau9 is neither a drive nor a coordinate; did you mean tau2.$"),
    ({"t": T, "tau9": T}, "^forces: tau9 is neither a drive nor a coordinate; did you mean tau2.$"),
    ({"tau1": [1, 2, 3]}, r"^forces: tau1: list \[1, 2, 3\] is no course over time; give a formula such as .*$"),
    ({"tau1": None}, "^forces: tau1: NoneType None is no course over time; .*$"),
    ({"tau1": True}, "^forces: tau1: bool True is no course over time; .*$"),
    ({"tau1": ""}, "^forces: tau1: .*it is empty.*$"),
    ({"tau1": math.nan}, "^forces: tau1: .*nan is not a finite number$"),
    ({"tau1": lambda a, b: a}, r"^forces: tau1: the function takes 2 arguments; a force is a function of t, or .*$"),
    ({1: "2"}, "^forces: 1 is no name; names are text$"),
    ({"t": 3, "tau1": 1}, "^forces: t = 3 is not what moves; t are the times of arrays$"),
    ({"t": T, "tau1": T[1:]}, "^forces: tau1 has 200 values at 201 times; give 201, one for each of t$"),
    ({"t": T[::-1], "tau1": T}, "^forces: t = 0.995 does not come after t = 1; sort by time$"),
    ({"tau1": (T, T * np.nan)}, "^forces: tau1: tau1 has nan as value 1; give finite numbers$"),
    ({"t": T, "tau1": [[1], [2, 3]]}, "^forces: tau1 is no row of numbers; give one number for each time, such as .*$"),
    ({"t": ["a", "b"], "tau1": [1, 2]}, r"^forces: t is no row of numbers; give one number for each time, such as .*$"),
    ({"t": T, "tau1": np.zeros((2, 201))}, r"^forces: tau1 is no row of numbers but of shape \(2, 201\); give one .*$"),
    (np.zeros((3, 2)), r"^forces: an array of shape \(3, 2\) says no forces; .*$"),
    (3, "^forces: int 3 says no forces; .*$"),
    ([["tau1=1"]], "^forces: list .* says no forces; .*$"),
    (("tau1=1", "tau1=2"), "^forces: tau1 is given twice, as 1 and as 2$"),
    ({"tau1": "1", "q1": math.sin}, "^forces: q1 has a force already$"),
    ({"tau1": "sin(", "tau2": "x"}, "^forces: tau1: .*breaks off.*\nforces: tau2: .*uses x, which is not known.*$"),
]


@pytest.mark.parametrize(("forces", "message"), MISTAKES, ids=[message for _, message in MISTAKES])
def test_a_mistake_is_one_error(scene: Scene, forces: object, message: str) -> None:
    with pytest.raises(SimulateError, match=message):
        read_forces(scene, forces)  # type: ignore[arg-type]


@pytest.mark.runs("cc")
def test_a_function_that_fails_is_told_by_its_name_and_what_came_before_stands(scene: Scene) -> None:
    for function, words in (
        (lambda t: 1 / 0, "forces: tau1: the function raised ZeroDivisionError: division by zero at t = 0 s"),
        (lambda t: "a", "forces: tau1: the function returned 'a', which is no force, at t = 0 s"),
        (lambda t: [1, 2], r"forces: tau1: the function returned \[1, 2\], numbers of shape \(2,\), at t = 0 s"),
    ):
        with pytest.raises(SimulateError, match=words):
            simulate(scene, forces={"tau1": function}, until=1.0)
    with pytest.warns(RuntimeWarning, match="the function raised ValueError: late at t = 0.5"):
        run = simulate(scene, forces={"tau1": _late}, until=1.0)
    assert 0.3 < run.t[-1] <= 0.5


def _late(t: float) -> float:
    if t > 0.5:
        raise ValueError("late")
    return t


def test_doors_that_differentiate_refuse_functions(scene: Scene) -> None:
    with pytest.raises(LinearizeError, match="tau1: a function has no derivatives; write a formula"):
        symdyn.linearize(scene, forces=read_forces(scene, {"tau1": math.sin}))
    with pytest.raises(SimulateError, match="tau1: a function has no derivatives; write a formula"):
        symdyn.sensitivity(scene, forces={"tau1": math.sin})


LAWS = {
    "functions, differentiated": ({"q1": lambda t: math.sin(2 * t), "q2": "0.3*t"}, 1e-9),
    "functions of three": (
        {"q1": lambda t: (np.sin(2 * t), 2 * np.cos(2 * t), -4 * np.sin(2 * t)), "q2": "3*t/10"}, 1e-12,
    ),
    "arrays": (
        {"t": T, "q1": np.sin(2 * T), "q1_dot": 2 * np.cos(2 * T), "q1_ddot": -4 * np.sin(2 * T), "q2": "0.3*t"}, 1e-12
    ),
    "times and values": ([{"q1": (T, np.sin(2 * T))}, "q2=0.3*t"], 1e-2),
}  # fmt: skip


@pytest.mark.runs("cc")
@pytest.mark.parametrize(("motion", "apart"), LAWS.values(), ids=LAWS)
def test_motions_are_the_same_whatever_they_are_given_as(scene: Scene, motion: object, apart: float) -> None:
    words = inverse(scene, ["q1=sin(2*t)", "q2=0.3*t"], T)
    assert np.abs(inverse(scene, motion, T).tau - words.tau).max() < apart  # type: ignore[arg-type]


def test_differences_of_a_function_are_good_to_ten_digits_and_begin_where_it_begins() -> None:
    law = function_law(lambda t: math.exp(-t) * math.sin(5 * t), "q1")
    x, v, a = law(T)
    assert np.abs(v - np.exp(-T) * (5 * np.cos(5 * T) - np.sin(5 * T))).max() < 1e-11
    assert np.abs(a - np.exp(-T) * (-24 * np.sin(5 * T) - 10 * np.cos(5 * T))).max() < 1e-9
    assert x[0] == 0.0
    assert np.isfinite(function_law(lambda t: t * math.sqrt(t), "q1")(np.array([0.01]))).all()
    assert pickle.loads(pickle.dumps(function_law(math.sin, "q1")))(0.0)[0] == 0.0


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        ({"q9": math.sin}, "^motion: q9 is not a coordinate; known are q1, q2$"),
        (math.sin, "^motion: a function moves a coordinate; give it by name; known are q1, q2$"),
        ({"q1": lambda a, b: 1}, "^motion: q1: a function takes one argument, the time in s, and returns .*$"),
        ({"t": T, "q7": T}, "^motion: q7 is not a coordinate; known are q1, q2$"),
        ({"q1": [1, 2, 3]}, "^motion: q1: list .* is no course over time; .*$"),
    ],
)
def test_a_mistake_in_a_motion_is_one_error(scene: Scene, motion: object, message: str) -> None:
    with pytest.raises(SimulateError, match=message):
        read_motion(scene, motion)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"start": [1, 2]}, r"^start = \[1, 2\]: give values by name, as in \{'NAME': 0.3\} or text or a Start"),
        ({"start": "q1"}, '^start: "q1" is not name=formula$'),
        ({"until": "3"}, "^until = '3': give a number"),
        ({"until": None}, "^until = None: give a number"),
        ({"every": "a"}, "^every = 'a': give a number"),
        ({"stops": "q1 +"}, r'^event: "q1 \+" is not a usable formula: .*$'),
    ],
)
def test_a_mistake_beside_forces_is_one_error(scene: Scene, given: dict[str, object], message: str) -> None:
    with pytest.raises(SimulateError, match=message):
        simulate(scene, **given)  # type: ignore[arg-type]
    with pytest.raises(SimulateError, match=r"^times: 'abc' are no times; .*$"):
        inverse(scene, {"q1": "t"}, "abc")


def test_every_mistake_of_a_call_is_told_at_once(scene: Scene) -> None:
    with pytest.raises(SimulateError) as caught:
        simulate(scene, forces={"tau9": 1}, start={"q9": 1}, until=-1.0, method="dopri", stops="q7")
    assert len(caught.value.faults) == 5, caught.value


def test_the_byte_that_is_no_text_is_told(tmp_path: Path) -> None:
    (tmp_path / "latin.csv").write_bytes(b"t,\xfc\n0,1\n")
    with pytest.raises(SimulateError, match=r"latin\.csv: byte 2 is not UTF-8; save the file as UTF-8 text"):
        read_file(tmp_path / "latin.csv")


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (
            lambda scene: symdyn.equations(scene, form=1),
            r"equations\(\) got .* 'form'; there are scene, formulation, values$",
        ),  # type: ignore[call-arg]
        (lambda scene: symdyn.sweep(scene, samples=3), r"sweep\(\) got .* 'samples'; did you mean count\?"),  # type: ignore[call-arg]
        (lambda scene: symdyn.collocation(scene, untl=1), r"collocation\(\) got .* 'untl'; did you mean until\?"),  # type: ignore[call-arg]
        (lambda scene: symdyn.inverse(scene, evry=1), r"inverse\(\) got .* 'evry'; did you mean every\?"),  # type: ignore[call-arg]
        (lambda scene: symdyn.film(scene, looop=1), r"film\(\) got .* 'looop'; did you mean loop\?"),  # type: ignore[call-arg]
        (lambda scene: symdyn.pid("q1", "tau1", kpp=1), r"pid\(\) got .* 'kpp'; did you mean kp\?"),  # type: ignore[call-arg]
    ],
)
def test_a_wrong_keyword_says_which_was_meant(call: Callable[[Scene], object], told: str, scene: Scene) -> None:
    with pytest.raises(TypeError, match=told):
        call(scene)


@pytest.mark.runs("cc")
def test_a_wrong_attribute_says_which_was_meant(scene: Scene) -> None:
    run = inverse(scene, {"q1": "t"}, until=1)

    with pytest.raises(AttributeError, match=r'^Trajectory has no attribute \'q1\'; write \["q1"\]$'):
        run.q1  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match=r"has no attribute 'strat'; did you mean start\?$"):
        symdyn.Problem(scene).strat  # type: ignore[attr-defined]  # noqa: B018
    assert pickle.loads(pickle.dumps(run)).t.tolist() == run.t.tolist()


@pytest.mark.runs("cc")
def test_times_of_inverse_are_given_as_those_of_simulate(scene: Scene) -> None:
    given = inverse(scene, {"q1": "t**2"}, np.linspace(0, 2, 5))

    assert inverse(scene, {"q1": "t**2"}, until=2, every=0.5).tau.tolist() == given.tau.tolist()
    with pytest.raises(SimulateError, match=r"^times = 2: times are a row of numbers; .*: until=2, every=0\.01$"):
        inverse(scene, {"q1": "t"}, 2)
    with pytest.raises(SimulateError, match=r"^times: until and every say them too; leave out either$"):
        inverse(scene, {"q1": "t"}, [0.0, 1.0], until=2)


def test_a_scene_is_not_made_of_the_name_of_a_file() -> None:
    """It was an empty scene without a word."""
    with pytest.raises(
        SceneError, match=r'arm\.toml is a file, and a Scene is what is in it: symdyn\.read\("arm\.toml"\)'
    ):
        symdyn.scene.Scene("arm.toml")
