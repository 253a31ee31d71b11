"""Less accuracy than doubles allow, where users meet it: loaded, certified, read back, and beside others in a bench."""

from __future__ import annotations

import pickle
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from symdyn import certify, load
from symdyn.cli import main
from symdyn.errors import EmitError
from symdyn.scene import example

pytestmark = pytest.mark.usefixtures("optimised")

EXAMPLES = Path(__file__).parent.parent / "examples"
PUMA = str(EXAMPLES / "puma560.toml")

# Loaded


@pytest.mark.long
@pytest.mark.runs("cc")
def test_what_is_loaded_has_it_for_many_states_and_after_a_pickle_too():
    arm = load(example("arm7"), "gravity_forces", accuracy="1e-10")
    full = load(example("arm7"), "gravity_forces")
    q = np.random.default_rng(3).uniform(-3, 3, (300, 7))
    exact_ = full.gravity_forces(q)
    for made in (arm, pickle.loads(pickle.dumps(arm))):
        off = np.abs(made.gravity_forces(q) - exact_).max() / np.abs(exact_).max()
        assert 1e-13 < off < 1e-10
        assert np.array_equal(made.gravity_forces(q[0]), full.gravity_forces(q[0])), "one state has all digits"
        single = q.astype(np.float32)
        assert np.array_equal(made.gravity_forces(single), full.gravity_forces(single))


def test_loading_refuses_what_there_is_not():
    with pytest.raises(EmitError, match="accuracy '1e-12' is not known"):
        load(example("pendulum"), accuracy="1e-12")


@pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is not installed")
def test_backends_that_do_not_have_it_say_so():
    with pytest.raises(EmitError, match="not for those of PyTorch; leave it out"):
        load(example("pendulum"), accuracy="1e-10", backend="torch")


# Certified


@pytest.mark.long
@pytest.mark.runs("cc")
def test_a_certificate_holds_code_against_the_bounds_of_its_sines():
    found = certify(example("puma560"), ["inverse_dynamics"], targets=("c", "ufunc"), accuracy="1e-10")
    assert found.passed
    assert {one.module for one in found.accuracy} == {"c", "ufunc"}
    assert all(1e-13 < one.max_ulp * 2.0**-52 < 1e-10 for one in found.accuracy), "many states are measured"
    assert all(one.worst > 0.01 for one in found.accuracy), "the bounds are no wider than they must be"
    assert {(one.target, one.option) for one in found.written} == {("c", "batch")}
    assert found.blocks[0].passed
    assert found.notes == ("accuracy 1e-10: bounds have sines and cosines that are off by 8e-12 in them",)


@pytest.mark.runs("cc")
def test_verify_takes_what_has_the_accuracy_and_refuses_the_rest_in_words(capsys):
    scene = ["verify", str(EXAMPLES / "pendulum.toml"), "--functions", "gravity_forces", "--accuracy", "1e-10"]
    assert main(scene) == 0
    told = capsys.readouterr().out
    assert "c --batch" in told
    assert "numpy" not in told
    for more, words in (
        (["--targets", "js"], "accuracy 1e-10 is for targets c and ufunc"),
        (["--real", "float"], "accuracy 1e-10 is one of double, not of float"),
        (["--rigorous"], "--rigorous measures code of full accuracy; leave out --accuracy"),
    ):
        assert main([*scene, *more]) == 1
        assert words in " ".join(capsys.readouterr().err.split())


def test_files_are_read_back_with_the_sines_that_their_header_says(tmp_path, capsys):
    words = ["--target", "c", "--batch", "--accuracy", "1e-10", "--functions", "gravity_forces", "-o", str(tmp_path)]
    assert main(["generate", PUMA, *words]) == 0
    assert main(["verify", PUMA, "--files", str(tmp_path)]) == 0
    file = tmp_path / "puma560.c"
    text = file.read_text("utf-8")
    for before, after in (("(-0.1666", "(-0.1667"), (" --accuracy 1e-10", "")):
        assert before in text
        file.write_text(text.replace(before, after), "utf-8")
        capsys.readouterr()
        assert main(["verify", PUMA, "--files", str(tmp_path)]) == 1
        assert ": fixed text: " in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(("function", "told"), [("mass_matrix", True), ("gravity_forces", False)])
def test_generate_says_where_there_is_nothing_to_gain(function, told, tmp_path, capsys):
    words = ["--target", "c", "--batch", "--accuracy", "1e-10", "--functions", function, "-o", str(tmp_path)]
    assert main(["generate", str(EXAMPLES / "pendulum.toml"), *words]) == 0
    assert ("no function takes a sine; --accuracy 1e-10 makes none faster" in capsys.readouterr().err) is told
