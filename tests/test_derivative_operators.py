"""What is asked of every output by a word behind its name: against 50-digit differences, and against each other."""

from __future__ import annotations

import keyword
import random
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arms import chain
from counts_of_literature import state_dependent_counts
from mechanisms import COUPLED, jointed, with_loads
from small_steps import BIG, Numbers, State, apart

import symdyn
from symdyn.dynamics import OUTPUTS, Workspace, derive, derive_one, formulations_of
from symdyn.dynamics.outputs.named_functions import ARGUMENTS, DIRECTIONS
from symdyn.dynamics.outputs.requests import OPERATORS
from symdyn.emit import emit
from symdyn.errors import DerivationError
from symdyn.program import formulate, lower
from symdyn.scene import Scene, bind, read, read_text
from symdyn.verify import certify

pytestmark = pytest.mark.long

EXAMPLES = Path(__file__).parent.parent / "examples"

LED = """
name = "led"
[parameters]
m = 2
[bodies.cart]
mass = "m"
[bodies.arm]
mass = 1
com = [0.5, 0, 0.1]
inertia = [0.1, 0.2, 0.3]
inertia_about = "com"
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
motion = "sin(3*t)/2"
[joints.hinge]
type = "revolute"
parent = "cart"
child = "arm"
axis = [0, 1, 0]
rotor = { inertia = 0.001, gear = 10 }
force = "-0.3*hinge_dot*abs(hinge_dot - 2) + 0.1*cos(2*t)"
coordinate = "hinge"
"""


@cache
def scenes() -> dict[str, Scene]:
    """Return trees with quaternions, couplings, rotors, screws, loads, springs, friction, time, prescribed motion."""
    found = {name: read(EXAMPLES / f"{name}.toml") for name in ("two_link", "cart_pole", "free_body", "heavy_top")}
    mixed = jointed("free", "helical")
    return found | {
        "mixed": mixed,
        "loaded": with_loads(jointed("spherical", "revolute"), 3),
        "coupled": with_loads(COUPLED[2], 5),
        "led": read_text(LED, "led.toml"),
    }


SCENES = ("two_link", "cart_pole", "free_body", "mixed", "loaded", "coupled", "led")
DYNAMICS = ("inverse_dynamics", "forward_dynamics")


@cache
def numbers(name: str) -> Numbers:
    """Return a scene's functions in 50 digits."""
    return Numbers(Workspace(scenes()[name]))


def states(name: str, request: str, natural: bool = True) -> Iterator[State]:
    """Yield states: at rest with all coordinates zero, with equal angles, and at random."""
    w, rng = numbers(name).workspace, random.Random(f"{name} {request}")
    function = numbers(name).function(request)
    for kind in ("zero", "equal", "random") if natural else ("random",):
        state: State = {"t": [BIG.number("0.3")]}
        for argument in function.arguments:
            still = 0.0 if kind == "zero" else 0.5
            drawn = [rng.uniform(-2, 2) if kind == "random" else still for _ in argument.symbols]
            positive = [rng.uniform(0.5, 2) for _ in argument.symbols]
            chosen = positive if argument.name == "params" else drawn
            state[argument.name] = [BIG.number(x) for x in chosen]
        yield state | {"q": unit(w, state["q"])}


def unit(w: Workspace, q: list[Any]) -> list[Any]:
    """Return coordinates with quaternions of unit length; those of no length are 1."""
    from symdyn.dynamics.mechanism.state import quaternions

    for names in quaternions(w.scene):
        places = [w.scene.coordinates.index(name) for name in names]
        length = BIG.context.sqrt(sum(q[k] ** 2 for k in places))
        for k, first in zip(places, (1, 0, 0, 0), strict=True):
            q[k] = q[k] / length if length else BIG.number(first)
    return q


def arguments(name: str, request: str) -> list[tuple[str, int]]:
    """Return the directions that an output is differentiated along: argument, and number from 0."""
    n = numbers(name).workspace.state.n
    taken = OUTPUTS[request.partition(":")[0]].arguments
    return [(argument, k) for argument in taken for k in range(n)]


def requests(name: str) -> list[str]:
    """Return what is looked at of a scene."""
    last = scenes()[name].bodies[-1].name
    return [*DYNAMICS, "kinetic_energy", "potential_energy", f"pose:{last}", f"jacobian:{last}"]


def suffixed(request: str, suffix: str) -> str:
    """Return how a derivative is asked for: "pose_jvp:tool"."""
    name, colon, place = request.partition(":")
    return name + suffix + colon + place


def words_of(request: str) -> list[str]:
    """Return what can be asked of an output: of single arguments only those that it takes, and time."""
    taken = (*OUTPUTS[request.partition(":")[0]].arguments, "t", "parameters")
    return [word for word in OPERATORS if not word.startswith("_by_") or word.removeprefix("_by_") in taken]


# Against differences


@pytest.mark.heavy("mixed", "coupled")
@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_derivatives_are_what_differences_in_fifty_digits_tend_to(name: str) -> None:
    n = numbers(name)
    for request in requests(name):
        ways = arguments(name, request)
        for state in states(name, request):
            columns = [n.slope(request, state, *way) for way in ways]
            J = [column[i] for i in range(len(columns[0])) for column in columns]
            for formulation in formulations_of(suffixed(request, "_derivatives"), n.workspace.scene):
                derive_one(n.workspace, suffixed(request, "_derivatives"), formulation)
            assert apart(n.at(suffixed(request, "_derivatives"), state), J) < 1e-20, request


@pytest.mark.parametrize("name", ["two_link", "loaded", "mixed", "led"])
def test_second_derivatives_are_what_differences_of_differences_tend_to(name: str) -> None:
    """X_j X_k in this order: the outer step leads, and the inner slope is taken where it has led."""
    n = numbers(name)
    for request in DYNAMICS:
        ways, H = arguments(name, request), suffixed(request, "_hessian")
        (state,) = states(name, H, natural=False)
        found = n.at(H, state)
        chosen = random.Random(name).sample(range(len(ways) ** 2), 6)
        chosen += [1, len(ways)] if name == "mixed" else []  # a pair that does not commute
        for place in chosen:
            k, j = divmod(place, len(ways))
            slopes = n.slope_of_slope(request, state, ways[j], ways[k])
            expected = sum(a * b for a, b in zip(state["weights"], slopes, strict=True))
            assert apart([found[place]], [expected]) < 1e-15, (request, ways[j], ways[k])


@pytest.mark.parametrize("name", ["two_link", "loaded", "led"])
def test_derivatives_by_parameters_are_what_differences_tend_to(name: str) -> None:
    """Those with a value are given others by `bind`, in numbers that are exact."""
    scene = scenes()[name]
    w = Workspace(scene)
    step = BIG.number("1e-12")
    for request in DYNAMICS:
        function = derive(scene, [f"{request}_by_parameters"]).functions[0]
        (state,) = states(name, request, natural=False)
        known = {p.name: BIG.number(0.7 + 0.1 * k) for k, p in enumerate(scene.parameters)}
        values = {
            symbol: value
            for argument in derive_one(w, request).arguments
            if argument.name != "params"
            for symbol, value in zip(argument.symbols, state[argument.name], strict=True)
        }

        def at(entries: Any, given: dict[str, Any], values: Any = values) -> list[Any]:
            from symdyn.graph import evaluate

            graph = entries[0].graph
            both = {graph.symbol(str(s.value)): x for s, x in values.items()}
            return evaluate(entries, BIG, both | {graph.symbol(p): x for p, x in given.items()})

        f, columns = derive_one(w, request).entries, []
        for p in function.labels[1]:
            there, here = (at(f, known | {p: known[p] + sign * step}) for sign in (1, -1))
            columns.append([(a - b) / (2 * step) for a, b in zip(there, here, strict=True)])
        J = [column[i] for i in range(len(f)) for column in columns]
        assert apart(at(function.entries, known), J) < 1e-20, request
        one = derive(scene, [f"{request}_by_{function.labels[1][0]}"]).functions[0]
        assert apart(at(one.entries, known), J[:: len(columns)]) < 1e-20


# Against each other


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("request_", DYNAMICS)
def test_what_is_asked_of_derivatives_is_made_of_them(name: str, request_: str) -> None:
    n, request = numbers(name), request_
    ways, m = arguments(name, request), n.workspace.state.n
    for state in states(name, suffixed(request, "_hessian_vector")):
        J, H = (n.at(suffixed(request, one), state) for one in ("_derivatives", "_hessian"))
        N, d = len(ways), [state[f"d{along}"][k] for along, k in ways]
        rows = [J[i : i + N] for i in range(0, len(J), N)]
        jvp = [sum(a * b for a, b in zip(row, d, strict=True)) for row in rows]
        vjp = [sum(w * row[k] for w, row in zip(state["weights"], rows, strict=True)) for k in range(N)]
        Hd = [sum(H[k * N + j] * d[j] for j in range(N)) for k in range(N)]
        for suffix, expected in (("_jvp", jvp), ("_vjp", vjp), ("_hessian_vector", Hd)):
            for formulation in formulations_of(suffixed(request, suffix), n.workspace.scene):
                function = derive_one(n.workspace, suffixed(request, suffix), formulation)
                assert function.formulation == formulation
            assert apart(n.at(suffixed(request, suffix), state), expected) < 1e-35, suffix
        for block, along in enumerate(OUTPUTS[request].arguments):
            part = [x for row in rows for x in row[block * m : (block + 1) * m]]
            assert apart(n.at(f"{request}_by_{along}", state), part) < 1e-35


def test_a_tensor_has_an_axis_of_entries_and_two_of_directions() -> None:
    n = numbers("loaded")
    (state,) = states("loaded", "inverse_dynamics_hessian", natural=False)
    tensor, H = (n.at(f"inverse_dynamics_{one}", state) for one in ("second_derivatives", "hessian"))
    shape = n.function("inverse_dynamics_second_derivatives").shape
    assert shape == (4, 12, 12)
    size = shape[1] * shape[2]
    summed = [sum(w * tensor[i * size + k] for i, w in enumerate(state["weights"])) for k in range(size)]
    assert apart(summed, H) < 1e-35


def test_second_derivatives_commute_but_for_brackets() -> None:
    """[X_x, X_y] = X_z of the turns of a free body: H - Hᵀ is a first derivative, 0 for rates of coordinates."""
    n = numbers("free_body")
    pose = f"pose_{{}}:{scenes()['free_body'].bodies[-1].name}"
    (state,) = states("free_body", pose.format("hessian"), natural=False)
    H, slopes = n.at(pose.format("hessian"), state), n.at(pose.format("vjp"), state)
    gap = H[4 * 6 + 3] - H[3 * 6 + 4]  # X_wx X_wy - X_wy X_wx
    assert abs(gap) > 0.1
    assert apart([gap], [slopes[5]]) < 1e-35
    for row in range(3):
        assert apart([H[row * 6 + k] for k in range(3)], [H[k * 6 + row] for k in range(3)]) < 1e-35


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", ["two_link", "heavy_top", "led"])
def test_all_formulations_of_all_words_are_proved_equal(name: str) -> None:
    """Of the top with its quaternion, half Hessians with brackets against whole ones, too."""
    scene = scenes()[name]
    words = {one: words_of(one) for one in (*DYNAMICS, f"pose:{scene.bodies[0].name}")}
    wanted = [suffixed(one, word) for one in words for word in words[one]]
    wanted = [one for one in wanted if scene.parameters or "by_parameters" not in one]
    assert len(wanted) > 24
    assert certify(scene, wanted).passed


# What it costs


@pytest.mark.heavy("8", "16")
@pytest.mark.parametrize("name", ["arm7", "puma560", "quadruped", 4, 8, 16])
def test_a_product_with_derivatives_costs_little_more_than_the_function(name: str | int) -> None:
    """Of arms, of a robot on legs, and of chains in a plane, where all that is turned is a vector of two components."""
    w = Workspace(chain(name) if isinstance(name, int) else read(EXAMPLES / f"{name}.toml"))
    for request, most in (("inverse_dynamics", 2.5), ("forward_dynamics", 2.75), ("kinetic_energy", 3.0)):
        alone, *products = (
            state_dependent_counts(derive_one(w, request + word)).multiplications for word in ("", "_jvp", "_vjp")
        )
        assert max(products) <= most * alone, (request, alone, products)


def test_a_long_chain_solves_as_its_forward_dynamics_does() -> None:
    """Products with derivatives share the articulated inertias, and are what inverse dynamics says."""
    w = Workspace(chain(17))
    alone, jvp, vjp = (
        state_dependent_counts(derive_one(w, f"forward_dynamics{word}")).multiplications
        for word in ("", "_jvp", "_vjp")
    )
    assert max(jvp, vjp) <= 2.75 * alone
    assert derive_one(w, "forward_dynamics").formulation == "aba"
    assert derive_one(w, "forward_dynamics_jvp").formulation == "solved"


# What is told


def test_arguments_and_columns_are_named() -> None:
    function = derive(scenes()["free_body"], ["inverse_dynamics_hessian_vector"]).functions[0]
    assert [one.name for one in function.arguments] == ["q", "qd", "qdd", "weights", "dq", "dqd", "dqdd"]
    by_name = {one.name: one for one in function.arguments}
    assert by_name["dq"].units == ("m",) * 3 + ("rad",) * 3
    assert by_name["dq"].text == "direction of the positions, along the velocities"
    assert "moved frame" in by_name["dq"].names
    assert by_name["weights"].shape == (6,)
    assert function.labels[0][:4] == ("along flight_vx", "along flight_vy", "along flight_vz", "along flight_wx")


def test_headers_tell_the_arguments_that_the_words_add() -> None:
    program = lower(formulate(scenes()["free_body"], ["inverse_dynamics_hessian_vector"]))
    header = next(text for name, text in emit(program, "c").items() if name.endswith(".h"))
    for told in (
        "inverse_dynamics_hessian_vector(q, qd, qdd, weights, dq, dqd, dqdd) -> Hd, shape (18,)",
        "dq, shape (6,); m, m, m, rad, rad, rad: direction of the positions, along the velocities",
        "weights, shape (6,): weights of the entries of the result, row by row",
        "row k, column j: X_j X_k, not symmetric where quaternions turn",
    ):
        assert told in header, told


@pytest.mark.runs("cc")
@pytest.mark.long
def test_compiled_products_of_many_states_are_those_of_their_matrices() -> None:
    """The tensor has three axes in C and in ufuncs, too."""
    scene, rng = scenes()["heavy_top"], np.random.default_rng(2)
    words = ("derivatives", "jvp", "vjp", "second_derivatives", "hessian")
    names = tuple(f"inverse_dynamics_{word}" for word in words)
    e, d, w = rng.normal(size=(5, 4)), rng.normal(size=(3, 5, 3)), rng.normal(size=(5, 3))
    state = (e / np.linalg.norm(e, axis=1, keepdims=True), *rng.normal(size=(2, 5, 3)))
    loaded = symdyn.load(scene, names)
    for calls in (symdyn.lambdify(scene, names, "c"), tuple(loaded[name] for name in names)):
        J, jvp, vjp, tensor, H = calls
        assert np.allclose(np.einsum("sij,sj->si", J(*state), np.concatenate(d, axis=1)), jvp(*state, *d))
        assert np.allclose(np.einsum("sij,si->sj", J(*state), w), vjp(*state, w))
        assert np.allclose(np.einsum("sikj,si->skj", tensor(*state), w), H(*state, w))


def test_one_number_needs_no_weights() -> None:
    function = derive(scenes()["two_link"], ["kinetic_energy_hessian"]).functions[0]
    assert [one.name for one in function.arguments] == ["q", "qd", "params"]
    assert function.shape == (4, 4)
    assert "weight" not in function.text


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        ("kinetic_energy_by_qdd", "kinetic_energy takes q, qd; it has no derivatives by qdd"),
        ("prescribed_motion_derivatives", "prescribed_motion takes nothing; it has no derivatives by that"),
        ("prescribed_motion_jvp", "prescribed_motion takes nothing"),
        (
            "inverse_dynamics_by_mass",
            "two_link: mass is neither an argument .* nor a parameter of the scene; there are m1",
        ),
        ("inverse_dynamic_jvp", "did you mean inverse_dynamics_jvp"),
        ("kinetic_energy_grad", "of kinetic_energy there are kinetic_energy_jvp, .*_by_qd, kinetic_energy_by_t, "),
        (
            "forward_dynamics_jvp_by_q",
            "of forward_dynamics there are forward_dynamics_jvp, .*_by_qd, .*_by_tau, .*_by_t",
        ),
        ("reactions_jvp:elbow", "whole scene; write reactions_jvp or reactions_jvp:joint or reactions_jvp:ground$"),
        ("inverse_dynamics_by_q:joint", "whole scene; write inverse_dynamics_by_q$"),
        ("inverse_dynamics_by_ui", "ui is neither an argument .* nor a parameter of the scene; there are m1"),
        ("pose_jvp", "pose_jvp needs a point; write pose_jvp:NAME"),
        ("inverse_dynamics_jvp:tool", "is about the whole scene"),
    ],
)
def test_what_there_is_not_is_told(request_: str, message: str) -> None:
    with pytest.raises(DerivationError, match=message):
        derive(scenes()["two_link"], [request_])


def test_a_scene_without_parameters_says_how_to_name_some() -> None:
    with pytest.raises(DerivationError, match="free_body has no named parameter to differentiate by"):
        derive(scenes()["free_body"], ["inverse_dynamics_by_parameters"])


def test_a_large_tensor_is_refused_with_what_would_work() -> None:
    scene = read(EXAMPLES / "quadruped.toml")
    words = r"18 x 54 x 54 = 52488 entries.*ask for inverse_dynamics_hessian.*_packed, those"
    with pytest.raises(DerivationError, match=words):
        derive(scene, ["inverse_dynamics_second_derivatives"])


@pytest.mark.parametrize("word", ["_derivatives", "_jvp"])
def test_closed_scenes_have_derivatives_of_what_is_a_function_of_the_full_state(word: str) -> None:
    scene = read(EXAMPLES / "four_bar.toml")
    assert derive(scene, [f"constraint_residual{word}"]).functions[0].entries
    assert derive(scene, [f"mass_matrix{word}"]).functions[0].name == f"tree_mass_matrix{word}"


@pytest.mark.parametrize("request_", ["reactions:ground", "forward_reactions:joint"])
def test_outputs_with_axes_in_their_name_have_derivatives_too(request_: str) -> None:
    n = numbers("two_link")
    (state,) = states("two_link", suffixed(request_, "_jvp"), natural=False)
    ways = [(name, k) for name in OUTPUTS[request_].arguments for k in range(2)]
    slopes = [n.slope(request_, state, *way) for way in ways]
    expected = [
        sum(state[f"d{one}"][k] * x for (one, k), x in zip(ways, row, strict=True)) for row in zip(*slopes, strict=True)
    ]
    assert apart(n.at(suffixed(request_, "_jvp"), state), expected) < 1e-20
    usual = request_.partition(":")[0]
    assert apart(n.at(f"{usual}_jvp", state), expected) > 1e-3
    assert n.function(suffixed(request_, "_by_m1")).name == request_.replace(":", "_by_m1_")


@pytest.mark.parametrize("name", ["slider_crank", "cart_pole"])
def test_a_parameter_may_have_the_name_of_an_argument_of_something_else(name: str) -> None:
    text = (EXAMPLES / f"{name}.toml").read_text()
    there = read(EXAMPLES / f"{name}.toml")
    p = "m1" if name == "slider_crank" else "mc"
    scene = read_text(text.replace(f"{p} =", "ui =").replace(f'"{p}"', '"ui"'))
    for request in DYNAMICS:
        own, usual = (derive(one, [f"{request}_by_{by}"]) for one, by in ((scene, "ui"), (there, p)))
        assert own.functions[0].labels[1] == ("ui",)
        assert len(own.functions[0].entries) == len(usual.functions[0].entries)


def test_derivatives_of_reactions_that_are_one_choice_say_so() -> None:
    text = derive(read(EXAMPLES / "four_bar.toml"), ["reactions_by_q"]).functions[0].text
    assert text.endswith("; of one choice among many where an entry is statically indeterminate")
    assert "choice" not in derive(scenes()["two_link"], ["reactions_by_q"]).functions[0].text


# Zeros


def test_a_parameter_that_is_zero_has_a_slope() -> None:
    """Its formulas are derived as if it had none, and the zero is put in afterwards."""
    scene = read(EXAMPLES / "two_link.toml")
    zero = replace(
        scene,
        parameters=tuple(
            replace(p, value=symdyn.scene.Quantity.number(0)) if p.name == "h1" else p for p in scene.parameters
        ),
    )
    call, other = (symdyn.lambdify(one, "potential_energy_by_h1") for one in (scene, zero))
    q, known = [0.3, 0.4], [2.0, 3.0, 0.0, 1.0, 9.81]
    assert other(q, [2.0, 3.0, 1.0, 9.81]) == pytest.approx(call(q, known))
    assert abs(call(q, known)).max() > 1


def test_a_parameter_that_bind_has_taken_away_is_told() -> None:
    scene = bind(read(EXAMPLES / "two_link.toml"), {"h1": 0})
    with pytest.raises(DerivationError, match="h1 is zero and stands in no formula any more"):
        derive(scene, ["kinetic_energy_by_h1"])
    function = derive(scene, ["kinetic_energy_by_parameters"]).functions[0]
    assert function.labels[1] == ("m1", "m2", "h2", "g")
    assert function.text.endswith("; without h1, zero and in no formula any more")


# Kinks

RUBBING = """
name = "rubbing"
[bodies.block]
mass = 1
[joints.rail]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
coordinate = "x"
friction = { coulomb = 2 }
force = "-3*abs(x_dot)*x_dot - 2*x_dot*sqrt(x_dot**2)"
"""


def test_a_kink_is_told_and_an_ideal_sign_has_no_forward_dynamics() -> None:
    scene = read_text(RUBBING, "rubbing.toml")
    function = derive(scene, ["inverse_dynamics_derivatives"]).functions[0]
    assert "one-sided where a sign or an absolute value turns over, of x_dot" in function.text
    assert "no number (NaN) where a root vanishes, of x_dot" in function.text
    assert "one-sided" not in derive(scene, ["inverse_dynamics_by_q"]).functions[0].text
    assert "one-sided" not in derive(scene, ["inverse_dynamics_by_qdd"]).functions[0].text
    with pytest.raises(DerivationError, match="ideal sign"):
        derive(scene, ["forward_dynamics_derivatives"])


def test_an_angle_of_nothing_is_told() -> None:
    scene = read_text(RUBBING.replace("sqrt(x_dot**2)", "atan2(x_dot, 2*x)"), "rubbing.toml")
    text = derive(scene, ["inverse_dynamics_derivatives"]).functions[0].text
    assert text.endswith("no number (NaN) where both sides of an atan2 vanish, of x and x_dot")
    assert "atan2" not in derive(scene, ["inverse_dynamics_by_qdd"]).functions[0].text


def test_beside_a_kink_derivatives_are_those_of_its_side() -> None:
    call = symdyn.lambdify(read_text(RUBBING, "rubbing.toml"), "inverse_dynamics_by_qd")
    for side in (1.0, -1.0):
        assert call([0.0], [side * 1e-9], [0.0])[0, 0] == pytest.approx(1e-8, rel=1e-6)


def test_arguments_are_names_in_every_language() -> None:
    """A target's file would not be read: `lambda` is none of Python's, `default` none of C's."""
    words = {
        *keyword.kwlist,
        *[
            "auto",
            "break",
            "case",
            "default",
            "delete",
            "do",
            "double",
            "export",
            "float",
            "int",
            "new",
            "null",
            "this",
            "void",
        ],
    }
    assert not words & set(ARGUMENTS)
    assert set(DIRECTIONS) | set(DIRECTIONS.values()) <= set(ARGUMENTS)
