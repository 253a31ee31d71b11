"""Laws that are checked in numbers, where proofs see nothing: inequalities, and closed mechanisms at natural positions.

A pivot or a partition that was chosen beforehand is singular at some positions, which random ones never meet. Often
these are the natural ones: the start, zeros, an upright wheel, equal angles. There, assembled as near as the loops
allow, the derived functions are compared with equations that nobody has solved beforehand:

    M u̇ + h = τ + Gᵀ λ,  G u̇ + γ = 0      forward dynamics, and multipliers as the force Gᵀ λ that they make
    A x + b = 0                             (5.18), reactions: equal where an entry is unique, elsewhere apart by what
                                            is in equilibrium with itself

Where these equations lose rank themselves (a change point, angles that are singular, a wheel that lies flat), forward
dynamics does not exist, which is reported with the rank; nor does it where independent velocities do not determine the
others. Where that is so at every natural position, random closed positions are taken. Anywhere else a result that is
not finite is wrong.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.arguments import argument
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.reactions import Equilibrium, why_no_reactions
from symdyn.emit import emit
from symdyn.errors import DerivationError, SymdynError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, evaluate, substitute
from symdyn.program import Sampling
from symdyn.runtime import RUNNERS
from symdyn.scene import SceneUnits
from symdyn.scene.values import velocity_name
from symdyn.simulation import contact_checks
from symdyn.verdict import NotLookedAt, Unclaimed, Verdict
from symdyn.verify.claims import Look, Looked, Seen
from symdyn.verify.equality import Finding

SAME = 1e-7
"""Largest difference of two results in doubles, over the largest entry, from which they are two."""

RANK = 1e-9
"""Singular values this much below the largest are zero."""

SINGLE = 8
"""Angles that are set to zero one by one."""


@dataclass(frozen=True)
class _State:
    """A closed position, velocities that the loops allow, driving forces, and what they make of it."""

    where: str  # the position, in words
    values: dict[Expr, float]  # of all symbols, u̇ among them
    moved: Array  # u̇, shape (nv,)
    pulled: Array  # Gᵀ λ, shape (nv,)


def forward_findings(w: Workspace) -> Looked:
    """Return how forward dynamics and its reactions stand at natural positions, and where they do not exist."""
    states, lost = _states(w, {})
    finding, undetermined = _forward(w, states)
    findings = [finding]
    absent = _grouped("forward dynamics", lost | undetermined)
    if why := why_no_reactions(w.scene):
        absent.append(Unclaimed("forward_reactions", why))
    elif w.hanging.cuts:
        there = [one for one in states if one.where not in undetermined]
        finding, others = _reactions(w, "forward_reactions", there)
        findings, absent = [*findings, finding], absent + others
    return findings, absent


def lost_rank(w: Workspace, q: Array) -> str:
    """Return why the equations of motion of a closed scene have no one solution at a position, "" where they have."""
    if not w.scene.is_constrained:
        return ""
    found = _state(w, {}, _entries(w), 0, "the state", q)
    return found if isinstance(found, str) else ""


def _grouped(name: str, lost: Mapping[str, str]) -> list[Unclaimed]:
    """Return at which positions something does not exist, those with one reason together."""
    reasons = dict.fromkeys(lost.values())
    places = {why: ", ".join(where for where, one in lost.items() if one == why) for why in reasons}
    return [Unclaimed(f"{name} at {where}", why) for why, where in places.items()]


def reaction_findings(w: Workspace) -> Looked:
    """Return how reactions of a motion that is given stand there."""
    if not w.hanging.cuts:
        return [], []
    states, _ = _states(w, dict.fromkeys(w.scene.passive_velocities, 0.0))  # told of forward dynamics
    finding, lost = _reactions(w, "reactions", states)
    return [finding], lost


def _undetermined(w: Workspace, state: _State) -> str:
    """Return why forward dynamics does not exist at a state whose equations have a solution, "" where it does."""
    decisions = w.loops.decisions
    free, names = decisions.partition.independent, w.scene.velocities
    q = np.array([state.values[symbol] for symbol in w.state.q])
    G = w.loops.numbers.jacobian(q)[list(decisions.independent_rows)].reshape(-1, w.state.n)
    rest = np.delete(G, list(free), axis=1)
    if (rank := _rank(rest)) == rest.shape[1]:
        return ""
    return (
        f"there {', '.join(names[k] for k in free)} do not determine the other velocities: the columns of these have "
        f"rank {rank} of {rest.shape[1]}; choose others with {argument('independent')}"
    )


def _rank(A: Array) -> int:
    return int(np.linalg.matrix_rank(A, tol=RANK * float(np.linalg.norm(A, 2)))) if A.size else 0


# Positions


def natural_places(w: Workspace) -> list[tuple[str, Array]]:
    """Return closed positions that are come to from natural ones, with their names, each once."""
    numbers = w.loops.numbers
    found: list[tuple[str, Array]] = []
    for where, guess, set_to in _guesses(w):
        for held in (set_to, []):  # as they were set, if the loops close so
            try:
                q = numbers.newton(numbers.normalised(guess), held)
                closed = numbers.is_closed(q) and not (numbers.lying_flat(q) or numbers.singular_angles(q))
            except DerivationError:  # a formula has no value there
                continue
            if closed:
                if all(np.abs(q - other).max(initial=0.0) > SAME for _, other in found):
                    found.append((where, q))
                break
    return found


def _guesses(w: Workspace) -> Iterator[tuple[str, Array, list[int]]]:
    """Yield the positions to begin with, and the velocities of the coordinates that were set."""
    assembly, scene = w.loops.decisions.assembly, w.scene
    units = SceneUnits(scene).coordinates
    angles = [k for k, unit in enumerate(units) if unit == "rad"]

    def turned(
        where: str, q: Sequence[float], angle: float, some: Sequence[int] = angles
    ) -> tuple[str, Array, list[int]]:
        """Return a position with some angles set."""
        guess = np.array(q)
        guess[list(some)] = angle
        rates = [velocity_name(scene.coordinates[k]) for k in some]
        return where, guess, [scene.velocities.index(name) for name in rates if name in scene.velocities]

    yield "the start", np.array(assembly.q), []
    yield turned("zeros", (0.0,) * len(units), 0.0)
    yield turned("all angles zero", assembly.q, 0.0)
    yield turned("equal angles", assembly.q, 0.5)
    yield turned("right angles", assembly.q, np.pi / 2)
    for k in angles[:SINGLE]:
        yield turned(f"{scene.coordinates[k]} = 0", assembly.configurations[0], 0.0, [k])


# States


def _states(w: Workspace, forces: Mapping[int, float]) -> tuple[list[_State], dict[str, str]]:
    """Return a state at every natural position where the equations of motion have one solution, and why not at others.

    `forces` are driving forces by velocity; others are random.
    """
    entries = _entries(w)
    made = {one[0]: _state(w, forces, entries, k, *one) for k, one in enumerate(w.once(natural_places))}
    if not any(isinstance(one, _State) for one in made.values()):  # positions at random are better than none
        for k, q in enumerate(w.loops.decisions.assembly.configurations):
            made[f"random position {k + 1}"] = _state(w, forces, entries, k, f"random position {k + 1}", np.array(q))
    states = [one for one in made.values() if isinstance(one, _State)]
    return states, {where: one for where, one in made.items() if isinstance(one, str)}


def _state(
    w: Workspace, forces: Mapping[int, float], entries: Sequence[Expr], number: int, where: str, q: Array
) -> _State | str:
    """Return the state at a position, at rest at every other one; or why the equations have no one solution there."""
    numbers, kept, n = w.loops.numbers, list(w.loops.decisions.independent_rows), w.state.n
    led, m = list(w.prescribed.place), len(kept)
    rng = random.Random(f"{w.scene.name}:{where}")
    G = numbers.jacobian(q)[kept].reshape(m, n)
    u = np.array([rng.uniform(-1, 1) for _ in range(n)]) if number % 2 else np.zeros(n)  # at rest, too
    u = u - np.linalg.pinv(G) @ (G @ u)
    tau = np.array([forces.get(k, rng.uniform(-1, 1)) for k in range(n)])
    values = _values(w, q, u, tau)
    found = _at(entries, values)
    if found is None:
        return "the equations of motion have no finite value there"
    M, h, bias, accelerated = np.split(found, np.cumsum([n * n, n, m]))
    rows = np.vstack([G, np.eye(n)[led].reshape(-1, n)])
    unit = float(np.abs(M).max(initial=0.0)) or 1.0  # masses of grams and tonnes alike
    K = np.zeros((n + len(rows), n + len(rows)))
    K[:n, :n], K[:n, n:], K[n:, :n] = M.reshape(n, n) / unit, -rows.T, rows
    if _rank(K) < len(K):  # a change point, or singular angles
        of_rows = f"the rows of loops and prescribed motions have rank {_rank(rows)} of {len(rows)}"
        return f"{of_rows}, the equations of motion have rank {_rank(K)} of {len(K)}"
    x = np.linalg.solve(K, np.concatenate([(tau - h) / unit, -bias, accelerated]))
    values |= dict(zip(w.state.qdd, x[:n].tolist(), strict=True))
    return _State(where, values, x[:n], unit * (G.T @ x[n : n + m]))


def _entries(w: Workspace) -> list[Expr]:
    h = substitute(w.forces(list(w.state.qdd)), dict.fromkeys(w.state.qdd, w.graph.zero))
    M = [x for row in w.composite_mass for x in row]
    return [*M, *h, *w.loops.gamma(w.loops.recursive), *w.prescribed.acceleration]


def _values(w: Workspace, q: Array, u: Array, tau: Array) -> dict[Expr, float]:
    """Return values of all symbols but the accelerations, at t = 0."""
    values = w.loops.values(q.tolist()) | w.scene.at_time(w.graph)
    for symbols, numbers in ((w.state.qd, u), (w.state.tau, tau)):
        values |= dict(zip(symbols, numbers.tolist(), strict=True))
    return values


def _at(entries: Sequence[Expr], values: Mapping[Expr, float]) -> Array | None:
    """Return values of entries; None where one is no finite number."""
    try:
        found = np.array(evaluate(list(entries), Floats(), values), dtype=np.float64)
    except (ArithmeticError, ValueError):
        return None
    return found if np.isfinite(found).all() else None


# What is compared


def _forward(w: Workspace, states: Sequence[_State]) -> tuple[Finding, dict[str, str]]:
    """Return how forward dynamics and multipliers stand, and at which positions they do not exist, with the reason."""
    moved, multipliers = derive_one(w, "forward_dynamics").entries, derive_one(w, "multipliers").entries
    pulled = w.loops.constraint_forces(multipliers)
    compared: list[str] = []
    undetermined: dict[str, str] = {}
    wrong, holes = [], []
    for state in states:
        found = _at([*moved, *pulled], state.values)
        if found is None and (why := _undetermined(w, state)):
            undetermined[state.where] = why
            continue
        compared.append(state.where)
        if found is None:
            holes.append(state.where)
        elif max(_apart(found[: w.state.n], state.moved), _apart(found[w.state.n :], state.pulled)) <= SAME:
            continue
        wrong.append(state.where)
    name, other = "forward dynamics", "M qdd + h = tau + G^T lambda in numbers"
    return _finding(name, other, compared, wrong, holes), undetermined


def _reactions(w: Workspace, name: str, states: Sequence[_State]) -> tuple[Finding, list[Unclaimed]]:
    """Return how reactions stand: whether they meet (5.18), and exist where it has the rank that it has in general.

    Where it has less, they do not exist.
    """
    derived = derive_one(w, name)
    length, decisions = w.loops.decisions.assembly.length, w.loops.decisions
    given = any(argument.name == "tau" for argument in derived.arguments)
    # what is prescribed takes its own drive
    drives = derive_one(w, "drive_forces").entries if w.prescribed.place else w.state.tau
    system = Equilibrium.of(w.hanging, tau=drives if given else None, whole=True).in_numbers
    compared: list[str] = []
    lost: dict[str, str] = {}
    wrong, holes, general = [], [], 0
    for place in decisions.assembly.configurations if states else ():
        values = states[0].values | dict(zip(w.state.q, place, strict=True))
        general = max(general, system.least(values, length).rank)
    for state in states:
        rank = system.least(state.values, length).rank
        if rank < general:  # a change point
            lost[state.where] = f"equilibrium (5.18) has rank {rank} there, and {general} elsewhere"
            continue
        found = _at(derived.entries, state.values)
        compared.append(state.where)
        holes += [state.where] if found is None else []
        off = found is None or system.missed(state.values, found, length) > SAME
        wrong += [state.where] if off else []
    return _finding(name, "equilibrium (5.18) in numbers", compared, wrong, holes), _grouped(name, lost)


def _apart(values: Array, expected: Array) -> float:
    return float(np.abs(values - expected).max(initial=0.0)) / (1.0 + float(np.abs(expected).max(initial=0.0)))


def _finding(name: str, other: str, compared: Sequence[str], wrong: Sequence[str], holes: Sequence[str]) -> Finding:
    """Return a finding about positions, by name: those compared, those that are off, and those not finite."""
    where = compared.index(wrong[0]) if wrong else -1
    title = f"{name}: at {', '.join(wrong) or 'natural positions'} = {other}"
    said = Verdict.of(len(compared), bool(wrong))
    why = "" if compared else "there is no closed position where it exists and was compared"
    if holes:
        why = f"at {', '.join(holes)} derived entries are not finite where the equations have a solution"
    return Finding(title, said, len(compared), 0, 0.0, where, why)


STATES = 50  # at which positive definiteness is looked at


DEFINITE = "mass matrix: positive definite"


def positive_definite(seen: Seen) -> Looked:
    """Return that M is positive definite at sampled states, where it should be and parameters have sensible values."""
    scene, mass = seen.program.scene, seen.program["mass_matrix"].function
    signed = [parameter.name for parameter in scene.free_parameters if not parameter.positive]
    if signed:
        return [], [NotLookedAt(DEFINITE, f"{', '.join(signed)} may be negative; declare it with positive = true")]
    rng = random.Random(seen.seed)
    states = [Sampling(mass.arguments, rng).state(1.0 + k % 4 * 8) for k in range(4 * STATES)]
    begin = scene.at_time(seen.program.graph)  # of masses that change; one that starts at zero has a size alone
    for k, one in enumerate(mass.arguments):
        if set(one.symbols) <= set(begin):
            for state in states:
                state[k] = np.array([begin[x] or abs(y) for x, y in zip(one.symbols, state[k], strict=True)])
    measured = next(iter(seen.modules.values()), None)  # whose own accuracy is known
    module = RUNNERS["numpy"].run(emit(seen.program)) if measured is None else measured
    with np.errstate(all="ignore"):
        matrices = [getattr(module, mass.name)(*state) for state in states]
    real = [M for M in matrices if np.isfinite(M).all()][:STATES]  # a formula may be real for some parameters only
    where = next((k for k, M in enumerate(real) if not _is_definite(M, scene.is_constrained)), -1)
    why = "" if real else f"M has finite entries at none of {len(states)} states"
    return [Finding(DEFINITE, Verdict.of(len(real), where >= 0), len(real), 0, 0.0, where, why)], []


def _is_definite(M: np.ndarray[Any, Any], closed: bool) -> bool:
    """Whether M is positive definite; only not negative for a spanning tree, which may end in a massless coupler."""
    values = np.linalg.eigvalsh(M)
    return bool(values.min() >= -1e-12 * values.max() if closed else values.min() > 0)


def contact_findings(seen: Seen) -> Looked:
    """Return how laws of contacts stand at natural states, and over a run of a second."""
    try:
        checks, lacking = contact_checks(seen.workspace.scene, seen.seed)
    except SymdynError as fault:
        return [], [NotLookedAt("contacts at natural states", str(fault))]
    found = []
    for claim, places in checks.items():
        wrong = [where for where, holds in places.items() if not holds]
        title, first = ": ".join((claim, *wrong[:1])), [*places].index(wrong[0]) if wrong else -1
        found.append(Finding(title, Verdict.of(len(places), bool(wrong)), len(places), 0, 0.0, first))
    return found, [NotLookedAt(claim, why) for claim, why in lacking.items()]


LOOKS: list[Look] = [
    Look(
        None,
        ("forward_dynamics", "multipliers"),
        "looking at natural positions",
        lambda seen: forward_findings(seen.workspace),
    ),
    Look(
        None,
        ("forward_dynamics", "multipliers", "reactions"),
        "looking at reactions there",
        lambda seen: reaction_findings(seen.workspace),
    ),
    Look(("delassus",), ("gap:",), "looking at contacts", contact_findings),
    Look(
        ("mass_matrix", "forward_dynamics"),
        ("mass_matrix", "forward_dynamics"),
        "looking at the inertia matrix",
        positive_definite,
    ),
]


def look(seen: Seen, progress: Callable[[str], None] = lambda _: None) -> Looked:
    """Return what all laws find that are about a scene, and what is no claim."""
    findings: list[Finding] = []
    absent: list[Unclaimed] = []
    for one in LOOKS:
        if one.fits(seen.program.scene, seen.outputs):
            progress(one.doing)
            found, told = one.look(seen)
            findings, absent = findings + found, absent + told
    return findings, absent
