"""The sign of each key that acts, as docs/scenes.md tells it: a cart of 1 kg in a run at q = 0.3 m, 2 m/s."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

import symdyn
from symdyn.scene.declaration.declare import schema
from symdyn.scene.toml import read_text

pytestmark = pytest.mark.runs("cc")

SCENE = """gravity = "none"
[bodies.cart]
mass = 1
[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "q"
{joint}
{table}
"""

FAR = 'from = { body = "ground", at = [-1, 0, 0] }\nto = "cart"\n'
"""Ends 1.3 m apart, of which the distance grows with q."""

LAWS = {
    "a spring at a joint": ("", '[springs.s]\njoint = "slide"\nstiffness = [5, 2]\nfree = 0.1\npreload = 3',
                            -(3 + 5 * 0.2 + 2 * 0.2**2)),
    "a preload alone": ("", '[springs.s]\njoint = "slide"\npreload = "-1500 N"', 1500),
    "a spring between points": ("", f"[springs.s]\n{FAR}stiffness = 5\nfree = 1\npreload = 3", -(3 + 5 * 0.3)),
    "a damper at a joint": ("", '[dampers.d]\njoint = "slide"\ndamping = [4, 0.5]', -(4 * 2 + 0.5 * 2**3)),
    "a damper between points": ("", f"[dampers.d]\n{FAR}damping = 4", -4 * 2),
    "damping of a joint": ("damping = 4", "", -4 * 2),
    "friction of a joint": ("friction = { coulomb = 6, static = 9, stribeck = 1, smoothing = 0.5 }", "",
                            -(6 + 3 * math.exp(-(2**2))) * math.tanh(2 / 0.5)),
    "a force of a joint": ("force = 7", "", 7),
    "a load on a body": ("", '[loads.w]\nbody = "cart"\nforce = [7, 0, 0]', 7),
}  # fmt: skip


@pytest.mark.parametrize(("joint", "table", "acts"), LAWS.values(), ids=LAWS)
def test_each_key_acts_with_the_sign_that_is_told(joint: str, table: str, acts: float) -> None:
    scene = read_text(SCENE.format(joint=joint, table=table))
    run = symdyn.simulate(scene, start={"q": 0.3}, start_rates={"q": 2}, until=1e-3, forces={"tau1": 10}, method="rk45")
    assert run["q_ddot"][0] == pytest.approx(10 + acts)


def test_a_couple_turns_right_handed() -> None:
    text = SCENE.replace('"prismatic"', '"revolute"').replace("mass = 1", "inertia = [1, 1, 1]")
    scene = read_text(text.format(joint="", table='[loads.w]\nbody = "cart"\ncouple = [7, 0, 0]'))
    assert symdyn.simulate(scene, until=1e-3, method="rk45")["q_ddot"][0] == pytest.approx(7)


def test_limits_are_told_as_they_stop_a_run() -> None:
    scene = read_text(SCENE.format(joint="limits = { lower = -0.1, upper = 0.4 }", table=""))
    for rate, end in ((2, 0.4), (-2, -0.1)):
        with pytest.warns(RuntimeWarning, match="limit"):
            run = symdyn.simulate(scene, start_rates={"q": rate}, until=1)
        assert run["q"][-1] == pytest.approx(end)


def test_each_key_with_a_sign_has_its_law_in_the_pages_and_in_the_schema() -> None:
    page = (Path(__file__).parents[1] / "docs/scenes.md").read_text(encoding="utf-8")
    section = page[page.index("## Springs, dampers") : page.index("## Ropes")]
    for key in ("preload", "free", "damping", "friction", "force", "couple", "drive", "limits", "motion"):
        assert re.search(rf"`{key}`", section), key
    sections = schema()["properties"]
    keys = {section: sections[section]["additionalProperties"]["properties"] for section in ("springs", "dampers")}
    assert "Q = -(preload + k1 x" in keys["springs"]["preload"]["description"]
    assert "x = 0" in keys["springs"]["free"]["description"]
    assert "Q = -(c1 v" in keys["dampers"]["damping"]["description"]
    joint = str(sections["joints"])
    for law in ("Q = -damping * rate", "towards growing q", "against the rate", "lower <= q <= upper"):
        assert law in joint, law
