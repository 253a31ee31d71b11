"""What a linear system is in formulas of its parameters, and eigenvalues that have a closed form."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.algebra import Form, Number

SAME = 1e-7
"""How nearly formulas and numbers are the same."""

Rows = tuple[tuple[Form, ...], ...]


@dataclass(frozen=True)
class Root:
    """Eigenvalues in closed form.

    Attributes:
        kind: "zero"; "real", λ = first; "pair", ω² = first, of λ² + ω² = 0; "damped", λ² + second λ + first = 0;
            "coupled", λ⁴ + second λ² + first = 0.
        first, second: formulas.
        times: how often it is one.
    """

    kind: str
    first: Form
    second: Form
    times: int


@dataclass(frozen=True)
class Symbolic:
    """Formulas of A, B, C, D, and those of eigenvalues that have one.

    Attributes:
        A, B, C, D: as in the linearization.
        roots: eigenvalues in closed form; not all may be.
        held: coordinates that the formulas keep as symbols.
        defined: names that they use and what these stand for: of loops, how dependent velocities follow independent
            ones, and multipliers.
    """

    A: Rows
    B: Rows
    C: Rows
    D: Rows
    roots: tuple[Root, ...]
    held: tuple[str, ...]
    defined: tuple[tuple[str, Form], ...] = ()


def negated(form: Form) -> Form:
    """Return -form."""
    return Form.product((Number.MINUS_ONE, form)) if form.terms else form
