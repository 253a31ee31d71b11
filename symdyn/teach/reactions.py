"""Steps: reactions and drives, solved for and in numbers, and the proof that Lagrange's road gives the same drives."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from symdyn.algebra.form import Form, Number, power_of
from symdyn.algebra.numeric import Floats
from symdyn.dynamics.lagrange import driving_forces
from symdyn.dynamics.reactions.dalembert import DRIVE, Unknown
from symdyn.graph import Expr, evaluate
from symdyn.teach.balance import Balance
from symdyn.teach.document import (
    Block,
    Fold,
    Formula,
    Step,
    Values,
    Words,
)
from symdyn.teach.lesson import together
from symdyn.teach.numbers import Chosen, written
from symdyn.teach.velocities import PAGE, length
from symdyn.verify.equality import PROVED, Claim, prove
from symdyn.verify.laws_of_reactions import LAWS_OF_REACTIONS


def solved_steps(lesson: Balance) -> list[Step]:
    """Return every unknown solved for, of an open mechanism; closed ones have numbers only."""
    if lesson.solved is None:
        return []
    blocks: list[Block] = []
    for symbol, node in zip(lesson.unknowns, lesson.solved, strict=True):
        form = lesson.short(node)
        formula = Formula(symbol.name, form)
        long = lesson.say("long", name=symbol, terms=str(length(form)))
        blocks.append(formula if length(form) <= PAGE else Fold(long, (formula,)))
    return [Step("solved", lesson.say("solved"), tuple(blocks), lesson.say("solved.reason"))]


def numbers_step(lesson: Balance, chosen: Chosen) -> Step:
    """Return every unknown at the chosen state, from A x + b = 0 in numbers."""
    A, b = lesson.system.matrix(), lesson.system.right()
    flat = [x for row in A for x in row]
    found = evaluate([*flat, *b], Floats(), chosen.values)
    size = (len(A), len(lesson.unknowns))
    matrix, right = np.array(found[: len(flat)], dtype=float).reshape(size), np.array(found[len(flat) :], dtype=float)
    x, _, rank, _ = np.linalg.lstsq(matrix, -right, rcond=1e-10)
    x = np.where(np.abs(x) < 1e-9 * (np.abs(x).max() or 1.0), 0.0, x)
    rows = []
    for symbol, one, value in zip(lesson.unknowns, lesson.system.unknowns, x, strict=True):
        unit = _unit(lesson, one)
        rows.append((Words((symbol,)), Words((written(float(value)),)), Words((unit,))))
    head = (lesson.say("table.symbol"), lesson.say("table.value"), lesson.say("table.unit"))
    where = lesson.say("reactions.moving" if not lesson.closed else "reactions.rest")
    unique = rank == len(x)
    blocks: list[Block] = [where, Values(head, tuple(rows))]
    if not unique:
        blocks.append(lesson.say("reactions.least"))
    return Step("reactions", lesson.say("reactions"), tuple(blocks), lesson.say("reactions.reason"))


def _unit(lesson: Balance, one: Unknown) -> str:
    """Return N for what has a force at unit size, else N m."""
    force = lesson.workspace.hanging.samples.at([*one.acts[0][1][0]], 2)
    return "N" if abs(force).max() > 1e-12 else "N m"


def roads_step(lesson: Balance) -> Step:
    """Return the proof that D'Alembert's drives are those of the other road, over finite fields."""
    w = lesson.workspace
    if lesson.solved is not None:
        drives = [x for x, one in zip(lesson.solved, lesson.system.unknowns, strict=True) if one.kind == DRIVE]
        claims = [Claim("drives", "D'Alembert", "Lagrange", tuple(drives), tuple(_driven(lesson)))]
        left = _left(lesson, lesson.solved)
        claims.append(Claim("equilibrium", "A x + b", "0", tuple(left), (lesson.graph.zero,) * len(left)))
    else:
        claims = [claim for _, law in LAWS_OF_REACTIONS if (claim := law(w)) is not None]
    fields, findings = prove(claims, positive=[p.name for p in lesson.scene.parameters if p.positive])
    assert all(one.verdict == PROVED for one in findings), "the two roads differ, or cannot be compared exactly"
    chance = max(one.error_log10 for one in findings)
    key = "roads.open" if lesson.solved is not None else "roads.closed"
    names: list[Form] = [s for s, one in zip(lesson.unknowns, lesson.system.unknowns, strict=True) if one.kind == DRIVE]
    said = lesson.say(
        key,
        names=together(names),
        points=str(fields.points),
        primes=str(len(fields.primes)),
        chance=power_of(Number(Fraction(10)), int(chance)),
    )
    return Step("roads", lesson.say("roads"), (said,), lesson.say("roads.reason"), "(5.21)")


def _driven(lesson: Balance) -> list[Expr]:
    """Return Lagrange's driving forces of the velocities that have an unknown drive, in the order of the joints."""
    forces = iter(driving_forces(lesson.workspace.energy))
    wanted = {(one.joint, one.number) for one in lesson.system.unknowns if one.kind == DRIVE}
    pairs = [(joint.name, k) for joint in lesson.scene.joints for k in range(len(joint.rates))]
    return [force for pair, force in zip(pairs, forces, strict=True) if pair in wanted]


def _left(lesson: Balance, x: Sequence[Expr]) -> list[Expr]:
    """Return A x + b."""
    rows = zip(lesson.system.matrix(), lesson.system.right(), strict=True)
    return [lesson.graph.total([b, *(a * y for a, y in zip(row, x, strict=True))]) for row, b in rows]
