"""One function, one name by every door: it can be asked for by what it is called in code, and by its request."""

from __future__ import annotations

from pathlib import Path

import pytest

import symdyn
from symdyn.cli import main
from symdyn.dynamics import OUTPUTS, row_of
from symdyn.dynamics.outputs.constrained_derivatives import CLOSED
from symdyn.dynamics.outputs.requests import MANY, words
from symdyn.errors import DerivationError
from symdyn.scene import Scene

CLOSED_SCENES = ("four_bar", "governor", "rolling_disc", "slider_crank")


def requests(scene: Scene) -> list[str]:
    """Return everything that can be asked of a scene, derivatives too."""
    of = [*OUTPUTS, *(CLOSED if scene.is_constrained else ())]
    of += [word for one in MANY for word in words(one, scene.is_constrained) if word.isidentifier() and word.islower()]
    found = []
    for one in dict.fromkeys(of):
        places = {"body": scene.bodies, "point": scene.points, "output": scene.outputs}
        for name in (one, *(f"{one}:{at.name}" for kind in places.values() for at in kind)):
            try:
                row_of(name, scene)
            except DerivationError:
                continue
            found.append(name)
    return found


@pytest.mark.long
@pytest.mark.wide("four_bar")
@pytest.mark.parametrize("name", [*CLOSED_SCENES, "cart_pole", "puma560"])
def test_every_function_can_be_asked_for_by_its_name_in_code(name: str) -> None:
    from symdyn.dynamics.outputs.requests import name_in_code, request_of

    scene = symdyn.example(name)
    every = requests(scene)
    assert len(every) > 100
    for request in every:
        row, place = row_of(request, scene)
        called = name_in_code(row, request, scene)
        assert called.isidentifier()
        same, there = row_of(called, scene)
        assert (same.text, same.arguments, there) == (row.text, row.arguments, place), called
        again = request_of(called, scene)
        assert name_in_code(row_of(again, scene)[0], again, scene) == called
        assert request_of(request, scene) == request


@pytest.mark.mends("30.numbers.4")
@pytest.mark.parametrize("name", ["four_bar", "rolling_disc"])
@pytest.mark.runs
def test_names_that_one_door_takes_the_others_take(name: str) -> None:
    """All functions of a closed scene: those of `load` are asked of `derive` and `load`; and the other way round."""
    scene = symdyn.example(name)
    loaded = symdyn.load(scene)
    names = list(loaded.signatures)
    refused = []
    for called in names:
        try:
            row_of(called, scene)
        except DerivationError as fault:
            refused.append(str(fault))
    assert not refused
    assert [one.name for one in symdyn.dynamics.derive(scene, names).functions] == names
    assert list(symdyn.load(scene, names).signatures) == names
    for request in loaded.requests:
        assert getattr(loaded, request.replace(":", "_")) is loaded[request]


@pytest.mark.mends("30.numbers.4")
def test_the_mass_matrix_of_the_tree_is_called_the_same_by_both_doors() -> None:
    scene = symdyn.example("four_bar")
    told = []
    for name in ("mass_matrix", "tree_mass_matrix"):
        try:
            told.append(str(symdyn.lambdify(scene, name)))
        except DerivationError as fault:
            told.append(str(fault))
    assert told[0] == told[1]
    one, other = symdyn.lambdify(scene, ("tree_mass_matrix", "mass_matrix"))
    q = [0.3, 0.2, 0.1]
    assert (one(q) == other(q)).all()


def test_a_certificate_is_asked_for_by_either_name(numpy_alone: None) -> None:
    scene = symdyn.example("four_bar")
    told = symdyn.certify(scene, ("tree_mass_matrix", "mass_matrix"))
    assert told.passed
    assert told.as_dict() == symdyn.certify(scene, ("mass_matrix",)).as_dict()


def test_what_is_asked_for_twice_by_two_names_is_written_once(tmp_path: Path) -> None:
    scene = str(Path(__file__).parent.parent / "examples" / "four_bar.toml")
    assert main(["generate", scene, "--functions", "mass_matrix,tree_mass_matrix", "-o", str(tmp_path)]) == 0
    assert (tmp_path / "four_bar.py").read_text().count("\ndef tree_mass_matrix(") == 1


def test_a_name_of_closed_scenes_is_none_of_open_ones() -> None:
    with pytest.raises(DerivationError, match="is what mass_matrix is called where loops close a scene"):
        symdyn.dynamics.derive(symdyn.example("cart_pole"), ["tree_mass_matrix"])
    with pytest.raises(DerivationError, match="there is no output 'tree_tree_forces'"):
        symdyn.dynamics.derive(symdyn.example("four_bar"), ["tree_tree_forces"])
