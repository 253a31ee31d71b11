"""A closed mechanism with one freedom at rest in formulas: mass, stiffness and damping have names of their own."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from symdyn.algebra import Floats, Form, Number, Symbol, with_added_angles
from symdyn.dynamics import formulas
from symdyn.dynamics.outputs import COLUMNS
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, evaluate, substitute
from symdyn.linear.formulas import SAME, Root, Symbolic, negated
from symdyn.linear.linearization import Linearization
from symdyn.linear.prepared import Prepared
from symdyn.rounding import digits_or
from symdyn.simulation import opened

MOST_ROWS = 3
"""Rows of loops in symbols that are small."""

DIGITS = 12
"""Digits of numbers that have no exact form."""


def places(prepared: Prepared, system: Linearization) -> tuple[list[int], list[int]]:
    """Return independent positions and velocities by number of the velocity."""
    labels, names, p = COLUMNS["q"](prepared.functions.w), system.scene.velocities, system.positions
    return [labels.index(x) for x in system.states.names[:p]], [names.index(x) for x in system.states.names[p:]]


def with_definitions(prepared: Prepared, system: Linearization, held: tuple[str, ...]) -> Symbolic | None:
    """Return a closed mechanism with one freedom in its coordinates: mass, stiffness, damping and all else named.

    m δü + d δu + k δξ = Nᵀ δτ        N  how all velocities follow the independent one, N_h the same at rest
    m = Nᵀ M N,  k = Nᵀ (X e) N,  d = Nᵀ (∂e/∂u) N, with λ of h = Gᵀ λ in X e
    """
    v = prepared.functions
    w, n, graph = v.w, v.w.state.n, v.w.graph
    positions, velocities = places(prepared, system)
    rows = len(v.multipliers)
    if positions != velocities or len(positions) != 1 or v.inputs or rows > MOST_ROWS or rows != n - 1:
        return None
    free = positions[0]
    name, labels = system.states.names[0], COLUMNS["q"](w)
    taken = {*system.scene.coordinates, *system.scene.velocities, *(one.name for one in system.scene.parameters)}
    dependent = [k for k in range(n) if k != free]
    slopes = {k: graph.symbol(_fresh(f"{labels[k]}_{name}", taken)) for k in dependent}
    pulls = [graph.symbol(_fresh(f"lambda{r + 1}", taken)) for r in range(rows)]
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
    letters = [Symbol(_fresh(f"{letter}_{name}", taken)) for letter in "mkd"]
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
    """Return the determinant of a small matrix by its first row."""
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


def _fresh(name: str, taken: set[str]) -> str:
    """Return a name that is not taken; with an underscore more for every one that is."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name
