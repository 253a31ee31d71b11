"""Contacts as they are declared and written, and what is told where they are wrong or not known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from contact_scenes import BELT, DATA, FALL, KNEE, ROD, TWO, row_of_balls, wheel

import symdyn
from symdyn.cli import main
from symdyn.errors import SceneError, SimulateError, SymdynError
from symdyn.scene import read_text, write_text

pytestmark = pytest.mark.runs("cc")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('friction = "0.36"', "restitution = 1.5", "contacts.foot: restitution = 1.5 is not between 0 and 1"),
        (
            'friction = "0.36"',
            "friction = 0.5\nstatic = 0.4",
            "contacts.foot: static = 0.4 is less than friction = 0.5; what sticks holds as much as what slips",
        ),
        (
            'friction = "0.36"',
            'law = "hertz"',
            'contacts.foot: law = "hertz" is not known; write "poisson" or "newton"',
        ),
        (
            'type = "point"',
            'type = "cube"',
            'contacts.foot: type = "cube" is not a contact; known are point, ball, wheel, gap',
        ),
        ('type = "point"', 'type = "ball"', "contacts.foot: radius is missing; write radius = 0.1"),
        ('body = "rod"', 'body = "rob"', 'contacts.foot: body = "rob" is not a body; did you mean rod?'),
    ],
)
def test_what_is_wrong_is_told(old: str, new: str, words: str) -> None:
    with pytest.raises(SceneError) as fault:
        read_text(ROD.replace(old, new))
    assert words in str(fault.value)


GAP = row_of_balls("poisson").replace('gap = "xb - xa"', 'gap = "GAP"\ntangent = "TANGENT"\nfriction = 0.1')


@pytest.mark.parametrize(
    ("gap", "tangent", "words"),
    [
        (
            "xb - xa_dot",
            "xa_dot",
            "gap = xb - xa_dot uses xa_dot; a gap is a formula in coordinates and parameters",
        ),
        ("xb - xa", "xa_dot**2", "contacts.ab: tangent = xa_dot**2 is not linear in the velocities"),
        ("xb - xa", "xa", "contacts.ab: tangent = xa is no sum of velocities, each times a formula in coordinates"),
    ],
)
def test_formulas_of_contacts_that_are_none_are_told(gap: str, tangent: str, words: str) -> None:
    with pytest.raises(SceneError) as fault:
        read_text(GAP.replace("GAP", gap).replace("TANGENT", tangent))
    assert words in str(fault.value)


def test_a_restitution_needs_a_limit() -> None:
    with pytest.raises(SceneError) as fault:
        read_text(TWO.replace("friction = { coulomb = 20 }", "limits = { restitution = 0.5 }"))
    assert "limits.restitution goes with lower or upper, which the joint strikes; give one of them" in str(fault.value)


def test_a_contact_that_begins_inside_its_plane_is_told() -> None:
    with pytest.raises(SimulateError) as fault:
        symdyn.simulate(read_text(ROD), until=1, start="y=0.3")
    assert "contact foot begins 0.199" in str(fault.value)
    assert "start where it touches, or above" in str(fault.value)


@pytest.mark.parametrize(
    "ask",
    [
        symdyn.linearize,
        lambda scene: symdyn.sensitivity(scene, until=0.1),
        lambda scene: symdyn.inverse(scene, motion="x=t,y=1,theta=0", until=1),
        lambda scene: symdyn.collocation(scene, until=1, cost="1"),
    ],
)
def test_what_knows_no_contacts_refuses_them(ask) -> None:
    with pytest.raises(SymdynError) as fault:
        ask(read_text(ROD))
    assert "contacts" in str(fault.value)


def test_a_method_that_begins_anew_slowly_is_refused() -> None:
    with pytest.raises(SymdynError) as fault:
        symdyn.simulate(read_text(ROD), until=1, method="lsoda")
    assert "it would begin anew at every event of a contact, with small steps; take radau" in str(fault.value)


@pytest.mark.parametrize(
    ("more", "asked", "words"),
    [
        (
            "",
            {"stops": ["reaction_z_fx"]},
            "reaction_z_fx: events do not know the forces of contacts in them; name normal_NAME",
        ),
        ("[inputs.gap_f]\n", {}, "gap_f is the name of a column of contact f, too; rename it or the contact"),
        ('[outputs]\nmode_f = "z"\n', {}, "mode_f is the name of a column of contact f, too"),
    ],
)
def test_what_a_run_with_contacts_cannot_tell_is_refused(more: str, asked: dict[str, Any], words: str) -> None:
    with pytest.raises(SymdynError) as fault:
        symdyn.simulate(read_text(FALL + more), until=1, **asked)
    assert words in str(fault.value)


def test_starts_beyond_a_stop_and_names_of_stops_are_told_in_their_words() -> None:
    with pytest.raises(SimulateError) as fault:
        symdyn.simulate(read_text(KNEE), until=1, start="q=0.7")
    assert "start: stop h_upper is passed by 0.2 rad; start the joint within its limits" in str(fault.value)
    with pytest.raises(SimulateError) as fault:
        symdyn.simulate(read_text(KNEE + '[contacts.h_upper]\nbody = "b"\n'), until=1)
    assert "h_upper is the name of a stop or a friction, too" in str(fault.value)


def test_who_takes_contacts_as_open_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, text in (("fall", FALL), ("knee", KNEE)):
        (tmp_path / f"{name}.toml").write_text(text)
        for verb in ("equations", "info"):
            assert main([verb, str(tmp_path / f"{name}.toml")]) == 0
            err = capsys.readouterr().err
            assert f"{name}: all contacts open: {'f' if name == 'fall' else 'stops of h'}; runs, sensitivity" in err
    main(["info", str(tmp_path / "fall.toml")])
    assert "restitution e, friction 0, Poisson's law" in capsys.readouterr().out
    assert "limits.restitution: the file has limits that nothing strikes" in "".join(
        write_text(read_text(KNEE), "urdf", lossy=True).lost
    )


def test_a_scene_with_contacts_is_written_as_it_was_read() -> None:
    for text in (ROD, BELT, TWO, row_of_balls("newton"), wheel(0.1)):
        scene = read_text(text)
        assert read_text(write_text(scene, "toml").text) == scene


def test_contacts_are_declared_in_python() -> None:
    scene = symdyn.scene.scene(
        "ball",
        bodies=[symdyn.scene.body("ball", mass=1)],
        joints=[symdyn.scene.joint("fall", "prismatic", "ground", "ball", axis=[0, 0, 1], coordinate="z", start=1)],
        contacts=[symdyn.scene.contact("floor", body="ball", restitution=0.8)],
    )
    assert (
        scene.unilaterals[0].restitution
        == read_text((DATA / "scenes/ball.toml").read_text()).unilaterals[0].restitution
    )
