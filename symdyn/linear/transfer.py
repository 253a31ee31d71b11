"""Transfer functions G(s) = C (s - A)⁻¹ B + D, one an input and output, cancelled; poles, zeros and gains.

    G_ik(s) = g Π(s - z) / Π(s - p)        on the states that input k reaches and output i shows

Zeros are where the rank of [A - s, B; C, D] falls; its infinite ones are taken out first, by compressions of rows and
columns, so that what is left is an eigenvalue problem.

Reference: Emami-Naeini and Van Dooren, Computation of zeros of linear multivariable systems, Automatica 18 (1982).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.linear.modes import Complexes, pairs_of, spectrum
from symdyn.linear.reach import balanced, minimal

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization


NOTHING = 1e-9
"""Singular values over the largest of the balanced system that are zero."""


@dataclass(frozen=True)
class Transfer:
    """How one output follows one input.

    Attributes:
        output, input: their names.
        zeros, poles: 1/s, pairs in full; poles of modes that the input does not move or the output not show are none.
        gain: g, the ratio of the leading coefficients; 0 where the output does not follow at all.
    """

    output: str
    input: str
    zeros: Complexes
    poles: Complexes
    gain: float

    @property
    def numerator(self) -> Array:
        """Coefficients, highest power of s first."""
        return self.gain * np.atleast_1d(np.real(np.poly(self.zeros)))

    @property
    def denominator(self) -> Array:
        """Coefficients, highest power of s first, which has 1."""
        return np.atleast_1d(np.real(np.poly(self.poles)))

    def at(self, s: complex) -> complex:
        """Return G(s)."""
        return complex(self.gain * np.prod(s - self.zeros) / np.prod(s - self.poles))

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "output": self.output, "input": self.input, "gain": self.gain, "zeros": pairs_of(self.zeros),
            "poles": pairs_of(self.poles), "numerator": self.numerator.tolist(),
            "denominator": self.denominator.tolist(),
        }  # fmt: skip


def transfers(one: Linearization) -> tuple[Transfer, ...]:
    """Return all transfer functions, output by output."""
    A, B, C, _ = balanced(one)
    return tuple(
        _transfer(output, name, A, B[:, [k]], C[[i]], one.D[[i]][:, [k]])
        for i, output in enumerate(one.outputs.names)
        for k, name in enumerate(one.inputs.names)
    )


def _transfer(output: str, name: str, A: Array, b: Array, c: Array, d: Array) -> Transfer:
    size = float(np.linalg.norm(A, 2))
    A, b, c = minimal(A, b, c)
    found = zeros(A, b, c, d, size)
    gain, markov = float(d[0, 0]), b
    for _ in range(len(A) - len(found)):
        gain, markov = float((c @ markov)[0, 0]), A @ markov
    return Transfer(output, name, found, eigenvalues(A, size), gain)


def eigenvalues(A: Array, size: float) -> Complexes:
    """Return all eigenvalues of a matrix, pairs in full, those that grow first; zero beside `size` is zero."""
    found = spectrum(A, size)
    values: list[complex] = []
    for mode in found.modes:
        values += [mode.value, mode.value.conjugate()] if mode.oscillates else [mode.value]
    return np.array([*values, *[0j] * found.zeros], dtype=np.complex128)


def zeros(A: Array, B: Array, C: Array, D: Array, size: float) -> Complexes:
    """Return the invariant zeros of a system of balanced states, 1/s: where inputs move states and outputs rest.

    Of several inputs and outputs those of all together; none where the outputs can follow everything. `size` is that of
    a whole of which the system is a part.
    """
    unit = size or 1.0
    ins, outs = (unit / (float(np.linalg.norm(one, 2)) if one.any() else unit) for one in (B, C))
    a, b, c, d = _compressed(A, B * ins, C * outs, D * (ins * outs), NOTHING * unit)
    a, c, b, d = (one.T for one in _compressed(a.T, c.T, b.T, d.T, NOTHING * unit))
    if not len(a):
        return np.zeros(0, dtype=np.complex128)
    turn = np.linalg.svd(np.hstack([c, d]))[2][len(c) :].T if len(c) else np.eye(len(a))
    return eigenvalues(np.linalg.solve(turn[: len(a)], np.hstack([a, b]) @ turn), size)


def _compressed(A: Array, B: Array, C: Array, D: Array, nothing: float) -> tuple[Array, Array, Array, Array]:
    """Return a system with the same finite zeros, whose D has full row rank."""
    while True:
        rows, sizes, _ = np.linalg.svd(D) if D.size else (np.eye(len(D)), np.zeros(0), None)
        rank = int(np.sum(sizes > nothing))
        through, lower = (rows.T @ D)[:rank], rows.T @ C
        upper, rest = lower[:rank], lower[rank:]
        if not len(rest) or not len(A):
            return A, B, upper, through
        _, sizes, across = np.linalg.svd(rest)
        seen = int(np.sum(sizes > nothing))
        if not seen:
            return A, B, upper, through
        turn = np.vstack([across[seen:], across[:seen]]).T
        A, B, upper = turn.T @ A @ turn, turn.T @ B, upper @ turn
        keep = len(A) - seen
        C, D = np.vstack([upper[:, :keep], A[keep:, :keep]]), np.vstack([through, B[keep:]])
        A, B = A[:keep, :keep], B[:keep]
