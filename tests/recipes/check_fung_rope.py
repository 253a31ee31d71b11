"""What a rope from outside is worth: one file, one row, and it goes around wheels as symdyn's own do.

`tests/test_recipes.py` runs this in a fresh process, where the kind is one file that is imported here.
"""

from __future__ import annotations

import numpy as np
import pytest
from fung_rope import FungRope

import symdyn
from symdyn.errors import SymdynError
from symdyn.scene import parse, read_text, write_text
from symdyn.scene.values.entry import entry
from symdyn.teach import walkthrough

pytestmark = pytest.mark.runs  # motions are compiled where there is a compiler

HOIST = """name = "hoist"
[parameters]
T0 = { value = 3, unit = "N" }
[bodies.load]
mass = 2
[joints.slide]
type = "prismatic"
parent = "ground"
child = "load"
origin = [0.5, 0, 0]
axis = [0, 0, -1]
coordinate = "x"
drive = false
start = 2
[points.hook]
body = "ground"
at = [-1, 0, 0.5]
[ropes.tendon]
type = "fung"
through = ["hook", { body = "ground", radius = 0.5, axis = [0, 1, 0], turn = "left" }, "load"]
tension = "T0"
rise = 4
free = 3
"""

LENGTH = 1 + np.pi / 4 + 2


def refusal(text: str) -> str:
    with pytest.raises(SymdynError) as refused:
        read_text(text)
    return str(refused.value)


def test_it_is_read_written_declared_and_checked() -> None:
    one = read_text(HOIST)

    (rope,) = one.elements
    assert isinstance(rope, FungRope)
    assert (rope.tension, rope.rise) == (parse("T0"), parse("4"))
    assert read_text(write_text(one, "toml").text) == one
    assert entry("ropes", "tendon", type="fung", through=["a", "b"], tension=1).name == "tendon"
    assert "tension is missing; write tension = 10" in refusal(HOIST.replace('tension = "T0"\n', ""))
    assert "rise = 0 does not stiffen; give one above zero" in refusal(HOIST.replace("rise = 4", "rise = 0"))


def test_its_force_is_that_of_its_length_around_the_wheel() -> None:
    one = read_text(HOIST)
    tension = 3 * (np.exp(4 * (LENGTH - 3) / 3) - 1)

    a, pull = symdyn.lambdify(one, ("forward_dynamics", "tension:tendon"))
    assert pull([2], [0], [0]) == pytest.approx(tension)
    assert a([2], [0], [0])[0] == pytest.approx(9.81 - tension / 2)
    assert symdyn.certify(one).passed


def test_a_run_keeps_its_energy_and_tells_its_tension() -> None:
    run = symdyn.simulate(read_text(HOIST), until=0.5, start={"x": 2.2})

    assert run.monitors["energy"] < 1e-8 * run.monitors["energy_scale"]
    assert run.monitors["tension tendon"] > 0


def test_pictures_and_lessons_show_it() -> None:
    one = read_text(HOIST)

    assert 'class="fung"' in str(symdyn.picture(one))
    for language, words in (("en", "tendon"), ("sk", "šľacha")):
        assert words in str(walkthrough(one, language=language))
