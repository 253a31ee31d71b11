"""Contacts that cannot be: where, what was found, what would work."""

from __future__ import annotations

import pytest
from contact_scenes import sliders

import symdyn
from symdyn.errors import SymdynError
from symdyn.scene.toml import read_text

pytestmark = [pytest.mark.runs("cc")]

SLIDES = """
name = "slides"
gravity = [0, 0, "-9.81"]
[parameters]
low = 2
high = 0
mu = 0.5
[bodies.a]
mass = 1
[bodies.b]
mass = 1
[joints.j]
type = "prismatic"
parent = "ground"
child = "a"
axis = [0, 0, 1]
coordinate = "z"
drive = false
start = 1
{keys}
[joints.k]
type = "{type}"
parent = "a"
child = "b"
{axis}
{more}
"""

MOVES, HELD = ("prismatic", 'axis = [1, 0, 0]\ncoordinate = "x"\ndrive = false'), ("fixed", "")


@pytest.mark.parametrize(
    ("keys", "joint", "more", "words"),
    [
        pytest.param(
            "",
            MOVES,
            'plane = { body = "a", at = [0, 0, 0.2], normal = [1, 0, 0] }\nat = [-0.1, 0, 0]',
            "slides: start: contact c begins 0.1 m inside its plane; start where it touches, or above",
            id="inside",
        ),
        pytest.param(
            "", MOVES, "restitution = -0.1", "contacts.c: restitution = -0.1 is not between 0 and 1", id="below 0"
        ),
        pytest.param(
            "", MOVES, 'restitution = "low"', "contacts.c: restitution = low is not between 0 and 1", id="above 1"
        ),
        pytest.param(
            "limits = { lower = 0, upper = 2, restitution = 1.5 }",
            MOVES,
            "",
            "joints.j: limits.restitution = 1.5 is not between 0 and 1",
            id="of a stop",
        ),
        pytest.param(
            "",
            MOVES,
            'type = "gap"\ngap = "z"\ntangent = "x_dot*z_dot"\nfriction = 0.1',
            "contacts.c: tangent = x_dot*z_dot is not linear in the velocities",
            id="tangent",
        ),
        pytest.param(
            "limits = { lower = 2, upper = 0, restitution = 0.5 }",
            MOVES,
            "",
            "joints.j: limits.lower = 2 is above limits.upper = 0; swap them",
            id="cross",
        ),
        pytest.param(
            'limits = { lower = "low", upper = "high", restitution = 0.5 }',
            MOVES,
            "",
            "joints.j: limits.lower = low is above limits.upper = high; swap them",
            id="cross by value",
        ),
        pytest.param(
            "",
            MOVES,
            'friction = "mu"\nstatic = 0.4',
            "contacts.c: static = 0.4 is less than friction = mu; what sticks",
            id="static",
        ),
        pytest.param(
            "friction = { coulomb = 2, static = 1 }",
            MOVES,
            "",
            "joints.j: friction.static = 1 is less than friction.coulomb = 2",
            id="joint",
        ),
        pytest.param(
            "",
            HELD,
            'plane = { body = "a", normal = [0, 0, 1] }',
            "slides: contacts.c: its gap never changes: nothing moves what touches",
            id="held together",
        ),
        pytest.param(
            "",
            MOVES,
            'at = [0, 0, 0.5]\nplane = { body = "a", normal = [0, 0, 1] }',
            "name another body or plane",
            id="along its plane",
        ),
        pytest.param(
            "",
            MOVES,
            'plane = { body = "b", normal = [0, 0, 1] }',
            'contacts.c: touches a plane on its own body, "b"',
            id="itself",
        ),
    ],
)
def test_a_contact_that_cannot_be_is_refused(keys: str, joint: tuple[str, str], more: str, words: str) -> None:
    kind, axis = joint
    body = "" if not more or "gap" in more else 'body = "b"\n'
    contact = f"[contacts.c]\n{body}{more}" if more else ""

    with pytest.raises(SymdynError) as fault:
        symdyn.simulate(read_text(SLIDES.format(keys=keys, type=kind, axis=axis, more=contact)), until=0.1)

    assert words in str(fault.value)


def test_nine_contacts_at_once_are_too_many_and_eight_are_not() -> None:
    table = f"gravity = [0, 0, -9.81]\n{sliders('z')}"
    feet = [f'[contacts.f{k}]\nbody = "b"\nat = [{k}, 0, 0]\n' for k in range(9)]
    words = r"9 contacts are closed at once, f0, .*, f8; 8 can be: leave out what others carry"

    run = symdyn.simulate(read_text(table + "".join(feet[:8])), until=0.1, method="dop853")
    assert run["normal_f3"][-1] == pytest.approx(9.81 / 8)
    with pytest.raises(SymdynError, match=rf"start: {words}"):
        symdyn.simulate(read_text(table + "".join(feet)), until=0.1, method="dop853")
    with pytest.warns(RuntimeWarning, match=words):  # what came before is kept
        symdyn.simulate(read_text(table + "".join(feet)), until=0.1, start="z=0.01", method="moreau:0.05")
