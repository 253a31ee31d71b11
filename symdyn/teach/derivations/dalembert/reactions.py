"""Steps: reactions and drives, solved for and in numbers, and the proof that Lagrange gives the same drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np

from symdyn.algebra import Number
from symdyn.dynamics import derive_one
from symdyn.dynamics.reactions import Unknown
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.table import Table
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.dalembert.shown_motion import determined, no_motion, solved_at
from symdyn.teach.derivations.lagrange.velocities import PAGE, folded, length
from symdyn.teach.document import Block, Formula, Step, Words
from symdyn.teach.lesson import together
from symdyn.teach.shown_state import Chosen
from symdyn.verdict import Verdict
from symdyn.verify import Claim, claims_of_reactions, prove


def solved_steps(lesson: Balance) -> list[Step]:
    """Return every unknown solved for, of an open mechanism; closed ones have numbers only."""
    if lesson.solved is None:
        return []
    blocks: list[Block] = []
    for symbol, node in zip(lesson.unknowns, lesson.solved, strict=True):
        formula = Formula(symbol.name, lesson.short(node))
        blocks.append(formula if length(formula.form) <= PAGE else folded(lesson, formula))
    return [Step("solved", lesson.say("solved"), tuple(blocks), lesson.say("solved.reason"))]


def numbers_step(lesson: Balance, chosen: Chosen) -> Step:
    """Return every unknown at the chosen state, from A x + b = 0 in numbers."""
    x, unique = solved_at(lesson, chosen)
    rows = []
    for symbol, one, value in zip(lesson.unknowns, lesson.system.unknowns, x, strict=True):
        force = lesson.workspace.hanging.samples.at([*one.acts[0][1][0]], 2)
        rows.append((symbol, lesson.written(float(value)), "N" if abs(force).max() > 1e-12 else "N m"))
    where = lesson.say("reactions.closed" if lesson.closed else "reactions.open")
    blocks: list[Block] = [where, lesson.table(("symbol", "value", "unit"), rows)]
    if not unique:
        blocks.append(lesson.say("reactions.least"))
    return Step("reactions", lesson.say("reactions"), tuple(blocks), lesson.say("reactions.reason"))


def formulations_step(lesson: Balance, chosen: Chosen) -> Step | None:
    """Return the proof over finite fields that both methods give the same drives, and their numbers; None without.

    Where there are no drives to compare, that is the proof of what holds of the reactions, and no word of another
    method.
    """
    drives = {u: one for u, one in enumerate(lesson.system.unknowns) if one.is_drive}
    if lesson.solved is not None:
        other = dict(zip(drives, _driven(lesson), strict=True))
        left = _left(lesson, lesson.solved)
        laws = {
            "formulations.open": Claim("equilibrium", "A x + b", "0", tuple(left), (lesson.graph.zero,) * len(left))
        }
        found = tuple(lesson.solved[u] for u in other)
        same = Claim("drives", "D'Alembert", "Lagrange", found, tuple(other.values()))
    else:
        other = _multiplied(lesson, drives, chosen)
        laws = {f"formulations.{name}": claim for name, claim in claims_of_reactions(lesson.workspace).items()}
        last = len(lesson.system.unknowns)
        given = [{u: lesson.graph.one, last: force} for u, force in other.items()]
        same = Claim.solvable("drives", "Lagrange", "D'Alembert", [*lesson.proved.rows(), *given], last)
    claims = {**({"formulations.drives": same} if other else {}), **laws}
    fields, findings = prove(list(claims.values()), positive=[p.name for p in lesson.scene.parameters if p.positive])
    assert all(one.verdict != Verdict.DIFFERENT for one in findings), "the two formulations differ"
    proved = {key: one for key, one in zip(claims, findings, strict=True) if one.verdict == Verdict.PROVED}
    if not proved:
        return None
    other = other if "formulations.drives" in proved else {}
    said = [key for key in proved if lesson.closed or key != "formulations.drives"]
    how = lesson.say(
        "formulations.proved",
        points=str(fields.points),
        primes=str(len(fields.primes)),
        chance=Number(Fraction(10)).power(int(max(one.error_log10 for one in proved.values()))),
    )
    blocks: list[Block] = [*map(lesson.say, said)]
    if not other:
        return Step("formulations", lesson.say("formulations.laws"), (*blocks, how))
    compared = lesson.say("formulations.compared", names=together([lesson.unknowns[u] for u in other]))
    blocks.append(Words((*compared.parts, " ", *how.parts)))
    blocks += [lesson.say("formulations.numbers"), _compared(lesson, chosen, other)]
    return Step("formulations", lesson.say("formulations"), tuple(blocks), lesson.say("formulations.reason"), "(5.21)")


def _compared(lesson: Balance, chosen: Chosen, other: Mapping[int, Expr]) -> Table[Words]:
    """Return every drive at the chosen state by both methods."""
    x, _ = solved_at(lesson, chosen)
    values = chosen.of(*other.values())
    worst = max(abs(x[u] - value) for u, value in zip(other, values, strict=True))
    size = max(*map(abs, values), np.abs(x).max())
    if worst > 1e-8 * (1 + size):  # they are proved equal: this is next to a singular position
        raise DerivationError(no_motion(lesson))
    rows = [
        (lesson.unknowns[u], lesson.written(float(x[u])), lesson.written(value))
        for u, value in zip(other, values, strict=True)
    ]
    return lesson.table(("symbol", "dalembert", "lagrange"), rows)


def _multiplied(lesson: Balance, drives: Mapping[int, Unknown], chosen: Chosen) -> dict[int, Expr]:
    """Return what Lagrange's equations with multipliers ask of the drives that the scene has; {} where that is open."""
    scene = lesson.scene
    try:
        tau = derive_one(lesson.workspace, "inverse_dynamics", "lagrange").entries
    except DerivationError:  # the drives do not fit the loops
        return {}
    places = [(joint.name, k) for joint in scene.joints for k in range(len(joint.rates))]
    found = dict(zip(places, tau, strict=True))
    passive = lesson.system.passive
    asked = {u: found[one.joint, one.number] for u, one in drives.items() if one not in passive}
    return asked if determined(lesson, chosen, list(asked)) else {}


def _driven(lesson: Balance) -> list[Expr]:
    """Return Lagrange's driving forces of the velocities that have an unknown drive, in the order of the joints."""
    forces = iter(lesson.workspace.energy.driving_forces())
    wanted = {(one.joint, one.number) for one in lesson.system.unknowns if one.is_drive}
    pairs = [(joint.name, k) for joint in lesson.scene.joints for k in range(len(joint.rates))]
    return [force for pair, force in zip(pairs, forces, strict=True) if pair in wanted]


def _left(lesson: Balance, x: Sequence[Expr]) -> list[Expr]:
    """Return A x + b."""
    rows = zip(lesson.system.matrix(), lesson.system.right(), strict=True)
    return [lesson.graph.total([b, *(a * y for a, y in zip(row, x, strict=True))]) for row, b in rows]
