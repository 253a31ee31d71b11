"""FMUs in FMPy: they are valid, move as `simulate` says in all four ways, and their derivatives are differences."""

from __future__ import annotations

import ctypes
import subprocess
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmus import VERSIONS, sources_of, unpack
from scipy.integrate import solve_ivp
from test_fmu import SIGNALS
from test_state_events import OSCILLATOR

import symdyn
from symdyn.cli.scene_options import read_bindings
from symdyn.emit import write
from symdyn.runtime.compiler import with_binaries
from symdyn.scene import Scene, bind, read_text
from symdyn.simulation import simulate

pytestmark = [pytest.mark.targets, pytest.mark.runs("cc")]

PRESCRIBED = """
name = "carried"
gravity = [0, -9.81, 0]
[bodies.cart]
mass = 1
[bodies.bob]
particles = [{ mass = 0.5, at = [0, -0.7, 0] }]
[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
motion = "0.3*sin(2*t)"
[joints.hinge]
type = "revolute"
parent = "cart"
child = "bob"
axis = [0, 0, 1]
coordinate = "q1"
drive = false
"""

FRICTION = """
name = "rubbing"
gravity = [0, -9.81, 0]
[parameters]
c = { value = 0.2, unit = "N m" }
[bodies.bob]
particles = [{ mass = 1, at = [0, -0.5, 0] }]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
coordinate = "q1"
start = 1
friction = { coulomb = "c", smoothing = 0.1 }
damping = 0.01
"""

SCENES: dict[str, Callable[[], Scene]] = {
    "rubbing": lambda: read_text(FRICTION),
    "two_link": lambda: bind(symdyn.example("two_link"), read_bindings("m1=1,m2=0.5,h1=0.4,h2=0.3,g=9.81")),
    "puma560": lambda: symdyn.example("puma560"),
    "four_bar": lambda: symdyn.example("four_bar"),
    "heavy_top": lambda: symdyn.example("heavy_top"),
    "rolling_disc": lambda: symdyn.example("rolling_disc"),
    "signals": lambda: read_text(SIGNALS),
    "carried": lambda: read_text(PRESCRIBED),
    "dc_motor": lambda: symdyn.example("dc_motor"),
}
UNTIL = 0.5

PATHS: dict[str, tuple[Path, ...]] = {}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """Return where the FMU of a scene stands, built once."""

    def path(name: str, version: str) -> Path:
        if name not in PATHS:
            PATHS[name] = write(with_binaries(sources_of(SCENES[name]())), tmp_path_factory.mktemp(name))
        return next(one for one in PATHS[name] if version in one.name)

    return path


Made = Callable[[str, str], Path]


def fmpy() -> Any:
    return pytest.importorskip("fmpy")


def states_of(scene: Scene) -> list[str]:
    return [*scene.coordinates, *scene.velocities, *(one.name for one in scene.states)]


def directional(scene: Scene) -> bool:
    """Tell whether FMUs of a scene have directional derivatives: neither of loops nor of states of one's own."""
    return not scene.is_constrained and not scene.states


def started(scene: Scene) -> dict[str, float]:
    """Return a start that is no rest, of scenes whose coordinates are free."""
    free = not scene.is_constrained and len(scene.coordinates) == len(scene.velocities)
    moved = {joint.coordinate for joint in scene.moving if joint.motion is not None}
    return {q: 0.3 + 0.1 * k for k, q in enumerate(scene.coordinates) if free and q not in moved}


def trajectory(scene: Scene) -> np.ndarray[Any, Any]:
    start = {name: repr(value) for name, value in started(scene).items()}
    run = simulate(scene, until=UNTIL, every=UNTIL / 10, start=start, ignore_limits=True)
    return np.hstack([run.q, run.qd, *(run[one.name][:, None] for one in scene.states)])


@contextmanager
def instance(path: Path, folder: Path, start: dict[str, float], moves: bool = True) -> Iterator[Any]:
    """Return an instance in continuous-time mode or in step mode, with what calls it by names."""
    fmpy()
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Model, FMU2Slave
    from fmpy.fmi3 import FMU3Model, FMU3Slave

    model = read_model_description(str(path))
    second = model.fmiVersion == "2.0"
    kind = (FMU2Model if moves else FMU2Slave) if second else (FMU3Model if moves else FMU3Slave)
    fmu = kind(
        guid=model.guid,
        unzipDirectory=extract(str(path), str(folder / path.stem)),
        modelIdentifier=model.modelExchange.modelIdentifier,
        instanceName="one",
    )
    fmu.instantiate()
    fmu.places = {one.name: one.valueReference for one in model.modelVariables}
    fmu.get = lambda names: (fmu.getReal if second else fmu.getFloat64)([fmu.places[one] for one in names])
    fmu.put = lambda values: (fmu.setReal if second else fmu.setFloat64)(
        [fmu.places[one] for one in values], [*values.values()]
    )
    fmu.put(start)
    if second:
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
    else:
        fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()
    if moves:
        fmu.enterContinuousTimeMode()
    try:
        yield fmu
    finally:
        fmu.terminate()
        fmu.freeInstance()


def rates(fmu: Any, t: float, x: Sequence[float]) -> np.ndarray[Any, Any]:
    """Return the rates that an instance of model exchange gives."""
    values = np.array(x, dtype=float)
    found = np.empty_like(values)
    real = ctypes.POINTER(ctypes.c_double)
    fmu.setTime(t)
    fmu.setContinuousStates(values.ctypes.data_as(real), len(values))
    ask = fmu.getDerivatives if hasattr(fmu, "getDerivatives") else fmu.getContinuousStateDerivatives
    ask(found.ctypes.data_as(real), len(found))
    return found


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", SCENES)
def test_fmpy_finds_nothing_wrong(name: str, version: str, made: Made) -> None:
    fmpy()
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(made(name, version))) == []


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", SCENES)
def test_a_co_simulation_moves_as_simulate_says(name: str, version: str, made: Made) -> None:
    scene = SCENES[name]()
    names = states_of(scene)
    found = fmpy().simulate_fmu(
        str(made(name, version)), fmi_type="CoSimulation", stop_time=UNTIL, output_interval=UNTIL / 10,
        relative_tolerance=1e-11, start_values=started(scene), output=names,
    )  # fmt: skip
    wanted = trajectory(scene)

    assert len(found) == len(wanted)
    np.testing.assert_allclose(np.array([found[one] for one in names]).T, wanted, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", SCENES)
def test_the_rates_of_a_model_lead_where_simulate_does(name: str, version: str, made: Made, tmp_path: Path) -> None:
    """A good integrator, DOP853, finds the digits that FMPy's own, BDF of low accuracy, does not."""
    scene = SCENES[name]()
    with instance(made(name, version), tmp_path, started(scene)) as fmu:
        x = fmu.get(states_of(scene))
        run = solve_ivp(lambda t, x: rates(fmu, t, x), (0.0, UNTIL), x, method="DOP853", rtol=1e-11, atol=1e-12)

    np.testing.assert_allclose(run.y[:, -1], trajectory(scene)[-1], rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", SCENES)
def test_fmpys_own_integrator_comes_as_close_as_its_error_grows(name: str, version: str, made: Made) -> None:
    scene = SCENES[name]()
    names = states_of(scene)
    ends = []
    for tolerance in (1e-6, 1e-9):
        found = fmpy().simulate_fmu(
            str(made(name, version)), fmi_type="ModelExchange", stop_time=UNTIL, output_interval=UNTIL / 100,
            relative_tolerance=tolerance, start_values=started(scene), output=names,
        )  # fmt: skip
        ends.append(np.abs(np.array([found[one][-1] for one in names]) - trajectory(scene)[-1]).max())

    assert ends[1] < 1e-4
    assert ends[1] <= max(0.1 * ends[0], 1e-9)


JUMPING = f"""
{OSCILLATOR.replace("p = 0.3", "p = 0.2963")}
[states.again]
rate = 0
reset = {{ when = "both - 1.5", to = "again + x_dot", way = "up" }}
[states.bound]
rate = "1 + x*x"
reset = {{ when = "bound - 0.7", to = "0.2 + bound/10", way = "up" }}
"""
"""Clocks of several lengths; one guard that a jump passes; one jump that depends on the motion."""


@pytest.mark.parametrize("way", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("version", VERSIONS)
def test_resets_are_events_of_a_model(version: str, way: str, tmp_path: Path) -> None:
    """What the tool's integrator leaves off is in the motion; each jump is there, and none is twice."""
    fmpy()
    from fmpy.validation import validate_fmu

    scene = read_text(JUMPING, "jumping.toml")
    path = next(one for one in write(with_binaries(sources_of(scene)), tmp_path) if version in one.name)
    names = states_of(scene)
    assert validate_fmu(str(path)) == []
    found = fmpy().simulate_fmu(
        str(path), fmi_type=way, stop_time=8.0, output_interval=0.05, relative_tolerance=1e-11, output=names,
        record_events=False,
    )  # fmt: skip
    run = simulate(scene, until=8, every=0.05, rtol=1e-11)
    told = Counter(one.formula for one in run.events)
    assert [told[one] for one in ("reset of s: s - p", "reset of both: x", "reset of down: x")] == [26, 3, 2]
    wanted = run[names]
    assert len(found) == len(wanted)
    np.testing.assert_allclose(np.array([found[one] for one in names]).T, wanted, atol=1e-8 if way[0] == "C" else 2e-5)


@pytest.mark.parametrize("version", VERSIONS)
def test_jumps_that_come_closer_and_closer_end_a_step(version: str, tmp_path: Path) -> None:
    text = OSCILLATOR.replace('to = "s - p"', 'to = "p - d"')
    text += '[states.d]\nstart = 1\nrate = 0\nreset = { when = "s - p", to = "d/2", way = "up" }\n'
    path = next(one for one in write(with_binaries(sources_of(read_text(text))), tmp_path) if version in one.name)
    with (
        instance(path, tmp_path, {}, moves=False) as fmu,
        pytest.raises(Exception, match=r"failed with status (2|fmi3Discard)"),
    ):
        fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=3.0)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", [name for name in SCENES if directional(SCENES[name]())])
def test_directional_derivatives_are_differences(name: str, version: str, made: Made, tmp_path: Path) -> None:
    scene = SCENES[name]()
    states, inputs = states_of(scene), [*filter(None, scene.drives), *(one.name for one in scene.inputs)]
    inputs = [one for one in inputs if one != next((j.drive for j in scene.joints if j.motion is not None), None)]
    unknowns = [*(f"der({one})" for one in states), *(one.name for one in scene.outputs)]
    rng = np.random.default_rng(1)
    with instance(made(name, version), tmp_path, started(scene)) as fmu:
        x = np.array(fmu.get(states)) + 0.1 * rng.normal(size=len(states))  # quaternions of any length
        given = dict(zip(inputs, rng.normal(size=len(inputs)), strict=True))

        def at(moved: np.ndarray[Any, Any], pushed: dict[str, float]) -> np.ndarray[Any, Any]:
            fmu.put(pushed)
            rates(fmu, 0.2, moved)
            return np.array(fmu.get(unknowns))

        h = 1e-5
        for k, known in enumerate([*states, *inputs]):
            step = h * (np.arange(len(states)) == k)
            more = {one: value + h * (one == known) for one, value in given.items()}
            less = {one: value - h * (one == known) for one, value in given.items()}
            wanted = (at(x + step, more) - at(x - step, less)) / (2 * h)
            at(x, given)
            found = fmu.getDirectionalDerivative([fmu.places[one] for one in unknowns], [fmu.places[known]], [1.0])
            np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=2e-6 * max(1.0, np.abs(wanted).max()))


@pytest.mark.parametrize("version", VERSIONS)
def test_a_parameter_may_change_between_runs_and_during_one(version: str, made: Made, tmp_path: Path) -> None:
    simulated = fmpy().simulate_fmu
    scene = SCENES["two_link"]()
    for text in ("m2=0.5", "m2=2"):
        changed = bind(symdyn.example("two_link"), read_bindings(f"m1=1,{text},h1=0.4,h2=0.3,g=9.81"))
        found = simulated(
            str(made("two_link", version)), fmi_type="CoSimulation", stop_time=UNTIL, relative_tolerance=1e-11,
            start_values={**started(scene), "m2": float(text[3:])}, output=["q1"],
        )  # fmt: skip
        assert found["q1"][-1] == pytest.approx(trajectory(changed)[-1, 0], abs=1e-8)

    with instance(made("two_link", version), tmp_path, started(scene), moves=False) as fmu:
        fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.1)
        before = fmu.get(["der(q1_dot)"])
        fmu.put({"g": 0.0})
        assert fmu.get(["der(q1_dot)"]) != before


@pytest.mark.parametrize("version", VERSIONS)
def test_inputs_act_and_steps_may_be_of_any_length(version: str, made: Made, tmp_path: Path) -> None:
    scene = read_text(SIGNALS)
    forces = {"u": "2", "M": "0.3"}
    run = simulate(scene, until=UNTIL, forces=forces, start={"x": "0", "theta": "0.3"}, every=UNTIL)
    with instance(made("signals", version), tmp_path, {"theta": 0.3, "u": 2.0, "M": 0.3}, moves=False) as fmu:
        t = 0.0
        for step in (0.1, 0.003, 0.297, 0.1):
            fmu.doStep(currentCommunicationPoint=t, communicationStepSize=step)
            t += step
        found = fmu.get([*states_of(scene), "grip", "push"])

    np.testing.assert_allclose(found[:4], [*run.q[-1], *run.qd[-1]], rtol=1e-7, atol=1e-8)
    np.testing.assert_allclose(found[4:], [run["grip"][-1], run["push"][-1]], rtol=1e-7, atol=1e-7)


def test_inputs_are_interpolated_where_their_rates_are_given(made: Made, tmp_path: Path) -> None:
    scene = read_text(SIGNALS)
    run = simulate(scene, until=UNTIL, forces={"u": "2*t"}, start={"theta": "0.3"}, every=UNTIL)
    with instance(made("signals", "fmi2"), tmp_path, {"theta": 0.3, "u": 0.0}, moves=False) as fmu:
        one, real = (ctypes.c_uint * 1)(fmu.places["u"]), (ctypes.c_double * 1)(2.0)
        fmu.fmi2SetRealInputDerivatives(fmu.component, one, 1, (ctypes.c_int * 1)(1), real)
        fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=UNTIL)
        found = fmu.get(states_of(scene))

    np.testing.assert_allclose(found, [*run.q[-1], *run.qd[-1]], rtol=1e-7, atol=1e-8)


def test_loops_stay_closed_while_they_are_integrated(made: Made, tmp_path: Path) -> None:
    scene = symdyn.example("four_bar")
    missed = symdyn.lambdify(scene, "constraint_residual")
    found = fmpy().simulate_fmu(
        str(made("four_bar", "fmi3")), fmi_type="CoSimulation", stop_time=5.0, output_interval=0.05,
        output=list(scene.coordinates),
    )  # fmt: skip
    q = np.array([found[one] for one in scene.coordinates]).T

    assert np.abs(missed(q)).max() < 1e-12


@pytest.mark.parametrize("version", VERSIONS)
def test_the_declarations_are_those_of_the_standard(version: str, tmp_path: Path) -> None:
    headers = Path(fmpy().__file__).parent / "c-code"
    for name in ("heavy_top", "four_bar"):
        unpack(sources_of(symdyn.example(name)), version, tmp_path)
        words = [
            "gcc",
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-DFMI_HEADERS",
            f"-I{headers}",
            "-c",
            f"{version}-functions.c",
        ]
        done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")


LAYOUTS = {
    "fmi2": """sizeof(fmi2EventInfo) offsetof(fmi2EventInfo,terminateSimulation) offsetof(fmi2EventInfo,nextEventTime)
        offsetof(fmi2EventInfo,nextEventTimeDefined) sizeof(fmi2CallbackFunctions) sizeof(fmi2ValueReference)
        offsetof(fmi2CallbackFunctions,stepFinished) offsetof(fmi2CallbackFunctions,componentEnvironment)
        fmi2OK fmi2Discard fmi2Error fmi2Pending fmi2CoSimulation fmi2LastSuccessfulTime fmi2Terminated
        sizeof(fmi2Boolean)""",
    "fmi3": """fmi3OK fmi3Discard fmi3Error fmi3Fatal fmi3Dependent fmi3IntervalChanged sizeof(fmi3Boolean)
        sizeof(fmi3ValueReference) sizeof(fmi3Binary) sizeof(fmi3Clock)""",
}


@pytest.mark.parametrize("version", VERSIONS)
def test_numbers_and_places_are_those_of_the_standard(version: str, tmp_path: Path) -> None:
    headers = Path(fmpy().__file__).parent / "c-code"
    unpack(sources_of(symdyn.example("pendulum")), version, tmp_path)
    lines = "".join(f'printf("%d\\n", (int){one});' for one in LAYOUTS[version].split())
    headed = "".join(f'#include "{name}"\n' for name in ("stddef.h", "stdio.h", f"{version}-types.h"))
    (tmp_path / "layout.c").write_text(f"{headed}int main(void) {{ {lines} }}\n")
    told = []
    for words in ([], ["-DFMI_HEADERS", f"-I{headers}"]):
        subprocess.run(["gcc", *words, "layout.c", "-o", "layout"], cwd=tmp_path, check=True)
        told.append(subprocess.check_output(["./layout"], cwd=tmp_path, text=True))

    assert told[0] == told[1]


@pytest.mark.parametrize("version", VERSIONS)
def test_fmpy_builds_the_sources_itself(version: str, tmp_path: Path) -> None:
    fmpy()
    from fmpy import extract, simulate_fmu
    from fmpy.build import build_platform_binary

    sources = write(sources_of(SCENES["rubbing"]()), tmp_path)
    folder = extract(str(next(one for one in sources if version in one.name)), str(tmp_path / "there"))
    build_platform_binary(folder)

    assert simulate_fmu(folder, stop_time=0.1, fmi_type="CoSimulation")["q1"][-1] < 1.0
