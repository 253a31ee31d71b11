"""A single mistake where a motion is prescribed is told alike by page and shell, its cause among the reasons."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from typing import Any

import pytest
import sympy
from test_student_answers import _benchmark

from symdyn.algebra import Form
from symdyn.dynamics.mechanism import prescribed
from symdyn.graph import Graph
from symdyn.scene import Scene, read_text
from symdyn.scene.values import acceleration_name
from symdyn.teach.student.course import Course

VALUES = {
    "m": "2 kg", "M": "5 kg", "l": "0.5 m", "h": "0.1 m", "a": "0.3 m", "e": "0.2 m", "J": "0.02 kg m^2",
    "W": "3 rad/s", "k": "40 N/m", "c": "0.1 N m s", "d": "0.3 N s/m", "g": "9.81 m/s^2",
    "v": "0.6 m/s", "eps": "1.5 rad/s^2",
}  # fmt: skip
DISC = 'inertia = ["J", "J", "J"]\ninertia_about = "com"'


def _joint(kind: str, parent: str, child: str, axis: str, more: str) -> str:
    return (
        f'[joints.{child}]\ntype = "{kind}"\nparent = "{parent}"\nchild = "{child}"\naxis = {axis}\n'
        + "\n".join(more.split("; "))
        + "\n"
    )


def _scene(name: str, gravity: str, bodies: dict[str, str], *joints: str) -> Scene:
    given = "".join(f'{x} = {{ value = "{y}", positive = true }}\n' for x, y in VALUES.items())
    each = "".join(f"[bodies.{body}]\n{text}\n" for body, text in bodies.items())
    return read_text(
        f'name = "{name}"\ngravity = {gravity}\n[parameters]\n{given}{each}{"".join(joints)}'
    ).as_parameters()


DOWN, LEVEL = '[0, "-g", 0]', '"none"'
LED = {
    "pivot": (DOWN, {"cart": "mass = 0", "bob": 'mass = "m"\ncom = [0, "-l", 0]'},
              _joint("prismatic", "ground", "cart", "[1, 0, 0]",
                     'coordinate = "s"; drive = "F"; motion = "h*sin(W*t)"'),
              _joint("revolute", "cart", "bob", "[0, 0, 1]", 'coordinate = "phi"; drive = false; damping = "c"')),
    "turntable": (LEVEL, {"table": DISC, "bead": 'mass = "m"'},
                  _joint("revolute", "ground", "table", "[0, 0, 1]",
                     'coordinate = "phi"; drive = "T"; motion = "W*t"'),
                  _joint("prismatic", "table", "bead", "[1, 0, 0]", 'coordinate = "s"; drive = false; damping = "d"'),
                  '[springs.coil]\njoint = "bead"\nstiffness = "k"\nfree = "a"\n'),
    "boom": (LEVEL, {"boom": DISC, "paddle": f'mass = "m"\ncom = ["l", 0, 0]\n{DISC}'},
             _joint("revolute", "ground", "boom", "[0, 0, 1]",
                     'coordinate = "phi"; drive = "T"; motion = "eps*t**2/2"'),
             _joint("revolute", "boom", "paddle", "[0, 0, 1]",
                     'origin = ["e", 0, 0]; coordinate = "psi"; drive = "N"')),
    "hoist": (DOWN, {"arm": DISC, "load": 'mass = "m"'},
              _joint("revolute", "ground", "arm", "[0, 0, 1]", 'coordinate = "phi"; drive = false; damping = "c"'),
              _joint("prismatic", "arm", "load", "[0, -1, 0]", 'coordinate = "r"; drive = "S"; motion = "a - v*t"')),
    "rail": (DOWN, {"rail": 'mass = "M"', "rod": f'mass = "m"\ncom = [0, "-l", 0]\n{DISC}'},
             _joint("prismatic", "ground", "rail", "[0, 1, 0]",
                     'coordinate = "y"; drive = "F"; motion = "h*cos(W*t)"'),
             _joint("revolute", "rail", "rod", "[0, 0, 1]", 'coordinate = "phi"; drive = "N"; damping = "c"')),
}  # fmt: skip

CAUSES = {
    "sign": {"sign", "gravity-sign", "spring-sign", "damping-sign", "rate-product-missing"},
    "twice": {"factor", "damping-missing", "missing-term", "wrong-inertia"},
    "trig": {"wrong-function"},
    "drop": {
        "missing-term", "gravity-missing", "damping-missing", "moved-mass-missing", "rate-product-missing",
        "spring-free-length", "prescribed-motion-ignored", "cross-term-missing", "inertia-of-body-missing",
    },
}  # fmt: skip
CAUSES["prescribed"] = CAUSES["drop"]
"""What each mistake may be in the words of the sealed sets."""


def _wrong(scene: Scene, i: int, in_letters: bool) -> Iterator[tuple[str, str]]:
    """Yield mistakes of one term of what stands behind the box of an equation, with the motion put in or in letters."""
    course, given = Course(scene), prescribed(scene, Graph())
    rates = tuple(map(acceleration_name, scene.velocities))
    node = course.value(f"tau:{i}", course.right)
    assert node is not None
    terms = [one.to_sympy() for one in course.terms(node + course.right.Q[i - 1])]
    right = sum(terms)
    moved = zip(
        (scene.coordinates, scene.velocities, rates), (given.position, given.velocity, given.acceleration), strict=True
    )
    led = {names[k]: Form.of(x).to_sympy() for names, nodes in moved for k, x in zip(given.place, nodes, strict=True)}

    def written(wrong: Any) -> str:
        found = wrong if in_letters else wrong.subs({x: led[x.name] for x in wrong.free_symbols if x.name in led})
        return str(found).replace("**", "^")

    moving = {of[k] for of in (scene.velocities, rates) for k in given.place}
    for t in terms:
        if any(led[x.name] == 0 for x in t.free_symbols if x.name in moving):  # nothing, on the motion
            continue
        yield "sign", written(right - 2 * t)
        yield "twice", written(right + t)
        if len(terms) > 1:
            yield "drop", written(right - t)
        for f in [*t.atoms(sympy.sin, sympy.cos)][:1]:
            yield "trig", written(right - t + t.subs(f, (sympy.cos if f.func is sympy.sin else sympy.sin)(*f.args)))
    still = {x: 0 for x in right.free_symbols if x.name in moving}
    if any(led[x.name] != 0 for x in still) and right.subs(still) not in (0, right):
        yield "prescribed", written(right.subs(still))


@pytest.mark.slow
@pytest.mark.runs("node")
@pytest.mark.skipif(shutil.which("node") is None, reason="node is not there")
@pytest.mark.parametrize("name", LED)
def test_page_and_shell_tell_the_same_causes_where_a_motion_is_prescribed(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    benchmark, scene = _benchmark(monkeypatch), _scene(name, *LED[name])
    asked = [(f"tau:{i}", *one) for i in (1, 2) for in_letters in (True, False) for one in _wrong(scene, i, in_letters)]
    asked = asked[:: 1 + len(asked) // 50]
    page = benchmark.sealed_on_page([(key, text) for key, _, text in asked], scene)

    off = []
    for (key, kind, text), (first, _) in zip(asked, page, strict=True):
        shell, causes = benchmark.sealed_in_shell({"answer": text}, key, scene), CAUSES[kind]
        reasons = [{x for x in one.rules if x not in benchmark.VAGUE} for one in (shell, first)]
        named = [any(map(one.names, causes)) for one in (shell, first)]
        true = all(named) and (kind != "prescribed" or all("prescribed" in x for x in reasons))
        for some in reasons:  # of rates that are lost the page may say more
            some.difference_update({"slope"} if kind in ("drop", "prescribed") and "velocities" in some else ())
        false = {x for x in reasons[0] if causes.isdisjoint(benchmark.NAMES[x].split())}
        if not shell.verdict == first.verdict == "wrong" or reasons[0] != reasons[1] or false or not true:
            off.append(f"{key} {kind}: {text}: {shell.verdict} {shell.rules}, {first.verdict} {first.rules}")
    assert len(asked) > 20
    assert not off, "\n".join(off)
