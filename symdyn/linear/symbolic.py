"""A, B, C, D as formulas in the parameters, where a mechanism is small, and what eigenvalues have a closed form.

Angles at the point that are multiples of 15 degrees, and what is zero, are exact; other coordinates stay symbols in the
formulas, as those of a four-bar do. Balance is used: at rest accelerations are zero, and multipliers follow from the
rows of dependent velocities. What is found is compared with the numbers at the point before it is shown. Of a closed
mechanism with one freedom at rest mass, stiffness and damping have names of their own.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array, Floats, Form, Nodes, Number, Ratio, Ratios, Symbol, with_added_angles
from symdyn.dynamics import formulas
from symdyn.dynamics.outputs import COLUMNS
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op, evaluate, growing, reachable, substitute
from symdyn.linear.report import SAME, Root, Symbolic, negated
from symdyn.rounding import digits_or
from symdyn.scene import SceneUnits
from symdyn.simulation import opened

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization
    from symdyn.linear.prepared import Prepared
    from symdyn.linear.variations import Entries, Variations

MOST_ROWS = 3
"""Rows of loops in symbols that are small."""

DIGITS = 12
"""Digits of numbers that have no exact form."""


def places(prepared: Prepared, system: Linearization) -> tuple[list[int], list[int]]:
    """Return independent positions, dropped ones among them, and velocities, by number of the velocity."""
    labels, p = COLUMNS["q"](prepared.functions.w), system.positions
    positions = sorted(labels.index(x) for x in (*system.states.names[:p], *system.dropped))
    return positions, system.velocities


def kept(prepared: Prepared, system: Linearization) -> tuple[list[int], list[int]]:
    """Return which states, of all those positions and velocities, and which outputs the system has."""
    labels, (positions, velocities) = COLUMNS["q"](prepared.functions.w), places(prepared, system)
    states = [k for k, place in enumerate(positions) if labels[place] not in system.dropped]
    states += range(len(positions), len(positions) + len(velocities))
    return states, [prepared.outputs.names.index(name) for name in system.outputs.names]


def with_definitions(prepared: Prepared, system: Linearization, held: tuple[str, ...]) -> Symbolic | None:
    """Return a closed mechanism with one freedom in its coordinates: mass, stiffness, damping and all else named.

    m δü + d δu + k δξ = Nᵀ δτ        N  how all velocities follow the independent one, N_h the same at rest
    m = Nᵀ M N,  k = Nᵀ (X e) N,  d = Nᵀ (∂e/∂u) N, with λ of h = Gᵀ λ in X e
    """
    v = prepared.functions
    w, n, graph = v.w, v.w.state.n, v.w.graph
    positions, velocities = places(prepared, system)
    rows = len(v.multipliers)
    many = positions != velocities or len(positions) != 1 or rows > MOST_ROWS or rows != n - 1
    if many or prepared.scene.given or system.dropped:
        return None
    free = positions[0]
    name, labels = system.states.names[0], COLUMNS["q"](w)
    taken = {*system.scene.coordinates, *system.scene.velocities, *(one.name for one in system.scene.parameters)}
    dependent = [k for k in range(n) if k != free]
    slopes = {k: graph.symbol(fresh(f"{labels[k]}_{name}", taken)) for k in dependent}
    pulls = [graph.symbol(fresh(f"lambda{r + 1}", taken)) for r in range(rows)]
    place = dict.fromkeys([*w.state.qd, *w.state.qdd, *w.state.tau], graph.zero)
    place |= dict(zip(v.multipliers, pulls, strict=True))

    def part(block: str) -> list[list[Expr]]:
        shape, entries = {**v.motion.parts, **v.slopes.parts, **v.outputs.parts}[block]
        flat, width = substitute(list(entries), place), shape[1] if len(shape) > 1 else 1
        return [flat[i * width : (i + 1) * width] for i in range(shape[0])]

    G, h, M, e, y = (part(block) for block in ("G", "h", "M", "e", "y_"))
    if any(not x.is_zero for row in y for x in row[2 * n :]):
        return None
    N = [slopes.get(k, graph.one) for k in range(n)]

    def within(matrix: Sequence[Sequence[Expr]]) -> Expr:
        return graph.total(N[i] * matrix[i][k] * N[k] for i in range(n) for k in range(n))

    square = [[row[k] for k in dependent] for row in G]
    beside, forces = [-row[free] for row in G], [h[k][0] for k in dependent]
    turned = [list(row) for row in zip(*square, strict=True)]
    below = _determinant(square)
    numerators = [_determinant(_replaced(square, i, beside)) for i in range(rows)]
    pulled = [_determinant(_replaced(turned, i, forces)) for i in range(rows)]
    told = [within(M), within([row[:n] for row in e]), within([row[n : 2 * n] for row in e]), below, *numerators]
    outputs = [[graph.total(row[k] * N[k] for k in range(n)) for row in y], [
        graph.total(row[n + k] * N[k] for k in range(n)) for row in y]]  # fmt: skip
    try:
        most = max(DIGITS, digits_or(DIGITS))
        forms = [with_added_angles(x) for x in formulas([*told, *pulled, *outputs[0], *outputs[1]], most)]
    except DerivationError:
        return None
    given = iter(forms)
    m, k, d, down, *over = [next(given) for _ in told]
    above = [next(given) for _ in pulled]
    C = [tuple(next(given) for _ in y), tuple(next(given) for _ in y)]
    letters = [Symbol(fresh(f"{letter}_{name}", taken)) for letter in "mkd"]
    under = letters[0].power(-1)
    zero, one = Number(Fraction(0)), Number(Fraction(1))
    nothing = [not x.terms for x in (k, d)]
    lower = [
        zero if gone else Form.product((Number.MINUS_ONE, letter, under))
        for gone, letter in zip(nothing, letters[1:], strict=True)
    ]
    drives = [under if j == free else Form.product((Symbol(str(slopes[j].value)), under)) for j in prepared.drives]
    named = list(zip(slopes.values(), over, strict=True)) + list(zip(pulls, above, strict=True))
    ratio = {str(symbol.value): x if not x.terms else Form.product((x, down.power(-1))) for symbol, x in named}
    defined = {letter.name: form for letter, form in zip(letters, (m, k, d), strict=True) if form.terms} | ratio
    rates = tuple((zero,) * len(prepared.drives) for _ in y)
    roots = Root("damped" if d.terms else "pair", Form.product((letters[1], under)), negated(lower[1]), 1)
    result = Symbolic(
        ((zero, one), (lower[0], lower[1])), ((zero,) * len(drives), tuple(drives)), tuple(zip(*C, strict=True)), rates,
        (roots,), held, tuple(defined.items()),
    )  # fmt: skip
    return result if _is_true(result, prepared, system) else None


def _determinant(A: Sequence[Sequence[Expr]]) -> Expr:
    if len(A) == 1:
        return A[0][0]
    minors = ([[*row[:k], *row[k + 1 :]] for row in A[1:]] for k in range(len(A)))
    return A[0][0].graph.total(
        (-1 if k % 2 else 1) * x * _determinant(minor) for k, (x, minor) in enumerate(zip(A[0], minors, strict=True))
    )


def _replaced(A: Sequence[Sequence[Expr]], column: int, by: Sequence[Expr]) -> list[list[Expr]]:
    return [[*row[:column], x, *row[column + 1 :]] for row, x in zip(A, by, strict=True)]


def _is_true(exact: Symbolic, prepared: Prepared, system: Linearization) -> bool:
    """Tell whether formulas with definitions have the numbers as values at the point."""
    graph = Graph()
    values: dict[str, float] = dict(opened(system.scene).values)
    values |= dict(zip(system.scene.coordinates, system.point.q.tolist(), strict=True))

    def value(form: Form) -> float:
        known = {graph.symbol(name): x for name, x in values.items()}
        return float(evaluate([form.express(graph)], Floats(), known)[0])

    for name, form in reversed(exact.defined):
        values[name] = value(form)
    for matrix, known in zip(
        (exact.A, exact.B, exact.C, exact.D), (system.A, system.B, system.C, system.D), strict=True
    ):
        there = np.array([[value(x) for x in row] for row in matrix]).reshape(known.shape)
        if np.abs(there - known).max(initial=0.0) > SAME * max(1.0, float(np.abs(known).max(initial=0.0))):
            return False
    return True


def fresh(name: str, taken: set[str]) -> str:
    """Return a name that is not taken; with an underscore more for every one that is."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name


MOST_STATES, MOST_NODES, MOST_TERMS = 6, 2500, 90
"""States, nodes of the graph, and terms of an entry that are small."""

PART = math.pi / 12
"""What angles are exact multiples of."""

EXACT = 1e-11
"""How nearly an angle is one."""

FAR = 1e4
"""Angles, rad, of which doubles do not tell any more whether they are one."""


@growing()
def symbolic(prepared: Prepared, system: Linearization) -> Symbolic | None:
    """Return a system at rest in formulas, None where it is not small, or not at rest."""
    v = prepared.functions
    if system.kind != "rest" or len(system.states) > MOST_STATES or len(v.slopes.order) > MOST_NODES:
        return None
    w, n, rows = v.w, len(v.u), len(v.multipliers)
    place, held = exact(prepared, system)
    if held and v.multipliers:
        return with_definitions(prepared, system, held)
    moving = [one for one in v.u if one not in w.states or system.point.u[v.u.index(one)] == 0.0]
    place |= dict.fromkeys([*moving, *v.a, *w.state.tau, *map(w.graph.symbol, v.inputs)], w.graph.zero)
    try:
        entries, forces = substitute(entries_of(v), place), substitute(v.motion.parts["h"][1], place)
        field = Ratios([*entries, *forces])
        values = field.values()
        if v.multipliers:
            G, h = (evaluate(some, field, values) for some in (entries[: rows * n], forces))
            values |= dict(zip(v.multipliers, _multipliers(field, G, h, prepared, system), strict=True))
        blocks = blocks_of(v, evaluate(entries, field, values))
        found = assembled(field, blocks, prepared, *places(prepared, system)).without(*kept(prepared, system))
        B, C, D = found.B, found.C, found.D
        A = [
            [field.zero if number == 0 else x for x, number in zip(row, numbers, strict=True)]  # forces that cancel
            for row, numbers in zip(found.A, system.A.tolist(), strict=True)
        ]
        small = all(x.size <= MOST_TERMS for matrix in (A, B, C, D) for row in matrix for x in row)
        if not small or not _true(field, (A, B, C, D), prepared, system):
            return None
    except (ZeroDivisionError, OverflowError):
        return None
    try:
        roots = _roots(field, A)
    except OverflowError:  # entries may be short and eigenvalues long
        roots = ()
    forms = [tuple(tuple(map(field.form, row)) for row in matrix) for matrix in (A, B, C, D)]
    return Symbolic(forms[0], forms[1], forms[2], forms[3], roots, held)


def _blocks(v: Variations) -> Entries:
    """Return what `assembled` takes, rows of constraints first."""
    return {name: v.motion.parts[name] for name in "GM"} | {name: v.slopes.parts[name] for name in "ecsr"} | {
        "y_": v.outputs.parts["y_"]}  # fmt: skip


def entries_of(v: Variations) -> list[Expr]:
    """Return all entries of what `assembled` takes."""
    return [x for _, some in _blocks(v).values() for x in some]


def blocks_of(v: Variations, values: Iterable[Any]) -> dict[str, Rows]:
    """Return what `assembled` takes of the values of all entries."""
    given, shapes = iter(values), {name: shape for name, (shape, _) in _blocks(v).items()}
    return {name: [[next(given) for _ in range(m)] for _ in range(n)] for name, (n, m) in shapes.items()}


def exact(prepared: Prepared, system: Linearization) -> tuple[dict[Expr, Expr], tuple[str, ...]]:
    """Return exact values of coordinates at the point, and those that there are none of."""
    w, place, held = prepared.functions.w, dict[Expr, Expr](), []
    needed = set(reachable([x for _, some in prepared.functions.slopes.parts.values() for x in some]))
    exact = True
    for q, x, unit in zip(w.state.q, system.point.q.tolist(), SceneUnits(system.scene).coordinates, strict=True):
        parts = round(x / PART) if abs(x) < FAR else 0
        if abs(x) <= EXACT:
            place[q] = w.graph.zero
        elif unit == "rad" and abs(x - parts * PART) <= EXACT * max(1, abs(parts)):
            place[q] = w.graph.pi * Fraction(parts, 12)
        elif unit == "1" and abs(abs(x) - 1) <= EXACT:
            place[q] = w.graph.constant(round(x))
        else:
            exact = exact and q not in needed
            held.append(q)
    if exact or not system.scene.is_constrained:
        return place, tuple(str(q.value) for q in held if q in needed)
    kept = [q for q in w.state.q if q in needed]  # loops hold positions: exact ones beside others would not close
    return {}, tuple(str(q.value) for q in kept)


def _multipliers(
    field: Ratios, G: Sequence[Ratio], h: Sequence[Ratio], prepared: Prepared, system: Linearization
) -> list[Ratio]:
    """Return λ of h = Gᵀ λ, of the rows of dependent velocities."""
    n = len(h)
    rows = len(G) // n
    dependent = [k for k in range(n) if k not in places(prepared, system)[1]]
    transposed = [[G[r * n + k] for r in range(rows)] for k in dependent]
    return [x for (x,) in field.solved(transposed, [[h[k]] for k in dependent])]


Rows = list[list[Any]]


@dataclass(frozen=True)
class Blocks:
    """A linear system over a field.

    Attributes:
        A, B, C, D: as in the linearization.
        mass, side: [1 0; 0 Nᵀ M N] and what is equal to it times ẋ, by states and inputs: mass ẋ = side [x; w].
    """

    A: Rows
    B: Rows
    C: Rows
    D: Rows
    mass: Rows
    side: Rows

    def without(self, states: Sequence[int], outputs: Sequence[int]) -> Blocks:
        """Return it with some states and outputs alone."""
        A, mass = ([[rows[i][k] for k in states] for i in states] for rows in (self.A, self.mass))
        C = [[self.C[i][k] for k in states] for i in outputs]
        side = [[self.side[i][k] for k in (*states, *range(len(self.A), len(self.side[i])))] for i in states]
        return Blocks(A, [self.B[i] for i in states], C, [self.D[i] for i in outputs], mass, side)


def assembled(
    field: Ratios | Nodes,
    blocks: Mapping[str, Rows],
    prepared: Prepared,
    positions: Sequence[int],
    velocities: Sequence[int],
) -> Blocks:
    """Return what `prepared.matrices` does in numbers; all velocities are projected on the independent ones.

        u̇ = N u̇_i + b,  G b = -X c        Nᵀ M N u̇_i = -Nᵀ (X e + M b)        G_dᵀ λ = (M u̇ + X e)_d

    Blocks beside those of the linearised functions are of motions alone: "s", "ad_u", and "spin", Ω, of axes that spin.
    """
    v = prepared.functions
    n, drives, inputs, zero, one = len(v.u), prepared.drives, len(v.inputs), field.zero, field.one
    G, e, M = blocks["G"], blocks["e"], blocks["M"]
    holding = [row for row, holds in zip(G, v.holding, strict=True) if holds]
    N_h = [row[: len(positions)] for row in followed(field, holding, (*positions, *range(v.w.state.n, n)), n)]
    N, p, states = followed(field, G, velocities, n), len(positions), len(positions) + len(velocities)
    width = states + len(drives) + inputs
    dependent = [k for k in range(n) if k not in velocities]
    square = [[row[k] for k in dependent] for row in G]
    own = [[one if column == k else zero for column in range(width)] for k in range(states, width)]
    given = own[len(drives) :]

    def plus(A: Rows, B: Rows) -> Rows:
        return [[*map(field.add, *both)] for both in zip(A, B, strict=True)]

    def following(name: str, moved: Rows) -> Rows:
        """Return velocities with independent ones zero and G u = -X f of a block; zero where there are no rows."""
        found = [[zero] * width for _ in range(n)]
        if G and name in blocks:
            pushed = field.product(blocks[name], [*moved, *given])
            for k, row in zip(dependent, field.solved(square, pushed), strict=True):
                found[k] = [field.neg(x) for x in row]
        return found

    moves = [[*row, *[zero] * (width - p)] for row in N_h]
    if holding and given:
        fixed = [k for k in range(v.w.state.n) if k not in positions]
        missed = [row for row, holds in zip(blocks["r"], v.holding, strict=True) if holds]
        left = [[row[k] for k in fixed] for row in holding]
        for k, row in zip(fixed, field.solved(left, field.product(missed, given)), strict=True):
            moves[k] = [field.add(x, field.neg(y)) for x, y in zip(moves[k], row, strict=True)]
    free = [[*[zero] * p, *row, *[zero] * (width - states)] for row in N]
    moved = [*moves, *plus(following("s", moves), free)]
    driven = [own[drives.index(k)] if k in drives else [zero] * width for k in range(n)]
    acted = field.product([row[3 * n :] for row in e], given) if inputs else [[zero] * width] * n
    right = plus(field.product([row[: 2 * n] for row in e], moved), acted)
    right = plus(right, [[field.neg(x) for x in row] for row in driven])
    beside, along = following("c", moved), [list(row) for row in zip(*N, strict=True)]
    reduced = field.product(field.product(along, M), N)
    below = [[field.neg(x) for x in row] for row in field.product(along, plus(right, field.product(M, beside)))]
    independent = field.solved(reduced, below)
    a = plus(field.product(N, independent), beside)
    held, turned = plus(field.product(M, a), right), [list(row) for row in zip(*square, strict=True)]
    multipliers = field.solved(turned, [held[k] for k in dependent]) if G else []
    y = field.product(blocks["y_"], [*moved, *a, *multipliers, *driven[: v.w.state.n], *given])
    upper = moved[n:]
    if "spin" in blocks:
        spun = [field.product(blocks["spin"], rows) for rows in (moved[:n], moved[n:])]
        less = field.product(blocks["ad_u"], moved[:n])
        upper = plus(plus(upper, spun[0]), [[field.neg(x) for x in row] for row in less])
        more = [spun[1][k] for k in velocities]
        independent, below = plus(independent, more), plus(below, field.product(reduced, more))
    upper = [upper[k] for k in positions]
    mass = [[one if k == i else zero for k in range(states)] for i in range(p)]
    mass += [[*[zero] * p, *row] for row in reduced]
    (A, B), (C, D) = (
        ([row[:states] for row in rows], [row[states:] for row in rows]) for rows in ([*upper, *independent], y)
    )
    return Blocks(A, B, C, D, mass, [*upper, *below])


def followed(field: Ratios | Nodes, G: Rows, independent: Sequence[int], n: int) -> Rows:
    """Return all velocities in terms of the independent ones, shape (n, those)."""
    dependent = [k for k in range(n) if k not in independent]
    found = [[field.one if k == i else field.zero for i in independent] for k in range(n)]
    if dependent:
        left = [[row[k] for k in dependent] for row in G]
        right = [[field.neg(row[k]) for k in independent] for row in G]
        for k, row in zip(dependent, field.solved(left, right), strict=True):
            found[k] = row
    return found


def _true(field: Ratios, exact: Sequence[Rows], prepared: Prepared, system: Linearization) -> bool:
    """Tell whether formulas have the numbers as values at the point."""
    w = prepared.functions.w
    values = {w.graph.symbol(name): x for name, x in opened(system.scene).values.items()}
    values |= dict(zip(w.state.q, system.point.q.tolist(), strict=True))
    values |= dict(zip(prepared.functions.u, system.point.u.tolist(), strict=True))
    if any(node.op is Op.SYMBOL and node not in values for node in reachable(field.atoms)):
        return False  # multipliers, which no formula here tells
    numbers = dict(zip(field.atoms, evaluate(field.atoms, Floats(), values), strict=True))
    for matrix, known in zip(exact, (system.A, system.B, system.C, system.D), strict=True):
        size = max(1.0, float(np.abs(known).max(initial=0.0)))
        value: Array = np.array([[field.number_at(x, numbers) for x in row] for row in matrix]).reshape(known.shape)
        if np.abs(value - known).max(initial=0.0) > SAME * size:
            return False
    return True


def _roots(field: Ratios, A: Rows) -> tuple[Root, ...]:
    found, nothing = [], field.form(field.zero)
    for monic, times in field.factors(field.characteristic(A)):
        form, degree = [field.form(x) for x in monic], len(monic) - 1
        odd = [x for k, x in enumerate(monic) if (degree - k) % 2]
        even = degree % 2 == 0 and all(x.is_zero for x in odd)
        if degree == 1:
            first = field.form(field.neg(monic[1]))
            found.append(Root("zero" if monic[1].is_zero else "real", first, nothing, times))
        elif degree == 2:
            found.append(Root("pair" if even else "damped", form[2], form[1], times))
        elif degree == 4 and even:
            found.append(Root("coupled", form[4], form[2], times))
    return tuple(found)
