"""Wheels that roll on the ground, written in the axes of the body that rolls, where nothing is long.

n        the plane's normal, in the body's axes: letters n1, n2, n3, whose squares add up to 1; ṅ = n × ω
a, r, P  axis, radius and centre of the wheel                   w      |a × n|, the sine of its lean
d        from P to the lowest point: -(r/w) (n - (n·a) a)       c      velocity of that point: v_P + ω × d
t        along the track: (a × n) / w                           n × t  across it
"""

from __future__ import annotations

from dataclasses import replace

from symdyn.dynamics.mechanism import vector
from symdyn.graph import Expr, gradient, tangents
from symdyn.scene import Scene
from symdyn.scene.joints import unit
from symdyn.scene.values import Contact
from symdyn.spatial import Vec, add, cross, dot, scale, sub
from symdyn.teach.derivations.multipliers.condition import Condition
from symdyn.teach.derivations.multipliers.constrained import Constrained
from symdyn.teach.document import Letter

WAYS = {"tie.force along the track": 0, "tie.force across the track": 1, "tie.normal force": 2}


def rolls(row: Contact) -> bool:
    """Tell whether a contact is a wheel on the ground."""
    return row.plane.body == Scene.GROUND and row.axis is not None and row.radius is not None


def name_normal(lesson: Constrained, row: Contact) -> None:
    """Name the plane's normal in the axes of the body that rolls."""
    number = str([one.name for one in lesson.scene.contacts].index(row.name) + 1)
    several = len(lesson.scene.contacts) > 1
    entries = lesson.placed[row.place.body].R.T @ unit(row.plane.normal, lesson.graph)
    for k, node in enumerate(entries, 1):
        lesson.letter(f"n:{row.name},{k}", Letter("n", (number, str(k)) if several else (str(k),)), node)


def normal(lesson: Constrained, row: Contact) -> Vec:
    """Return the letters of the plane's normal."""
    x, y, z = (lesson.graph.symbol(f"n:{row.name},{k}") for k in (1, 2, 3))
    return x, y, z


def in_letters(lesson: Constrained, row: Contact, tie: Condition, twist: tuple[Vec, Vec]) -> Condition:
    """Return a condition of a wheel with what is shown of it in letters; the body's `twist` is (v, ω), in its axes."""
    graph, u = lesson.graph, lesson.state.qd
    assert row.axis is not None, "a wheel has an axis"
    assert row.radius is not None, "a wheel has a radius"
    n, (v, omega) = normal(lesson, row), twist
    a, r, P = unit(row.axis, graph), row.radius.express(graph), vector(row.place.at, graph)
    lean = cross(a, n)
    w = graph.sqrt(dot(lean, lean))
    d = scale(-r / w, sub(n, scale(dot(n, a), a)))
    c = add(add(v, cross(omega, P)), cross(omega, d))
    t = scale(1 / w, lean)
    power = dot((t, cross(n, t), n)[WAYS[tie.words]], c)
    slopes = gradient(power, u)
    rates = dict(zip(n, cross(n, omega), strict=True)) | lesson.state.velocity
    (bias,) = tangents([power], rates)
    shown: list[Expr] = [*slopes, bias]
    if tie.residual is not None:
        height = dot(unit(row.plane.normal, graph), sub(lesson.placed[row.place.body].p, vector(row.plane.at, graph)))
        shown.append(height + dot(n, P) - r * w)
    return replace(tie, shown=tuple(shown))
