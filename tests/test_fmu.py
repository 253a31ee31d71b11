"""A mechanism as an FMU: what its files say, that its code compiles, and that it moves as `simulate` says."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

import symdyn
from symdyn.emit import TARGETS, Sources, emit
from symdyn.program import tunable
from symdyn.scene import Scene

EXAMPLES = Path(__file__).parent.parent / "examples"
VERSIONS = ("fmi2", "fmi3")


def sources_of(scene: Scene) -> Sources:
    return emit(tunable(scene, TARGETS["fmu"].functions(scene)), "fmu")


def members(archive: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(archive)) as opened:
        return {name: opened.read(name) for name in opened.namelist()}


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", ["pendulum", "heavy_top", "four_bar", "puma560"])
def test_a_model_description_names_states_inputs_and_parameters(name: str, version: str) -> None:
    scene = symdyn.example(name)
    found = members(sources_of(scene)[f"{name}_{version}.fmu"])
    model = ElementTree.fromstring(found["modelDescription.xml"])
    states = [*scene.coordinates, *scene.velocities]
    variables = {one.get("name"): one for one in model.find("ModelVariables")}

    assert [*variables][: 1 + 2 * len(states)] == ["t", *states, *(f"der({one})" for one in states)]
    by: dict[str | None, list[str | None]] = {}
    for word, one in variables.items():
        by.setdefault(one.get("causality"), []).append(word)
    assert by["output"] == states
    assert by.get("input", []) == [drive for drive in scene.drives if drive]
    assert by.get("parameter", []) == [one.name for one in scene.parameters]
    assert [one.get("valueReference") for one in variables.values()] == [*map(str, range(len(variables)))]
