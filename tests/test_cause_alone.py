"""A mistake in a scene is told by its cause alone, and what its line says to write is a scene when it is copied."""

from __future__ import annotations

import pytest

from symdyn.errors import SceneError
from symdyn.scene.toml import read_text

ROD = """[parameters]
m = "2 kg"
l = "400 mm"
k = "3 N m/rad"
[inputs.shake]
unit = "m"
[bodies.cart]
mass = "5 kg"
[bodies.rod]
mass = "m"
com = [0, 0, "-l/2"]
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
coordinate = "x"
[joints.hinge]
type = "revolute"
parent = "cart"
child = "rod"
axis = [0, 1, 0]
coordinate = "phi"
[springs.coil]
joint = "hinge"
stiffness = "k"
[outputs]
way = "phi"
"""

HEADER = ROD[: ROD.index("[inputs")]

WRONG = {
    "a star left out": ('"-l/2"', '"-0.5 l"', '"-0.5 l" is not a usable value: l is no unit; write -0.5*l', '"-0.5*l"'),
    "powers": ('"-l/2"', '"2 l^2"', "l is no unit; write 2*l**2", '"2*l**2/l"'),
    "a letter that a unit has in capitals": ('"-l/2"', '"-2 a"', "did you mean A? or write -2*a", '"-2*l"'),
    "no such point": ('way = "phi"', 'way = "point_tip_x"',
                      'uses point_tip_x, of no point; write [points.tip] with body = "rod"',
                      'way = "point_tip_x"\n[points.tip]\nbody = "rod"'),
    "a mass by an input": ('mass = "m"', 'mass = "m*shake"',
                           'changes by a state: write mass = "m_rod" and [states.m_rod] with rate = -0.1, start = 1, '
                           'unit = "kg", and [flows.rod] with body = "rod", velocity = [0, 0, 0]',
                           'mass = "m_rod"\n[states.m_rod]\nrate = -0.1\nstart = 1\n'
                           'unit = "kg"\n[flows.rod]\nbody = "rod"\nvelocity = [0, 0, 0]\n'),
    "parameters without a header": ("[parameters]\n", "", 'unknown key "m"; write [parameters] above m, l, k',
                                    "[parameters]\n"),
    "a parameter above its header": ("[parameters]\n", "r = 2\n[parameters]\n",
                                     'unknown key "r"; move it below [parameters]: r', "[parameters]\nr = 2\n"),
    "a list of tables": ("[joints.rail]\n", '[[joints]]\nname = "rail"\n',
                         "[[joints]] is a list of tables; write [joints.rail] without name", "[joints.rail]\n"),
    "parameters without a header, and a head behind them": (
        HEADER, HEADER.replace("[parameters]\n", "") + 'name = "rod"\ngravity = [0, 0, -9.81]\n',
        'unknown key "m"; write [parameters] below name, gravity and above m, l, k',
        'name = "rod"\ngravity = [0, 0, -9.81]\n\n' + HEADER),
    "a plain word above all tables": (HEADER, f'author = "me"\n{HEADER}', 'unknown key "author"; known are',
                                      f'text = "me"\n\n{HEADER}'),
    "a section misspelt": ("[springs.coil]", "[spring.coil]", 'unknown key "spring"; did you mean springs?',
                           "[springs.coil]"),
    "a joint and an end": ('joint = "hinge"\n', 'joint = "hinge"\nfrom = "cart"\nto = "rod"\n',
                           'has joint and from and to; write joint = "NAME"', 'joint = "hinge"\n'),
    "a negative mass": ('mass = "m"',
                        'mass = "m - 3"\ninertia = ["(m - 3)*l**2", "(m - 3)*l**2", 0]\ninertia_about = "com"',
                        "bodies.rod: mass = m - 3 = -1 is negative; correct m", 'mass = "m"'),
    "a place in a plane": ('coordinate = "phi"', 'coordinate = "phi"\norigin = ["l", 0]',
                           'origin = ["l", 0] has 2 entries; three are needed',
                           'coordinate = "phi"\norigin = ["l", 0, 0]'),
    "a rate at the start": ('coordinate = "phi"', 'coordinate = "phi"\nstart_rate = 8', "it is start_rates = 8",
                            'coordinate = "phi"\nstart_rates = 8'),
    "a child that is the ground": ('child = "cart"', 'child = "ground"', 'joints.rail: joins "ground" with itself',
                                   'child = "cart"'),
    "an unknown leader": ('coordinate = "phi"', 'coordinate = "phi"\nmimic = { joint = "wheel" }',
                          'mimic.joint = "wheel" is not a joint; known are hinge, rail', 'coordinate = "phi"'),
}  # fmt: skip


@pytest.mark.parametrize(("right", "wrong", "told", "cure"), WRONG.values(), ids=WRONG)
def test_only_the_cause_is_told_and_its_cure_is_a_scene(right: str, wrong: str, told: str, cure: str) -> None:
    assert right in ROD
    with pytest.raises(SceneError) as refused:
        read_text(ROD.replace(right, wrong))
    (fault,) = refused.value.faults
    assert told in fault
    line, _, tables = cure.partition("\n[")  # tables stand behind the others
    assert read_text(ROD.replace(right, line) + f"[{tables}" * bool(tables))


def test_a_flow_is_silent_where_the_mass_is_told() -> None:
    leak = ROD.replace('mass = "m"', 'mass = "2 - t"') + '[flows.leak]\nbody = "rod"\nvelocity = [0, 0, 0]\n'
    with pytest.raises(SceneError) as refused:
        read_text(leak)
    (fault,) = refused.value.faults
    assert fault.endswith('write mass = "m_rod" and [states.m_rod] with rate = -0.1, start = 1, unit = "kg"')
