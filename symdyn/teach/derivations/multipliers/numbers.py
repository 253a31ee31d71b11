"""Steps: multipliers and drives in numbers, and the check by energy: conditions do no work."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra import Form, Symbol
from symdyn.graph import tangents
from symdyn.scene import SceneUnits
from symdyn.scene.values import force_unit
from symdyn.teach.derivations.multipliers.balance import unit_of, valued
from symdyn.teach.derivations.multipliers.conditions import multiplier
from symdyn.teach.derivations.multipliers.constrained import Constrained
from symdyn.teach.document import Block, Formula, Step, Words
from symdyn.teach.lesson import named
from symdyn.teach.shown_state import Chosen, rates_of

SMALL = 1e-9


def forces_step(lesson: Constrained, chosen: Chosen) -> Step:
    """Return the multipliers and the drives at the chosen state."""
    rows = []
    units = [force_unit(unit) for unit in SceneUnits(lesson.scene).velocities]
    for own, unit in zip(lesson.scene.drives, units, strict=True):
        if own:
            node = lesson.names[own].node
            assert node is not None, "a drive has a value"
            rows.append((Symbol(own), lesson.about(chosen.of(node)[0]), unit))
    for tie in lesson.ties:
        rows.append(
            (multiplier(tie), lesson.about(chosen.of(valued(lesson, multiplier(tie)))[0]), unit_of(tie, lesson.scene))
        )
    if not rows:
        return Step("forces", lesson.say("forces.none"), ())
    table = lesson.table(("symbol", "value", "unit"), rows)
    return Step("forces", lesson.say("forces"), (table,), lesson.say("forces.reason"), show=("reactions", "forces"))


def tied_power_step(lesson: Constrained, right: Sequence[Form], chosen: Chosen) -> Step:
    """Return d/dt (K + P) = Σ (drive + Q) u + Σ λ_k ḟ_k, whose last sum vanishes; no multiplier is in `right`."""
    state = lesson.state
    total = lesson.energy.K + lesson.energy.P
    (rate,) = tangents([total], state.acceleration)
    lesson.name("E:", "E", node=total)
    symbol = lesson.rate("E:", rate)
    power = [force.signed_product(named(u)) for force, u in zip(right, state.qd, strict=True) if force.terms]
    held = [Form.product((multiplier(tie), Symbol(tie.rate))) for tie in lesson.ties]
    left, *parts = chosen.of(rate, *(valued(lesson, form) for form in (*power, *held)))
    size = SMALL * (1 + sum(map(abs, (*parts, *rates_of(lesson.energy, state, chosen)))))
    assert abs(left - sum(parts)) <= size, "the power of all forces is not d/dt (K + P)"
    assert sum(map(abs, parts[len(power) :])) <= size, "a condition does work"
    value, done = (0.0 if abs(x) <= size else x for x in (left, sum(parts[: len(power)])))
    idle = any(lesson.scene.drives[k] is None for k in lesson.partition.independent)  # then only in its own motion
    whole = Form.sum([*power, *held])
    blocks: list[Block] = [
        Formula("E:", Form.sum((Symbol("K:"), Symbol("P:")))),
        Words((symbol, " = ", whole)) if idle else Formula(symbol.name, whole),
        lesson.say("tied.power.numbers", left=symbol, value=lesson.equals(value), done=lesson.about(done)),
    ]
    reason = lesson.say("tied.power.reason" if lesson.ties else "power.reason")
    return Step("power", lesson.say("tied.power"), tuple(blocks), reason, show=("energies",))
