"""A mechanism as an FMU: what its files say, that its code compiles, and that an instance lives as the standard says.

How it moves is compared in `test_fmu_moves.py`.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import pytest
from fmus import VERSIONS, model_of, sources_of, unpack, unpacked
from test_state_events import OSCILLATOR

import symdyn
from symdyn.cli import main
from symdyn.cli.scene_options import read_bindings
from symdyn.emit import TARGETS, emit
from symdyn.errors import DerivationError, EmitError
from symdyn.program import lower, prepare, tunable
from symdyn.runtime.compiler import binary_place, complete
from symdyn.scene import Scene, bind, read_text
from symdyn.simulation.initial import read_start

EXAMPLES = Path(__file__).parent.parent / "examples"
DRIVER = Path(__file__).parent / "fmu_driver.c"
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"]

SIGNALS = """
name = "signals"
[parameters]
k = { value = 3, unit = "N/V" }
reach = { value = 3, unit = "m" }
b = { value = 0.4, unit = "N s/m" }
[inputs.u]
unit = "V"
value = 0.5
[bodies.cart]
mass = 2
[bodies.pole]
mass = 0.3
com = [0, 0, -0.5]
[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
drive = false
force = "k*u - b*x_dot + 0.1*sin(3*t)"
limits = { lower = -2, upper = "2*reach" }
[joints.hinge]
type = "revolute"
parent = "cart"
child = "pole"
axis = [0, 1, 0]
coordinate = "theta"
drive = "M"
[points.tip]
body = "pole"
at = [0, 0, -0.5]
[outputs]
grip = { formula = "point_tip_x", unit = "m" }
push = { formula = "2*x_ddot + 3*u", unit = "mN s/g" }
"""


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", ["pendulum", "heavy_top", "four_bar"])
def test_a_model_description_names_states_inputs_and_parameters(name: str, version: str) -> None:
    scene = symdyn.example(name)
    states = [*scene.coordinates, *scene.velocities]
    variables = {one.get("name"): one for one in model_of(sources_of(scene), version).find("ModelVariables") or ()}

    by: dict[str | None, list[str | None]] = {}
    for word, one in variables.items():
        by.setdefault(one.get("causality"), []).append(word)
    assert [*variables][: 1 + 2 * len(states)] == ["t", *states, *(f"der({one})" for one in states)]
    assert by["output"] == states
    assert by.get("input", []) == [drive for drive in scene.drives if drive]
    assert by.get("parameter", []) == [one.name for one in scene.parameters]
    assert [one.get("valueReference") for one in variables.values()] == [*map(str, range(len(variables)))]


@pytest.mark.parametrize("version", VERSIONS)
def test_inputs_and_outputs_of_a_scene_are_those_of_its_model(version: str) -> None:
    model = model_of(sources_of(read_text(SIGNALS)), version)
    variables = {str(one.get("name")): one for one in model.find("ModelVariables") or ()}
    real = {name: one.attrib | (one[0].attrib if len(one) else {}) for name, one in variables.items()}

    assert [name for name, one in real.items() if one["causality"] == "input"] == ["M", "u"]
    assert [name for name, one in real.items() if one["causality"] == "output"] == ["grip", "push"]
    assert real["u"]["start"] == "0.5"
    assert (real["k"]["start"], real["k"]["variability"], real["k"]["unit"]) == ("3.0", "tunable", "N/V")
    assert (real["x"]["causality"], real["x"]["min"], real["x"]["max"]) == ("local", "-2.0", "6.0")


@pytest.mark.parametrize("version", VERSIONS)
def test_an_output_depends_on_what_its_formula_names(version: str) -> None:
    model = model_of(sources_of(read_text(SIGNALS)), version)
    names = [str(one.get("name")) for one in model.find("ModelVariables") or ()]
    structure = model.find("ModelStructure")
    assert structure is not None
    first = 1 if version == "fmi2" else 0
    unknowns = {
        names[int(one.get("index") or one.get("valueReference") or 0) - first]: [
            names[int(k) - first] for k in str(one.get("dependencies")).split()
        ]
        for one in structure.iter()
        if one.get("dependencies") is not None
    }

    assert unknowns["grip"] == ["x", "theta"]
    assert unknowns["der(x)"] == ["x_dot"]
    assert {"M", "u"} <= {*unknowns["push"]}
    assert "x" not in unknowns["push"]


@pytest.mark.parametrize("version", VERSIONS)
def test_units_have_their_exponents_where_they_can_be_read(version: str) -> None:
    model = model_of(sources_of(read_text(SIGNALS)), version)
    units = {one.get("name"): one for one in model.iter("Unit")}

    assert units["N/V"][0].attrib == {"m": "-1", "s": "1", "A": "1"}
    assert units["N m"][0].attrib == {"kg": "1", "m": "2", "s": "-2"}
    assert units["mN s/g"][0].attrib == {"m": "1", "s": "-1"}


def test_resets_are_events_that_a_model_description_counts() -> None:
    second, third = (model_of(sources_of(read_text(OSCILLATOR)), version) for version in VERSIONS)
    assert second.get("numberOfEventIndicators") == "3"
    told = {one.get("valueReference"): one.get("description") for one in third.find("ModelVariables") or ()}
    found = [told[one.get("valueReference")] for one in third.iter("EventIndicator")]
    assert found == ["reset of s: s - p", "reset of both: x", "reset of down: x"]


@pytest.mark.long(0)
def test_a_model_starts_where_simulate_does() -> None:
    for name in ("four_bar", "free_body", "rolling_disc", "slider_crank"):
        scene = symdyn.example(name)
        start = read_start(scene)
        found = model_of(sources_of(scene), "fmi3").find("ModelVariables")
        assert found is not None
        starts = [float(str(one.get("start"))) for one in found if one.get("start")]
        assert starts[: start.q.size + start.u.size] == pytest.approx([*start.q, *start.u], abs=1e-12)


def test_the_same_scene_gives_the_same_bytes_and_no_date() -> None:
    first, second = (sources_of(symdyn.example("four_bar")) for _ in range(2))

    assert first.files == second.files
    with zipfile.ZipFile(BytesIO(bytes(first["four_bar_fmi2.fmu"]))) as archive:
        assert {one.date_time for one in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


GOLDEN = ("modelDescription.xml", "sources/fmu-mechanism.h", "sources/buildDescription.xml")


@pytest.mark.parametrize("version", VERSIONS)
def test_what_generated_holds_is_in_the_file(version: str, tmp_path: Path, update_golden: bool) -> None:
    folder = EXAMPLES.parent / "generated" / "pendulum_fmu"
    words = ["generate", str(EXAMPLES / "pendulum.toml"), "--target", "fmu"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("symdyn.cli.generate.complete", lambda sources: (sources, ""))
        assert main([*words, "-o", str(tmp_path)]) == 0
    with zipfile.ZipFile(tmp_path / f"pendulum_{version}.fmu") as archive:
        found = {Path(name).name: archive.read(name) for name in archive.namelist() if name in GOLDEN}
    for name, text in found.items():
        path = folder / f"{version}_{name}"
        if update_golden:
            folder.mkdir(exist_ok=True)
            path.write_bytes(text)
        assert path.read_bytes() == text


@pytest.mark.parametrize("name", ["fmi2", "fmu_steps", "fmu-steps", "modelDescription", "types", "a b é"])
def test_a_scene_may_be_called_as_files_of_ours_are(name: str) -> None:
    scene = replace(symdyn.example("pendulum"), name=name)
    for version in VERSIONS:
        names, usual = ({*unpacked(sources_of(one), version)} for one in (scene, symdyn.example("pendulum")))
        assert len(names) == len(usual)


def test_another_model_has_another_token() -> None:
    one, other = (
        re.findall(r'TOKEN "(\w+)"', text.decode())[0]
        for text in (
            unpacked(sources_of(scene), "fmi2")["sources/fmu-mechanism.h"]
            for scene in (symdyn.example("pendulum"), bind(symdyn.example("pendulum"), read_bindings("l=2")))
        )
    )
    assert one != other


def test_what_it_is_made_of_is_asked_for_and_nothing_else(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pendulum = str(EXAMPLES / "pendulum.toml")
    words = ["generate", pendulum, "--target", "fmu", "-o", str(tmp_path)]

    assert main([*words, "--functions", "mass_matrix"]) == 1
    assert "is made of forward_dynamics, forward_dynamics_derivatives, here are mass_matrix" in capsys.readouterr().err
    assert main([*words, "--static"]) == 1
    assert "leave --static out" in capsys.readouterr().err
    with pytest.raises(EmitError, match=r"is made of forward_dynamics, .*; leave functions out"):
        emit(lower(symdyn.dynamics.derive(symdyn.example("pendulum"), ["mass_matrix"])), "fmu")
    assert not [*tmp_path.iterdir()]


def test_what_has_no_functions_to_call_is_not_measured(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(EXAMPLES / "pendulum.toml"), "--targets", "fmu"]) == 1
    assert "has no functions to call; measure numpy or c" in capsys.readouterr().err


def test_a_parameter_without_a_value_is_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["generate", str(EXAMPLES / "two_link.toml"), "--target", "fmu"]) == 1
    assert "m1, m2, h1, h2, g have no value, and a variable of an FMU starts with one" in capsys.readouterr().err


def test_what_sticks_is_refused() -> None:
    text = SIGNALS.replace("b*x_dot", "2*b*sign(x_dot)")
    with pytest.raises(EmitError, match=r"lacks sign, which forward_dynamics.* needs: its events are resets"):
        sources_of(read_text(text))


def test_ideal_friction_is_refused() -> None:
    text = SIGNALS.replace('drive = "M"', 'drive = "M"\nfriction = { coulomb = 0.4, smoothing = 0 }')
    with pytest.raises(DerivationError, match="smoothing"):
        sources_of(read_text(text))


def test_the_command_in_its_files_makes_them_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symdyn.cli.generate.complete", lambda sources: (sources, ""))
    words = ["generate", str(EXAMPLES / "pendulum.toml"), "--target", "fmu", "--bind", "l=2"]
    assert main([*words, "-o", str(tmp_path / "a")]) == 0
    with zipfile.ZipFile(tmp_path / "a" / "pendulum_fmi3.fmu") as archive:
        told = ElementTree.fromstring(archive.read("modelDescription.xml")).get("description") or ""
    monkeypatch.chdir(EXAMPLES)
    assert main([*told.split()[1:], "-o", str(tmp_path / "b")]) == 0
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


def test_without_a_compiler_it_holds_sources_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "nothing-of-that-name")
    sources = sources_of(symdyn.example("pendulum"))
    same, told = complete(sources)

    assert same is sources
    assert told.startswith("pendulum_fmi2.fmu, pendulum_fmi3.fmu: sources alone; ")


@pytest.mark.runs("cc")
def test_a_binary_is_added_where_the_standard_looks_for_it() -> None:
    sources, told = complete(sources_of(symdyn.example("pendulum")))

    assert told == "pendulum_fmi2.fmu, pendulum_fmi3.fmu: sources, and a binary for this platform"
    for version in VERSIONS:
        assert binary_place(version, "pendulum") in unpacked(sources, version)


CASES = ["pendulum", "heavy_top", "four_bar", "rolling_disc", "counted"]
TEXTS = {"signals": SIGNALS, "counted": OSCILLATOR}


def made(name: str) -> Scene:
    return read_text(TEXTS[name]) if name in TEXTS else symdyn.example(name)


@pytest.mark.wide("pendulum-fmi2-gcc", "four_bar-fmi3-clang", "signals-fmi2-clang")
@pytest.mark.long
@pytest.mark.runs("gcc")
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", [*CASES, "signals"])
def test_its_code_compiles_without_a_word(name: str, version: str, compiler: str, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    scene = made(name)
    unpack(sources_of(scene), version, tmp_path)
    for more in ([], [f"-D{version.upper()}_FUNCTION_PREFIX=model_"]):
        words = [compiler, *STRICT, *more, "-c", f"{version}-functions.c", "-o", "model.o"]
        done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.long
@pytest.mark.runs("gcc")
def test_an_instance_has_no_state_outside_itself(tmp_path: Path) -> None:
    unpack(sources_of(symdyn.example("pendulum")), "fmi2", tmp_path)
    for file in ("fmi2-functions.c", "pendulum.c"):
        subprocess.run(["gcc", *STRICT, "-c", file, "-o", "model.o"], cwd=tmp_path, check=True)
        symbols = subprocess.check_output(["nm", "model.o"], cwd=tmp_path, text=True)
        assert [line for line in symbols.splitlines() if re.search(r" [bBdDcC] ", line) and "NAMES" not in line] == []


@pytest.mark.wide("pendulum-plain")
@pytest.mark.long
@pytest.mark.runs("gcc")
@pytest.mark.parametrize(
    ("name", "way"),
    [(name, way) for name in CASES for way in ("plain", "prepared") if way == "plain" or made(name).parameters],
)
def test_instances_live_beside_each_other_and_leave_nothing(name: str, way: str, tmp_path: Path) -> None:
    scene = made(name)
    program = tunable(scene, TARGETS["fmu"].functions(scene))  # type: ignore[misc]
    unpack(emit(prepare(program) if way == "prepared" else program, "fmu"), "fmi2", tmp_path)
    shutil.copy(DRIVER, tmp_path)
    sanitizers = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    code = [DRIVER.name, f"{name}.c"]
    subprocess.run(["gcc", *STRICT, *sanitizers, *code, "-o", "driver", "-lm"], cwd=tmp_path, check=True)
    done = subprocess.run(["./driver"], cwd=tmp_path, capture_output=True, text=True, check=False)

    assert (done.returncode, done.stderr) == (0, "")
    told = [line.split() for line in done.stdout.splitlines()]
    expected = ["apart", "restored", "read", "freed", *["refused"] * 5, "fresh"]
    if name in ("heavy_top", "rolling_disc", "counted"):  # no parameters, or it moves alike whatever they are
        told, expected = [line for line in told if line[0] != "apart"], expected[1:]
    assert [line[0] for line in told if len(line) == 2] == expected
    assert all(line[1] == "1" for line in told if len(line) == 2), done.stdout
    assert all(line[2] == "logStatusError" for line in told if len(line) > 2)
