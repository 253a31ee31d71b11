"""Both formulations take what they say they take: each scene ends in a lesson, or in one sentence that is true."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.cli import main
from symdyn.errors import DerivationError
from symdyn.scene import read, read_text
from symdyn.teach import walkthrough
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.dalembert.shown_motion import choose_motion, solved_at

ROOT = Path(__file__).parent
FOUND, CONTACTS = ROOT / "data" / "found", ROOT / "data" / "contacts"

SLIDES = """
gravity = [0, -9.81, 0]
[bodies.b]
mass = 2
com = [0.1, 0, 0]
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[joints.table]
type = "planar"
parent = "ground"
child = "b"
axis = [0, 0, 1]
coordinates = ["x", "y", "phi"]
drive = false
[[loop]]
name = "slope"
type = "point_on_plane"
parent = "ground"
child = "b"
axis = [0, 3, 4]
"""


@pytest.mark.mends("3.9")
def test_bodies_that_nothing_drives_move_as_they_do_by_themselves(tmp_path: Path) -> None:
    """A body slides on a plane without a drive: the lesson's accelerations are those of its own motion."""
    scene = tmp_path / "slides.toml"
    scene.write_text(SLIDES, encoding="utf-8")

    assert main(["walkthrough", str(scene), "--formulation", "dalembert", "-o", str(tmp_path / "slides.md")]) == 0


@pytest.mark.parametrize("name", ["skate", "bicycle"])
def test_the_state_of_a_rolling_lesson_is_in_equilibrium(name: str) -> None:
    lesson = Balance(read(CONTACTS / f"{name}.toml"), "en")
    chosen = choose_motion(lesson)

    solved_at(lesson, chosen)  # asserts A x + b = 0

    assert np.abs(chosen.of(*lesson.state.qdd)).max() > 0.1


@pytest.mark.mends("3.9")
def test_a_joint_that_turns_and_slides_on_one_coordinate_has_reactions_in_its_lesson(tmp_path: Path) -> None:
    """Its wrenches are not at right angles, so none is the product with the whole."""
    assert (
        main(["walkthrough", str(FOUND / "cam.toml"), "--formulation", "dalembert", "-o", str(tmp_path / "cam.md")])
        == 0
    )


@pytest.mark.slow
@pytest.mark.mends("3.9")
def test_no_formulation_sends_a_scene_to_a_formulation_that_refuses_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene, said = str(ROOT.parent / "examples" / "rolling_disc.toml"), []
    for formulation in ("lagrange", "multipliers", "dalembert"):
        assert main(["walkthrough", scene, "--formulation", formulation, "-o", str(tmp_path / "disc.md")]) == 1
        said.append(capsys.readouterr().err)

    assert len(set(said)) == 1
    assert "--formulation quaternions" in said[0]
    assert main(["walkthrough", scene, "--formulation", "quaternions", "-o", str(tmp_path / "disc.md")]) == 0


def test_a_lesson_refuses_singular_angles_by_their_names() -> None:
    with pytest.raises(DerivationError, match=r"joint \w+: where the lesson shows numbers .* angles are singular"):
        walkthrough(read(FOUND / "euler_hinge.toml"), formulation="dalembert")


@pytest.mark.mends("3.9")
@pytest.mark.parametrize("length", ["pi/2", "sqrt(2)"])
def test_a_number_that_no_energy_holds_can_be_written(length: str) -> None:
    text = f"""
gravity = [0, -9.81, 0]
[bodies.b]
particles = [{{ mass = 2, at = [3, 0, "{length}"] }}]
[joints.j]
type = "revolute"
parent = "ground"
child = "b"
"""
    walkthrough(read_text(text, "b.toml"), until="energies")
