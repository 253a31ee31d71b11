"""What a force element from outside is worth: everything that symdyn does with its own, checked by laws.

`tests/test_recipes.py` runs this in a fresh process, where the kind is one file that is imported here.
"""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from gas_spring import GasSpring

import symdyn
from symdyn.cli.facts import acting
from symdyn.draw import free_body, picture
from symdyn.errors import SymdynError
from symdyn.scene import Quantity, lock, parse, read_text, with_symbols, write_text
from symdyn.scene.build import body, prismatic, scene
from symdyn.scene.forces import FORCES
from symdyn.scene.forces.applied_forces import Spring
from symdyn.scene.forces.force_kind import ForceKind, Pull
from symdyn.scene.values import Place
from symdyn.scene.values.entry import entry
from symdyn.simulation import simulate
from symdyn.teach import walkthrough
from symdyn.teach.render.page import interactive_page

pytestmark = pytest.mark.runs  # motions are compiled where there is a compiler

NAME = "gas_spring"

ARM = """name = "lid"
[parameters]
n = { value = 20, unit = "J" }
[bodies.lid]
mass = 2
com = [0.5, 0, 0]
inertia = [0.1, 0.2, 0.3]
inertia_about = "com"
[bodies.slider]
mass = 1
[joints.hinge]
type = "revolute"
parent = "ground"
child = "lid"
axis = [0, -1, 0]
coordinate = "phi"
drive = false
start = 0.4
[joints.rail]
type = "prismatic"
parent = "lid"
child = "slider"
axis = [1, 0, 0]
coordinate = "x"
drive = false
start = 0.6
[gas_springs.strut]
from = { body = "ground", at = [0.1, 0, -0.5] }
to = { body = "lid", at = [0.8, 0, 0] }
charge = "n"
dead = 0.05
[gas_springs.stop]
joint = "rail"
charge = 3
"""


def refusal(text: str) -> str:
    with pytest.raises(SymdynError) as refused:
        read_text(text)
    return str(refused.value)


def check_section() -> None:
    """Files and Python declare it in a section of its own, and what is written is read again."""
    one = read_text(ARM)

    assert "[gas_springs.strut]" in write_text(one, "toml").text
    assert read_text(write_text(one, "toml").text) == one
    made = scene(
        "stop",
        bodies=[body("b", mass=1)],
        joints=[prismatic("rail", "ground", "b", axis=[1, 0, 0])],
        gas_springs=[entry("gas_springs", "stop", joint="rail", charge=3)],
    )
    assert made.elements == (one.elements[1],)
    assert "did you mean gas_springs?" in refusal(ARM.replace("[gas_springs", "[gas_sprngs"))


def check_noun() -> None:
    assert read_text(ARM).elements == (
        GasSpring(
            "strut",
            ends=(Place("ground", vec("1/10", 0, "-1/2")), Place("lid", vec("4/5", 0, 0))),
            charge=parse("n"),
            dead=parse("1/20"),
        ),
        GasSpring("stop", joint="rail", charge=Quantity.number(3)),
    )


def vec(*entries: object) -> tuple[symdyn.scene.Quantity, ...]:
    return tuple(parse(str(one)) for one in entries)


def check_parts() -> None:
    """Its keys are read, checked, named and asked for, and belong to no other kind; a locked joint takes it along."""
    assert "uses the undefined symbol s" in refusal(ARM.replace('charge = "n"', 'charge = "s"'))
    assert "charge = phi uses phi, which moves" in refusal(ARM.replace('charge = "n"', 'charge = "phi"'))
    assert "charge = [1] is a list; give a number" in refusal(ARM.replace('charge = "n"', "charge = [1]"))
    assert "charge = -3 is that of no gas; give one above zero" in refusal(ARM.replace("charge = 3", "charge = -3"))
    assert 'unknown key "charg"; did you mean charge?' in refusal(
        ARM.replace('charge = "n"', 'charge = 1\ncharg = "n"')
    )
    assert 'unknown key "stiffness"' in refusal(ARM.replace("charge = 3", "charge = 3\nstiffness = 1"))
    assert 'unknown key "charge"' in refusal(ARM.replace("[gas_springs.stop]", "[springs.stop]"))
    assert "to = " in refusal(ARM.replace('to = { body = "lid"', 'to = { body = "lad"'))
    assert 'joint = "rial" is not a joint of the tree; ' in refusal(ARM.replace('joint = "rail"', 'joint = "rial"'))
    assert [one.name for one in lock(read_text(ARM), {"rail": Quantity.number(0)}).elements] == ["strut"]
    named = {p.name: (p.unit, p.text) for p in with_symbols(read_text(ARM), "all").parameters}
    assert named["pv2"] == ("J", "charge of stop")
    assert named["dl1"] == ("m", "dead length of strut")


def check_letter() -> None:
    assert "a_gs1f" in {p.name for p in with_symbols(read_text(ARM), "geometry").parameters}


def check_needs() -> None:
    assert "charge is missing" not in refusal(ARM.replace('"n"', '"s"'))


def check_missing() -> None:
    assert "charge is missing; write charge = 20" in refusal(ARM.replace("charge = 3", ""))


def check_law() -> None:
    """Its force is the slope of its energy; every law is proved; generated C agrees; energy is kept in motion."""
    one = read_text(ARM)
    energy, gravity, forces = symdyn.lambdify(one, ("potential_energy", "gravity_forces", "elastic_forces"))
    q, step = np.array([0.4, 0.6]), 1e-5
    for k in range(2):
        slope = (energy(q + step * np.eye(2)[k]) - energy(q - step * np.eye(2)[k])) / (2 * step)
        np.testing.assert_allclose((gravity(q) + forces(q))[k], slope, rtol=1e-8)
    s = float(np.hypot(0.8 * np.cos(0.4) - 0.1, 0.8 * np.sin(0.4) + 0.5))
    weight = symdyn.lambdify(replace(one, elements=()), "potential_energy")(q)
    np.testing.assert_allclose(energy(q) - weight, -20 * np.log(s - 0.05) - 3 * np.log(0.6), rtol=1e-13)
    assert symdyn.certify(one).passed
    motion = simulate(one, until=1.0)
    kinetic = symdyn.lambdify(one, "kinetic_energy")
    total = kinetic(motion.q, motion.qd) + energy(motion.q)
    np.testing.assert_allclose(total, total[0], rtol=1e-9)
    assert np.ptp(motion.q[:, 0]) > 0.1


def check_law_words() -> None:
    assert {"kind": NAME, "name": "stop", "where": "joint rail", "law": "charge 3, dead 0"} in acting(read_text(ARM))


def check_words() -> None:
    assert set(FORCES[NAME].words) == {"en", "sk"}
    for language, words in FORCES[NAME].words.items():
        assert words in str(walkthrough(read_text(ARM), language=language))


def check_lost() -> None:
    """A format that cannot hold it refuses it, and says what it leaves out where that is allowed."""
    with pytest.raises(SymdynError, match=r"gas_springs\.strut: a gas spring, which acts in the equations"):
        write_text(read_text(ARM.replace('"n"', "20").replace('n = { value = 20, unit = "J" }\n', "")), "urdf")


def check_mark() -> None:
    shown = picture(read_text(ARM))

    assert shown.count('class="gas_spring"') == 2
    assert "F strut" in free_body(read_text(ARM), "lid")
    assert '"damper_slide"' in interactive_page(read_text(ARM))


def check_check() -> None:
    assert "dead = -1 is a length below zero" in refusal(ARM.replace("charge = 3", "charge = 3\ndead = -1"))


CHECKS = {
    "section": check_section, "noun": check_noun, "letter": check_letter, "parts": check_parts, "needs": check_needs,
    "missing": check_missing, "law": check_law, "law_words": check_law_words, "words": check_words, "lost": check_lost,
    "mark": check_mark, "check": check_check,
}  # fmt: skip

GONE = {
    "section": "springs", "noun": Spring, "letter": "", "parts": (), "needs": (), "missing": "",
    "law": Pull(FORCES[NAME].law.force), "law_words": lambda one: "", "words": {}, "lost": "",
    "mark": None, "check": None,
}  # fmt: skip


@pytest.mark.parametrize("field", CHECKS)
def test_the_new_kind_does_what_its_row_says(field: str) -> None:
    CHECKS[field]()


@pytest.mark.parametrize("field", CHECKS)
def test_a_row_without_a_field_fails_the_check_of_that_field(field: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FORCES, NAME, replace(FORCES[NAME], **{field: GONE[field]}))

    with pytest.raises((AssertionError, SymdynError, LookupError, TypeError, pytest.fail.Exception)):
        CHECKS[field]()


def test_every_field_of_a_row_is_checked() -> None:
    assert {one.name for one in fields(ForceKind)} == set(CHECKS)
