"""One freedom whose equation knows no position: its motion in time as the lesson has it, against a run."""

from __future__ import annotations

import pytest

import symdyn
from symdyn.algebra import Floats
from symdyn.graph import Graph, evaluate
from symdyn.scene import Scene
from symdyn.scene.toml import read_text
from symdyn.teach.document import Formula, Step
from tests.lessons import lesson_of

WINCH = """
name = "winch"
gravity = [0, "-g", 0]
[parameters]
m = "40 kg"
r = "0.2 m"
J = { value = 1.5, unit = "kg m^2" }
b = { value = 2, unit = "N m s/rad" }
g = "9.81 m/s^2"
[bodies.drum]
mass = 1
inertia = ["J", "J", "J"]
[bodies.load]
mass = "m"
[joints.shaft]
type = "revolute"
parent = "ground"
child = "drum"
axis = [0, 0, 1]
coordinate = "phi"
drive = "M"
damping = "b"
[joints.lift]
type = "prismatic"
parent = "ground"
child = "load"
axis = [0, 1, 0]
mimic = { joint = "shaft", ratio = "r" }
"""


FREE, CALM = ('drive = "M"', "drive = false"), ('damping = "b"\n', "")
LIGHT = ('gravity = [0, "-g", 0]', 'gravity = "none"')


def winch(*changes: tuple[str, str]) -> Scene:
    text = WINCH
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return read_text(text, "winch")


def told(scene: Scene) -> list[Step]:
    return [step for part in lesson_of(scene).sections for step in part.steps if step.key == "uniform"]


@pytest.mark.runs("cc")
@pytest.mark.parametrize("changes", [(), (FREE,), (CALM,), (FREE, CALM), (FREE, LIGHT), (CALM, LIGHT)])
def test_the_motion_in_time_is_that_of_a_run(changes: tuple[tuple[str, str], ...]) -> None:
    scene, torque = winch(*changes), 0.0 if FREE in changes else 95.0
    known = {"t": 0.8, "M": torque, "uniform:00": 0.3, "uniform:01": -0.4}
    known |= {"m": 40, "r": 0.2, "J": 1.5, "b": 2, "g": 9.81}
    forces = () if FREE in changes else f"M={torque}"
    run = symdyn.simulate(scene, forces=forces, until=0.8, rtol=1e-11, start="phi=0.3", start_rates="phi=-0.4")
    (step,) = told(scene)
    graph = Graph()
    for block in step.blocks:
        if isinstance(block, Formula) and block.right is not None:
            left = block.left or str(block.form.express(graph).value)
            at = {graph.symbol(x): float(y) for x, y in known.items()}
            known[left] = float(evaluate([block.right.express(graph)], Floats(), at)[0])
    assert known["phi_dot"] == pytest.approx(run["phi_dot"][-1], rel=1e-8)
    assert ("phi" in known) == (CALM in changes)
    assert known.get("phi", run["phi"][-1]) == pytest.approx(run["phi"][-1], rel=1e-8)


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    "change",
    [
        ('damping = "b"', "friction = { coulomb = 0.5, smoothing = 0.01 }"),
        ('damping = "b"', 'damping = "b"\nforce = "-2*phi"'),
        ('damping = "b"', 'force = "b*phi_dot"'),
        ('damping = "b"', 'force = "-2*sign(phi_dot)"'),
        ('damping = "b"', 'damping = "b"\nforce = "-2*sign(phi_dot)"'),
        ('damping = "b"', 'force = "if(phi_dot > 1, -2, 0)"'),
        ('damping = "b"', "friction = { coulomb = 0.5 }"),
        ("[bodies.drum]", '[inputs.u]\nunit = "N m"\n[loads.wind]\nbody = "drum"\ncouple = [0, 0, "u"]\n[bodies.drum]'),
        ('drive = "M"', 'drive = "M"\nmotion = "2*t"'),
    ],
)
def test_what_is_no_such_motion_has_no_step(change: tuple[str, str]) -> None:
    assert not told(winch(change))
