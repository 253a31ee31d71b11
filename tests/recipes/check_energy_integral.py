"""What an output from outside is worth: everything that symdyn does with its own, checked by differences and by a law.

`tests/test_recipes.py` runs this in a fresh process, where the output is one file that is imported here.
"""

from __future__ import annotations

from dataclasses import MISSING, fields, replace
from pathlib import Path

import energy_integral
import numpy as np
import pytest

import symdyn
from symdyn.bench.time_and_error import comparable
from symdyn.cli import main
from symdyn.dynamics import OUTPUTS, Formulation, Output, Workspace, available, derive_one
from symdyn.emit import emit
from symdyn.errors import DerivationError, MissingProgram
from symdyn.program import formulate, lower
from symdyn.runtime import RUNNERS
from symdyn.simulation import simulate
from symdyn.verdict import Verdict
from symdyn.verify import certify

NAME = energy_integral.__name__
pytestmark = pytest.mark.runs

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
SCENES = ("two_link", "cart_pole", "heavy_top", "four_bar", "governor", "rolling_disc")


def scene(name: str) -> symdyn.Scene:
    return symdyn.read(EXAMPLES / f"{name}.toml")


def states(one: symdyn.Scene) -> tuple[np.ndarray, np.ndarray]:
    drawn = np.random.default_rng(3)
    return drawn.uniform(-1, 1, len(one.coordinates)), drawn.uniform(-1, 1, len(one.velocities))


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("name", SCENES)
def test_a_scene_has_it_unasked_and_it_is_proved(name: str) -> None:
    assert NAME in available(scene(name))[0]
    certificate = certify(scene(name), (NAME,))
    verdicts = {finding.claim: finding.verdict for finding in certificate.findings}
    assert certificate.passed
    assert any(verdicts.get(f"{NAME}: {sides}") == Verdict.PROVED for sides in AGREE)


AGREE = ("recursive = definition", "definition = recursive")


@pytest.mark.parametrize("target", [name for name, runner in RUNNERS.items() if not runner.by_name_only])
def test_every_target_writes_it_and_its_slopes_are_the_momenta(target: str) -> None:
    one = scene("two_link")
    program = lower(formulate(one, (NAME, "momentum")))
    try:
        module = RUNNERS[target].run(emit(program, target))
    except MissingProgram as fault:
        pytest.skip(str(fault))
    q, u = states(one)
    params = np.ones(len(one.free_parameters))
    ends = [[getattr(module, NAME)(q, u + side, params) for side in (h, -h)] for h in 1e-3 * np.eye(2)]
    slopes = [(float(ahead) - float(behind)) / 2e-3 for ahead, behind in ends]
    assert slopes == pytest.approx(np.ravel(module.momentum(q, u, params)), rel=1e-9)


def test_it_stays_as_it_is_along_a_motion_without_drives() -> None:
    one = symdyn.scene.bind(scene("two_link"), dict.fromkeys(("m1", "m2", "h1", "h2", "g"), "1"))
    moved = simulate(one, until=2.0, start={"q1": 1.0, "q2": 0.5}, rtol=1e-10, atol=1e-12)
    H = symdyn.load(one, NAME)[NAME](moved.q, moved.qd)
    assert np.ptp(H) < 1e-7 * np.abs(H).max()


def test_info_tells_it_and_load_has_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(EXAMPLES / "four_bar.toml")]) == 0
    assert f"{NAME} " in capsys.readouterr().out  # of the full state, not of the tree
    assert NAME in symdyn.load(scene("pendulum")).calls


def test_it_is_told_of_springs() -> None:
    assert derive_one(Workspace(scene("governor")), NAME).text.endswith(" and in springs")


# What a row says, everyone reads


CHANGED = {
    "may_fail": ("reported", lambda: None),
    "default_in": ("request", lambda: NAME not in available(scene("two_link"))[0]),
    "exists": (lambda scene: False, lambda: NAME not in available(scene("two_link"))[0]),
    "when_constrained": (
        "refuse",
        lambda: refused("four_bar", "about trees") and NAME not in available(scene("four_bar"))[0],
    ),
    "cubic": (True, lambda: NAME not in available(scene("quadruped"))[0]),
    "place": ("point", lambda: refused("two_link", f"write {NAME}:NAME")),
}


def refused(name: str, why: str) -> bool:
    with pytest.raises(DerivationError, match=why):
        derive_one(Workspace(scene(name)), NAME)
    return True


@pytest.mark.parametrize("field", CHANGED)
def test_another_word_in_a_field_is_heard(field: str, monkeypatch: pytest.MonkeyPatch) -> None:
    word, heard = CHANGED[field]
    monkeypatch.setitem(OUTPUTS, NAME, replace(OUTPUTS[NAME], **{field: word}))
    assert heard() is not False


def test_what_trees_do_not_have_is_refused_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(OUTPUTS, NAME, replace(OUTPUTS[NAME], when_constrained="only"))
    assert refused("two_link", "about closed loops and rows")


def test_what_is_of_the_tree_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(OUTPUTS, NAME, replace(OUTPUTS[NAME], when_constrained="tree"))
    function = derive_one(Workspace(scene("four_bar")), NAME)
    assert function.name == f"tree_{NAME}"
    assert function.text.endswith("of the spanning tree, as if nothing closed it")


def test_a_formulation_that_grows_fast_is_not_measured_for_many_coordinates() -> None:
    assert comparable(scene("two_link"), NAME) == ("recursive", "definition")
    assert comparable(scene("puma560"), NAME) == ("recursive",)


@pytest.mark.usefixtures("numpy_alone")
def test_a_fault_in_one_formulation_fails_the_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = Formulation(lambda w: [2 * x for x in energy_integral.by_definition(w)])
    row = OUTPUTS[NAME]
    monkeypatch.setitem(OUTPUTS, NAME, replace(row, formulations=row.formulations | {"definition": wrong}))
    assert not certify(scene("two_link"), (NAME,)).passed


def test_every_field_without_a_default_is_needed() -> None:
    needed = {one.name: getattr(OUTPUTS[NAME], one.name) for one in fields(Output) if one.default is MISSING}
    for name in needed:
        with pytest.raises(TypeError, match=name):
            Output(**{key: value for key, value in needed.items() if key != name})
