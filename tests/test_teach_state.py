"""The state of a lesson's numbers: allowed by the scene, hiding nothing; rounded numbers follow ≈, and have units."""

from __future__ import annotations

import itertools
import math
import re
from pathlib import Path

import pytest
from lessons import lesson_of, step_of

import symdyn
from symdyn.scene import Scene, read, read_text
from symdyn.table import Table
from symdyn.teach import Document, rendered, walkthrough
from symdyn.teach.mathematics import Spelling
from symdyn.teach.shown_state import shown_state

ROOT = Path(__file__).parent
EXAMPLES, FOUND = ROOT.parent / "examples", ROOT / "data/found"

CRANK = """
name = "crank"
gravity = [0, "-g", 0]
[parameters]
r = { value = 0.2, positive = true, unit = "m" }
l = { value = 0.7, positive = true, unit = "m" }
g = { value = 9.81, positive = true, unit = "m/s^2" }
[bodies]
crank = { particles = [{ mass = 1, at = ["r", 0, 0] }] }
rod = { particles = [{ mass = 2, at = ["l/2", 0, 0] }] }
piston = { particles = [{ mass = 3, at = [0, 0, 0] }] }
[joints.motor]
type = "revolute"
parent = "ground"
child = "crank"
axis = [0, 0, 1]
coordinate = "phi"
motion = "2 + 3*t + 2*t**2"
[joints.pin]
type = "revolute"
parent = "crank"
child = "rod"
origin = { xyz = ["r", 0, 0] }
axis = [0, 0, 1]
coordinate = "psi"
drive = false
[joints.guide]
type = "prismatic"
parent = "ground"
child = "piston"
axis = [1, 0, 0]
coordinate = "x"
drive = false
start = 0.6
[[loop]]
name = "eye"
type = "revolute"
parent = "rod"
child = "piston"
origin = { xyz = ["l", 0, 0] }
axis = [0, 0, 1]
"""


def shown(document: Document, key: str = "state") -> dict[str, float]:
    """Return the numbers of a table by symbol."""
    step = step_of(document, key)
    (table,) = [block for block in step.blocks if isinstance(block, Table)]
    return {
        row[0].parts[0].name: float(str(row[1].parts[0]).replace("−", "-").replace(" · 10^", "e")) for row in table.rows
    }


@pytest.mark.long(0)
@pytest.mark.mends("5.5")
@pytest.mark.parametrize("formulation", ["lagrange", "dalembert"])
def test_a_prescribed_motion_is_shown_where_it_is(formulation: str) -> None:
    """The hoop is turned by phi = Omega t, so phi' is Omega and phi'' is zero, whatever else is chosen."""
    state = shown(lesson_of(read(FOUND / "hoop_driven.toml"), formulation=formulation))

    assert state["phi"] == pytest.approx(state["Omega"] * state["t"])
    assert state["phi_dot"] == state["Omega"] == 8
    assert state["phi_ddot"] == 0
    assert state["theta_dot"] != 0


@pytest.mark.mends("5.5")
def test_a_loop_with_a_prescribed_motion_is_shown_where_it_is() -> None:
    state = shown(walkthrough(read_text(CRANK, "crank"), formulation="dalembert"))

    t, phi, psi = state["t"], state["phi"], state["psi"]
    assert phi == pytest.approx(2 + 3 * t + 2 * t * t, abs=2e-3)
    assert state["phi_dot"] == pytest.approx(3 + 4 * t, abs=2e-3)
    assert state["phi_ddot"] == 4
    assert 0.2 * math.sin(phi) + 0.7 * math.sin(phi + psi) == pytest.approx(0, abs=2e-3)
    assert 0.2 * math.cos(phi) + 0.7 * math.cos(phi + psi) == pytest.approx(state["x"], abs=2e-3)
    speed = 0.2 * math.cos(phi) * state["phi_dot"] + 0.7 * math.cos(phi + psi) * (state["phi_dot"] + state["psi_dot"])
    assert speed == pytest.approx(0, abs=1e-2)


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.mends("5.5")
@pytest.mark.parametrize("name", ["two_link", "cart_pole", "double_pendulum", "pendulum", "hoop", "scara"])
def test_no_coordinate_of_the_state_hides_an_error(name: str) -> None:
    """At zero, at a multiple of 45°, and where two are equal, a wrong sign or sine in place of a cosine goes unseen."""
    scene = read(FOUND / "hoop_driven.toml") if name == "hoop" else read(EXAMPLES / f"{name}.toml")
    state = shown(walkthrough(scene))

    places = {q: state[q] for q in scene.coordinates}
    units = dict(zip(scene.coordinates, kinds(scene), strict=True))
    for q, value in places.items():
        assert abs(math.remainder(value, math.pi / 4) if units[q] == "rad" else value) > 0.01
    sizes = sorted(abs(value) for value in places.values())
    assert all(b - a > 0.01 for a, b in itertools.pairwise(sizes))


def kinds(scene: Scene) -> list[str]:
    from symdyn.scene.joints import JOINTS

    return [unit for joint in scene.moving for unit in JOINTS[joint.type].coordinates(joint)]


@pytest.mark.long(0)
def test_limits_of_a_joint_are_kept() -> None:
    text = (FOUND / "hoop_driven.toml").read_text().replace('motion = "Omega*t"\n', "")
    text = text.replace("start = 0.5", "start = 0.0\nlimits = { lower = -0.5, upper = 0.5 }")
    assert 0 < abs(shown(walkthrough(read_text(text, "hoop")))["theta"]) < 0.5


@pytest.mark.long(0)
def test_rates_that_the_scene_starts_with_are_shown() -> None:
    text = (EXAMPLES / "two_link.toml").read_text().replace("[joints.elbow]", "[joints.elbow]\nstart_rates = [2.5]")
    assert shown(walkthrough(read_text(text, "two_link")))["q2_dot"] == 2.5


@pytest.mark.long
@pytest.mark.wide(3)
@pytest.mark.mends("5.5")
@pytest.mark.parametrize("language", ["en", "sk"])
@pytest.mark.parametrize("name", ["two_link", "cart_pole"])
def test_rounded_results_follow_the_sign_for_it(name: str, language: str) -> None:
    text = str(rendered(lesson_of(read(EXAMPLES / f"{name}.toml"), language), "md")[f"{name}.md"])

    prose = [line for line in text.splitlines() if not line.startswith(("|", "$$", "<"))]
    found = [n for line in prose for n in re.findall(r"(?<![A-Za-z]) ([=≈]) (−?\d+[.,]\d+)", line)]
    assert len(found) >= 3
    assert {sign for sign, number in found if len(re.sub("[−.,]", "", number).lstrip("0")) == 4} == {"≈"}


@pytest.mark.mends("5.5")
def test_rounded_numbers_in_formulas_follow_the_sign_for_it() -> None:
    scene = read_text(THIRDS, "thirds")
    document = walkthrough(scene)
    spell = Spelling(document)
    chains = [spell.formula(b)[1] for _, b in document.blocks() if getattr(b, "left", "") == "k_z:1,1"]

    assert chains
    assert all(chain.startswith(r"\approx ") for chain in chains)


THIRDS = """
name = "thirds"
gravity = [0, "-g", 0]
[parameters]
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies]
rod = { particles = [{ mass = 1.23456789, at = [0.7, 0, 0] }] }
[joints]
pivot = { type = "revolute", parent = "ground", child = "rod", axis = [0, 0, 1] }
"""


@pytest.mark.mends("5.5")
def test_coefficients_have_units() -> None:
    scene = read(EXAMPLES / "cart_pole.toml")
    document = walkthrough(scene)

    step = step_of(document, "values")
    (table,) = [block for block in step.blocks if isinstance(block, Table)]
    spell = Spelling(document)
    units = {spell.words(row[0], str): spell.words(row[-1], str) for row in table.rows}
    assert units["$k_{z,11}$"] == "kg"
    assert units["$k_{z,12}$"] == units["$k_{D,12}$"] == "kg m"
    assert units["$k_{z,22}$"] == "kg m²"
    assert units["$k_{G,2}$"] == "N m"


def test_values_that_lessons_choose_for_parameters_are_no_two_alike_and_none_is_lost():
    scene = read(ROOT / "data/rx90.par")
    chosen = shown_state(scene).parameters
    values = [chosen[parameter.name] for parameter in scene.free_parameters]

    assert len(values) == len(set(values)) == 81
    assert min(values) > 0.05


@pytest.mark.long(0)
def test_what_nothing_drives_is_accelerated_as_its_equation_says() -> None:
    """l/3 theta'' = (g sin theta + x'' cos theta) / 2 of a rod on a cart; R theta'' of a bead by hand."""
    cart = shown(lesson_of(read(EXAMPLES / "cart_pole.toml")))
    theta = cart["theta"]
    pull = cart["g"] * math.sin(theta) + cart["x_ddot"] * math.cos(theta)
    assert cart["theta_ddot"] == pytest.approx(1.5 * pull / cart["l"], rel=1e-3)

    document = lesson_of(read(FOUND / "hoop_driven.toml"))
    bead = shown(document)
    turning = bead["Omega"] ** 2 * math.sin(bead["theta"]) * math.cos(bead["theta"])
    fall = bead["g"] / bead["R"] * math.sin(bead["theta"])
    assert bead["theta_ddot"] == pytest.approx(turning - fall, rel=1e-3)
    needed = step_of(document, "torque:2")
    assert "= 0 N m" in "".join(map(str, needed.claim.parts))
    other = shown(lesson_of(read(EXAMPLES / "cart_pole.toml"), formulation="dalembert"))
    assert other["theta_ddot"] == cart["theta_ddot"]


@pytest.mark.long(0)
def test_a_drive_beside_friction_does_not_supply_all_by_itself() -> None:
    text = str(rendered(lesson_of(read(EXAMPLES / "cart_pole.toml")), "md")["cart_pole.md"])
    assert "what the drive of $x$ and what else acts there have to supply together" in text
    assert "No drive acts on $\\theta$, and nothing else without a potential: the terms add up to zero." in text
    assert "The drive of $x$ has to supply this" not in text


@pytest.mark.mends("30.also.lessons")
def test_a_lesson_at_a_dead_centre_shows_the_acceleration_that_gravity_gives_there() -> None:
    """The crank and the rod, whose rates are as 1 to -1/2, turn by I q'' = -m g s alone: no drive reaches them."""
    inertia = 0.0825 + 2 * 0.25**2 + 0.2 * 0.5**2
    state = shown(lesson_of(read(ROOT / "data/dead_centre.toml"), formulation="dalembert"))
    assert state["q1_ddot"] == pytest.approx(-3 * 9.81 * 0.25 / inertia, rel=1e-3)


def test_a_lesson_that_has_no_numbers_says_of_which_scene_and_where() -> None:
    with pytest.raises(symdyn.SymdynError, match="deadcentre: where the lesson shows numbers"):
        walkthrough(read(ROOT / "data/dead_centre.toml"), formulation="multipliers")


STIFF = """
name = "stiff"
gravity = [0, -9.81, 0]
[bodies]
a = { particles = [{ mass = 1, at = [1, 0, 0] }] }
b = { particles = [{ mass = 0.3, at = [0.4, 0.1, 0] }] }
[joints]
A = { type = "revolute", parent = "ground", child = "a", drive = false, start = 0.3 }
B = { type = "revolute", parent = "a", child = "b", origin = [1, 0, 0], drive = false, start = 0.7 }
[springs.s]
joint = "A"
stiffness = 1e12
[springs.r]
joint = "B"
stiffness = 1e10
"""


@pytest.mark.long
@pytest.mark.mends("30.also.lessons")
@pytest.mark.parametrize("formulation", ["lagrange", "dalembert"])
def test_a_lesson_of_stiff_springs_is_not_stopped_by_rounding(formulation: str) -> None:
    assert walkthrough(read_text(STIFF), formulation=formulation).sections
