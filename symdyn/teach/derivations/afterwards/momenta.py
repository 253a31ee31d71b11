"""Steps: coordinates that L does not know, the momenta that stay with them, and the energy that stays with time."""

from __future__ import annotations

from symdyn.algebra import Form, Number, Symbol
from symdyn.dynamics.mechanism import TIME, generalized_forces
from symdyn.emit.print import Printable
from symdyn.errors import DerivationError
from symdyn.graph import gradient, reachable
from symdyn.scene import Quantity
from symdyn.teach.derivations.afterwards.reduced import cyclic_of, led_by, reduced, zero
from symdyn.teach.derivations.lagrange.equation_steps import momentum_form
from symdyn.teach.derivations.lagrange.meaning import axes_of
from symdyn.teach.derivations.lagrange.velocities import folded
from symdyn.teach.document import Block, Formula, Step, Words
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.shown_state import Chosen


def momentum_steps(lesson: Lesson, page: Printable, chosen: Chosen) -> list[Step]:
    """Return a step a cyclic coordinate, or one that says why there is none; then what is said of the energy."""
    cyclic = cyclic_of(lesson)
    steps = [_cyclic(lesson, page, k, first=k == cyclic[0]) for k in cyclic] or [_none(lesson)]
    return [*steps, _energy(lesson, chosen)]


def _cyclic(lesson: Lesson, page: Printable, k: int, first: bool) -> Step:
    """Return the momentum of a coordinate, and what changes it."""
    state, q = lesson.state, named(lesson.state.q[k])
    p = lesson.name(f"p:{k + 1}", "p", str(k + 1), node=lesson.momenta[k])
    axis = axes_of(lesson)[k]
    blocks: list[Block] = [folded(lesson, Formula(p.name, momentum_form(lesson, k)))]
    if axis is not None and axis.joint.armature == Quantity.ZERO:
        key = "momentum.slide" if axis.slides else "momentum.turn"
        blocks.append(lesson.say(key, p=p, joint=axis.joint.name))
    right = page.right[k]
    key = "momentum.kept" if right == Number.ZERO else "momentum.driven"
    blocks.append(lesson.say(key, p=p, right=right, q=q, rate=lesson.rate(p.name, lesson.momentum_rates[k])))
    reason = lesson.say("momentum.noether") if first else Words(())
    claim = lesson.say("momentum.cyclic", q=q, p=p)
    show = ("momenta", f"joint:{_joint(lesson, k)}")
    assert str(state.q[k].value) == q.name, "a coordinate is called by its name"
    return Step(f"cyclic:{k + 1}", claim, tuple(blocks), reason, show=show)


def _joint(lesson: Lesson, k: int) -> str:
    """Return the joint of a velocity."""
    return [joint.name for joint in lesson.scene.moving for _ in joint.coordinates][k]


def _none(lesson: Lesson) -> Step:
    """Return why no coordinate is cyclic: whether it is gravity or springs alone that know one, or K too."""
    state, led = lesson.state, led_by(lesson)
    slopes = [(k, gradient(lesson.energy.K, [q])[0]) for k, q in enumerate(state.q) if k not in led]
    alone: list[Form] = [named(state.q[k]) for k, slope in slopes if zero(lesson, slope)]
    blocks: tuple[Block, ...] = (lesson.say("momentum.potential", names=together(alone)),) if alone else ()
    return Step("cyclic", lesson.say("momentum.none"), blocks, lesson.say("momentum.noether"), show=("momenta",))


def _energy(lesson: Lesson, chosen: Chosen) -> Step:
    """Return whether K + P stays, what takes or gives it, or what stays in its place where a motion is prescribed."""
    graph, scene = lesson.graph, lesson.scene
    show = ("energies", "plots")
    left, led = reduced(lesson, chosen), led_by(lesson)
    total = Form.sum((Symbol("K:"), Symbol("P:")))
    if led:
        if left is None:
            return Step("energy", lesson.say("energy.led", total=total), (), show=show)
        r, qd = left.q, lesson.state.qd[left.r]
        (p,) = gradient(lesson.energy.K, [qd])
        (m,) = gradient(p, [qd])
        node = m * qd * qd / 2 + left.static
        h = lesson.name("h:", "H", node=node)
        try:
            block = folded(lesson, Formula(h.name, lesson.short(node)))
        except (DerivationError, KeyError):
            return Step("energy", lesson.say("energy.led", total=total), (), show=show)
        claim = lesson.say("energy.jacobi", total=total, h=h, q=named(r))
        return Step("energy", claim, (block,), lesson.say("energy.jacobi.reason", h=h), show=show)
    acting = generalized_forces(scene, graph)
    timed = graph.symbol(TIME) in reachable([lesson.L, *acting])
    some = [named(q) for q, force in zip(lesson.state.q, acting, strict=True) if not force.is_zero]
    if timed:
        return Step("energy", lesson.say("energy.timed", total=total), (), show=show)
    if some:
        return Step("energy", lesson.say("energy.spent", total=total, names=together(some)), (), show=show)
    return Step(
        "energy", lesson.say("energy.kept", total=total), (), lesson.say("energy.reason", total=total), show=show
    )
