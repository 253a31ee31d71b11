"""What is shown beside numbers: the unit of a formula, and nothing in a scene without dimensions."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import symdyn
from symdyn.cli import main
from symdyn.scene import read_text
from symdyn.scene.declaration.dimensions import SceneUnits

CRANE = """
name = "crane"
units = "none"
gravity = [0, "-g0", 0]
parameters = { m0 = { value = 1.5, text = "weight" }, l0 = 0.7, k0 = 3, g0 = 9.81 }
inputs = { v = 0 }

[outputs]
ener = "m0*phi_dot**2/2"
place = "x"

[bodies]
wagon = { mass = 2 }
bob = { mass = "m0", com = ["l0", 0, 0] }

[joints.rail]
type = "prismatic"
parent = "ground"
child = "wagon"
axis = [1, 0, 0]
coordinate = "x"
drive = "pull"
force = "v"
limits = { upper = 0.02 }

[joints.hinge]
type = "revolute"
parent = "wagon"
child = "bob"
axis = [0, 0, 1]
coordinate = "phi"
drive = "tau1"
start = 0.3
limits = { effort = 1 }

[springs.s]
joint = "rail"
stiffness = "k0"

[points.tip]
body = "bob"
at = ["l0", 0, 0]
"""
UNIT = re.compile(r"\b(rad|kg|N m|m/s)\b|\b[0-9.]+(e-?\d+)? (m|N|J)\b|\[(m|N|J|s)\]|, (m|N|s|J)<|mathrm\{(m|s|N|rad)\}")
"""How a unit stands on a page: behind a number, in brackets, behind the words of an axis, in a formula's letters."""

DOORS = {
    "info": ("info",),
    "info --units": ("info", "--units"),
    "run": ("simulate", "--until", "0.2", "--every", "0.1", "--forces", "pull=50", "--plot", "FILE.svg"),
    "inverse": ("inverse", "--motion", "phi=0.3*sin(2*t)", "--until", "0.2", "--every", "0.1"),
    "no equilibrium": ("linearize",),
    "linear": ("linearize", "--start", "x=0,phi=-pi/2"),
    "linear, of a point": ("linearize", "--start", "x=0,phi=-pi/2", "--outputs", "x, phi"),
    "latex": ("equations", "--document"),
    "dalembert": ("equations", "--formulation", "dalembert", "--format", "text"),
    "dalembert, latex": ("equations", "--formulation", "dalembert", "--document"),
}  # fmt: skip


@pytest.mark.heavy("run")
@pytest.mark.runs("cc")
@pytest.mark.parametrize("door", DOORS)
def test_a_scene_without_dimensions_shows_no_unit(
    door: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same scene with dimensions shows that each of these pages has units, so that they could stand there."""
    found = {}
    for name, text in (("none", CRANE), ("si", CRANE.replace('units = "none"\n', ""))):
        (tmp_path / "crane.toml").write_text(text)
        verb, *options = (word.replace("FILE", str(tmp_path / name)) for word in DOORS[door])
        main([verb, str(tmp_path / "crane.toml"), *options])
        said = capsys.readouterr()
        files = [path.read_text() for path in tmp_path.iterdir() if path.stem == name]
        found[name] = [one.group() for text in (said.out, said.err, *files) for one in UNIT.finditer(text)]

    assert found["si"], said
    assert found["none"] == []


@pytest.mark.slow
@pytest.mark.runs("cc")
def test_the_columns_of_a_run_without_dimensions_have_no_unit() -> None:
    said = CRANE.replace("v = 0", 'v = { value = 0, unit = "V" }').replace('place = "x"', 'place = "x"\nshown = "v"')
    run = symdyn.simulate(read_text(said), until=0.1, every=0.1)

    assert {one.name: one.unit for one in run.columns if one.unit} == {"v": "V", "shown": "V"}
    runs = symdyn.sweep(read_text(said), {"phi": [0.1]}, ["e = max(x)", "f = max(pull)"], until=0.1)
    assert not any(runs.units.values())


def test_a_model_without_dimensions_has_no_units() -> None:
    from fmus import sources_of, unpacked

    for text, units in ((CRANE, False), (CRANE.replace('units = "none"\n', ""), True)):
        assert (b"unit=" in unpacked(sources_of(read_text(text)), "fmi2")["modelDescription.xml"]) is units


@pytest.mark.parametrize(
    ("name", "formula", "unit"),
    [
        ("y", "m*(l*phi_dot)**2/2", "N m"),
        ("y", "m*g*l*sin(phi)", "N m"),
        ("kinetic_energy_of_bob", "m*(l*phi_dot)**2/2", "J"),
        ("energy", "-m*g*l*cos(phi)", "J"),
        ("work2", "m*g*l*phi", "J"),
        ("network", "m*g*l", "N m"),
        ("energy_rate", "m*g*l*phi_dot", "W"),
        ("energy", "12*u", ""),
    ],
)
def test_what_is_called_an_energy_is_in_joules(name: str, formula: str, unit: str) -> None:
    """Dimensions tell no energy from a torque: where neither a name nor a term says it, the unit is N m."""
    from dimensional import output, pendulum

    scene = pendulum(more=output(formula).replace("y =", f"{name} ="))
    assert SceneUnits(scene).outputs[name] == unit


def test_what_has_a_term_in_joules_is_in_joules() -> None:
    from dimensional import pendulum

    from symdyn.scene import parse
    from symdyn.simulation.columns import unit_of

    scene = pendulum()
    said = {
        "m*g*l - kinetic_energy": "J",
        "kinetic_energy + potential_energy": "J",
        "-work": "J",
        "m*g*l*sin(phi)": "N m",
    }
    assert {text: unit_of(parse(text), scene) for text in said} == said


@pytest.mark.runs("cc")
def test_a_measure_that_is_called_an_energy_is_in_joules() -> None:
    from dimensional import pendulum

    found = symdyn.sweep(pendulum(), {"phi": [0.1]}, ["energy = max(m*g*l)", "y = max(m*g*l)"], until=0.1)
    assert (found.units["energy"], found.units["y"]) == ("J", "N m")
