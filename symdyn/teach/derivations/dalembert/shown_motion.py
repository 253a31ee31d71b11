"""The state that D'Alembert's lesson shows, and its steps in numbers: reactions, drives, the proof against Lagrange.

Of a closed mechanism the state has rates and accelerations that the loops allow:

    G u = 0, G u̇ + Ġ u = 0      equations of the loops at the drawn position, and of prescribed motions

Rates of independent velocities are chosen, the others follow. What nothing drives (the spin of a rod between two balls,
a wheel that rolls down) is accelerated as it is without a drive.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
from scipy.linalg import null_space

from symdyn import verify
from symdyn.algebra import Array, Floats, Number
from symdyn.dynamics import derive_one
from symdyn.dynamics.mechanism import angles_of
from symdyn.dynamics.reactions import Unknown
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate
from symdyn.table import Table
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.velocities import PAGE, folded, length
from symdyn.teach.document import Block, Formula, Step, Words
from symdyn.teach.lesson import together
from symdyn.teach.shown_state import ACCELERATIONS, RATES, Chosen, choose_state, starting_rates
from symdyn.verdict import Verdict
from symdyn.verify import Claim, claims_of_reactions, prove

SMALL = 1e-9


def choose_motion(lesson: Balance) -> Chosen:
    """Return the drawn position with rates and accelerations that are not all alike and that the loops allow.

    Raises:
        DerivationError: angles are singular at that position, or no accelerations fit it.
    """
    chosen = choose_state(lesson.scene, lesson.state, lesson.graph, moving=not lesson.closed)
    _refuse_singular_angles(lesson, chosen)
    w, n = lesson.workspace, lesson.state.n
    led = w.prescribed
    if not lesson.closed:
        return chosen
    rows = w.loops.recursive
    G = w.loops.G(rows)
    pins = np.eye(n)[list(led.place)].reshape(-1, n)
    A = np.vstack([np.array(chosen.of(*(x for row in G for x in row))).reshape(-1, n), pins])
    free = _independent(lesson, led.place)
    given = starting_rates(lesson.scene, chosen.parameters)
    wanted = [given[k] or RATES[place % len(RATES)] for place, k in enumerate(free)]
    u = _tied(A, np.array([*(0.0 for _ in G), *chosen.of(*led.velocity)]), free, wanted)
    chosen = _with(chosen, lesson.state.qd, u)
    bias = [-x for x in chosen.of(*w.loops.bias(rows))]
    right = np.array([*bias, *chosen.of(*led.acceleration)])
    return _with(chosen, lesson.state.qdd, _accelerated(lesson, chosen, A, right, free))


def _refuse_singular_angles(lesson: Balance, chosen: Chosen) -> None:
    for angles in angles_of(lesson.scene):
        if abs(chosen.of(angles.clearance(lesson.graph))[0]) < SMALL:
            raise DerivationError(
                f"{lesson.scene.name}: joint {angles.joint.name}: where the lesson shows numbers {angles.names[1]} is "
                f"{chosen.q[angles.middle]:.4g}, and its angles are singular there; give another start, or another "
                "sequence of axes"
            )


def solved_at(lesson: Balance, chosen: Chosen) -> tuple[Array, bool]:
    """Return the least x with A x + b = 0 of (5.18) in numbers, and whether it is the only one.

    Raises:
        DerivationError: there is none at the chosen state.
    """
    matrix, right = _system_at(lesson, chosen)
    x, _, rank, _ = np.linalg.lstsq(matrix, -right, rcond=1e-10)
    left = abs(matrix @ x + right).max(initial=0.0)
    if left > 1e-8 * (1 + abs(right).max(initial=0.0)):
        raise DerivationError(no_motion(lesson))
    return np.where(np.abs(x) < SMALL * (np.abs(x).max() or 1.0), 0.0, x), rank == len(x)


def no_motion(lesson: Balance) -> str:
    """Return what is said where a lesson finds no motion whose forces it could show."""
    return (
        f"{lesson.scene.name}: where the lesson shows numbers no accelerations fit the loops and rows (a change "
        "point); give the joints another start"
    )


def determined(lesson: Balance, chosen: Chosen, unknowns: list[int]) -> bool:
    """Return whether (5.18) determines some of its unknowns at the chosen state."""
    matrix, _ = _system_at(lesson, chosen)
    units = np.eye(matrix.shape[1])[unknowns].reshape(-1, matrix.shape[1])
    return bool(np.linalg.matrix_rank(matrix) == np.linalg.matrix_rank(np.vstack([matrix, units])))


def _system_at(lesson: Balance, chosen: Chosen) -> tuple[Array, Array]:
    """Return A and b of (5.18) in numbers."""
    A, b = lesson.system.matrix(), lesson.system.right()
    found = np.array(evaluate([*(x for row in A for x in row), *b], Floats(), chosen.values), dtype=np.float64)
    size = (len(A), len(lesson.unknowns))
    return found[: size[0] * size[1]].reshape(size), found[size[0] * size[1] :]


def _independent(lesson: Balance, led: tuple[int, ...]) -> list[int]:
    """Return the velocities whose rates may be chosen."""
    return [k for k in lesson.workspace.loops.decisions.partition.independent if k not in led]


def _tied(A: Array, right: Array, free: list[int], requested: Sequence[float]) -> Array:
    """Return x with A x = right whose free entries are as wanted, or near where A does not allow it."""
    x = np.zeros(A.shape[1])
    x[free] = [requested[k % len(requested)] for k in range(len(free))]
    others = [k for k in range(len(x)) if k not in free]
    if others and len(A):
        x[others] = np.linalg.lstsq(A[:, others], right - A[:, free] @ x[free], rcond=1e-10)[0]
    if len(A) and abs(A @ x - right).max() > SMALL * (1 + abs(x).max()):  # a dead centre
        x += np.linalg.lstsq(A, right - A @ x, rcond=1e-10)[0]
    return x


def _with(chosen: Chosen, symbols: tuple[Expr, ...], values: Array) -> Chosen:
    rounded = [0.0 if abs(x) < SMALL else float(x) for x in values]
    return chosen.with_values(dict(zip(symbols, rounded, strict=True)))


def _accelerated(lesson: Balance, chosen: Chosen, G: Array, right: Array, free: list[int]) -> Array:
    """Return accelerations near those wanted that the rows allow and that need no drive which nobody declared.

        G u̇ = right, A x + b(u̇) = 0 with x = 0 where it is an idle drive      linear in (u̇, x)

    Raises:
        DerivationError: there are none.
    """
    n, unknowns = lesson.state.n, len(lesson.system.unknowns)
    rest, slopes = _inertial(lesson, chosen)
    matrix, _ = _system_at(lesson, chosen)
    idle = np.eye(unknowns)[[lesson.system.unknowns.index(one) for one in lesson.system.passive]]
    C = np.block(
        [
            [G, np.zeros((len(G), unknowns))],
            [slopes, matrix],
            [np.zeros((len(idle), n)), idle.reshape(-1, unknowns)],
        ]
    )
    d = np.concatenate([right, -rest, np.zeros(len(idle))])
    found = np.linalg.lstsq(C, d, rcond=1e-10)[0]
    if abs(C @ found - d).max(initial=0.0) > 1e-7 * (1 + abs(d).max(initial=0.0)):
        raise DerivationError(no_motion(lesson))
    ways = null_space(C, rcond=1e-10)[:n]
    ways = np.where(np.abs(ways) > SMALL, ways, 0.0)  # at a dead centre the equilibrium leaves none open
    wanted = np.array([ACCELERATIONS[place % len(ACCELERATIONS)] for place in range(len(free))])
    weight = np.array([1e4 if lesson.scene.drives[k] else 1.0 for k in free]).reshape(-1, 1)  # driven ones first
    missing = (wanted - found[free]).reshape(-1, 1)
    moved = found[free] + ways[free] @ np.linalg.lstsq(weight * ways[free], weight * missing, rcond=1e-10)[0][:, 0]
    return _tied(G, right, free, [float(x) for x in np.round(moved, 12)])


def _inertial(lesson: Balance, chosen: Chosen) -> tuple[Array, Array]:
    """Return b of (5.18) without acceleration, and how it changes with each, which it does linearly."""

    def at(accelerations: Array) -> Array:
        return _system_at(lesson, _with(chosen, lesson.state.qdd, accelerations))[1]

    n = lesson.state.n
    rest = at(np.zeros(n))
    return rest, np.array([at(unit) - rest for unit in np.eye(n)]).reshape(n, -1).T


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
    on_sphere = verify.on_unit_sphere(lesson.scene, list(claims.values()))
    fields, findings = prove(on_sphere, positive=[p.name for p in lesson.scene.parameters if p.positive])
    free = lesson.state.n - len(lesson.workspace.loops.decisions.independent_rows) if lesson.closed else 0
    few = {"formulations.drives"} if len(other) < free else set[str]()  # not every motion is possible then
    different = {key for key, one in zip(claims, findings, strict=True) if one.verdict == Verdict.DIFFERENT}
    assert different <= few, "the two formulations differ"
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
