"""One line of comparison: Kane's form of an equation that Lagrange's method has derived.

    F_i = Σ m a · ∂v/∂q̇_i + Σ (I ω̇ + ω × I ω) · ∂ω/∂q̇_i + ∂P/∂q_i        sums over masses, ω and I in body axes

Reference: Kane and Levinson, Dynamics: Theory and Applications (1985), chapter 6.
"""

from __future__ import annotations

from symdyn.algebra import Form, Symbol
from symdyn.dynamics import rotor_energy
from symdyn.dynamics.mechanism import vector
from symdyn.emit.print import Printable
from symdyn.graph import Expr, gradient, tangents
from symdyn.spatial import add, cross
from symdyn.teach.derivations.lagrange.rotations import angular_velocity
from symdyn.teach.derivations.lagrange.velocities import folded
from symdyn.teach.document import Block, Formula, Step
from symdyn.teach.lesson import AXES, Lesson, Mass, named, together
from symdyn.teach.shown_state import Chosen

SMALL = 1e-9

TURNED = "dH:"
"""What keys of components of Ḣ begin with."""


def kane_steps(lesson: Lesson, page: Printable, chosen: Chosen) -> list[Step]:
    """Return Kane's form of the first equation that a mass has a share in; none where a body has a first moment.

    On the left stands what the page has there: the drive and what else acts.
    """
    if any(mass.h is not None for mass in lesson.masses):
        return []  # its origin is no centre of mass, so that the line would be another one
    i = next(
        (k for k in range(lesson.state.n) if not lesson.vanishes(gradient(lesson.energy.K, lesson.state.qd)[k])), 0
    )
    u, q = lesson.state.qd[i], lesson.state.q[i]
    forms: list[Form] = []
    nodes: list[Expr] = []
    for mass in lesson.masses:
        shares = _moved(lesson, mass, u) + _turned(lesson, mass, u)
        forms += [form for form, _ in shares]
        nodes += [node for _, node in shares]
    for joint in lesson.scene.joints:
        if joint.moves and not joint.armature.express(lesson.graph).is_zero:
            momentum = gradient(rotor_energy(joint, lesson.state.velocity, lesson.graph), [u])
            (node,) = tangents(momentum, lesson.state.acceleration)
            if (form := lesson.short(node)).terms:
                forms.append(form)
                nodes.append(node)
    slope = gradient(lesson.energy.P, [q])[0]
    if any(not x.is_zero for x in vector(lesson.scene.gravity, lesson.graph)) or not slope.is_zero:
        forms.append(lesson.slope("P:", str(q.value), slope))
        nodes.append(slope)
    whole = lesson.names[f"tau:{i + 1}"].node
    assert whole is not None, "an equation has a value"
    ours, truth = chosen.of(lesson.graph.total(nodes), whole)
    assert abs(ours - truth) <= SMALL * (1 + sum(map(abs, chosen.of(*nodes)))), "Kane's form is another equation"
    claim = lesson.say("kane", rate=named(u), left=page.right[i])
    blocks: list[Block] = [folded(lesson, Formula("", page.right[i], right=Form.sum(forms)))]
    if turned := [symbol for form in forms for symbol in form.factors if is_turned(symbol)]:
        blocks.append(lesson.say("kane.turned", rates=together(list(dict.fromkeys(turned)))))
    return [Step("kane", claim, tuple(blocks), lesson.say("kane.reason"), show=("accelerations", "velocities"))]


def is_turned(form: Form) -> bool:
    """Tell whether a factor is the rate of an angular momentum."""
    return isinstance(form, Symbol) and form.name.startswith(TURNED)


def _moved(lesson: Lesson, mass: Mass, u: Expr) -> list[tuple[Form, Expr]]:
    """Return m ẍ ∂ẋ/∂u by axes, with its values; none that vanishes."""
    if mass.m.is_zero:
        return []
    found, state = [], lesson.state
    for axis, place in zip(AXES, mass.place, strict=True):
        (velocity,) = tangents([place], state.velocity)
        partial = gradient(velocity, [u])[0]
        if lesson.vanishes(partial):
            continue
        (pushed,) = tangents([velocity], state.acceleration)
        lesson.name(f"d{axis}:{mass.tag}", axis, mass.tag, node=velocity, dots=1)
        a = lesson.name(f"dd{axis}:{mass.tag}", axis, mass.tag, node=pushed, dots=2)
        slope = lesson.slope(f"d{axis}:{mass.tag}", str(u.value), partial)
        found.append((Form.product((lesson.short(mass.m), a, slope)), mass.m * pushed * partial))
    return found


def _turned(lesson: Lesson, mass: Mass, u: Expr) -> list[tuple[Form, Expr]]:
    """Return Ḣ ∂ω/∂u by axes of the body: Ḣ = I ω̇ + ω × I ω."""
    if not mass.spins:
        return []
    w, state = angular_velocity(lesson, mass.body), lesson.state
    x, y, z = tangents(w, state.acceleration)
    moments = add(mass.inertia @ (x, y, z), cross(w, mass.inertia @ w))
    found = []
    for axis, rate, moment in zip(AXES, w, moments, strict=True):
        partial = gradient(rate, [u])[0]
        if lesson.vanishes(partial) or lesson.vanishes(moment):
            continue
        lesson.name(f"omega:{mass.tag}{axis}", "omega", mass.tag, axis, node=rate)
        H = lesson.name(f"{TURNED}{mass.tag}{axis}", "H", mass.tag, axis, node=moment, dots=1)
        slope = lesson.slope(f"omega:{mass.tag}{axis}", str(u.value), partial)
        found.append((Form.product((H, slope)), moment * partial))
    return found
