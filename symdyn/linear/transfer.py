"""Transfer functions G(s) = C (s - A)⁻¹ B + D, and which modes inputs move and outputs show.

    G_ik(s) = g Π(s - z) / Π(s - p)        on the states that input k reaches and output i shows

Zeros are where the rank of [A - s, B; C, D] falls; its infinite ones are taken out first, by compressions of rows and
columns, so that what is left is an eigenvalue problem.

What inputs reach is found by a staircase for the ranks, and the test of Popov, Belevitch and Hautus:

    V, W     orthonormal: [V W]ᵀ A [V W] = [A_v *; 0 A_w], [V W]ᵀ B = [B_v; 0]; what B reaches, and what is left
    σ(λ)     the smallest singular value of [A_v - λ, B_v]: how far the mode of λ is from one that no input moves

States have different units: A is balanced, D⁻¹ A D, and B and C are scaled to the size of A, before sizes are compared.
Of observability all is the same with Aᵀ and Cᵀ.

References: Emami-Naeini and Van Dooren, Computation of zeros of linear multivariable systems, Automatica 18 (1982); Van
Dooren, The generalized eigenstructure problem in linear system theory, IEEE Trans. Aut. Control 26 (1981); Eising,
Between controllable and uncontrollable, Systems & Control Letters 4 (1984), for σ.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.frozen import dataclass
from symdyn.linear.modes import NOTHING, Complexes, balance, pairs_of, spectrum
from symdyn.linear.plots import Answer, Transfers
from symdyn.rounding import in_digits
from symdyn.table import Table

if TYPE_CHECKING:
    from symdyn.linear.state_space import StateSpace

SAID, NAMED = 0.1, 4
"""Parts of a mode, of the largest, that are named, and how many at most."""


@dataclass(frozen=True)
class Mark:
    """How far the mode of an eigenvalue is from being hidden."""

    value: complex  # eigenvalue, 1/s
    margin: float  # σ(λ) over the size of A, on what is reached; 0 of a mode that is hidden
    states: tuple[str, ...]  # names of the states that take part most in what no input moves, or no output shows

    @property
    def hidden(self) -> bool:
        """Whether no input moves it, or no output shows it."""
        return self.margin == 0.0


@dataclass(frozen=True)
class Reach(Answer):
    """What all inputs together move, or all outputs together show.

    Attributes:
        name: "controllability" or "observability".
        rank: of how many states.
        order: how many states there are.
        marks: one an eigenvalue, those that are zero as one, nearest to hidden first.
    """

    name: str
    rank: int
    order: int
    marks: tuple[Mark, ...]

    def __repr__(self) -> str:
        lost = "".join(f"\n    hidden: mode {shown(one.value)} 1/s of {', '.join(one.states)}" for one in self.hidden)
        return f"<{self.name.capitalize()}: rank {self.rank} of {self.order}, margin {in_digits(self.margin, 2)}{lost}>"

    def tables(self) -> list[Table[str | float]]:
        """Return the modes, the one that is nearest to hidden first."""
        rows = [(shown(one.value), one.margin, ", ".join(one.states)) for one in self.marks]
        return [Table(("mode, 1/s", "margin", "states"), rows, (1,))]

    @property
    def margin(self) -> float:
        """How far the rank is from being less: the least margin of what is not hidden; 0 of a rank of zero."""
        return min((one.margin for one in self.marks if not one.hidden), default=0.0)

    @property
    def hidden(self) -> tuple[Mark, ...]:
        """Modes that no input moves, or no output shows."""
        return tuple(one for one in self.marks if one.hidden)

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON."""
        marks = [
            {"eigenvalue": pairs_of([m.value])[0], "margin": m.margin, "hidden": m.hidden, "states": list(m.states)}
            for m in self.marks
        ]
        return {"rank": self.rank, "order": self.order, "margin": self.margin, "modes": marks}


def reach(name: str, A: Array, B: Array, names: tuple[str, ...]) -> Reach:
    """Return what B moves of balanced states."""
    size, B = float(np.linalg.norm(A, 2)) or 1.0, alike(A, B)
    V, W = staircase(A, B)
    marks = [Mark(value, 0.0, states) for value, _, states in _least(A, B[:, :0], W, names, size)]
    marks += [Mark(*one) for one in _least(A, B, V, names, size)]
    return Reach(name, V.shape[1], len(A), tuple(sorted(marks, key=lambda mark: mark.margin)))


def _least(
    A: Array, B: Array, space: Array, names: tuple[str, ...], size: float
) -> list[tuple[complex, float, tuple[str, ...]]]:
    """Return the eigenvalues in a space, σ of [A - λ, B] there over the size of A, and who takes part in it most."""
    part, way = space.T @ A @ space, space.T @ B
    found = spectrum(part, size)
    told = []
    for value in [*(mode.value for mode in found.modes), *([0j] if found.zeros else [])]:
        rows, sizes, _ = np.linalg.svd(np.hstack([part - value * np.eye(len(part)), way]))
        many = max(1, int(np.sum(sizes <= NOTHING * size)))
        share = np.linalg.norm(space @ rows[:, -many:], axis=1)
        most = [k for k in np.argsort(-share, kind="stable") if share[k] > SAID * share.max()]
        told.append((value, float(sizes[-1]) / size, tuple(names[k] for k in most[:NAMED])))
    return told


def balanced(one: StateSpace) -> tuple[Array, Array, Array, Array]:
    """Return D⁻¹ A D, D⁻¹ B, C D and the diagonal of D."""
    scale = balance(one.A)
    return one.A * scale[None, :] / scale[:, None], one.B / scale[:, None], one.C * scale[None, :], scale


def alike(A: Array, B: Array) -> Array:
    """Return B with columns as long as A is large, those that are zero left out of it."""
    lengths = np.linalg.norm(B, axis=0)
    return np.asarray(B * ((float(np.linalg.norm(A, 2)) or 1.0) / np.where(lengths > 0, lengths, 1.0)))


def staircase(A: Array, B: Array) -> tuple[Array, Array]:
    """Return V, shape (n, rank), and W: what B reaches of balanced states, and what is beside it."""
    size = float(np.linalg.norm(A, 2)) or 1.0
    n, V, step = len(A), np.zeros((len(A), 0)), alike(A, B)
    while V.shape[1] < n and step.shape[1]:
        step = step - V @ (V.T @ step)
        rows, sizes, _ = np.linalg.svd(step, full_matrices=False)
        fresh = rows[:, sizes > NOTHING * size]
        fresh = fresh - V @ (V.T @ fresh)
        fresh = np.linalg.qr(fresh)[0] if fresh.shape[1] else fresh
        V, step = np.hstack([V, fresh]), A @ fresh
    W = np.linalg.svd(V, full_matrices=True)[0][:, V.shape[1] :] if V.shape[1] else np.eye(n)
    return V, W


def minimal(A: Array, B: Array, C: Array) -> tuple[Array, Array, Array]:
    """Return A, B, C on the states that B reaches and C shows; all of balanced states."""
    V, _ = staircase(A, B)
    A, B, C = V.T @ A @ V, V.T @ B, C @ V
    V, _ = staircase(A.T, C.T)
    return V.T @ A @ V, V.T @ B, C @ V


def shown(value: complex) -> str:
    """Return an eigenvalue, pole or zero as text: a pair once."""
    x, y = float(value.real), float(value.imag)
    if y == 0:
        return in_digits(x, 6)
    return f"{in_digits(x, 6)} ± {in_digits(abs(y), 6)}i" if abs(x) > NOTHING * abs(y) else f"±{in_digits(abs(y), 6)}i"


def named(space: Array | Complexes, names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the states that take part in a space of balanced states."""
    share = np.linalg.norm(space / np.linalg.norm(space, axis=0), axis=1)
    return tuple(name for name, x in zip(names, share, strict=True) if x > SAID * share.max(initial=0.0))


def poles_in_words(values: Iterable[complex]) -> str:
    """Return poles or zeros as text, pairs once."""
    return ", ".join(shown(value) for value in values if value.imag >= 0) or "none"


@dataclass(frozen=True, eq=False)
class Transfer(Answer):
    """How one output follows one input, in s, or in z of a sampled system.

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

    def __repr__(self) -> str:
        what = f"zeros: {poles_in_words(self.zeros)}; poles: {poles_in_words(self.poles)}"
        return f"<Transfer {self.output} / {self.input}: gain {in_digits(self.gain, 6)}; {what}>"

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

    __call__ = at  # type: ignore[assignment]

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "output": self.output, "input": self.input, "gain": self.gain, "zeros": pairs_of(self.zeros),
            "poles": pairs_of(self.poles), "numerator": self.numerator.tolist(),
            "denominator": self.denominator.tolist(),
        }  # fmt: skip


def transfers(one: StateSpace) -> Transfers:
    """Return all transfer functions, output by output."""
    return Transfers(_transfer(one[output, name]) for output in one.outputs.names for name in one.inputs.names)


def _transfer(one: StateSpace) -> Transfer:
    size, own = float(np.linalg.norm(balanced(one)[0], 2)), one.minimal
    found = invariant_zeros(own.A, own.B, own.C, own.D, size)
    gain, markov = float(own.D[0, 0]), own.B
    for _ in range(len(own.A) - len(found)):
        gain, markov = float((own.C @ markov)[0, 0]), own.A @ markov
    return Transfer(one.outputs.names[0], one.inputs.names[0], found, spectrum(own.A, size).values, gain)


def invariant_zeros(A: Array, B: Array, C: Array, D: Array, size: float) -> Complexes:
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
    return spectrum(np.linalg.solve(turn[: len(a)], np.hstack([a, b]) @ turn), size).values


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
