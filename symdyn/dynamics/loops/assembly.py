"""Assembly: coordinates at which every loop is closed, found by Newton's method from a guess.

    r, R, G      residuals, their rates and the constraint rows: loop_numbers.py
    σ            singular values of G, made dimensionless by a characteristic length

Where σ is smaller than at generic configurations, the mechanism stands at a change point, where branches meet.

Reference: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), sections 4.5 and 5.4.

A large graph is evaluated at one state level by level, all operations of one kind that need nothing else at once. A
node's level is one more than the highest of its operands'. A graph of many like parts, as of a mechanism with many
loops, has few levels, however many nodes: NumPy takes each in one call. Values are those of doubles; sines and the like
may differ from Python's in the last bit.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.dynamics.loops.newton import (
    CLOSED,
    NEGLIGIBLE,
    generic_configurations,
    lever_of,
    open_loop,
    rank_of,
    reversed_loop,
    spectrum,
    unbound,
)
from symdyn.dynamics.loops.sparse_rows import is_large, triangular
from symdyn.errors import DerivationError, NoValueError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, arithmetic, reachable
from symdyn.scene.forces import FORCES

if TYPE_CHECKING:
    from symdyn.dynamics.loops.loop_numbers import Numbers


NEAR = 1e-3
"""Below it a mechanism is said to be near a change point."""

GUESSES, DRAWS, GUESSES_A_DRAW = 40, 60, 5

EFFORT = 4_000_000
"""When so much is spent, about 3 s, no further guess is tried; the first is followed as far as it leads."""


@dataclass(frozen=True)
class Assembly:
    """A closed position of a mechanism."""

    q: tuple[float, ...]  # coordinates, shape (nq,); rad, m or 1
    parameters: tuple[tuple[str, float], ...]  # values that free parameters were given to look at the mechanism at all
    residual: float  # largest residual that is left, m or 1
    length: float  # the characteristic length, m, by which velocities of slides are divided and forces multiplied
    smallest: float  # the singular value of the dimensionless G, all rows, that vanishes first
    rank: int  # rank of G in general, at generic configurations
    here: int  # rank of G at q itself; less at a change point
    regular: tuple[float, ...]  # q itself, or at a change point a generic configuration, where the rank is `rank`
    configurations: tuple[tuple[float, ...], ...]  # generic ones, closed, shape (nq,) each
    notes: tuple[str, ...] = ()  # what a user should know, such as that the position is near a change point


def closed_position(
    numbers: Numbers, guess: Array | None = None, locked: Sequence[int] | None = None, guesses: int = GUESSES
) -> Assembly:
    """Return a closed position from a guess of the coordinates; see `assemble`.

    Without a guess those of the scene are taken, and where it gives none random ones. Coordinates of `locked`
    velocities do not move; None locks those with a drive as long as the loops close so.
    """
    scene = numbers.scene
    given = guess is not None or any(joint.start for joint in scene.moving)
    first = numbers.start() if guess is None else numbers.normalised(guess)
    with_drives = [k for k, drive in enumerate(scene.drives) if drive] if given else []
    attempts = [tuple(locked)] if locked is not None else [tuple(with_drives), ()] if with_drives else [()]
    fault, notes = numbers.lying_flat(first), list[str]()
    for fixed in attempts if not fault else ():
        q = numbers.newton(first, fixed)
        if not numbers.is_closed(q) and not fixed:
            # where angles are singular they hold a body
            q = numbers.from_quaternions(numbers.in_quaternions.newton(numbers.to_quaternions(first), ()), first)
        if numbers.is_closed(q):
            if fixed != attempts[0]:
                moved = ", ".join(scene.velocities[k].removesuffix("_dot") for k in attempts[0])
                notes.append(f"the loops do not close at the start of {moved}, which had to move")
                notes += mirrored_loops(numbers, bare=True)
            return _looked_at(numbers, q, notes)
        fault = open_loop(numbers, q) or reversed_loop(numbers, q) or ""
        names = [scene.velocities[k].removesuffix("_dot") for k in fixed]
        held = [scene.coordinates.index(name) for name in names if name in scene.coordinates]
        if fixed and locked is None and (at := numbers.closed_elsewhere(first, held, fixed, guesses // 4)) is not None:
            return _looked_at(numbers, at, ["the loops close from other guesses of the start alone"])
    for seed in range(guesses) if not given else ():
        if numbers.effort > EFFORT:
            break
        q = numbers.newton(numbers.drawn(seed), ())
        if numbers.is_closed(q):
            notes.append("no joint has a start: a closed position was found from a random guess; give start")
            return _looked_at(numbers, q, notes)
    found = numbers.closed_elsewhere(first, [], (), guesses // 4) if given and not locked else None
    if found is not None:
        values = ", ".join(f"{name} = {x:.6g}" for name, x in zip(scene.coordinates, found, strict=True))
        raise DerivationError(f"{scene.name}: {fault}; from other guesses it closes, give a start near {values}")
    raise DerivationError("; ".join([f"{scene.name}: {fault}", *mirrored_loops(numbers, bare=True)]))


def witness(make: Mapping[str, float] | None, numbers: Numbers) -> tuple[Numbers, Assembly]:
    """Return a witness configuration (Michelucci, Foufou, 2006), at which things are decided: all values, closed loops.

    Values that `make` does not give are drawn until the loops close; DerivationError where they never do.
    """
    scene, known = numbers.scene, dict(make or {})
    entries = [*numbers.constraints.residual, *(entry for row in numbers.constraints.G for entry in row)]
    missing = [name for name in unbound(scene, entries) if name not in known]
    others = [p.name for p in scene.free_parameters if p.name not in known and p.name not in missing]
    rest = dict(known) | dict.fromkeys(others, 1.0)
    if not missing:
        numbers = numbers.bound_to(rest)
        return numbers, closed_position(numbers)
    last: DerivationError | None = None
    for draw in range(DRAWS):
        rng = random.Random(f"{scene.name}:{draw}")
        numbers = numbers.bound_to(rest | {name: rng.uniform(0.5, 1.5) for name in missing})
        try:
            return numbers, closed_position(numbers, guesses=GUESSES_A_DRAW)
        except DerivationError as fault:
            last = fault
        if numbers.effort > EFFORT:
            break
    raise DerivationError(
        f"{last}; random values of {', '.join(missing)} were tried, {draw + 1} times: give values with which it closes"
    )


# What was found


def _looked_at(numbers: Numbers, q: Array, notes: list[str]) -> Assembly:
    """Return a closed position with its singular values, compared with those of generic configurations."""
    in_quaternions, at = numbers.in_quaternions, numbers.to_quaternions(q)
    length = lever_of(in_quaternions, at)
    values = spectrum(in_quaternions, at, length)
    near = generic_configurations(in_quaternions, at, length)
    ranks = [values.rank, *(spectrum(in_quaternions, one, length).rank for one in near)]
    here, rank = ranks[0], max(ranks)
    largest, smallest = values.value(0), values.value(rank - 1)
    best = [one for one, r in zip((at, *near), ranks, strict=True) if r == rank]
    # where the first position's angles are nearly singular, the one at which they are so least
    positions = [q if one is at else numbers.from_quaternions(one, q) for one in best]
    clear = [float(numbers.clearances(q).min(initial=1.0)) for q in positions]
    regular = positions[0 if clear[0] > NEAR else int(np.argmax(clear))]
    if rank and smallest < NEAR * largest:
        where, then = ("near", "lose that many digits") if here == rank else ("at", "are not unique there")
        notes.append(
            f"{_weakest(in_quaternions, at, length)} is {where} a change point: the smallest singular value of its "
            f"constraints is {smallest:.3g}, the largest {largest:.3g}; accelerations and reactions {then}"
        )
    notes += [
        f"the loop {name} forbids nothing that the other joints of the loop do not forbid already: it has no length, "
        "or its joint repeats another one; give lengths by origin and tip, or leave it out"
        for name in _void_loops(in_quaternions, [at, numbers.to_quaternions(regular)])
    ]
    notes += doubts(numbers, q)
    residual = float(np.max(np.abs(numbers.residual(q)), initial=0.0))
    return Assembly(
        tuple(q.tolist()),
        tuple(sorted(numbers.free.items())),
        residual,
        length,
        smallest,
        rank,
        here,
        tuple(regular.tolist()),
        tuple(tuple(numbers.from_quaternions(one, q).tolist()) for one in near),
        tuple(dict.fromkeys(notes)),
    )


def seen_in_quaternions(numbers: Numbers, assembly: Assembly) -> Assembly:
    """Return an assembled position as one of the mechanism in quaternions."""
    q, regular, *configurations = (
        tuple(numbers.to_quaternions(np.array(one)).tolist())
        for one in (assembly.q, assembly.regular, *assembly.configurations)
    )
    return replace(assembly, q=q, regular=regular, configurations=tuple(configurations))


def doubts(numbers: Numbers, q: Array) -> list[str]:
    """Return which contacts are off the plane that their scene declares, and do not hold it, and mirrored loops."""
    heights = numbers.at([one.height for one in numbers.contact_gaps], q).tolist()
    return [
        f"contact {one.row.name}: {one.row.place.body} is {abs(h):.3g} m "
        f"{'above' if h > 0 else 'below'} its plane, and no component of the contact holds it there"
        for one, h in zip(numbers.contact_gaps, heights, strict=True)
        if one.row.plane.declared
        and not FORCES[one.row.kind].holonomic(one.row)
        and abs(h) > CLOSED * max(1.0, lever_of(numbers, q))
    ] + mirrored_loops(numbers)


MIRRORED, FEW = 1e-2, 6
"""A residual over another that shows which of two mechanisms was meant, when the start is given to some digits."""


def mirrored_loops(numbers: Numbers, bare: bool = False) -> list[str]:
    """Return which loops a start leaves open that close when `tip` is taken for its inverse, or that have none."""
    scene, q, found = numbers.scene, numbers.start(), list[str]()
    if len(scene.loops) > FEW or not any(joint.start for joint in scene.moving) or numbers.lying_flat(q):
        return found
    gaps, lever = np.abs(numbers.residual(q)), max(1.0, lever_of(numbers, q))
    off = float(gaps.max(initial=0.0))
    if off < MIRRORED * lever:
        return found
    owners = [one.owner for one in numbers.constraints.labels]
    for loop in scene.loops:
        own = max([0.0, *(gap for gap, owner in zip(gaps, owners, strict=False) if owner == loop.name)])
        if not loop.tip.steps:
            told = f"without tip or child_origin the joint {loop.name} is at the origin of {loop.child}'s frame"
            found += [f"{told}: if it is not, write child_origin"] if bare and own > MIRRORED * lever else []
            continue
        loops = tuple(replace(one, tip=one.tip.inverse()) if one is loop else one for one in scene.loops)
        other = type(numbers)(replace(scene, loops=loops)).bound_to(numbers.free)
        if np.abs(other.residual(q)).max() < MIRRORED * off:
            found.append(
                f"{numbers.left_open(q)}; {loop.name} would close if its tip were its child_origin: "
                "tip is the child's frame seen from the joint, child_origin the joint seen from that"
            )
    return found


def _void_loops(numbers: Numbers, positions: Sequence[Array]) -> list[str]:
    """Return the loops whose constraint rows all vanish at closed positions."""
    sizes = [np.abs(numbers.dimensionless(q, lever_of(numbers, q))).max(axis=1, initial=0.0) for q in positions]
    working = np.max(sizes, axis=0) > NEGLIGIBLE
    owners = {one.owner for one, works in zip(numbers.constraints.labels, working, strict=True) if one.loop and works}
    return [joint.name for joint in numbers.scene.loops if joint.name not in owners]


def _weakest(numbers: Numbers, q: Array, length: float) -> str:
    """Return in words the owner of the rows that come closest to being dependent."""
    G = numbers.dimensionless(q, length)
    working = np.flatnonzero(G.any(axis=1))
    if is_large(G[working]):
        found = triangular(G[working], NEGLIGIBLE)
        weakest = int(working[(*found.dependent, found.independent[-1])[0]])
        return numbers.constraints.labels[weakest].words
    U, values, _ = np.linalg.svd(G)
    mixed = np.abs(U[:, max(0, rank_of(values) - 1)])
    if rank_of(values) < min(G.shape):
        mixed = np.abs(U[:, rank_of(values)]) * (np.abs(G).max(axis=1, initial=0.0) > 0)
    return numbers.constraints.labels[int(mixed.argmax())].words


class Levels:
    """Outputs of a graph, ready to be evaluated often."""

    def __init__(self, outputs: Sequence[Expr]) -> None:
        order = reachable(outputs)
        place = {node: k for k, node in enumerate(order)}
        level = [0] * len(order)
        steps: dict[tuple[int, Op], list[int]] = {}
        known: list[tuple[int, float]] = []
        self.symbols: dict[Expr, int] = {}
        numbers = Batches()
        for k, node in enumerate(order):
            if node.op is Op.SYMBOL:
                self.symbols[node] = k
            elif node.op is Op.CONSTANT:
                assert isinstance(node.value, Fraction), "a constant has a fraction"
                known.append((k, float(numbers.constant(node.value))))
            elif node.op is Op.PI:
                known.append((k, float(numbers.pi())))
            else:
                level[k] = 1 + max(level[place[arg]] for arg in node.args)
                steps.setdefault((level[k], node.op), []).append(k)
        self.size = len(order)
        self._start = np.zeros(self.size)
        for k, x in known:
            self._start[k] = x
        self._steps = [
            (
                op,
                np.array(ks, dtype=np.intp),
                np.array([[place[a] for a in order[k].args] for k in ks], dtype=np.intp).T,
            )
            for (_, op), ks in sorted(steps.items(), key=lambda item: (item[0][0], item[0][1].value))
        ]
        self._outputs = np.array([place[node] for node in outputs], dtype=np.intp)

    def at(self, values: Mapping[Expr, float]) -> Array:
        """Return the outputs at values of the symbols, shape (outputs,).

        Raises:
            KeyError: a symbol has no value.
            NoValueError: something is divided by zero, or has no real value.
        """
        x, numbers = self._start.copy(), Batches()
        apply = arithmetic(numbers)
        for node, k in self.symbols.items():
            x[k] = values[node]
        with np.errstate(divide="raise", invalid="raise", over="ignore", under="ignore"):
            try:
                for op, at, args in self._steps:
                    operands = [x[one] for one in args]
                    x[at] = apply[op](*operands) if op in apply else numbers.functions[op](*operands)
            except FloatingPointError as fault:
                raise NoValueError(f"{fault} in a formula of the scene") from None
        return np.asarray(x[self._outputs])
