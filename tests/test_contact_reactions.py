"""Reactions of joints beside contacts: by momenta of what hangs on a joint, and as where rows hold what sticks."""

from __future__ import annotations

import numpy as np
import pytest

import symdyn
from symdyn.errors import SymdynError
from symdyn.scene.toml import read_text

pytestmark = [pytest.mark.runs("cc")]

ARM = """
name = "arm"
gravity = [0, 0, "-9.81"]
[bodies.a]
mass = 1
com = [0.5, 0, 0]
inertia = [0.02, 0.1, 0.1]
inertia_about = "com"
[bodies.b]
mass = 2
com = [0.4, 0, 0.1]
inertia = [0.02, 0.2, 0.2]
inertia_about = "com"
[joints.j]
type = "revolute"
parent = "ground"
child = "a"
axis = [0, 1, 0]
origin = [0, 0, 0.5]
coordinate = "q1"
damping = 0.3
start = 0.2
[joints.k]
type = "revolute"
parent = "a"
child = "b"
origin = [1, 0, 0]
axis = [0, 1, 0]
coordinate = "q2"
drive = false
start = 0.1
start_rates = 0.5
[contacts.tip]
body = "b"
at = [0.8, 0, 0]
friction = 0.3
restitution = 0.2
"""

LEVER = """
name = "lever"
gravity = [0, 0, "-9.81"]
[bodies.lever]
mass = 3
com = [0.3, 0, 0]
inertia = [0.1, 0.4, 0.4]
inertia_about = "com"
[bodies.slide]
mass = 0.5
[bodies.b]
mass = 2
[joints.pin]
type = "revolute"
parent = "ground"
child = "lever"
axis = [0, 1, 0]
coordinate = "phi"
drive = "M"
[joints.x]
type = "prismatic"
parent = "ground"
child = "slide"
axis = [1, 0, 0]
coordinate = "x"
drive = false
start = 0.6
[joints.z]
type = "prismatic"
parent = "slide"
child = "b"
axis = [0, 0, 1]
coordinate = "z"
drive = false
start = 0.1
"""

SPRING = '[springs.s]\njoint = "pin"\nstiffness = 400\n'

TOUCH = """
type = "{type}"
body = "b"
plane = {{ body = "lever", normal = [0, 0, 1] }}
{more}
"""


@pytest.mark.slow
def test_what_hangs_on_a_joint_moves_by_its_reaction_its_weight_and_its_contact() -> None:
    run = symdyn.simulate(
        read_text(ARM + '[outputs]\nr = "reaction_j_fz_ground"\n'), until=1.5, every=0.05, reactions="ground"
    )
    angles, rates, changes = (np.cumsum(one, axis=1) for one in (run.q, run.qd, run.qdd))

    def moved(k: int, x: float, z: float) -> np.ndarray:
        """Return the acceleration of a place of link k beside its origin, along x and z."""
        a, w, dw = angles[:, k], rates[:, k], changes[:, k]
        here = np.array([x * np.cos(a) + z * np.sin(a), -x * np.sin(a) + z * np.cos(a)])
        return dw * np.array([here[1], -here[0]]) - w**2 * here

    total = moved(0, 0.5, 0) + 2 * (moved(0, 1, 0) + moved(1, 0.4, 0.1))

    assert {one.what for one in run.impacts} == {"strikes", "slips"}
    assert run["normal_tip"].max() > 10
    assert run["reaction_j_fx_ground"] + run["friction_tip"] == pytest.approx(total[0], abs=1e-12)
    assert run["reaction_j_fz_ground"] + run["normal_tip"] == pytest.approx(total[1] + 3 * 9.81, abs=1e-12)
    assert run["reaction_k_my_ground"] == pytest.approx(0, abs=1e-12)  # nothing drives it
    assert run["reaction_j_my_ground"] == pytest.approx(-0.3 * run.qd[:, 0], abs=1e-12)
    assert np.array_equal(run["r"], run["reaction_j_fz_ground"])


def test_a_contact_between_two_bodies_acts_on_both_as_a_row_that_holds_it_does() -> None:
    contact = TOUCH.format(type="ball", more="radius = 0.1\nfriction = 2")
    run = symdyn.simulate(read_text(f"{LEVER}{SPRING}[contacts.foot]{contact}"), until=0.3, every=0.03, reactions=True)
    row = TOUCH.format(type="rolling", more='radius = 0.1\ncomponents = ["normal", "along"]')
    held = symdyn.lambdify(read_text(f"{LEVER}{SPRING}[constraints.foot]{row}"), "forward_reactions")

    assert set(run["mode_foot"]) == {1.0}
    for k in range(1, len(run.t)):
        found = held(run.q[k], run.qd[k], run.tau[k])
        for j, joint in enumerate(("pin", "x", "z")):
            names = [f"reaction_{joint}_{one}" for one in ("fx", "fy", "fz", "mx", "my", "mz")]
            assert [run[name][k] for name in names] == pytest.approx(found[j].tolist(), abs=1e-8)


@pytest.mark.parametrize(
    ("text", "asked", "words"),
    [
        (
            ARM,
            {"method": "moreau:1e-2"},
            "reactions: moreau:1e-2 has impacts within its steps, and its accelerations do not",
        ),
        (
            LEVER + '[contacts.foot]\ntype = "gap"\ngap = "z"\n',
            {},
            "reactions: they do not know where the forces of foot act, a formula; leave it out",
        ),
        (
            LEVER + '[contacts.foot]\nbody = "b"\n[constraints.belt]\ntype = "formula"\nformula = "x_dot - z_dot"\n'
            'acts_in = "joints"\n',
            {},
            "reactions: beside loops and constraints they do not know the forces of contacts, foot; leave them out",
        ),
    ],
)
def test_reactions_that_are_not_known_beside_contacts_are_refused(text: str, asked: dict[str, str], words: str) -> None:
    with pytest.raises(SymdynError) as fault:
        symdyn.simulate(read_text(text), until=0.1, reactions=True, **asked)

    assert words in str(fault.value)


@pytest.mark.parametrize("rope_first", [True, False])
def test_a_slack_rope_pulls_at_all_its_places_and_beside_other_contacts(rope_first: bool) -> None:
    """Joints felt its first straight part alone; before a contact it ended in an IndexError."""
    rope = """
    [ropes.r]
    type = "slack"
    through = [{ body = "ground", at = [4, 0, 0] }, { body = "a", at = [0, 0, 0] }, { body = "ground", at = [0, 4, 0] }]
    length = 10
    """
    foot = '[contacts.foot]\nbody = "b"\nplane = { body = "ground", normal = [0, 0, 1] }\n'
    text = "gravity = [0, 0, -10]\n" + "".join(
        f"""
        [bodies.{body}]
        mass = {mass}
        [joints.{joint}]
        type = "prismatic"
        parent = "ground"
        child = "{body}"
        coordinate = "{joint}"
        drive = false
        start = {start}
        """
        for body, mass, joint, start in (("a", 2, "z", -3.0), ("b", 5, "y", 0.0))
    )
    run = symdyn.simulate(
        read_text(text + (rope + foot if rope_first else foot + rope)), until=1e-2, reactions="ground"
    )
    told = [[run[f"reaction_{joint}_f{k}_ground"][0] for k in "xyz"] for joint in "zy"]

    assert run["normal_r"][0] == pytest.approx(50 / 3)  # 2 · 3/5 of it carry 20 N
    assert run["normal_foot"][0] == pytest.approx(50)
    np.testing.assert_allclose(told, [[-40 / 3, -40 / 3, 0], [0, 0, 0]], atol=1e-9)
