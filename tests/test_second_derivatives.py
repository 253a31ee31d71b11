"""All second derivatives of whole robots, packed: against differences of the first ones, and against the graph."""

from __future__ import annotations

import random
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arms import turning_chain
from mechanisms import COUPLED, TREES, jointed, with_loads
from small_steps import BIG, Numbers, State, apart

import symdyn
from symdyn.dynamics import Workspace, derive, derive_one, second_derivative_places
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.dynamics.outputs.second_derivatives import PACKED
from symdyn.emit import emit
from symdyn.errors import DerivationError
from symdyn.program import formulate, lower
from symdyn.runtime import second_derivatives
from symdyn.scene import Scene, read, read_text
from symdyn.verify import certify

EXAMPLES = Path(__file__).parent.parent / "examples"
INVERSE, FORWARD = PACKED

RESISTED = """
name = "resisted"
units = "none"
[bodies.arm]
mass = 2
com = [0.4, 0.1, 0.05]
inertia_about = "com"
inertia = { xx = 0.1, yy = 0.2, zz = 0.25, xy = 0.01, yz = -0.02 }
[bodies.block]
mass = 1
com = [0.1, 0, 0.2]
[bodies.other]
mass = 1.5
com = [0, 0.3, 0]
inertia_about = "com"
inertia = [0.05, 0.06, 0.07]
[joints.shoulder]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 1, 0]
rotor = { inertia = 0.001, gear = 10 }
force = "-0.3*shoulder_dot**3 - 2*sin(shoulder)"
coordinate = "shoulder"
[joints.slide]
type = "prismatic"
parent = "arm"
child = "block"
axis = [1, 0.5, 0]
origin = [0.3, 0.2, 0.1]
damping = 0.7
coordinate = "slide"
[joints.elbow]
type = "revolute"
parent = "arm"
child = "other"
axis = [0.2, 0, 1]
origin = [0.5, 0, 0]
coordinate = "elbow"
"""


@cache
def numbers(name: str) -> Numbers:
    """Return a scene's functions in 50 digits: branches, balls at the ground and on an arm, free flight, slides."""
    made = {
        "tree": lambda: TREES[0],
        "ball on an arm": lambda: jointed("revolute", "spherical", "prismatic"),
        "flying arm": lambda: jointed("free", "revolute"),
        "branches": lambda: turning_chain(5, "tree"),
        "loaded": lambda: with_loads(jointed("spherical", "revolute"), 3),
        "resisted": lambda: read_text(RESISTED, "resisted.toml"),
    }
    return Numbers(Workspace(made[name]() if name in made else read(EXAMPLES / f"{name}.toml")))


SCENES = ("two_link", "heavy_top", "tree", "ball on an arm", "flying arm", "branches", "resisted", "loaded")


def state_of(n: Numbers, request: str, kind: str) -> State:
    """Return a state: at rest with all coordinates zero, with all numbers equal, or at random."""
    rng, scene, still = random.Random(request), n.workspace.scene, 0.0 if kind == "zero" else 0.5
    state: State = {}
    for argument in n.function(request).arguments:
        drawn = [rng.uniform(-2, 2) if kind == "random" else still for _ in argument.symbols]
        positive = [rng.uniform(0.5, 2) for _ in argument.symbols]
        state[argument.name] = [BIG.number(x) for x in (positive if argument.name == "params" else drawn)]
    for names in quaternions(scene):
        places = [scene.coordinates.index(name) for name in names]
        length = BIG.context.sqrt(sum(state["q"][k] ** 2 for k in places))
        for k, first in zip(places, (1, 0, 0, 0), strict=True):
            state["q"][k] = state["q"][k] / length if length else BIG.number(first)
    return state


def pairs_of(w: Workspace, request: str) -> list[tuple[int, int, int]]:
    """Return force or acceleration, row and column of every entry."""
    if request == INVERSE:
        return [(int(i), int(k), int(j)) for i, k, j in second_derivative_places(w.scene)]
    names = [f"{name} of {one}" for name in ("q", "qd", "tau") for one in w.scene.velocities]
    columns = [label.removeprefix("by ").split(", ") for label in derive_one(w, request).labels[1]]
    return [(i, names.index(k), names.index(j)) for i in range(w.state.n) for k, j in columns]


@pytest.mark.heavy("tree", "branches", "flying arm", "loaded")
@pytest.mark.long(1)
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("kind", ["zero", "equal", "random"])
def test_they_are_what_differences_of_first_derivatives_tend_to(name: str, kind: str) -> None:
    n = numbers(name)
    nv = n.workspace.state.n
    for request, arguments in ((INVERSE, ("q", "qd", "qdd")), (FORWARD, ("q", "qd", "tau"))):
        first = f"{request.removesuffix('_second_derivatives_packed')}_derivatives"
        state, at = state_of(n, request, kind), pairs_of(n.workspace, request)
        found = n.at(request, state)
        for j in {"zero": (nv - 1, nv), "equal": (0, 3 * nv - 1), "random": (nv - 1, 2 * nv - 1, 2 * nv)}[kind]:
            slopes = n.slope(first, state, arguments[j // nv], j % nv)
            here = [place for place, one in enumerate(at) if one[2] == j]
            expected = [slopes[at[place][0] * 3 * nv + at[place][1]] for place in here]
            assert apart([found[place] for place in here], expected) < 1e-15, (request, j)


@pytest.mark.parametrize("name", ["ball on an arm", "branches", "resisted", "heavy_top"])
def test_what_stands_at_no_place_vanishes_or_follows_by_exchange(name: str) -> None:
    """The whole tensor of the graph, entry by entry: nothing is left out, nothing stands for two numbers."""
    n = numbers(name)
    state, nv = state_of(n, INVERSE, "random"), n.workspace.state.n
    packed = dict(zip(pairs_of(n.workspace, INVERSE), n.at(INVERSE, state), strict=True))
    tensor = np.full((nv, 3 * nv, 3 * nv), BIG.number(0), dtype=object)
    for (i, k, j), value in packed.items():
        tensor[i, j, k] = value
        if j >= 2 * nv:
            tensor[j - 2 * nv, k, 2 * nv + i] = tensor[j - 2 * nv, 2 * nv + i, k] = value
    for place, value in packed.items():
        tensor[place] = value
    assert apart(list(tensor.ravel()), n.at("inverse_dynamics_second_derivatives", state)) < 1e-35


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("name", ["two_link", "heavy_top"])
def test_recursion_and_sweeps_are_proved_equal(name: str) -> None:
    assert certify(numbers(name).workspace.scene, [INVERSE, FORWARD]).passed


@pytest.mark.slow
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("name", ["puma560", "free_body"])
def test_those_of_robots_are_proved_equal(name: str) -> None:
    assert certify(read(EXAMPLES / f"{name}.toml"), [INVERSE, FORWARD]).passed


@pytest.mark.long
def test_a_robot_on_legs_has_few_entries_and_few_operations() -> None:
    """Of 18 x 54 x 54 = 52,488 entries: those of three velocities on one way, each once."""
    dog = read(EXAMPLES / "quadruped.toml")
    (routine,) = lower(formulate(dog, [INVERSE])).routines
    at = second_derivative_places(dog)
    assert routine.function.shape == (5972,) == at.shape[:1]
    assert len({tuple(one) for one in at}) == 5972
    assert routine.counts.multiplications <= 7468
    assert routine.counts.additions <= 8050
    legs = [set(range(6 + 3 * k, 9 + 3 * k)) for k in range(4)]
    for place in at % 18:
        assert sum(bool(leg & set(place.tolist())) for leg in legs) <= 1


@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize("request_", [INVERSE, FORWARD])
def test_compiled_code_and_the_numpy_module_give_the_same(request_: str, tmp_path: Path) -> None:
    n = numbers("flying arm")
    scene = n.workspace.scene
    state = state_of(n, request_, "random")
    expected = np.array(n.at(request_, state), dtype=float)
    given = [np.array(state[name], dtype=float) for name in list(state)]
    found = symdyn.lambdify(scene, request_)(*given)
    assert found.ravel() == pytest.approx(expected, rel=1e-10, abs=1e-10)
    text = next(iter(emit(lower(formulate(scene, [request_])), "numpy").texts.values()))
    module: dict[str, Any] = {}
    exec(text, module)
    assert np.ravel(module[request_](*given)) == pytest.approx(expected, rel=1e-10, abs=1e-10)


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("name", ["ball on an arm", "branches", "two_link"])
def test_arrays_of_all_are_the_whole_tensors(name: str) -> None:
    """Those of forward dynamics go by products of matrices there, not by lines."""
    n, arrays = numbers(name), second_derivatives(numbers(name).workspace.scene, "numpy")
    nv, state = n.workspace.state.n, state_of(n, INVERSE, "random")
    whole = arrays.inverse(*(np.array(one, dtype=float) for one in state.values()))
    assert whole.shape == (nv, 3 * nv, 3 * nv)
    assert [whole[place] for place in pairs_of(n.workspace, INVERSE)] == near(n.at(INVERSE, state))
    state = state_of(n, FORWARD, "random")
    found = arrays.forward(*(np.array(one, dtype=float) for one in state.values()))
    assert (found.q.shape, found.qd.shape) == ((nv, nv, 3 * nv), (nv, nv, nv))
    at = pairs_of(n.workspace, FORWARD)
    here = [found.q[i, k, j] if k < nv else found.qd[i, k - nv, j - nv] for i, k, j in at]
    assert here == near(n.at(FORWARD, state))


def test_arrays_of_forces_in_time_are_refused() -> None:
    with pytest.raises(
        DerivationError, match="functions that take internal are called by themselves: inverse_dynamics"
    ):
        second_derivatives(read(EXAMPLES / "gallery" / "rocket.toml"), "numpy")


def near(values: list[Any]) -> Any:
    """Return what numbers are compared with that should be these."""
    expected = np.array(values, dtype=float)
    return pytest.approx(expected, rel=1e-9, abs=1e-9 * float(np.abs(expected).max()))


def led() -> Scene:
    """Return a scene with a motion that is prescribed."""
    return read_text(
        RESISTED.replace('coordinate = "elbow"', 'coordinate = "elbow"\nmotion = "sin(3*t)/2"'), "led.toml"
    )


def tied() -> Scene:
    """Return a scene with a spring between two branches."""
    ends = 'from = { body = "block" }\nto = { body = "other", at = [0, 0.3, 0] }'
    return read_text(f"{RESISTED}[springs.tie]\n{ends}\nstiffness = 30\nfree = 0.2\n", "tied.toml")


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (lambda: COUPLED[0], "helical or coupled joints share velocities; ask for inverse_dynamics_hessian or"),
        (led, "motions are prescribed; ask for inverse_dynamics_hessian"),
        (lambda: read(EXAMPLES / "four_bar.toml"), "is about trees; loops or rows close four_bar"),
        (tied, "a spring, load or formula ties others; ask for"),
        (lambda: turning_chain(60), r"would take some 5,700,000 .*inverse_dynamics_hessian_vector"),
    ],
    ids=["coupled", "led", "closed", "tied", "long"],
)
def test_what_has_no_such_order_is_told_what_works(scene: Any, message: str) -> None:
    with pytest.raises(DerivationError, match=message):
        derive(scene(), [INVERSE])


def test_those_of_forward_dynamics_that_are_too_many_are_arrays() -> None:
    with pytest.raises(DerivationError, match=r"_hessian, or take arrays of symdyn.runtime.second_derivatives"):
        derive(turning_chain(24), [FORWARD])


def test_other_outputs_have_none() -> None:
    with pytest.raises(DerivationError, match="there is no output 'pose_second_derivatives_packed'"):
        derive(read(EXAMPLES / "two_link.toml"), ["pose_second_derivatives_packed"])
